//! Poses in, calibration out: estimation, and how far its result can be trusted.
//!
//! The API is internal to gravical and may change.
//!
//! # Overview
//!
//! Numbers only: no files, no rows, no units but those of the readings and SI, no words.
//!
//! 1. [`Pose`]: a mean reading at rest, and what is known of its direction.
//! 2. [`model`]: u = M a + b, and derivatives of what follows from it.
//! 3. [`fit`]: M and b with their covariance.
//! 4. [`Trust`], [`Grade`]: how far they can be trusted.
//! 5. [`gyro`]: the gyroscope from motions between rests.
//! 6. [`test_drift`], [`temperature`]: is a drift with temperature predictable?
//! 7. [`Sensor`]: a calibration as numbers, what its covariance says of ‖a‖.
//! 8. [`consistency`]: does a calibration still fit, and do two of them differ?
#![deny(missing_docs)]

mod bias_drift;
pub mod consistency;
mod fit;
mod gyro;
pub mod model;
mod nonlinearity;
mod pose;
mod rows;
mod search;
mod sensor;
mod sphere;
pub mod temperature;
mod trust;

pub use bias_drift::{DriftTest, test_drift};
pub use consistency::{SIGNIFICANCE, Test};
pub use fit::{BiasDrift, Fit, FitQuality, FittedPose, Options, Undetermined};
pub use gyro::{
    FittedMotion, GyroFit, GyroOptions, GyroRest, GyroUndetermined, MIN_MOTIONS, MISFIT_RAD,
    Motion, MotionFit, Sample, StaticInterval, gyro,
};
pub use nonlinearity::fit;
pub use pose::{Face, Hint, Pose, angle_deg};
pub use search::{Explained, Explanation};
pub use sensor::{
    Claim, Deviations, Gravity, Mounting, Sensor, WorstDirection, covariance_by_gravity,
    deviations, mounting,
};
pub use sphere::{Sphere, centre};
pub use trust::{
    Budget, CONTRADICTION, FAIR_MPS2, GOOD_MPS2, Grade, LeftOut, NextPose, Trust, UNVERIFIED_MPS2,
    Undetected, grade, is_open, rival,
};
