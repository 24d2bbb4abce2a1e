//! Polynomials that are orthonormal on given points, for fits at any spacing.
//!
//! With powers of the points a fit of order 8 over 101 points loses all but three digits; with
//! polynomials that are orthogonal on the points it loses none. The recurrence is that of P. D.
//! Brubeck, Y. Nakatsukasa and L. N. Trefethen, "Vandermonde with Arnoldi", SIAM Review 63, 2021;
//! on equally spaced points these are the Gram polynomials of P. A. Gorry, Analytical Chemistry
//! 62, 1990.

/// p_0 … p_order with Σ_i p_m(x_i) p_k(x_i) = δ_mk.
pub(super) struct Gram {
    order: usize,
    count: usize,
    /// p_m(x_i), one m after the other.
    values: Vec<f64>,
    /// x p_m = Σ_j h_jm p_j, j up to m + 1; row j, column m.
    steps: Vec<f64>,
}

/// Relative norm of x p_m after orthogonalisation below which the points do not determine another
/// polynomial.
const VANISHED: f64 = 1e-9;

impl Gram {
    /// Allocates polynomials up to `order` on `count` points.
    pub fn new(order: usize, count: usize) -> Self {
        Gram {
            order,
            count,
            values: vec![0.0; (order + 1) * count],
            steps: vec![0.0; (order + 1) * (order + 1)],
        }
    }

    /// Computes the polynomials for other points, within about −1 to 1; false if too few of them
    /// are different.
    pub fn fit_to(&mut self, points: &[f64]) -> bool {
        let (count, size) = (self.count, self.order + 1);
        if points.len() != count || count == 0 {
            return false;
        }
        self.steps.fill(0.0);
        self.values[..count].fill(1.0 / (count as f64).sqrt());
        for m in 0..self.order {
            let (known, rest) = self.values.split_at_mut((m + 1) * count);
            let next = &mut rest[..count];
            let last = &known[m * count..];
            for ((next, p), x) in next.iter_mut().zip(last).zip(points) {
                *next = p * x;
            }
            let whole = norm(next);
            // A second orthogonalisation removes the rounding errors of the first.
            for _ in 0..2 {
                for (j, p) in known.chunks_exact(count).enumerate() {
                    let share: f64 = p.iter().zip(&*next).map(|(a, b)| a * b).sum();
                    for (next, p) in next.iter_mut().zip(p) {
                        *next -= share * p;
                    }
                    self.steps[j * size + m] += share;
                }
            }
            let left = norm(next);
            // Also refuses points that are NaN.
            if left.is_nan() || left <= VANISHED * whole {
                return false;
            }
            next.iter_mut().for_each(|v| *v /= left);
            self.steps[(m + 1) * size + m] = left;
        }
        true
    }

    /// Writes the derivative of every polynomial at `x` to `out`.
    pub fn at(&self, x: f64, derivative: usize, out: &mut Vec<f64>) {
        let size = self.order + 1;
        out.clear();
        out.resize(size, 0.0);
        // Derivatives in ascending order: that of x p is x p⁽ᵈ⁾ + d p⁽ᵈ⁻¹⁾.
        let mut below: Vec<f64> = Vec::new();
        for d in 0..=derivative {
            let mut now = vec![0.0; size];
            now[0] = if d == 0 {
                1.0 / (self.count as f64).sqrt()
            } else {
                0.0
            };
            for m in 0..self.order {
                let mut next = x * now[m] + d as f64 * below.get(m).copied().unwrap_or(0.0);
                for (j, known) in now.iter().enumerate().take(m + 1) {
                    next -= self.steps[j * size + m] * known;
                }
                now[m + 1] = next / self.steps[(m + 1) * size + m];
            }
            if d == derivative {
                out.copy_from_slice(&now);
            }
            below = now;
        }
    }

    /// Σ_m p_m(x_i) a_m for every point: with a_m = p_m⁽ᵈ⁾(x), the weights for the derivative of
    /// the fit at x.
    pub fn combine(&self, a: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (p, a) in self.values.chunks_exact(self.count).zip(a) {
            for (out, p) in out.iter_mut().zip(p) {
                *out += a * p;
            }
        }
    }

    /// Σ_i p_m(x_i) y_i for every polynomial: the fit to `y`.
    pub fn project(&self, y: &[f64]) -> Vec<f64> {
        self.values
            .chunks_exact(self.count)
            .map(|p| p.iter().zip(y).map(|(p, y)| p * y).sum())
            .collect()
    }
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// `count` equally spaced points from −1 to 1.
pub(super) fn even_points(count: usize) -> Vec<f64> {
    let half = half_width(count);
    (0..count)
        .map(|i| (i as f64 - 0.5 * (count as f64 - 1.0)) / half)
        .collect()
}

/// Number of samples from the middle of a window to its ends; 1 for a window of one.
pub(super) fn half_width(count: usize) -> f64 {
    if count > 1 {
        0.5 * (count as f64 - 1.0)
    } else {
        1.0
    }
}
