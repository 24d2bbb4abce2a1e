//! One leg: from a rest to the next, from a rest to the end, from the start to a
//! rest, or the whole of a recording without rest.
//!
//! [`Forward`] levels at the rest and propagates from there. What the second rest
//! tells of the samples before it ([`Leg::close`]): the tilt that is missing is spread
//! over the leg, and the velocity that is left is taken off.

use std::ops::Range;

use gravical_core::integrate::Trapezoid;
use gravical_core::matrix3::{add, norm, scaled, sub};
use gravical_core::motion::Propagator;
use gravical_core::strapdown::{from_rotation_vector, levelling_error, quat_mul, rotate};

use super::parameters::Direction;
use super::samples::View;
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

impl Removal {
    /// The attitude is followed.
    pub fn follows(&self) -> bool {
        matches!(self, Removal::Strapdown)
    }

    /// `attitude`, levelled by the force at a rest.
    pub fn levelled(&self, attitude: &[f64; 4], force: &[f64; 3]) -> [f64; 4] {
        match self {
            Removal::Mean(_) => [1.0, 0.0, 0.0, 0.0],
            _ => quat_mul(
                &from_rotation_vector(&levelling_error(attitude, force)),
                attitude,
            ),
        }
    }
}

/// A leg: samples `near` to `far`, both included. The rest that it starts from
/// lies before `near`; `near` > `far` runs backwards in time.
#[derive(Debug, Clone)]
pub(super) struct Leg<'a> {
    pub view: View<'a>,
    pub near: usize,
    pub far: usize,
    /// The rest at `near`.
    pub start: Anchor,
    /// The rest at `far`.
    pub closing: Option<Closing>,
    /// Attitude at `near` as far as it is known; the rest levels it.
    pub attitude: [f64; 4],
    pub removal: Removal,
    /// Stances between the rests, counted from `near`; velocity is zero in them.
    pub stances: Vec<Range<usize>>,
    /// Velocity at `near`, m/s: zero after a rest.
    pub v0: [f64; 3],
}

/// The rest that ends a leg, and how it is used.
#[derive(Debug, Clone)]
pub(super) struct Closing {
    /// What it says.
    pub rest: Anchor,
    /// What it says of the tilt along the leg.
    pub smoother: Smoother,
    /// How much of the change of the magnitude between the rests is believed, 0
    /// to 1.
    pub magnitude_gain: f64,
}

/// Samples of a leg in the order that it takes them. Kept from run to run to save the
/// allocations.
#[derive(Debug, Clone, Default)]
pub(super) struct Columns {
    /// Time since `near`, s; negative when it ran backwards.
    pub tau: Vec<f64>,
    /// Attitude, where asked for.
    pub attitude: Vec<[f64; 4]>,
    /// Acceleration in the frame, m/s².
    pub acceleration: Vec<[f64; 3]>,
    pub velocity: Vec<[f64; 3]>,
    pub position: Vec<[f64; 3]>,
}

/// What is left at the end of a leg.
#[derive(Debug, Clone, Copy)]
pub(super) struct Closure {
    /// Velocity at `far` as it was integrated, m/s.
    pub velocity: [f64; 3],
    /// What is left of it once the tilt is put right, before it was taken off, m/s.
    pub left_over: [f64; 3],
    /// Rotation vector in the frame that was missing at `far`, rad.
    pub missing: [f64; 3],
    /// Attitude at `far`.
    pub attitude: [f64; 4],
}

