//! The virtual board: computes the rows of a recording from a path, in memory or into a file.
//!
//! The sensor is simulated at about 1 kHz, including its low-pass for signal and noise, and every
//! k-th value is read out. Neighbouring samples are therefore correlated as in the real part, and
//! the noise density at low frequencies is the given one at every rate.

use std::path::{Path, PathBuf};

use rand::RngExt;

use crate::options::{FileOptions, SimulateOptions};
use crate::problem::Problem;
use crate::random::{Purpose, stream, uniform};
use crate::scenario::{self, Plan};
use crate::sensor::{
    ACCEL_NOISE_MPS_RTS, GYRO_NOISE_DEG_RTS, LOW_PASS_HZ, Part, Reading, temperature_counts,
};
use crate::truth::{FileTruth, Truth};
use gravical_judge::{Error, Result};
use gravical_recording::output::{check_target, make_folder, write_atomic, write_text};

/// The lowest rate of the internal simulation of the sensor, Hz.
pub(crate) const INSIDE_HZ: f64 = 1000.0;

/// Largest number of rows in memory (28 h at 100 Hz, 0.8 GB), and in files; more are assumed to be a
/// mistake.
const MAX_ROWS: usize = 10_000_000;
const MAX_WRITTEN: usize = 1_000_000_000;

/// The header of the student report's logger, verbatim. It is wrong: the values under it are in m/s² and
/// rad/s.
const WRONG_HEADER: &str = "Timestamp,aX (g),aY (g),aZ (g),Temp (C),gX (°/s),gY (°/s),gZ (°/s)";
const RAW_HEADER: &str = "Timestamp (ms),ax,ay,az,temp,gx,gy,gz";

/// A row of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Time stamp of the board, ms. The signal is older by the delay of the low-pass (5.1 ms at 44 Hz).
    pub stamp_ms: u64,
    /// What the board read.
    pub reading: Reading,
}

/// Number of rows before any are lost.
fn row_count(plan: &Plan, options: &SimulateOptions) -> usize {
    // Tolerance for rounding, so that 10 s at 100 Hz are 1000 rows.
    (plan.duration_s() * options.rate_hz + 1e-6).floor() as usize
}

/// Records a plan, each row by `each`. `file` is the index of the recording (their noise differs).
fn record(
    plan: &Plan,
    options: &SimulateOptions,
    file: usize,
    mut each: impl FnMut(&Row) -> Result<()>,
) -> Result<FileTruth> {
    let per_row = (INSIDE_HZ / options.rate_hz).ceil() as usize;
    let step_s = 1.0 / (options.rate_hz * per_row as f64);
    let mut part = Part::new(options, step_s, file, plan, warmer_c(options, plan.on_s));
    let mut drops = stream(options.seed, Purpose::Drops, file);
    let mut stamps = stream(options.seed, Purpose::Stamps, file);
    let mut truth = FileTruth {
        // Opening the port resets the board; the first line follows after its setup.
        first_stamp_ms: stamps.random_range(100..300),
        ..plan.truth.clone()
    };
    for row in 0..row_count(plan, options) {
        let t_s = row as f64 / options.rate_hz;
        let warm_c = warmer_c(options, plan.on_s + t_s);
        let before = if row == 0 { per_row } else { 1 };
        for step in before..per_row {
            let t_s = ((row - 1) * per_row + step) as f64 * step_s;
            part.update(plan, t_s, warm_c);
        }
        let reading = part.read(plan, t_s, warm_c);
        let jitter_ms = options.stamp_jitter_ms * uniform(&mut stamps);
        let board_ms = truth.first_stamp_ms as f64 + row as f64 * 1000.0 / options.rate_hz;
        let is_lost = drops.random::<f64>() < options.dropped_fraction;
        if is_lost && row > 0 {
            truth.dropped_rows += 1;
            continue;
        }
        truth.rows += 1;
        truth.clipped_rows += usize::from(reading.is_clipped);
        each(&Row {
            // millis() truncates; the tolerance keeps 30 ms from becoming 29.
            stamp_ms: (board_ms + jitter_ms + 1e-6).floor().max(0.0) as u64,
            reading,
        })?;
    }
    Ok(truth)
}

