//! Static intervals of a recording, by the detector of rests ([`gravical_signal::detect_rests`]).

use std::ops::Range;

use gravical_core::matrix3::{norm, sub};
use gravical_signal::stats::{moments, weighted_median};
use gravical_signal::{
    BLOCK_S, MAX_VARIANCE, RestTolerance, Samples, block_len, detect_rests, quantile,
};

use super::face::{Claim, angle_deg};
use super::nominal::NominalSamples;
use super::stills::{HELD_DEG, SAME_DEG, brief_rests};
#[doc(hidden)]
pub use crate::finding::Restless;
use crate::recording::Recording;

/// Shortest static interval, s: a shorter pause of a hand is no pose.
pub const MIN_REST_S: f64 = 1.0;
/// Nobody places a sensor in so many poses: they are found in days of wear, and enough to test a model on
/// eighths of them.
pub(crate) const MANY_POSES: usize = 64;
/// A rest of fewer blocks is used to its ends.
const MIN_BLOCKS_TO_TRIM: usize = 6;
/// So many hours hold more static intervals than poses that somebody placed a sensor in: it is worn …
const WORN_HOURS: f64 = 12.0;
/// … and rests for at least this long, s (van Hees et al., J. Appl. Physiol. 117 (2014) 738).
const MIN_WORN_REST_S: f64 = 10.0;
/// Shortest static interval where no rate is known, in blocks …
const MIN_REST_BLOCKS: f64 = 4.0;
/// … and as a fraction of the median number of rows of a rest.
const MIN_SHARE: f64 = 0.4;
/// Directions further apart than this are two poses, degrees: a pose
/// that is taken up and put down again comes back within a few.
pub(super) const APART_DEG: f64 = 10.0;
/// Beside the pose that the name of a file speaks of, a rest shorter than
/// this share of it is handling.
const HANDLING: f64 = 0.25;
/// Share of the rows at rest below which rests may be shorter than those that were looked for, and above
/// which short ones are those of a session: in a motion pauses are fewer.
const HARDLY_STATIC: f64 = 0.1;
const MOSTLY_STATIC: f64 = 0.5;

/// The rows of the static intervals of a recording, in order.
///
/// Rows with empty cells are left out; a spike is replaced by the row before it. Without a rate, rests are
/// counted in readings: 40, or 20 or 10 where that makes a recording a series of rests. What shows
/// more than 0.3 m/s² or 2 °/s rms on an axis is not a rest, whatever else is in the recording.
pub fn find_rests(recording: &Recording) -> Vec<Range<usize>> {
    rests_in(recording, &NominalSamples::new(recording))
}

/// The same of samples that are made.
pub(super) fn rests_in(recording: &Recording, nominal: &NominalSamples) -> Vec<Range<usize>> {
    let rests = rests_of(recording, nominal);
    let share = |rests: &[Range<usize>]| {
        let at_rest: usize = rests.iter().map(ExactSizeIterator::len).sum();
        at_rest as f64 / recording.rows().max(1) as f64
    };
    if recording.clock.rate_hz().is_some() || share(&rests) > HARDLY_STATIC {
        return rests;
    }
    let short = rests_of(recording, &NominalSamples::for_short_rests(recording));
    if share(&short) > MOSTLY_STATIC {
        return short;
    }
    let brief = nominal.without_turns(brief_rests(&nominal.samples));
    let brief: Vec<Range<usize>> = brief.iter().map(|span| nominal.in_rows(span)).collect();
    if share(&brief) > MOSTLY_STATIC {
        brief
    } else {
        rests
    }
}

fn rests_of(recording: &Recording, nominal: &NominalSamples) -> Vec<Range<usize>> {
    let channels = &nominal.samples;
    // More than a rest of a motion may wander, and too little to matter for a pose.
    let rests = nominal.without_turns(detect_rests(channels, nominal.tolerance(SAME_DEG)));
    // The sensor is worn: what rests for less does not count.
    let hours = channels.time_s.len() as f64 * channels.period_s / 3600.0;
    let is_worn = hours >= WORN_HOURS && rests.len() >= MANY_POSES;
    let min_len = match recording.clock.rate_hz() {
        Some(rate_hz) if is_worn => MIN_WORN_REST_S * rate_hz,
        Some(rate_hz) => MIN_REST_S * rate_hz - 0.5,
        None => min_samples_without_rate(rests.iter().map(ExactSizeIterator::len), channels),
    };
    let long = rests.into_iter().filter(|r| r.len() as f64 >= min_len);
    long.map(|rest| nominal.in_rows(&nominal.without_ends(rest)))
        .collect()
}

