//! Leg after leg: attitude, velocity, position and what they may be off by.

use std::ops::Range;

use gravical_core::matrix3::{norm, sub};
use gravical_core::strapdown::level;

use super::anchors::{Anchors, Side};
use super::bands::{Unmodelled, Variances};
use super::closure::Tested;
use super::course::{Carried, Course};
use super::leg::{Columns, Leg, Removal};
use super::parameters::Kind;
use super::plan::Stretch;
use super::result::{Ends, FinalState, Move, PositionBudget};
use super::setup::Setup;

/// What is known of a sample; NaN where it is not.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known {
    pub attitude: [f64; 4],
    pub acceleration: [f64; 3],
    pub velocity: [f64; 3],
    pub position: [f64; 3],
    pub sigma_velocity: [f64; 3],
    pub sigma_position: [f64; 3],
}

impl Known {
    const NOTHING: Known = Known {
        attitude: [f64::NAN; 4],
        acceleration: [f64::NAN; 3],
        velocity: [f64::NAN; 3],
        position: [f64::NAN; 3],
        sigma_velocity: [f64::NAN; 3],
        sigma_position: [f64::NAN; 3],
    };
}

/// Where the samples go, each once and in order.
pub(super) type Sink<'s> = &'s mut dyn FnMut(usize, &Known);

/// Gives samples on to a sink. A rest and a leg share a sample: the later one counts.
struct Emitter<'s> {
    sink: Option<Sink<'s>>,
    held: Option<(usize, Known)>,
    next: usize,
}

impl Emitter<'_> {
    fn put(&mut self, i: usize, known: Known) {
        if let Some((held, before)) = self.held.replace((i, known))
            && held != i
        {
            self.give(held, &before);
        }
    }

    /// All samples up to `i` of which nothing is known, and that one.
    fn give(&mut self, i: usize, known: &Known) {
        if let Some(sink) = &mut self.sink {
            (self.next..i).for_each(|k| sink(k, &Known::NOTHING));
            sink(i, known);
        }
        self.next = i + 1;
    }

    fn finish(&mut self, count: usize) {
        if let Some((held, known)) = self.held.take() {
            self.give(held, &known);
        }
        if self.next < count {
            self.give(count - 1, &Known::NOTHING);
        }
    }
}

/// The moves, and what they come to.
#[derive(Debug)]
pub(super) struct Path {
    pub moves: Vec<Move>,
    pub end: FinalState,
    pub budget: Option<PositionBudget>,
}

/// Where the sensor is after the legs so far, and how far that may be off.
struct State {
    attitude: [f64; 4],
    position: [f64; 3],
    /// False after a move that cannot be known.
    known: bool,
    /// No stretch of the recording is a move.
    unmoved: bool,
    /// Of the last sample; none where it is not known.
    velocity: Option<[f64; 3]>,
    /// Of the position of the last sample.
    sigma: [f64; 3],
    noise: [f64; 3],
    tilt: [f64; 3],
    carried: Carried,
    yaw: Yaw,
}

/// Errors of yaw: each that a leg adds turns all that comes after it about the
/// place where it arose.
#[derive(Clone, Copy, Default)]
struct Yaw {
    variance: f64,
    first: [f64; 2],
    second: [f64; 2],
}

impl Yaw {
    fn add(&mut self, variance: f64, at: &[f64; 3]) {
        self.variance += variance;
        for i in 0..2 {
            self.first[i] += variance * at[i];
            self.second[i] += variance * at[i] * at[i];
        }
    }

    /// Σ σ² (p − p_k)², x by the distance in y and the other way round.
    fn at(&self, p: &[f64; 3]) -> [f64; 3] {
        let off = |i: usize| {
            (self.variance * p[i] * p[i] - 2.0 * self.first[i] * p[i] + self.second[i]).max(0.0)
        };
        [off(1), off(0), 0.0]
    }
}

