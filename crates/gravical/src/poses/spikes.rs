//! Samples that differ from their neighbours: transmission errors, not motion.

use crate::stats::{SortedWindow, median};

/// Neighbours on either side that a sample is compared with: what lasts longer than these
/// is motion, and the blocks of a mean leave it out ([`super::mean`]).
const REACH: usize = 5;
/// A sample further from the median of its neighbourhood than this many robust standard
/// deviations is a spike: normal noise has one in 5·10⁸.
const SPIKE: f64 = 6.0;
/// Shares of the rows between which they are taken out. More are no spikes but the signal.
/// Fewer go with their blocks, where they matter ([`super::mean`]), or are jerks of a hand:
/// what begins and ends at rest has a mean acceleration of zero, but not without its peaks.
const SHARE: [f64; 2] = [0.02, 1.0 / 3.0];
/// Fewest spikes that are taken out: one or two of a short pose depend on the last digit.
const LEAST: f64 = 3.0;

/// Makes the rows of three channels empty in which any of them has a spike, and counts
/// them. `step` is what the values of each are rounded to: less than six of those is never
/// a spike. None are taken out where they are less than 2 % or more than a third.
///
/// The rule rejects single samples, so that means keep the full efficiency of the
/// arithmetic one under normal noise (Hampel, J. Am. Stat. Assoc. 69 (1974) 383).
pub(super) fn take_out(channels: &mut [Vec<f64>; 3], step: [f64; 3]) -> usize {
    let rows = channels[0].len();
    let mut spike = vec![false; rows];
    for (channel, step) in channels.iter().zip(step) {
        let local = neighbourhoods(channel);
        let mut spreads: Vec<f64> = local.iter().map(|[_, spread]| *spread).collect();
        spreads.retain(|v| v.is_finite());
        // 1.4826 makes the median deviation that of a normal distribution.
        let scale = 1.4826 * median(&mut spreads).unwrap_or(0.0);
        let limit = SPIKE * scale.max(step);
        for (flag, [off, _]) in spike.iter_mut().zip(local) {
            *flag |= limit > 0.0 && off.abs() > limit;
        }
    }
    let count = spike.iter().filter(|s| **s).count();
    let [least, most] = SHARE.map(|share| share * rows as f64);
    if !(least.max(LEAST)..=most).contains(&(count as f64)) {
        return 0;
    }
    for channel in channels {
        for (value, _) in channel.iter_mut().zip(&spike).filter(|(_, s)| **s) {
            *value = f64::NAN;
        }
    }
    count
}

/// Of each sample its deviation from the median of its neighbourhood, and the median absolute
/// deviation of the neighbourhood. The latter and not the former gives the scale: behind a
/// low-pass most samples are the median of their neighbours, but not all neighbours are alike.
fn neighbourhoods(channel: &[f64]) -> Vec<[f64; 2]> {
    let rows = channel.len();
    if rows < WIDTH + LANES || !channel.iter().all(|v| v.is_finite()) {
        return one_by_one(channel);
    }
    // Only those at the ends are narrower.
    let mut all = one_by_one(&channel[..2 * REACH])[..REACH].to_vec();
    all.reserve_exact(rows - REACH);
    let mut from = 0;
    while from + WIDTH + LANES - 1 <= rows {
        let near: [[f64; LANES]; WIDTH] =
            std::array::from_fn(|k| std::array::from_fn(|lane| channel[from + k + lane]));
        let median = middle(&near);
        let spread = middle(
            &near.map(|values| std::array::from_fn(|lane| (values[lane] - median[lane]).abs())),
        );
        all.extend((0..LANES).map(|lane| [near[REACH][lane] - median[lane], spread[lane]]));
        from += LANES;
    }
    // The last ones by a window that begins early enough for the first of them.
    all.extend(&one_by_one(&channel[from..])[REACH..]);
    all
}

/// Values of a neighbourhood, and how many of these are evaluated side by side.
const WIDTH: usize = 2 * REACH + 1;
const LANES: usize = 4;