/// Samples of the shortest static interval among others where no rate is known.
pub(super) fn min_samples_without_rate(
    rests: impl Iterator<Item = usize>,
    samples: &Samples,
) -> f64 {
    let median = quantile(rests.map(|len| len as f64).collect(), 0.5);
    (MIN_SHARE * median).max(MIN_REST_BLOCKS * BLOCK_S / samples.period_s)
}

/// Spans of rows that are quiet and point one way, if not to the accuracy of a pose: held by a hand, or at
/// rest while a bias drifts with the temperature.
#[doc(hidden)]
pub fn find_quiet(recording: &Recording) -> Vec<Range<usize>> {
    quiet_in(&NominalSamples::new(recording))
}

/// The same of samples that are made.
pub(super) fn quiet_in(nominal: &NominalSamples) -> Vec<Range<usize>> {
    let quiet = detect_rests(&nominal.samples, nominal.tolerance(HELD_DEG));
    quiet.iter().map(|span| nominal.in_rows(span)).collect()
}

/// How far a motion may reach into the rests around it, s: it begins and ends so slowly
/// that this is taken for rest.
const SLOW_END_S: f64 = 0.5;

/// The rows from the end of one rest to the start of the next, and as much of both as
/// may hide the slow beginning and end of the motion between them: less the bias, what
/// is rest adds but noise.
pub(crate) fn with_slow_ends(
    recording: &Recording,
    before: &Range<usize>,
    after: &Range<usize>,
) -> Range<usize> {
    let most = (SLOW_END_S * recording.working_rate_hz()) as usize;
    // The greater part of a static interval is rest.
    let hidden = |rest: &Range<usize>| most.min(rest.len() / 3);
    before.end - hidden(before)..after.start + hidden(after)
}

/// Why a recording has no static interval.
#[doc(hidden)]
pub fn why_never_static(recording: &Recording) -> Restless {
    if recording.units.accel.nominal().is_none() {
        return Restless::UnknownUnit;
    }
    let nominal = NominalSamples::new(recording);
    let max_rms = MAX_VARIANCE.map(|variance| (variance / 3.0).sqrt());
    match [0, 1].map(|sensor| nominal.quietest_rms(sensor)) {
        [force, _] if force > max_rms[0] => Restless::Moves { mps2: force },
        [_, rate] if rate > max_rms[1] => Restless::Turns {
            deg_per_s: rate.to_degrees(),
        },
        _ => Restless::Short {
            least_s: MIN_REST_S,
        },
    }
}

impl NominalSamples {
    /// How far a pose may move.
    fn tolerance(&self, tilt_deg: f64) -> RestTolerance {
        RestTolerance {
            tilt_rad: tilt_deg.to_radians(),
            rate_rad_s: self.turning_rad_s,
            steps_are_turns: !self.has_clock,
        }
    }

    /// Mean specific force and angular rate of a span.
    fn mean(&self, span: &Range<usize>) -> ([f64; 3], [f64; 3]) {
        let [x, y, z, u, v, w] = self.samples.mean(span);
        ([x, y, z], [u, v, w])
    }

    /// A rest without the block at each end that borders on motion, while the sensor rocks and the hand
    /// lets go; a short rest is left as it is.
    fn without_ends(&self, rest: Range<usize>) -> Range<usize> {
        let size = block_len(self.samples.period_s, BLOCK_S);
        if rest.len() < MIN_BLOCKS_TO_TRIM * size {
            return rest;
        }
        let piece = self.samples.piece(rest.start);
        let trim = |borders: bool| size * usize::from(borders);
        rest.start + trim(rest.start > piece.start)..rest.end - trim(rest.end < piece.end)
    }

