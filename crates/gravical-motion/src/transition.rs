//! From a node to the next: strapdown integration, and what it does to errors.

use std::ops::Range;

use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};

use crate::noise::{Density, Noise};
use crate::options::{Directions, MotionOptions};
use crate::state::{
    ATTITUDE, Derivatives, FORCE_BIAS, FORCE_PARAMETERS, GRAVITY, MOVING, Nominal, POSITION,
    RATE_BIAS, RATE_PARAMETERS, VELOCITY, by_element, set_rows,
};
use gravical_signal::Samples;

/// What of the bend of the force between three samples, (h/12) Δ²f, a mean over the period leaves out where the sensor
/// does not decimate. Without it bands of simulated knocks hold 0.92 of the truths, with all of it they are 2.7 times
/// too wide.
const UNRESOLVED: f64 = 0.7;
/// Nonlinearity of a gyroscope, of the rate: 0.2 % (data sheet of the MPU-6050), and for how long its error stays the
/// same, s: a hand turns one way for so long.
const NONLINEARITY: f64 = 2e-3;
const ONE_WAY_S: f64 = 0.5;
/// What may happen in a gap, m/s² and rad/s: a hand.
const GAP_FORCE_MPS2: f64 = 3.0;
const GAP_RATE_RAD_S: f64 = 1.0;
/// An interruption of unknown length counts as a gap that long, s: enough that no rest after it is doubted.
const INTERRUPTED_S: f64 = 1.0;
/// A rate that noise makes, rad/s: what turns slower does not turn.
const MIN_TURN_RAD_S: f64 = 0.03;
/// Standard deviation of the tilt that a move without a gyroscope may have, degrees, and the time over which it
/// has that, s.
const TILT_DEG: f64 = 0.5;
const TILT_S: f64 = 10.0;
/// A table does not tilt, but it turns: what a move without a gyroscope turns about the vertical, over
/// its tilt.
const YAW_OVER_TILT: f64 = 20.0;

/// Error propagation over one node: x(end) = F x(start) + w, covariance of w Q.
#[derive(Debug, Clone)]
pub(crate) struct Transition {
    /// The first nine rows of F; the others are those of the identity.
    pub f: Derivatives,
    /// Covariance of position, velocity and attitude by the noise of both sensors.
    pub q: SMatrix<f64, MOVING, MOVING>,
    /// The part of it that comes from the angular rate.
    pub q_rate: SMatrix<f64, MOVING, MOVING>,
    /// Time from start to end, s.
    pub seconds: f64,
    /// Angle turned beyond noise, rad.
    pub turned_rad: f64,
}

/// Sums over the samples of a node.
#[derive(Default)]
struct Sums {
    /// ∫ [f×] dt, world.
    force: Matrix3<f64>,
    /// ∫ R dt.
    attitude: Matrix3<f64>,
    /// ∫ R M f dt and ∫ R M ω dt of the readings, by the elements of M.
    by_force: SMatrix<f64, 3, 9>,
    by_rate: SMatrix<f64, 3, 9>,
    /// Variance of the velocity (sensor axes) by what samples do not resolve, of the attitude by nonlinearity.
    unresolved: Vector3<f64>,
    nonlinear: f64,
}

/// What the filter knows besides its state.
#[derive(Clone, Copy)]
pub(crate) struct Model<'a> {
    pub samples: &'a Samples,
    pub options: &'a MotionOptions,
    pub directions: &'a Directions,
    pub noise: &'a Noise,
}

