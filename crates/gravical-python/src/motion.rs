//! Motion sample by sample.

use std::sync::Mutex;

use gravical::motion::{Calibrated, MotionStepper, Readings};
use gravical::recording::Meter;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::keywords::Keywords;
use crate::outcome::Outcome;
use crate::recording::{Inputs, Reading, json};
use crate::task;
use crate::verbs::motion_options;

/// Motion sample by sample.
#[pyclass(frozen, module = "gravical._gravical")]
pub struct Stepper {
    stepper: Mutex<MotionStepper>,
    /// The first recording has time stamps.
    #[pyo3(get)]
    timed: bool,
}

/// The numbers of a sample, and whether it was taken.
const WIDTH: usize = 1 + 2 * 3 + 1 + 4 + 5 * 3 + 1;

fn busy<T>(_: T) -> PyErr {
    PyRuntimeError::new_err("another thread failed while it used this object; make a new one")
}

#[pymethods]
impl Stepper {
    #[new]
    fn new(
        py: Python<'_>,
        first: Inputs,
        calibration: Option<(Py<Outcome>, String)>,
        mut keywords: Keywords,
    ) -> PyResult<Self> {
        let meter = Meter::default();
        let (stepper, timed) = task::run(py, &meter.clone(), move || {
            let options = motion_options(&mut keywords)?;
            let reading = Reading::new(first, &mut keywords, &meter)?;
            keywords.end()?;
            let rows = reading.one()?;
            let name = calibration.as_ref().map_or("", |(_, name)| name.as_str());
            let file = calibration
                .as_ref()
                .map(|(outcome, _)| outcome.get().file());
            let file = file.transpose()?;
            let calibrated = file.as_deref().map(|file| Calibrated { file, name });
            let stepper = MotionStepper::new(&rows, calibrated, &options)?;
            Ok((stepper, rows.time_s.is_some()))
        })?;
        Ok(Stepper {
            stepper: Mutex::new(stepper),
            timed,
        })
    }

    /// Takes rows of t, ax, ay, az, gx, gy, gz, temperature, with NaN for what there is not; returns
    /// what is known after each, and at last whether it was taken.
    fn update<'py>(
        &self,
        py: Python<'py>,
        rows: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = rows.as_array();
        let states = py.detach(|| -> PyResult<Array2<f64>> {
            let mut states = Vec::with_capacity(rows.nrows() * WIDTH);
            let mut stepper = self.stepper.lock().map_err(busy)?;
            for row in rows.rows() {
                let is_taken = stepper.update(&Readings {
                    t_s: self.timed.then_some(row[0]),
                    accel: [row[1], row[2], row[3]],
                    gyro: [row[4], row[5], row[6]],
                    temperature_c: row[7],
                });
                states.extend(stepper.now().numbers().chain([f64::from(is_taken)]));
            }
            Array2::from_shape_vec((rows.nrows(), WIDTH), states)
                .map_err(|e| PyValueError::new_err(e.to_string()))
        })?;
        Ok(states.into_pyarray(py))
    }

    fn interrupt(&self) -> PyResult<()> {
        self.stepper.lock().map_err(busy)?.interrupt();
        Ok(())
    }

    #[getter]
    fn samples(&self) -> PyResult<u64> {
        Ok(self.stepper.lock().map_err(busy)?.samples())
    }

    fn findings(&self) -> PyResult<String> {
        json(&self.stepper.lock().map_err(busy)?.findings())
    }
}
