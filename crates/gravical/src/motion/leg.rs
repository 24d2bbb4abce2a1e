//! One leg: from a rest to the next, from a rest to the end, from the start to a
//! rest, or the whole of a recording without rest.
//!
//! The order of things: level at the rest, follow the attitude with the
//! gyroscope, turn the specific force upright, spread what is missing of the tilt
//! at the next rest over the leg, take gravity off, integrate, and take off the
//! velocity that is left at the rest.

use std::ops::Range;

use gravical_core::integrate::Trapezoid;
use gravical_core::matrix3::{add, cross, mul_vec, norm, scaled, sub};
use gravical_core::strapdown::{Strapdown, matrix, missing_tilt, rotate, times, turn};

use super::parameters::Direction;
use super::samples::Samples;
use super::smoother::Smoother;

/// What a rest says.
#[derive(Debug, Clone, Copy)]
pub(super) struct Anchor {
    /// Mean specific force, m/s².
    pub force: [f64; 3],
    /// So many seconds of noise alone the mean is worth.
    pub seconds: f64,
    /// Bias of the gyroscope, rad/s; zero without one.
    pub bias: [f64; 3],
    /// Its variance, rad²/s².
    pub bias_variance: f64,
}

/// How gravity is taken off in a leg.
#[derive(Debug, Clone, Copy)]
pub(super) enum Removal {
    /// The attitude is followed with the gyroscope.
    Strapdown,
    /// The tilt goes from that of one rest to that of the other.
    Tilt,
    /// The tilt stays that of the rest at the start.
    ConstantTilt,
    /// This mean is subtracted; nothing is turned.
    Mean([f64; 3]),
}

/// A leg: samples `near` to `far`, both included. The rest that it starts from
/// lies before `near`; `near` > `far` runs backwards in time.
#[derive(Debug, Clone)]
pub(super) struct Leg<'a> {
    pub samples: &'a Samples,
    pub near: usize,
    pub far: usize,
    /// The rest at `near`.
    pub start: Anchor,
    /// The rest at `far`.
    pub end: Option<Anchor>,
    /// Attitude at `near` as far as it is known; the rest levels it.
    pub attitude: [f64; 4],
    pub removal: Removal,
    /// What the second rest says of the tilt along the leg.
    pub smoother: Smoother,
    /// How much of the change of the magnitude between the rests is believed, 0
    /// to 1.
    pub magnitude_gain: f64,
    /// Stances between the rests, counted from `near`; velocity is zero in them.
    pub stances: Vec<Range<usize>>,
    /// Velocity at `near`, m/s: zero after a rest.
    pub v0: [f64; 3],
}

/// What a leg comes to, sample by sample from `near` on. Kept from run to run to
/// save the allocations.
#[derive(Debug, Clone, Default)]
pub(super) struct Ran {
    /// Time since `near`, s; negative when it ran backwards.
    pub tau: Vec<f64>,
    /// Attitude, where asked for.
    pub attitude: Vec<[f64; 4]>,
    /// Acceleration in the frame, m/s².
    pub acceleration: Vec<[f64; 3]>,
    pub velocity: Vec<[f64; 3]>,
    pub position: Vec<[f64; 3]>,
    /// Velocity at `far` before it was taken off, m/s.
    pub left_over: [f64; 3],
    /// Rotation vector in the frame that was missing at `far`, rad.
    pub missing: [f64; 3],
    /// Attitude at `far`.
    pub last: [f64; 4],
}

