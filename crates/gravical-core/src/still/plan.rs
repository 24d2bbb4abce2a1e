//! Lengths in samples, and the noise at rest.

use super::CHANNELS;
use crate::{Real, rounding};

/// Lengths of windows and blocks in samples.
///
/// Everything is a multiple of the block of 0.2 s: windows of 1, 2.5 and 5
/// blocks (20, 50 and 100 samples at 100 Hz), a reference of 25 blocks that ends
/// 5 before the window. Below 25 Hz a block is 5 samples, and everything takes
/// longer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Samples of a block.
    pub block: usize,
    /// Samples of the windows, the shortest first.
    pub windows: [usize; 3],
    /// How far an onset is moved into the rest, samples: 3 of a block of 20.
    pub margin: usize,
}

impl Plan {
    /// Length of a block, s.
    pub const BLOCK_S: f64 = 0.2;
    /// The least samples of a block.
    pub const LEAST_BLOCK: usize = 5;
    /// Blocks that have to agree where a rest begins.
    pub const SEED_BLOCKS: usize = 5;
    /// Blocks of a whole reference: 5 s.
    pub const REFERENCE_BLOCKS: usize = 25;
    /// Blocks of a reference that is kept away from the window: 2 s.
    pub const LEAST_REFERENCE: usize = 10;
    /// Blocks between reference and window: 1 s.
    pub const GAP_BLOCKS: usize = 5;

    /// For a sampling rate in Hz; one that is no number counts as very low.
    #[must_use]
    pub fn new<T: Real>(rate_hz: T) -> Self {
        let wanted = (rate_hz * T::from_f64(Self::BLOCK_S)).round();
        Self::of_block(wanted.to_usize().unwrap_or(0))
    }

    /// For blocks of so many samples.
    #[must_use]
    pub fn of_block(samples: usize) -> Self {
        let block = samples.clamp(Self::LEAST_BLOCK, 1 << 24);
        Plan {
            block,
            windows: [block, block * 5 / 2, block * 5],
            margin: (block * 3).div_ceil(20),
        }
    }

    /// Samples of one second, in which an onset is looked for.
    #[must_use]
    pub fn onset_samples(&self) -> usize {
        self.block * 5
    }
}

/// Noise of a sensor that rests, per channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RestNoise<T> {
    /// n times the variance of a mean of n samples, n a window: σ²·VIF, (m/s²)²
    /// or (rad/s)². One for each of the three windows.
    pub mean_variance: [[T; CHANNELS]; 3],
    /// Variance of a sample, σ², (m/s²)² or (rad/s)².
    pub variance: [T; CHANNELS],
    /// Variance inflation factor of the gyroscope, 1 or more.
    pub gyro_vif: T,
    /// False without a gyroscope: then its channels count nothing.
    pub has_gyro: bool,
}

impl<T: Real> RestNoise<T> {
    /// From standard deviations of a sample and variance inflation factors.
    #[must_use]
    pub fn new(accel_sigma: [T; 3], accel_vif: T, gyro: Option<([T; 3], T)>) -> Self {
        let (gyro_sigma, gyro_vif) = gyro.unwrap_or(([T::one(); 3], T::one()));
        let variance: [T; CHANNELS] = core::array::from_fn(|c| match c {
            0..3 => accel_sigma[c] * accel_sigma[c],
            _ => gyro_sigma[c - 3] * gyro_sigma[c - 3],
        });
        let vif = [accel_vif, gyro_vif];
        RestNoise {
            mean_variance: [core::array::from_fn(|c| variance[c] * vif[c / 3]); 3],
            variance,
            gyro_vif,
            has_gyro: gyro.is_some(),
        }
    }

    /// The same where samples are rounded to steps of `step`, each channel (m/s² or
    /// rad/s; 0 where nothing is known of them): no variance is less than that of
    /// rounding ([`rounding::sample_variance`]), and what rounding leaves in a mean
    /// ([`rounding::mean_variance`]) does not shrink with the window.
    #[must_use]
    pub fn rounded(self, plan: &Plan, step: &[T; CHANNELS]) -> Self {
        let left = core::array::from_fn(|c| rounding::mean_variance(self.variance[c], step[c]));
        self.with_rounding(plan, step, &left)
    }

    /// The same where it is known from elsewhere which variance rounding leaves in a
    /// mean, (m/s²)² or (rad/s)²: from many rests, say, or from counts.
    #[must_use]
    pub fn with_rounding(
        mut self,
        plan: &Plan,
        step: &[T; CHANNELS],
        left: &[T; CHANNELS],
    ) -> Self {
        for c in 0..CHANNELS {
            let left = left[c];
            let floor = rounding::floor(step[c]);
            self.variance[c] = self.variance[c].max(floor + left + left);
            for (means, window) in self.mean_variance.iter_mut().zip(plan.windows) {
                // A variance of zero has no ratio to go by.
                let white = means[c].max(floor);
                means[c] = white + left * T::from_f64(window as f64);
            }
        }
        self
    }

    /// True when the samples scatter about the means of their blocks by no more than
    /// three times their noise, each sensor by itself: what shakes is no rest, even
    /// where its means agree. `variance` is that of the samples.
    #[must_use]
    pub fn quiet(&self, variance: &[T; CHANNELS]) -> bool {
        let sensors = if self.has_gyro { 2 } else { 1 };
        (0..sensors).all(|sensor| {
            let (mut found, mut noise) = (T::zero(), T::zero());
            for c in 3 * sensor..3 * sensor + 3 {
                found = found + variance[c];
                noise = noise + self.variance[c];
            }
            found <= T::from_f64(QUIET) * noise
        })
    }

    /// True when five means of blocks agree, each sensor by itself: χ² of their
    /// scatter against 12 degrees of freedom at 10⁻⁶.
    #[must_use]
    pub fn agree(&self, means: &[[T; CHANNELS]; Plan::SEED_BLOCKS], block: usize) -> bool {
        let sensors = if self.has_gyro { 2 } else { 1 };
        let count = T::from_f64(Plan::SEED_BLOCKS as f64);
        let weight = T::from_f64(block as f64);
        (0..sensors).all(|sensor| {
            let mut chi2 = T::zero();
            for c in 3 * sensor..3 * sensor + 3 {
                // Less the first one: gravity would cost f32 its digits.
                let first = means[0][c];
                let mut sum = T::zero();
                let mut squares = T::zero();
                for mean in means {
                    let off = mean[c] - first;
                    sum = sum + off;
                    squares = squares + off * off;
                }
                let scatter = (squares - sum * sum / count).max(T::zero());
                chi2 = chi2 + scatter * weight / self.mean_variance[0][c];
            }
            // Also false when it is no number.
            chi2 <= T::from_f64(SEED_LIMIT)
        })
    }
}

/// Quantile of χ² with 12 degrees of freedom at 1 − 10⁻⁶.
const SEED_LIMIT: f64 = 50.825_252_138_874_45;
/// Square of how many times its noise a quiet sensor may scatter.
const QUIET: f64 = 9.0;
