//! Results: as JSON, as a report, as figures, as arrays.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use gravical::calibration_file::{Calibration, InputFile, creation_time};
use gravical::export::{ExportOptions, TARGETS, Target, export, export_noise};
use gravical::motion::{Motion, MotionTable, OrientationResult};
use gravical::output::{self, write_atomic};
use gravical::recording;
use gravical::targets::check_targets;
use gravical::{Error, Result, TOOL};
use gravical_report::document::{Detail, Document};
use gravical_report::figure::{self, Figure};
use gravical_report::report;
use numpy::PyArray1;
use pyo3::prelude::*;
use serde::Serialize;

use crate::error::raised;
use crate::keywords::Keywords;
use crate::recording::{Recording, view};

/// The recordings of a calibration, and their poses.
type Session = Box<(Vec<recording::Recording>, gravical::poses::Segmentation)>;

/// A document with these figures.
type DocumentOf = Box<dyn for<'a> Fn(&'a [Figure]) -> Document<'a> + Send + Sync>;

/// What was found, and what its figures need.
pub enum Kind {
    /// Of `calibrate`, with its session if it was computed here.
    Calibration(Arc<Calibration>, Option<Session>),
    /// Of `noise`.
    Noise(Arc<gravical::noise::NoiseResult>),
    /// Of `motion`, with its recording.
    Motion(Arc<Motion>, Arc<recording::Recording>),
    /// Of `orient`, with its recording, and whether its table has accelerations.
    Orientation(
        Arc<Motion>,
        Arc<OrientationResult>,
        Arc<recording::Recording>,
        bool,
    ),
    /// The report of any other verb, of its figures.
    Plain(DocumentOf, Box<dyn Fn() -> Vec<Figure> + Send + Sync>),
}

/// A result and its files.
#[pyclass(frozen, module = "gravical._gravical")]
pub struct Outcome {
    kind: Kind,
    /// The document of the program.
    #[pyo3(get)]
    json: String,
    inputs: Vec<InputFile>,
    /// The calibrated channels, or the rows of a motion.
    pub table: Option<Table>,
    /// What was filtered.
    pub filtered: Option<Arc<recording::Recording>>,
}

/// The JSON of the program.
pub fn json(value: &impl Serialize) -> Result<String> {
    serde_json::to_string(value).map_err(|e| Error::io(Path::new("the result"), e.into()))
}

impl Outcome {
    /// A result of these files.
    pub fn new(kind: Kind, result: &impl Serialize, inputs: Vec<InputFile>) -> Result<Self> {
        Ok(Outcome {
            kind,
            json: json(result)?,
            inputs,
            table: None,
            filtered: None,
        })
    }

    /// A calibration.
    pub fn calibration(file: Calibration, session: Option<Session>) -> Result<Self> {
        let (inputs, file) = (file.inputs.clone(), Arc::new(file));
        Self::new(Kind::Calibration(file.clone(), session), &*file, inputs)
    }

    /// The calibration that this is.
    pub fn file(&self) -> Result<Arc<Calibration>> {
        match &self.kind {
            Kind::Calibration(file, _) => Ok(file.clone()),
            _ => Err(Error::usage("usage", "this is not a calibration")),
        }
    }

    fn draw_figures(&self) -> Vec<Figure> {
        match &self.kind {
            Kind::Calibration(file, session) => {
                let session = session.as_ref().map(|s| (&s.0[..], &s.1));
                figure::calibration::figures(file, session)
            }
            Kind::Noise(result) => figure::noise::figures(result),
            Kind::Motion(motion, _) => figure::motion::figures(motion),
            Kind::Orientation(motion, ..) => figure::motion::orientation(motion),
            Kind::Plain(_, figures) => figures(),
        }
    }

    fn build_document<'a>(&self, figures: &'a [Figure]) -> Document<'a> {
        let document = match &self.kind {
            Kind::Calibration(file, _) => return report::calibration(file, None, figures),
            Kind::Noise(result) => report::noise(result, figures),
            Kind::Motion(motion, rows) => report::motion(&motion.result, rows, figures),
            Kind::Orientation(_, result, rows, _) => report::orientation(result, rows, figures),
            Kind::Plain(document, _) => document(figures),
        };
        document.with_provenance(TOOL, None, &creation_time(), &self.inputs)
    }

    fn write_to(&self, path: &Path, force: bool, json: &str) -> Result<()> {
        let inputs: Vec<PathBuf> = self.inputs.iter().map(|i| PathBuf::from(&i.path)).collect();
        check_targets(&[path.to_owned()], &inputs, force)?;
        let write = |table: MotionTable<'_>| {
            write_atomic(path, force, |out| {
                table.write(out).map_err(|e| Error::io(path, e))
            })
        };
        match &self.kind {
            Kind::Calibration(file, _) => file.write(path, force),
            Kind::Motion(motion, _) => write(motion.table()),
            Kind::Orientation(motion, .., acceleration) => {
                write(motion.orientation_table(*acceleration))
            }
            _ => output::write_text(path, force, json),
        }
    }

    fn export_to(&self, to: &str, options: &ExportOptions) -> Result<(String, Vec<String>)> {
        let unknown = || {
            let names: Vec<&str> = TARGETS.iter().map(|t| t.name).collect();
            Error::usage("usage", format!("to=: {to:?} is no target"))
                .with_hint(format!("one of {}", names.join(", ")))
        };
        let target = Target::find(to).ok_or_else(unknown)?;
        target.check(options)?;
        let written = match &self.kind {
            Kind::Noise(result) if target.is_noise() => export_noise(result, target, options)?,
            _ => export(&*self.file()?, target, options)?,
        };
        Ok((written.text, written.notes))
    }
}

