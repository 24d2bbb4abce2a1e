//! Turn a cheap IMU into an instrument you can trust.
//!
//! # Overview
//!
//! The stages of processing, one module each:
//!
//! 1. [`recording`] reads recordings in many formats and reports their faults; [`inspect`]
//!    summarises their contents.
//! 2. [`poses`] finds the static intervals and the face that was up in each.
//! 3. [`calibrate`] estimates the parameters and gives a verdict on their accuracy. Read it first: it contains the whole method in order.
//! 4. [`calibration_file`] stores them; [`apply`] calibrates recordings of any size with them,
//!    [`check`] determines whether one still fits new recordings, [`compare`] whether two of them
//!    differ by more than their uncertainty; [`export`] writes them as code or parameters for
//!    other programs.
//! 5. [`motion`](mod@motion) turns acceleration into attitude, velocity and position with their bands.
//! 6. [`denoise`] filters a recording and reports the effect on its noise; [`noise`] determines the
//!    noise itself.
//!
//! What is not shown here serves the program `gravical` and may change with every release, like the crates below it
//! (`gravical-judge`, `-recording`, `-signal`, `-fit`, `-motion`, `-calibrate`, `-live`, `-sim`).
//!
//! [`simulate`] computes recordings of a sensor with known parameters. Documents and figures of a
//! result are in the crate `gravical-report`, code for microcontrollers in `gravical-core`.
//!
//! # From six files to a calibration
//!
//! ```
//! use gravical::calibrate::{CalibrateOptions, calibrate};
//! use gravical::recording::ReadOptions;
//! use gravical::session::read_session;
//! # use gravical::simulate::{Scenario, SimulateOptions, SixPositionOptions, simulate_to};
//! # let folder = tempfile::tempdir()?;
//! # let options = SimulateOptions::new(Scenario::SixPosition(SixPositionOptions::default()));
//! # simulate_to(&options, &folder, false)?;
//! # let folder = folder.path().to_path_buf();
//!
//! // A folder with a recording a face, or any recordings at rest.
//! let (session, _) = read_session(&[folder.clone()], None, &ReadOptions::default())?;
//! let calibration = calibrate(&session, &CalibrateOptions::default())?.calibration;
//!
//! let accelerometer = &calibration.accelerometer;
//! let bias_sd = accelerometer.deviations().map(|d| d.bias);
//! println!("{}: bias {:?} ± {bias_sd:?}", calibration.grade(), accelerometer.bias);
//! for finding in &calibration.findings {
//!     println!("{}: {}", finding.kind, finding.message);
//! }
//! calibration.write(folder.join("cal.json"), false)?;
//! # assert_eq!(calibration.poses.len(), 6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Apply it
//!
//! ```
//! use gravical::apply::{ApplyOptions, apply_recording};
//! use gravical::calibration_file::Calibration;
//! use gravical::recording::{ReadOptions, read};
//! # use gravical::calibrate::{CalibrateOptions, calibrate};
//! # let temporary = tempfile::tempdir()?;
//! # let folder = temporary.path();
//! # let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
//! #            -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
//! # std::fs::write(folder.join("recording.csv"), csv)?;
//! # let means = read(folder.join("recording.csv"), &ReadOptions::default())?;
//! # calibrate(&[means], &CalibrateOptions::default())?.calibration.write(folder.join("cal.json"), false)?;
//!
//! let calibration = Calibration::read(folder.join("cal.json"))?;
//! let recording = read(folder.join("recording.csv"), &ReadOptions::default())?;
//! let applied = apply_recording(&calibration, &recording, &ApplyOptions::default())?;
//! let [x, y, z] = &applied.accel; // m/s²
//! println!("{} rows, the last {} {} {}", x.len(), x[5], y[5], z[5]);
//!
//! // One sample at a time, also on a microcontroller.
//! let one = calibration.accelerometer_calibration().apply([0.83, -0.18, 10.42]);
//! assert!((one[2] - 9.80665).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Where it went
//!
//! ```
//! use gravical::motion::{MotionOptions, motion};
//! use gravical::recording::{ReadOptions, read};
//! # use gravical::simulate::{LineOptions, Scenario, SimulateOptions, simulate_to};
//! # let temporary = tempfile::tempdir()?;
//! # let folder = temporary.path();
//! # let options = SimulateOptions::new(Scenario::Line(LineOptions::default()));
//! # simulate_to(&options, folder, false)?;
//!
//! let recording = read(folder.join("line.csv"), &ReadOptions::default())?;
//! let motion = motion(&recording, None, &MotionOptions::default())?;
//! for part in &motion.result.moves {
//!     println!("{:?} m ± {:?}", part.displacement_m, part.sigma_m);
//! }
//! let last = motion.samples().last();
//! # let moved = motion.result.moves[0].displacement_m.unwrap_or_default();
//! # assert!((moved[1] - 0.7).abs() < 0.1 && last.is_some());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Structs of options have defaults, and may get fields: write `..Default::default()`.
#![deny(missing_docs)]

