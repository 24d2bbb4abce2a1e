//! The gyroscope from static intervals and the motions between them.
//!
//! At rest it reads its bias and what gravity does to it. Gravity's direction is known at both ends of a
//! motion from the calibrated accelerometer, so that the integrated angular rate has to turn the one into
//! the other:
//!
//! ```text
//! C(∫ω dt) v₀ − v₁ = 0,   ω = G (u − b − S a)
//! ```
//!
//! for the nine elements of G and what the rests leave of b (Tedaldi, Pretto and Menegatti, "A robust and
//! easy to implement method for IMU calibration without external equipments", ICRA 2014). No turn has to be
//! known. It fails where the sensor never turns about one of its axes while that axis is level: a turn
//! about the vertical leaves gravity where it is.

mod motions;
mod rest;
#[cfg(test)]
mod tests;

use gravical_core::calibration::LinearCalibration;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use crate::model::median;
use motions::{FLOOR, Path, Problem, Square};
use rest::at_rest;

/// A static interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticInterval {
    /// Mean of the gyroscope, input unit.
    pub rate: [f64; 3],
    /// Duration, s.
    pub seconds: f64,
    /// Mean of the accelerometer, its input unit.
    pub accel: [f64; 3],
    /// Standard deviation of that mean.
    pub accel_sd: [f64; 3],
}

/// One reading of a [`Motion`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Gyroscope, input unit.
    pub rate: [f64; 3],
    /// Accelerometer, its input unit; where it is no number, the last one that is holds.
    pub accel: [f64; 3],
    /// Time to the next sample, s; not used in the last one.
    pub step_s: f64,
}

/// What happened between two static intervals, from a reading at rest to one at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Index of the static interval before it.
    pub before: usize,
    /// … and of the one after it.
    pub after: usize,
    /// Without a gap.
    pub samples: Vec<Sample>,
}

/// What is known of the gyroscope beside its readings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GyroOptions {
    /// Nominal scale, input unit per rad/s; none: the motions show it.
    pub nominal: Option<f64>,
    /// Low-frequency noise, Allan N, input unit · √s.
    pub noise: [f64; 3],
    /// Standard deviation that rounding leaves in every mean alike, input unit.
    pub rounding: [f64; 3],
}

/// What the static intervals show.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GyroRest {
    /// Reading at rest without gravity's part, input unit.
    pub bias: [f64; 3],
    /// Its standard deviation.
    pub bias_sd: [f64; 3],
    /// S, row-major: row gyroscope, column accelerometer, input unit per m/s²; zero where not
    /// significant.
    pub g_sensitivity: [[f64; 3]; 3],
    /// How far the bias of each static interval is off, as far as it is not noise.
    local: Vec<Vector3<f64>>,
    /// Standard deviation of what is left of that.
    local_sd: Vector3<f64>,
    /// The part of `bias_sd` that noise and rounding make: all that motions can tell of.
    noise_sd: Vector3<f64>,
}

/// What the motions leave open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GyroUndetermined {
    /// Axes about which they turn too little.
    pub axes: [bool; 3],
    /// Relative standard deviation of the matrix in its worst direction.
    pub sd: f64,
}

/// One motion under the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedMotion {
    /// It took part; it does not if it contradicts the others.
    pub used: bool,
    /// Length of the difference of unit vectors.
    pub residual: f64,
    /// The same if the motion takes no part; none if the others determine too little.
    pub left_out: Option<f64>,
}

/// The gyroscope by the motions.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionFit {
    /// G, row-major, rad/s per input unit; axes of the accelerometer.
    pub matrix: [[f64; 3]; 3],
    /// b, input unit.
    pub bias: [f64; 3],
    /// Covariance of the row-major M = G⁻¹ and b.
    pub covariance: [[f64; 12]; 12],
    /// Every motion given.
    pub motions: Vec<FittedMotion>,
    /// Angle by which a typical motion misses, of all motions, rad.
    pub typical_rad: f64,
}

/// The gyroscope.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroFit {
    /// At rest.
    pub rest: GyroRest,
    /// By the motions; none without motions, or where no scale is known and none is found.
    pub by_motions: Option<Result<MotionFit, GyroUndetermined>>,
}