#[pymethods]
impl Outcome {
    /// Name, title, caption and SVG of each.
    fn figures(&self, py: Python<'_>) -> Vec<(String, String, String, String)> {
        py.detach(|| {
            let drawn = self.draw_figures().into_iter().map(|f| {
                let svg = figure::standalone(&f);
                (f.name, f.title, f.caption, svg)
            });
            drawn.collect()
        })
    }

    /// The report: `html`, `txt`, or the text in short.
    fn document(&self, py: Python<'_>, format: &str) -> String {
        py.detach(|| {
            let figures = self.draw_figures();
            let document = self.build_document(&figures);
            match format {
                "html" => document.to_html(),
                "txt" => document.to_text(Detail::Full),
                _ => document.to_text(Detail::Summary),
            }
        })
    }

    /// What the program writes with `-o`: a calibration, the table of a motion, else `json`.
    fn write(&self, py: Python<'_>, path: PathBuf, force: bool, json: &str) -> PyResult<()> {
        py.detach(|| self.write_to(&path, force, json))
            .map_err(|e| raised(py, &e))
    }

    /// Text for another program, and what it cannot hold.
    fn export(
        &self,
        py: Python<'_>,
        to: &str,
        mut keywords: Keywords,
    ) -> PyResult<(String, Vec<String>)> {
        let options: Result<ExportOptions> = keywords.last();
        let text = options.and_then(|options| self.export_to(to, &options));
        text.map_err(|e| raised(py, &e))
    }

    /// The table beside the document: names of its columns, and its values row by row.
    fn table<'py>(this: &Bound<'py, Self>) -> Option<(Vec<String>, Bound<'py, PyArray1<f64>>)> {
        let table = this.get().table.as_ref()?;
        let values = view(&table.values, this.clone().into_any());
        Some((table.columns.clone(), values))
    }

    /// The filtered recording.
    fn recording(&self) -> Option<Recording> {
        let shared = self.filtered.clone()?;
        Some(Recording { shared })
    }
}

/// A table in memory.
pub struct Table {
    columns: Vec<String>,
    /// Row by row.
    values: Vec<f64>,
}

impl Table {
    /// The calibrated channels of a recording.
    pub fn of_applied(applied: &gravical::apply::Applied, time_s: Option<&[f64]>) -> Self {
        let channels = applied.accel.iter().chain(applied.gyro.iter().flatten());
        let channels = channels.map(Vec::as_slice);
        let all: Vec<&[f64]> = time_s.into_iter().chain(channels).collect();
        let mut columns = applied.summary.columns.clone();
        if time_s.is_some() {
            columns.insert(0, "t_s".to_owned());
        }
        let rows = 0..applied.accel[0].len();
        let values = rows.flat_map(|i| all.iter().map(move |column| column[i]));
        let values = values.collect();
        Table { columns, values }
    }

    /// That of a motion.
    pub fn new(table: &MotionTable<'_>) -> Self {
        Table {
            columns: table.names().into_iter().map(str::to_owned).collect(),
            values: table.values(),
        }
    }
}

/// A calibration from its file, or from the text of it.
#[pyfunction]
pub fn read_calibration(
    py: Python<'_>,
    path: Option<PathBuf>,
    text: Option<&str>,
) -> PyResult<Outcome> {
    let file = match path {
        Some(path) => py.detach(|| Calibration::read(&path)),
        None => Calibration::parse(text.unwrap_or_default().as_bytes()),
    };
    file.and_then(|file| Outcome::calibration(file, None))
        .map_err(|e| raised(py, &e))
}

/// Targets of an export, and what each holds.
#[pyfunction]
pub fn export_targets() -> Vec<(&'static str, &'static str)> {
    TARGETS.iter().map(|t| (t.name, t.holds)).collect()
}

/// Writes a text, atomically; nothing is overwritten without `force`.
#[pyfunction]
pub fn write_text(py: Python<'_>, path: PathBuf, text: &str, force: bool) -> PyResult<()> {
    py.detach(|| output::write_text(&path, force, text))
        .map_err(|e| raised(py, &e))
}
