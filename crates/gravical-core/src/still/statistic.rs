//! The test of one sample after the other: does the rest go on?

use super::{CHANNELS, Plan, RestNoise};
use crate::Real;

/// χ² with 3 degrees of freedom at 1 − 10⁻⁷/3: three windows share 10⁻⁷.
const MEAN_LIMIT: f64 = 37.661_609_22;
/// The same probability as standard deviations of a normal distribution.
const NORMAL_LIMIT: f64 = 5.399_930_641_220_101;
/// Blocks kept: a window, the gap, the reference, and the one being filled.
const KEPT: usize =
    Plan::SEED_BLOCKS + Plan::GAP_BLOCKS + Plan::REFERENCE_BLOCKS + Plan::SEED_BLOCKS;

/// What ended a rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Alarm {
    /// The mean specific force left that of the seconds before.
    Force,
    /// The mean angular rate did.
    Rate,
    /// The angular rate shakes more than its noise.
    Energy,
}

/// A rest as it goes on: MEAN in three windows, and the energy of the angular
/// rate (ARE) in the shortest.
///
/// MEAN is Σ (w̄ − r̄)² / (V (1/W + 1/n)) over the three axes of a sensor, w̄ the
/// mean of the last W samples, r̄ that of the n samples of the reference, V =
/// σ²·VIF. It is χ² with 3 degrees of freedom at rest. The reference is the
/// mean of the 5 s that end 1 s before the window; of what there is, 2 s at
/// least, at the start of a rest; closer to the window and shorter in its first
/// seconds.
///
/// Skog, Händel, Nilsson and Rantakokko 2010 compare such detectors; VIF makes
/// the test honest behind a low-pass.
#[derive(Debug, Clone)]
pub struct Statistic<T> {
    plan: Plan,
    noise: RestNoise<T>,
    origin: [T; CHANNELS],
    energy_limit: T,
    /// 1/σ² of each axis of the gyroscope.
    per_variance: [T; 3],
    samples: usize,
    sums: [[T; CHANNELS]; 3],
    energy: T,
    block: [T; CHANNELS],
    blocks: [[T; CHANNELS]; KEPT],
    references: [Reference<T>; 3],
}

#[derive(Debug, Clone, Copy)]
struct Reference<T> {
    /// Blocks; none while `to` is 0.
    to: usize,
    /// Number of samples from which on it may be another one.
    until: usize,
    mean: [T; CHANNELS],
    /// 1/(V (1/W + 1/n)) of each channel.
    weight: [T; CHANNELS],
}

impl<T: Real> Statistic<T> {
    /// A rest that begins; `origin` is a value near its mean (that of its first
    /// block), from which sums are taken.
    #[must_use]
    pub fn new(plan: Plan, noise: RestNoise<T>, origin: [T; CHANNELS]) -> Self {
        let none = Reference {
            to: 0,
            until: 0,
            mean: [T::zero(); CHANNELS],
            weight: [T::zero(); CHANNELS],
        };
        Statistic {
            plan,
            noise,
            origin,
            energy_limit: energy_limit(plan.windows[0], noise.gyro_vif),
            per_variance: core::array::from_fn(|c| T::one() / noise.variance[3 + c]),
            samples: 0,
            sums: [[T::zero(); CHANNELS]; 3],
            energy: T::zero(),
            block: [T::zero(); CHANNELS],
            blocks: [[T::zero(); CHANNELS]; KEPT],
            references: [none; 3],
        }
    }

    /// The reference of the shortest window, once there is one.
    #[must_use]
    pub fn reference(&self) -> Option<[T; CHANNELS]> {
        let reference = &self.references[0];
        (reference.to > 0).then(|| core::array::from_fn(|c| self.origin[c] + reference.mean[c]))
    }