impl Leg<'_> {
    /// Duration, s.
    pub fn seconds(&self) -> f64 {
        (self.samples.t_s[self.far] - self.samples.t_s[self.near]).abs()
    }

    /// Its samples in the order that it takes them.
    pub fn order(&self) -> impl Iterator<Item = usize> + use<> {
        let (near, far) = (self.near, self.far);
        let count = near.abs_diff(far) + 1;
        (0..count).map(move |k| if near <= far { near + k } else { near - k })
    }

    /// The attitude at `near`: levelled by the rest.
    pub fn levelled(&self, force: &[f64; 3]) -> [f64; 4] {
        match self.removal {
            Removal::Mean(_) => [1.0, 0.0, 0.0, 0.0],
            _ => times(&turn(&missing_tilt(&self.attitude, force)), &self.attitude),
        }
    }

    /// Runs the leg, its parameters changed by `change`.
    pub fn run(&self, change: &Direction, with_attitude: bool, out: &mut Ran) {
        let force_of = |f: [f64; 3]| add(&f, &change.force(&f));
        let rate_of = |w: [f64; 3]| add(&w, &change.rate(&w));
        let samples = self.samples;
        let (start, end) = (
            force_of(self.start.force),
            self.end.map(|e| force_of(e.force)),
        );
        let bias = rate_of(self.start.bias);
        let drift = self.end.map_or([0.0; 3], |e| sub(&rate_of(e.bias), &bias));
        let t0 = samples.t_s[self.near];
        let total = samples.t_s[self.far] - t0;
        let share = |tau: f64| if total == 0.0 { 1.0 } else { tau / total };

        out.tau.clear();
        out.attitude.clear();
        out.acceleration.clear();
        out.velocity.clear();
        out.position.clear();
        let q0 = self.levelled(&start);

        // The specific force, turned into the frame.
        let mut q = q0;
        match self.removal {
            Removal::Strapdown => {
                let mut strapdown = Strapdown::new(q0);
                let mut before = t0;
                for i in self.order() {
                    let t = samples.t_s[i];
                    let tau = t - t0;
                    let s = share(tau);
                    let offset = [
                        bias[0] + s * drift[0],
                        bias[1] + s * drift[1],
                        bias[2] + s * drift[2],
                    ];
                    q = strapdown.update(sub(&rate_of(samples.rate_at(i)), &offset), t - before);
                    before = t;
                    out.tau.push(tau);
                    if with_attitude {
                        out.attitude.push(q);
                    }
                    out.acceleration
                        .push(rotate(&q, &force_of(samples.force_at(i))));
                }
            }
            Removal::Tilt | Removal::ConstantTilt | Removal::Mean(_) => {
                let r = matrix(&q0);
                for i in self.order() {
                    out.tau.push(samples.t_s[i] - t0);
                    if with_attitude {
                        out.attitude.push(q0);
                    }
                    out.acceleration
                        .push(mul_vec(&r, &force_of(samples.force_at(i))));
                }
            }
        }

        // What the second rest shows: tilt that is missing, velocity that is left.
        out.missing = match (end, self.removal) {
            (Some(end), Removal::Strapdown | Removal::Tilt) => missing_tilt(&q, &end),
            _ => [0.0; 3],
        };
        let mut left = [0.0; 2];
        if end.is_some() {
            for (a, tau) in out.acceleration.windows(2).zip(out.tau.windows(2)) {
                let half = 0.5 * (tau[1] - tau[0]);
                (0..2).for_each(|i| left[i] += half * (a[0][i] + a[1][i]));
            }
        }
        let upright = Upright {
            smoother: &self.smoother,
            missing: out.missing,
            left,
            active: end.is_some() && !matches!(self.removal, Removal::Mean(_)),
        };
        let (down, change_of_down) = match self.removal {
            Removal::Mean(mean) => (force_of(mean), [0.0; 3]),
            _ => {
                let g = norm(&start);
                let more = end.map_or(0.0, |e| self.magnitude_gain * (norm(&e) - g));
                ([0.0, 0.0, g], [0.0, 0.0, more])
            }
        };
        let mut way = Trapezoid::new(self.v0, [0.0; 3]);
        let mut before = 0.0;
        for (k, a) in out.acceleration.iter_mut().enumerate() {
            let tau = out.tau[k];
            let s = share(tau);
            let turned = upright.apply(tau, a);
            *a = [
                turned[0] - down[0] - s * change_of_down[0],
                turned[1] - down[1] - s * change_of_down[1],
                turned[2] - down[2] - s * change_of_down[2],
            ];
            way.update(*a, tau - before);
            before = tau;
            out.velocity.push(way.velocity());
            out.position.push(way.position());
        }
        for (q, tau) in out.attitude.iter_mut().zip(&out.tau) {
            *q = times(&turn(&upright.vector(*tau)), q);
        }
        out.last = times(&turn(&upright.vector(total)), &q);
        out.left_over = way.velocity();

        if !self.stances.is_empty() {
            self.stand(out);
        } else if self.end.is_some() && total != 0.0 {
            // At the second rest the velocity is zero: what is left grew evenly.
            let slope = scaled(&out.left_over, 1.0 / total);
            for k in 0..out.tau.len() {
                let tau = out.tau[k];
                for i in 0..3 {
                    out.velocity[k][i] -= slope[i] * tau;
                    out.position[k][i] -= 0.5 * slope[i] * tau * tau;
                    out.acceleration[k][i] -= slope[i];
                }
            }
        }
    }

    /// Takes off what velocity is left at each stance, and integrates again.
    fn stand(&self, out: &mut Ran) {
        let last = out.tau.len() - 1;
        let mut from = 0;
        let ends = self.end.is_some().then(|| last..last + 1);
        for stance in self.stances.iter().cloned().chain(ends) {
            let to = stance.start.min(last);
            let (v0, v1) = (out.velocity[from], out.velocity[to]);
            let (t0, t) = (out.tau[from], out.tau[to] - out.tau[from]);
            let slope = if t > 0.0 {
                scaled(&sub(&v1, &v0), 1.0 / t)
            } else {
                [0.0; 3]
            };
            for k in from + 1..=to {
                let tau = out.tau[k] - t0;
                for i in 0..3 {
                    out.velocity[k][i] -= v0[i] + slope[i] * tau;
                    out.acceleration[k][i] -= slope[i];
                }
            }
            // The last sample of a stance is where the next step starts.
            let until = stance.end.min(last + 1) - 1;
            for k in to + 1..until {
                out.velocity[k] = [0.0; 3];
                out.acceleration[k] = [0.0; 3];
            }
            from = until.max(to);
        }
        if self.end.is_none() {
            let v0 = out.velocity[from];
            for k in from + 1..=last {
                out.velocity[k] = sub(&out.velocity[k], &v0);
            }
        }
        // Where a step starts the velocity is that of the stance: zero.
        for stance in &self.stances {
            let start = stance.end.min(last + 1) - 1;
            out.velocity[start] = [0.0; 3];
        }
        out.velocity[0] = [0.0; 3];
        for k in 1..=last {
            let half = 0.5 * (out.tau[k] - out.tau[k - 1]);
            for i in 0..3 {
                out.position[k][i] =
                    out.position[k - 1][i] + half * (out.velocity[k - 1][i] + out.velocity[k][i]);
            }
        }
    }
}

