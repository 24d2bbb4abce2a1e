//! Where a gyroscope stands at the end of its range.

use crate::full_scale::FULL_SCALES_DEG_S;
use crate::units::{GyroScale, GyroUnit};

/// Values of a channel at and beyond which it is clipped; none when it never
/// is. The end of the range is known where the unit is; everywhere it shows as
/// three or more readings in a row at the channel's own extreme that the signal comes
/// to, or leaves, in a step far above its last digit: the top of a smooth
/// motion is reached in small ones.
#[must_use]
pub fn range_end(channel: &[f64], scale: Option<GyroScale>) -> Option<[f64; 2]> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut digit = f64::INFINITY;
    let mut before = f64::NAN;
    for &v in channel {
        low = low.min(v);
        high = high.max(v);
        let change = (v - before).abs();
        if change > 0.0 {
            digit = digit.min(change);
        }
        before = v;
    }
    if !digit.is_finite() {
        return None;
    }
    let signed = low < 16384.0;
    let repeats = |extreme: f64| channel.iter().filter(|v| **v == extreme).take(3).count() == 3;
    let at_end = |extreme: f64| {
        known_end(extreme, signed, scale) && (is_counts(scale) || repeats(extreme))
            || flat_top(channel, extreme, digit)
    };
    let (bottom, top) = (at_end(low), at_end(high));
    (bottom || top).then_some([
        if bottom { low } else { f64::NEG_INFINITY },
        if top { high } else { f64::INFINITY },
    ])
}

fn is_counts(scale: Option<GyroScale>) -> bool {
    scale.is_some_and(|s| s.unit == GyroUnit::Counts)
}

fn known_end(extreme: f64, signed: bool, scale: Option<GyroScale>) -> bool {
    let Some(scale) = scale else { return false };
    if scale.unit == GyroUnit::Counts {
        // 16-bit values, signed, or unsigned around 32768.
        return if signed {
            (32767.0..=32768.0).contains(&extreme.abs())
        } else {
            extreme == 65535.0
        };
    }
    scale.nominal().is_some_and(|nominal| {
        let rate_deg_s = (extreme / nominal).to_degrees().abs();
        FULL_SCALES_DEG_S
            .iter()
            .any(|full| rate_deg_s <= full * 1.0005 && rate_deg_s >= full * (1.0 - 2.5 / 32768.0))
    })
}

fn flat_top(channel: &[f64], extreme: f64, digit: f64) -> bool {
    if !channel.windows(3).any(|w| w == [extreme; 3]) {
        return false;
    }
    // Lengths of the runs that begin or end with such a step.
    let mut lengths = Vec::new();
    let (mut from, mut longest) = (0, 0);
    for run in channel.chunk_by(|a, b| a == b) {
        let to = from + run.len();
        let beside = [from.checked_sub(1), Some(to)].map(|i| channel.get(i?));
        let mut steps = beside.into_iter().flatten().map(|v| (v - run[0]).abs());
        if steps.any(|step| step > 5.0 * digit) {
            lengths.push(run.len());
            if run[0] == extreme {
                longest = longest.max(run.len());
            }
        }
        from = to;
    }
    // Where values are held, or read faster than they are measured, each of them
    // stands in several rows.
    let quarter = lengths.len() / 4;
    longest > 0 && longest >= 3 * *lengths.select_nth_unstable(quarter).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_top_is_clipped_and_a_round_one_is_not() {
        let wave = |limit: f64, digit: f64| -> Vec<f64> {
            (0..400)
                .map(|i| {
                    let v = 300.0 * (f64::from(i) * 0.05).sin();
                    (v / digit).round() * digit
                })
                .map(|v| v.clamp(-limit, limit))
                .collect()
        };
        assert_eq!(range_end(&wave(1e9, 0.01), None), None);
        assert_eq!(range_end(&wave(1e9, 5.0), None), None);
        let clipped = range_end(&wave(250.0, 0.01), None).unwrap();
        assert_eq!(clipped, [-250.0, 250.0]);
        assert_eq!(range_end(&[1.0; 50], None), None);
        // Every value is held over four rows.
        let held = |wave: Vec<f64>| wave.into_iter().flat_map(|v| [v; 4]).collect::<Vec<_>>();
        assert_eq!(range_end(&held(wave(1e9, 0.01)), None), None);
        assert_eq!(range_end(&held(wave(250.0, 0.01)), None), Some(clipped));
    }
}
