//! One leg: its samples, its bands, and where it takes the sensor.

use gravical_core::matrix3::{norm, sub};
use gravical_core::strapdown::times;

use super::super::bands::{LegNoise, Variances};
use super::super::leg::{Leg, Ran, Removal};
use super::super::parameters::Direction;
use super::super::result::{Ends, Move};
use super::Path;
use super::linear::Linear;
use super::setup::Setup;
use super::state::State;

/// Step of the parameters for their effect, in standard deviations.
const STEP: f64 = 1e-3;

impl Setup<'_> {
    /// Runs one leg, writes its samples, and takes the state to its end.
    pub(super) fn fly(
        &self,
        leg: &Leg<'_>,
        ends: Ends,
        noise: &LegNoise,
        state: &mut State,
        path: &mut Path,
        scratch: &mut (Ran, Ran),
    ) -> Move {
        let (ran, changed) = scratch;
        leg.run(&Direction::NONE, true, ran);
        let count = ran.tau.len();
        let last = count - 1;
        // Of a leg that ran backwards the far end is the start.
        let backwards = ends == Ends::ToRest;
        let zero = if backwards {
            ran.position[last]
        } else {
            [0.0; 3]
        };
        let way = if backwards {
            ran.position[last].map(|v| -v)
        } else {
            ran.position[last]
        };
        let origin = state.position;
        let order = |k: usize| {
            if backwards {
                leg.near - k
            } else {
                leg.near + k
            }
        };
        for k in 0..count {
            let i = order(k);
            path.attitude[i] = ran.attitude[k];
            path.acceleration[i] = ran.acceleration[k];
            path.velocity[i] = ran.velocity[k];
            if state.known {
                path.position[i] =
                    std::array::from_fn(|a| origin[a] + ran.position[k][a] - zero[a]);
            }
        }
        let mut displacement_sigma = None;
        if self.bands {
            let mut variance_v = vec![[0.0; 3]; count];
            let mut variance_p = vec![[0.0; 3]; count];
            let mut own = [0.0; 3];
            let linear = matches!(leg.removal, Removal::Mean(_))
                && leg.stances.is_empty()
                && leg.v0 == [0.0; 3];
            if linear {
                let effect = Linear::new(self.directions, &state.offsets);
                for k in 0..count {
                    variance_v[k] = effect.of_velocity(&ran.velocity[k]);
                    variance_p[k] = effect.of_position(&sub(&ran.position[k], &zero));
                }
                own = self.shift(state, &way);
            }
            let run_again = if linear { 0 } else { self.directions.len() };
            let changes = self
                .directions
                .iter()
                .zip(&mut state.offsets)
                .zip(&mut state.yaw_offsets);
            for ((direction, offset), yaw) in changes.take(run_again) {
                leg.run(&direction.times(STEP), false, changed);
                // The heading that the legs before have lost turns this one.
                let turned = *yaw;
                let off = |k: usize, i: usize| {
                    let p = sub(&ran.position[k], &ran.position[0]);
                    let aside = [-turned * p[1], turned * p[0], 0.0];
                    (changed.position[k][i] - ran.position[k][i]) / STEP + aside[i]
                };
                if !backwards {
                    *yaw += heading(&changed.last, &ran.last) / STEP;
                }
                let far: [f64; 3] = std::array::from_fn(|i| off(last, i));
                for k in 0..count {
                    for i in 0..3 {
                        let base = if backwards { -far[i] } else { 0.0 };
                        let p = offset[i] + off(k, i) + base;
                        let v = (changed.velocity[k][i] - ran.velocity[k][i]) / STEP;
                        variance_p[k][i] += p * p;
                        variance_v[k][i] += v * v;
                    }
                }
                for i in 0..3 {
                    own[i] += far[i] * far[i];
                    offset[i] += if backwards { -far[i] } else { far[i] };
                }
            }
            let mut end = Variances::default();
            let steps = (!leg.stances.is_empty()).then(|| Steps::new(leg, &ran.tau, noise));
            for k in 0..count {
                let tau = ran.tau[k].abs();
                let (v, p) = match &steps {
                    Some(steps) => steps.at(k, noise),
                    None => self.variances(leg, ends, noise, tau),
                };
                let rotation = self.rotation(noise, tau, &ran.position[k], &zero);
                let i = order(k);
                let here: [f64; 3] =
                    std::array::from_fn(|a| origin[a] + ran.position[k][a] - zero[a]);
                let total = self.total(state, &p, &rotation, &variance_p[k], &here);
                for a in 0..3 {
                    if state.known {
                        path.sigma_position[i][a] = total[a].sqrt();
                    }
                    let clock = self.clock_error * ran.velocity[k][a];
                    path.sigma_velocity[i][a] =
                        (v.noise[a] + v.tilt[a] + variance_v[k][a] + clock * clock).sqrt();
                }
                if k == if backwards { 0 } else { last } {
                    end = p;
                    (0..3).for_each(|a| end.tilt[a] += rotation[a]);
                }
            }
            displacement_sigma = Some(self.arrive(state, &end, &own, &way));
        }
        let place: [f64; 3] = std::array::from_fn(|a| origin[a] + way[a]);
        // The heading is that of the first rest: what ran backwards from it turns
        // nothing that comes after.
        if !backwards && (noise.gyro > 0.0 || noise.bias > 0.0) {
            let yaw = noise.gyro * noise.total + noise.bias * noise.total.powi(2);
            state.yaw.add(yaw, &place);
        }
        state.position = place;
        if !backwards {
            state.attitude = ran.last;
        }
        let speeds = ran.velocity.iter().map(norm);
        let path_m: f64 = ran
            .velocity
            .windows(2)
            .zip(ran.tau.windows(2))
            .map(|(v, t)| 0.5 * (norm(&v[0]) + norm(&v[1])) * (t[1] - t[0]).abs())
            .sum();
        Move {
            start_s: self.samples.t_s[leg.near.min(leg.far)],
            end_s: self.samples.t_s[leg.near.max(leg.far)],
            ends,
            displacement_m: Some(way),
            sigma_m: displacement_sigma,
            uncalibrated_m: None,
            peak_speed_mps: Some(speeds.fold(0.0, f64::max)),
            path_m: Some(path_m),
            velocity_error_mps: leg.end.map(|_| ran.left_over),
            missing_tilt_deg: leg.end.map(|_| norm(&ran.missing).to_degrees()),
            usable: true,
            reason: None,
        }
    }

    fn variances(
        &self,
        leg: &Leg<'_>,
        ends: Ends,
        noise: &LegNoise,
        tau: f64,
    ) -> (Variances, Variances) {
        match (leg.removal, ends) {
            (Removal::Mean(_), Ends::FromRest | Ends::Free) if leg.near == 0 => {
                noise.after_mean(tau)
            }
            (_, Ends::RestToRest) => noise.between(&leg.smoother, tau),
            (_, Ends::ToRest) => (noise.open(tau).0, noise.way_open(tau)),
            (_, Ends::FromRest | Ends::Free) => noise.open(tau),
        }
    }

    /// What a tilt that the levelling missed turns up and down, and what the yaw
    /// of the leg itself turns sideways.
    pub(super) fn rotation(
        &self,
        noise: &LegNoise,
        tau: f64,
        p: &[f64; 3],
        zero: &[f64; 3],
    ) -> [f64; 3] {
        let p: [f64; 3] = std::array::from_fn(|i| p[i] - zero[i]);
        let level = noise.level_near;
        let yaw = (noise.gyro * tau + noise.bias * tau * tau) / 3.0;
        [
            level * p[2] * p[2] + yaw * p[1] * p[1],
            level * p[2] * p[2] + yaw * p[0] * p[0],
            level * (p[0] * p[0] + p[1] * p[1]),
        ]
    }
}