    /// Takes the next sample. `leaving` are the samples that leave the three
    /// windows with it, those 1, 2.5 and 5 blocks before it; they count for
    /// nothing while the rest is shorter than that.
    #[inline]
    pub fn update(&mut self, sample: [T; CHANNELS], leaving: [[T; CHANNELS]; 3]) -> Option<Alarm> {
        let new: [T; CHANNELS] = core::array::from_fn(|c| sample[c] - self.origin[c]);
        self.samples += 1;
        for (w, &width) in self.plan.windows.iter().enumerate() {
            if self.samples > width {
                let old: [T; CHANNELS] = core::array::from_fn(|c| leaving[w][c] - self.origin[c]);
                for c in 0..CHANNELS {
                    self.sums[w][c] = self.sums[w][c] + (new[c] - old[c]);
                }
                if w == 0 {
                    self.energy = self.energy + (self.power(&new) - self.power(&old));
                }
            } else {
                for c in 0..CHANNELS {
                    self.sums[w][c] = self.sums[w][c] + new[c];
                }
                if w == 0 {
                    self.energy = self.energy + self.power(&new);
                }
            }
        }
        for c in 0..CHANNELS {
            self.block[c] = self.block[c] + new[c];
        }
        let length = self.plan.block;
        if self.samples.is_multiple_of(length) {
            let at = (self.samples / length - 1) % KEPT;
            self.blocks[at] = self.block;
            self.block = [T::zero(); CHANNELS];
        }
        // A twentieth of a block is soon enough.
        if self.samples.is_multiple_of((length / 20).max(1)) {
            self.test()
        } else {
            None
        }
    }

    /// Σ ω²/σ² over the axes of the gyroscope, ω less the origin.
    fn power(&self, off: &[T; CHANNELS]) -> T {
        let mut sum = T::zero();
        for c in 0..3 {
            sum = sum + off[3 + c] * off[3 + c] * self.per_variance[c];
        }
        sum
    }

    fn test(&mut self) -> Option<Alarm> {
        for w in 0..3 {
            let width = self.plan.windows[w];
            if !self.refer(w, width) {
                continue;
            }
            let reference = &self.references[w];
            let share = T::one() / T::from_f64(width as f64);
            let mut chi2 = [T::zero(); 2];
            for c in 0..CHANNELS {
                let off = self.sums[w][c] * share - reference.mean[c];
                chi2[c / 3] = chi2[c / 3] + off * off * reference.weight[c];
            }
            let limit = T::from_f64(MEAN_LIMIT);
            if chi2[0] > limit {
                return Some(Alarm::Force);
            }
            if self.noise.has_gyro {
                if chi2[1] > limit {
                    return Some(Alarm::Rate);
                }
                if w == 0 && self.shaking(width) {
                    return Some(Alarm::Energy);
                }
            }
        }
        None
    }

    /// Energy about the reference: Σ(ω − r)² = Σω² − 2 r Σω + W r².
    fn shaking(&self, width: usize) -> bool {
        let mean = &self.references[0].mean;
        let width = T::from_f64(width as f64);
        let mut energy = self.energy;
        for c in 0..3 {
            let r = mean[3 + c];
            let two = T::from_f64(2.0);
            energy =
                energy + (width * r * r - two * r * self.sums[0][3 + c]) * self.per_variance[c];
        }
        energy > self.energy_limit
    }

    /// Chooses the reference of a window; false while there is none.
    fn refer(&mut self, w: usize, width: usize) -> bool {
        if self.samples < self.references[w].until {
            return self.references[w].to > 0;
        }
        let length = self.plan.block;
        let Some(before) = self.samples.checked_sub(width) else {
            return false;
        };
        let near = before / length;
        let until = (near + 1) * length + width;
        self.references[w].until = until;
        let far = near.saturating_sub(Plan::GAP_BLOCKS);
        let to = far.max(near.min(Plan::LEAST_REFERENCE));
        if to < Plan::SEED_BLOCKS || self.references[w].to == to {
            return self.references[w].to > 0;
        }
        let from = to.saturating_sub(Plan::REFERENCE_BLOCKS);
        let mut mean = [T::zero(); CHANNELS];
        for block in from..to {
            let sums = &self.blocks[block % KEPT];
            for c in 0..CHANNELS {
                mean[c] = mean[c] + sums[c];
            }
        }
        let samples = T::from_f64(((to - from) * length) as f64);
        let spread = T::one() / T::from_f64(width as f64) + T::one() / samples;
        let variance = &self.noise.mean_variance[w];
        self.references[w] = Reference {
            to,
            until,
            mean: mean.map(|m| m / samples),
            weight: core::array::from_fn(|c| T::one() / (variance[c] * spread)),
        };
        true
    }
}