/// Two residuals each for nine parameters, and three to judge them by.
pub const MIN_MOTIONS: usize = 6;
/// Known worse than this, a matrix is no better than the data sheet's.
const MAX_SD: f64 = 0.03;
/// A typical motion that misses by more was fitted from a wrong start, or not at all, rad.
pub const MISFIT_RAD: f64 = 3.0 * std::f64::consts::PI / 180.0;

/// Estimates the gyroscope. `accelerometer` calibrates the readings of the accelerometer to m/s²; an error
/// of it is in the covariance only as far as the residuals show it.
///
/// None without static intervals, if one has no duration, if a motion has no samples or is between others than
/// these intervals, or if a value is no number.
pub fn gyro(
    intervals: &[StaticInterval],
    motions: &[Motion],
    accelerometer: &LinearCalibration<f64>,
    options: &GyroOptions,
) -> Option<GyroFit> {
    let rest = at_rest(intervals, accelerometer, options)?;
    let path = |motion| path(motion, intervals, accelerometer, &rest);
    let paths = motions.iter().map(path).collect::<Option<Vec<Path>>>()?;
    let nominal = options.nominal.map(f64::recip);
    let unit = nominal.or_else(|| scale_by_motions(&paths));
    let unit = unit.filter(|unit| unit.is_normal() && !paths.is_empty());
    let by_motions = unit.map(|unit| {
        if paths.len() < MIN_MOTIONS {
            return Err(GyroUndetermined::NOTHING);
        }
        solve(&problem(paths, &rest, options, unit))
    });
    Some(GyroFit { rest, by_motions })
}

/// A motion in input units, less bias and g-sensitivity; `sd` by the directions of gravity.
fn path(
    motion: &Motion,
    intervals: &[StaticInterval],
    accelerometer: &LinearCalibration<f64>,
    rest: &GyroRest,
) -> Option<Path> {
    let (before, after) = (intervals.get(motion.before)?, intervals.get(motion.after)?);
    let sensitivity = Matrix3::from(rest.g_sensitivity).transpose();
    // The drift of the bias is what both static intervals show of it.
    let local = 0.5 * (rest.local[motion.before] + rest.local[motion.after]);
    let bias = Vector3::from(rest.bias) + local;
    let mut accel = before.accel;
    let mut sample = |s: &Sample| {
        if s.accel.iter().all(|v| v.is_finite()) {
            accel = s.accel;
        }
        let by_force = sensitivity * Vector3::from(accelerometer.apply(accel));
        (Vector3::from(s.rate) - bias - by_force, s.step_s)
    };
    let mut samples: Vec<(Vector3<f64>, f64)> = motion.samples.iter().map(&mut sample).collect();
    samples.last_mut()?.1 = 0.0;
    let directions = [before, after].map(|interval| direction(interval, accelerometer));
    let is_number = |s: &(Vector3<f64>, f64)| s.0.norm().is_finite() && s.1.is_finite();
    let is_whole = samples.iter().all(is_number);
    is_whole.then(|| Path {
        samples,
        gravity: directions.map(|d| d.0),
        sd: (0.5 * (directions[0].1 + directions[1].1)).sqrt(),
    })
}

/// Unit vector of gravity in a static interval, and the trace of its covariance.
fn direction(
    interval: &StaticInterval,
    accelerometer: &LinearCalibration<f64>,
) -> (Vector3<f64>, f64) {
    let force = Vector3::from(accelerometer.apply(interval.accel));
    let unit = force.normalize();
    let tangent = Matrix3::identity() - unit * unit.transpose();
    // nalgebra's arrays are columns.
    let of_reading = tangent * Matrix3::from(accelerometer.matrix).transpose() / force.norm();
    let spread = of_reading * Matrix3::from_diagonal(&interval.accel_sd.into());
    (unit, spread.norm_squared())
}

/// The motions in rad/s by `unit`, rad/s per input unit; noise and drift of the rate in their `sd`.
fn problem<'a>(
    mut motions: Vec<Path>,
    rest: &'a GyroRest,
    options: &GyroOptions,
    unit: f64,
) -> Problem<'a> {
    let mean_square = |v: Vector3<f64>| v.norm_squared() / 3.0 * unit.powi(2);
    let noise = mean_square(options.noise.into());
    let drift = mean_square(rest.local_sd);
    for motion in &mut motions {
        let seconds: f64 = motion.samples.iter().map(|s| s.1).sum();
        let own = noise * seconds.abs() + drift * seconds.powi(2) + FLOOR.powi(2);
        motion.sd = motion.sd.hypot(own.sqrt());
        motion.samples.iter_mut().for_each(|s| s.0 *= unit);
    }
    Problem {
        motions,
        rest,
        unit,
    }
}

