//! Samples that differ from their neighbours: transmission errors, not motion.

use std::ops::Range;

use gravical_signal::stats::median;

/// Neighbours on either side that a sample is compared with: what lasts longer than these
/// is motion, and the blocks of a mean leave it out ([`super::mean`]).
pub(super) const REACH: usize = 5;
const WIDTH: usize = 2 * REACH + 1;
/// The scale uses at least this many neighbourhoods, where the channel has them.
const MIN_NEIGHBOURHOODS: usize = 20;
/// A sample further from the median of its neighbourhood than this many robust standard
/// deviations is a spike: normal noise has one in 5·10⁸.
const SPIKE: f64 = 6.0;
/// Shares of the rows between which they are taken out. More are no spikes but the signal.
/// Fewer go with their blocks, where they matter ([`super::mean`]), or are jerks of a hand:
/// what begins and ends at rest has a mean acceleration of zero, but not without its peaks.
const SHARE: [f64; 2] = [0.02, 1.0 / 3.0];
/// Fewest spikes that are taken out: one or two of a short pose depend on the last digit.
const MIN_SPIKES: f64 = 3.0;

/// Makes the rows of three channels empty in which any of them has a spike, and counts them. `inner`: rows that
/// may be emptied; the others serve as neighbours only. `step` is what the values of each are rounded to: less
/// than six of those is never a spike. None are taken out where they are less than 2 % or more than a third.
///
/// The rule rejects single samples, so that means keep the full efficiency of the
/// arithmetic one under normal noise (Hampel, J. Am. Stat. Assoc. 69 (1974) 383).
pub(super) fn take_out(channels: &mut [Vec<f64>; 3], step: [f64; 3], inner: Range<usize>) -> usize {
    let rows = inner.len();
    let mut spike = vec![false; channels[0].len()];
    for (channel, step) in channels.iter().zip(step) {
        mark(channel, step, &mut spike);
    }
    spike[..inner.start].fill(false);
    spike[inner.end..].fill(false);
    let count = spike.iter().filter(|s| **s).count();
    let [least, most] = SHARE.map(|share| share * rows as f64);
    if !(least.max(MIN_SPIKES)..=most).contains(&(count as f64)) {
        return 0;
    }
    for channel in channels {
        for (value, _) in channel.iter_mut().zip(&spike).filter(|(_, s)| **s) {
            *value = f64::NAN;
        }
    }
    count
}

/// Marks the spikes of a channel. The median deviation within neighbourhoods gives the scale, not that of
/// samples from the median of theirs: behind a low-pass most samples are the median of their neighbours,
/// but not all neighbours are alike.
fn mark(channel: &[f64], step: f64, spike: &mut [bool]) {
    let rows = channel.len();
    let near =
        |row: usize| spread(&channel[row.saturating_sub(REACH)..(row + REACH + 1).min(rows)]);
    let every = (rows / MIN_NEIGHBOURHOODS).clamp(1, WIDTH);
    let spreads = (0..rows).step_by(every).filter_map(near);
    let mut spreads: Vec<f64> = spreads.map(|[_, spread]| spread).collect();
    // 1.4826 makes the median deviation that of a normal distribution.
    let limit = SPIKE * (1.4826 * median(&mut spreads).unwrap_or(0.0)).max(step);
    if limit <= 0.0 {
        return;
    }
    for from in (0..rows).step_by(WIDTH) {
        let end = (from + WIDTH).min(rows);
        let around = &channel[from.saturating_sub(REACH)..(end + REACH).min(rows)];
        let low = around.iter().copied().fold(f64::INFINITY, f64::min);
        let high = around.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // A range below the limit cannot hold a spike.
        if high - low <= limit {
            continue;
        }
        for row in from..end {
            spike[row] |=
                near(row).is_some_and(|[middle, _]| (channel[row] - middle).abs() > limit);
        }
    }
}

/// The median of a neighbourhood, and the median deviation from it.
fn spread(neighbours: &[f64]) -> Option<[f64; 2]> {
    if let Ok(whole) = neighbours.try_into()
        && neighbours.iter().all(|v| v.is_finite())
    {
        return Some(spread_of_whole(whole));
    }
    let mut values: Vec<f64> = neighbours
        .iter()
        .copied()
        .filter(|v| v.is_finite())
        .collect();
    let middle = median(&mut values)?;
    values.iter_mut().for_each(|v| *v = (*v - middle).abs());
    Some([middle, median(&mut values)?])
}

/// The same of a whole one, without branches: of the time that a long recording takes this is the most.
fn spread_of_whole(mut sorted: [f64; WIDTH]) -> [f64; 2] {
    let less = |a: f64, b: f64| if a < b { a } else { b };
    let more = |a: f64, b: f64| if a < b { b } else { a };
    for round in 0..WIDTH {
        for i in (round % 2..WIDTH - 1).step_by(2) {
            let (a, b) = (sorted[i], sorted[i + 1]);
            (sorted[i], sorted[i + 1]) = (less(a, b), more(a, b));
        }
    }
    let middle = sorted[REACH];
    // As many values as REACH are no further off than the median deviation, some of them below the middle.
    let spread = (0..=REACH).map(|below| {
        let low = middle - sorted[REACH - below];
        let high = sorted[2 * REACH - below] - middle;
        more(low, high)
    });
    [middle, spread.fold(f64::INFINITY, less)]
}

#[cfg(test)]
mod tests {
    use super::{WIDTH, spread, spread_of_whole};

    #[test]
    fn a_whole_neighbourhood_has_the_medians_of_any_other() {
        for seed in 0..500_u32 {
            let value = |i: u32| ((seed * 31 + i) * 7919 % 13) as f64 - 6.0;
            let values: [f64; WIDTH] = std::array::from_fn(|i| value(i as u32));
            // With a value that is no number it goes the other way.
            let longer = [&values[..], &[f64::NAN]].concat();
            assert_eq!(Some(spread_of_whole(values)), spread(&longer), "{values:?}");
        }
    }
}