    /// The rests in which the sensor does not turn evenly: their mean rates (NaN: unknown) differ by little
    /// from the median over the time at rest, the bias.
    pub(super) fn without_turns(&self, mut rests: Vec<Range<usize>>) -> Vec<Range<usize>> {
        let bias: [f64; 3] = std::array::from_fn(|axis| {
            let weigh = |rest| (self.mean(rest).1[axis], rest.len() as f64);
            weighted_median(&mut rests.iter().map(weigh).collect::<Vec<_>>()).unwrap_or(0.0)
        });
        rests.retain(|rest| {
            let off = norm(&sub(&self.mean(rest).1, &bias));
            off < self.turning_rad_s || off.is_nan()
        });
        rests
    }
}

/// The longest rest of every direction, in order.
pub(super) fn directions(
    recording: &Recording,
    rests: &[Range<usize>],
    claimed: Option<Claim>,
) -> Vec<Range<usize>> {
    let mut found: Vec<([f64; 3], Range<usize>)> = Vec::new();
    for span in rests {
        let (mean, _) = moments(&recording.accel, span.clone());
        match found
            .iter_mut()
            .find(|(other, _)| angle_deg(*other, mean) < APART_DEG)
        {
            Some((_, kept)) if kept.len() < span.len() => *kept = span.clone(),
            Some(_) => {}
            None => found.push((mean, span.clone())),
        }
    }
    if matches!(claimed, Some(Claim::Face(_))) {
        let longest = found.iter().map(|(_, s)| s.len()).max().unwrap_or(0);
        found.retain(|(_, s)| s.len() as f64 >= HANDLING * longest as f64);
    }
    found.sort_by_key(|(_, s)| s.start);
    found.into_iter().map(|(_, s)| s).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{ReadOptions, read_bytes};

    /// Rows of six channels, m/s² and rad/s, every 10 ms.
    fn found(rows: impl Iterator<Item = [f64; 6]>) -> Vec<Range<usize>> {
        let mut text = String::from("t_ms,ax,ay,az,gx,gy,gz\n");
        for (i, row) in rows.enumerate() {
            let cells = row.map(|v| format!("{v:.4}")).join(",");
            text += &format!("{},{cells}\n", 10 * i);
        }
        let recording = read_bytes(text.as_bytes(), "a.csv", &ReadOptions::default()).unwrap();
        find_rests(&recording)
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
            let rests = found((0..2 * rest + turn).map(row));
            assert_eq!(rests.len(), 2, "{rests:?}");
            let slow = 60;
            assert!(rests[0].end <= rest + slow, "{rests:?}");
            assert!(rests[1].start + slow >= rest + turn, "{rests:?}");
        }
    }

    /// An axis that stands at the end of its values is no clipped one, and a jump of all axes no knock.
    #[test]
    fn coarse_steps_and_transmission_errors_hide_no_face() {
        let (hold, motion) = (400, 10);
        let faces = [
            [9.8, 0.3],
            [-9.4, 0.2],
            [0.1, 9.9],
            [0.2, -9.6],
            [-0.3, 0.4],
        ];
        let row = |i: usize, step: f64, spike: f64| {
            let (k, at) = (i / (hold + motion), i % (hold + motion));
            let next = faces[(k + 1) % faces.len()];
            let share = at.saturating_sub(hold) as f64 / motion as f64;
            let [x, y] = [0, 1].map(|c| faces[k][c] + share * (next[c] - faces[k][c]));
            let up = [x, y, if k == 4 { 9.7 } else { 0.5 }];
            let is_hit = i * 7919 % 29 == 3;
            std::array::from_fn(|c| match c {
                3.. => 0.002 * noise(i, c),
                _ if is_hit => up[c] + spike * noise(i, c).signum(),
                _ => ((up[c] + 0.02 * noise(i, c)) / step).round() * step,
            })
        };
        for (step, spike) in [(0.15, 0.0), (0.01, 4.0), (0.01, 8.0), (0.01, 20.0)] {
            let rests = found((0..5 * (hold + motion)).map(|i| row(i, step, spike)));
            assert_eq!(rests.len(), 5, "{step} {spike} {rests:?}");
        }
    }
}
