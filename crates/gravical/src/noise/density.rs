//! Check of N by the power spectral density between 1 and 10 Hz.
//!
//! Welch's method (P. D. Welch, IEEE Trans. Audio Electroacoust. 15, 1967): the mean of
//! periodograms of segments of 4 s under a Hann window. Only twelve frequencies are needed, and
//! of a long recording up to a thousand segments evenly spread: a Fourier sum for these is
//! cheaper than a transform of all samples. The density is one-sided, that of white noise 2N².

use std::f64::consts::TAU;

use crate::stats::Thinned;

const SEGMENT_S: f64 = 4.0;
const FREQUENCIES: usize = 12;
const FROM_HZ: f64 = 1.0;
const TO_HZ: f64 = 10.0;
/// Largest frequency, over the sampling rate: beyond it a low-pass is part of the density.
const MOST_OF_RATE: f64 = 0.35;
const MOST_SEGMENTS: usize = 1 << 10;
/// Samples of a segment at which the sums stay cheap.
const MOST_SAMPLES: usize = 1 << 14;

/// One value for each frequency.
type Wave = [f64; FREQUENCIES];

/// Periodograms of one channel.
#[derive(Debug, Clone)]
pub(super) struct Density {
    /// Frequencies, Hz; none if the rate is too low.
    hz: Vec<f64>,
    /// For each sample their cosines and sines under the window: side by side, since the sums of all
    /// frequencies are formed together.
    waves: Vec<[Wave; 2]>,
    /// From the square of a sum to the density.
    factor: f64,
    samples: usize,
    segment: Vec<f64>,
    powers: Thinned<Wave, MOST_SEGMENTS>,
}

impl Density {
    /// For a sampling period, s. Without frequencies if the rate is too low.
    pub fn new(period_s: f64) -> Self {
        let samples = ((SEGMENT_S / period_s).round() as usize).min(MOST_SAMPLES);
        let resolution_hz = 1.0 / (samples as f64 * period_s);
        let to_hz = TO_HZ.min(MOST_OF_RATE / period_s);
        let window = |k: usize| 1.0 - (TAU * k as f64 / samples as f64).cos();
        let (mut hz, mut waves) = (Vec::new(), Vec::new());
        if to_hz > 2.0 * FROM_HZ {
            let cycles: Wave = std::array::from_fn(|i| {
                let share = i as f64 / (FREQUENCIES - 1) as f64;
                let hz = FROM_HZ * (to_hz / FROM_HZ).powf(share);
                (hz / resolution_hz).round()
            });
            let wave = |k: usize| {
                let window = window(k);
                let angles = cycles.map(|c| TAU * c * k as f64 / samples as f64);
                [
                    angles.map(|a| window * a.cos()),
                    angles.map(|a| window * a.sin()),
                ]
            };
            hz = cycles.map(|c| c * resolution_hz).to_vec();
            waves = (0..samples).map(wave).collect();
        }
        let squares: f64 = (0..samples).map(|k| window(k).powi(2)).sum();
        Density {
            hz,
            waves,
            factor: 2.0 * period_s / squares,
            samples,
            segment: Vec::with_capacity(samples),
            powers: Thinned::default(),
        }
    }

    /// Adds samples that continue the last ones.
    pub fn push(&mut self, values: &[f64]) {
        if self.waves.is_empty() {
            return;
        }
        for value in values {
            self.segment.push(*value);
            if self.segment.len() == self.samples {
                let (waves, segment, factor) = (&self.waves, &self.segment, self.factor);
                self.powers.push_with(|| powers(waves, segment, factor));
                self.segment.clear();
            }
        }
    }

    /// The next sample does not continue the last one.
    pub fn split(&mut self) {
        self.segment.clear();
    }

    /// Mean ratio of the density to the `expected` one, its standard deviation by chance, and the
    /// band in Hz. `None` without a segment.
    pub fn ratio(&self, expected: impl Fn(f64) -> f64) -> Option<(f64, f64, [f64; 2])> {
        let segments = self.powers.items();
        let band = [*self.hz.first()?, *self.hz.last()?];
        if segments.is_empty() {
            return None;
        }
        let count = (segments.len() * FREQUENCIES) as f64;
        let each = segments.iter().flat_map(|powers| {
            let both = powers.iter().zip(&self.hz);
            both.map(|(power, hz)| power / expected(*hz))
        });
        // The square of a normal amplitude deviates by itself; low neighbours overlap a little.
        Some((each.sum::<f64>() / count, 1.5 / count.sqrt(), band))
    }
}

fn powers(waves: &[[Wave; 2]], segment: &[f64], factor: f64) -> Wave {
    let mean = segment.iter().sum::<f64>() / segment.len() as f64;
    let (mut re, mut im) = ([0.0; FREQUENCIES], [0.0; FREQUENCIES]);
    for (value, [cos, sin]) in segment.iter().zip(waves) {
        let off = value - mean;
        for i in 0..FREQUENCIES {
            re[i] += off * cos[i];
            im[i] += off * sin[i];
        }
    }
    std::array::from_fn(|i| factor * (re[i] * re[i] + im[i] * im[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};

    #[test]
    fn white_noise_has_twice_the_square_of_its_allan_density() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        // Uniform over ±√3: variance 1, N² = period.
        let x: Vec<f64> = (0..400_000)
            .map(|_| 3_f64.sqrt() * (2.0 * rng.random::<f64>() - 1.0))
            .collect();
        for period_s in [0.01, 0.004] {
            let mut density = Density::new(period_s);
            x.chunks(777).for_each(|part| density.push(part));
            let (ratio, deviation, band) = density.ratio(|_| 2.0 * period_s).unwrap();
            assert_eq!(band, [1.0, 10.0]);
            assert!(
                (ratio - 1.0).abs() < 3.0 * deviation,
                "{ratio} ± {deviation}"
            );
            assert!(deviation < 0.03);
        }
    }

    #[test]
    fn a_tone_of_known_amplitude() {
        // A sine of amplitude a in a bin of width Δf under a Hann window: a²/2 over 1.5 Δf.
        let mut density = Density::new(0.01);
        let tone = |k: usize| 0.3 * (TAU * 1.0 * 0.01 * k as f64).sin();
        density.push(&(0..400).map(tone).collect::<Vec<f64>>());
        let power = density.powers.items()[0][0];
        assert!(
            (power / (0.045 / (1.5 * 0.25)) - 1.0).abs() < 1e-9,
            "{power}"
        );
    }

    #[test]
    fn slow_recordings_have_no_density() {
        let mut density = Density::new(0.2);
        density.push(&[1.0; 1000]);
        assert!(density.ratio(|_| 1.0).is_none());
    }
}