impl Setup<'_> {
    /// Follows `plan` from beginning to end; every sample goes to `sink`, where there
    /// is one.
    pub(super) fn follow(
        &self,
        plan: &[Stretch],
        rests: &[Range<usize>],
        sink: Option<Sink<'_>>,
    ) -> Path {
        let count = self.view.samples.len();
        let anchors = Anchors::new(self.view, self.walk);
        let first = match rests.first() {
            Some(_) => anchors.at(rests, 0, Side::First),
            None => anchors.whole(0..count),
        };
        let unit = [1.0, 0.0, 0.0, 0.0];
        let mut state = State {
            attitude: match self.removal() {
                Removal::Mean(_) => unit,
                _ => level(first.force, 0.0),
            },
            position: self.p0,
            known: true,
            unmoved: plan
                .iter()
                .all(|s| matches!(s, Stretch::Rest(_) | Stretch::QuietGap { .. })),
            velocity: Some([0.0; 3]),
            sigma: [0.0; 3],
            noise: [0.0; 3],
            tilt: [0.0; 3],
            carried: Carried {
                offsets: vec![[0.0; 3]; self.directions.len()],
                yaw_offsets: vec![0.0; self.directions.len()],
            },
            yaw: Yaw::default(),
        };
        let mut out = Emitter {
            sink,
            held: None,
            next: 0,
        };
        let mut moves: Vec<Move> = Vec::new();
        for (index, stretch) in plan.iter().enumerate() {
            if self.is_stopped() {
                break;
            }
            match stretch {
                Stretch::Rest(k) => {
                    let force = anchors.at(rests, *k, Side::First).force;
                    state.attitude = self.removal().levelled(&state.attitude, &force);
                    self.rest(&rests[*k], &mut state, &mut out);
                }
                Stretch::Leg {
                    from,
                    to,
                    ends,
                    before,
                    after,
                } => {
                    let (near, far, start, side) = match ends {
                        // From the rest back to the beginning.
                        Ends::ToRest => (*to, *from, *after, Side::First),
                        _ => (*from, *to, *before, Side::Last),
                    };
                    let start = match start {
                        Some(k) => anchors.at(rests, k, side),
                        None => anchors.moving(*from..*to + 1),
                    };
                    let end = after
                        .filter(|_| *ends == Ends::RestToRest)
                        .map(|k| anchors.at(rests, k, Side::First));
                    let mut leg = self.leg(near, far, start, end, state.attitude);
                    if moves.is_empty() && matches!(ends, Ends::Free | Ends::FromRest) {
                        leg.v0 = self.v0;
                    }
                    let around = before.zip(*after).filter(|_| leg.closing.is_some());
                    let around = around.map(|(a, b)| [rests[a].clone(), rests[b].clone()]);
                    moves.push(self.along(&leg, *ends, around, &mut state, &mut out));
                }
                Stretch::Lost { from, to, why } => {
                    let t = self.view.t_s();
                    moves.push(Move::lost(t[*from], t[*to], *why));
                    // Before the first rest nothing is counted yet.
                    state.known &= index == 0 && plan.len() > 1 && !rests.is_empty();
                    state.velocity = None;
                }
                Stretch::QuietGap { .. } => {}
            }
        }
        out.finish(count);
        Path {
            moves,
            end: FinalState {
                position_m: state.known.then_some(state.position),
                sigma_m: (state.known && self.bands).then_some(state.sigma),
                velocity_mps: state.velocity.filter(|v| v.iter().all(|v| v.is_finite())),
            },
            budget: (state.known && self.bands).then(|| self.budget(&state)),
        }
    }

    fn rest(&self, span: &Range<usize>, state: &mut State, out: &mut Emitter<'_>) {
        state.velocity = Some([0.0; 3]);
        let nothing = Variances::default();
        let by_parameters = state.carried.offsets.iter().fold([0.0; 3], |sum, o| {
            std::array::from_fn(|i| sum[i] + o[i] * o[i])
        });
        if state.unmoved {
            state.noise = [0.0; 3];
        }
        state.sigma = self.sigma_position(state, &nothing, &by_parameters, &state.position);
        let place = |known: bool, value: [f64; 3]| if known { value } else { [f64::NAN; 3] };
        let t_s = self.view.t_s();
        let before = state.sigma;
        // Where nothing is seen to move, what is hidden is all that there may be.
        let hidden = |i: usize| match state.unmoved && self.bands {
            true => self.hidden.sigma_m(t_s[i] - t_s[0]).powi(2),
            false => 0.0,
        };
        let sigma_at = |i: usize| before.map(|s| (s * s + hidden(i)).sqrt());
        let mut known = Known {
            attitude: state.attitude,
            acceleration: [0.0; 3],
            velocity: [0.0; 3],
            position: place(state.known, state.position),
            sigma_velocity: [0.0; 3],
            sigma_position: place(state.known, before),
        };
        if out.sink.is_some() {
            for i in span.clone() {
                known.sigma_position = place(state.known, sigma_at(i));
                out.put(i, known);
            }
        }
        let last = span.end - 1;
        if state.unmoved {
            state.noise = [hidden(last); 3];
            state.sigma = sigma_at(last);
        }
    }

    /// Goes along one leg, gives its samples on, and takes the state to its end.
    fn along(
        &self,
        leg: &Leg<'_>,
        ends: Ends,
        around: Option<[Range<usize>; 2]>,
        state: &mut State,
        out: &mut Emitter<'_>,
    ) -> Move {
        let noise = self.noise(leg);
        let mut course = Course::new(self, leg, &noise);
        let mut moved = Moved::default();
        let mut tested: Option<Tested> = None;
        while course.done < leg.len() {
            let from = course.done;
            course.advance(&state.carried, out.sink.is_some());
            if let Some(around) = around.as_ref().filter(|_| self.bands) {
                tested = self.hold_against_closure(&course, around);
                course.unmodelled = tested.map_or_else(Unmodelled::default, |t| t.unmodelled);
            }
            moved.add(&course.columns);
            if out.sink.is_some() {
                let n = course.done - from;
                for j in 0..n {
                    let k = if leg.is_backwards() { n - 1 - j } else { j };
                    out.put(leg.sample(from + k), self.known(&course, state, k));
                }
            }
            if self.is_stopped() {
                break;
            }
        }
        let end = course.end();
        let way = course.position(end);
        state.sigma = self.known(&course, state, end).sigma_position;
        state.velocity = Some(course.columns.velocity[end]);
        let sigma_m = self.bands.then(|| {
            let (_, at_end) = self.variances(&course, end);
            let own = course.off.iter().fold([0.0; 3], |sum, (way, _)| {
                std::array::from_fn(|i| sum[i] + way[i] * way[i])
            });
            let aside = [way[1], way[0], 0.0];
            let sigma = std::array::from_fn(|i| {
                let clock = 2.0 * self.clock_error * way[i];
                let yaw = state.yaw.variance * aside[i] * aside[i];
                (at_end.noise[i] + at_end.tilt[i] + own[i] + clock * clock + yaw).sqrt()
            });
            for i in 0..3 {
                state.noise[i] += at_end.noise[i];
                state.tilt[i] += at_end.tilt[i];
            }
            sigma
        });
        for (k, (way, heading)) in course.off.iter().enumerate() {
            (0..3).for_each(|i| state.carried.offsets[k][i] += way[i]);
            state.carried.yaw_offsets[k] += heading;
        }
        state.position = std::array::from_fn(|i| state.position[i] + way[i]);
        // The heading is that of the first rest: what ran backwards from it turns
        // nothing that comes after.
        if !leg.is_backwards() {
            state.attitude = course.attitude();
            let yaw = noise.open.gyro * noise.total + noise.open.bias * noise.total.powi(2);
            state.yaw.add(yaw, &state.position);
        }
        let closure = course.closure.filter(|_| leg.closing.is_some());
        let closure_sigmas = tested.map(|t| t.sigmas());
        let t_s = self.view.t_s();
        Move {
            start_s: t_s[leg.near.min(leg.far)],
            end_s: t_s[leg.near.max(leg.far)],
            ends,
            displacement_m: Some(way),
            sigma_m,
            uncalibrated_m: None,
            peak_speed_mps: Some(moved.peak_mps),
            path_m: Some(moved.path_m),
            velocity_error_mps: closure.map(|c| c.left_over),
            levelling_error_deg: closure.map(|c| norm(&c.missing).to_degrees()),
            closure_sigmas,
            usable: true,
            reason: tested.and_then(|t| t.reason()),
        }
    }

    /// What is known at place `k` of what a leg has come to.
    fn known(&self, course: &Course<'_>, state: &State, k: usize) -> Known {
        let columns = &course.columns;
        let velocity = columns.velocity[k];
        let way = course.position(k);
        let here: [f64; 3] = std::array::from_fn(|i| state.position[i] + way[i]);
        let mut known = Known {
            attitude: columns.attitude.get(k).copied().unwrap_or([f64::NAN; 4]),
            acceleration: columns.acceleration[k],
            velocity,
            ..Known::NOTHING
        };
        if state.known {
            known.position = here;
        }
        if self.bands {
            let (v, p) = self.variances(course, k);
            known.sigma_velocity = std::array::from_fn(|i| {
                let clock = self.clock_error * velocity[i];
                (v.noise[i] + v.tilt[i] + course.by_velocity[k][i] + clock * clock).sqrt()
            });
            if state.known {
                known.sigma_position =
                    self.sigma_position(state, &p, &course.by_position[k], &here);
            }
        }
        known
    }

    /// Standard uncertainty of the position `here`: what the legs before have left, noise
    /// and tilt of this one, what the parameters make of all of them, the clock.
    fn sigma_position(
        &self,
        state: &State,
        own: &Variances,
        by_parameters: &[f64; 3],
        here: &[f64; 3],
    ) -> [f64; 3] {
        let yaw = state.yaw.at(here);
        std::array::from_fn(|i| {
            let clock = 2.0 * self.clock_error * (here[i] - self.p0[i]);
            let before = state.noise[i] + state.tilt[i] + yaw[i];
            (before + own.noise[i] + own.tilt[i] + by_parameters[i] + clock * clock).sqrt()
        })
    }

    /// Variances of velocity and position at place `k` by noise and tilt of the leg.
    pub(super) fn variances(&self, course: &Course<'_>, k: usize) -> (Variances, Variances) {
        let (leg, noise) = (course.leg, course.noise);
        let tau = course.columns.tau[k].abs();
        let (mut v, mut p) = match (&course.steps, &leg.closing) {
            (Some(steps), _) => steps.at(k, noise),
            (None, Some(closing)) => noise.between(&closing.smoother, tau, &course.unmodelled),
            (None, None) if leg.is_backwards() => (noise.open(tau).0, noise.way_open(tau)),
            (None, None) if matches!(leg.removal, Removal::Mean(_)) && leg.near == 0 => {
                noise.after_mean(tau)
            }
            (None, None) => noise.open(tau),
        };
        let way = course.position(k);
        if leg.closing.is_none() && matches!(leg.removal, Removal::Tilt) {
            // Nothing tells motion from tilt: neither a gyroscope nor a velocity at its end.
            let velocity = course.columns.velocity[k];
            for i in 0..3 {
                v.tilt[i] += velocity[i] * velocity[i];
                p.tilt[i] += way[i] * way[i];
            }
        }
        // What a tilt that the levelling missed turns up and down, and what the yaw of
        // the leg itself turns sideways.
        let level = noise.level_near;
        let yaw = (noise.open.gyro * tau + noise.open.bias * tau * tau) / 3.0;
        p.tilt[0] += level * way[2] * way[2] + yaw * way[1] * way[1];
        p.tilt[1] += level * way[2] * way[2] + yaw * way[0] * way[0];
        p.tilt[2] += level * (way[0] * way[0] + way[1] * way[1]);
        (v, p)
    }

    fn budget(&self, state: &State) -> PositionBudget {
        let root = |v: [f64; 3]| v.iter().sum::<f64>().sqrt();
        let of = |kind: Kind| -> f64 {
            self.directions
                .iter()
                .zip(&state.carried.offsets)
                .filter(|(d, _)| d.kind == kind)
                .map(|(_, o)| o.iter().map(|v| v * v).sum::<f64>())
                .sum::<f64>()
        };
        let yaw = state.yaw.at(&state.position);
        PositionBudget {
            noise: root(state.noise),
            bias: of(Kind::Bias).sqrt(),
            scale: of(Kind::Scale).sqrt(),
            clock: 2.0 * self.clock_error * norm(&sub(&state.position, &self.p0)),
            tilt: (state.tilt.iter().chain(&yaw).sum::<f64>() + of(Kind::Gyro)).sqrt(),
        }
    }
}

/// Highest speed and length of a path.
#[derive(Default)]
struct Moved {
    peak_mps: f64,
    path_m: f64,
    /// Time and speed of the sample before.
    before: Option<(f64, f64)>,
}

impl Moved {
    fn add(&mut self, columns: &Columns) {
        for (tau, velocity) in columns.tau.iter().zip(&columns.velocity) {
            let speed = norm(velocity);
            if let Some((t, s)) = self.before.replace((*tau, speed)) {
                self.path_m += 0.5 * (s + speed) * (tau - t).abs();
            }
            self.peak_mps = self.peak_mps.max(speed);
        }
    }
}
