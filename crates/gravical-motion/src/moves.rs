//! Moves and rests, forwards: what the filter goes through, in order.

use std::ops::Range;

use crate::closure::{Closure, Innovation, REST_SPEED_MPS, enlargement, step_enlargement};
use crate::filter::{Action, Filter, Record};
use crate::noise::{Density, tremor};
use crate::result::{Budget, CLOCK_SD, Ends, Move, PathNode, array, rows};
use crate::transition::Model;

/// The first second of a rest closes the move before it, the last 20 s lead into the next: over longer
/// ones biases drift.
const CLOSING_S: f64 = 1.0;
pub(crate) const LEADING_S: f64 = 20.0;
/// Samples of the end of a rest that say something beyond its first second.
const MIN_LEADING: usize = 5;
/// Factor by which a rest may shake more than the others and still have that speed more.
const MAX_SHAKEN: f64 = 5.0;
/// Nodes are at most so far apart, s, and a move has at least so many where its samples allow.
const NODE_S: f64 = 0.1;
const MIN_NODES: usize = 50;
/// Times that a move whose closure fails is enlarged: by the tilt and by the velocity.
const MAX_ENLARGED: usize = 2;
/// What of the rate of turns to and fro, times the error of the scale, stays as a constant rate. Simulated
/// moves do not need it; without it a real walk closes to 1.8 m in place of 0.3 m, and a bout of 30 s of a
/// hand to 3.6 m in place of 1.1 m.
const RECTIFIED: f64 = 0.2;
/// Nodes from one checkpoint to the next: what the smoother holds at once, 6 kB each.
const CHECKPOINT_NODES: usize = 1_000;

/// What a forward pass keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Keep {
    Nothing,
    /// Nodes as the filter knows them.
    Path,
    /// What the smoother goes back through.
    Plan,
}

/// The filter before an action of the plan.
#[derive(Debug, Clone)]
pub(crate) struct Checkpoint {
    pub action: usize,
    nodes: usize,
    pub filter: Filter,
}

/// What a forward pass did.
#[derive(Debug, Clone)]
pub(crate) struct Tape {
    keep: Keep,
    pub path: Vec<PathNode>,
    pub plan: Vec<Action>,
    /// Nodes of the plan.
    nodes: usize,
    pub checkpoints: Vec<Checkpoint>,
}

impl Tape {
    pub fn new(keep: Keep) -> Tape {
        Tape {
            keep,
            path: Vec::new(),
            plan: Vec::new(),
            nodes: 0,
            checkpoints: Vec::new(),
        }
    }

    pub fn run(&mut self, model: &Model<'_>, filter: &mut Filter, action: Action) {
        match self.keep {
            Keep::Nothing => filter.run(model, &action, None),
            Keep::Path => {
                let mut records = Vec::new();
                filter.run(model, &action, Some(&mut records));
                let nodes = records.iter().filter_map(|r| match r {
                    Record::Node(node) => Some(PathNode::forward(node)),
                    _ => None,
                });
                self.path.extend(nodes);
            }
            Keep::Plan => {
                let last = self.checkpoints.last();
                if last.is_none_or(|c| self.nodes >= c.nodes + CHECKPOINT_NODES) {
                    self.checkpoints.push(Checkpoint {
                        action: self.plan.len(),
                        nodes: self.nodes,
                        filter: filter.clone(),
                    });
                }
                self.nodes += match &action {
                    Action::Propagate { to, node, .. } => (to - filter.at).div_ceil(*node),
                    _ => 1,
                };
                filter.run(model, &action, None);
                self.plan.push(action);
            }
        }
    }

    /// Lengths of the plan, its nodes and the path.
    fn mark(&self) -> [usize; 3] {
        [self.plan.len(), self.nodes, self.path.len()]
    }

    fn rewind(&mut self, [actions, nodes, path]: [usize; 3]) {
        self.plan.truncate(actions);
        self.checkpoints.retain(|c| c.action < actions);
        self.nodes = nodes;
        self.path.truncate(path);
    }
}

/// The first second of a rest.
pub(crate) fn closing(model: &Model<'_>, rest: &Range<usize>) -> Range<usize> {
    let count = model.samples.count_in(CLOSING_S).max(2);
    rest.start..rest.start.saturating_add(count).min(rest.end)
}

/// Variance that the turns of a span leave of the bias of the gyroscope, (rad/s)².
pub(crate) fn rectified(mean_square: f64, rate_sd: f64) -> f64 {
    mean_square * (rate_sd * RECTIFIED).powi(2)
}

/// A move and what is known of it.
pub(crate) struct Leg<'a> {
    /// Its number, and its last sample.
    pub number: usize,
    pub end: usize,
    pub ends: Ends,
    /// The part of the rest that it has to close with.
    pub rest: Option<Range<usize>>,
    pub stances: &'a [usize],
}