/// °C above 25 °C, `on_s` seconds after the part was switched on: it warms up.
pub(crate) fn warmer_c(options: &SimulateOptions, on_s: f64) -> f64 {
    let o = &options.sensor;
    o.temperature_rise_c * -(-on_s / o.temperature_time_s).exp_m1()
}

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
        let mut rows = Vec::with_capacity(row_count(plan, options));
        let file = record(plan, options, index, |row| {
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
fn planned(options: &SimulateOptions, max: usize) -> Result<(Truth, Vec<Plan>)> {
    options.validate()?;
    let plans = scenario::plan(options);
    let rows: usize = plans.iter().map(|p| row_count(p, options)).sum();
    if rows > max {
        return Err(Problem::TooManyRows { rows, max }.error());
    }
    Ok((Truth::draw(options), plans))
}

/// Simulates into files, row by row: every recording and `truth.json` in `dir`, which is created if
/// necessary. Returns the truth and the paths, `truth.json` last.
///
/// All targets are checked before the first is written.
///
/// # Errors
///
/// `simulate-option` (usage) for an option out of its range and for more than 10⁹ rows; `exists` (usage) if a
/// target exists and `force` is false; otherwise errors of the file system, with the path.
pub fn simulate_to(
    options: &SimulateOptions,
    dir: impl AsRef<Path>,
    force: bool,
) -> Result<(Truth, Vec<PathBuf>)> {
    let dir = dir.as_ref();
    let (mut truth, plans) = planned(options, MAX_WRITTEN)?;
    let names = plans.iter().map(|plan| plan.truth.name.as_str());
    let paths: Vec<PathBuf> = names
        .chain(["truth.json"])
        .map(|name| dir.join(name))
        .collect();
    for path in &paths {
        check_target(path, force)?;
    }
    make_folder(dir)?;
    let lsb = [truth.accelerometer.lsb_mps2, truth.gyroscope.lsb_rad_s];
    for (index, (plan, path)) in plans.iter().zip(&paths).enumerate() {
        write_atomic(path, force, |out| {
            let failed = |e| Error::io(path, e);
            let preamble = preamble(options, &plan.truth.name);
            out.write_all(preamble.as_bytes()).map_err(failed)?;
            let file = record(plan, options, index, |row| {
                let line = line(row, options.file, lsb);
                out.write_all(line.as_bytes()).map_err(failed)
            })?;
            truth.files.push(file);
            Ok(())
        })?;
    }
    let path = &paths[plans.len()];
    let json = serde_json::to_string_pretty(&truth).map_err(|e| Error::io(path, e.into()))?;
    write_text(path, force, &(json + "\n"))?;
    Ok((truth, paths))
}

/// Comment lines and header.
fn preamble(o: &SimulateOptions, name: &str) -> String {
    let s = &o.sensor;
    let header = match o.file {
        FileOptions { raw: true, .. } => RAW_HEADER,
        FileOptions {
            wrong_header: true, ..
        } => WRONG_HEADER,
        _ => Reading::HEADER.trim_end(),
    };
    let tool = gravical_recording::output::TOOL;
    let scenario = o.scenario.name();
    format!(
        "# simulated by {tool}, not measured: {scenario}, {name}; what was put in is in truth.json\n\
         # seed {}, rate {} Hz, range {} g and 250 °/s, low-pass {LOW_PASS_HZ} Hz, noise {} m/s/√s and {} °/√s\n\
         # gravity {} m/s², tilt of the poses {}°, jitter {} ms, lost rows {}\n\
         {header}\n",
        o.seed,
        o.rate_hz,
        s.accel_range_g,
        s.noise_factor * ACCEL_NOISE_MPS_RTS,
        s.noise_factor * GYRO_NOISE_DEG_RTS,
        o.gravity_mps2,
        o.tilt_sd_deg,
        o.stamp_jitter_ms,
        o.dropped_fraction,
    )
}

/// A row as text; `lsb`: m/s² and rad/s of one count.
fn line(row: &Row, file: FileOptions, lsb: [f64; 2]) -> String {
    let r = &row.reading;
    if !file.raw {
        return r.row(row.stamp_ms, usize::from(file.decimals));
    }
    let [ax, ay, az] = r.accel_mps2.map(|v| (v / lsb[0]).round() as i16);
    let [gx, gy, gz] = r.gyro_rad_s.map(|v| (v / lsb[1]).round() as i16);
    let (stamp_ms, t) = (row.stamp_ms, temperature_counts(r.temperature_c) as i16);
    format!("{stamp_ms},{ax},{ay},{az},{t},{gx},{gy},{gz}\n")
}
