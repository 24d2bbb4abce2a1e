//! The virtual board: computes the rows of a recording from a path.
//!
//! The sensor is simulated at about 1 kHz, including its low-pass for signal and noise, and every
//! k-th value is read out. Neighbouring samples are therefore correlated as in the real part, and
//! the noise density at low frequencies is the given one at every rate.

use rand::RngExt;

use super::options::SimulateOptions;
use super::part::{Part, Reading};
use super::path::MotionPath;
use super::random::{Purpose, stream, uniform};
use super::sensor::{START_TEMPERATURE_C, Sensor};
use crate::Result;

/// The lowest rate of the internal simulation of the sensor, Hz.
pub(super) const INSIDE_HZ: f64 = 1000.0;

/// A row of a recording; row 0 is at true time 0.
pub(super) struct Row {
    pub t_s: f64,
    pub stamp_ms: u64,
    pub reading: Reading,
    pub still: bool,
}

/// What is known after the last row.
#[derive(Debug, Default)]
pub(super) struct Recorded {
    pub rows: usize,
    pub first_stamp_ms: u64,
    pub dropped_rows: usize,
    pub clipped_rows: usize,
}

/// Number of rows before any are lost.
pub(super) fn row_count(path: &MotionPath, options: &SimulateOptions) -> usize {
    // Tolerance for rounding, so that 10 s at 100 Hz are 1000 rows.
    (path.duration_s() * options.rate_hz + 1e-6).floor() as usize
}

/// Records `path`, each row by `each`. `file` is the index of the recording (their noise differs), `warm_s` the time
/// that the part has been switched on at the start.
pub(super) fn record(
    path: &MotionPath,
    sensor: &Sensor,
    options: &SimulateOptions,
    file: usize,
    warm_s: f64,
    mut each: impl FnMut(&Row) -> Result<()>,
) -> Result<Recorded> {
    let rows = row_count(path, options);
    let per_row = (INSIDE_HZ / options.rate_hz).ceil() as usize;
    let step_s = 1.0 / (options.rate_hz * per_row as f64);
    let mut part = Part::new(sensor, options, step_s, file, path);
    let mut stamps = Stamps::new(options, file);
    let mut drops = stream(options.seed, Purpose::Drops, file);
    let mut recorded = Recorded {
        first_stamp_ms: stamps.first_ms,
        ..Recorded::default()
    };

    // The state of the low-pass at row 0 must already be noise.
    let settle_steps = options
        .sensor
        .low_pass_hz
        .map_or(0, |f| (5.0 / (f * step_s)).ceil() as usize);
    let warmer_c = |t_s: f64| warmer_c(options, t_s, warm_s + t_s, path.duration_s());
    for _ in 0..settle_steps {
        part.update(path, 0.0, warmer_c(0.0));
    }
    for row in 0..rows {
        let t_s = row as f64 / options.rate_hz;
        let warm_c = warmer_c(t_s);
        let before = if row == 0 { per_row } else { 1 };
        for step in before..per_row {
            let t_s = ((row - 1) * per_row + step) as f64 * step_s;
            part.update(path, t_s, warm_c);
        }
        let reading = part.read(path, t_s, warm_c);
        let stamp_ms = stamps.at(row);
        let lost = drops.random::<f64>() < options.dropped_fraction;
        if lost && row > 0 {
            recorded.dropped_rows += 1;
            continue;
        }
        recorded.rows += 1;
        recorded.clipped_rows += usize::from(reading.clipped);
        each(&Row {
            t_s,
            stamp_ms,
            reading,
            still: path.is_still_at(t_s),
        })?;
    }
    Ok(recorded)
}

/// °C above 25 °C at `t_s`, `on_s` seconds after the part was switched on: it warms up on a table, or follows a
/// chamber once from the highest temperature to the lowest and back.
pub(super) fn warmer_c(options: &SimulateOptions, t_s: f64, on_s: f64, duration_s: f64) -> f64 {
    if let Some(soak) = options.scenario.soak() {
        let turn = std::f64::consts::TAU * t_s / duration_s;
        let celsius = soak.low_c + 0.5 * (soak.high_c - soak.low_c) * (1.0 + turn.cos());
        return celsius - START_TEMPERATURE_C;
    }
    let o = &options.sensor;
    o.temperature_rise_c * -(-on_s / o.temperature_time_s).exp_m1()
}

/// The board's clock in whole milliseconds.
struct Stamps<'a> {
    options: &'a SimulateOptions,
    rng: rand_chacha::ChaCha8Rng,
    first_ms: u64,
}

impl<'a> Stamps<'a> {
    fn new(options: &'a SimulateOptions, file: usize) -> Self {
        let mut rng = stream(options.seed, Purpose::Stamps, file);
        // Opening the port resets the board; the first line follows after its setup.
        let first_ms = rng.random_range(100..300);
        Self {
            options,
            rng,
            first_ms,
        }
    }

    fn at(&mut self, row: usize) -> u64 {
        let o = self.options;
        let jitter_ms = o.stamp_jitter_ms * uniform(&mut self.rng);
        let true_ms = row as f64 * 1000.0 / o.rate_hz;
        let board_ms = self.first_ms as f64 + true_ms;
        // millis() truncates; the tolerance keeps 30 ms from becoming 29.
        (board_ms + jitter_ms + 1e-6).floor().max(0.0) as u64
    }
}
