//! Motion of samples: the whole way, in order. Read this first.

use std::ops::Range;

use gravical_signal::{RestOptions, detect_rests};

use crate::chain::RestSelector;
use crate::closure::{Closure, REST_SPEED_MPS, closure, enlargement};
use crate::filter::{Action, Filter, Record};
use crate::noise::{Density, Noise, tremor};
use crate::result::{Bounds, Budget, Motion, Move, PathNode, RestNoise, array, rows};
use crate::rough::Roughness;
use crate::samples::{MotionOptions, Samples};
use crate::smooth::Smoother;
use crate::stance::detect_stances;
use crate::state::Directions;

/// The first second of a rest closes the move before it, the last 20 s lead into the next: over longer
/// ones biases drift.
const CLOSING_S: f64 = 1.0;
const LEADING_S: f64 = 20.0;
/// Samples of the end of a rest that say something beyond its first second.
const MIN_LEADING: usize = 5;
/// Factor by which a rest may shake more than the others and still have that speed more.
const MAX_SHAKEN: f64 = 5.0;
/// Noise of a causal run is that of the first seconds, s.
const LEARNED_S: f64 = 3.0;
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

/// Velocity and position of calibrated samples.
///
/// 1. Rests: quiet spans ([`detect_rests`]) whose velocity closes, or those that are given.
/// 2. Noise: of the rests, and of what is rough besides.
/// 3. Forwards: strapdown and error-state filter; a rest is zero velocity, levelling, zero rate; a stance
///    zero velocity. A move whose closure fails is gone through again with more noise, the same along all
///    axes.
/// 4. Backwards: the smoother, from checkpoint to checkpoint. Not in a causal run.
///
/// Without a rest there is a [`Motion`] without moves, nor is there one if an option is negative or no number.
#[must_use]
pub fn estimate_motion(samples: &Samples, options: &MotionOptions) -> Motion {
    if !options.are_possible() {
        return Motion::default();
    }
    let found = match &options.rests_s {
        Some(spans) => given_rests(samples, spans),
        None => detect_rests(
            &samples.channels(),
            &RestOptions {
                causal: options.causal,
            },
        ),
    };
    let Some(first) = found.first() else {
        return Motion::default();
    };
    let learned = first.start..first.end.min(samples.after_s(first.start, LEARNED_S));
    let learned = if options.causal {
        std::slice::from_ref(&learned)
    } else {
        &found[..]
    };
    let noise = Noise::new(samples, learned, Roughness::new(samples, &found))
        .with_white(options.noise.as_ref(), samples);
    let directions = Directions::new(&options.calibration);
    let selector = RestSelector {
        samples,
        options,
        directions: &directions,
        noise: &noise,
    };
    let rests = if options.rests_s.is_some() {
        found
    } else if options.causal {
        selector.as_they_come(&found)
    } else {
        selector.chain(&found)
    };
    let Some(first) = rests.first() else {
        return Motion::default();
    };
    let (stances, measured) = if options.zero_velocity {
        let stances = detect_stances(samples, &rests, options.max_stance_rate_rad_s);
        (stances, &rests[..])
    } else {
        (Vec::new(), std::slice::from_ref(first))
    };
    let noise = if options.zero_velocity || options.causal {
        noise.clone()
    } else {
        Noise::new(samples, measured, noise.rough.clone())
            .with_white(options.noise.as_ref(), samples)
    };
    let filter = Filter::new(samples, options, &directions, &noise, 0, first);
    let mut pass = Pass {
        samples,
        options,
        noise: &noise,
        rests: measured,
        stances: &stances,
        plan: Vec::new(),
        nodes: 0,
        checkpoints: Vec::new(),
        moves: Vec::new(),
        path: Vec::new(),
    };
    let end = pass.forward(filter);
    if options.causal {
        pass.path.push(PathNode::forward(&end.node()));
    } else {
        pass.backward(&end);
    }
    let (mut moves, path) = (pass.moves, pass.path);
    moves
        .iter_mut()
        .for_each(|m| m.count_bridged(&samples.bridged));
    Motion {
        moves,
        path,
        noise: Some(RestNoise {
            force_mps2_sqrt_s: array(&noise.rest.force.map(f64::sqrt)),
            rate_rad_sqrt_s: array(&noise.rest.rate.map(f64::sqrt)),
        }),
        stances,
        rests,
    }
}