pub mod apply;
#[doc(hidden)]
pub mod calibration_folder;
pub mod convert;
pub mod denoise;
#[doc(hidden)]
pub mod export;
pub mod finding;
pub mod inspect;
pub mod motion;
pub mod noise;
mod problem;
mod rewrite;
pub mod session;
#[doc(hidden)]
pub mod targets;

/// From the recordings of a session to a [`Calibration`](calibration_file::Calibration): read [`calibrate`](fn@calibrate::calibrate) first.
pub mod calibrate {
    #[doc(hidden)]
    pub use gravical_calibrate::calibrate::*;
    #[doc(inline)]
    pub use gravical_calibrate::calibrate::{
        CalibrateOptions, Calibrated, EstimateOptions, Prior, RecordOptions, calibrate,
    };
}

/// The calibration: what is computed, written to the file, read and shown.
pub mod calibration_file {
    #[doc(hidden)]
    pub use gravical_calibrate::calibration_file::*;
    #[doc(inline)]
    pub use gravical_calibrate::calibration_file::{
        Accelerometer, Budget, Calibration, ChannelDrift, Contribution, Covariance, Deviations,
        DriftVerdict, FitQuality, Grade, GravitySource, GyroMethod, Gyroscope, InputFile,
        InputRole, Method, MotionCounts, Mounting, NextPose, PoseKind, PoseResult, PoseTilt,
        RecordingTime, Reliability, SensorInfo, Source, TemperatureModel, TemperatureRange,
        TiltSource, Undetected, Verdict, WorstDirection, from_imucal, to_imucal,
    };
}

/// Whether a calibration still fits new recordings.
pub mod check {
    #[doc(inline)]
    pub use gravical_calibrate::check::{
        CheckOptions, CheckReport, Judgement, Side, StillCheck, Verdict, check,
    };
}

/// Whether two calibrations differ by more than their uncertainty.
pub mod compare {
    #[doc(inline)]
    pub use gravical_calibrate::compare::{
        Comparison, MagnitudeDifference, OrientationDifference, ParameterDifference, compare,
    };
}

/// Local gravity: given, from latitude and altitude, or standard.
pub mod gravity {
    #[doc(inline)]
    pub use gravical_calibrate::gravity::{Gravity, GravityOptions};
}

/// The static intervals of a session, and the face that was up in each.
pub mod poses {
    #[doc(hidden)]
    pub use gravical_calibrate::poses::*;
    #[doc(inline)]
    pub use gravical_calibrate::poses::{Pose, SegmentOptions, Segmentation, Turn, segment};
}

/// Recordings in many formats, and what was found in them.
pub mod recording {
    #[doc(hidden)]
    pub use gravical_calibrate::recording::*;
    #[doc(inline)]
    pub use gravical_calibrate::recording::{
        AccelScale, AccelUnit, Clock, ColumnsSpec, GyroScale, GyroUnit, JoinedFile, Labels, Ledger,
        Meter, Origin, Progress, ReadOptions, Reason, Recording, TableColumn, TimeUnit, Units,
        join_gyroscope, read, read_bytes,
    };
}

#[doc(hidden)]
pub use gravical_calibrate::temperature;
#[doc(hidden)]
pub use gravical_recording::output;
#[doc(hidden)]
pub use gravical_recording::output::TOOL;

/// The part that runs on a microcontroller, too: calibrations and filters of one sample,
/// closed-form estimation.
pub use gravical_core as core;
#[doc(hidden)]
pub use gravical_fit as fit;
pub use gravical_judge::{Category, Error, Location, Result, utc};
#[doc(hidden)]
pub use gravical_judge::{errors, escape, numfmt};
/// Guided calibration: a recording that grows and commands in, events out.
pub use gravical_live as live;
/// A virtual sensor with known parameters.
pub use gravical_sim as simulate;

/// The programs of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
