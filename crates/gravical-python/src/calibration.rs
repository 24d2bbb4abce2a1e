//! Calibrations.

use std::path::PathBuf;
use std::sync::Arc;

use gravical::calibration_file::{CalibrationFile, InputFile};
use gravical::core::calibration::GyroscopeCalibration;
use gravical::export::{TARGETS, Target, export};
use gravical::gravity::Gravity;
use gravical::noise::{NoiseResult, read_noise};
use gravical::poses::Segmentation;
use gravical::recording::Recording as Rows;
use gravical::session::{Session, SessionCalibration, calibrate_recordings as calibrate_rows};
use gravical::{Error, Result};
use gravical_report::figure::{self, Figure};
use gravical_report::report;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::OrRaise;
use crate::options::Options;
use crate::outcome::{Drawn, Kind, Outcome, check_output, rendered, svgs};
use crate::recording::Recording;
use crate::task;

/// What a calibration was computed from, for figures.
struct Origin {
    recordings: Vec<Rows>,
    segmentation: Segmentation,
}

/// A calibration, and the session it comes from if it was computed here.
#[pyclass(frozen, module = "gravical._gravical")]
pub struct Calibration {
    /// Shared with what is computed with it.
    pub file: Arc<CalibrationFile>,
    origin: Option<Arc<Origin>>,
}

impl Calibration {
    fn of(file: CalibrationFile) -> Self {
        Calibration {
            file: Arc::new(file),
            origin: None,
        }
    }

    fn drawn(&self) -> Vec<Figure> {
        let session = self.origin.as_ref().map(|o| figure::calibration::Session {
            recordings: &o.recordings,
            segmentation: &o.segmentation,
        });
        figure::calibration::figures(&self.file, session)
    }
}

impl From<SessionCalibration> for Calibration {
    fn from(done: SessionCalibration) -> Self {
        Calibration {
            file: Arc::new(done.file),
            origin: Some(Arc::new(Origin {
                recordings: done.recordings,
                segmentation: done.segmentation,
            })),
        }
    }
}

#[pymethods]
impl Calibration {
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let file = py.detach(|| CalibrationFile::read(&path));
        file.map(Self::of).or_raise(py)
    }

    #[staticmethod]
    fn parse(py: Python<'_>, text: &str) -> PyResult<Self> {
        CalibrationFile::parse(text.as_bytes())
            .map(Self::of)
            .or_raise(py)
    }

    /// The text of the file.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        self.file.to_json().or_raise(py)
    }

    fn write(&self, py: Python<'_>, path: PathBuf, force: bool) -> PyResult<()> {
        let write = || {
            check_output(&path, &self.file.inputs, force)?;
            self.file.write(&path, force)
        };
        py.detach(write).or_raise(py)
    }

    /// Text for another program, and what it cannot hold.
    fn export(
        &self,
        py: Python<'_>,
        to: &str,
        options: Options<'_>,
    ) -> PyResult<(String, Vec<String>)> {
        let Some(target) = Target::find(to) else {
            let names: Vec<&str> = TARGETS.iter().map(|t| t.name).collect();
            let error = Error::usage("usage", format!("to=: {to:?} is no target"));
            return Err(error.with_hint(format!("one of {}", names.join(", ")))).or_raise(py);
        };
        let written = export(&self.file, target, &options.export()?).or_raise(py)?;
        Ok((written.text, written.notes))
    }

    fn figures(&self, py: Python<'_>) -> Vec<Drawn> {
        py.detach(|| svgs(&self.drawn()))
    }

    fn document(&self, py: Python<'_>, format: &str) -> PyResult<String> {
        py.detach(|| {
            let figures = self.drawn();
            rendered(&report::calibration(&self.file, None, &figures), format)
        })
    }

    /// Specific force, m/s², of readings in the unit of the calibration.
    fn apply_accel<'py>(
        &self,
        py: Python<'py>,
        raw: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let calibration = self.file.accelerometer_calibration();
        mapped(py, &raw, |row| calibration.apply(row))
    }

    /// Angular rate, rad/s, of readings in the unit of the calibration; `force` is calibrated.
    fn apply_gyro<'py>(
        &self,
        py: Python<'py>,
        raw: PyReadonlyArray2<'py, f64>,
        force: Option<PyReadonlyArray2<'py, f64>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let calibration = self.file.gyroscope_calibration().ok_or_else(|| {
            Error::usage("gyro-not-calibrated", "the calibration has no gyroscope")
                .with_hint("calibrate with recordings that hold its columns")
        });
        let calibration: GyroscopeCalibration<f64> = calibration.or_raise(py)?;
        let Some(force) = force else {
            return mapped(py, &raw, |row| calibration.apply(row, [0.0; 3]));
        };
        let (force, mut at) = (force.as_array(), 0);
        mapped(py, &raw, |row| {
            let f = [force[[at, 0]], force[[at, 1]], force[[at, 2]]];
            at += 1;
            calibration.apply(row, f)
        })
    }
}

