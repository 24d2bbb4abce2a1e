//! Variances that noise gives velocity and position, in closed form.
//!
//! τ is the time since the rest, T the length of the leg, T₀ that of the rest; N
//! the noise of the accelerometer (velocity walks by N√t), N_g that of the
//! gyroscope; w the share of the missing tilt that is corrected.
//!
//! Between rests, with d = τ³/6 − τ²T/4 what a tilt that grows evenly becomes
//! after the zero-velocity correction, and d₂ = τ⁴/24T − τ²T/12 what the second
//! half of a rate that goes over from one bias to the other becomes:
//!
//! ```text
//! accelerometer  N² (τ³/3 − τ⁴/4T)
//! gyroscope      g² N_g² [τ⁴T/12 − 7τ⁵/60 + τ⁶/24T − d² (2w − w²)/T]
//! its biases     g² [σ_A² (d − d₂ − wd/2)² + σ_B² (d₂ − wd/2)²]
//! levelling      g² w² σ_ε² (d/T)²
//! ```
//!
//! From a rest on without another, N² (τ³/3 + τ⁴/4T₀) + g² N_g² τ⁵/20 +
//! g² σ_A² τ⁶/36. All are integrals of white noise; they are tested against
//! simulated noise.

/// What the noise of a leg consists of.
#[derive(Debug, Clone, Copy)]
pub(super) struct LegNoise {
    /// N² along the axes of the frame, m²/s³.
    pub accel: [f64; 3],
    /// N_g², rad²/s.
    pub gyro: f64,
    /// Variance of the gyroscope's bias at the first rest, rad²/s².
    pub bias_near: f64,
    /// At the second; none where it is that of the first.
    pub bias_far: Option<f64>,
    /// Variance of the tilt that the two rests show, between them, rad².
    pub levelling: f64,
    /// Variance of the tilt at the first rest, rad².
    pub level_near: f64,
    /// Constant tilt that sets in with the motion (without a gyroscope), rad².
    pub wobble: f64,
    /// Variance of what was taken for a change of gravity's size, m²/s⁴.
    pub magnitude: f64,
    /// w.
    pub tilt_gain: f64,
    /// g, m/s².
    pub gravity: f64,
    /// T, s.
    pub total: f64,
    /// T₀, s.
    pub rest: f64,
}

/// Variances by cause: what the accelerometer's noise makes, and what attitude
/// makes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Variances {
    pub noise: [f64; 3],
    pub tilt: [f64; 3],
}

impl LegNoise {
    /// Variance of velocity and position between two rests.
    pub fn between(&self, tau: f64) -> (Variances, Variances) {
        let (t, w) = (self.total, self.tilt_gain);
        if t <= 0.0 {
            return Default::default();
        }
        let (t2, t3, t4) = (tau * tau, tau.powi(3), tau.powi(4));
        let d = t3 / 6.0 - t2 * t / 4.0;
        let d2 = t4 / (24.0 * t) - t2 * t / 12.0;
        let e = 0.5 * (t2 - tau * t);
        let e2 = t3 / (6.0 * t) - tau * t / 6.0;
        let walk_p = tau.powi(4) * t / 12.0 - 7.0 * tau.powi(5) / 60.0 + tau.powi(6) / (24.0 * t);
        let walk_v = t2 * (t - tau).powi(2) / (3.0 * t);
        let tilt = |walk: f64, d: f64, d2: f64| {
            let corrected = d * d * (2.0 * w - w * w) / t;
            let bias = match self.bias_far {
                Some(far) => {
                    self.bias_near * (d - d2 - 0.5 * w * d).powi(2)
                        + far * (d2 - 0.5 * w * d).powi(2)
                }
                None => self.bias_near * ((1.0 - w) * d).powi(2),
            };
            let level = w * w * self.levelling * (d / t).powi(2);
            self.gravity.powi(2) * (self.gyro * (walk - corrected).max(0.0) + bias + level)
        };
        let (tilt_v, tilt_p) = (tilt(walk_v, e, e2), tilt(walk_p, d, d2));
        let vertical = |d: f64| self.magnitude * (d / t).powi(2);
        (
            Variances {
                noise: self.accel.map(|n| n * (tau * (t - tau) / t).max(0.0)),
                tilt: [tilt_v, tilt_v, vertical(e)],
            },
            Variances {
                noise: self.accel.map(|n| n * (t3 / 3.0 - t4 / (4.0 * t)).max(0.0)),
                tilt: [tilt_p, tilt_p, vertical(d)],
            },
        )
    }