/// The rotation that takes the tilt's error off.
struct Upright<'a> {
    smoother: &'a Smoother,
    /// Rotation vector that is missing at the end, rad.
    missing: [f64; 3],
    /// Horizontal velocity that is left there, m/s.
    left: [f64; 2],
    active: bool,
}

impl Upright<'_> {
    /// Its rotation vector, rad.
    #[inline]
    fn vector(&self, tau: f64) -> [f64; 3] {
        if !self.active {
            return [0.0; 3];
        }
        let [of_tilt, of_velocity] = self.smoother.tilt_gain(tau);
        // An error φ of the attitude turns gravity into g (φ_y, −φ_x); what is
        // missing is −φ.
        let x = -of_tilt * self.missing[1] + of_velocity * self.left[0];
        let y = of_tilt * self.missing[0] + of_velocity * self.left[1];
        [y, -x, 0.0]
    }

    /// `v`, turned (Rodrigues).
    #[inline]
    fn apply(&self, tau: f64, v: &[f64; 3]) -> [f64; 3] {
        if !self.active {
            return *v;
        }
        let r = self.vector(tau);
        let squared = r[0] * r[0] + r[1] * r[1];
        // sin φ/φ and (1 − cos φ)/φ²; the series to 1e-11 where it is taken.
        let (sine, versine) = if squared < 0.09 {
            (
                1.0 - squared / 6.0 * (1.0 - squared / 20.0 * (1.0 - squared / 42.0)),
                0.5 - squared / 24.0 * (1.0 - squared / 30.0 * (1.0 - squared / 56.0)),
            )
        } else {
            let angle = squared.sqrt();
            (angle.sin() / angle, (1.0 - angle.cos()) / squared)
        };
        let first = cross(&r, v);
        let second = cross(&r, &first);
        std::array::from_fn(|i| v[i] + sine * first[i] + versine * second[i])
    }
}
