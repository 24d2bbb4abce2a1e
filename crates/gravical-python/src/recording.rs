//! Recordings, and arrays that share their memory.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use gravical::Result;
use gravical::output;
use gravical::recording::{self, Meter, ReadOptions, TableColumn, join_gyroscope};
use numpy::ndarray::ArrayView1;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::{PyKeyError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::Deserialize;

use crate::error::OrRaise;
use crate::keywords::Keywords;
use crate::task;

/// A recording in columns; its arrays are views of them.
#[pyclass(frozen, module = "gravical._gravical")]
pub struct Recording {
    /// Shared with what is computed from it.
    pub shared: Arc<recording::Recording>,
}

impl Recording {
    /// Of rows that are shared.
    pub fn of(shared: Arc<recording::Recording>) -> Self {
        Recording { shared }
    }
}

/// A read-only array over `values`, which belong to `owner` and live as long as it does.
#[allow(unsafe_code)]
pub fn view<'py>(values: &[f64], owner: Bound<'py, PyAny>) -> Bound<'py, PyArray1<f64>> {
    let view = ArrayView1::from(values);
    // SAFETY: the owner is a frozen class that holds the values behind an `Arc` and never changes
    // them; the array keeps the owner alive.
    let array = unsafe { PyArray1::borrow_from_array(&view, owner) };
    array.readwrite().make_nonwriteable();
    array
}

/// A column of a table, held by Python.
enum Held<'py> {
    Numbers(PyReadonlyArray1<'py, f64>),
    Texts(Vec<String>),
}

fn held<'py>(columns: &[Bound<'py, PyAny>]) -> PyResult<Vec<Held<'py>>> {
    let one = |column: &Bound<'py, PyAny>| match column.extract() {
        Ok(numbers) => Ok(Held::Numbers(numbers)),
        Err(_) => column.extract().map(Held::Texts),
    };
    columns.iter().map(one).collect()
}

fn table<'a>(held: &'a [Held<'_>]) -> PyResult<Vec<TableColumn<'a>>> {
    let one = |column: &'a Held<'_>| match column {
        Held::Numbers(numbers) => Ok(TableColumn::Numbers(numbers.as_slice()?)),
        Held::Texts(texts) => Ok(TableColumn::Texts(texts)),
    };
    held.iter().map(one).collect()
}

/// The JSON of the program.
pub fn json(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|e| PyRuntimeError::new_err(e.to_string()))
}

