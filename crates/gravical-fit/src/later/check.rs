//! Do later readings at rest fit a calibration?

use nalgebra::{DMatrix, DVector, Vector3};

use super::propagated;
use crate::consistent::{Test, consistent};
use crate::model::{Parameters, bend, bias, matrix};
use crate::sensor::{Gravity, Sensor};

/// Directions this near to each other (chord of the unit sphere, 25°) share the model error.
const MODEL_ERROR_CHORD: f64 = 0.43;

/// A mean reading at rest, in working units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticMean {
    /// Mean of the channels, at the temperature of reference.
    pub mean: Vector3<f64>,
    /// Standard deviation of this mean.
    pub sd: Vector3<f64>,
    /// Standard deviation of its length beside that, independent between intervals, m/s².
    pub sd_of_length_mps2: f64,
}

/// A static interval, calibrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    /// Specific force, axes of the board, m/s².
    pub force: Vector3<f64>,
    /// ‖a‖ less gravity, the bend of the sensor taken off, m/s².
    pub error_mps2: f64,
    /// Its standard deviation, if the calibration fits, m/s².
    pub sd_mps2: f64,
}

/// A calibration held against later readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Every static interval, as they were given.
    pub lengths: Vec<Length>,
    /// All errors that count together.
    pub test: Test,
}

/// Holds the lengths of static intervals against gravity: that of the calibration, or of another
/// place, `here`. Only those that `count` are tested. None without one, or where a value is no number.
///
/// The intervals share the errors of the parameters, of gravity and of the model; the noise of each
/// mean is its own.
pub fn check(
    sensor: &Sensor,
    here: Option<Gravity>,
    means: &[StaticMean],
    counts: impl Fn(usize) -> bool,
) -> Option<Check> {
    let gravity = here.unwrap_or(sensor.gravity).value_mps2;
    let counted: Vec<usize> = (0..means.len()).filter(|k| counts(*k)).collect();
    if counted.is_empty() || !sensor.is_finite() {
        return None;
    }
    let x = &sensor.parameters;
    let inverse = matrix(x).try_inverse()?;
    let forces: Vec<Vector3<f64>> = means
        .iter()
        .map(|s| inverse * (s.mean - bias(x, 0.0)))
        .collect();
    let errors = length_errors(x, gravity, means)?;
    let directions: Vec<Vector3<f64>> = forces.iter().map(Vector3::normalize).collect();
    let by_parameters = propagated(x, &sensor.covariance, |x| length_errors(x, gravity, means))?;
    let covariance = by_parameters + covariance_of_the_rest(sensor, here, &directions, means)?;
    let length = |i: usize| Length {
        force: forces[i],
        error_mps2: errors[i],
        sd_mps2: covariance[(i, i)].sqrt(),
    };
    let lengths = (0..means.len()).map(length).collect();
    let errors = errors.select_rows(&counted);
    let covariance = covariance.select_rows(&counted).select_columns(&counted);
    Some(Check {
        lengths,
        test: consistent(&errors, &covariance),
    })
}

/// ‖a‖ less gravity, the bend taken off. None where that is no number.
fn length_errors(x: &Parameters, gravity: f64, means: &[StaticMean]) -> Option<DVector<f64>> {
    let inverse = matrix(x).try_inverse()?;
    let error = |s: &StaticMean| {
        let force = inverse * (s.mean - bias(x, 0.0));
        force.norm() - gravity * (1.0 + bend(x, &force.normalize()))
    };
    let errors = DVector::from_iterator(means.len(), means.iter().map(error));
    errors.iter().all(|e| e.is_finite()).then_some(errors)
}

/// Covariance of the lengths along `directions` by gravity, model error and noise.
fn covariance_of_the_rest(
    sensor: &Sensor,
    here: Option<Gravity>,
    directions: &[Vector3<f64>],
    means: &[StaticMean],
) -> Option<DMatrix<f64>> {
    let inverse = matrix(&sensor.parameters).try_inverse()?;
    // Held against its own gravity, the error of that counts once.
    let elsewhere = here.map_or(0.0, |here| here.sd_mps2.powi(2));
    let of_gravity = sensor.gravity.sd_mps2.powi(2) + elsewhere;
    let model_error = |i: usize, j: usize| {
        let chord = (directions[i] - directions[j]).norm() / MODEL_ERROR_CHORD;
        sensor.model_error_mps2.powi(2) * (-chord * chord).exp()
    };
    let noise = |i: usize| {
        let along = inverse.tr_mul(&directions[i]).component_mul(&means[i].sd);
        along.norm_squared() + means[i].sd_of_length_mps2.powi(2)
    };
    Some(DMatrix::from_fn(means.len(), means.len(), |i, j| {
        let own = if i == j { noise(i) } else { 0.0 };
        of_gravity + model_error(i, j) + own
    }))
}
