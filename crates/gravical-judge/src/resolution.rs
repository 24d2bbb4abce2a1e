//! Resolution of a channel: the step of the converter, or the last decimal place that was
//! printed.

/// Largest number of values examined, evenly distributed over a channel (of a long one at least
/// half as many). Enough to contain neighbouring steps, and fast to sort.
const MAX_VALUES: usize = 1 << 12;
/// Tables with fewer rows contain means, whose differences are not steps.
const MIN_ROWS: usize = 40;
/// Relative difference up to which values are equal: 9.81 − 9.80 is not exactly 0.01 in binary,
/// and 32-bit floats computed differently differ in their last bit.
const SAME: f64 = 3e-7;
/// Largest number of decimal places of a table of means.
const MAX_PLACES: i32 = 9;

/// Resolution of each axis of a sensor, in its unit: the smallest difference between occurring
/// values, 0 if unknown.
///
/// A greatest common divisor would be wrong: counts of 1/131 °/s printed with six decimals have
/// steps of 0.0076. An axis that never changes gets the resolution of the finest other axis, which
/// was measured and printed in the same way; if none changes, and in a table of means, the
/// resolution is the last decimal place in use. For computed values (filtered, rotated,
/// interpolated) the result is far below their noise.
pub fn resolution(sensor: &[Vec<f64>; 3]) -> [f64; 3] {
    let samples = sensor.each_ref().map(|channel| sample(channel));
    let steps = [0, 1, 2].map(|i| smallest_difference(&sensor[i], &samples[i]));
    // The certain ones first.
    let known = steps.iter().flatten();
    let finest = known.min_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)));
    let fallback = finest.map_or_else(|| decimal_step(&samples), |step| step.1);
    steps.map(|step| match step {
        Some((true, step)) => step,
        Some((false, step)) => step.min(fallback),
        None => fallback,
    })
}

/// Values of rows at equal distances, without empty ones, sorted.
fn sample(channel: &[f64]) -> Vec<f64> {
    let stride = channel.len().div_ceil(MAX_VALUES).next_power_of_two();
    let values = channel.iter().copied().step_by(stride);
    let mut values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// The smallest difference between occurring values, and whether it is certain: both occur
/// repeatedly. Otherwise it is an upper limit. `None` for too few rows, or a single value.
fn smallest_difference(channel: &[f64], sample: &[f64]) -> Option<(bool, f64)> {
    if channel.len() < MIN_ROWS {
        return None;
    }
    // If most values occur repeatedly, a single different row is ignored; if they do not, two
    // repeated rows are.
    let often = groups(sample).filter(|g| g.len() > 1);
    if 2 * often.map(<[f64]>::len).sum::<usize>() > sample.len()
        && let Some(step) = smallest_gap(sample, 2)
    {
        return Some((true, step));
    }
    // An axis that changes rarely: the smallest distance from the first value, over all rows.
    let rare = || {
        let first = channel.iter().copied().find(|v| v.is_finite())?;
        let offsets = channel.iter().map(|v| (v - first).abs());
        offsets
            .filter(|off| *off > SAME * first.abs())
            .reduce(f64::min)
    };
    let step = smallest_gap(sample, 1).or_else(rare)?;
    Some((false, step))
}

/// The smallest gap between sorted values that occur at least `least` times.
fn smallest_gap(sorted: &[f64], least: usize) -> Option<f64> {
    let often = groups(sorted).filter(|g| g.len() >= least);
    let mut values = often.map(|g| g[0]);
    let mut before = values.next()?;
    values
        .map(|value| value - std::mem::replace(&mut before, value))
        .reduce(f64::min)
}

/// Groups of equal values in a sorted list.
fn groups(sorted: &[f64]) -> impl Iterator<Item = &[f64]> {
    let ends = [sorted.first(), sorted.last()].into_iter().flatten();
    let largest = ends.fold(0.0, |most: f64, v| most.max(v.abs()));
    sorted.chunk_by(move |a, b| b - a <= SAME * largest)
}

/// The last decimal place in use; 0 if there are more than nine, and if all values are zero.
fn decimal_step(samples: &[Vec<f64>; 3]) -> f64 {
    let values = || samples.iter().flatten();
    let written_with = |p: &f64| values().all(|v| ((v * p).round() - v * p).abs() < 1e-4);
    let mut powers = (0..=MAX_PLACES).map(|places| 10_f64.powi(places));
    let power = powers.find(written_with);
    power
        .filter(|_| values().any(|v| *v != 0.0))
        .map_or(0.0, f64::recip)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// Noise of `sigma` about `mean`, rounded by `write`.
    fn channel(n: usize, mean: f64, sigma: f64, write: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        (0..n)
            .map(|_| write(mean + sigma * rng.sample::<f64, _>(StandardNormal)))
            .collect()
    }

    fn of(values: Vec<f64>) -> f64 {
        resolution(&[values.clone(), values.clone(), values])[0]
    }

    fn decimals(places: i32) -> impl Fn(f64) -> f64 {
        let p = 10_f64.powi(places);
        move |v| (v * p).round() / p
    }

    #[test]
    fn steps_are_found_whatever_wrote_them() {
        let two = |n| channel(n, 9.81, 0.03, decimals(2));
        let flips = |n| channel(n, 0.0, 0.004, decimals(2));
        let constant = |v: f64| vec![v; 500];
        let converted = |v: f64| decimals(6)((v * 131.0).round() / 131.0);
        // In 32 bits, with a bias subtracted.
        let single = |v: f64| f64::from((v * 1670.7).round() as f32 / 1670.7 - 0.123_f32);
        let mut stray = two(5000);
        stray[77] = 9.80665;
        // The stray value is the only other one; a change is rare.
        let (mut quiet, mut rare) = (vec![0.5; 5000], vec![0.02; 200_000]);
        (quiet[77], rare[131_071]) = (3.0, 0.03);
        for (found, wanted) in [
            (of(channel(5000, 9.81, 0.03, decimals(1))), 0.1),
            (of(two(5000)), 0.01),
            (of(channel(5000, 9.81, 0.03, decimals(3))), 0.001),
            (of(channel(5000, -1.7, 0.01, converted)), 1.0 / 131.0),
            (of(channel(5000, 120.0, 20.0, f64::round)), 1.0),
            (of(channel(5000, 9.81, 0.03, single)), 1.0 / 1670.7),
            (of(stray), 0.01),
            (resolution(&[quiet, flips(5000), flips(5000)])[0], 0.01),
            (of(rare), 0.01),
            (
                resolution(&[constant(0.5), flips(500), constant(0.0)])[2],
                0.01,
            ),
            (resolution(&[0.12, -0.3, 9.8].map(constant))[0], 0.01),
        ] {
            assert!((found / wanted - 1.0).abs() < 2e-3, "{found} {wanted}");
        }
        assert_eq!(resolution(&[0.0; 3].map(constant)), [0.0; 3]);
        // Differences of means are not steps.
        let means = [vec![9.43, -0.27], vec![0.1, 10.2], vec![0.0; 2]];
        assert_eq!(resolution(&means), [0.01; 3]);
        // Nor are those of computed values; two repeated rows are not evidence.
        let mut computed = channel(5000, 9.81, 0.03, |v| v);
        assert!(of(computed.clone()) < 1e-5);
        for i in [1000, 3000] {
            computed[i] = computed[i - 1];
        }
        assert!(of(computed) < 1e-5);
    }
}