/// A foot in stance still moves by this, m/s.
const STANCE_MPS: f64 = 0.02;

/// Variances along a walk: each step starts and ends in a stance.
struct Steps {
    /// Of velocity and position at each sample: by noise of the accelerometer with
    /// N² = 1, and by what velocity a stance may have.
    noise: Vec<[f64; 2]>,
    stance: Vec<[f64; 2]>,
    /// By tilt.
    tilt: Vec<[f64; 2]>,
}

impl Steps {
    fn new(leg: &Leg<'_>, tau: &[f64], of: &LegNoise) -> Self {
        let last = tau.len() - 1;
        let mut out = Steps {
            noise: vec![[0.0; 2]; tau.len()],
            stance: vec![[0.0; 2]; tau.len()],
            tilt: vec![[0.0; 2]; tau.len()],
        };
        let (mut noise, mut stance, mut tilt) = (0.0, 0.0, 0.0);
        let g2 = of.gravity * of.gravity;
        let mut from = 0;
        let end = last..last + 1;
        for next in leg.stances.iter().chain(std::iter::once(&end)) {
            let closed = next.start < last || leg.end.is_some();
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

    fn at(&self, k: usize, noise: &LegNoise) -> (Variances, Variances) {
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
    let (q, b) = (noise.gyro, noise.bias);
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

/// How far the first attitude is turned about the vertical against the second,
/// rad; small.
fn heading(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    let back = [b[0], -b[1], -b[2], -b[3]];
    2.0 * times(a, &back)[3]
}
