//! The virtual board: computes the rows of a recording from a path.
//!
//! The sensor is simulated at about 1 kHz, including its low-pass for signal and noise, and every
//! k-th value is read out. Neighbouring samples are therefore correlated as in the real part, and
//! the noise density at low frequencies is the given one at every rate.

use rand::RngExt;

use super::options::SimulateOptions;
use super::random::{Purpose, stream, uniform};
use super::scenario::Plan;
use super::sensor::{Part, Reading};
use super::truth::FileTruth;
use crate::Result;

/// The lowest rate of the internal simulation of the sensor, Hz.
pub(super) const INSIDE_HZ: f64 = 1000.0;

/// A row of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// True time, s since the first row. The signal is older by the delay of the low-pass (5.1 ms at
    /// 44 Hz).
    pub t_s: f64,
    /// Time stamp of the board, ms.
    pub stamp_ms: u64,
    /// What the board read.
    pub reading: Reading,
}

/// Number of rows before any are lost.
pub(super) fn row_count(plan: &Plan, options: &SimulateOptions) -> usize {
    // Tolerance for rounding, so that 10 s at 100 Hz are 1000 rows.
    (plan.path.duration_s() * options.rate_hz + 1e-6).floor() as usize
}

/// Records a plan, each row by `each`. `file` is the index of the recording (their noise differs).
pub(super) fn record(
    plan: &Plan,
    options: &SimulateOptions,
    file: usize,
    mut each: impl FnMut(&Row) -> Result<()>,
) -> Result<FileTruth> {
    let path = &plan.path;
    let per_row = (INSIDE_HZ / options.rate_hz).ceil() as usize;
    let step_s = 1.0 / (options.rate_hz * per_row as f64);
    let mut part = Part::new(options, step_s, file, path, warmer_c(options, plan.on_s));
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
            part.update(path, t_s, warm_c);
        }
        let reading = part.read(path, t_s, warm_c);
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
            t_s,
            // millis() truncates; the tolerance keeps 30 ms from becoming 29.
            stamp_ms: (board_ms + jitter_ms + 1e-6).floor().max(0.0) as u64,
            reading,
        })?;
    }
    Ok(truth)
}

/// °C above 25 °C, `on_s` seconds after the part was switched on: it warms up.
pub(super) fn warmer_c(options: &SimulateOptions, on_s: f64) -> f64 {
    let o = &options.sensor;
    o.temperature_rise_c * -(-on_s / o.temperature_time_s).exp_m1()
}
