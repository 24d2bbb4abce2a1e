//! Many recordings over an engine: the run as its client has it, and an item as a worker has it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use gravical::apply::apply;
use gravical::cohort::{
    AnyValues, ApplyValues, Beginning, CalibrationValues, CheckValues, Columns, Item, Journal,
    List, NoiseValues, Origin, Outcome as Measured, Row, Status, Task, TaskWork, Work, ending_of,
    journal_name, named, sha256_of,
};
use gravical::output::{make_folder, write_atomic};
use gravical::recording::open;
use gravical::{Error, Result};
use pyo3::exceptions::{PyIndexError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use serde::Serialize;

use crate::calibration::Calibration;
use crate::error::OrRaise;
use crate::options::Options;
use crate::outcome::{Kind, Outcome};
use crate::recording::json;
use crate::task;

/// A run: its items, and its journal.
#[pyclass(frozen, module = "gravical._gravical")]
pub struct CohortRun {
    folder: PathBuf,
    origin: Origin,
    items: Vec<Item>,
    journal: std::sync::Mutex<Option<Journal>>,
    force: bool,
}

#[pymethods]
impl CohortRun {
    /// Of `command` over `paths`; `words` are its options as the program names them, `files` belong to
    /// the options.
    #[new]
    fn new(
        py: Python<'_>,
        command: &str,
        paths: Vec<PathBuf>,
        folder: PathBuf,
        words: Vec<String>,
        files: Vec<PathBuf>,
        force: bool,
    ) -> PyResult<Self> {
        let begin = || -> Result<Self> {
            let hashes = files.iter().map(|path| {
                let sha256 = sha256_of(path)?;
                Ok((path.display().to_string(), sha256))
            });
            let origin = Origin::new(command, &words, hashes.collect::<Result<BTreeMap<_, _>>>()?);
            make_folder(&folder)?;
            let (items, _) = named(paths, ending_of(command));
            let beginning = Beginning {
                origin: origin.clone(),
                shard: None,
                list: List::of(&items),
                items: &items,
            };
            let path = folder.join(journal_name(command, None));
            let journal = Journal::open(&path, &beginning, !force, force)?;
            Ok(CohortRun {
                folder,
                origin,
                items,
                journal: std::sync::Mutex::new(Some(journal)),
                force,
            })
        };
        py.detach(begin).or_raise(py)
    }

    fn __len__(&self) -> usize {
        self.items.len()
    }

    /// The task of an item, as JSON.
    fn task(&self, py: Python<'_>, index: usize) -> PyResult<String> {
        let item = self.item(index)?.clone();
        let result = item.file.as_ref().map(|file| self.folder.join(file));
        let replaces =
            self.with(|journal| result.is_some_and(|result| journal.is_own(&item, None, &result)));
        let task = Task {
            folder: self.folder.clone(),
            origin: self.origin.clone(),
            replaces: replaces.unwrap_or(false),
            anew: self.force,
            item,
        };
        let text = serde_json::to_string(&task).map_err(|e| {
            Error::usage(
                "each-input",
                format!("an engine cannot take this path: {e}"),
            )
            .at(&task.item.path, None)
            .with_hint("rename it: only UTF-8 can be sent to another machine")
        });
        text.or_raise(py)
    }

    /// Notes the row of an item.
    fn take(&self, py: Python<'_>, index: usize, row: &str) -> PyResult<()> {
        let row: Row<AnyValues> =
            serde_json::from_str(row).map_err(|e| PyValueError::new_err(format!("no row: {e}")))?;
        self.end(py, self.item(index)?, &row)
    }

    /// Notes that an item has no result; its row.
    fn failed(
        &self,
        py: Python<'_>,
        index: usize,
        code: &str,
        message: &str,
        hint: Option<&str>,
    ) -> PyResult<String> {
        let item = self.item(index)?;
        let mut row = Row::<AnyValues>::of(&item.name, Status::Error);
        row.path = item.path.display().to_string();
        row.failed(code, message, hint);
        self.end(py, item, &row)?;
        json(&row)
    }

    /// Ends the run: another one may begin.
    fn close(&self) {
        let mut journal = self.journal.lock();
        if let Ok(journal) = &mut journal {
            journal.take();
        }
    }
}

impl CohortRun {
    fn item(&self, index: usize) -> PyResult<&Item> {
        let item = self.items.get(index);
        item.ok_or_else(|| PyIndexError::new_err(index))
    }

    /// None once the run has ended.
    fn with<T>(&self, act: impl FnOnce(&Journal) -> T) -> Option<T> {
        self.journal.lock().ok()?.as_ref().map(act)
    }

    fn end(&self, py: Python<'_>, item: &Item, row: &Row<AnyValues>) -> PyResult<()> {
        let result = item.file.as_ref().map(|file| self.folder.join(file));
        let own = result.filter(|_| row.status != Status::Error);
        let ended = py.detach(|| self.with(|journal| journal.end(item, own.as_deref(), row)));
        match ended {
            Some(ended) => ended.or_raise(py),
            None => Err(PyRuntimeError::new_err("the run has ended")),
        }
    }
}

/// An item that is worked on, or the row it has already.
#[pyclass(frozen, module = "gravical._gravical")]
pub struct CohortItem {
    begun: TaskWork<AnyValues>,
}

#[pymethods]
impl CohortItem {
    /// Begins the task of [`CohortRun::task`].
    #[staticmethod]
    fn begin(py: Python<'_>, task: &str) -> PyResult<Self> {
        let task: Task = serde_json::from_str(task)
            .map_err(|e| PyValueError::new_err(format!("no task: {e}")))?;
        let begun = py.detach(|| task.begin()).or_raise(py)?;
        Ok(CohortItem { begun })
    }

    /// The row, if nothing is left to be done.
    #[getter]
    fn row(&self) -> PyResult<Option<String>> {
        match &self.begun {
            TaskWork::Over(row) => json(row).map(Some),
            TaskWork::Open(_) => Ok(None),
        }
    }

    /// The row of a calibration, which is written.
    fn calibrated(&self, py: Python<'_>, calibration: &Bound<'_, Calibration>) -> PyResult<String> {
        let (work, file) = (self.work()?, calibration.get().file.clone());
        finish(
            py,
            work,
            Measured::<CalibrationValues>::from(&*file),
            |path| file.write(path, work.may_replace()),
        )
    }

    /// The row of a check or of noise, which is written.
    fn found(&self, py: Python<'_>, outcome: &Bound<'_, Outcome>) -> PyResult<String> {
        let work = self.work()?;
        match &outcome.get().kind {
            Kind::Check(report) => {
                finish(py, work, Measured::<CheckValues>::from(&**report), |_| {
                    Ok(())
                })
            }
            Kind::Noise(result) => {
                finish(py, work, Measured::<NoiseValues>::from(&**result), |path| {
                    write_json(path, work.may_replace(), &**result)
                })
            }
            _ => Err(PyValueError::new_err("a result without a row")),
        }
    }

    /// Applies a calibration; the row.
    fn applied(
        this: &Bound<'_, Self>,
        py: Python<'_>,
        calibration: &Bound<'_, Calibration>,
        path: PathBuf,
        options: Options<'_>,
    ) -> PyResult<String> {
        let (wanted, meter) = options.apply()?;
        let file = calibration.get().file.clone();
        let own = this.clone().unbind();
        let measured = task::run(py, &meter, move || {
            let TaskWork::Open(work) = &own.get().begun else {
                return Ok(None);
            };
            let Some(result) = work.result() else {
                return Ok(None);
            };
            let mut measured = None;
            write_atomic(result, work.may_replace(), |out| {
                let input = open::open(&path, &wanted.read)?;
                let name = path.display().to_string();
                let summary = apply(&file, input, &name, out, &wanted)?;
                measured = Some(Measured::<ApplyValues>::from(&summary));
                // Published only if this returns.
                work.check_unchanged()
            })?;
            Ok(measured)
        })?;
        let measured = measured.ok_or_else(|| PyRuntimeError::new_err("nothing was written"))?;
        let work = this.get().work()?;
        json(&py.detach(|| work.done(measured)))
    }

    /// The row of an error.
    fn failed(
        &self,
        py: Python<'_>,
        code: &str,
        message: &str,
        hint: Option<&str>,
    ) -> PyResult<String> {
        let work = self.work()?;
        let row = py.detach(|| work.failed::<AnyValues>(code, message, hint));
        json(&row)
    }
}

impl CohortItem {
    fn work(&self) -> PyResult<&Work> {
        match &self.begun {
            TaskWork::Open(work) => Ok(work),
            TaskWork::Over(_) => Err(PyRuntimeError::new_err("it is done already")),
        }
    }
}

fn finish<V: Columns + Sync>(
    py: Python<'_>,
    work: &Work,
    measured: Measured<V>,
    write: impl Fn(&Path) -> Result<()> + Send + Sync,
) -> PyResult<String> {
    let done = py.detach(|| -> Result<Row<V>> {
        work.check_unchanged()?;
        if let Some(result) = work.result() {
            write(result)?;
        }
        Ok(work.done(measured))
    });
    json(&done.or_raise(py)?)
}

fn write_json(path: &Path, force: bool, value: &impl Serialize) -> Result<()> {
    write_atomic(path, force, |out| {
        serde_json::to_writer_pretty(&mut *out, value).map_err(|e| Error::io(path, e.into()))?;
        out.write_all(b"\n").map_err(|e| Error::io(path, e))
    })
}
