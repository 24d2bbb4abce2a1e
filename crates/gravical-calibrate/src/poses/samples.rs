//! A recording as the detector of rests takes it: samples in SI units.
//!
//! Units are nominal here: what no unit is known of is scaled such that gravity is gravity, and that the
//! gyroscope rests where it is quietest.

use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_signal::{BLOCK_S, Samples, block_len, blocks, pieces, quantile, resolutions};

use super::spikes;
use crate::recording::Recording;
use crate::recording::units::{MDPS_PER_DEG_S, Origin};

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
pub(super) struct NominalSamples {
    pub samples: Samples,
    /// A rest whose mean rate is off the bias by more is a turn.
    pub turning_rad_s: f64,
}

impl NominalSamples {
    /// Rows of a span of samples.
    pub fn in_rows(&self, span: &Range<usize>) -> Range<usize> {
        let rows = &self.samples.rows;
        rows[span.start] as usize..rows[span.end - 1] as usize + 1
    }

    /// Samples of a span of rows.
    pub fn in_samples(&self, rows: &Range<usize>) -> Range<usize> {
        let sample = |row: usize| self.samples.rows.partition_point(|r| (*r as usize) < row);
        sample(rows.start)..sample(rows.end)
    }

    pub fn new(recording: &Recording) -> NominalSamples {
        NominalSamples::of_blocks(recording, BLOCK_READINGS)
    }

    /// The same for the shortest rests of a recording without a rate: 20 readings.
    pub fn for_short_rests(recording: &Recording) -> NominalSamples {
        NominalSamples::of_blocks(recording, FEWEST_READINGS)
    }

    /// `readings`: those of a block where no rate is known.
    fn of_blocks(recording: &Recording, readings: f64) -> NominalSamples {
        let period_s = match recording.clock.rate_hz() {
            Some(rate_hz) => rate_hz.recip(),
            None => BLOCK_S / (readings * recording.clock.rows_per_reading),
        };
        let per_mps2 = recording
            .units
            .accel
            .nominal()
            .unwrap_or_else(|| typical_magnitude(recording) / STANDARD_GRAVITY_MPS2);
        let rows = 0..recording.rows();
        let mut force: Vec<[f64; 3]> = rows
            .clone()
            .map(|row| recording.accel_at(row).map(|v| v / per_mps2))
            .collect();
        let step = recording.units.resolution[0].map(|step| step / per_mps2);
        // Without a rate a block has few rows: the start of a motion at its end would pass for spikes.
        let reach = match recording.clock.rate_hz() {
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
        let samples = Samples {
            pieces: pieces(&time_s, period_s, &breaks),
            time_s,
            force_mps2: force,
            rate_rad_s: gyro.map_or(Vec::new(), |gyro| held(gyro, &rows)),
            period_s,
            resolution: [0.0; 6],
            rows: rows.into_iter().map(|row| row as u32).collect(),
            breaks,
            bridged: Vec::new(),
        };
        let mut nominal = NominalSamples {
            samples,
            turning_rad_s: TURNING_RAD_S,
        };
        if nominal.samples.has_gyro() {
            let (per_rad_s, is_guessed) = nominal.rate_scale(recording);
            if is_guessed {
                nominal.turning_rad_s /= MAX_RANGE_RATIO;
            }
            let rates = nominal.samples.rate_rad_s.iter_mut().flatten();
            rates.for_each(|v| *v /= per_rad_s);
        }
        let samples = &mut nominal.samples;
        samples.resolution = resolutions(&samples.force_mps2, &samples.rate_rad_s);
        nominal
    }

    /// Units of the file per rad/s: what is known of it, if the gyroscope may be as quiet as it is in
    /// that; else the first unit in which it may. True if that is the range of counts.
    fn rate_scale(&self, recording: &Recording) -> (f64, bool) {
        let degrees = 1.0_f64.to_degrees();
        let stated = recording.units.gyro;
        let known = match stated.and_then(|s| Some((s.origin, s.nominal()?))) {
            Some((Origin::Given, nominal)) => return (nominal, false),
            Some((Origin::Data, nominal)) => Some(nominal),
            // A header that is wrong about the accelerometer says nothing about the gyroscope.
            Some((Origin::Header, nominal)) => {
                Some(nominal).filter(|_| !recording.units.contradicts_header)
            }
            Some((Origin::Assumed, _)) | None => None,
        };
        // Of counts the finest first: a gyroscope that seems too quiet hides no pose. Those of another
        // file are interpolated, and no whole numbers.
        let counts = [131.0 * degrees, MDPS_PER_DEG_S * degrees];
        let is_whole = self
            .samples
            .rate_rad_s
            .iter()
            .flatten()
            .all(|v| v.fract() == 0.0);
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
        let size = block_len(self.samples.period_s, BLOCK_S);
        let blocks = blocks(&self.samples, &(0..self.samples.len()), size);
        let variances = blocks.iter().map(|b| b.total_variance(sensor)).collect();
        (quantile(variances, QUIET_SHARE) / 3.0).sqrt()
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
