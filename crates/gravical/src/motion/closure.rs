//! What is left at the end of a move between two rests, and what it says of the band.
//!
//! Velocity and tilt at the second rest, before they are set right, are each held against
//! their own standard uncertainty. Where a velocity is improbable, or a tilt beyond 4 σ, the noise was larger than the
//! model has it: along that axis N² gains e_v²/T, and the density q of the tilt φ²/T, so
//! much as the closure shows. In its second moment this is one step, of the velocity or of
//! the tilt, at an unknown moment of the move; what of it the smoother has taken off is
//! taken off in the band, too (`smoother.rs`). A velocity that a step of the
//! tilt explains, between 0 and gφT, is not counted again.
//!
//! Or the velocity came so slowly in one of the rests that nobody saw it: t seconds before
//! the move, or after it, the position lacks e_v (t + T)/2. How likely that is, the force
//! in the rest says. And a tilt that no turn explains may be an acceleration a = g φ all
//! along a rest that is none: a velocity a t comes of it, which the closure's has to allow.
//! Without a gyroscope such a tilt is no proof, and neither is a velocity that a tilt on
//! the way explains; but they are tested as if nothing had tilted, and widen the band
//! likewise.

use std::ops::Range;

use gravical_core::strapdown::{conjugate, rotate};

use super::bands::Unmodelled;
use super::course::Course;
use super::gate::{FAR, STEADY_MPS};
use super::leg::{Closure, Leg, Removal};
use super::setup::Setup;

/// What is further from zero than this, in σ, is improbable: one in a hundred.
const IMPROBABLE: f64 = 2.58;
/// So much of a rest is looked at for what came slowly, s; in so many steps.
const SLOW_S: f64 = 20.0;
const STEPS: usize = 16;
/// … and no more than this share of it: what is left is what it is held against.
const SLOW_SHARE: f64 = 0.75;
/// A rest that is shorter, s, may accelerate however much: it is levelled by itself.
const SHORT_S: f64 = 2.0;
/// Likelihood by which the force in the rests has to speak for a velocity that came there,
/// where it is not improbable by itself.
const EVIDENCE: f64 = 20.0;
/// Logarithm beyond which a likelihood says no more.
const CERTAIN: f64 = 30.0;

/// What a closure says.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tested {
    /// Velocity and tilt over their standard uncertainties, of the axis where that is most.
    velocity: f64,
    tilt: f64,
    /// What the band has to allow for beside the model.
    pub unmodelled: Unmodelled,
}

impl Tested {
    pub fn sigmas(&self) -> f64 {
        self.velocity.max(self.tilt)
    }

    /// What widens the band; none where nothing does.
    pub fn reason(&self) -> Option<String> {
        let beyond = [
            ("velocity", self.velocity, IMPROBABLE),
            ("tilt", self.tilt, FAR),
        ]
        .map(|(what, ratio, limit)| {
            (ratio > limit)
                .then(|| format!("the {what} at its end is {ratio:.1} times its uncertainty"))
        });
        let named: Vec<String> = beyond.into_iter().flatten().collect();
        (!named.is_empty()).then(|| {
            format!(
                "{} from what the rest shows: the band is widened by that",
                named.join(" and ")
            )
        })
    }
}

