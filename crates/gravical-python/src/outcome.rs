//! Results: as JSON, as a report, as figures, as arrays.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use gravical::apply::{Applied, ApplySummary};
use gravical::calibration_file::{
    CalibrationFile, InputFile, InputRole, NoiseSection, creation_time,
};
use gravical::check::CheckReport;
use gravical::compare::Comparison;
use gravical::denoise::DenoiseSummary;
use gravical::export::{ExportOptions, TARGETS, Target, export, kalibr};
use gravical::inspect::Inspection;
use gravical::motion::{Motion, table_columns, write_table};
use gravical::noise::{self, NoiseResult};
use gravical::output::{self, write_atomic};
use gravical::recording;
use gravical::session::SessionCalibration;
use gravical::targets::check_targets;
use gravical::{Error, Result, TOOL};
use gravical_report::document::{Detail, Document};
use gravical_report::figure::{self, Figure, svg};
use gravical_report::report::{self, Provenance};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::error::OrRaise;
use crate::keywords::Keywords;
use crate::recording::{Recording, json, view};

/// What was found, and what its figures need.
pub enum Kind {
    /// Of `calibrate`, with its session if it was computed here.
    Calibration(Arc<CalibrationFile>, Option<Box<SessionCalibration>>),
    /// Of `inspect`.
    Inspection(Box<Inspection>),
    /// Of `apply`, with the calibrated channels if they stay in memory.
    Apply(Box<ApplySummary>, Option<Table>),
    /// Of `check`.
    Check(Box<CheckReport>),
    /// Of `compare`.
    Comparison(Box<Comparison>),
    /// Of `noise`.
    Noise(Box<NoiseResult>),
    /// Of `denoise`, with the filtered recording if it stays in memory.
    Denoise(Box<DenoiseSummary>, Option<Arc<recording::Recording>>),
    /// Of `motion`, with its recording and its table.
    Motion(Box<Motion>, Arc<recording::Recording>, Table),
}

/// A result and its files.
#[pyclass(frozen, module = "gravical._gravical")]
pub struct Outcome {
    kind: Kind,
    inputs: Vec<InputFile>,
}

impl Outcome {
    /// A result of these files.
    pub fn new(kind: Kind, inputs: Vec<InputFile>) -> Self {
        Outcome { kind, inputs }
    }

    /// A calibration.
    pub fn calibration(file: CalibrationFile, session: Option<Box<SessionCalibration>>) -> Self {
        let inputs = file.inputs.clone();
        Self::new(Kind::Calibration(Arc::new(file), session), inputs)
    }

    /// The calibration that this is.
    pub fn file(&self) -> Result<Arc<CalibrationFile>> {
        match &self.kind {
            Kind::Calibration(file, _) => Ok(file.clone()),
            _ => Err(Error::usage("usage", "this is not a calibration")),
        }
    }

    /// The noise that this is, with its file if it was read.
    pub fn noise(&self) -> Result<(NoiseSection, Vec<InputFile>)> {
        let Kind::Noise(result) = &self.kind else {
            return Err(Error::usage("usage", "noise=: this is no result of noise"));
        };
        let mut inputs = self.inputs.clone();
        inputs.retain(|input| input.role == InputRole::Noise);
        Ok((result.section(), inputs))
    }

    fn draw_figures(&self) -> Vec<Figure> {
        match &self.kind {
            Kind::Calibration(file, session) => {
                let session = session.as_ref().map(|s| figure::calibration::Session {
                    recordings: &s.recordings,
                    segmentation: &s.segmentation,
                });
                figure::calibration::figures(file, session)
            }
            Kind::Noise(result) => figure::noise::figures(result),
            Kind::Motion(motion, ..) => figure::motion::figures(motion),
            _ => Vec::new(),
        }
    }

    fn build_document<'a>(&self, figures: &'a [Figure]) -> Document<'a> {
        let document = match &self.kind {
            Kind::Calibration(file, _) => return report::calibration(file, None, figures),
            Kind::Inspection(result) => report::inspection(result),
            Kind::Apply(..) => Document::default(),
            Kind::Check(result) => report::check(result),
            Kind::Comparison(result) => report::comparison(result),
            Kind::Noise(result) => report::noise(result, figures),
            Kind::Denoise(result, _) => report::denoise(result),
            Kind::Motion(motion, recording, _) => {
                report::motion(&motion.result, recording, figures)
            }
        };
        document.with_provenance(&Provenance {
            tool: TOOL,
            command: None,
            created: &creation_time(),
            inputs: &self.inputs,
        })
    }

    fn write_to(&self, path: &Path, force: bool, json: &str) -> Result<()> {
        let inputs: Vec<PathBuf> = self.inputs.iter().map(|i| PathBuf::from(&i.path)).collect();
        check_targets(&[path.to_owned()], &inputs, force)?;
        match &self.kind {
            Kind::Calibration(file, _) => file.write(path, force),
            Kind::Motion(motion, ..) => write_atomic(path, force, |out| {
                write_table(motion, out).map_err(|e| Error::io(path, e))
            }),
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
        let written = match &self.kind {
            Kind::Noise(result) if target.name == "kalibr" => {
                kalibr(&result.section(), options.upper_limit)?
            }
            _ => export(&*self.file()?, target, options)?,
        };
        Ok((written.text, written.notes))
    }
}

