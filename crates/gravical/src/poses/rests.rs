//! Static intervals of a recording, by the detector of rests ([`gravical_signal::detect_rests`]).
//!
//! The detector takes SI units. Those of a recording are nominal here: what no unit is known of is
//! scaled such that gravity is gravity, and that the gyroscope rests where it is quietest.

use std::ops::Range;

use gravical_core::matrix3::{norm, sub};
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_motion::resolutions;
use gravical_signal::{
    BLOCK_S, Channels, MAX_VARIANCE, block_len, blocks, detect_quiet, detect_rests, is_gap,
    quantile,
};

use super::gyro_unit::MAX_NOISE_RAD_S;
use super::spikes;
use crate::poses::MANY_POSES;
use crate::recording::units::{MDPS_PER_DEG_S, Origin};
use crate::recording::{Finding, FindingKind, Recording, between};
use crate::stats::weighted_median;

/// Shortest static interval, s: a shorter pause of a hand is no pose.
pub const MIN_REST_S: f64 = 1.0;
/// A rest of fewer blocks is used to its ends.
const MIN_BLOCKS_TO_TRIM: usize = 6;
/// So many hours hold more static intervals than poses that somebody placed a sensor in: it is worn …
const WORN_HOURS: f64 = 12.0;
/// … and rests for at least this long, s (van Hees et al., J. Appl. Physiol. 117 (2014) 738).
const MIN_WORN_REST_S: f64 = 10.0;
/// The same where no rate is known, in blocks …
const MIN_BLOCKS_OF_ROWS: f64 = 4.0;
/// … and as a fraction of the median number of rows of a rest.
const MIN_SHARE: f64 = 0.4;
/// Readings of a block where no rate is known: 0.1 s at 100 Hz, 0.5 s at 20 Hz.
const BLOCK_READINGS: f64 = 10.0;
/// The range of counts may be so many times the least one, by which it is guessed.
const MAX_RANGE_RATIO: f64 = 4.0;
/// Fraction of the blocks that is quiet in any recording.
const QUIET_SHARE: f64 = 0.05;
/// Readings stay this near their mean in a pose, as an angle in degrees, by noise, a table that gives way, a
/// hand that wanders or a bias that drifts …
const SAME_DEG: f64 = 1.0;
/// … and this near where no pose is asked for, or none is found.
const HELD_DEG: f64 = 5.0;
/// Blocks of a second.
const BLOCKS_PER_S: usize = 5;
/// A mean rate this far from that of most rests is a turn about the vertical, which the accelerometer does
/// not see, rad/s: 3 °/s, more than a bias drifts or differs between poses.
pub(crate) const TURNING_RAD_S: f64 = 0.052;

/// Rows of a recording as the detector takes them, without rows that are no measurement.
struct Samples {
    /// Row of each sample.
    rows: Vec<usize>,
    time_s: Vec<f64>,
    force: Vec<[f64; 3]>,
    /// Empty without a gyroscope.
    rate: Vec<[f64; 3]>,
    period_s: f64,
    pieces: Vec<Range<usize>>,
    resolution: [f64; 6],
    /// A mean rate this far off is a turn.
    turning_rad_s: f64,
}

/// The static intervals of a recording.
#[derive(Debug, Clone, Default)]
pub struct Rests {
    /// Rows of each, in order.
    pub spans: Vec<Range<usize>>,
    /// The sensor is worn, for half a day or longer: what rests for less than 10 s does not count.
    pub is_worn: bool,
}

