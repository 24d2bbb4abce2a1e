//! Leg after leg: attitude, velocity, position and what they may be off by.

mod close;
mod fly;
mod linear;
mod setup;
mod state;

use std::ops::Range;

use gravical_core::strapdown::level;

use super::anchors::{Anchors, Side};
use super::leg::{Ran, Removal};
use super::plan::Stretch;
use super::result::{Ends, FinalState, Move, PositionBudget};

pub(super) use setup::Setup;
use state::State;

/// The way, sample by sample; NaN where it is not known.
#[derive(Debug, Default)]
pub(super) struct Path {
    pub attitude: Vec<[f64; 4]>,
    pub acceleration: Vec<[f64; 3]>,
    pub velocity: Vec<[f64; 3]>,
    pub position: Vec<[f64; 3]>,
    pub sigma_velocity: Vec<[f64; 3]>,
    pub sigma_position: Vec<[f64; 3]>,
    pub moves: Vec<Move>,
    pub end: Option<FinalState>,
    pub budget: Option<PositionBudget>,
}

impl Setup<'_> {
    /// Follows `plan` from beginning to end.
    pub fn follow(&self, plan: &[Stretch], rests: &[Range<usize>]) -> Path {
        let n = self.samples.len();
        let mut path = Path {
            attitude: vec![[f64::NAN; 4]; n],
            acceleration: vec![[f64::NAN; 3]; n],
            velocity: vec![[f64::NAN; 3]; n],
            position: vec![[f64::NAN; 3]; n],
            sigma_velocity: if self.bands {
                vec![[f64::NAN; 3]; n]
            } else {
                Vec::new()
            },
            sigma_position: if self.bands {
                vec![[f64::NAN; 3]; n]
            } else {
                Vec::new()
            },
            ..Path::default()
        };
        let anchors = Anchors::new(self.samples, self.walk);
        let attitude = match rests.first() {
            Some(_) => level(anchors.at(rests, 0, Side::First).force, 0.0),
            None => level(anchors.whole(0..n).force, 0.0),
        };
        let mut state = State::new(attitude, self.p0, self.directions.len());
        if matches!(self.removal(), Removal::Mean(_)) {
            state.attitude = [1.0, 0.0, 0.0, 0.0];
        }
        let mut scratch = (Ran::default(), Ran::default());
        let mut last_velocity = Some([0.0; 3]);
        for (index, stretch) in plan.iter().enumerate() {
            match stretch {
                Stretch::Rest(k) => {
                    let anchor = anchors.at(rests, *k, Side::First);
                    let leg = self.leg(
                        rests[*k].start,
                        rests[*k].start,
                        anchor,
                        None,
                        state.attitude,
                    );
                    state.attitude = leg.levelled(&anchor.force);
                    self.rest(&rests[*k], &state, &mut path);
                    last_velocity = Some([0.0; 3]);
                }
                Stretch::Leg {
                    from,
                    to,
                    ends,
                    before,
                    after,
                } => {
                    let (near, far, start, end) = match ends {
                        Ends::RestToRest => (*from, *to, *before, *after),
                        Ends::FromRest | Ends::Free => (*from, *to, *before, None),
                        // From the rest back to the beginning.
                        Ends::ToRest => (*to, *from, *after, None),
                    };
                    let anchor = |k: Option<usize>, side| k.map(|k| anchors.at(rests, k, side));
                    let side = if *ends == Ends::ToRest {
                        Side::First
                    } else {
                        Side::Last
                    };
                    let start_anchor = anchor(start, side)
                        .unwrap_or_else(|| anchors.moving(near.min(far)..near.max(far) + 1));
                    let mut leg = self.leg(
                        near,
                        far,
                        start_anchor,
                        anchor(end, Side::First),
                        state.attitude,
                    );
                    if path.moves.is_empty() && matches!(ends, Ends::Free | Ends::FromRest) {
                        leg.v0 = self.v0;
                    }
                    let noise = self.noise(&leg);
                    let moved = self.fly(&leg, *ends, &noise, &mut state, &mut path, &mut scratch);
                    last_velocity = path.velocity.get(*to).copied();
                    path.moves.push(moved);
                }
                Stretch::Lost { from, to, gap_s } => {
                    let t = &self.samples.t_s;
                    path.moves.push(Move::lost(t[*from], t[*to], *gap_s));
                    // Before the first rest nothing is counted yet.
                    state.known &= index == 0 && plan.len() > 1 && !rests.is_empty();
                    last_velocity = None;
                }
                Stretch::QuietGap { .. } => {}
            }
        }
        let known = state.known;
        path.end = Some(FinalState {
            position_m: known.then_some(state.position),
            sigma_m: (known && self.bands)
                .then(|| path.sigma_position.last().copied())
                .flatten(),
            velocity_mps: last_velocity.filter(|v| v.iter().all(|v| v.is_finite())),
        });
        path.budget = (known && self.bands).then(|| self.budget(&state));
        path
    }

    fn rest(&self, span: &Range<usize>, state: &State, path: &mut Path) {
        let sigma = self.bands.then(|| self.sigma(state, &state.position));
        for i in span.clone() {
            path.attitude[i] = state.attitude;
            path.acceleration[i] = [0.0; 3];
            path.velocity[i] = [0.0; 3];
            if state.known {
                path.position[i] = state.position;
            }
            if let Some(sigma) = sigma {
                path.sigma_velocity[i] = [0.0; 3];
                if state.known {
                    path.sigma_position[i] = sigma;
                }
            }
        }
    }
}