#[pymethods]
impl Outcome {
    fn json(&self) -> PyResult<String> {
        match &self.kind {
            Kind::Calibration(file, _) => json(&**file),
            Kind::Inspection(result) => json(result),
            Kind::Apply(result, _) => json(result),
            Kind::Check(result) => json(result),
            Kind::Comparison(result) => json(result),
            Kind::Noise(result) => json(result),
            Kind::Denoise(result, _) => json(result),
            Kind::Motion(motion, ..) => json(&motion.result),
        }
    }

    /// Name, title, caption and SVG of each.
    fn figures(&self, py: Python<'_>) -> Vec<(String, String, String, String)> {
        py.detach(|| {
            let drawn = self.draw_figures().into_iter().map(|f| {
                let svg = svg::standalone(&f);
                (f.name, f.title, f.caption, svg)
            });
            drawn.collect()
        })
    }

    /// The report: `html`, `md`, `txt`, or the text in short.
    fn document(&self, py: Python<'_>, format: &str) -> String {
        if let Kind::Apply(summary, _) = &self.kind {
            return format!("{}: {} rows calibrated\n", summary.input, summary.rows);
        }
        py.detach(|| {
            let figures = self.draw_figures();
            let document = self.build_document(&figures);
            match format {
                "html" => document.to_html(),
                "md" => document.to_markdown(None),
                "txt" => document.to_text(Detail::Full),
                _ => document.to_text(Detail::Summary),
            }
        })
    }

    /// What the program writes with `-o`: a calibration, the table of a motion, else `json`.
    fn write(&self, py: Python<'_>, path: PathBuf, force: bool, json: &str) -> PyResult<()> {
        py.detach(|| self.write_to(&path, force, json)).or_raise(py)
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
        text.or_raise(py)
    }

    /// The table beside the document: names of its columns, and its values row by row.
    fn table<'py>(this: &Bound<'py, Self>) -> Option<(Vec<String>, Bound<'py, PyArray1<f64>>)> {
        let (Kind::Apply(_, Some(table)) | Kind::Motion(.., table)) = &this.get().kind else {
            return None;
        };
        let values = view(&table.values, this.clone().into_any());
        Some((table.columns.clone(), values))
    }

    /// The filtered recording.
    fn recording(&self) -> Option<Recording> {
        match &self.kind {
            Kind::Denoise(_, Some(rows)) => Some(Recording {
                shared: rows.clone(),
            }),
            _ => None,
        }
    }
}

/// A table in memory.
pub struct Table {
    columns: Vec<String>,
    /// Row by row.
    values: Vec<f64>,
}

impl Table {
    fn new(columns: Vec<String>, rows: usize, numbers: impl Iterator<Item = f64>) -> Self {
        let mut values = Vec::with_capacity(rows * columns.len());
        values.extend(numbers);
        Table { columns, values }
    }

    /// The calibrated channels of a recording.
    pub fn of_applied(applied: &Applied, time_s: Option<&[f64]>) -> Self {
        let channels = applied.accel.iter().chain(applied.gyro.iter().flatten());
        let channels = channels.map(Vec::as_slice);
        let all: Vec<&[f64]> = time_s.into_iter().chain(channels).collect();
        let mut columns = applied.summary.columns.clone();
        if time_s.is_some() {
            columns.insert(0, "t_s".to_owned());
        }
        let rows = applied.accel[0].len();
        let values = (0..rows).flat_map(|i| all.iter().map(move |column| column[i]));
        Table::new(columns, rows, values)
    }

    /// The table of a motion.
    pub fn of_motion(motion: &Motion) -> Self {
        let columns: Vec<String> = table_columns(motion).map(str::to_owned).collect();
        let (samples, width) = (motion.samples(), columns.len());
        let rows = samples.size_hint().0;
        let values = samples.flat_map(|sample| sample.numbers().take(width));
        Table::new(columns, rows, values)
    }
}

/// Noise from its file.
#[pyfunction]
pub fn read_noise(py: Python<'_>, path: PathBuf) -> PyResult<Outcome> {
    let (result, input) = noise::read_noise(&path).or_raise(py)?;
    Ok(Outcome::new(Kind::Noise(Box::new(result)), vec![input]))
}

/// A calibration from its file, or from the text of it.
#[pyfunction]
pub fn read_calibration(
    py: Python<'_>,
    path: Option<PathBuf>,
    text: Option<&str>,
) -> PyResult<Outcome> {
    let file = match path {
        Some(path) => py.detach(|| CalibrationFile::read(&path)),
        None => CalibrationFile::parse(text.unwrap_or_default().as_bytes()),
    };
    Ok(Outcome::calibration(file.or_raise(py)?, None))
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
        .or_raise(py)
}