/// Finds the static intervals of a recording.
///
/// Rows with empty cells, single spikes and rows in which the sensor hung are no part of what is
/// judged. Without a rate, rests are counted in rows. A recording without rests has none: what shows
/// more than 0.3 m/s² or 2 °/s rms on an axis is no rest, whatever else is in it.
#[must_use]
pub fn find_rests(recording: &Recording) -> Rests {
    let samples = Samples::new(recording);
    let channels = samples.channels();
    let rate = |rest: &Range<usize>| {
        let [.., x, y, z] = channels.mean(rest);
        [x, y, z]
    };
    // A hand that holds the sensor wanders, and a bias drifts: more than a rest of a motion may, and too
    // little to matter for a pose.
    let one_way = |span: &Range<usize>| samples.stays(span, SAME_DEG);
    let (mut rests, others): (Vec<_>, Vec<_>) =
        detect_quiet(&channels).into_iter().partition(one_way);
    if !others.is_empty() {
        let inside = |rest: &Range<usize>| {
            let meets = |span: &Range<usize>| span.start < rest.end && rest.start < span.end;
            others.iter().any(meets)
        };
        rests.extend(detect_rests(&channels).into_iter().filter(inside));
        rests.sort_by_key(|rest| rest.start);
    }
    let rests = without_turns(rests, rate, samples.turning_rad_s);
    let is_worn = samples.hours() >= WORN_HOURS && rests.len() >= MANY_POSES;
    let min_len = match recording.timing.rate_hz() {
        Some(rate_hz) if is_worn => MIN_WORN_REST_S * rate_hz,
        Some(rate_hz) => MIN_REST_S * rate_hz - 0.5,
        None => {
            let lengths = rests.iter().map(|r| r.len() as f64).collect();
            (MIN_SHARE * quantile(lengths, 0.5))
                .max(MIN_BLOCKS_OF_ROWS * BLOCK_S / samples.period_s)
        }
    };
    let long = rests.into_iter().filter(|r| r.len() as f64 >= min_len);
    let rests = long
        .map(|rest| samples.in_rows(&samples.without_ends(rest)))
        .collect();
    Rests {
        spans: rests,
        is_worn,
    }
}

/// Spans of rows that are quiet and point one way, if not to the accuracy of a pose: held by a hand, or at
/// rest while a bias drifts with the temperature.
pub(crate) fn find_quiet(recording: &Recording) -> Vec<Range<usize>> {
    let samples = Samples::new(recording);
    let channels = samples.channels();
    detect_quiet(&channels)
        .iter()
        .filter(|span| samples.stays(span, HELD_DEG))
        .map(|span| samples.in_rows(span))
        .collect()
}

/// The shortest static interval in words: blocks have five rows or more.
fn min_rest(recording: &Recording) -> String {
    match recording.timing.rate_hz() {
        Some(rate_hz) => format!("{:.3} s", MIN_REST_S.max(20.0 / rate_hz)),
        None => "40 readings".to_owned(),
    }
}

