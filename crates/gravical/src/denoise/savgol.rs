//! Savitzky–Golay filter: a polynomial fitted to the samples around each one, and its value or
//! derivative there.
//!
//! A. Savitzky and M. J. E. Golay, Analytical Chemistry 36, 1964. Samples are equally spaced, so
//! that one set of weights is used for all.

use std::ops::Range;

use super::convolve::convolve;
use super::gram::{Gram, even_points, half_width};
use crate::{Error, Result};

/// The filter for samples `step_s` apart.
pub(super) struct Savgol {
    window: usize,
    derivative: usize,
    /// For x_(i−left) … x_(i+right).
    weights: Vec<f64>,
    left: usize,
    /// One over half the length of the window, to the power of the derivative.
    scale: f64,
    gram: Gram,
}

/// Weights for samples from the oldest to the newest that give the polynomial's derivative at
/// `position` (0 the oldest, `window` − 1 the newest).
///
/// # Errors
///
/// `filter-range` as [`FilterSpec::validate`](super::FilterSpec::validate), and for a `step_s`
/// that is not positive.
pub fn coefficients(
    window: usize,
    order: usize,
    derivative: usize,
    position: f64,
    step_s: f64,
) -> Result<Vec<f64>> {
    super::FilterSpec::SavitzkyGolay {
        window,
        order,
        derivative,
    }
    .validate()?;
    if !(step_s > 0.0 && step_s.is_finite() && position.is_finite()) {
        return Err(Error::usage(
            "filter-range",
            format!("the time between samples has to be above zero, not {step_s} s"),
        )
        .with_hint("step_s is the inverse of the sampling rate"));
    }
    let mut gram = Gram::new(order, window);
    // A window above the order always has enough points.
    gram.fit_to(&even_points(window));
    let half = half_width(window);
    let mut a = Vec::new();
    gram.at(
        (position - 0.5 * (window as f64 - 1.0)) / half,
        derivative,
        &mut a,
    );
    let scale = (half * step_s).powi(derivative as i32).recip();
    a.iter_mut().for_each(|a| *a *= scale);
    let mut weights = vec![0.0; window];
    gram.combine(&a, &mut weights);
    Ok(weights)
}

/// Weights for the newest sample, from the oldest to the newest, for
/// [`SavitzkyGolay`](gravical_core::filter::savgol::SavitzkyGolay) on a microcontroller.
///
/// # Errors
///
/// As [`coefficients`].
///
/// ```
/// use gravical::denoise::causal_coefficients;
///
/// let weights = causal_coefficients(5, 2, 0, 0.01)?;
/// assert!((weights[4] - 31.0 / 35.0).abs() < 1e-15);
/// # Ok::<(), gravical::Error>(())
/// ```
pub fn causal_coefficients(
    window: usize,
    order: usize,
    derivative: usize,
    step_s: f64,
) -> Result<Vec<f64>> {
    let newest = window as f64 - 1.0;
    coefficients(window, order, derivative, newest, step_s)
}

impl Savgol {
    /// `step_s` is used only for derivatives.
    pub fn new(window: usize, order: usize, derivative: usize, step_s: f64) -> Result<Self> {
        let middle = 0.5 * (window as f64 - 1.0);
        let weights = coefficients(window, order, derivative, middle, step_s)?;
        let mut gram = Gram::new(order, window);
        gram.fit_to(&even_points(window));
        Ok(Savgol {
            window,
            derivative,
            weights,
            left: (window - 1) / 2,
            scale: (half_width(window) * step_s)
                .powi(derivative as i32)
                .recip(),
            gram,
        })
    }

    pub fn window(&self) -> usize {
        self.window
    }

    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The filtered samples, which are equally spaced; fewer than the window stay as they are.
    pub fn filter(&self, x: &[f64]) -> Vec<f64> {
        let n = x.len();
        if n < self.window {
            return x.to_vec();
        }
        let mut out = Vec::with_capacity(n);
        // As in scipy, also for even windows.
        let ends = self.window / 2;
        let right = self.window - 1 - self.left;
        let start = n - self.window;
        self.polynomial(&x[..self.window], 0..ends, &mut out);
        if ends < n - ends {
            let inner = &x[ends - self.left..n - ends + right];
            convolve(inner, &self.weights, &mut out);
        }
        self.polynomial(&x[start..], n - ends - start..self.window, &mut out);
        out
    }

    /// Appends the fit to one window at some of its samples.
    fn polynomial(&self, samples: &[f64], at: Range<usize>, out: &mut Vec<f64>) {
        let fit = self.gram.project(samples);
        let half = half_width(self.window);
        let mut a = Vec::new();
        out.extend(at.map(|i| {
            let x = (i as f64 - 0.5 * (self.window as f64 - 1.0)) / half;
            self.gram.at(x, self.derivative, &mut a);
            let value: f64 = a.iter().zip(&fit).map(|(a, f)| a * f).sum();
            value * self.scale
        }));
    }
}