impl Leg<'_> {
    /// Duration, s.
    pub fn seconds(&self) -> f64 {
        self.total().abs()
    }

    /// From `near` to `far`, s; negative when it runs backwards.
    fn total(&self) -> f64 {
        let t = self.view.t_s();
        t[self.far] - t[self.near]
    }

    /// How far along the leg a time is, 0 to 1.
    fn share(&self, tau: f64) -> f64 {
        let total = self.total();
        if total == 0.0 { 1.0 } else { tau / total }
    }

    /// It goes back in time, from a rest to what came before.
    pub fn is_backwards(&self) -> bool {
        self.near > self.far
    }

    /// It has to be there as a whole: something tells of the samples before it, or its
    /// far end is where positions count from.
    pub fn is_corrected(&self) -> bool {
        self.closing.is_some() || !self.stances.is_empty() || self.is_backwards()
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.near.abs_diff(self.far) + 1
    }

    /// The sample at place `k`.
    #[inline]
    pub fn sample(&self, k: usize) -> usize {
        if self.near <= self.far {
            self.near + k
        } else {
            self.near - k
        }
    }

    /// What the second rest and the stances tell of the samples before them, once
    /// `forward` has gone all the way and left its samples in `columns`.
    pub fn close(&self, forward: &Forward<'_>, columns: &mut Columns) -> Closure {
        let mut out = Closure {
            velocity: forward.propagator.velocity(),
            left_over: forward.propagator.velocity(),
            missing: [0.0; 3],
            attitude: forward.propagator.attitude(),
        };
        let mean = matches!(self.removal, Removal::Mean(_));
        if let Some(closing) = self.closing.as_ref().filter(|_| !mean) {
            let end = forward.force(&closing.rest.force);
            if matches!(self.removal, Removal::Strapdown | Removal::Tilt) {
                out.missing = levelling_error(&out.attitude, &end);
            }
            let upright = Upright {
                smoother: &closing.smoother,
                missing: out.missing,
                left: [out.left_over[0], out.left_over[1]],
            };
            let g = forward.propagator.gravity()[2];
            let more = closing.magnitude_gain * (norm(&end) - g);
            let mut integral = Trapezoid::new(self.v0, [0.0; 3]);
            let mut before = 0.0;
            for (k, a) in columns.acceleration.iter_mut().enumerate() {
                let tau = columns.tau[k];
                let turned = rotate(&upright.rotation(tau), &[a[0], a[1], a[2] + g]);
                *a = [turned[0], turned[1], turned[2] - g - self.share(tau) * more];
                integral.update(*a, tau - before);
                before = tau;
                columns.velocity[k] = integral.velocity();
                columns.position[k] = integral.position();
            }
            for (q, tau) in columns.attitude.iter_mut().zip(&columns.tau) {
                *q = quat_mul(&upright.rotation(*tau), q);
            }
            out.attitude = quat_mul(&upright.rotation(self.total()), &out.attitude);
            out.left_over = integral.velocity();
        }
        if !self.stances.is_empty() {
            self.stand(columns);
        } else if self.closing.is_some() && self.total() != 0.0 {
            // At the second rest the velocity is zero: what is left grew evenly.
            let slope = scaled(&out.left_over, 1.0 / self.total());
            for (k, &tau) in columns.tau.iter().enumerate() {
                for i in 0..3 {
                    columns.velocity[k][i] -= slope[i] * tau;
                    columns.position[k][i] -= 0.5 * slope[i] * tau * tau;
                    columns.acceleration[k][i] -= slope[i];
                }
            }
        }
        out
    }

    /// Takes off what velocity is left at each stance, and integrates again.
    fn stand(&self, out: &mut Columns) {
        let last = out.tau.len() - 1;
        let mut from = 0;
        let ends = self.closing.is_some().then(|| last..last + 1);
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
        if self.closing.is_none() {
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

/// The forward pass along a leg, its parameters changed by a direction.
#[derive(Debug, Clone)]
pub(super) struct Forward<'a> {
    leg: &'a Leg<'a>,
    change: Direction,
    pub propagator: Propagator<f64>,
    /// Bias of the gyroscope at `near`, and how much more of it there is at `far`.
    bias: [f64; 3],
    drift: [f64; 3],
    before_s: f64,
    /// Places that it has gone.
    done: usize,
}

impl<'a> Forward<'a> {
    /// Before the first sample of `leg`.
    pub fn new(leg: &'a Leg<'a>, change: Direction) -> Self {
        let force_of = |f: &[f64; 3]| add(f, &change.force(f));
        let rate_of = |w: &[f64; 3]| add(w, &change.rate(w));
        let start = force_of(&leg.start.force);
        let bias = rate_of(&leg.start.bias);
        let end = leg.closing.as_ref();
        let gravity = match &leg.removal {
            Removal::Mean(mean) => force_of(mean),
            _ => [0.0, 0.0, norm(&start)],
        };
        let attitude = leg.removal.levelled(&leg.attitude, &start);
        let mut propagator = Propagator::new(attitude, leg.removal.follows(), gravity);
        propagator.set_velocity_position(leg.v0, [0.0; 3]);
        Forward {
            leg,
            change,
            propagator,
            bias,
            drift: end.map_or([0.0; 3], |e| sub(&rate_of(&e.rest.bias), &bias)),
            before_s: leg.view.t_s()[leg.near],
            done: 0,
        }
    }

    /// A specific force with the change.
    fn force(&self, f: &[f64; 3]) -> [f64; 3] {
        add(f, &self.change.force(f))
    }

    /// Takes the next sample; its time since `near`, s.
    #[inline]
    pub fn advance(&mut self) -> f64 {
        let leg = self.leg;
        let i = leg.sample(self.done);
        let t_s = leg.view.t_s();
        let tau = t_s[i] - t_s[leg.near];
        let rate = if leg.removal.follows() {
            let w = leg.view.rate_at(i);
            let s = leg.share(tau);
            let more = self.change.rate(&w);
            std::array::from_fn(|c| w[c] + more[c] - (self.bias[c] + s * self.drift[c]))
        } else {
            [0.0; 3]
        };
        let force = self.force(&leg.view.force_at(i));
        self.propagator.update(force, rate, t_s[i] - self.before_s);
        self.before_s = t_s[i];
        self.done += 1;
        tau
    }

    /// Takes samples until it has gone `count` of them.
    pub fn advance_to(&mut self, count: usize) {
        while self.done < count {
            self.advance();
        }
    }

    /// Takes the next `count` samples into `out`, in place of what is there.
    pub fn run(&mut self, count: usize, with_attitude: bool, out: &mut Columns) {
        out.tau.clear();
        out.attitude.clear();
        out.acceleration.clear();
        out.velocity.clear();
        out.position.clear();
        for _ in 0..count {
            let tau = self.advance();
            out.tau.push(tau);
            if with_attitude {
                out.attitude.push(self.propagator.attitude());
            }
            out.acceleration.push(self.propagator.acceleration());
            out.velocity.push(self.propagator.velocity());
            out.position.push(self.propagator.position());
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
}

impl Upright<'_> {
    #[inline]
    fn rotation(&self, tau: f64) -> [f64; 4] {
        let [of_tilt, of_velocity] = self.smoother.tilt_gain(tau);
        // An error φ of the attitude turns gravity into g (φ_y, −φ_x); what is
        // missing is −φ.
        let x = -of_tilt * self.missing[1] + of_velocity * self.left[0];
        let y = of_tilt * self.missing[0] + of_velocity * self.left[1];
        from_rotation_vector(&[y, -x, 0.0])
    }
}
