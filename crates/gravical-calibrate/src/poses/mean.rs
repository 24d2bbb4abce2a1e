//! Mean of a pose and what it is worth: robust against bumps, its standard
//! error from the means of blocks, because neighbouring samples are not
//! independent.

use std::ops::Range;

use gravical_signal::rounding;
use gravical_signal::stats::{mean_of_finite, median};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Fewer blocks than these say nothing about their own scatter.
const MIN_BLOCKS: usize = 8;
/// Blocks further from the median than this many robust standard deviations
/// are a bump.
const BUMP: f64 = 5.0;
/// Lags over which samples may be correlated.
const MAX_LAGS: usize = 20;

/// Noise of the poses of a session: per axis, and how much wider a mean
/// scatters because samples are correlated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseNoise {
    /// Standard deviation of a sample, in the unit of the file.
    pub sigma: [f64; 3],
    /// Variance inflation factor: Var(mean) = σ²·VIF/n.
    pub vif: f64,
    /// Standard deviation that rounding leaves in a mean, however many rows it is
    /// over.
    pub rounding: [f64; 3],
}

/// The mean of a pose.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseMean {
    /// Mean of each axis.
    pub mean: [f64; 3],
    /// Standard error of each, by noise and by rounding; none when there is one row
    /// only.
    pub standard_error: Option<[f64; 3]>,
    /// Rows that the mean is over.
    pub rows: usize,
}

/// Pools the noise of all `poses`: σ over their residuals, and
/// VIF = max(1, 1 + 2 Σ r_k) with r_k the autocorrelation pooled over axes and
/// poses, summed until it first falls under 2/√(n·axes), 20 lags at the most.
///
/// `step` is what the values of each axis are rounded to, in their unit; σ is at
/// least that of rounding, and an axis counts for VIF only as far as its noise shows
/// through: a few flips in a thousand rows say nothing of correlation. A row may be the
/// mean of several `samples`, which are what is rounded.
pub fn pooled_noise(poses: &[[&[f64]; 3]], step: [f64; 3], samples: f64) -> PoseNoise {
    let mut squares = [0.0_f64; 3];
    let mut freedom = [0.0_f64; 3];
    // Residuals of every pose and axis, and what they count for.
    let mut series: Vec<(Vec<f64>, f64)> = Vec::new();
    for pose in poses {
        for (axis, values) in pose.iter().enumerate() {
            let values: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
            if values.len() < 2 {
                continue;
            }
            let rows = values.len() as f64;
            let mean = values.iter().sum::<f64>() / rows;
            let residuals: Vec<f64> = values.iter().map(|v| v - mean).collect();
            let own: f64 = residuals.iter().map(|r| r * r).sum();
            squares[axis] += own;
            freedom[axis] += rows - 1.0;
            if own > 0.0 {
                // Each axis counts alike, whatever its noise, as far as that shows.
                let weight = rows / own * rounding::shown(samples * own / rows, step[axis]);
                series.push((residuals, weight));
            }
        }
    }
    let variance: [f64; 3] = std::array::from_fn(|i| squares[i] / freedom[i].max(1.0));
    let residuals: usize = series.iter().map(|(residuals, _)| residuals.len()).sum();
    let at_lag = |lag: usize| -> f64 {
        let product = |r: &[f64]| {
            r.iter()
                .zip(r.iter().skip(lag))
                .map(|(a, b)| a * b)
                .sum::<f64>()
        };
        series.iter().map(|(r, weight)| weight * product(r)).sum()
    };
    let whole = at_lag(0);
    let vif = 1.0
        + (1..=MAX_LAGS)
            .map(|lag| at_lag(lag) / whole)
            .take_while(|r| *r >= 2.0 / (residuals as f64).sqrt())
            .map(|r| 2.0 * r)
            .sum::<f64>();
    PoseNoise {
        sigma: std::array::from_fn(|i| variance[i].max(rounding::floor(step[i]) / samples).sqrt()),
        vif: vif.max(1.0),
        rounding: std::array::from_fn(|i| {
            rounding::mean_variance(samples * variance[i], step[i]).sqrt()
        }),
    }
}

/// Mean of a pose over blocks: a robust one is without those that stand out, a plain one over all rows, as the
/// student report takes it.
pub fn pose_mean(
    channels: &[&[f64]; 3],
    noise: &PoseNoise,
    rate_hz: f64,
    is_robust: bool,
) -> PoseMean {
    let mut blocks = cut(channels[0].len(), noise, rate_hz);
    if is_robust && blocks.len() >= MIN_BLOCKS {
        blocks = without_bumps(channels, blocks);
    }
    over(channels, &blocks, noise)
}