/// Spans of samples of times, in order, joined where they touch; what holds fewer than two samples is left
/// out.
fn given_rests(samples: &Samples, spans_s: &[(f64, f64)]) -> Vec<Range<usize>> {
    let index = |t_s: f64| samples.time_s.partition_point(|t| *t < t_s);
    let mut spans: Vec<Range<usize>> = spans_s
        .iter()
        .filter(|(from_s, to_s)| from_s.is_finite() && to_s.is_finite())
        .map(|(from_s, to_s)| index(*from_s)..samples.time_s.partition_point(|t| t <= to_s))
        .filter(|span| span.start + 1 < span.end)
        .collect();
    spans.sort_by_key(|span| span.start);
    let mut rests: Vec<Range<usize>> = Vec::new();
    for span in spans {
        match rests.last_mut().filter(|last| last.end >= span.start) {
            Some(last) => last.end = last.end.max(span.end),
            None => rests.push(span),
        }
    }
    rests
}

/// The filter before an action of the plan.
struct Checkpoint<'a> {
    action: usize,
    nodes: usize,
    filter: Filter<'a>,
}

/// Forwards and back.
struct Pass<'a> {
    samples: &'a Samples,
    options: &'a MotionOptions,
    noise: &'a Noise,
    rests: &'a [Range<usize>],
    stances: &'a [usize],
    /// What the forward pass did, and how many nodes it has.
    plan: Vec<Action>,
    nodes: usize,
    checkpoints: Vec<Checkpoint<'a>>,
    moves: Vec<Move>,
    path: Vec<PathNode>,
}

