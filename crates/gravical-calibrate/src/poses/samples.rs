//! A recording as the detector of rests takes it: samples in SI units.
//!
//! Units are nominal here: what no unit is known of is scaled such that gravity is gravity, and that the
//! gyroscope rests where it is quietest.

use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_signal::{BLOCK_S, Channels, block_len, blocks, pieces, quantile, resolutions};

use super::spikes;
use crate::recording::units::{MDPS_PER_DEG_S, Origin};
use crate::recording::{Finding, FindingKind, Recording};

/// Between the noise of a usual gyroscope in rad/s and in °/s: 0.09 °/s is
/// 0.0016 rad/s, and this is their geometric mean.
pub(super) const MAX_NOISE_RAD_S: f64 = 0.012;
/// A mean rate this far from that of most rests is a turn about the vertical, which the accelerometer does
/// not see, rad/s: 3 °/s, more than a bias drifts or differs between poses.
const TURNING_RAD_S: f64 = 0.052;
/// The range of counts may be so many times the least one, by which it is guessed.
const MAX_RANGE_RATIO: f64 = 4.0;
/// Readings of a block where no rate is known: 0.1 s at 100 Hz, 0.5 s at 20 Hz.
const BLOCK_READINGS: f64 = 10.0;
/// The least that have a variance.
const FEWEST_READINGS: f64 = 5.0;
/// Fraction of the blocks that is quiet in any recording.
const QUIET_SHARE: f64 = 0.05;

/// Rows of a recording as the detector takes them, without rows that are no measurement.
pub(super) struct Samples {
    /// Row of each sample.
    rows: Vec<usize>,
    time_s: Vec<f64>,
    force: Vec<[f64; 3]>,
    /// Empty without a gyroscope.
    rate: Vec<[f64; 3]>,
    pub period_s: f64,
    pieces: Vec<Range<usize>>,
    resolution: [f64; 6],
    /// A rest whose mean rate is off the bias by more is a turn.
    pub turning_rad_s: f64,
}

impl Samples {
    /// Rows of a span of samples.
    pub fn in_rows(&self, span: &Range<usize>) -> Range<usize> {
        self.rows[span.start]..self.rows[span.end - 1] + 1
    }

    pub fn new(recording: &Recording) -> Samples {
        Samples::of_blocks(recording, BLOCK_READINGS)
    }

    /// The same for the shortest rests of a recording without a rate: 20 readings.
    pub fn for_short_rests(recording: &Recording) -> Samples {
        Samples::of_blocks(recording, FEWEST_READINGS)
    }

    /// `readings`: those of a block where no rate is known.
    fn of_blocks(recording: &Recording, readings: f64) -> Samples {
        let period_s = match recording.timing.rate_hz() {
            Some(rate_hz) => rate_hz.recip(),
            None => BLOCK_S / (readings * rows_of_a_reading(recording)),
        };
        let per_mps2 = recording
            .accel_scale
            .nominal()
            .unwrap_or_else(|| typical_magnitude(recording) / STANDARD_GRAVITY_MPS2);
        let rows = 0..recording.rows();
        let mut force: Vec<[f64; 3]> = rows
            .clone()
            .map(|row| recording.accel_at(row).map(|v| v / per_mps2))
            .collect();
        let step = recording.resolution[0].map(|step| step / per_mps2);
        // In a second that is counted in few rows, a motion that begins at its end would be few enough for spikes.
        let reach = match recording.timing.rate_hz() {
            Some(_) => 0,
            None => spikes::REACH,
        };
        take_out_spikes(&mut force, step, period_s, reach);
        let is_whole = |force: &[f64; 3]| force.iter().all(|v| v.is_finite());
        let rows: Vec<usize> = rows.filter(|row| is_whole(&force[*row])).collect();
        force.retain(is_whole);
        let time_s: Vec<f64> = rows.iter().map(|row| *row as f64 * period_s).collect();
        let after = |row: &usize| rows.partition_point(|r| r < row);
        let breaks: Vec<usize> = recording.breaks.iter().map(after).collect();
        let gyro = recording.gyro.as_ref();
        let mut samples = Samples {
            pieces: pieces(&time_s, period_s, &breaks),
            time_s,
            force,
            rate: gyro.map_or(Vec::new(), |gyro| held(gyro, &rows)),
            period_s,
            resolution: [0.0; 6],
            turning_rad_s: TURNING_RAD_S,
            rows,
        };
        if !samples.rate.is_empty() {
            let (per_rad_s, is_guessed) = samples.rate_scale(recording);
            if is_guessed {
                samples.turning_rad_s /= MAX_RANGE_RATIO;
            }
            let rates = samples.rate.iter_mut().flatten();
            rates.for_each(|v| *v /= per_rad_s);
        }
        samples.resolution = resolutions(&samples.force, &samples.rate);
        samples
    }