/// The middle of eleven finite values: of more than half of them and one, neither the least nor the
/// greatest is the middle, whatever the others are. Both go and one of the others comes, until none
/// is left.
#[inline]
fn middle(values: &[[f64; LANES]; WIDTH]) -> [f64; LANES] {
    let mut some = [[0.0; LANES]; REACH + 2];
    some.copy_from_slice(&values[..REACH + 2]);
    extremes::<7>(&mut some);
    some[0] = values[7];
    extremes::<6>(&mut some);
    some[0] = values[8];
    extremes::<5>(&mut some);
    some[0] = values[9];
    extremes::<4>(&mut some);
    some[0] = values[10];
    extremes::<3>(&mut some);
    some[1]
}

/// Puts the least of the first `COUNT` values first, and the greatest of them last.
#[inline]
fn extremes<const COUNT: usize>(some: &mut [[f64; LANES]; REACH + 2]) {
    let mut order = |low: usize, high: usize| {
        for lane in 0..LANES {
            let (a, b) = (some[low][lane], some[high][lane]);
            some[low][lane] = if a < b { a } else { b };
            some[high][lane] = if a < b { b } else { a };
        }
    };
    (1..COUNT).for_each(|i| order(0, i));
    (1..COUNT - 1).for_each(|i| order(i, COUNT - 1));
}

/// The same one after the other, of channels with empty cells, too.
fn one_by_one(channel: &[f64]) -> Vec<[f64; 2]> {
    let first = channel.iter().copied().take(REACH);
    let mut near = SortedWindow::new(first.filter(|v| v.is_finite()));
    let rows = 0..channel.len();
    rows.map(|row| {
        let next = channel.get(row + REACH).filter(|v| v.is_finite());
        let past = row.checked_sub(REACH + 1).map(|past| channel[past]);
        if let Some(next) = next {
            near.insert(*next);
        }
        if let Some(past) = past.filter(|v| v.is_finite()) {
            near.remove(past);
        }
        match near.median() {
            Some(median) => [channel[row] - median, near.median_deviation(median)],
            None => [f64::NAN; 2],
        }
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    fn noise(rng: &mut ChaCha8Rng, rows: usize) -> [Vec<f64>; 3] {
        std::array::from_fn(|_| (0..rows).map(|_| rng.sample(StandardNormal)).collect())
    }

    fn mean(values: &[f64]) -> f64 {
        let some = || values.iter().filter(|v| v.is_finite());
        some().sum::<f64>() / some().count() as f64
    }

    #[test]
    fn a_tenth_of_the_samples_does_not_move_the_mean() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut channels = noise(&mut rng, 500);
        let clean = channels.each_ref().map(|c| mean(c));
        for row in 0..500 {
            if rng.random::<f64>() < 0.1 {
                (0..3).for_each(|i| channels[i][row] += [300.0, 40.0, 3.0][i]);
            }
        }
        let count = take_out(&mut channels, [0.0; 3]);
        assert!((30..70).contains(&count), "{count}");
        for (channel, clean) in channels.iter().zip(clean) {
            assert!((mean(channel) - clean).abs() < 0.05, "{}", mean(channel));
        }
    }

    #[test]
    fn noise_of_any_bandwidth_steps_and_bumps_are_not_spikes() {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let mut channels = noise(&mut rng, 500);
        for v in &mut channels[0][300..320] {
            *v += 50.0;
        }
        assert_eq!(take_out(&mut channels, [0.0; 3]), 0);
        // Ten times faster than the noise changes: most samples lie between their neighbours.
        let smooth = noise(&mut rng, 5000).map(|c| {
            let mut state = [0.0; 2];
            let low_pass = |v: f64| {
                state[0] += 0.1 * (v - state[0]);
                state[1] += 0.1 * (state[0] - state[1]);
                state[1]
            };
            c.into_iter().map(low_pass).collect::<Vec<f64>>()
        });
        assert_eq!(take_out(&mut smooth.clone(), [0.0; 3]), 0);
        // Mostly constant, with flips of the last digit.
        let mut rounded = noise(&mut rng, 1000).map(|c| {
            c.into_iter()
                .map(|v: f64| (0.3 * v).round())
                .collect::<Vec<f64>>()
        });
        assert_eq!(take_out(&mut rounded, [1.0; 3]), 0);
    }
}
