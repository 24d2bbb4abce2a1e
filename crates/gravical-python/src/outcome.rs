//! Results: as JSON, as a report, as figures, as arrays.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use gravical::apply::ApplySummary;
use gravical::calibration_file::{CalibrationFile, InputFile, creation_time};
use gravical::check::CheckReport;
use gravical::compare::Comparison;
use gravical::core::calibration::GyroscopeCalibration;
use gravical::denoise::DenoiseSummary;
use gravical::export::{ExportOptions, TARGETS, Target, export, kalibr};
use gravical::inspect::Inspection;
use gravical::motion::{Motion, Track, table_columns, write_table};
use gravical::noise::{NoiseResult, read_noise};
use gravical::output::{write_atomic, write_text};
use gravical::recording::Recording;
use gravical::session::SessionCalibration;
use gravical::targets::check_targets;
use gravical::{Error, Result, TOOL};
use gravical_report::document::{Detail, Document};
use gravical_report::figure::{self, Figure, svg};
use gravical_report::report::{self, Provenance};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::error::OrRaise;
use crate::keywords::Keywords;
use crate::recording::{json, view};

/// What was found, and what its figures need.
pub enum Kind {
    /// Of `calibrate`, with its session if it was computed here.
    Calibration(Arc<CalibrationFile>, Option<Box<SessionCalibration>>),
    /// Of `inspect`.
    Inspection(Box<Inspection>),
    /// Of `apply`, with the recording and its channels if they stay in memory.
    Apply(Box<ApplySummary>, Option<(Arc<Recording>, Vec<Vec<f64>>)>),
    /// Of `check`.
    Check(Box<CheckReport>),
    /// Of `compare`.
    Comparison(Box<Comparison>),
    /// Of `noise`.
    Noise(Box<NoiseResult>),
    /// Of `denoise`.
    Denoise(Box<DenoiseSummary>),
    /// Of `motion`, with what is said of its recording.
    Motion(Arc<Motion>, Arc<Recording>),
}

/// A result and its files.
#[pyclass(frozen, module = "gravical._gravical")]
pub struct Outcome {
    kind: Kind,
    inputs: Vec<InputFile>,
    /// Columns of a motion, once they are asked for.
    track: OnceLock<Track>,
}

/// Name, title, caption and SVG.
type Drawn = (String, String, String, String);

/// A group of columns: its name, theirs, and their values; those of one array lie row by row.
type Group<'py> = (&'static str, Vec<String>, Vec<Bound<'py, PyAny>>);

impl Outcome {
    /// A result of these files.
    pub fn new(kind: Kind, inputs: Vec<InputFile>) -> Self {
        Outcome {
            kind,
            inputs,
            track: OnceLock::new(),
        }
    }

    /// A calibration.
    pub fn calibration(file: CalibrationFile, session: Option<Box<SessionCalibration>>) -> Self {
        let inputs = file.inputs.clone();
        Self::new(Kind::Calibration(Arc::new(file), session), inputs)
    }

    /// The calibration that this is.
    pub fn file(&self) -> PyResult<Arc<CalibrationFile>> {
        match &self.kind {
            Kind::Calibration(file, _) => Ok(file.clone()),
            _ => Err(PyValueError::new_err("this is not a calibration")),
        }
    }

    fn drawn(&self) -> Vec<Figure> {
        match &self.kind {
            Kind::Calibration(file, session) => {
                let session = session.as_ref().map(|s| figure::calibration::Session {
                    recordings: &s.recordings,
                    segmentation: &s.segmentation,
                });
                figure::calibration::figures(file, session)
            }
            Kind::Noise(result) => figure::noise::figures(result),
            Kind::Motion(motion, _) => figure::motion::figures(motion),
            _ => Vec::new(),
        }
    }

