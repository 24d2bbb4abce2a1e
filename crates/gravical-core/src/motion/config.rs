//! Configuration of a pipeline.

use crate::Real;
use crate::calibration::{Calibration, GyroscopeCalibration};
use crate::still::{Plan, RestNoise};

/// How gravity is taken off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Removal {
    /// The mean of the first samples is subtracted; nothing is rotated, the frame
    /// is the sensor's own.
    InitialMean,
    /// The tilt stays that of the rest before.
    ConstantTilt,
    /// The attitude is followed with the gyroscope from the rest before.
    Strapdown,
}

/// What the first rest is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FirstRest {
    /// So many samples at the start; at least 1.
    Samples(usize),
    /// The first one that is found or given. Nothing is known before it.
    Found,
}

/// What does not change on the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionConfig<T> {
    /// From the raw unit to m/s².
    pub accelerometer: Calibration<T>,
    /// From the raw unit to rad/s.
    pub gyroscope: GyroscopeCalibration<T>,
    /// How gravity is taken off.
    pub removal: Removal,
    /// What the first rest is. [`Removal::InitialMean`] needs samples.
    pub first_rest: FirstRest,
    /// Whether velocity is zero at rests after the first.
    pub zero_velocity: bool,
    /// What rests are found with, at the rate of the samples; none where they are
    /// given.
    pub rests: Option<(Plan, RestNoise<T>)>,
    /// Velocity after the first rest, m/s.
    pub velocity_mps: [T; 3],
    /// Position at the first rest, m.
    pub position_m: [T; 3],
    /// For the gate: standard uncertainty of the accelerometer's bias, m/s². 0.6 for
    /// an MPU6050 as it comes.
    pub bias_mps2: T,
    /// For the gate: that of the gyroscope's scale, relative. 0.03 as it comes.
    pub gyro_scale: T,
    /// For the gate: how far the sensor tilts in a move where no gyroscope is used,
    /// rad, standard deviation.
    pub tilt_change_rad: T,
}

impl<T: Real> MotionConfig<T> {
    /// The mean of the first `samples` off; no zero velocity. Readings are SI.
    #[must_use]
    pub fn initial_mean(samples: usize) -> Self {
        MotionConfig {
            removal: Removal::InitialMean,
            first_rest: FirstRest::Samples(samples),
            zero_velocity: false,
            ..Self::strapdown()
        }
    }

    /// The attitude by the gyroscope, velocity zero at the rests that are given; with
    /// [`rests`](Self::rests) at those that are found. Readings are SI.
    #[must_use]
    pub fn strapdown() -> Self {
        MotionConfig {
            accelerometer: Calibration::identity(),
            gyroscope: GyroscopeCalibration::identity(),
            removal: Removal::Strapdown,
            first_rest: FirstRest::Found,
            zero_velocity: true,
            rests: None,
            velocity_mps: [T::zero(); 3],
            position_m: [T::zero(); 3],
            bias_mps2: T::from_f64(0.6),
            gyro_scale: T::from_f64(0.03),
            tilt_change_rad: T::from_f64(0.01),
        }
    }
}
