//! What an estimate of motion holds.

use std::ops::Range;

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, UnitQuaternion, Vector3};

use serde::Serialize;

use crate::closure::Closure;
use crate::filter::Node;
use crate::noise::NoiseAtRest;
use crate::state::{ATTITUDE, MOVING, POSITION, VELOCITY};
use crate::unusable::Unusable;

/// Relative error of the clock.
pub(crate) const CLOCK_SD: f64 = 1e-3;
/// ∫ s̈² dτ of the minimum-jerk path s of length 1 in time 1 (Flash and Hogan 1985).
const MINIMUM_JERK_ENERGY: f64 = 120.0 / 7.0;
/// What is found of simulated moves of 0.5 to 8 s: what a matched filter sees at so many standard deviations.
const VISIBLE_SD: f64 = 15.0;
/// A steady travel is found by its ramps: simulated ones of half a second at so many standard deviations of the
/// velocity.
const VISIBLE_RAMP_SD: f64 = 10.0;
const RAMP_S: f64 = 0.5;

/// Root of a variance that rounding may have left below zero; what is no number stays none.
pub(crate) fn deviation(variance: f64) -> f64 {
    if variance < 0.0 { 0.0 } else { variance.sqrt() }
}

/// How velocity is tied down at the ends of a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ends {
    /// A rest before and after.
    RestToRest,
    /// A rest before; the recording ends in motion, or zero velocity is off.
    FromRest,
    /// A rest after; the recording starts in motion.
    ToRest,
    /// No rest at either end.
    #[default]
    Free,
}

/// Standard deviations that parts of the uncertainty contribute to a displacement, m; squares add up.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Budget {
    /// Noise of the accelerometer, in the move and at the rests that level it; what the move was rougher; the
    /// velocity of a foot in its stances; the clock.
    pub noise: [f64; 3],
    /// Calibration and gravity.
    pub calibration: [f64; 3],
    /// Attitude in the move: noise and unsteady scale of the gyroscope, or the tilts that a move without one
    /// may have.
    pub attitude: [f64; 3],
}

impl Budget {
    /// Of the total, calibration and attitude: what the latter leave is noise.
    pub(crate) fn new(covariances: [Matrix3<f64>; 3]) -> Budget {
        let [total, calibration, attitude] = covariances.map(|c| c.diagonal());
        let calibration = calibration.inf(&total);
        let attitude = attitude.inf(&(total - calibration));
        let part = |variance: Vector3<f64>| variance.map(deviation).into();
        Budget {
            noise: part(total - calibration - attitude),
            calibration: part(calibration),
            attitude: part(attitude),
        }
    }
}

/// One move.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Move {
    /// From its first to its last sample, that one included in the integral.
    pub samples: Range<usize>,
    /// Displacement, m: x, y level in the directions of the first rest, z up.
    pub displacement_m: [f64; 3],
    /// Its standard deviations, m.
    pub sd_m: [f64; 3],
    /// That of its length, m.
    pub along_sd_m: f64,
    /// What contributes to it.
    pub budget: Budget,
    /// What lies at its ends.
    pub ends: Ends,
    /// What the rest that ends it says of it.
    pub closure: Option<Closure>,
    /// Steps of a foot in it that ended its drift.
    pub stances: usize,
    /// Runs of clipped or spiked rows in it.
    pub replaced: usize,
    /// Why its displacement is not known; none if it is, to its deviations.
    pub unusable: Option<Unusable>,
}

/// State of the motion at a sample.
#[derive(Debug, Clone, PartialEq)]
pub struct PathNode {
    /// The sample.
    pub sample: usize,
    /// Position from the start of the recording, m, and its standard deviations.
    pub position_m: [f64; 3],
    /// See `position_m`.
    pub position_sd_m: [f64; 3],
    /// Velocity, m/s, and its standard deviations.
    pub velocity_mps: [f64; 3],
    /// See `velocity_mps`.
    pub velocity_sd_mps: [f64; 3],
    /// Attitude, sensor → world, quaternion w, x, y, z.
    pub attitude: [f64; 4],
    /// Standard deviations of its rotation about each axis of the world, rad: tilt, and heading about z.
    pub attitude_sd_rad: [f64; 3],
}

impl PathNode {
    /// The node with its estimated error and covariance.
    pub(crate) fn new(
        node: &Node,
        error: &SVector<f64, MOVING>,
        covariance: &SMatrix<f64, MOVING, MOVING>,
    ) -> Self {
        let part = |at: usize| error.fixed_rows::<3>(at).into_owned();
        let nominal = &node.nominal;
        let position = nominal.position + part(POSITION);
        let velocity = nominal.velocity + part(VELOCITY);
        // With the error of the clock, which is the same for the whole recording: lengths go with its square.
        let sd = |at: usize, values: &Vector3<f64>, clock_sd: f64| {
            let sd = |c: usize| deviation(covariance[(at + c, at + c)]);
            std::array::from_fn(|c| sd(c).hypot(clock_sd * values[c]))
        };
        let attitude =
            Rotation3::new(part(ATTITUDE)) * Rotation3::from_matrix_unchecked(nominal.attitude);
        let attitude = UnitQuaternion::from_rotation_matrix(&attitude);
        PathNode {
            sample: node.sample,
            position_m: position.into(),
            position_sd_m: sd(POSITION, &position, 2.0 * CLOCK_SD),
            velocity_mps: velocity.into(),
            velocity_sd_mps: sd(VELOCITY, &velocity, CLOCK_SD),
            attitude: [attitude.w, attitude.i, attitude.j, attitude.k],
            attitude_sd_rad: [0, 1, 2].map(|c| deviation(covariance[(ATTITUDE + c, ATTITUDE + c)])),
        }
    }

    /// As the filter knows it.
    pub(crate) fn forward(node: &Node) -> Self {
        let covariance = node.rows.fixed_columns::<MOVING>(0).into_owned();
        PathNode::new(node, &SVector::zeros(), &covariance)
    }
}

/// Motion of a recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// Rests, in samples. Without one nothing else is known.
    pub rests: Vec<Range<usize>>,
    /// Noise of the rests; none without rests.
    pub noise: Option<NoiseAtRest>,
    /// The moves, in order.
    pub moves: Vec<Move>,
    /// Nodes in order of time, at most 0.1 s apart in moves.
    pub path: Vec<PathNode>,
}

impl Motion {
    /// Displacement along an axis, m, that a smooth move of `duration_s` may have and hide within a rest:
    /// 15 σ of a matched filter, which simulated moves of 0.5 to 8 s need to be found. None without rests. It does
    /// not hold where the rests were given.
    pub fn hidden_displacement_m(&self, duration_s: f64) -> Option<f64> {
        Some(hidden_displacement_m(self.density()?, duration_s))
    }

    /// Speed along an axis, m/s, below which a steady travel with ramps of half a second may look like a rest. None
    /// without rests.
    pub fn hidden_speed_mps(&self) -> Option<f64> {
        Some(VISIBLE_RAMP_SD * self.density()? * RAMP_S.sqrt())
    }

    /// Noise of the noisiest axis, m/s²/√Hz.
    fn density(&self) -> Option<f64> {
        Some(self.noise?.accel_n.into_iter().fold(0.0, f64::max))
    }
}

/// That of noise of so many m/s²/√Hz.
pub(crate) fn hidden_displacement_m(density: f64, duration_s: f64) -> f64 {
    VISIBLE_SD * density * (duration_s.powi(3) / MINIMUM_JERK_ENERGY).sqrt()
}