    fn presented<'a>(&'a self, figures: &'a [Figure]) -> Document<'a> {
        let document = match &self.kind {
            Kind::Calibration(file, _) => return report::calibration(file, None, figures),
            Kind::Inspection(result) => report::inspection(result),
            Kind::Apply(..) => Document::default(),
            Kind::Check(result) => report::check(result),
            Kind::Comparison(result) => report::comparison(result),
            Kind::Noise(result) => report::noise(result, figures),
            Kind::Denoise(result) => report::denoise(result),
            Kind::Motion(motion, recording) => report::motion(&motion.result, recording, figures),
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
            Kind::Motion(motion, _) => write_atomic(path, force, |out| {
                write_table(motion, out).map_err(|e| Error::io(path, e))
            }),
            _ => write_text(path, force, json),
        }
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
            Kind::Denoise(result) => json(result),
            Kind::Motion(motion, _) => json(&motion.result),
        }
    }

    fn figures(&self, py: Python<'_>) -> Vec<Drawn> {
        py.detach(|| {
            let drawn = self.drawn().into_iter().map(|f| {
                let svg = svg::standalone(&f);
                (f.name, f.title, f.caption, svg)
            });
            drawn.collect()
        })
    }

    /// The report: `html`, `md`, `txt`, or `summary`, the text in short.
    fn document(&self, py: Python<'_>, format: &str) -> PyResult<String> {
        if let Kind::Apply(summary, _) = &self.kind {
            return Ok(format!(
                "{}: {} rows calibrated\n",
                summary.input, summary.rows
            ));
        }
        py.detach(|| {
            let figures = self.drawn();
            let document = self.presented(&figures);
            match format {
                "html" => Ok(document.to_html()),
                "md" => Ok(document.to_markdown(None)),
                "txt" => Ok(document.to_text(Detail::Full)),
                "summary" => Ok(document.to_text(Detail::Summary)),
                _ => Err(PyValueError::new_err(format!("no format {format:?}"))),
            }
        })
    }

    /// What the program writes with `-o`: a calibration, the table of a motion, else JSON.
    fn write(&self, py: Python<'_>, path: PathBuf, force: bool) -> PyResult<()> {
        let value: serde_json::Value = serde_json::from_str(&self.json()?)
            .map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
        let text = format!("{value:#}\n");
        py.detach(|| self.write_to(&path, force, &text))
            .or_raise(py)
    }

    /// Text for another program, and what it cannot hold.
    fn export(
        &self,
        py: Python<'_>,
        to: &str,
        keywords: Keywords,
    ) -> PyResult<(String, Vec<String>)> {
        let options = keywords.read(py, Keywords::take::<ExportOptions>)?;
        let targets = || {
            let names: Vec<&str> = TARGETS.iter().map(|t| t.name).collect();
            Error::usage("usage", format!("to=: {to:?} is no target"))
                .with_hint(format!("one of {}", names.join(", ")))
        };
        let target = Target::find(to).ok_or_else(targets).or_raise(py)?;
        let written = match &self.kind {
            Kind::Noise(result) if target.name == "kalibr" => {
                kalibr(&result.section(), None, options.upper_limit)
            }
            _ => export(&*self.file()?, target, &options),
        };
        let written = written.or_raise(py)?;
        Ok((written.text, written.notes))
    }

    /// The arrays beside the document.
    fn arrays<'py>(this: &Bound<'py, Self>) -> Vec<Group<'py>> {
        let (py, outcome) = (this.py(), this.get());
        let share = |values: &[f64]| view(values, this.clone().into_any()).into_any();
        match &outcome.kind {
            Kind::Apply(summary, Some((rows, channels))) => {
                let t = rows.time_s.iter();
                let t = t.map(|t| ("t", vec!["t_s".to_owned()], vec![share(t)]));
                let threes = channels.chunks(3).zip(summary.columns.chunks(3));
                let named = ["accel", "gyro"].into_iter().zip(threes);
                let named = named.map(|(name, (three, names))| {
                    (
                        name,
                        names.to_vec(),
                        three.iter().map(|v| share(v)).collect(),
                    )
                });
                t.chain(named).collect()
            }
            Kind::Motion(motion, _) => {
                let track = py.detach(|| outcome.track.get_or_init(|| motion.track()));
                let still = PyArray1::from_slice(py, &track.still);
                still.readwrite().make_nonwriteable();
                let three = |columns: &[Vec<f64>; 3]| columns.iter().map(|c| share(c)).collect();
                let rows = |columns: &[[f64; 3]]| vec![share(columns.as_flattened())];
                let groups = [
                    ("t", 1, vec![share(&track.t_s)]),
                    ("raw", 3, three(&track.raw_mps2)),
                    ("force", 3, three(&track.force_mps2)),
                    ("still", 1, vec![still.into_any()]),
                    ("attitude", 4, vec![share(track.attitude.as_flattened())]),
                    ("acceleration", 3, rows(&track.acceleration_mps2)),
                    ("velocity", 3, rows(&track.velocity_mps)),
                    ("position", 3, rows(&track.position_m)),
                    ("sigma_velocity", 3, rows(&track.sigma_velocity_mps)),
                    ("sigma_position", 3, rows(&track.sigma_position_m)),
                ];
                let mut names = table_columns(track.bands).map(str::to_owned);
                let named = groups.map(|(name, width, values)| {
                    (name, names.by_ref().take(width).collect::<Vec<_>>(), values)
                });
                named
                    .into_iter()
                    .filter(|(_, names, _)| !names.is_empty())
                    .collect()
            }
            _ => Vec::new(),
        }
    }

    /// Specific force, m/s², of readings in the unit of the calibration.
    fn apply_accel<'py>(
        &self,
        py: Python<'py>,
        raw: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let calibration = self.file()?.accelerometer_calibration();
        mapped(py, &raw, |_, row| calibration.apply(row))
    }

    /// Angular rate, rad/s, of readings in the unit of the calibration; `force` is calibrated.
    fn apply_gyro<'py>(
        &self,
        py: Python<'py>,
        raw: PyReadonlyArray2<'py, f64>,
        force: Option<PyReadonlyArray2<'py, f64>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let calibration = self.file()?.gyroscope_calibration().ok_or_else(|| {
            Error::usage("gyro-not-calibrated", "the calibration has no gyroscope")
                .with_hint("calibrate with recordings that hold its columns")
        });
        let calibration: GyroscopeCalibration<f64> = calibration.or_raise(py)?;
        let force = force.as_ref().map(|force| force.as_array());
        mapped(py, &raw, |i, row| {
            let at = force.as_ref().map(|f| [f[[i, 0]], f[[i, 1]], f[[i, 2]]]);
            calibration.apply(row, at.unwrap_or_default())
        })
    }
}

