//! Noise gain and −3 dB frequencies of a filter, from its definition.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use serde::Serialize;

use super::spec::{Band, Passes};

/// Properties of a filter that do not depend on the recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Response {
    /// Standard deviation of white noise after the filter over that before it: the root of the
    /// sum of squares of its impulse response. For a derivative of order d in 1/sᵈ. For Hampel,
    /// which has no impulse response, measured on normal noise.
    pub noise_gain: f64,
    /// Frequencies with a gain of 1/√2 (−3 dB), as a share of the sampling rate: none if the gain
    /// never falls so far, two for a band-pass. For a derivative: where it is 1/√2 of the true
    /// one.
    pub minus_3db_of_rate: Vec<f64>,
    /// The same in Hz; null without a sampling rate.
    pub minus_3db_hz: Option<Vec<f64>>,
}

/// For weights on equally spaced samples and a derivative of order `derivative` with respect to
/// the sample index.
pub(super) fn of_weights(weights: &[f64], derivative: usize) -> (f64, Vec<f64>) {
    let gain = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
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
    (gain, crossing.into_iter().collect())
}

/// Noise gain of a Butterworth filter whose passes together have `band`: G² = 2∫|H|²df up to half
/// the rate, |H|² = (1 + x²ⁿ)⁻ᵖ for p passes.
///
/// As a function of u = ln Ω the integrand 2·|H|²·Ω/(π(1 + Ω²)) is smooth and decays
/// exponentially on both sides; u = u₀ + w sinh v concentrates the points at the band, however
/// narrow it is. The trapezoidal rule then converges geometrically (L. N. Trefethen and J. A. C.
/// Weideman, SIAM Review 56, 2014).
pub(super) fn of_butterworth(order: usize, band: Band, passes: Passes, rate_hz: f64) -> f64 {
    let warp = |f: f64| (PI * f / rate_hz).tan();
    let power = match passes {
        Passes::Causal => 1,
        Passes::Two => 2,
    };
    // x²ⁿ at the −3 dB frequencies of all passes: 1, or √2 − 1.
    let at_edge = 2.0_f64.powf(1.0 / f64::from(power)) - 1.0;
    let edges: Vec<f64> = band.edges_hz().into_iter().map(warp).collect();
    let (first, last) = match edges.as_slice() {
        [one] => (*one, *one),
        [low, high] => (*low, *high),
        _ => return f64::NAN,
    };
    let share = |omega: f64| match band {
        Band::Low { .. } => omega / first,
        Band::High { .. } => first / omega,
        Band::Between { .. } => (omega * omega - first * last).abs() / (omega * (last - first)),
    };
    let integrand = |u: f64| {
        let omega = u.exp();
        let x = share(omega).powi(2 * order as i32) * at_edge;
        (1.0 + x).powi(-power) * omega / (PI * (1.0 + omega * omega))
    };
    let middle = 0.5 * (first.ln() + last.ln());
    let width = match band {
        Band::Between { .. } => (0.5 * (last / first).ln()).min(1.0),
        _ => 1.0,
    };
    // The nearest pole is about π/2n = 0.2 away; e⁻⁴⁰ is negligible.
    let step = 0.02;
    let end = ((40.0 + middle.abs()) / width).asinh();
    let count = (end / step).ceil() as i64;
    let sum: f64 = (-count..=count)
        .map(|i| i as f64 * step)
        .map(|v| integrand(middle + width * v.sinh()) * v.cosh())
        .sum();
    (2.0 * sum * width * step).sqrt()
}