/// Blocks of at least 0.2 s and five correlation times.
fn cut(rows: usize, noise: &PoseNoise, rate_hz: f64) -> Vec<Range<usize>> {
    // Stamps in milliseconds make 100 Hz 100.0001: that is no row more.
    let width = (0.2 * rate_hz).max(5.0 * noise.vif) - 0.01;
    let width = width.ceil().max(1.0) as usize;
    let count = (rows / width).max(1);
    (0..count)
        .map(|i| i * rows / count..(i + 1) * rows / count)
        .collect()
}

fn without_bumps(channels: &[&[f64]; 3], blocks: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let mut out = vec![false; blocks.len()];
    for channel in channels {
        let means: Vec<f64> = blocks
            .iter()
            .map(|b| mean_of_finite(&channel[b.clone()]))
            .collect();
        let Some(centre) = median(&mut means.clone()) else {
            continue;
        };
        let mut off: Vec<f64> = means.iter().map(|m| (m - centre).abs()).collect();
        // 1.4826 makes the median deviation that of a normal distribution.
        let scale = 1.4826 * median(&mut off).unwrap_or(0.0);
        if scale > 0.0 {
            for (flag, mean) in out.iter_mut().zip(&means) {
                *flag |= (mean - centre).abs() > BUMP * scale || mean.is_nan();
            }
        }
    }
    let kept = blocks.iter().zip(&out).filter(|(_, out)| !**out);
    let kept: Vec<Range<usize>> = kept.map(|(b, _)| b.clone()).collect();
    // More than a third standing out is no bump but the pose itself.
    if kept.len() * 3 < blocks.len() * 2 {
        blocks
    } else {
        kept
    }
}

fn over(channels: &[&[f64]; 3], blocks: &[Range<usize>], noise: &PoseNoise) -> PoseMean {
    let rows: usize = blocks.iter().map(|b| b.len()).sum();
    let mut mean = [f64::NAN; 3];
    let mut error = [f64::NAN; 3];
    for axis in 0..3 {
        let values: Vec<f64> = blocks
            .iter()
            .flat_map(|b| channels[axis][b.clone()].iter().copied())
            .filter(|v| v.is_finite())
            .collect();
        let n = values.len() as f64;
        mean[axis] = values.iter().sum::<f64>() / n;
        let pooled = noise.sigma[axis] * (noise.vif / n).sqrt();
        let scatter = if blocks.len() < MIN_BLOCKS {
            pooled
        } else {
            let count = blocks.len() as f64;
            let squares: f64 = blocks
                .iter()
                .map(|b| (mean_of_finite(&channels[axis][b.clone()]) - mean[axis]).powi(2))
                .sum();
            (squares / (count - 1.0) / count).sqrt() * widening(blocks.len() - 1)
        };
        error[axis] = scatter.hypot(noise.rounding[axis]);
    }
    let standard_error = (rows > 1 && error.iter().all(|e| e.is_finite())).then_some(error);
    PoseMean {
        mean,
        standard_error,
        rows,
    }
}

/// Student's t at 97.5 % over the normal quantile: with it, twice the standard
/// error keeps its meaning however few blocks there were.
fn widening(freedom: usize) -> f64 {
    let t = StudentsT::new(0.0, 1.0, freedom as f64);
    t.map_or(1.0, |t| t.inverse_cdf(0.975) / 1.959_963_984_540_054)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// First-order low-pass with a pole at `pole`: VIF (1 + pole)/(1 − pole).
    fn red(rng: &mut ChaCha8Rng, n: usize, pole: f64) -> Vec<f64> {
        let mut state = 0.0;
        (0..n + 200)
            .map(|_| {
                state = pole * state + rng.sample::<f64, _>(StandardNormal);
                state
            })
            .skip(200)
            .collect()
    }

    #[test]
    fn the_95_percent_interval_covers_behind_rounding() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for (step, low) in [(0.5, 0.92), (2.0, 0.92), (10.0, 0.92), (1000.0, 0.94)] {
            let (mut covered, runs) = (0, 400);
            for _ in 0..runs {
                // Anywhere between two steps, a few poses as in a session.
                let poses: Vec<(f64, Vec<f64>)> = (0..6)
                    .map(|_| {
                        let truth = step * rng.random::<f64>();
                        let rows = red(&mut rng, 400, 0.5);
                        let round = |v: f64| ((truth + v) / step).round() * step;
                        (truth, rows.into_iter().map(round).collect())
                    })
                    .collect();
                let slices: Vec<[&[f64]; 3]> = poses.iter().map(|h| [&h.1[..]; 3]).collect();
                let noise = pooled_noise(&slices, [step; 3], 1.0);
                assert!(noise.vif < 5.0, "{noise:?}");
                for (pose, slices) in poses.iter().zip(&slices) {
                    let found = pose_mean(slices, &noise, 100.0, true);
                    let off = (found.mean[0] - pose.0).abs();
                    covered += usize::from(off < 1.96 * found.standard_error.unwrap()[0]);
                }
            }
            let share = f64::from(covered as u32) / f64::from(6 * runs);
            assert!((low..=1.0).contains(&share), "step {step}: {share}");
        }
    }
}