/// Why a recording has no static interval.
pub(crate) fn why_never_static(recording: &Recording) -> String {
    if recording.accel_scale.nominal().is_none() {
        return "no second of it is quiet".to_owned();
    }
    let samples = Samples::new(recording);
    let channels = samples.channels();
    let size = block_len(channels.period_s, BLOCK_S);
    let blocks = blocks(&channels, &(0..samples.rows.len()), size);
    let quietest = |sensor| {
        let variances = blocks.iter().map(|b| b.total_variance(sensor)).collect();
        quantile(variances, QUIET_SHARE)
    };
    let rms = |variance: f64| (variance / 3.0).sqrt();
    match [0, 1].map(quietest) {
        [force, _] if force > MAX_VARIANCE[0] => format!(
            "where it is quietest each axis moves by {:.1} m/s² rms, at rest by less than 0.3",
            rms(force)
        ),
        [_, rate] if rate > MAX_VARIANCE[1] => format!(
            "where it is quietest it turns by {:.0} °/s rms, at rest by less than 2",
            rms(rate).to_degrees()
        ),
        _ => format!(
            "what is quiet is shorter than {}, or turns",
            min_rest(recording)
        ),
    }
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

impl Samples {
    /// True if the mean of every block stays near that of the span: within `max_deg`, of its magnitude, so that
    /// a scale that drifts counts like a tilt, and the rate of every second within what is no turn: a hand
    /// trembles faster.
    fn stays(&self, span: &Range<usize>, max_deg: f64) -> bool {
        let channels = &self.channels();
        let mean = |span: &Range<usize>| {
            let [x, y, z, u, v, w] = channels.mean(span);
            ([x, y, z], [u, v, w])
        };
        let (force, rate) = mean(span);
        let limit = max_deg.to_radians() * norm(&force);
        let size = block_len(channels.period_s, BLOCK_S);
        let all = |size, is_near: &dyn Fn(&Range<usize>) -> bool| {
            blocks(channels, span, size)
                .iter()
                .all(|b| is_near(&b.span))
        };
        let keeps_force = |block: &Range<usize>| norm(&sub(&mean(block).0, &force)) < limit;
        let keeps_rate =
            |second: &Range<usize>| norm(&sub(&mean(second).1, &rate)) < self.turning_rad_s;
        all(size, &keeps_force) && all(BLOCKS_PER_S * size, &keeps_rate)
    }

    /// A rest without the block at each end that borders on motion, while the sensor rocks and the hand
    /// lets go; a short rest is left as it is.
    fn without_ends(&self, rest: Range<usize>) -> Range<usize> {
        let size = block_len(self.period_s, BLOCK_S);
        if rest.len() < MIN_BLOCKS_TO_TRIM * size {
            return rest;
        }
        let piece = self.channels().piece(rest.start);
        let trim = |borders: bool| if borders { size } else { 0 };
        rest.start + trim(rest.start > piece.start)..rest.end - trim(rest.end < piece.end)
    }

    fn in_rows(&self, span: &Range<usize>) -> Range<usize> {
        self.rows[span.start]..self.rows[span.end - 1] + 1
    }

    fn new(recording: &Recording) -> Samples {
        let period_s = match recording.timing.rate_hz() {
            Some(rate_hz) => rate_hz.recip(),
            None => BLOCK_S / (BLOCK_READINGS * rows_of_a_reading(recording)),
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
        let step = recording.accel_resolution().map(|step| step / per_mps2);
        take_out_spikes(&mut force, step, period_s);
        let is_whole = |force: &[f64; 3]| force.iter().all(|v| v.is_finite());
        let rows: Vec<usize> = rows.filter(|row| is_whole(&force[*row])).collect();
        force.retain(is_whole);
        let mut samples = Samples {
            time_s: rows.iter().map(|row| *row as f64 * period_s).collect(),
            force,
            rate: Vec::new(),
            period_s,
            pieces: Vec::new(),
            resolution: [0.0; 6],
            turning_rad_s: TURNING_RAD_S,
            rows,
        };
        if let Some(gyro) = &recording.gyro {
            samples.rate = samples.held(gyro);
        }
        samples.part(recording);
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

    /// The gyroscope at each sample; where it was not read, its last reading. Empty if it never was.
    fn held(&self, gyro: &[Vec<f64>; 3]) -> Vec<[f64; 3]> {
        let at = |row: &usize| gyro.each_ref().map(|c| c[*row]);
        let is_read = |v: &[f64; 3]| v.iter().all(|x| x.is_finite());
        let Some(mut last) = self.rows.iter().map(at).find(is_read) else {
            return Vec::new();
        };
        let hold = |row| {
            let now = at(row);
            if is_read(&now) {
                last = now;
            }
            last
        };
        self.rows.iter().map(hold).collect()
    }

    /// Parts the samples at breaks and gaps.
    fn part(&mut self, recording: &Recording) {
        let count = self.rows.len();
        let mut starts: Vec<usize> = recording
            .breaks
            .iter()
            .map(|row| self.rows.partition_point(|r| r < row))
            .collect();
        let gaps =
            (1..count).filter(|i| is_gap(self.time_s[*i] - self.time_s[i - 1], self.period_s));
        starts.extend(gaps);
        starts.sort_unstable();
        starts.dedup();
        self.pieces = between(&starts, count);
    }

    /// Units of the file per rad/s: what is known of it, if the gyroscope may be as quiet as it is in
    /// that; else the first unit in which it may. True if that is the range of counts.
    fn rate_scale(&self, recording: &Recording) -> (f64, bool) {
        let degrees = 1.0_f64.to_degrees();
        // A header that is wrong about the accelerometer says nothing about the gyroscope.
        let header_is_wrong = recording.contradicts_header();
        let known = recording.gyro_scale.filter(|s| match s.origin {
            Origin::Given | Origin::Data => true,
            Origin::Header => !header_is_wrong,
            Origin::Assumed => false,
        });
        let known = known.and_then(|s| s.nominal());
        let is_given = recording
            .gyro_scale
            .is_some_and(|s| s.origin == Origin::Given);
        if let Some(given) = known.filter(|_| is_given) {
            return (given, false);
        }
        // Of counts the finest first: a gyroscope that seems too quiet hides no pose. Those of another
        // file are interpolated, and no whole numbers.
        let counts = [131.0 * degrees, MDPS_PER_DEG_S * degrees];
        let is_whole = self.rate.iter().flatten().all(|v| v.fract() == 0.0);
        let units = [1.0, degrees].into_iter().filter(|_| !is_whole);
        let scales: Vec<f64> = known.into_iter().chain(units).chain(counts).collect();
        let size = block_len(self.period_s, BLOCK_S);
        let blocks = blocks(&self.channels(), &(0..self.rows.len()), size);
        let variances = blocks.iter().map(|b| b.total_variance(1)).collect();
        let level = (quantile(variances, QUIET_SHARE) / 3.0).sqrt();
        let quiet = scales
            .iter()
            .find(|scale| level < MAX_NOISE_RAD_S * **scale);
        let scale = *quiet.or(scales.last()).unwrap_or(&1.0);
        (scale, Some(scale) != known && counts.contains(&scale))
    }

    fn hours(&self) -> f64 {
        self.rows.len() as f64 * self.period_s / 3600.0
    }

    fn channels(&self) -> Channels<'_> {
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

/// The rests in which the sensor does not turn evenly: their mean rates (NaN: unknown) differ by less than
/// `max_off` from the median over the time at rest, the bias.
pub(crate) fn without_turns(
    mut rests: Vec<Range<usize>>,
    mean_rate: impl Fn(&Range<usize>) -> [f64; 3],
    max_off: f64,
) -> Vec<Range<usize>> {
    let bias: [f64; 3] = std::array::from_fn(|axis| {
        let weigh = |rest| (mean_rate(rest)[axis], rest.len() as f64);
        weighted_median(&mut rests.iter().map(weigh).collect::<Vec<_>>()).unwrap_or(0.0)
    });
    rests.retain(|rest| {
        let off = norm(&sub(&mean_rate(rest), &bias));
        off < max_off || off.is_nan()
    });
    rests
}

/// Holds the row before in place of one with a spike, in blocks of a second: those that transmission errors
/// make hide rests.
fn take_out_spikes(force: &mut [[f64; 3]], step: [f64; 3], period_s: f64) {
    let block = ((period_s.recip() + 1e-6).round() as usize).max(1);
    for from in (0..force.len()).step_by(block) {
        let rows = from..(from + block).min(force.len());
        let mut values = [0, 1, 2].map(|i| force[rows.clone()].iter().map(|f| f[i]).collect());
        if spikes::take_out(&mut values, step) == 0 {
            continue;
        }
        for row in rows {
            let is_spike = |i: usize| values[i][row - from].is_nan() && !force[row][i].is_nan();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{ReadOptions, read_bytes};

    /// Rows of six channels, m/s² and rad/s, every 10 ms, or without times.
    fn found(rows: impl Iterator<Item = [f64; 6]>, stamps: bool) -> Vec<Range<usize>> {
        let mut text = String::from(if stamps {
            "t_ms,ax,ay,az,gx,gy,gz\n"
        } else {
            "ax,ay,az,gx,gy,gz\n"
        });
        for (i, row) in rows.enumerate() {
            if stamps {
                text += &format!("{},", 10 * i);
            }
            text += &(row.map(|v| format!("{v:.4}")).join(",") + "\n");
        }
        let recording = read_bytes(text.as_bytes(), "a.csv", &ReadOptions::default()).unwrap();
        find_rests(&recording).spans
    }

    /// Evenly spread, of a standard deviation of one; another for each channel.
    fn noise(i: usize, channel: usize) -> f64 {
        let at = (i * 7919 + channel * 104_729 + i * i * 31) % 1009;
        (at as f64 / 504.0 - 1.0) * 3.0_f64.sqrt()
    }

    fn at_rest(i: usize) -> [f64; 6] {
        let up = [0.0, 0.0, 9.81, 0.0, 0.0, 0.0];
        std::array::from_fn(|c| up[c] + noise(i, c) * if c < 3 { 0.03 } else { 0.002 })
    }

    fn turned(i: usize, pose: usize) -> [f64; 6] {
        let mut row = at_rest(i);
        row[..3].rotate_left(pose % 3);
        row
    }

    #[test]
    fn what_shakes_throughout_is_no_rest_however_evenly() {
        let shaken = |mps2: f64| {
            let add = |i: usize| -> [f64; 6] {
                let row = at_rest(i);
                std::array::from_fn(|c| row[c] + noise(i + 50, c) * if c < 3 { mps2 } else { 0.0 })
            };
            found((0..2000).map(add), true)
        };
        assert_eq!(shaken(0.0).first(), Some(&(0..2000)));
        assert_eq!(shaken(0.9), []);
    }

    /// A turn about the vertical leaves gravity where it is, and is too smooth for a block to show.
    #[test]
    fn a_slow_turn_about_the_vertical_parts_two_rests() {
        for (rest, turn) in [(1000, 1000), (1000, 1200), (6000, 800)] {
            let row = |i: usize| {
                let mut row = at_rest(i);
                if (rest..rest + turn).contains(&i) {
                    let phase = (i - rest) as f64 / turn as f64;
                    let mean_rad_s = std::f64::consts::TAU / (turn as f64 / 100.0);
                    row[5] += mean_rad_s * (1.0 - (std::f64::consts::TAU * phase).cos());
                }
                row
            };
            let rests = found((0..2 * rest + turn).map(row), true);
            assert_eq!(rests.len(), 2, "{rests:?}");
            let slow = 60;
            assert!(rests[0].end <= rest + slow, "{rests:?}");
            assert!(rests[1].start + slow >= rest + turn, "{rests:?}");
        }
    }

    #[test]
    fn rows_of_a_sensor_that_hung_are_no_rest() {
        let row = |i: usize| match i {
            0..400 | 800.. => at_rest(i),
            // Moved, and hung in the move for 1.5 s.
            500..650 => turned(500, 1),
            _ => at_rest(i).map(|v| v + 3.0 * (0.2 * i as f64).sin()),
        };
        let rests = found((0..1200).map(row), true);
        assert_eq!(rests.len(), 2, "{rests:?}");
        // The reader sets the rows aside that repeat.
        assert!(
            rests[0].end <= 400 && rests[1].start >= 800 - 149,
            "{rests:?}"
        );
    }

    #[test]
    fn without_a_rate_rests_are_counted_in_rows() {
        // At 20 Hz: 4 s at rest, 1.5 s of motion.
        let row = |i: usize| match i % 110 {
            0..80 => turned(i, i / 110),
            _ => turned(i, i / 110).map(|v| v + 2.0 * (1.3 * i as f64).sin()),
        };
        let rests = found((0..660).map(row), false);
        assert_eq!(rests.len(), 6, "{rests:?}");
        for (k, rest) in rests.iter().enumerate() {
            assert!(
                rest.start >= 110 * k && rest.end <= 110 * k + 80,
                "{rests:?}"
            );
        }
    }
}
