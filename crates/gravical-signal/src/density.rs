//! Power spectral density of noise between 1 and 10 Hz, beside an expected one.

use std::f64::consts::TAU;

const SEGMENT_S: f64 = 4.0;
const FREQUENCIES: usize = 12;
const MIN_HZ: f64 = 1.0;
const MAX_HZ: f64 = 10.0;
/// Largest frequency over the sampling rate: beyond it a low-pass is part of the density.
const MAX_OF_RATE: f64 = 0.35;
const MAX_SEGMENTS: usize = 1024;
/// Samples of a segment up to which the sums stay cheap.
const MAX_SAMPLES: usize = 1 << 14;

/// Power in a band over the power that was expected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DensityRatio {
    /// Mean ratio of the densities
    pub ratio: f64,
    /// Its standard deviation by chance
    pub sd: f64,
    /// The band, Hz
    pub band_hz: [f64; 2],
}

/// The one-sided power spectral density of samples `period_s` apart over the `expected` one (of a
/// frequency in Hz): that of white noise is 2N². `None` without a segment of 4 s, or below a rate of
/// 6 Hz.
///
/// Welch's method (P. D. Welch, IEEE Trans. Audio Electroacoust. 15, 1967): the mean of periodograms
/// of segments of 4 s under a Hann window, of up to a thousand segments evenly spread. Twelve
/// frequencies are enough: their sums are cheaper than a transform.
#[must_use]
pub fn density_ratio(
    segments: &[impl AsRef<[f64]>],
    period_s: f64,
    expected: impl Fn(f64) -> f64,
) -> Option<DensityRatio> {
    let length = ((SEGMENT_S / period_s).round() as usize).min(MAX_SAMPLES);
    let max_hz = MAX_HZ.min(MAX_OF_RATE / period_s);
    let chunks = || {
        segments
            .iter()
            .flat_map(|s| s.as_ref().chunks_exact(length.max(1)))
    };
    if max_hz <= 2.0 * MIN_HZ || chunks().next().is_none() {
        return None;
    }
    let resolution_hz = 1.0 / (length as f64 * period_s);
    let angle = |k: usize| TAU * k as f64 / length as f64;
    let window: Vec<f64> = (0..length).map(|k| 1.0 - angle(k).cos()).collect();
    let factor = 2.0 * period_s / window.iter().map(|w| w * w).sum::<f64>();
    let stride = chunks().count().div_ceil(MAX_SEGMENTS);
    let windowed: Vec<Vec<f64>> = chunks()
        .step_by(stride)
        .map(|chunk| {
            let mean = chunk.iter().sum::<f64>() / length as f64;
            let values = chunk.iter().zip(&window);
            values.map(|(value, w)| w * (value - mean)).collect()
        })
        .collect();
    let mut sum = 0.0;
    let mut band_hz = [f64::NAN; 2];
    for i in 0..FREQUENCIES {
        let share = i as f64 / (FREQUENCIES - 1) as f64;
        let cycles = (MIN_HZ * (max_hz / MIN_HZ).powf(share) / resolution_hz).round() as usize;
        let hz = cycles as f64 * resolution_hz;
        band_hz = [if i == 0 { hz } else { band_hz[0] }, hz];
        let wave: Vec<(f64, f64)> = (0..length)
            .map(|k| angle(cycles * k % length).sin_cos())
            .collect();
        let powers = windowed.iter().map(|values| {
            let (mut re, mut im) = (0.0, 0.0);
            for (value, (sin, cos)) in values.iter().zip(&wave) {
                re += value * cos;
                im += value * sin;
            }
            factor * (re * re + im * im)
        });
        sum += powers.sum::<f64>() / expected(hz);
    }
    let count = (windowed.len() * FREQUENCIES) as f64;
    // The square of a normal amplitude deviates by itself; low neighbours overlap a little.
    Some(DensityRatio {
        ratio: sum / count,
        sd: 1.5 / count.sqrt(),
        band_hz,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};

    #[test]
    fn white_noise_has_twice_the_square_of_its_allan_density() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        // Uniform over ±√3: variance 1, N² = period.
        let samples: Vec<f64> = (0..400_000)
            .map(|_| 3_f64.sqrt() * (2.0 * rng.random::<f64>() - 1.0))
            .collect();
        for period_s in [0.01, 0.004] {
            let density = density_ratio(&[&samples], period_s, |_| 2.0 * period_s).unwrap();
            assert_eq!(density.band_hz, [1.0, 10.0]);
            assert!(
                (density.ratio - 1.0).abs() < 3.0 * density.sd,
                "{density:?}"
            );
            assert!(density.sd < 0.03);
        }
    }

    #[test]
    fn a_tone_of_known_amplitude() {
        // A sine of amplitude a in a bin of width Δf under a Hann window: a²/2 over 1.5 Δf.
        let tone: Vec<f64> = (0..400)
            .map(|k| 0.3 * (TAU * 0.01 * f64::from(k)).sin())
            .collect();
        let first = |hz: f64| if hz == 1.0 { 1.0 } else { f64::INFINITY };
        let power = 12.0 * density_ratio(&[&tone], 0.01, first).unwrap().ratio;
        assert!(
            (power / (0.045 / (1.5 * 0.25)) - 1.0).abs() < 1e-9,
            "{power}"
        );
        assert!(density_ratio(&[&[1.0; 1000]], 0.2, |_| 1.0).is_none());
    }
}
