//! Motion: of a whole recording, and sample by sample.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use gravical::Result;
use gravical::calibration_file::InputFile;
use gravical::motion::truth::{add_comparison, read_reference};
use gravical::motion::{
    self as library, Calibrated, MotionOptions, MotionSample, MotionStepper, Readings,
};
use gravical::recording::Meter;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use serde::Deserialize;

use crate::keywords::Keywords;
use crate::outcome::{Kind, Noise, Outcome};
use crate::recording::{Source, json};
use crate::task;

/// A reference that the result is compared with.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Truth {
    truth: Option<PathBuf>,
}

fn options(keywords: &mut Keywords) -> Result<MotionOptions> {
    let gravity = keywords.gravity()?;
    let options = MotionOptions {
        gravity,
        ..keywords.take()?
    };
    options.validate()?;
    Ok(options)
}

/// Velocity and position of a recording.
#[pyfunction]
pub fn motion(
    py: Python<'_>,
    source: Source<'_>,
    calibration: Option<&Bound<'_, Outcome>>,
    name: String,
    noise: Option<Noise<'_>>,
    keywords: Keywords,
) -> PyResult<Outcome> {
    let meter = Meter::default();
    let (rows, (mut wanted, truth)) = source.open(py, keywords, &meter, |k| {
        Ok((options(k)?, k.take::<Truth>()?.truth))
    })?;
    let noise = noise.map(|noise| noise.read(py)).transpose()?;
    wanted.noise = noise.as_ref().map(|(result, _)| result.section());
    wanted.meter = Some(meter.clone());
    let file = calibration.map(|c| c.get().file()).transpose()?;
    task::run(py, &meter, move || {
        let calibrated = file.as_deref().map(|file| Calibrated { file, name: &name });
        let mut motion = library::motion(&rows, calibrated, &wanted)?;
        let mut inputs = InputFile::of(std::slice::from_ref(&*rows));
        inputs.extend(noise.and_then(|(_, input)| input));
        if let Some(path) = truth {
            let here = PathBuf::from(&rows.name);
            let reference = read_reference(&path, &rows, &here)?;
            add_comparison(&mut motion, &reference)?;
            inputs.push(reference.input());
        }
        Ok(Outcome::new(Kind::Motion(Arc::new(motion), rows), inputs))
    })
}

/// Motion sample by sample.
#[pyclass(frozen, module = "gravical._gravical")]
pub struct Stepper {
    stepper: Mutex<MotionStepper>,
    /// The first recording has time stamps.
    #[pyo3(get)]
    timed: bool,
}

/// What is known after each sample, whether it rests, and whether it was taken.
type States<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
);

/// Numbers of a sample: t, force, attitude, acceleration, velocity, position, and σ of the last two.
const WIDTH: usize = 1 + 3 + 4 + 3 + 3 + 3 + 3 + 3;

fn numbers(sample: &MotionSample) -> [f64; WIDTH] {
    let mut all = [sample.t_s; WIDTH];
    all[1..4].copy_from_slice(&sample.force_mps2);
    let state = &sample.state;
    all[4..8].copy_from_slice(&state.attitude);
    all[8..11].copy_from_slice(&state.acceleration_mps2);
    all[11..14].copy_from_slice(&state.velocity_mps);
    all[14..17].copy_from_slice(&state.position_m);
    all[17..20].copy_from_slice(&state.velocity_sd_mps);
    all[20..23].copy_from_slice(&state.position_sd_m);
    all
}

fn busy<T>(_: T) -> PyErr {
    PyRuntimeError::new_err("another thread failed while it used this object; make a new one")
}

#[pymethods]
impl Stepper {
    #[new]
    fn new(
        py: Python<'_>,
        first: Source<'_>,
        calibration: Option<&Bound<'_, Outcome>>,
        name: String,
        keywords: Keywords,
    ) -> PyResult<Self> {
        let meter = Meter::default();
        let (rows, wanted) = first.open(py, keywords, &meter, options)?;
        let file = calibration.map(|c| c.get().file()).transpose()?;
        let timed = rows.time_s.is_some();
        let stepper = task::run(py, &meter, move || {
            let calibrated = file.as_deref().map(|file| Calibrated { file, name: &name });
            MotionStepper::new(&rows, calibrated, &wanted)
        })?;
        Ok(Stepper {
            stepper: Mutex::new(stepper),
            timed,
        })
    }

    /// Takes rows of t, ax, ay, az, gx, gy, gz, temperature, with NaN for what there is not; returns
    /// what is known after each, whether it rests, and whether it was taken.
    fn update<'py>(
        &self,
        py: Python<'py>,
        rows: PyReadonlyArray2<'py, f64>,
        timed: bool,
    ) -> PyResult<States<'py>> {
        let rows = rows.as_array();
        let count = rows.nrows();
        let mut out = Vec::with_capacity(count * WIDTH);
        let (mut still, mut taken) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut run = || -> PyResult<()> {
            let mut stepper = self.stepper.lock().map_err(busy)?;
            for row in rows.rows() {
                let was = stepper.update(&Readings {
                    t_s: timed.then_some(row[0]),
                    accel: [row[1], row[2], row[3]],
                    gyro: [row[4], row[5], row[6]],
                    temperature_c: row[7],
                });
                taken.push(was);
                still.push(stepper.now().state.at_rest);
                out.extend(numbers(stepper.now()));
            }
            Ok(())
        };
        py.detach(&mut run)?;
        let out = Array2::from_shape_vec((count, WIDTH), out);
        let out = out.map_err(|e| PyValueError::new_err(e.to_string()))?;
        Ok((
            out.into_pyarray(py),
            still.into_pyarray(py),
            taken.into_pyarray(py),
        ))
    }

    fn interrupt(&self) -> PyResult<()> {
        self.stepper.lock().map_err(busy)?.interrupt();
        Ok(())
    }

    #[getter]
    fn samples(&self) -> PyResult<u64> {
        Ok(self.stepper.lock().map_err(busy)?.samples())
    }

    fn findings_json(&self) -> PyResult<String> {
        json(&self.stepper.lock().map_err(busy)?.findings())
    }
}
