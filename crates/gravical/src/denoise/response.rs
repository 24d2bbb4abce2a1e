//! Noise gain and −3 dB frequencies of a filter, from its definition.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use serde::Serialize;

/// Properties of a filter that do not depend on the recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Response {
    /// Standard deviation of white noise after the filter over that before it: the root of the
    /// sum of squares of its impulse response. For a derivative of order d in 1/sᵈ. Null for
    /// Hampel, which has no impulse response.
    pub noise_gain: Option<f64>,
    /// Frequencies with a gain of 1/√2 (−3 dB), as a share of the sampling rate: none if the gain
    /// never falls so far, two for a band-pass. For a derivative: where it is 1/√2 of the true
    /// one.
    pub minus_3db_of_rate: Vec<f64>,
    /// The same in Hz; null without a sampling rate.
    pub minus_3db_hz: Option<Vec<f64>>,
}

/// The frequency as a share of the rate, if there is one, at which the gain of weights falls to −3 dB; for a
/// derivative of order `derivative` with respect to the sample index, relative to the true one.
pub(super) fn minus_3db(weights: &[f64], derivative: usize) -> Vec<f64> {
    let relative = |share: f64| {
        let (mut re, mut im) = (0.0, 0.0);
        for (k, w) in weights.iter().enumerate() {
            let (sin, cos) = (TAU * share * k as f64).sin_cos();
            re += w * cos;
            im += w * sin;
        }
        f64::hypot(re, im) / (TAU * share).powi(derivative as i32)
    };
    // Fine enough to find every dip: lobes are about 1/window wide.
    let step = 1.0 / (32.0 * weights.len().max(4) as f64);
    let down = |share: f64| relative(share) < FRAC_1_SQRT_2;
    let steps = (0.5 / step) as usize;
    let crossing = (1..=steps)
        .map(|i| i as f64 * step)
        .find(|share| down(*share))
        .map(|at| {
            let (mut low, mut high) = (at - step, at);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if middle > 0.0 && down(middle) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            0.5 * (low + high)
        });
    crossing.into_iter().collect()
}
