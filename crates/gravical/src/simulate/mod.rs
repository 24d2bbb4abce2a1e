//! A virtual MPU6050 with known parameters.
//!
//! # Overview
//!
//! A scenario is converted to a path: attitude and position as functions of time, with gravity
//! (`MotionPath`). Angular rate and specific force are computed from this path, so the two
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

mod interactive;
mod options;
mod random;
mod record;
mod scenario;
mod sensor;
#[cfg(test)]
mod tests;
mod truth;
mod write;

pub use interactive::InteractiveSensor;
pub use options::{
    FileOptions, LineOptions, PosesOptions, Scenario, SensorOptions, SimulateOptions,
    SixPositionOptions, StaticOptions,
};
pub use record::Row;
pub use sensor::Reading;
pub use truth::{
    AccelerometerTruth, FileTruth, GyroscopeTruth, MoveTruth, PoseKind, PoseTruth, Truth,
};
pub use write::simulate_to;

use crate::Result;

/// Largest number of rows in memory (28 h at 100 Hz, 0.8 GB), and in files; more are assumed to be a
/// mistake.
const MAX_ROWS: usize = 10_000_000;
const MAX_WRITTEN: usize = 1_000_000_000;

/// Simulated recordings and their true values.
#[derive(Debug, Clone)]
pub struct Simulation {
    /// The recordings, in chronological order.
    pub files: Vec<SimulatedFile>,
    /// The true values; `truth.files` corresponds to `files`.
    pub truth: Truth,
}

/// One recording.
#[derive(Debug, Clone)]
pub struct SimulatedFile {
    /// File name, `x_axis_pos.csv` ….
    pub name: String,
    /// Its rows.
    pub rows: Vec<Row>,
}

/// Simulates `options.scenario`.
///
/// # Errors
///
/// `simulate-option` (usage) for an option out of its range, or for more than ten million rows in
/// total; [`simulate_to`] writes more.
pub fn simulate(options: &SimulateOptions) -> Result<Simulation> {
    let (mut truth, plans) = planned(options, MAX_ROWS)?;
    let mut files = Vec::with_capacity(plans.len());
    for (index, plan) in plans.iter().enumerate() {
        let mut rows = Vec::with_capacity(record::row_count(plan, options));
        let file = record::record(plan, options, index, |row| {
            rows.push(*row);
            Ok(())
        })?;
        files.push(SimulatedFile {
            name: file.name.clone(),
            rows,
        });
        truth.files.push(file);
    }
    Ok(Simulation { files, truth })
}

/// The truth without recordings, and the recordings, if these have no more than `max` rows together.
fn planned(options: &SimulateOptions, max: usize) -> Result<(Truth, Vec<scenario::Plan>)> {
    options.validate()?;
    let plans = scenario::plan(options);
    let rows: usize = plans.iter().map(|p| record::row_count(p, options)).sum();
    if rows > max {
        return Err(options::bad(format!(
            "{rows} rows; {max} at most: lower the rate or the duration"
        )));
    }
    Ok((Truth::draw(options), plans))
}