impl Leg<'_> {
    /// Goes through the move, with more noise where it does not close.
    pub fn run(&self, model: &Model<'_>, tape: &mut Tape, filter: &Filter) -> (Filter, Move) {
        let span = filter.at..self.end;
        let seconds = model.samples.time_s[span.end] - model.samples.time_s[span.start];
        let mut excess = model.noise.excess(span.start, span.end);
        let mut closed: Option<Closure> = None;
        let (mark, mut enlarged) = (tape.mark(), 0);
        loop {
            let mut trial = filter.clone();
            tape.rewind(mark);
            self.propagate(model, tape, &mut trial, &excess);
            let more = self.rest.as_ref().and_then(|rest| {
                let innovation = Innovation::of_rest(model, &trial, rest);
                closed.get_or_insert_with(|| innovation.closure());
                enlargement(&innovation, trial.nominal.gravity, seconds)
            });
            match (more, &mut closed) {
                (Some(more), Some(closed)) if enlarged < MAX_ENLARGED => {
                    enlarged += 1;
                    closed.widened = true;
                    excess.force += more.force;
                    excess.rate += more.rate;
                }
                _ => return (trial, self.result(model, span, closed)),
            }
        }
    }

    fn propagate(&self, model: &Model<'_>, tape: &mut Tape, filter: &mut Filter, excess: &Density) {
        let samples = model.samples;
        let (from, end) = (filter.at, self.end);
        let seconds = samples.time_s[end] - samples.time_s[from];
        let most = ((NODE_S / seconds * (end - from) as f64) as usize).max(1);
        let node = ((end - from) / MIN_NODES).clamp(1, most);
        let mean_square = filter.mean_square_rate(model, from..end);
        let inflation = rectified(mean_square, model.options.calibration.rate_sd());
        tape.run(model, filter, Action::StartMove(self.number));
        tape.run(model, filter, Action::InflateRateBias(inflation));
        let advance = |tape: &mut Tape, filter: &mut Filter, stance: usize, excess: Density| {
            while filter.at < stance {
                // In parts, so that a checkpoint may stand between them.
                let to = stance.min(filter.at + node * CHECKPOINT_NODES);
                tape.run(model, filter, Action::Propagate { to, node, excess });
            }
        };
        for &stance in self.stances {
            let (mark, before) = (tape.mark(), filter.clone());
            advance(tape, filter, stance, *excess);
            let seconds = samples.time_s[stance] - samples.time_s[before.at];
            if let Some(more) = step_enlargement(filter, seconds) {
                tape.rewind(mark);
                *filter = before;
                let force = excess.force + more.force;
                advance(tape, filter, stance, Density { force, ..*excess });
            }
            tape.run(model, filter, Action::Stance);
        }
        advance(tape, filter, end, *excess);
        tape.run(model, filter, Action::InflateRateBias(inflation));
        tape.run(model, filter, Action::EndMove);
    }

    /// What is known of the move without its displacement.
    pub fn result(&self, model: &Model<'_>, span: Range<usize>, closure: Option<Closure>) -> Move {
        let samples = model.samples;
        Move {
            duration_s: samples.time_s[span.end] - samples.time_s[span.start],
            displacement_m: [0.0; 3],
            covariance_m2: [[0.0; 3]; 3],
            budget: Budget::default(),
            ends: self.ends,
            closure,
            stances: self.stances.len(),
            unusable: samples.unusable(&span),
            replaced: 0,
            samples: span,
        }
    }
}

/// The displacement of a move as the filter knows it, which is at its end or in the rest after it.
pub(crate) fn take_displacement(filter: &mut Filter, one: &mut Move) {
    let (displacement, mut covariance) = filter.displacement();
    for c in 0..3 {
        covariance[(c, c)] += (2.0 * CLOCK_SD * displacement[c]).powi(2);
    }
    one.displacement_m = array(&displacement);
    one.covariance_m2 = rows(&covariance);
}

/// Closes a move with what `span`, the first second of a rest, says.
pub(crate) fn close(model: &Model<'_>, tape: &mut Tape, filter: &mut Filter, span: Range<usize>) {
    // What shakes more than the rests do may have some speed.
    let usual = model.noise.rest.force.sum();
    let shaken = tremor(model.samples, &span).unwrap_or(usual) / usual;
    let speed_sd_mps = REST_SPEED_MPS * shaken.sqrt().clamp(1.0, MAX_SHAKEN);
    tape.run(model, filter, Action::Rest { span, speed_sd_mps });
}

/// What the last seconds of a rest before the next move say, from sample `closed` to that of the filter.
pub(crate) fn level_before_move(
    model: &Model<'_>,
    tape: &mut Tape,
    filter: &mut Filter,
    closed: usize,
) {
    let (time_s, last) = (&model.samples.time_s, filter.at);
    let since = time_s.partition_point(|t| *t < time_s[last] - LEADING_S);
    let span = closed.max(since)..last + 1;
    if span.len() > MIN_LEADING {
        let action = Action::Rest {
            span,
            speed_sd_mps: REST_SPEED_MPS,
        };
        tape.run(model, filter, action);
    }
}