/// Each row by `of`, the interpreter released.
fn mapped<'py>(
    py: Python<'py>,
    raw: &PyReadonlyArray2<'py, f64>,
    mut of: impl FnMut([f64; 3]) -> [f64; 3] + Send,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let raw = raw.as_array();
    let rows = raw.nrows();
    let mut out: Vec<f64> = Vec::with_capacity(3 * rows);
    py.detach(|| match raw.as_slice() {
        Some(values) => {
            for row in values.chunks_exact(3) {
                out.extend(of([row[0], row[1], row[2]]));
            }
        }
        None => {
            for row in raw.rows() {
                out.extend(of([row[0], row[1], row[2]]));
            }
        }
    });
    let out = Array2::from_shape_vec((rows, 3), out);
    Ok(out
        .map_err(|e| PyValueError::new_err(e.to_string()))?
        .into_pyarray(py))
}

/// The noise of a sensor, from `noise`.
type Noise = (NoiseResult, Option<InputFile>);

/// The noise of the sensor: a result of `noise`, or the path of its file.
pub fn noise_of(py: Python<'_>, given: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Noise>> {
    let Some(given) = given else {
        return Ok(None);
    };
    if let Ok(outcome) = given.cast::<Outcome>() {
        return match &outcome.get().kind {
            Kind::Noise(result) => Ok(Some(((**result).clone(), None))),
            _ => Err(PyValueError::new_err("this is not a result of noise")),
        };
    }
    let path: PathBuf = given.extract()?;
    let (result, input) = read_noise(&path).or_raise(py)?;
    Ok(Some((result, Some(input))))
}

fn with_noise(mut done: SessionCalibration, noise: Option<Noise>) -> Calibration {
    if let Some((noise, input)) = noise {
        done.file.noise = Some(noise.section());
        done.file.inputs.extend(input);
    }
    done.into()
}

/// Calibrates from files or a folder.
#[pyfunction]
pub fn calibrate_paths(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    gyro: Option<PathBuf>,
    noise: Option<Bound<'_, PyAny>>,
    options: Options<'_>,
) -> PyResult<Calibration> {
    let calibrate = options.calibrate()?;
    let gravity: Option<Gravity> = options.gravity()?;
    let noise = noise_of(py, noise.as_ref())?;
    let (read, meter) = options.read(true)?;
    let done = task::run(py, &meter, move || {
        let session = Session {
            inputs: &paths,
            gyro: gyro.as_deref(),
            read: &read,
            options: &calibrate,
            gravity,
        };
        session.calibrate()
    })?;
    Ok(with_noise(done, noise))
}

/// Calibrates from recordings in memory.
#[pyfunction]
pub fn calibrate_recordings(
    py: Python<'_>,
    recordings: Vec<Bound<'_, Recording>>,
    noise: Option<Bound<'_, PyAny>>,
    options: Options<'_>,
) -> PyResult<Calibration> {
    let calibrate = options.calibrate()?;
    let noise = noise_of(py, noise.as_ref())?;
    let (_, meter) = options.read(false)?;
    let shared: Vec<Arc<Rows>> = recordings.iter().map(|r| r.get().shared.clone()).collect();
    let done = task::run(py, &meter, move || -> Result<SessionCalibration> {
        let rows = shared.iter().map(|r| (**r).clone()).collect();
        calibrate_rows(rows, &calibrate)
    })?;
    Ok(with_noise(done, noise))
}

/// Targets of an export, and what each holds.
#[pyfunction]
pub fn export_targets() -> Vec<(&'static str, &'static str)> {
    TARGETS.iter().map(|t| (t.name, t.holds)).collect()
}
