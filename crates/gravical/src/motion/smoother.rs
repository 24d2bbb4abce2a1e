//! What the second rest of a leg says of the tilt all along it.
//!
//! Along each horizontal axis the error of a leg is a state x = (β, θ, v, p):
//!
//! ```text
//! β' = 0            bias that the rests left in the gyroscope, rad/s
//! θ' = β + w_g      tilt, as far as it turns gravity along this axis, rad
//! v' = g θ + w_a    velocity, m/s
//! p' = v            position, m
//! ```
//!
//! with white noise w_g of density q and w_a of density N². θ starts with what
//! levelling missed. At the second rest two things are seen: the tilt that is
//! missing, and a velocity that should be zero. Given P(τ), the covariance of x,
//! and Φ(T − τ), the way to the end, the best estimate of x(τ) from that
//! measurement m = H x(T) + r is
//!
//! ```text
//! x̂(τ) = P Φᵀ Hᵀ S⁻¹ m,   S = H P(T) Hᵀ + R
//! ```
//!
//! (Rauch, Tung and Striebel 1965, for one measurement at the end). Where the
//! accelerometer's noise is the larger error, this is a velocity that is taken off
//! evenly; where the attitude is, in moves of ten seconds and more, it is a tilt
//! that comes and goes.

use nalgebra::{Matrix2, Matrix4, Matrix4x2};

/// Nodes that functions of τ are computed at; between them they are linear.
const NODES: usize = 256;

/// A velocity at rest is zero to this, m/s.
const STILL_MPS: f64 = 1e-6;

/// A process and how it is seen at its end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Noise {
    /// Variance of β, rad²/s².
    pub bias: f64,
    /// Variance of θ at the start, rad².
    pub level: f64,
    /// Density of w_a, N², m²/s³.
    pub accel: f64,
    /// Variance of the tilt that the second rest shows, rad²; infinite where it
    /// shows none.
    pub seen: f64,
}

/// Functions of the time since the first rest.
#[derive(Debug, Clone)]
pub(super) struct Smoother {
    tau: Vec<f64>,
    gravity: f64,
    /// x̂ = C m, by node; empty where the measurement is singular.
    gain: Vec<Matrix4x2<f64>>,
    /// Variance of v and p by tilt.
    tilt: Vec<[f64; 2]>,
    /// … and by the accelerometer's noise with N² = 1.
    accel: Vec<[f64; 2]>,
    /// … and by a tilt that nobody reckoned with, of the variance 1 rad² at the end.
    walk: Vec<[f64; 2]>,
}

impl Smoother {
    /// For a leg of the length `total`, s. `density` gives q between two times,
    /// first what may be there, then what is certain to be: the first decides how
    /// the measurement is used, the second what error is left by noise alone.
    pub fn new(
        total: f64,
        gravity: f64,
        design: Noise,
        actual: Noise,
        density: impl Fn(f64, f64) -> (f64, f64),
    ) -> Self {
        let tau: Vec<f64> = (0..=NODES)
            .map(|j| total * j as f64 / NODES as f64)
            .collect();
        let unit = Noise {
            bias: 0.0,
            level: 0.0,
            accel: 1.0,
            seen: 0.0,
        };
        let tilt_only = Noise {
            accel: 0.0,
            ..actual
        };
        let by_design = covariances(&tau, gravity, &design, |a, b| density(a, b).0);
        let by_tilt = covariances(&tau, gravity, &tilt_only, |a, b| density(a, b).1);
        let by_accel = covariances(&tau, gravity, &unit, |_, _| 0.0);
        let none = Noise { accel: 0.0, ..unit };
        let by_walk = covariances(&tau, gravity, &none, |_, _| 1.0 / total.max(1e-9));
        let of_v_p = |all: &[Matrix4<f64>]| all.iter().map(|p| [p[(2, 2)], p[(3, 3)]]).collect();
        let mut out = Smoother {
            gravity,
            gain: Vec::new(),
            tilt: of_v_p(&by_tilt),
            accel: of_v_p(&by_accel),
            walk: of_v_p(&by_walk),
            tau,
        };
        if let Some(gain) = out.gains(&by_design, &design) {
            out.tilt = out.left(&by_tilt, &gain, tilt_only.seen);
            out.accel = out.left(&by_accel, &gain, 0.0);
            out.walk = out.left(&by_walk, &gain, 0.0);
            out.gain = gain;
        }
        out
    }