impl Model<'_> {
    /// Integrates samples `span.start` to `span.end`, that one included, into `nominal` ([`mean_over_step`]), and
    /// its errors to first order. `added_noise` is noise beyond that of the rests, world axes.
    pub fn step(
        &self,
        nominal: &mut Nominal,
        span: Range<usize>,
        added_noise: &Density,
    ) -> Transition {
        let samples = self.samples;
        let correction = nominal.correction(self.directions);
        let start = nominal.attitude;
        let mut sums = Sums::default();
        let mut turned_rad = 0.0;
        // Without a gyroscope nothing turns.
        let rate_at = |i: usize| {
            let reading = samples.rate_rad_s.get(i);
            reading.map_or_else(Vector3::zeros, |reading| correction.rate(reading))
        };
        let mut rate = rate_at(span.start);
        let mut force = correction.force(&samples.force_mps2[span.start]);
        for i in span.clone() {
            let h = samples.time_s[i + 1] - samples.time_s[i];
            let [next_rate, next_force] =
                [rate_at(i + 1), correction.force(&samples.force_mps2[i + 1])];
            let mean_rate = mean_over_step(&[rate, next_rate], h, samples.period_s);
            let mean_force = mean_over_step(&[force, next_force], h, samples.period_s);
            let angle = turn(&[rate, next_rate], h, samples.period_s);
            let middle = nominal.attitude * Rotation3::new(angle * 0.5).into_inner();
            let mean_force = middle * mean_force;
            let acceleration = mean_force - Vector3::new(0.0, 0.0, nominal.gravity);
            nominal.position += nominal.velocity * h + acceleration * (0.5 * h * h);
            nominal.velocity += acceleration * h;

            let speed = mean_rate.norm();
            turned_rad += (speed - MIN_TURN_RAD_S).max(0.0) * h;
            sums.nonlinear += (NONLINEARITY * speed).powi(2) * ONE_WAY_S * h;
            sums.force += mean_force.cross_matrix() * h;
            sums.attitude += middle * h;
            let turn = middle * h;
            sums.by_force += by_element(&turn, &Vector3::from(samples.force_mps2[i + 1]));
            sums.by_rate += by_element(&turn, &mean_rate);
            if i > 0 {
                sums.unresolved += self.unresolved(i, h);
            }
            nominal.attitude *= Rotation3::new(angle).into_inner();
            (rate, force) = (next_rate, next_force);
        }
        let seconds = samples.time_s[span.end] - samples.time_s[span.start];
        let (q, q_rate) = self.process_noise(&span, &start, &sums, seconds, added_noise);
        Transition {
            f: self.derivatives(&sums, seconds),
            q,
            q_rate,
            seconds,
            turned_rad,
        }
    }

    /// Variance of the velocity by what sample `i` does not resolve.
    fn unresolved(&self, i: usize, h: f64) -> Vector3<f64> {
        let f = &self.samples.force_mps2;
        let factor = h.min(2.0 * self.samples.period_s) / 12.0 * UNRESOLVED;
        Vector3::from_fn(|c, _| ((f[i + 1][c] - 2.0 * f[i][c] + f[i - 1][c]) * factor).powi(2))
    }

    /// The first nine rows of F (Solà, eq. 269 for the world frame, integrated over the node).
    fn derivatives(&self, sums: &Sums, seconds: f64) -> Derivatives {
        let half = 0.5 * seconds;
        let mut f = Derivatives::identity();
        let moved = Matrix3::<f64>::identity() * seconds;
        set_rows(&mut f, (POSITION, VELOCITY), &moved);
        set_rows(&mut f, (POSITION, ATTITUDE), &(-sums.force * half));
        set_rows(&mut f, (VELOCITY, ATTITUDE), &-sums.force);
        set_rows(&mut f, (POSITION, FORCE_BIAS), &(-sums.attitude * half));
        set_rows(&mut f, (VELOCITY, FORCE_BIAS), &-sums.attitude);
        let tilted = sums.force * sums.attitude;
        set_rows(&mut f, (POSITION, RATE_BIAS), &(tilted * (half / 3.0)));
        set_rows(&mut f, (VELOCITY, RATE_BIAS), &(tilted * 0.5));
        set_rows(&mut f, (ATTITUDE, RATE_BIAS), &-sums.attitude);
        f[(VELOCITY + 2, GRAVITY)] = -seconds;
        f[(POSITION + 2, GRAVITY)] = -seconds * half;
        let Directions { force, rate, .. } = self.directions;
        let attitude = sums.by_rate * rate;
        let velocity = sums.force * attitude * -0.5;
        let position = velocity * (seconds / 3.0);
        set_rows(&mut f, (POSITION, RATE_PARAMETERS), &position);
        set_rows(&mut f, (VELOCITY, RATE_PARAMETERS), &velocity);
        set_rows(&mut f, (ATTITUDE, RATE_PARAMETERS), &attitude);
        let by_matrix = sums.by_force * force.fixed_rows::<9>(0);
        let velocity = by_matrix + sums.attitude * force.fixed_rows::<3>(9);
        set_rows(&mut f, (POSITION, FORCE_PARAMETERS), &(velocity * half));
        set_rows(&mut f, (VELOCITY, FORCE_PARAMETERS), &velocity);
        f
    }

    /// Process noise: white noise of both sensors, and what was interpolated, bent or missing.
    fn process_noise(
        &self,
        span: &Range<usize>,
        start: &Matrix3<f64>,
        sums: &Sums,
        seconds: f64,
        added_noise: &Density,
    ) -> (SMatrix<f64, 9, 9>, SMatrix<f64, 9, 9>) {
        let mut unmeasured = self.unmeasured(span);
        unmeasured.force += sums.unresolved;
        let white = |rest: &Vector3<f64>, unmeasured: &Vector3<f64>, added_noise: &Vector3<f64>| {
            start * Matrix3::from_diagonal(&(rest * seconds + unmeasured)) * start.transpose()
                + Matrix3::from_diagonal(&(added_noise * seconds))
        };
        let noise = &self.noise.rest;
        let force = white(&noise.force, &unmeasured.force, &added_noise.force);
        let mut tilts = added_noise.rate;
        if !self.samples.has_gyro() {
            let density = TILT_DEG.to_radians().powi(2) / TILT_S;
            tilts += Vector3::new(density, density, density * YAW_OVER_TILT.powi(2));
        }
        let rate =
            white(&noise.rate, &unmeasured.rate, &tilts) + Matrix3::identity() * sums.nonlinear;
        let mut q = SMatrix::<f64, 9, 9>::zeros();
        let cross = -sums.force * rate * 0.5;
        set_rows(&mut q, (ATTITUDE, ATTITUDE), &rate);
        set_rows(&mut q, (VELOCITY, ATTITUDE), &cross);
        set_rows(&mut q, (ATTITUDE, VELOCITY), &cross.transpose());
        let by_rate = sums.force * rate * sums.force.transpose() / 3.0;
        set_rows(&mut q, (VELOCITY, VELOCITY), &by_rate);
        let q_rate = q;
        let [moved, moved_twice] = [seconds / 2.0, seconds * seconds / 3.0].map(|t| force * t);
        set_rows(&mut q, (VELOCITY, VELOCITY), &(by_rate + force));
        set_rows(&mut q, (POSITION, VELOCITY), &moved);
        set_rows(&mut q, (VELOCITY, POSITION), &moved);
        set_rows(&mut q, (POSITION, POSITION), &moved_twice);
        (q, q_rate)
    }

    /// Variances of velocity and attitude by what interpolations may be off, at the node that holds their end, and by what
    /// may have happened in gaps.
    fn unmeasured(&self, span: &Range<usize>) -> Density {
        let mut variance = Density::default();
        for (interpolated, sd) in self.samples.interpolated_in(span) {
            let sensor = if interpolated.channel < 3 {
                &mut variance.force
            } else {
                &mut variance.rate
            };
            sensor[interpolated.channel % 3] += sd * sd;
        }
        for (seconds, interrupted) in self.samples.gaps(span) {
            let least_s = if interrupted { INTERRUPTED_S } else { 0.0 };
            let seconds = seconds.max(least_s);
            variance.force += Vector3::repeat((GAP_FORCE_MPS2 * seconds).powi(2));
            if self.samples.has_gyro() {
                variance.rate += Vector3::repeat((GAP_RATE_RAD_S * seconds).powi(2));
            }
        }
        variance
    }
}

