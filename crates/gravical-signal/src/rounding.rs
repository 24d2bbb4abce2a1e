//! What rounding to steps of q does to noise and to means.
//!
//! Noise of more than a third of a step spreads over several of them, and a mean
//! then goes between the steps. Under less noise most samples read the same step,
//! and no number of them tells where between two steps the truth lies: q/√12
//! (Widrow and Kollár, *Quantization Noise*, 2008, chapters 4 and 10).

use std::f64::consts::PI;

/// Below this share of q² the variance of rounded samples grows evenly with the
/// noise: a sample steps over only where the truth lies near the middle of two steps.
const EVENLY: f64 = 0.141;
/// √π.
const ROOT_PI: f64 = 1.772_453_850_905_516;

/// Standard deviation before rounding, from the variance of samples that are rounded
/// to steps of `step`, above 0; the same unit. Zero where the samples never change: the noise
/// cannot be seen.
///
/// The variance that is expected wherever between two steps the truth lies, with
/// s = σ/q, is q² (s² + Σ_k (1 − exp(−4π²k²s²))/(2π²k²)): s/√π under s = 0.25, and
/// s² + 1/12 less the first of the exponentials above. This is its inverse.
fn noise_before(variance: f64, step: f64) -> f64 {
    let share = variance.max(0.0) / (step * step);
    if share <= EVENLY {
        return ROOT_PI * share * step;
    }
    let squared = share - 1.0 / 12.0;
    (squared + left(squared) / (2.0 * PI * PI)).sqrt() * step
}

/// Variance of a mean that rounding leaves however many samples there are:
/// (q²/12)·exp(−4π²σ²/q²), from the variance of the rounded samples.
pub fn mean_variance(variance: f64, step: f64) -> f64 {
    floor(step) * (1.0 - shown(variance, step))
}

/// Share of what there is to see that shows through rounding, from the variance of
/// the rounded samples: 1 − exp(−4π²σ²/q²). Zero where the samples never change.
pub fn shown(variance: f64, step: f64) -> f64 {
    if step <= 0.0 {
        return 1.0;
    }
    let sigma = noise_before(variance, step) / step;
    1.0 - left(sigma * sigma)
}

/// Variance of rounding itself, q²/12: no sample is known better.
pub fn floor(step: f64) -> f64 {
    step * step / 12.0
}

/// exp(−4π²s²).
fn left(squared: f64) -> f64 {
    (-4.0 * PI * PI * squared).exp()
}