/// A recording, or what it is made of.
#[derive(FromPyObject)]
pub enum Source<'py> {
    /// In memory.
    Recording(Bound<'py, Recording>),
    /// Name, and the content of a file.
    Bytes(String, Vec<u8>),
    /// Name, names of columns, and columns: arrays of float64 without gaps, or lists of texts.
    Table(String, Vec<String>, Vec<Bound<'py, PyAny>>),
    /// A file under the name of its pose.
    Named(String, PathBuf),
    /// A file.
    Path(PathBuf),
}

/// The gyroscope of a recording in a second file.
#[derive(Default, Deserialize)]
#[serde(default)]
pub struct GyroFile {
    /// Its path.
    pub gyro: Option<PathBuf>,
}

impl<'py> Source<'py> {
    /// The rows: read by the keywords of reading, which a recording in memory does not take.
    /// `own`: the other options of the call.
    pub fn open<T>(
        self,
        py: Python<'py>,
        keywords: Keywords,
        meter: &Meter,
        own: impl FnOnce(&mut Keywords) -> Result<T>,
    ) -> PyResult<(Arc<recording::Recording>, T)> {
        if let Source::Recording(recording) = self {
            let own = keywords.read(py, own)?;
            return Ok((recording.get().shared.clone(), own));
        }
        let of_file = matches!(self, Source::Path(_) | Source::Named(..));
        let (read, gyro, own) = keywords.read(py, |k| {
            let gyro = if of_file {
                k.take::<GyroFile>()?.gyro
            } else {
                None
            };
            Ok((k.reading(meter)?, gyro, own(k)?))
        })?;
        Ok((self.read(py, read, gyro, meter)?, own))
    }

    /// The rows, read by options that are known.
    pub fn read(
        self,
        py: Python<'py>,
        read: ReadOptions,
        gyro: Option<PathBuf>,
        meter: &Meter,
    ) -> PyResult<Arc<recording::Recording>> {
        let rows = match self {
            Source::Recording(recording) => return Ok(recording.get().shared.clone()),
            Source::Bytes(name, bytes) => task::run(py, meter, move || {
                recording::read_bytes(&bytes, &name, &read)
            })?,
            Source::Table(name, names, columns) => {
                let held = held(&columns)?;
                let columns = table(&held)?;
                let made =
                    py.detach(|| recording::Recording::from_table(&name, &names, &columns, &read));
                made.or_raise(py)?
            }
            Source::Named(name, path) => {
                let rows = task::run(py, meter, move || read_file(&path, gyro.as_deref(), &read))?;
                renamed(rows, name)
            }
            Source::Path(path) => {
                task::run(py, meter, move || read_file(&path, gyro.as_deref(), &read))?
            }
        };
        Ok(Arc::new(rows))
    }
}

fn renamed(mut rows: recording::Recording, name: String) -> recording::Recording {
    for finding in &mut rows.findings {
        finding.file = Some(name.clone());
    }
    rows.name = name;
    rows
}

/// A file, with the gyroscope of a second one.
pub fn read_file(
    path: &Path,
    gyro: Option<&Path>,
    read: &ReadOptions,
) -> Result<recording::Recording> {
    let Some(gyro) = gyro else {
        return recording::read(path, read);
    };
    let mut recording = recording::read(path, &read.beside_gyroscope_file())?;
    join_gyroscope(&mut recording, gyro, read)?;
    Ok(recording)
}

#[pymethods]
impl Recording {
    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        let made = rmp_serde::from_slice::<recording::Recording>(bytes);
        made.map(|rows| Self::of(Arc::new(rows)))
            .map_err(|e| PyRuntimeError::new_err(format!("not a pickled recording: {e}")))
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| rmp_serde::to_vec_named(&*self.shared));
        let bytes = bytes.map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The same columns under another name.
    fn named(&self, name: String) -> Self {
        Self::of(Arc::new(renamed((*self.shared).clone(), name)))
    }

    /// What is known of it, as JSON.
    fn facts(&self) -> PyResult<String> {
        let r = &*self.shared;
        json(&serde_json::json!({
            "name": r.name,
            "description": r.description,
            "rows": r.rows(),
            "column_names": r.column_names,
            "accel_unit": r.accel_scale.unit.name(),
            "gyro_unit": r.gyro_scale.map(|scale| scale.unit.name()),
            "zero_offset": r.zero_offset,
            "breaks": r.breaks,
            "rate_hz": r.timing.rate_hz(),
            "recorded": r.recorded_at().map(|time| time.to_string()),
            "findings": r.findings,
        }))
    }

    /// Names of the channels that there are.
    fn channels(&self) -> Vec<&'static str> {
        let r = &*self.shared;
        let time = r.time_s.iter().map(|_| "t");
        let gyro = r.gyro.iter().flat_map(|_| ["gx", "gy", "gz"]);
        let temperature = r.temperature_c.iter().map(|_| "temperature");
        let all = time.chain(["ax", "ay", "az"]).chain(gyro);
        all.chain(temperature).collect()
    }

    /// A read-only view of a channel.
    fn channel<'py>(this: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let r = &this.get().shared;
        let gyro = |i: usize| r.gyro.as_ref().map(|g| &g[i][..]);
        let values = match name {
            "t" => r.time_s.as_deref(),
            "ax" => Some(&r.accel[0][..]),
            "ay" => Some(&r.accel[1][..]),
            "az" => Some(&r.accel[2][..]),
            "gx" => gyro(0),
            "gy" => gyro(1),
            "gz" => gyro(2),
            "temperature" => r.temperature_c.as_deref(),
            _ => None,
        };
        match values {
            Some(values) => Ok(view(values, this.clone().into_any())),
            None => Err(PyKeyError::new_err(name.to_owned())),
        }
    }

    /// Different labels, and for every row the index of its own.
    fn labels(&self) -> Option<(Vec<String>, Vec<u32>)> {
        let labels = self.shared.labels.as_ref()?;
        Some((labels.names.clone(), labels.of_row.clone()))
    }
}

/// Reads a recording.
#[pyfunction]
pub fn read(py: Python<'_>, source: Source<'_>, keywords: Keywords) -> PyResult<Recording> {
    let (shared, ()) = source.open(py, keywords, &Meter::default(), |_| Ok(()))?;
    Ok(Recording::of(shared))
}

/// Writes a text, atomically; nothing is overwritten without `force`.
#[pyfunction]
pub fn write_text(py: Python<'_>, path: PathBuf, text: &str, force: bool) -> PyResult<()> {
    py.detach(|| output::write_text(&path, force, text))
        .or_raise(py)
}