fn solve(problem: &Problem<'_>) -> Result<MotionFit, GyroUndetermined> {
    let start = problem.start(&Matrix3::identity());
    // By noise alone: what the motions can determine at best.
    let weights = problem.weights(&vec![true; problem.motions.len()], 0.0);
    let expected = problem.solve(&start, &weights);
    check(&expected.ok_or(GyroUndetermined::NOTHING)?.covariance)?;
    let mut robust = problem.robust(start);
    if robust.as_ref().is_none_or(|r| r.typical > MISFIT_RAD) {
        // Perhaps the axes are not the accelerometer's.
        let starts = axes().map(|e| problem.start(&e));
        let best = starts.min_by(|a, b| a.typical.total_cmp(&b.typical));
        let other = best.and_then(|best| problem.robust(best));
        let both = [robust, other].into_iter().flatten();
        robust = both.min_by(|a, b| a.typical.total_cmp(&b.typical));
    }
    let settled = robust.and_then(|robust| problem.settle(robust));
    let (covariance, fit) = settled.ok_or(GyroUndetermined::NOTHING)?;
    check(&covariance)?;
    Ok(fit)
}

impl GyroUndetermined {
    /// As if there were no motion.
    const NOTHING: GyroUndetermined = GyroUndetermined {
        axes: [true; 3],
        sd: f64::INFINITY,
    };
}

/// Whether all nine elements are known to [`MAX_SD`] in every direction, and which axes lack a turn if not.
fn check(covariance: &Square) -> Result<(), GyroUndetermined> {
    let eigen = SymmetricEigen::new(covariance.fixed_view::<9, 9>(0, 0).into_owned());
    let mut load = [0.0; 3];
    let directions = eigen.eigenvectors.column_iter();
    for (value, direction) in eigen.eigenvalues.iter().zip(directions) {
        if *value > MAX_SD.powi(2) {
            (0..9).for_each(|p| load[p % 3] += value * direction[p].powi(2));
        }
    }
    let total: f64 = load.iter().sum();
    if total > 0.0 {
        return Err(GyroUndetermined {
            axes: load.map(|l| l > 0.1 * total),
            sd: eigen.eigenvalues.max().sqrt(),
        });
    }
    Ok(())
}

/// Rad/s per input unit, negative for a gyroscope that counts the other way round; axes as the
/// accelerometer's.
///
/// A motion about one fixed axis turns gravity so that v₁ − v₀ = f · (v₀ + v₁)/2 × ψ, ψ = ∫ω dt, f =
/// tan(|ψ|/2)/(|ψ|/2). The hand comes near enough to that for a start: the median over the motions that
/// turn gravity by more than noise and less than an unknown way, and that the formula fits within 25°.
fn scale_by_motions(paths: &[Path]) -> Option<f64> {
    let scale = |path: &Path| {
        let [from, to] = path.gravity;
        let integral: Vector3<f64> = path.samples.iter().map(|s| s.0 * s.1).sum();
        let change = to - from;
        let turned = (0.5 * (from + to)).cross(&integral);
        let along = change.dot(&turned);
        let fits = (8.0..160.0).contains(&from.angle(&to).to_degrees())
            && along.abs() > 0.9 * change.norm() * turned.norm();
        let length = integral.norm();
        let scale = 2.0 * (along / turned.norm_squared() * 0.5 * length).atan() / length;
        (fits && scale.is_normal()).then_some(scale)
    };
    let found: Vec<f64> = paths.iter().filter_map(scale).collect();
    Some(median(found)).filter(|m| m.is_finite())
}

/// The axes of the accelerometer in every order and sense.
fn axes() -> impl Iterator<Item = Matrix3<f64>> {
    (0..48).map(|n| {
        let (first, by) = (n / 8 % 3, 1 + n / 24);
        Matrix3::from_fn(|r, c| match (first + by * r) % 3 {
            axis if axis != c => 0.0,
            _ if n >> r & 1 == 0 => 1.0,
            _ => -1.0,
        })
    })
}