    /// Variance of velocity and position from a rest on, without another.
    pub fn open(&self, tau: f64) -> (Variances, Variances) {
        let g2 = self.gravity.powi(2);
        let tilt_v = self.gyro * tau.powi(3) / 3.0
            + self.bias_near * tau.powi(4) / 4.0
            + self.wobble * tau * tau;
        let tilt_p = self.gyro * tau.powi(5) / 20.0
            + self.bias_near * tau.powi(6) / 36.0
            + self.wobble * tau.powi(4) / 4.0;
        let (tilt_v, tilt_p) = (g2 * tilt_v, g2 * tilt_p);
        (
            Variances {
                noise: self.accel.map(|n| n * (tau + tau * tau / self.rest)),
                tilt: [tilt_v, tilt_v, 0.0],
            },
            Variances {
                noise: self
                    .accel
                    .map(|n| n * (tau.powi(3) / 3.0 + tau.powi(4) / (4.0 * self.rest))),
                tilt: [tilt_p, tilt_p, 0.0],
            },
        )
    }

    /// Variance of the way from τ to the far end T, without a rest there: what
    /// a leg that ran backwards in time says of its start.
    pub fn way_open(&self, tau: f64) -> Variances {
        let (t, rest) = (self.total, self.rest);
        let way = (t - tau).powi(2) * tau + (t - tau).powi(3) / 3.0;
        let mean = (t * t - tau * tau).powi(2) / (4.0 * rest);
        let tilt = |tau: f64| self.open(tau).1.tilt[0].sqrt();
        let tilt = (tilt(t) - tilt(tau)).powi(2);
        Variances {
            noise: self.accel.map(|n| n * (way + mean)),
            tilt: [tilt, tilt, 0.0],
        }
    }