/// Limit of Σ ω²/σ² over a window. Correlated samples count as 3W/VIF: the sum is
/// VIF times a χ² of so many degrees of freedom (Satterthwaite), whose quantile
/// is that of Wilson and Hilferty 1931.
fn energy_limit<T: Real>(width: usize, vif: T) -> T {
    let vif = vif.max(T::one());
    let freedom = T::from_f64(3.0 * width as f64) / vif;
    let share = T::from_f64(2.0 / 9.0) / freedom;
    let root = T::one() - share + T::from_f64(NORMAL_LIMIT) * share.sqrt();
    freedom * root * root * root * vif
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum of twelve uniform numbers less 6, from a linear congruential generator
    /// (Knuth's MMIX): near enough to normal for ten thousand samples.
    struct Noise(u64);

    impl Noise {
        fn next(&mut self) -> f64 {
            (0..12)
                .map(|_| {
                    self.0 = self
                        .0
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1_442_695_040_888_963_407);
                    (self.0 >> 11) as f64 / (1_u64 << 53) as f64
                })
                .sum::<f64>()
                - 6.0
        }

        fn sample(&mut self) -> [f64; CHANNELS] {
            core::array::from_fn(|_| self.next())
        }
    }

    fn first_alarm(samples: &[[f64; CHANNELS]]) -> Option<(usize, Alarm)> {
        let plan = Plan::new(100.0);
        let noise = RestNoise::new([1.0; 3], 1.0, Some(([1.0; 3], 1.0)));
        let mut statistic = Statistic::new(plan, noise, samples[0]);
        (0..samples.len()).find_map(|i| {
            let leaving = plan.windows.map(|w| samples[i.saturating_sub(w)]);
            statistic
                .update(samples[i], leaving)
                .map(|alarm| (i, alarm))
        })
    }

    #[test]
    fn white_noise_raises_no_alarm() {
        let mut noise = Noise(1);
        let samples: std::vec::Vec<_> = (0..100_000).map(|_| noise.sample()).collect();
        assert_eq!(first_alarm(&samples), None);
    }

    #[test]
    fn each_alarm_for_its_reason() {
        let mut noise = Noise(2);
        let quiet: std::vec::Vec<_> = (0..1000).map(|_| noise.sample()).collect();
        let mut pushed = quiet.clone();
        pushed[800..].iter_mut().for_each(|s| s[1] += 3.0);
        let mut turned = quiet.clone();
        turned[800..].iter_mut().for_each(|s| s[5] -= 3.0);
        let mut shaken = quiet.clone();
        for (i, s) in shaken[800..].iter_mut().enumerate() {
            s[4] += if i % 2 == 0 { 4.0 } else { -4.0 };
        }
        for (samples, reason) in [
            (pushed, Alarm::Force),
            (turned, Alarm::Rate),
            (shaken, Alarm::Energy),
        ] {
            let (at, alarm) = first_alarm(&samples).unwrap();
            assert_eq!(alarm, reason);
            assert!((800..825).contains(&at), "{at}");
        }
    }

    #[test]
    fn a_drift_is_followed() {
        // 3 mm/s² in 10 s where σ is 35 mm/s²: a fixed reference would fail.
        let mut noise = Noise(3);
        let mut samples: std::vec::Vec<_> = (0..20_000).map(|_| noise.sample()).collect();
        for (i, s) in samples.iter_mut().enumerate() {
            s[0] += 0.003 / 0.035 / 1000.0 * i as f64;
        }
        assert_eq!(first_alarm(&samples), None);
    }

    #[test]
    fn the_limit_of_the_energy() {
        // SciPy: chi2.isf(1e-7/3, 60) is 138.94, chi2.isf(1e-7/3, 30) 91.93.
        assert!((energy_limit(20, 1.0_f64) - 138.94).abs() < 1.0);
        assert!((energy_limit(20, 2.0_f64) - 2.0 * 91.93).abs() < 2.0);
    }
}