    /// C(τ) at the nodes; none where the measurement is singular.
    fn gains(&self, p: &[Matrix4<f64>], noise: &Noise) -> Option<Vec<Matrix4x2<f64>>> {
        let total = *self.tau.last()?;
        let at_end = seen(p.last()?);
        // A tilt that is not seen has a variance beyond all others.
        let level = if noise.seen.is_finite() {
            noise.seen
        } else {
            1e6
        };
        let s = Matrix2::new(
            at_end[(1, 0)] + level,
            at_end[(1, 1)],
            at_end[(2, 0)],
            at_end[(2, 1)] + STILL_MPS * STILL_MPS,
        );
        let inverse = s.try_inverse()?;
        let all = self.tau.iter().zip(p).map(|(tau, p)| {
            let to_end = p * self.way(total - tau).transpose();
            seen(&to_end) * inverse
        });
        Some(all.collect())
    }

    /// Variance of v and p with the measurement used as `gain` says, whatever it
    /// was designed for.
    fn left(&self, p: &[Matrix4<f64>], gain: &[Matrix4x2<f64>], level: f64) -> Vec<[f64; 2]> {
        let (Some(total), Some(last)) = (self.tau.last(), p.last()) else {
            return Vec::new();
        };
        let level = if level.is_finite() { level } else { 0.0 };
        let at_end = seen(last);
        let s = Matrix2::new(
            at_end[(1, 0)] + level,
            at_end[(1, 1)],
            at_end[(2, 0)],
            at_end[(2, 1)],
        );
        self.tau
            .iter()
            .zip(p)
            .zip(gain)
            .map(|((tau, p), c)| {
                let cross = seen(&(p * self.way(total - tau).transpose()));
                let left =
                    p - c * cross.transpose() - cross * c.transpose() + c * s * c.transpose();
                [left[(2, 2)].max(0.0), left[(3, 3)].max(0.0)]
            })
            .collect()
    }

    /// Φ(h).
    fn way(&self, h: f64) -> Matrix4<f64> {
        transition(self.gravity, h)
    }

    /// What share of the missing tilt, and how much tilt for each m/s of velocity
    /// that is left, is taken for the tilt's error at `tau`.
    pub fn tilt_gain(&self, tau: f64) -> [f64; 2] {
        if self.gain.is_empty() {
            return [0.0; 2];
        }
        let (j, share) = self.place(tau);
        let (a, b) = (&self.gain[j], &self.gain[j + 1]);
        [0, 1].map(|k| a[(1, k)] + share * (b[(1, k)] - a[(1, k)]))
    }

    /// Variance of velocity and position by tilt, and by the accelerometer's noise
    /// of N² = 1.
    pub fn variances(&self, tau: f64) -> ([f64; 2], [f64; 2]) {
        (
            self.between(&self.tilt, tau),
            self.between(&self.accel, tau),
        )
    }

    /// … and what a tilt leaves that walked to a variance of 1 rad² at the end without being
    /// reckoned with: in the second moment one step at an unknown moment.
    pub fn by_tilt_walk(&self, tau: f64) -> [f64; 2] {
        self.between(&self.walk, tau)
    }

    fn between(&self, all: &[[f64; 2]], tau: f64) -> [f64; 2] {
        let (j, share) = self.place(tau);
        [0, 1].map(|k| all[j][k] + share * (all[j + 1][k] - all[j][k]))
    }

    /// The node before `tau`, and how far on to the next, 0 to 1.
    #[inline]
    fn place(&self, tau: f64) -> (usize, f64) {
        let step = self.tau[1];
        let at = if step > 0.0 {
            (tau / step).clamp(0.0, NODES as f64)
        } else {
            0.0
        };
        let j = (at as usize).min(NODES - 1);
        (j, at - j as f64)
    }
}

/// Columns of θ and v: what is seen at the end, of Cov(x, ·).
fn seen(covariance: &Matrix4<f64>) -> Matrix4x2<f64> {
    covariance.fixed_columns::<2>(1).into_owned()
}

fn transition(g: f64, h: f64) -> Matrix4<f64> {
    let (h2, h3) = (h * h / 2.0, h * h * h / 6.0);
    Matrix4::new(
        1.0,
        0.0,
        0.0,
        0.0, //
        h,
        1.0,
        0.0,
        0.0, //
        g * h2,
        g * h,
        1.0,
        0.0, //
        g * h3,
        g * h2,
        h,
        1.0,
    )
}

