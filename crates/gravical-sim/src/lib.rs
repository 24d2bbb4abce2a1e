//! A virtual MPU6050 with known parameters.
//!
//! The API is internal to gravical and may change.
//!
//! # Overview
//!
//! A scenario is converted to a path: attitude and position as functions of time, with gravity
//! (`Plan`). Angular rate and specific force are computed from this path, so the two
//! sensors are consistent. They are measured by a sensor with random errors drawn from the seed,
//! followed by a low-pass, a converter and a board's clock; the true values are returned as
//! [`Truth`].
//!
//! The same options give the same rows; every kind of random quantity (parameters, tilts, noise,
//! stamps, lost rows …) has its own random stream, so that changing one option leaves the others
//! unaffected.
//!
//! # Example
//!
//! ```
//! # mod gravical { pub use gravical_judge::Error; pub use gravical_sim as simulate; }
//! use gravical::simulate::{LineOptions, Scenario, SimulateOptions, simulate};
//!
//! let mut options = SimulateOptions::new(Scenario::Line(LineOptions::default()));
//! options.seed = 7;
//! let simulation = simulate(&options)?;
//! let line = &simulation.files[0];
//! assert_eq!(line.rows.len(), 1200);
//! assert_eq!(simulation.truth.files[0].moves[0].displacement_m[1], 0.7);
//! # Ok::<(), gravical::Error>(())
//! ```
#![deny(missing_docs)]

mod interactive;
mod options;
mod problem;
mod random;
mod record;
mod scenario;
mod sensor;
#[cfg(test)]
mod tests;
mod truth;

pub use interactive::InteractiveSensor;
pub use options::{
    FileOptions, LineOptions, PosesOptions, Scenario, SensorOptions, SimulateOptions,
    SixPositionOptions, StaticOptions,
};
pub use record::{Row, SimulatedFile, Simulation, simulate, simulate_to};
pub use sensor::Reading;
pub use truth::{
    AccelerometerTruth, FileTruth, GyroscopeTruth, MoveTruth, PoseKind, PoseTruth, Truth,
};
