//! The virtual board: computes the rows of a recording from a path.
//!
//! The sensor is simulated at about 1 kHz, including its low-pass for signal and noise, and every
//! k-th value is read out. Neighbouring samples are therefore correlated as in the real part, and
//! the noise density at low frequencies is the given one at every rate.

use rand::RngExt;

use super::chamber::Chamber;
use super::options::SimulateOptions;
use super::part::{Part, Reading};
use super::path::MotionPath;
use super::random::{Purpose, stream, uniform};
use super::sensor::{START_TEMPERATURE_C, Sensor};

/// The lowest rate of the internal simulation of the sensor, Hz.
pub(super) const INSIDE_HZ: f64 = 1000.0;

/// The columns of one recording; row 0 is at true time 0.
#[derive(Debug, Default)]
pub(super) struct Columns {
    pub t_s: Vec<f64>,
    pub stamp_ms: Vec<u64>,
    pub accel_mps2: [Vec<f64>; 3],
    pub gyro_rad_s: [Vec<f64>; 3],
    pub temperature_c: Vec<f64>,
    pub still: Vec<bool>,
    pub first_stamp_ms: u64,
    pub dropped_rows: usize,
    pub clipped_rows: usize,
    pub temperature_mean_c: f64,
}

/// Number of rows before any are lost.
pub(super) fn row_count(path: &MotionPath, options: &SimulateOptions) -> usize {
    // Tolerance for rounding, so that 10 s at 100 Hz are 1000 rows.
    (path.duration_s() * options.rate_hz + 1e-6).floor() as usize
}

/// Records `path`. `file` is the index of the recording (their noise differs), `warm_s` the time
/// that the part has been switched on at the start.
pub(super) fn record(
    path: &MotionPath,
    sensor: &Sensor,
    options: &SimulateOptions,
    file: usize,
    warm_s: f64,
) -> Columns {
    let rows = row_count(path, options);
    let per_row = (INSIDE_HZ / options.rate_hz).ceil() as usize;
    let step_s = 1.0 / (options.rate_hz * per_row as f64);
    let mut part = Part::new(sensor, options, step_s, file, path);
    let mut stamps = Stamps::new(options, file);
    let mut drops = stream(options.seed, Purpose::Drops, file);
    let mut columns = Columns {
        first_stamp_ms: stamps.first_ms,
        ..Columns::default()
    };
    columns.reserve(rows);

    // The state of the low-pass at row 0 must already be noise.
    let settle_steps = options
        .sensor
        .low_pass_hz
        .map_or(0, |f| (5.0 / (f * step_s)).ceil() as usize);
    let soak = options.scenario.soak();
    let mut chamber = Chamber::new(&options.sensor, soak, path.duration_s(), warm_s);
    for _ in 0..settle_steps {
        part.update(path, 0.0, chamber.at(0.0).drift_c);
    }
    let mut temperature_sum = 0.0;
    for row in 0..rows {
        let t_s = row as f64 / options.rate_hz;
        let warmth = chamber.at(t_s);
        temperature_sum += warmth.thermometer_c;
        let before = if row == 0 { per_row } else { 1 };
        for step in before..per_row {
            let t_s = ((row - 1) * per_row + step) as f64 * step_s;
            part.update(path, t_s, warmth.drift_c);
        }
        let reading = part.read(path, t_s, warmth);
        let stamp_ms = stamps.at(row);
        let lost = drops.random::<f64>() < options.dropped_fraction;
        if lost && row > 0 {
            columns.dropped_rows += 1;
            continue;
        }
        columns.push(t_s, stamp_ms, &reading, path.is_still_at(t_s));
    }
    columns.temperature_mean_c = START_TEMPERATURE_C + temperature_sum / rows.max(1) as f64;
    columns
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
        let board_ms = self.first_ms as f64 + true_ms * (1.0 + o.clock_error_ppm * 1e-6);
        // millis() truncates; the tolerance keeps 30 ms from becoming 29.
        (board_ms + jitter_ms + 1e-6).floor().max(0.0) as u64
    }
}

impl Columns {
    fn reserve(&mut self, rows: usize) {
        self.t_s.reserve(rows);
        self.stamp_ms.reserve(rows);
        for channel in self.accel_mps2.iter_mut().chain(&mut self.gyro_rad_s) {
            channel.reserve(rows);
        }
        self.temperature_c.reserve(rows);
        self.still.reserve(rows);
    }

    fn push(&mut self, t_s: f64, stamp_ms: u64, reading: &Reading, still: bool) {
        self.t_s.push(t_s);
        self.stamp_ms.push(stamp_ms);
        for axis in 0..3 {
            self.accel_mps2[axis].push(reading.accel[axis]);
            self.gyro_rad_s[axis].push(reading.gyro[axis]);
        }
        self.temperature_c.push(reading.temperature_c);
        self.still.push(still);
        self.clipped_rows += usize::from(reading.clipped);
    }
}