/// Each row by `of`, the interpreter released.
fn mapped<'py>(
    py: Python<'py>,
    raw: &PyReadonlyArray2<'py, f64>,
    of: impl Fn(usize, [f64; 3]) -> [f64; 3] + Send + Sync,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let raw = raw.as_array();
    let out = py.detach(|| {
        let rows = raw.rows().into_iter().enumerate();
        let out = rows.flat_map(|(i, row)| of(i, [row[0], row[1], row[2]]));
        Array2::from_shape_vec((raw.nrows(), 3), out.collect())
    });
    let out = out.map_err(|e| PyValueError::new_err(e.to_string()))?;
    Ok(out.into_pyarray(py))
}

/// The noise of a sensor: a result of `noise`, or the path of its file.
#[derive(FromPyObject)]
pub enum Noise<'py> {
    /// The result.
    Result(Bound<'py, Outcome>),
    /// Its file.
    File(PathBuf),
}

impl Noise<'_> {
    /// The noise, and its file if it was read.
    pub fn read(self, py: Python<'_>) -> PyResult<(NoiseResult, Option<InputFile>)> {
        match self {
            Noise::Result(outcome) => match &outcome.get().kind {
                Kind::Noise(result) => Ok(((**result).clone(), None)),
                _ => Err(PyValueError::new_err("this is not a result of noise")),
            },
            Noise::File(path) => {
                let (result, input) = read_noise(&path).or_raise(py)?;
                Ok((result, Some(input)))
            }
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