impl<'a> Pass<'a> {
    fn forward(&mut self, mut filter: Filter<'a>) -> Filter<'a> {
        let last = self.samples.len() - 1;
        for k in 0..=self.rests.len() {
            let end = self.rests.get(k).map_or(last, |rest| rest.start);
            let moves = end > filter.at;
            if moves {
                filter = self.estimate_move(filter, k, end);
            }
            if let Some(rest) = self.rests.get(k) {
                let from = end.max(filter.at);
                self.rest(&mut filter, rest, from, k > 0);
            } else if self.options.causal && moves {
                self.take_displacement(&mut filter);
            }
        }
        filter
    }

    fn run(&mut self, filter: &mut Filter<'a>, action: Action) {
        if self.options.causal {
            let mut records = Vec::new();
            filter.run(&action, Some(&mut records));
            let nodes = records.iter().filter_map(|r| match r {
                Record::Node(node) => Some(PathNode::forward(node)),
                _ => None,
            });
            self.path.extend(nodes);
            return;
        }
        if self
            .checkpoints
            .last()
            .is_none_or(|c| self.nodes >= c.nodes + CHECKPOINT_NODES)
        {
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
        filter.run(&action, None);
        self.plan.push(action);
    }

    /// The move to sample `end`, where rest `k` begins if there is one: with more noise where it does not
    /// close.
    fn estimate_move(&mut self, filter: Filter<'a>, k: usize, end: usize) -> Filter<'a> {
        let from = filter.at;
        let seconds = self.samples.time_s[end] - self.samples.time_s[from];
        let closing = if self.options.causal {
            end + self.samples.count_in(CLOSING_S).max(2)
        } else {
            usize::MAX
        };
        let rest = self.rests.get(k).filter(|_| k > 0);
        let rest = rest.map(|r| end..r.end.min(closing));
        let mut excess = self.noise.excess(from, end);
        let mut closed: Option<Closure> = None;
        let (actions, nodes, path) = (self.plan.len(), self.nodes, self.path.len());
        for enlarged in 0..=MAX_ENLARGED {
            let mut trial = filter.clone();
            self.plan.truncate(actions);
            self.checkpoints.retain(|c| c.action < actions);
            self.nodes = nodes;
            self.path.truncate(path);
            self.propagate_move(&mut trial, end, &excess);
            if let Some(rest) = &rest {
                let (found, innovation) = closure(&trial, rest);
                let closed = closed.get_or_insert(found);
                let more = enlargement(&found, &innovation, trial.nominal.gravity, seconds);
                if let Some(more) = more.filter(|_| enlarged < MAX_ENLARGED) {
                    closed.enlarged = true;
                    excess.force += more.force;
                    excess.rate += more.rate;
                    continue;
                }
            }
            self.add_move(from..end, k, closed, &excess);
            return trial;
        }
        filter
    }

    fn propagate_move(&mut self, filter: &mut Filter<'a>, end: usize, excess: &Density) {
        let samples = self.samples;
        let from = filter.at;
        let seconds = samples.time_s[end] - samples.time_s[from];
        let most = ((NODE_S / seconds * (end - from) as f64) as usize).max(1);
        let node = ((end - from) / MIN_NODES).clamp(1, most);
        let number = self.moves.len();
        let inflation = filter.wobble_variance(from..end) * RECTIFIED.powi(2);
        self.run(filter, Action::StartMove(number));
        self.run(filter, Action::InflateRateBias(inflation));
        let first = self.stances.partition_point(|i| *i <= from);
        let stances = self.stances[first..].iter().take_while(|i| **i < end);
        for stance in stances.copied().chain([end]).collect::<Vec<_>>() {
            while filter.at < stance {
                // In parts, so that a checkpoint may stand between them.
                let to = stance.min(filter.at + node * CHECKPOINT_NODES);
                self.run(
                    filter,
                    Action::Propagate {
                        to,
                        node,
                        excess: *excess,
                    },
                );
            }
            if stance < end {
                self.run(filter, Action::Stance);
            }
        }
        self.run(filter, Action::InflateRateBias(inflation));
        self.run(filter, Action::EndMove);
    }

    fn add_move(
        &mut self,
        span: Range<usize>,
        k: usize,
        closure: Option<Closure>,
        excess: &Density,
    ) {
        let samples = self.samples;
        let bounds = match (k > 0, k < self.rests.len()) {
            (true, true) => Bounds::Closed,
            (false, true) => Bounds::OpenStart,
            (true, false) => Bounds::OpenEnd,
            (false, false) => Bounds::Open,
        };
        let until = |i: usize| self.stances.partition_point(|s| *s < i);
        let stances = until(span.end) - until(span.start);
        self.moves.push(Move {
            duration_s: samples.time_s[span.end] - samples.time_s[span.start],
            displacement_m: [0.0; 3],
            covariance_m2: [[0.0; 3]; 3],
            budget: Budget::default(),
            bounds,
            closure,
            stances,
            gap: samples.gaps(&span).next().is_some(),
            unusable: samples.unusable(&span),
            clipped: 0,
            spiked: 0,
            excess_noise: [excess.force.max().sqrt(), excess.rate.max().sqrt()],
            samples: span,
        });
    }

    /// A rest from sample `from` on: its first second as it comes, its last seconds before the next move.
    fn rest(&mut self, filter: &mut Filter<'a>, rest: &Range<usize>, from: usize, closes: bool) {
        let samples = self.samples;
        let closing = samples.count_in(CLOSING_S).max(2);
        let second = (rest.start + closing).min(rest.end).max(from + 1);
        // What shakes more than the rests do may have some speed.
        let shaken = tremor(samples, &(from..second)) / self.noise.rest.force.sum();
        let speed_sd_mps = REST_SPEED_MPS * shaken.sqrt().clamp(1.0, MAX_SHAKEN);
        self.run(
            filter,
            Action::Rest {
                span: from..second,
                speed_sd_mps,
            },
        );
        if closes && self.options.causal {
            self.take_displacement(filter);
        }
        let leave = rest.end.max(filter.at + 1);
        self.run(filter, Action::Halt { to: leave - 1 });
        let since = samples.time_s[leave - 1] - LEADING_S;
        let leading = second.max(samples.time_s.partition_point(|t| *t < since))..leave;
        if leading.len() > MIN_LEADING {
            self.run(
                filter,
                Action::Rest {
                    span: leading,
                    speed_sd_mps: REST_SPEED_MPS,
                },
            );
        }
    }

    /// The displacement of the last move as it is known when a rest has closed it.
    fn take_displacement(&mut self, filter: &mut Filter<'a>) {
        if let Some(one) = self.moves.last_mut() {
            let (displacement, mut covariance) = filter.displacement();
            for c in 0..3 {
                covariance[(c, c)] += (2.0 * self.options.clock_sd * displacement[c]).powi(2);
            }
            one.displacement_m = array(&displacement);
            one.covariance_m2 = rows(&covariance);
        }
    }

    /// Smooths from checkpoint to checkpoint: the filter runs again from each, with its records kept.
    fn backward(&mut self, end: &Filter<'a>) {
        let uncertainty = &self.options.calibration;
        let mut smoother = Smoother::new(uncertainty.gravity_sd_mps2, self.options.clock_sd);
        let mut path = vec![PathNode::forward(&end.node())];
        let mut until = self.plan.len();
        while let Some(Checkpoint {
            action: from,
            mut filter,
            ..
        }) = self.checkpoints.pop()
        {
            let mut records = Vec::new();
            for action in &self.plan[from..until] {
                filter.run(action, Some(&mut records));
            }
            smoother.back(&records, &mut path, &mut self.moves);
            until = from;
        }
        path.reverse();
        self.path = path;
    }
}
