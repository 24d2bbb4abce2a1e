//! What becomes known of a motion as it goes: rests, moves, the end.

use gravical_core::matrix3::{norm, sub};
use gravical_core::motion::Phase;

use crate::motion::result::{Ends, FinalState, Loss, Move, Span};

/// Follows the state from sample to sample.
#[derive(Debug, Clone)]
pub(super) struct MoveTracker {
    before: Phase,
    last_s: f64,
    first_s: f64,
    /// Start of the rest, or of the move, that goes on.
    since_s: f64,
    rests: Vec<Span>,
    moves: Vec<Move>,
    going: Going,
    /// The move before the last rest, should that have been none.
    before_rest: Option<(f64, Going)>,
    /// How many rests were taken back.
    pub taken_back: u32,
    /// When something was taken for a rest although the velocity is not zero, s.
    pub rests_at_speed: Vec<f64>,
    speed: f64,
    velocity: [f64; 3],
    position: [f64; 3],
}

/// The move that goes on.
#[derive(Debug, Clone, Copy)]
struct Going {
    start: [f64; 3],
    ends: Ends,
    peak: f64,
    path: f64,
}

/// A sample and what it came to.
pub(super) struct MotionState {
    pub t_s: f64,
    pub phase: Phase,
    /// At rest.
    pub rests: bool,
    pub velocity: [f64; 3],
    pub position: [f64; 3],
    /// Rests that were taken back so far, and those that are at speed.
    pub taken_back: u32,
    pub overruled: u32,
}

impl MoveTracker {
    pub fn new(start_m: [f64; 3]) -> Self {
        MoveTracker {
            before: Phase::Waiting,
            last_s: f64::NAN,
            first_s: f64::NAN,
            since_s: f64::NAN,
            rests: Vec::new(),
            moves: Vec::new(),
            going: Going {
                start: start_m,
                ends: Ends::Free,
                peak: 0.0,
                path: 0.0,
            },
            before_rest: None,
            taken_back: 0,
            rests_at_speed: Vec::new(),
            speed: f64::NAN,
            velocity: [f64::NAN; 3],
            position: [f64::NAN; 3],
        }
    }

    #[inline]
    pub fn see(&mut self, now: &MotionState) {
        let phase = if now.rests { Phase::Resting } else { now.phase };
        if phase != self.before {
            self.turn(phase, now);
        }
        if phase == Phase::Moving {
            let speed = norm(&now.velocity);
            let h = now.t_s - self.last_s;
            if self.speed.is_finite() && h.is_finite() {
                self.going.path += 0.5 * h * (speed + self.speed);
            }
            self.going.peak = self.going.peak.max(speed);
            self.speed = speed;
        }
        self.last_s = now.t_s;
        self.velocity = now.velocity;
        self.position = now.position;
    }

    #[cold]
    fn turn(&mut self, phase: Phase, now: &MotionState) {
        if self.first_s.is_nan() {
            self.first_s = now.t_s;
        }
        if now.taken_back > self.taken_back {
            self.taken_back = now.taken_back;
            self.take_back();
        }
        match self.before {
            Phase::Resting => self.rests.push(Span {
                start_s: self.since_s,
                end_s: self.last_s,
            }),
            Phase::Moving => {
                // The place is put right where it comes to rest.
                let end = if phase == Phase::Resting {
                    now.position
                } else {
                    self.position
                };
                let ends = match (self.going.ends, phase) {
                    (Ends::FromRest, Phase::Resting) => Ends::RestToRest,
                    (Ends::Free, Phase::Resting) => Ends::ToRest,
                    (ends, _) => ends,
                };
                self.before_rest = Some((self.since_s, self.going));
                self.close(now.t_s, ends, end);
                if now.overruled as usize > self.rests_at_speed.len() {
                    self.rests_at_speed.push(now.t_s);
                    if let Some(last) = self.moves.last_mut() {
                        last.reason = Some(
                            "the velocity at its end is not zero: how far it went may be far off"
                                .to_owned(),
                        );
                    }
                }
            }
            Phase::Waiting | Phase::Start => {}
        }
        if phase == Phase::Moving {
            let from_rest = self.before == Phase::Resting;
            if from_rest {
                self.going.start = self.position;
                self.since_s = self.last_s;
            } else {
                self.since_s = self.first_s;
            }
            self.going = Going {
                ends: Ends::FromRest,
                peak: 0.0,
                path: 0.0,
                ..self.going
            };
            self.speed = if from_rest { 0.0 } else { f64::NAN };
        } else {
            self.since_s = now.t_s;
        }
        self.before = phase;
    }

    /// The last rest was none: the move before it goes on.
    fn take_back(&mut self) {
        let Some((since_s, before)) = self.before_rest.take() else {
            return;
        };
        self.rests.pop();
        self.moves.pop();
        self.since_s = since_s;
        self.going = Going {
            peak: before.peak.max(self.going.peak),
            path: before.path + self.going.path,
            ..before
        };
    }

    fn close(&mut self, end_s: f64, ends: Ends, end: [f64; 3]) {
        let way = sub(&end, &self.going.start);
        let usable = way.iter().all(|v| v.is_finite());
        self.moves.push(Move {
            start_s: self.since_s,
            end_s,
            ends,
            displacement_m: usable.then_some(way),
            sigma_m: None,
            uncalibrated_m: None,
            peak_speed_mps: Some(self.going.peak),
            path_m: Some(self.going.path),
            velocity_error_mps: None,
            levelling_error_deg: None,
            closure_sigmas: None,
            usable,
            reason: (!usable)
                .then(|| "its place is not known since something is missing".to_owned()),
        });
    }

    /// Something is missing between the last sample and the next, `gap_s` later: `missing_s`,
    /// which is zero where nothing tells.
    pub fn lose(&mut self, gap_s: f64, missing_s: f64) {
        let moving = self.before == Phase::Moving;
        if self.before == Phase::Resting {
            self.rests.push(Span {
                start_s: self.since_s,
                end_s: self.last_s,
            });
        }
        let start_s = if moving { self.since_s } else { self.last_s };
        let end_s = self.last_s + gap_s.max(0.0);
        let why = Loss::Gap { seconds: missing_s };
        self.moves.push(Move::lost(start_s, end_s, why));
        self.before = Phase::Waiting;
        self.before_rest = None;
        self.position = [f64::NAN; 3];
        self.velocity = [f64::NAN; 3];
    }

    /// Rests, moves and the end.
    pub fn finish(mut self) -> (Vec<Span>, Vec<Move>, FinalState) {
        match self.before {
            Phase::Resting => self.rests.push(Span {
                start_s: self.since_s,
                end_s: self.last_s,
            }),
            Phase::Moving => self.close(self.last_s, self.going.ends, self.position),
            Phase::Waiting | Phase::Start => {}
        }
        let known = |v: [f64; 3]| v.iter().all(|x| x.is_finite()).then_some(v);
        let end = FinalState {
            position_m: known(self.position),
            sigma_m: None,
            velocity_mps: known(self.velocity),
        };
        (self.rests, self.moves, end)
    }
}