impl Setup<'_> {
    /// Holds the far end of a course against the rest there; `around` are the rests at its
    /// two ends. None where it is no move from rest to rest, or a walk.
    pub(super) fn hold_against_closure(
        &self,
        course: &Course<'_>,
        around: &[Range<usize>; 2],
    ) -> Option<Tested> {
        let (closure, leg) = (course.closure?, course.leg);
        let seconds = leg.seconds();
        let (open, _) = course.noise.open(seconds);
        let follows = leg.removal.follows();
        // Held against zero as it is, and as if nothing had tilted on the way.
        let deviations = |with_tilt: bool| -> [f64; 3] {
            std::array::from_fn(|i| {
                let tilt = if with_tilt || follows {
                    open.tilt[i]
                } else {
                    0.0
                };
                let variance = open.noise[i]
                    + tilt
                    + course.closure_by_parameters[0][i]
                    + STEADY_MPS * STEADY_MPS;
                variance.sqrt()
            })
        };
        let left = closure.velocity;
        let ratio =
            |sigma: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|i| left[i].abs() / sigma[i]) };
        let untilted = deviations(false);
        let (with_tilt, ratio) = (ratio(&deviations(true)), ratio(&untilted));
        let tilt = self.tilt_ratio(course, &closure);
        let most = |of: &[f64]| of.iter().fold(0.0, |most: f64, one| most.max(*one));
        let mut out = Tested {
            velocity: most(&with_tilt),
            tilt: if follows { most(&tilt) } else { 0.0 },
            unmodelled: Unmodelled::default(),
        };
        if course.steps.is_some() {
            return Some(out);
        }
        let mut hidden = self.came_slowly(leg, &closure, around);
        let improbable = most(&ratio);
        if improbable < 1.0 || improbable < FAR && hidden.weight < EVIDENCE {
            hidden = Slowly::default();
        }
        let least = if hidden.weight > 0.0 { 1.0 } else { IMPROBABLE };
        let gravity = course.noise.open.gravity;
        // An error φ of the attitude turns gravity into g (φ_y, −φ_x); missing is −φ.
        let tilted = [
            (tilt[1], -closure.missing[1]),
            (tilt[0], closure.missing[0]),
            (0.0, 0.0),
        ];
        // Variance of the position at the end where N² = 1.
        let by_noise = course.noise.accel_at_end(leg);
        for i in 0..3 {
            let (sigmas, phi) = tilted[i];
            let acceleration = gravity * phi;
            let mut beside = 0.0;
            if ratio[i] > least {
                beside += hidden.likely() * left[i].powi(2) * hidden.lever();
            }
            if sigmas > FAR {
                let speed = left[i].abs() + FAR * untilted[i];
                beside += self.in_no_rest(around, acceleration.abs(), speed, seconds);
            }
            if by_noise[i] > 0.0 {
                out.unmodelled.accel[i] += beside / by_noise[i];
            }
            let improbable = with_tilt[i] > IMPROBABLE && seconds > 0.0;
            if follows && (improbable || sigmas > FAR) {
                out.unmodelled.tilt[i] = phi * phi;
            }
            if improbable {
                let by_tilt = if follows { acceleration * seconds } else { 0.0 };
                let beyond = left[i] - left[i].clamp(by_tilt.min(0.0), by_tilt.max(0.0));
                out.unmodelled.accel[i] += (1.0 - hidden.likely()) * beyond * beyond / seconds;
            }
        }
        Some(out)
    }

    /// The tilt that is missing, about x and y, over its standard uncertainty; zero where
    /// no gyroscope tells how it turned.
    fn tilt_ratio(&self, course: &Course<'_>, closure: &Closure) -> [f64; 2] {
        let (noise, Some(closing)) = (course.noise, &course.leg.closing) else {
            return [0.0; 2];
        };
        if !matches!(course.leg.removal, Removal::Strapdown | Removal::Tilt) {
            return [0.0; 2];
        }
        let t = noise.total;
        let g2 = noise.open.gravity.powi(2);
        let seen = self.walk.accel_mean() / closing.rest.seconds / g2;
        let walked = noise.open.gyro * t + noise.open.bias * t * t;
        std::array::from_fn(|i| {
            let variance = noise.level_near + seen + walked + course.closure_by_parameters[1][i];
            closure.missing[i].abs() / variance.sqrt()
        })
    }

    /// Square of the way that is missing if `acceleration` went on in the rests, m². A short
    /// one may be any part of the move. A long one, where a second of it hides that much, as
    /// far as the `speed` that the closure allows.
    fn in_no_rest(
        &self,
        around: &[Range<usize>; 2],
        acceleration: f64,
        speed: f64,
        seconds: f64,
    ) -> f64 {
        let (mut short_s, mut long_s) = (0.0, 0.0);
        for rest in around {
            let length_s = self.length_s(rest);
            if length_s < SHORT_S {
                short_s += length_s;
            } else if acceleration < self.hidden.acceleration_mps2() {
                long_s += length_s.min(SLOW_S).min(speed / acceleration);
            }
        }
        let lever = |s: f64, by: f64| if s > 0.0 { by } else { 0.0 };
        let short = lever(short_s, (seconds + short_s).powi(2) / 8.0);
        let long = long_s * (seconds + long_s);
        acceleration.powi(2) * (short * short + long * long / 12.0)
    }

    fn length_s(&self, rest: &Range<usize>) -> f64 {
        self.view.t_s()[rest.end - 1] - self.view.t_s()[rest.start]
    }

    /// What the force in the rests at the ends of a leg says of a velocity that came there
    /// slowly, against one that came in the move.
    fn came_slowly(&self, leg: &Leg<'_>, closure: &Closure, around: &[Range<usize>; 2]) -> Slowly {
        let start = leg.removal.levelled(&leg.attitude, &leg.start.force);
        let mut out = Slowly::default();
        for (rest, attitude, late) in [
            (&around[0], &start, true),
            (&around[1], &closure.attitude, false),
        ] {
            // In the sensor's axes; before the move and after it, it is less the velocity
            // that is left.
            let gained = rotate(&conjugate(attitude), &closure.velocity.map(|v| -v));
            self.add_slowly(rest, late, &gained, leg.seconds(), &mut out);
        }
        out
    }

    /// One rest: constant acceleration in its last seconds, or its first ones.
    fn add_slowly(
        &self,
        rest: &Range<usize>,
        late: bool,
        gained: &[f64; 3],
        seconds: f64,
        out: &mut Slowly,
    ) {
        let t_s = self.view.t_s();
        let from_edge = |k: usize| match late {
            true => rest.end - 1 - k,
            false => rest.start + k,
        };
        let edge = t_s[from_edge(0)];
        let past = |k: usize| (t_s[from_edge(k)] - edge).abs();
        let most = SLOW_S.min(SLOW_SHARE * self.length_s(rest));
        if most <= 0.0 {
            return;
        }
        let origin = self.view.force_at(from_edge(0));
        let mut sums = Vec::new();
        let mut sum = [0.0; 3];
        let mut k = 0;
        let mut add_until = |until: f64, sum: &mut [f64; 3]| {
            while k < rest.len() && past(k) <= until {
                let force = self.view.force_at(from_edge(k));
                (0..3).for_each(|i| sum[i] += force[i] - origin[i]);
                k += 1;
            }
            k as f64
        };
        for step in 0..STEPS {
            let slow_s = most * (step as f64 + 0.5) / STEPS as f64;
            let count = add_until(slow_s, &mut sum);
            sums.push((slow_s, count, sum));
        }
        let whole_s = (2.0 * SLOW_S).min(self.length_s(rest));
        let count = add_until(whole_s, &mut sum);
        for (slow_s, n, part) in sums {
            let left = count - n;
            if n < 1.0 || left < 1.0 {
                continue;
            }
            let variance = self.walk.accel_mean() * (1.0 / slow_s + 1.0 / (whole_s - slow_s));
            let log: f64 = (0..3)
                .map(|i| {
                    let differs = part[i] / n - (sum[i] - part[i]) / left;
                    let predicted = gained[i] / slow_s;
                    predicted * (differs - 0.5 * predicted) / variance
                })
                .sum();
            let weight = log.clamp(-CERTAIN, CERTAIN).exp() / STEPS as f64;
            out.weight += weight;
            out.lever += weight * (0.5 * (slow_s + seconds)).powi(2);
        }
    }
}

/// A velocity that came in the rests: its likelihood against one that came in the move, and
/// the square of the time that it moved the position by, s².
#[derive(Debug, Clone, Copy, Default)]
struct Slowly {
    weight: f64,
    lever: f64,
}

impl Slowly {
    fn likely(&self) -> f64 {
        self.weight / (1.0 + self.weight)
    }

    fn lever(&self) -> f64 {
        if self.weight > 0.0 {
            self.lever / self.weight
        } else {
            0.0
        }
    }
}