    /// Units of the file per rad/s: what is known of it, if the gyroscope may be as quiet as it is in
    /// that; else the first unit in which it may. True if that is the range of counts.
    fn rate_scale(&self, recording: &Recording) -> (f64, bool) {
        let degrees = 1.0_f64.to_degrees();
        let stated = recording.gyro_scale;
        let known = match stated.and_then(|s| Some((s.origin, s.nominal()?))) {
            Some((Origin::Given, nominal)) => return (nominal, false),
            Some((Origin::Data, nominal)) => Some(nominal),
            // A header that is wrong about the accelerometer says nothing about the gyroscope.
            Some((Origin::Header, nominal)) => {
                Some(nominal).filter(|_| !recording.contradicts_header)
            }
            Some((Origin::Assumed, _)) | None => None,
        };
        // Of counts the finest first: a gyroscope that seems too quiet hides no pose. Those of another
        // file are interpolated, and no whole numbers.
        let counts = [131.0 * degrees, MDPS_PER_DEG_S * degrees];
        let is_whole = self.rate.iter().flatten().all(|v| v.fract() == 0.0);
        let units = [1.0, degrees].into_iter().filter(|_| !is_whole);
        let scales: Vec<f64> = known.into_iter().chain(units).chain(counts).collect();
        let level = self.quietest_rms(1);
        let quiet = scales
            .iter()
            .find(|scale| level < MAX_NOISE_RAD_S * **scale);
        let scale = *quiet.or(scales.last()).unwrap_or(&1.0);
        (scale, Some(scale) != known && counts.contains(&scale))
    }

    /// Standard deviation of each axis in the quietest twentieth of the blocks: of the accelerometer (0) or the
    /// gyroscope (1).
    pub fn quietest_rms(&self, sensor: usize) -> f64 {
        let size = block_len(self.period_s, BLOCK_S);
        let blocks = blocks(&self.channels(), &(0..self.rows.len()), size);
        let variances = blocks.iter().map(|b| b.total_variance(sensor)).collect();
        (quantile(variances, QUIET_SHARE) / 3.0).sqrt()
    }

    pub fn channels(&self) -> Channels<'_> {
        Channels {
            time_s: &self.time_s,
            force_mps2: &self.force,
            rate_rad_s: &self.rate,
            period_s: self.period_s,
            pieces: &self.pieces,
            resolution: self.resolution,
        }
    }
}

/// The gyroscope in each row; where it was not read, its last reading. Empty if it never was.
fn held(gyro: &[Vec<f64>; 3], rows: &[usize]) -> Vec<[f64; 3]> {
    let at = |row: &usize| gyro.each_ref().map(|c| c[*row]);
    let is_read = |v: &[f64; 3]| v.iter().all(|x| x.is_finite());
    let Some(mut last) = rows.iter().map(at).find(is_read) else {
        return Vec::new();
    };
    let hold = |row| {
        let now = at(row);
        if is_read(&now) {
            last = now;
        }
        last
    };
    rows.iter().map(hold).collect()
}

/// Rows for each reading of a sensor that was read faster than it measures.
fn rows_of_a_reading(recording: &Recording) -> f64 {
    let is_repeat = |f: &Finding| f.kind == FindingKind::RepeatedRows;
    if !recording.findings.iter().any(is_repeat) {
        return 1.0;
    }
    let rows = recording.rows();
    let same = |c: &Vec<f64>, row: usize| c[row] == c[row - 1];
    let is_new = |row: &usize| !recording.accel.iter().all(|c| same(c, *row));
    rows as f64 / (1 + (1..rows).filter(is_new).count()) as f64
}

/// Holds the row before in place of one with a spike, in blocks of a second: those that transmission errors
/// make hide rests. `reach` rows around a block are neighbours of its rows.
fn take_out_spikes(force: &mut [[f64; 3]], step: [f64; 3], period_s: f64, reach: usize) {
    let block = ((period_s.recip() + 1e-6).round() as usize).max(1);
    for from in (0..force.len()).step_by(block) {
        let rows = from..(from + block).min(force.len());
        let first = from.saturating_sub(reach);
        let around = first..(rows.end + reach).min(force.len());
        let mut values = [0, 1, 2].map(|i| force[around.clone()].iter().map(|f| f[i]).collect());
        if spikes::take_out(&mut values, step, rows.start - first..rows.end - first) == 0 {
            continue;
        }
        for row in rows {
            let is_spike = |i: usize| values[i][row - first].is_nan() && !force[row][i].is_nan();
            if row > 0 && (0..3).any(is_spike) {
                force[row] = force[row - 1];
            }
        }
    }
}

fn typical_magnitude(recording: &Recording) -> f64 {
    let rows = (0..recording.rows()).map(|row| norm(&recording.accel_at(row)));
    let magnitude = quantile(rows.filter(|n| n.is_finite()).collect(), 0.5);
    if magnitude > 0.0 { magnitude } else { 1.0 }
}