/// Mean of a rate, rad/s, or a force, m/s², over a step of `step_s` seconds between two samples.
///
/// A sample is the mean over the period before its stamp, as decimation makes it: so is that over a step of one period.
/// What a longer step has beyond a period is half-way between its samples; of a shorter one nobody knows more than the
/// later sample. Attitude and velocity are then those of the
/// stamp. Of simulated sensors (test `attitude_and_velocity_are_those_of_the_stamp`) they are exact for decimation, for
/// a low-pass filter that is sampled at two to four times its −3 dB between 0.19 periods early and 0.40 late, and half a
/// period early without any filter, which no sensor should be: it is aliased. Taken for values at their stamps
/// (trapezoid) all are half a period later. Neither drifts, since that is half a period of the last sample.
pub(crate) fn mean_over_step(pair: &[Vector3<f64>; 2], step_s: f64, period_s: f64) -> Vector3<f64> {
    pair[0].lerp(&pair[1], 0.5 * (1.0 + (period_s / step_s).min(1.0)))
}

/// Rotation vector of a step of `h` seconds between two rates (with Savage's two-sample coning term, J. Guid.
/// Control Dyn. 21(1), 1998, eq. 32).
pub(crate) fn turn(rate: &[Vector3<f64>; 2], h: f64, period_s: f64) -> Vector3<f64> {
    mean_over_step(rate, h, period_s) * h + rate[0].cross(&rate[1]) * (h * h / 12.0)
}
