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
//! assert_eq!(line.t_s.len(), 1200);
//! assert_eq!(simulation.truth.files[0].moves[0].displacement_m[1], 0.7);
//! # Ok::<(), gravical::Error>(())
//! ```

mod builder;
mod interactive;
#[doc(hidden)]
mod options;
mod part;
mod path;
mod poses;
mod random;
mod range;
mod record;
mod scenario;
mod scenario_options;
mod sensor;
#[cfg(test)]
mod tests;
mod truth;
mod write;

pub use interactive::{InteractiveReading, InteractiveSensor};
pub use options::{FileOptions, SensorOptions, SimulateOptions};
#[doc(hidden)]
pub use poses::spread_directions;
pub use scenario_options::{
    LineOptions, PosesOptions, Scenario, SixPositionOptions, SoakOptions, StaticOptions,
};
pub use truth::{
    AccelerometerTruth, FileTruth, GyroscopeTruth, MoveTruth, PoseKind, PoseTruth, TRUTH_FORMAT,
    Truth, TurnTruth,
};
pub use write::simulate_to;

use crate::Result;

/// Largest number of rows in memory (28 h at 100 Hz, 0.8 GB), and in files; more are assumed to be a
/// mistake.
const MOST_ROWS: usize = 10_000_000;
const MOST_WRITTEN: usize = 1_000_000_000;

/// Seconds between two recordings of one simulation; the part stays switched on and continues to
/// warm up.
const BETWEEN_FILES_S: f64 = 10.0;

/// Simulated recordings and their true values.
#[derive(Debug, Clone)]
pub struct Simulation {
    /// The recordings, in chronological order.
    pub files: Vec<SimulatedFile>,
    /// The true values; `truth.files` corresponds to `files`.
    pub truth: Truth,
}

/// One recording, as columns of equal length.
#[derive(Debug, Clone)]
pub struct SimulatedFile {
    /// File name, `x_axis_pos.csv` ….
    pub name: String,
    /// True time of each row, s since the first row. The signal is older by the delay of the
    /// low-pass (5.1 ms at 44 Hz).
    pub t_s: Vec<f64>,
    /// Time stamp of the board, ms.
    pub stamp_ms: Vec<u64>,
    /// Reading x, y, z of the accelerometer, m/s².
    pub accel_mps2: [Vec<f64>; 3],
    /// Reading x, y, z of the gyroscope, rad/s.
    pub gyro_rad_s: [Vec<f64>; 3],
    /// Reading of the thermometer, °C.
    pub temperature_c: Vec<f64>,
    /// True at rest (by the path, not by the delayed signal).
    pub still: Vec<bool>,
}

/// Simulates `options.scenario`.
///
/// # Errors
///
/// `simulate-option` (usage) for an option out of its range, or for more than ten million rows in
/// total; [`simulate_to`] writes more.
pub fn simulate(options: &SimulateOptions) -> Result<Simulation> {
    let (sensor, plans) = planned(options, MOST_ROWS)?;
    let mut files = Vec::with_capacity(plans.len());
    let mut file_truths = Vec::with_capacity(plans.len());
    let mut on_s = 0.0;
    for (index, plan) in plans.into_iter().enumerate() {
        let mut file = SimulatedFile::empty(&plan, record::row_count(&plan.path, options));
        let recorded = record::record(&plan.path, &sensor, options, index, on_s, |row| {
            file.push(row);
            Ok(())
        })?;
        on_s += plan.path.duration_s() + BETWEEN_FILES_S;
        file_truths.push(file_truth(plan, &recorded));
        files.push(file);
    }
    let truth = truth_of(&sensor, options, file_truths);
    Ok(Simulation { files, truth })
}

/// The sensor and the recordings, if these have no more than `most` rows together.
fn planned(options: &SimulateOptions, most: usize) -> Result<(sensor::Sensor, Vec<builder::Plan>)> {
    options.validate()?;
    let plans = scenario::plan(options);
    let rows: usize = plans
        .iter()
        .map(|p| record::row_count(&p.path, options))
        .sum();
    if rows > most {
        return Err(range::bad(format!(
            "{rows} rows; {most} at most: lower the rate or the duration"
        )));
    }
    Ok((sensor::Sensor::draw(options), plans))
}

fn file_truth(plan: builder::Plan, recorded: &record::Recorded) -> FileTruth {
    FileTruth {
        name: plan.name,
        rows: recorded.rows,
        dropped_rows: recorded.dropped_rows,
        clipped_rows: recorded.clipped_rows,
        first_stamp_ms: recorded.first_stamp_ms,
        poses: plan.poses,
        turns: plan.turns,
        moves: plan.moves,
    }
}

impl SimulatedFile {
    fn empty(plan: &builder::Plan, rows: usize) -> Self {
        let column = || Vec::with_capacity(rows);
        SimulatedFile {
            name: plan.name.clone(),
            t_s: column(),
            stamp_ms: Vec::with_capacity(rows),
            accel_mps2: std::array::from_fn(|_| column()),
            gyro_rad_s: std::array::from_fn(|_| column()),
            temperature_c: column(),
            still: Vec::with_capacity(rows),
        }
    }

    fn push(&mut self, row: &record::Row) {
        self.t_s.push(row.t_s);
        self.stamp_ms.push(row.stamp_ms);
        for axis in 0..3 {
            self.accel_mps2[axis].push(row.reading.accel[axis]);
            self.gyro_rad_s[axis].push(row.reading.gyro[axis]);
        }
        self.temperature_c.push(row.reading.temperature_c);
        self.still.push(row.still);
    }
}

fn truth_of(sensor: &sensor::Sensor, options: &SimulateOptions, files: Vec<FileTruth>) -> Truth {
    Truth {
        format: TRUTH_FORMAT.to_owned(),
        tool: crate::TOOL.to_owned(),
        seed: options.seed,
        gravity_mps2: options.gravity_mps2,
        accelerometer: sensor.accel_truth(options),
        gyroscope: sensor.gyro_truth(options),
        files,
        options: options.clone(),
    }
}