/// P at each node.
fn covariances(
    tau: &[f64],
    g: f64,
    noise: &Noise,
    density: impl Fn(f64, f64) -> f64,
) -> Vec<Matrix4<f64>> {
    let mut p = Matrix4::zeros();
    p[(0, 0)] = noise.bias;
    p[(1, 1)] = noise.level;
    let mut out = vec![p];
    for pair in tau.windows(2) {
        let h = pair[1] - pair[0];
        let (q, n) = (density(pair[0], pair[1]), noise.accel);
        let way = transition(g, h);
        // What the noise of this step adds.
        let (h2, h3) = (h * h, h * h * h);
        let (tv, tp) = (q * g * h2 / 2.0, q * g * h3 / 6.0);
        let vv = q * g * g * h3 / 3.0 + n * h;
        let vp = q * g * g * h2 * h2 / 8.0 + n * h2 / 2.0;
        let pp = q * g * g * h2 * h3 / 20.0 + n * h3 / 3.0;
        let added = Matrix4::new(
            0.0,
            0.0,
            0.0,
            0.0, //
            0.0,
            q * h,
            tv,
            tp, //
            0.0,
            tv,
            vv,
            vp, //
            0.0,
            tp,
            vp,
            pp,
        );
        p = way * p * way.transpose() + added;
        out.push(p);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: f64 = 9.8;
    const T: f64 = 3.0;

    fn noise(bias: f64, level: f64, accel: f64, seen: f64) -> Noise {
        Noise {
            bias,
            level,
            accel,
            seen,
        }
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-3 * b.abs().max(1e-9), "{a} {b}");
    }

    #[test]
    fn open_loop_is_the_integral_of_white_noise() {
        let (n, ng, rest) = (2.0_f64, 0.3_f64, 4.0);
        let all = noise(ng / rest, n / (G * G * rest), n, 0.0);
        let by_formula = gravical_core::motion::OpenNoise {
            gyro: ng,
            bias: ng / rest,
            tilt_change: 0.0,
            gravity: G,
            rest_s: rest,
        };
        for tau in [0.75, 1.5, 3.0] {
            let open = covariances(&[0.0, tau], G, &all, |_, _| ng)[1];
            let [v, of_tilt_v] = by_formula.velocity(tau);
            let [p, of_tilt_p] = by_formula.position(tau);
            close(open[(2, 2)], n * v + of_tilt_v);
            close(open[(3, 3)], n * p + of_tilt_p);
        }
    }

    #[test]
    fn with_accelerometer_noise_alone_velocity_is_taken_off_evenly() {
        let certain = noise(0.0, 0.0, 1.0, 0.0);
        let design = noise(0.0, 0.0, 1.0, f64::INFINITY);
        let both = Smoother::new(T, G, design, certain, |_, _| (1e-12, 0.0));
        for tau in [0.75, 1.5, 3.0] {
            let (_, accel) = both.variances(tau);
            close(accel[1], tau.powi(3) / 3.0 - tau.powi(4) / (4.0 * T));
            close(accel[0] + 1.0, tau * (T - tau) / T + 1.0);
            assert!(both.tilt_gain(tau)[0].abs() < 1e-6);
        }
        // Gyroscope noise that nobody reckoned with, after that.
        let unseen = noise(0.0, 0.0, 0.0, 0.0);
        let left = Smoother::new(T, G, design, unseen, |_, _| (1e-12, 1.0));
        for tau in [1.5, 3.0_f64] {
            let p = tau.powi(4) * T / 12.0 - 7.0 * tau.powi(5) / 60.0 + tau.powi(6) / (24.0 * T);
            close(left.variances(tau).0[1], G * G * p);
        }
    }

    #[test]
    fn what_is_designed_for_leaves_the_least() {
        let truth = noise(1e-6, 1e-7, 1e-5, 1e-7);
        let left = |design: Noise, q: f64| {
            let s = Smoother::new(20.0, G, design, truth, |_, _| (q, 1e-6));
            let (tilt, accel) = s.variances(20.0);
            tilt[1] + 1e-5 * accel[1]
        };
        let best = left(truth, 1e-6);
        assert!(best > 0.0);
        for (design, q) in [
            (truth, 1e-9),
            (truth, 1e-4),
            (noise(1e-3, 1e-7, 1e-5, 1e-7), 1e-6),
            (noise(1e-6, 1e-7, 1e-2, 1e-7), 1e-6),
            (noise(1e-6, 1e-7, 1e-5, 1e-3), 1e-6),
        ] {
            assert!(left(design, q) > best * (1.0 - 1e-9), "{design:?} {q}");
        }
    }
}
