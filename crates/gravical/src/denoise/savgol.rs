//! Savitzky–Golay filter: a polynomial fitted to the samples around each one, and its value or
//! derivative there.
//!
//! A. Savitzky and M. J. E. Golay, Analytical Chemistry 36, 1964. Samples are equally spaced, so
//! that one set of weights is used for all.

use nalgebra::{DMatrix, DVector};

/// Samples summed at once, so that they stay in the first-level cache.
const BLOCK: usize = 1024;

/// The filter for samples `step_s` apart.
pub(super) struct Savgol {
    window: usize,
    order: usize,
    derivative: usize,
    /// Chebyshev coefficients of the fit by the samples of a window: R⁻¹Qᵀ.
    fit: DMatrix<f64>,
    /// For the middle of a window.
    weights: Vec<f64>,
    /// From derivatives on −1 … 1 to those by time.
    scale: f64,
}

impl Savgol {
    /// `window` is odd and above `order`; `step_s` is used only for derivatives.
    ///
    /// Powers of the points lose all but three digits (window 101, order 8); Chebyshev polynomials
    /// on −1 … 1 lose none. `None` if the window does not determine the polynomial.
    pub fn new(window: usize, order: usize, derivative: usize, step_s: f64) -> Option<Self> {
        let points = (0..window).flat_map(|i| chebyshev(order, position(i, window), 0));
        let qr = DMatrix::from_row_iterator(window, order + 1, points).qr();
        let fit = qr.r().solve_upper_triangular(&qr.q().transpose())?;
        let scale = (half_width(window) * step_s)
            .powi(derivative as i32)
            .recip();
        let middle = DVector::from_vec(chebyshev(order, 0.0, derivative));
        let weights = (fit.tr_mul(&middle) * scale).as_slice().to_vec();
        Some(Savgol {
            window,
            order,
            derivative,
            fit,
            weights,
            scale,
        })
    }

    pub fn window(&self) -> usize {
        self.window
    }

    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Filters equally spaced samples, a window or more. At the ends the fit to the last full window
    /// goes on (scipy's `interp`).
    pub fn filter(&self, x: &[f64]) -> Vec<f64> {
        let (n, ends) = (x.len(), self.window / 2);
        let mut y = vec![0.0; n];
        for (block, y) in y[ends..n - ends].chunks_mut(BLOCK).enumerate() {
            for (k, weight) in self.weights.iter().enumerate() {
                y.iter_mut()
                    .zip(&x[BLOCK * block + k..])
                    .for_each(|(y, x)| *y += weight * x);
            }
        }
        for (start, rows) in [(0, 0..ends), (n - self.window, n - ends..n)] {
            let samples = DVector::from_column_slice(&x[start..start + self.window]);
            let fit = &self.fit * samples;
            for row in rows {
                let basis = chebyshev(
                    self.order,
                    position(row - start, self.window),
                    self.derivative,
                );
                y[row] = self.scale * basis.iter().zip(&fit).map(|(b, c)| b * c).sum::<f64>();
            }
        }
        y
    }
}

/// Place of a sample in its window, from −1 to 1.
fn position(i: usize, window: usize) -> f64 {
    (i as f64 - 0.5 * (window as f64 - 1.0)) / half_width(window)
}

/// Samples from the middle of a window to its ends; 1 for a window of one.
fn half_width(window: usize) -> f64 {
    (0.5 * (window as f64 - 1.0)).max(1.0)
}

/// A derivative of the Chebyshev polynomials T₀ … T_order: of T_(m+1) = 2x T_m − T_(m−1), d times.
fn chebyshev(order: usize, x: f64, derivative: usize) -> Vec<f64> {
    let mut values = vec![0.0; order + 1];
    for d in 0..=derivative {
        let below = std::mem::replace(&mut values, vec![0.0; order + 1]);
        values[0] = if d == 0 { 1.0 } else { 0.0 };
        if order > 0 {
            values[1] = [x, 1.0].get(d).copied().unwrap_or(0.0);
        }
        for m in 1..order {
            values[m + 1] = 2.0 * (x * values[m] + d as f64 * below[m]) - values[m - 1];
        }
    }
    values
}
