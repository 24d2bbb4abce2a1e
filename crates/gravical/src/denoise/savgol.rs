//! Savitzky–Golay filter: a polynomial fitted to the samples around each one, and its value or
//! derivative there.
//!
//! A. Savitzky and M. J. E. Golay, Analytical Chemistry 36, 1964. Samples are equally spaced, so
//! that one set of weights is used for all.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::convolve::convolve;
use super::gram::{Gram, even_points, half_width};
use crate::{Error, Result};

/// Values beyond the ends of a recording, for filters with a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Edge {
    /// None: the polynomial of the first and last full window is evaluated up to the ends
    /// (scipy's `interp`). The default.
    #[default]
    Interp,
    /// The first and last sample, repeated: a a a | a b c.
    Nearest,
    /// The samples mirrored about the first and last one: c b | a b c.
    Mirror,
    /// Zeros. Useful only after a high-pass, since gravity is not zero.
    Constant,
}

impl Edge {
    /// Name in options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Edge::Interp => "interp",
            Edge::Nearest => "nearest",
            Edge::Mirror => "mirror",
            Edge::Constant => "constant",
        }
    }
}

impl std::str::FromStr for Edge {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        [Edge::Interp, Edge::Nearest, Edge::Mirror, Edge::Constant]
            .into_iter()
            .find(|e| e.name() == text)
            .ok_or_else(|| {
                Error::usage("edge-unknown", format!("there is no edge \"{text}\""))
                    .with_hint("interp, nearest, mirror or constant")
            })
    }
}

/// The filter for samples `step_s` apart.
pub(super) struct Savgol {
    window: usize,
    derivative: usize,
    edge: Edge,
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
    pub fn new(
        window: usize,
        order: usize,
        derivative: usize,
        step_s: f64,
        edge: Edge,
    ) -> Result<Self> {
        let middle = 0.5 * (window as f64 - 1.0);
        let weights = coefficients(window, order, derivative, middle, step_s)?;
        let mut gram = Gram::new(order, window);
        gram.fit_to(&even_points(window));
        Ok(Savgol {
            window,
            derivative,
            edge,
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

    /// Number of samples before and after each that are in its window.
    fn reach(&self) -> (usize, usize) {
        (self.left, self.window - 1 - self.left)
    }

    /// Number of rows at each end that depend on `edge`.
    fn edge_rows(&self) -> [usize; 2] {
        match self.edge {
            // As in scipy, also for even windows.
            Edge::Interp => [self.window / 2; 2],
            _ => self.reach().into(),
        }
    }

    /// The filtered samples, which are equally spaced; fewer than the window stay as they are.
    pub fn filter(&self, x: &[f64]) -> Vec<f64> {
        let n = x.len();
        if n < self.window {
            return x.to_vec();
        }
        let mut out = Vec::with_capacity(n);
        let [first, last] = self.edge_rows();
        let (left, right) = self.reach();
        match self.edge {
            Edge::Interp => self.polynomial(&x[..self.window], 0..first, &mut out),
            _ => self.padded(x, 0..first, &mut out),
        }
        if first < n - last {
            let inner = &x[first - left..n - last + right];
            convolve(inner, &self.weights, &mut out);
        }
        let start = n - self.window;
        let tail = n - last..n;
        match self.edge {
            Edge::Interp => {
                self.polynomial(&x[start..], tail.start - start..tail.end - start, &mut out);
            }
            _ => self.padded(x, tail, &mut out),
        }
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

    /// Appends the weighted sums at these rows, with the values of `edge` beyond the ends.
    fn padded(&self, x: &[f64], at: Range<usize>, out: &mut Vec<f64>) {
        let n = x.len() as isize;
        let sample = |i: isize| {
            let inside = match self.edge {
                Edge::Constant if !(0..n).contains(&i) => return 0.0,
                Edge::Mirror if n > 1 => {
                    let folded = i.rem_euclid(2 * (n - 1));
                    folded.min(2 * (n - 1) - folded)
                }
                _ => i.clamp(0, n - 1),
            };
            x[inside as usize]
        };
        out.extend(at.map(|row| {
            let from = row as isize - self.left as isize;
            let terms = self.weights.iter().zip(from..);
            terms.map(|(w, i)| w * sample(i)).sum::<f64>()
        }));
    }
}
