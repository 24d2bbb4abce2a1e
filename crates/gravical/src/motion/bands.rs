//! Variances that noise gives velocity and position.
//!
//! τ is the time since the rest, T the length of the leg, T₀ that of the rest; N
//! the noise of the accelerometer (velocity walks by N√t), N_g that of the
//! gyroscope. Between two rests the horizontal axes follow [`Smoother`], the
//! vertical one N² (τ³/3 − τ⁴/4T). From a rest on without another,
//!
//! ```text
//! N² (τ³/3 + τ⁴/4T₀) + g² N_g² τ⁵/20 + g² σ_A² τ⁶/36
//! ```
//!
//! with σ_A² the variance of the gyroscope's bias at the rest. All are integrals
//! of white noise; they are tested against simulated noise.

use gravical_core::motion::OpenNoise;

use super::leg::Leg;
use super::smoother::Smoother;

/// A foot in stance still moves by this, m/s.
const STANCE_MPS: f64 = 0.02;

/// What the noise of a leg consists of.
#[derive(Debug, Clone, Copy)]
pub(super) struct LegNoise {
    /// N² along the axes of the frame, m²/s³.
    pub accel: [f64; 3],
    /// The rest at its start, the gyroscope, and a change of tilt without one.
    pub open: OpenNoise<f64>,
    /// Variance of the tilt at the first rest, rad².
    pub level_near: f64,
    /// Variance of what was taken for a change of gravity's size, m²/s⁴.
    pub magnitude: f64,
    /// Square of a velocity that it may have had at the rest, (m/s)²: where another stretch
    /// is as quiet at that velocity, nothing says which of the two is the rest.
    pub ride: f64,
    /// T, s.
    pub total: f64,
}

/// Variances by cause: what the accelerometer's noise makes, and what attitude
/// makes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Variances {
    pub noise: [f64; 3],
    pub tilt: [f64; 3],
}

/// What a closure shows beside the model: noise that was larger than at rest.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Unmodelled {
    /// What N² gains along each axis, m²/s³.
    pub accel: [f64; 3],
    /// Square of the tilt that came on along each axis, rad²: the density of its walk times T.
    pub tilt: [f64; 3],
}

impl LegNoise {
    /// Variance of the position at the end of a leg between two rests where N² = 1, s³.
    pub fn accel_at_end(&self, leg: &Leg<'_>) -> [f64; 3] {
        let up = self.total.powi(3) / 12.0;
        let along = leg
            .closing
            .as_ref()
            .map_or(up, |c| c.smoother.variances(self.total).1[1]);
        [along, along, up]
    }

    /// Variance of velocity and position between two rests.
    pub fn between(
        &self,
        smoother: &Smoother,
        tau: f64,
        more: &Unmodelled,
    ) -> (Variances, Variances) {
        let t = self.total;
        if t <= 0.0 {
            return Default::default();
        }
        let (tilt, accel) = smoother.variances(tau);
        let walk = smoother.by_tilt_walk(tau);
        let ramp_v = 0.5 * (tau * tau - tau * t);
        let ramp_p = tau.powi(3) / 6.0 - tau * tau * t / 4.0;
        let vertical = |ramp: f64| self.magnitude * (ramp / t).powi(2);
        let up_v = (tau * (t - tau) / t).max(0.0);
        let up_p = (tau.powi(3) / 3.0 - tau.powi(4) / (4.0 * t)).max(0.0);
        let [x, y, z]: [f64; 3] = std::array::from_fn(|i| self.accel[i] + more.accel[i]);
        let both = |k: usize, up: f64, ramp: f64| Variances {
            noise: [x * accel[k], y * accel[k], z * up],
            tilt: [
                tilt[k] + more.tilt[0] * walk[k],
                tilt[k] + more.tilt[1] * walk[k],
                vertical(ramp),
            ],
        };
        (both(0, up_v, ramp_v), both(1, up_p, ramp_p))
    }

