//! The noise of a sensor that rests, learnt from its first seconds.

use super::{CHANNELS, Plan, RestNoise};
use crate::{Real, rounding};

/// VIF beyond this: it moved. Behind a low-pass of 5 Hz at 100 Hz it is 9.
const MOST_VIF: f64 = 30.0;

/// Learns the noise from a rest: σ² within blocks of 0.2 s, VIF from the scatter of
/// their means.
///
/// The scatter of n blocks gives VIF to √(2/(3(n − 1))): 22 % for 15 blocks, which is
/// 3 s. It is only as good as the rest: lay the sensor down.
#[derive(Debug, Clone)]
pub struct Learner<T> {
    plan: Plan,
    has_gyro: bool,
    step: [T; CHANNELS],
    samples: usize,
    blocks: usize,
    first: [T; CHANNELS],
    sum: [T; CHANNELS],
    square: [T; CHANNELS],
    within: [T; CHANNELS],
    means: [T; CHANNELS],
    mean_squares: [T; CHANNELS],
}

impl<T: Real> Learner<T> {
    /// Starts to learn.
    #[must_use]
    pub fn new(plan: Plan, has_gyro: bool) -> Self {
        let zero = [T::zero(); CHANNELS];
        Learner {
            plan,
            has_gyro,
            step: zero,
            samples: 0,
            blocks: 0,
            first: zero,
            sum: zero,
            square: zero,
            within: zero,
            means: zero,
            mean_squares: zero,
        }
    }

    /// The same for readings that are rounded to steps of `step`, specific force
    /// (m/s²) and then angular rate (rad/s): one count of the converter, or the last
    /// decimal place. A channel that never changes then has the noise of rounding;
    /// without, there is none to be learnt from it.
    #[must_use]
    pub fn rounded(mut self, step: [T; CHANNELS]) -> Self {
        self.step = step;
        self
    }

    /// Takes a sample: specific force, m/s², and angular rate, rad/s. One with a
    /// value that is not finite is left out.
    pub fn update(&mut self, force_mps2: [T; 3], rate_rad_s: Option<[T; 3]>) {
        let [a, b, c] = force_mps2;
        let [d, e, f] = rate_rad_s.unwrap_or([T::zero(); 3]);
        let value = [a, b, c, d, e, f];
        if !value.iter().all(|v| v.is_finite()) {
            return;
        }
        if self.samples == 0 {
            // Less the first sample: gravity would cost f32 its digits.
            self.first = value;
        }
        self.samples += 1;
        for c in 0..CHANNELS {
            let off = value[c] - self.first[c];
            self.sum[c] = self.sum[c] + off;
            self.square[c] = self.square[c] + off * off;
        }
        if !self.samples.is_multiple_of(self.plan.block) {
            return;
        }
        self.blocks += 1;
        let count = T::from_f64(self.plan.block as f64);
        for c in 0..CHANNELS {
            let mean = self.sum[c] / count;
            self.within[c] = self.within[c] + (self.square[c] - mean * self.sum[c]);
            self.means[c] = self.means[c] + mean;
            self.mean_squares[c] = self.mean_squares[c] + mean * mean;
        }
        self.sum = [T::zero(); CHANNELS];
        self.square = [T::zero(); CHANNELS];
    }

    /// The noise; none before five blocks, where a channel has no noise at all and
    /// its steps are not known, or where the means scatter so much that it moved.
    #[must_use]
    pub fn noise(&self) -> Option<RestNoise<T>> {
        if self.blocks < Plan::SEED_BLOCKS {
            return None;
        }
        let n = T::from_f64(self.blocks as f64);
        let b = T::from_f64(self.plan.block as f64);
        let one = T::one();
        // Variance within blocks, and of their means.
        let within: [T; CHANNELS] = core::array::from_fn(|c| self.within[c] / (n * (b - one)));
        let between: [T; CHANNELS] = core::array::from_fn(|c| {
            (self.mean_squares[c] - self.means[c] * self.means[c] / n) / (n - one)
        });
        // A block takes the share VIF/b of the variance with its mean.
        let found: [T; CHANNELS] = core::array::from_fn(|c| within[c] * (b - one) / b + between[c]);
        let variance: [T; CHANNELS] =
            core::array::from_fn(|c| found[c].max(rounding::floor(self.step[c])));
        let sensors = if self.has_gyro { 2 } else { 1 };
        let mut vif = [one; 2];
        for (sensor, vif) in vif.iter_mut().enumerate().take(sensors) {
            let mut ratio = T::zero();
            for c in 3 * sensor..3 * sensor + 3 {
                ratio = ratio + b * between[c] / variance[c] / T::from_f64(3.0);
            }
            // Also refuses what is no number.
            if ratio.is_nan() || ratio > T::from_f64(MOST_VIF) {
                return None;
            }
            *vif = ratio.max(one);
        }
        let sigma = found.map(T::sqrt);
        let accel = [sigma[0], sigma[1], sigma[2]];
        let gyro = self
            .has_gyro
            .then_some(([sigma[3], sigma[4], sigma[5]], vif[1]));
        Some(RestNoise::new(accel, vif[0], gyro).rounded(&self.plan, &self.step))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alternating_and_repeated_values() {
        // ±0.1 in turn: σ 0.1, and means of blocks that do not scatter at all.
        let mut learner = Learner::<f32>::new(Plan::new(100.0_f32), false);
        for i in 0..400 {
            let v = if i % 2 == 0 { 0.1 } else { -0.1 };
            learner.update([v, v, 9.81 + v], None);
        }
        let noise = learner.noise().unwrap();
        assert!(noise.variance[..3].iter().all(|v| (v - 0.01).abs() < 1e-4));
        assert!((noise.mean_variance[0][2] - noise.variance[2]).abs() < 1e-9);
    }

    #[test]
    fn nothing_is_learnt_from_motion_or_from_silence() {
        let mut moving = Learner::<f64>::new(Plan::new(100.0), false);
        let mut silent = moving.clone();
        for i in 0..400 {
            let v = (f64::from(i) * 0.01).sin();
            moving.update([v, v, 9.81], None);
            silent.update([0.0, 0.0, 9.81], None);
        }
        assert!(moving.noise().is_none());
        assert!(silent.noise().is_none());
        // With known steps silence is what rounding hides.
        let noise = silent.rounded([0.01; CHANNELS]).noise().unwrap();
        let floor = rounding::floor(0.01);
        assert!(
            noise.variance[..3]
                .iter()
                .all(|v| (v / floor - 3.0).abs() < 1e-12)
        );
        for (window, means) in Plan::new(100.0).windows.iter().zip(noise.mean_variance) {
            assert!((means[0] - floor * (1.0 + *window as f64)).abs() < 1e-12);
        }
    }
}