    /// Variance where the mean over the first T₀ seconds was taken off and
    /// integration began with them.
    pub fn after_mean(&self, tau: f64) -> (Variances, Variances) {
        let t0 = self.rest;
        let (v, p) = if tau <= t0 {
            (
                tau - tau * tau / t0,
                tau.powi(3) / 3.0 - tau.powi(4) / (4.0 * t0),
            )
        } else {
            (
                tau * tau / t0 - tau,
                tau.powi(4) / (4.0 * t0) + 0.5 * tau * tau * t0 - 2.0 * tau.powi(3) / 3.0,
            )
        };
        let g2 = self.gravity.powi(2);
        let moving = (tau - t0).max(0.0);
        let tilt_v = g2 * self.wobble * moving * moving;
        let tilt_p = g2 * self.wobble * moving.powi(4) / 4.0;
        (
            Variances {
                noise: self.accel.map(|n| n * v.max(0.0)),
                tilt: [tilt_v, tilt_v, 0.0],
            },
            Variances {
                noise: self.accel.map(|n| n * p.max(0.0)),
                tilt: [tilt_p, tilt_p, 0.0],
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    const T: f64 = 3.0;
    const REST: f64 = 2.0;
    const H: f64 = 0.02;

    fn noise(w: f64) -> LegNoise {
        LegNoise {
            accel: [0.0; 3],
            gyro: 0.0,
            bias_near: 0.0,
            bias_far: None,
            levelling: 0.0,
            level_near: 0.0,
            wobble: 0.0,
            magnitude: 0.0,
            tilt_gain: w,
            gravity: 1.0,
            total: T,
            rest: REST,
        }
    }

    /// Twice the integral of an acceleration; with `ends` the velocity at the end
    /// is taken off evenly.
    fn integrated(a: &[f64], ends: bool) -> (Vec<f64>, Vec<f64>) {
        let (mut v, mut p) = (vec![0.0], vec![0.0]);
        for k in 1..a.len() {
            v.push(v[k - 1] + 0.5 * H * (a[k] + a[k - 1]));
            p.push(p[k - 1] + 0.5 * H * (v[k] + v[k - 1]));
        }
        if ends {
            let slope = v[a.len() - 1] / T;
            for k in 0..a.len() {
                let tau = H * k as f64;
                v[k] -= slope * tau;
                p[k] -= 0.5 * slope * tau * tau;
            }
        }
        (v, p)
    }

    /// Compares a variance with that of many draws of `error`, an acceleration.
    fn compare(
        mut error: impl FnMut(&mut ChaCha8Rng, usize) -> Vec<f64>,
        ends: bool,
        formula: impl Fn(f64) -> (f64, f64),
    ) {
        let n = (T / H) as usize + 1;
        let runs = 4000;
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let (mut v2, mut p2) = (vec![0.0; n], vec![0.0; n]);
        for _ in 0..runs {
            let (v, p) = integrated(&error(&mut rng, n), ends);
            for k in 0..n {
                v2[k] += v[k] * v[k] / f64::from(runs);
                p2[k] += p[k] * p[k] / f64::from(runs);
            }
        }
        for k in [n / 4, n / 2, 3 * n / 4, n - 1] {
            let (v, p) = formula(H * k as f64);
            // Five standard deviations of a variance of so many draws.
            let far = 5.0 * (2.0 / f64::from(runs)).sqrt();
            assert!(
                (p2[k] / p - 1.0).abs() < far + 0.02,
                "p at {k}: {} {p}",
                p2[k]
            );
            if v > 0.0 {
                assert!(
                    (v2[k] / v - 1.0).abs() < far + 0.02,
                    "v at {k}: {} {v}",
                    v2[k]
                );
            }
        }
    }

    fn white(rng: &mut ChaCha8Rng) -> f64 {
        rng.sample(StandardNormal)
    }

    #[test]
    fn accelerometer_noise_between_rests_and_open() {
        let unit = LegNoise {
            accel: [1.0; 3],
            ..noise(0.0)
        };
        let draw = |rng: &mut ChaCha8Rng, n: usize| -> Vec<f64> {
            (0..n).map(|_| white(rng) / H.sqrt()).collect()
        };
        compare(draw, true, |tau| {
            let (v, p) = unit.between(tau);
            (v.noise[0], p.noise[0])
        });
        let with_mean = |rng: &mut ChaCha8Rng, n: usize| -> Vec<f64> {
            let mean = white(rng) / REST.sqrt();
            draw(rng, n).into_iter().map(|a| a - mean).collect()
        };
        compare(with_mean, false, |tau| {
            let (v, p) = unit.open(tau);
            (v.noise[0], p.noise[0])
        });
        let own_mean = |rng: &mut ChaCha8Rng, n: usize| -> Vec<f64> {
            let a = draw(rng, n);
            let rows = (REST / H) as usize;
            let mean = a[..rows].iter().sum::<f64>() / rows as f64;
            a.into_iter().map(|a| a - mean).collect()
        };
        compare(own_mean, false, |tau| {
            let (v, p) = unit.after_mean(tau);
            (v.noise[0], p.noise[0])
        });
    }

    #[test]
    fn gyroscope_noise_bias_and_levelling() {
        for w in [0.0, 0.4, 1.0] {
            let all = LegNoise {
                gyro: 1.0,
                bias_near: 0.3,
                bias_far: Some(0.6),
                levelling: 0.8,
                ..noise(w)
            };
            let draw = |rng: &mut ChaCha8Rng, n: usize| -> Vec<f64> {
                let (near, far) = (0.3_f64.sqrt() * white(rng), 0.6_f64.sqrt() * white(rng));
                let level = 0.8_f64.sqrt() * white(rng);
                let mut theta = 0.0;
                let mut before = white(rng) / H.sqrt();
                let mut tilt = vec![0.0];
                for k in 1..n {
                    let s = k as f64 / (n - 1) as f64;
                    let rate = white(rng) / H.sqrt();
                    theta += H * (0.5 * (rate + before) + near + (far - near) * s);
                    before = rate;
                    tilt.push(theta);
                }
                let missing = w * (theta + level);
                (0..n)
                    .map(|k| tilt[k] - missing * k as f64 / (n - 1) as f64)
                    .collect()
            };
            compare(draw, true, |tau| {
                let (v, p) = all.between(tau);
                // At the end nothing is left of the velocity.
                (if tau > T - H { 0.0 } else { v.tilt[0] }, p.tilt[0])
            });
        }
    }
}
