//! A recording as the detector of rests takes it: samples in SI units.
//!
//! Units are nominal here: what no unit is known of is scaled such that gravity is gravity, and that the
//! gyroscope rests where it is quietest.

use std::borrow::Cow;
use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_signal::stats::moments;
use gravical_signal::{BLOCK_S, Samples, block_len, blocks, quantile};

use super::face::AxisMap;
use super::spikes;
use crate::recording::Recording;
use crate::recording::units::{MDPS_PER_DEG_S, Origin};
use crate::samples::{Columns, samples};

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
    /// Their period is known.
    pub has_clock: bool,
}

impl NominalSamples {
    /// Rows of a span of samples.
    pub fn in_rows(&self, span: &Range<usize>) -> Range<usize> {
        let rows = &self.samples.rows;
        rows[span.start] as usize..rows[span.end - 1] as usize + 1
    }

    /// Samples of a span of rows.
    pub fn in_samples(&self, rows: &Range<usize>) -> Range<usize> {
        self.samples.first_sample(rows.start)..self.samples.first_sample(rows.end)
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
        // Rows, not stamps, give the time: samples whose stamps repeat are left out.
        let time_s: Vec<f64> = (0..recording.rows())
            .map(|row| row as f64 * period_s)
            .collect();
        let columns = |values, per_si| Columns {
            values,
            per_si,
            interpolated: Vec::new(),
        };
        let accel = columns(without_spikes(recording, period_s), per_mps2(recording));
        let read = recording.gyro.as_ref();
        let scale = read.map(|read| rate_scale(recording, read, period_s));
        let is_guessed = scale.is_some_and(|(_, is_guessed)| is_guessed);
        let filled = read.and_then(forward_fill).zip(scale);
        let gyro = filled.map(|(values, (per_si, _))| columns(values, per_si));
        let axes = AxisMap::default();
        let in_si = |gyro| samples(recording, &time_s, &accel, gyro, &axes, None).0;
        let mut samples = in_si(gyro.as_ref());
        if 2 * samples.len() < recording.rows() {
            // In a wrong unit no rate is possible.
            let alone = in_si(None);
            if alone.len() > samples.len() {
                samples = alone;
            }
        }
        NominalSamples {
            samples: samples.with_period(period_s),
            has_clock: recording.clock.rate_hz().is_some(),
            turning_rad_s: TURNING_RAD_S / if is_guessed { MAX_RANGE_RATIO } else { 1.0 },
        }
    }

    /// Standard deviation of each axis in the quietest twentieth of the blocks: of the accelerometer (0) or the
    /// gyroscope (1).
    pub fn quietest_rms(&self, sensor: usize) -> f64 {
        let size = block_len(self.samples.period_s, BLOCK_S);
        let blocks = blocks(&self.samples, &(0..self.samples.len()), size);
        rms_of_quietest(blocks.iter().map(|b| b.total_variance(sensor)))
    }
}

/// Standard deviation of each axis in the quietest twentieth of blocks, by their variances of three axes.
fn rms_of_quietest(variances: impl Iterator<Item = f64>) -> f64 {
    (quantile(variances.collect(), QUIET_SHARE) / 3.0).sqrt()
}

/// Units of the file per m/s²; where none is known gravity is gravity.
fn per_mps2(recording: &Recording) -> f64 {
    let known = recording.units.accel.nominal();
    known.unwrap_or_else(|| typical_magnitude(recording) / STANDARD_GRAVITY_MPS2)
}

/// Units of the file per rad/s: what is known of it, if the gyroscope may be as quiet as it is in
/// that; else the first unit in which it may. True if that is the range of counts.
fn rate_scale(recording: &Recording, gyro: &[Vec<f64>; 3], period_s: f64) -> (f64, bool) {
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
    let is_whole = gyro
        .iter()
        .flatten()
        .all(|v| v.is_nan() || v.fract() == 0.0);
    let units = [1.0, degrees].into_iter().filter(|_| !is_whole);
    let scales: Vec<f64> = known.into_iter().chain(units).chain(counts).collect();
    let size = block_len(period_s, BLOCK_S);
    let blocks = (0..recording.rows() / size).map(|k| k * size..(k + 1) * size);
    let level = rms_of_quietest(blocks.map(|rows| moments(gyro, rows).1));
    let quiet = scales
        .iter()
        .find(|scale| level < MAX_NOISE_RAD_S * **scale);
    let scale = *quiet.or(scales.last()).unwrap_or(&1.0);
    (scale, Some(scale) != known && counts.contains(&scale))
}

/// The gyroscope in each row; where it was not read, its last reading. None if it never was.
fn forward_fill(gyro: &[Vec<f64>; 3]) -> Option<[Cow<'_, [f64]>; 3]> {
    let is_read = |row: &usize| gyro.iter().all(|c| c[*row].is_finite());
    let mut filled = gyro.each_ref().map(|c| Cow::Borrowed(&c[..]));
    let mut last = (0..gyro[0].len()).find(is_read)?;
    for row in 0..gyro[0].len() {
        if is_read(&row) {
            last = row;
        } else {
            for c in &mut filled {
                c.to_mut()[row] = c[last];
            }
        }
    }
    Some(filled)
}

/// The accelerometer with the row before in place of one with a spike, in blocks of a second: those that transmission
/// errors make hide rests.
fn without_spikes(recording: &Recording, period_s: f64) -> [Cow<'_, [f64]>; 3] {
    let (accel, step) = (&recording.accel, recording.units.resolution[0]);
    // Without a rate a block has few rows: the start of a motion at its end would pass for spikes.
    let reach = match recording.clock.rate_hz() {
        Some(_) => 0,
        None => spikes::REACH,
    };
    let mut clean = accel.each_ref().map(|c| Cow::Borrowed(&c[..]));
    let rows = recording.rows();
    let block = ((period_s.recip() + 1e-6).round() as usize).max(1);
    for from in (0..rows).step_by(block) {
        let inner = from..(from + block).min(rows);
        let first = from.saturating_sub(reach);
        let around = first..(inner.end + reach).min(rows);
        let mut values = clean.each_ref().map(|c| c[around.clone()].to_vec());
        if spikes::take_out(&mut values, step, inner.start - first..inner.end - first) == 0 {
            continue;
        }
        for row in inner {
            let is_spike = |i: usize| values[i][row - first].is_nan() && !clean[i][row].is_nan();
            if row > 0 && (0..3).any(is_spike) {
                for c in &mut clean {
                    c.to_mut()[row] = c[row - 1];
                }
            }
        }
    }
    clean
}

fn typical_magnitude(recording: &Recording) -> f64 {
    let rows = (0..recording.rows()).map(|row| norm(&recording.accel_at(row)));
    let magnitude = quantile(rows.filter(|n| n.is_finite()).collect(), 0.5);
    if magnitude > 0.0 { magnitude } else { 1.0 }
}