    /// Variance of velocity and position from a rest on, without another.
    pub fn open(&self, tau: f64) -> (Variances, Variances) {
        let of = |[noise, tilt]: [f64; 2], ride: f64| Variances {
            noise: self.accel.map(|n| n * noise + ride),
            tilt: [tilt, tilt, 0.0],
        };
        (
            of(self.open.velocity(tau), self.ride),
            of(self.open.position(tau), self.ride * tau * tau),
        )
    }

    /// Variance of the way from τ to the far end T, without a rest there: what
    /// a leg that ran backwards in time says of its start.
    pub fn way_open(&self, tau: f64) -> Variances {
        let (t, rest) = (self.total, self.open.rest_s);
        let way = (t - tau).powi(2) * tau + (t - tau).powi(3) / 3.0;
        let mean = (t * t - tau * tau).powi(2) / (4.0 * rest);
        let tilt = |tau: f64| self.open(tau).1.tilt[0].sqrt();
        let tilt = (tilt(t) - tilt(tau)).powi(2);
        Variances {
            noise: self
                .accel
                .map(|n| n * (way + mean) + self.ride * (t - tau).powi(2)),
            tilt: [tilt, tilt, 0.0],
        }
    }

    /// Variance where the mean over the first T₀ seconds was taken off and
    /// integration began with them.
    pub fn after_mean(&self, tau: f64) -> (Variances, Variances) {
        let t0 = self.open.rest_s;
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
        let g2 = self.open.gravity.powi(2);
        let moving = (tau - t0).max(0.0);
        let tilt_v = g2 * self.open.tilt_change * moving * moving;
        let tilt_p = g2 * self.open.tilt_change * moving.powi(4) / 4.0;
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

/// Variances along a walk: each step starts and ends in a stance.
pub(super) struct Steps {
    /// Of velocity and position at each sample: by noise of the accelerometer with
    /// N² = 1, and by what velocity a stance may have.
    noise: Vec<[f64; 2]>,
    stance: Vec<[f64; 2]>,
    /// By tilt.
    tilt: Vec<[f64; 2]>,
}

impl Steps {
    pub fn new(leg: &Leg<'_>, tau: &[f64], of: &LegNoise) -> Self {
        let last = tau.len() - 1;
        let mut out = Steps {
            noise: vec![[0.0; 2]; tau.len()],
            stance: vec![[0.0; 2]; tau.len()],
            tilt: vec![[0.0; 2]; tau.len()],
        };
        let (mut noise, mut stance, mut tilt) = (0.0, 0.0, 0.0);
        let g2 = of.open.gravity * of.open.gravity;
        let mut from = 0;
        let end = last..last + 1;
        for next in leg.stances.iter().chain(std::iter::once(&end)) {
            let closed = next.start < last || leg.closing.is_some();
            let t = tau[next.start] - tau[from];
            for k in from..=next.start {
                let s = tau[k] - tau[from];
                let (v, p) = if closed && t > 0.0 {
                    (s * (t - s) / t, s.powi(3) / 3.0 - s.powi(4) / (4.0 * t))
                } else {
                    (s, s.powi(3) / 3.0)
                };
                out.noise[k] = [v, noise + p];
                let [v, p] = tilt_of_step(of, tau[from], s, closed.then_some(t));
                out.tilt[k] = [g2 * v, tilt + g2 * p];
                out.stance[k] = [STANCE_MPS * STANCE_MPS, stance + (STANCE_MPS * s).powi(2)];
            }
            noise = out.noise[next.start][1];
            stance = out.stance[next.start][1];
            tilt = out.tilt[next.start][1];
            from = next.end.min(last + 1) - 1;
            for k in next.start..=from {
                out.noise[k] = [0.0, noise];
                out.stance[k] = [STANCE_MPS * STANCE_MPS, stance];
                out.tilt[k] = [0.0, tilt];
            }
        }
        out
    }

    pub fn at(&self, k: usize, noise: &LegNoise) -> (Variances, Variances) {
        let of = |i: usize| Variances {
            noise: noise
                .accel
                .map(|n| n * self.noise[k][i] + self.stance[k][i]),
            tilt: [self.tilt[k][i], self.tilt[k][i], 0.0],
        };
        (of(0), of(1))
    }
}

/// Variance of velocity and position over g² that tilt makes `s` seconds into a
/// step that begins `before` seconds after the last rest; `closed` is the step's
/// length where a stance ends it.
fn tilt_of_step(noise: &LegNoise, before: f64, s: f64, closed: Option<f64>) -> [f64; 2] {
    let (q, b) = (noise.open.gyro, noise.open.bias);
    match closed {
        // What the tilt was at the start of the step is a velocity that grows evenly:
        // the stance takes it off.
        Some(t) if t > 0.0 => {
            let walk_v = s * s * (t - s).powi(2) / (3.0 * t);
            let walk_p = s.powi(4) * t / 12.0 - 7.0 * s.powi(5) / 60.0 + s.powi(6) / (24.0 * t);
            let (e, d) = (0.5 * (s * s - s * t), s.powi(3) / 6.0 - s * s * t / 4.0);
            [
                q * walk_v.max(0.0) + b * e * e,
                q * walk_p.max(0.0) + b * d * d,
            ]
        }
        _ => {
            let start = noise.level_near + q * before;
            let (v, p) = (
                before * s + s * s / 2.0,
                before * s * s / 2.0 + s.powi(3) / 6.0,
            );
            [
                start * s * s + q * s.powi(3) / 3.0 + b * v * v,
                start * s.powi(4) / 4.0 + q * s.powi(5) / 20.0 + b * p * p,
            ]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::smoother::Noise;
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    const T: f64 = 3.0;
    const REST: f64 = 2.0;
    const H: f64 = 0.02;

    fn unit() -> LegNoise {
        LegNoise {
            accel: [1.0; 3],
            open: OpenNoise {
                gyro: 0.0,
                bias: 0.0,
                tilt_change: 0.0,
                gravity: 1.0,
                rest_s: REST,
            },
            level_near: 0.0,
            magnitude: 0.0,
            ride: 0.0,
            total: T,
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
        let unit = unit();
        let draw = |rng: &mut ChaCha8Rng, n: usize| -> Vec<f64> {
            (0..n).map(|_| white(rng) / H.sqrt()).collect()
        };
        let none = Noise {
            bias: 0.0,
            level: 0.0,
            accel: 1.0,
            seen: 1.0,
        };
        let smoother = Smoother::new(T, 1.0, none, none, |_, _| (0.0, 0.0));
        compare(draw, true, |tau| {
            let (v, p) = unit.between(&smoother, tau, &Unmodelled::default());
            (v.noise[2], p.noise[2])
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
    fn a_smoother_leaves_what_it_says() {
        let (q, n, bias, level) = (1.0, 0.5, 0.3, 0.2);
        let noise = Noise {
            bias,
            level,
            accel: n,
            seen: level,
        };
        let smoother = Smoother::new(T, 1.0, noise, noise, |_, _| (q, q));
        let draw = |rng: &mut ChaCha8Rng, count: usize| -> Vec<f64> {
            let beta = bias.sqrt() * white(rng);
            let mut theta = level.sqrt() * white(rng);
            let mut tilt = vec![theta];
            let mut before = white(rng) / H.sqrt();
            for _ in 1..count {
                let rate = white(rng) / H.sqrt();
                theta += H * (0.5 * (rate + before) + beta);
                before = rate;
                tilt.push(theta);
            }
            let walk: Vec<f64> = tilt.iter().map(|_| (n / H).sqrt() * white(rng)).collect();
            let a: Vec<f64> = tilt.iter().zip(&walk).map(|(t, w)| t + w).collect();
            let left = integrated(&a, false).0[count - 1];
            let missing = theta + level.sqrt() * white(rng);
            a.iter()
                .enumerate()
                .map(|(k, a)| {
                    let [of_tilt, of_velocity] = smoother.tilt_gain(H * k as f64);
                    a - of_tilt * missing - of_velocity * left
                })
                .collect()
        };
        compare(draw, true, |tau| {
            let (tilt, accel) = smoother.variances(tau);
            let v = tilt[0] + n * accel[0];
            (if tau > T - H { 0.0 } else { v }, tilt[1] + n * accel[1])
        });
    }
}
