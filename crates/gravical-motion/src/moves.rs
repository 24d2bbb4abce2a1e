//! Moves and rests, forwards: what the filter goes through, in order.

use std::ops::Range;

use nalgebra::Vector3;

use crate::closure::{Closure, MAX_STEP_CHI2, REST_SPEED_MPS, enlargement};
use crate::filter::{Filter, GAINED_SPEED_MPS, LEVELLED_S, Record, Recorder};
use crate::noise::{Density, tremor};
use crate::result::Move;
use crate::state::RATE_BIAS;
use crate::transition::Model;
use crate::unusable::{Unusable, turned_unseen, unusable};

/// The first second of a rest closes the move before it, the last 20 s lead into the next: over longer
/// ones biases drift.
const CLOSING_S: f64 = 1.0;
const LEADING_S: f64 = 20.0;
/// Samples of the end of a rest that say something beyond its first second.
const MIN_LEADING: usize = 5;
/// Factor by which a rest may shake more than the others and still have that speed more.
const MAX_SHAKEN: f64 = 5.0;
/// Nodes are at most so far apart, s, and a move has at least so many where its samples allow; of a move
/// above an hour there are as many as of an hour, whose records take 270 MB.
const NODE_S: f64 = 0.1;
const MIN_NODES: usize = 50;
const MAX_NODES: usize = 36_000;
/// Times that a move whose closure fails is enlarged: by the tilt and by the velocity.
const MAX_ENLARGED: usize = 2;
/// What of the rate of turns to and fro, times the error of the scale, stays as a constant rate. Simulated
/// moves do not need it; without it a real walk closes to 1.8 m in place of 0.3 m, and a bout of 30 s of a
/// hand to 3.6 m in place of 1.1 m.
const RECTIFIED: f64 = 0.2;
/// For how long the error of a gyroscope's scale stays the same in a walk, s: a foot that strikes turns faster than
/// samples resolve. Without it a real walk closes to 0.7 m in place of 0.3 m.
const STRIKE_S: f64 = 0.1;
/// What the velocity of a move gains between two levellings at least, m/s: a hand.
const MIN_GAINED_MPS: f64 = 1.0;

/// The first second of a rest.
fn zero_velocity_window(model: &Model<'_>, rest: &Range<usize>) -> Range<usize> {
    let count = model.samples.count_in(CLOSING_S).max(2);
    rest.start..rest.start.saturating_add(count).min(rest.end)
}

/// A move and what is known of it.
pub(crate) struct MoveSegment {
    /// Its last sample.
    pub end: usize,
    /// Noise that it has beyond that of the rests.
    pub added_noise: Density,
    /// The rest that it has to close with.
    pub rest: Option<Range<usize>>,
    pub stances: Vec<usize>,
    /// Standard deviation of what its velocity gains between two levellings, m/s.
    pub gained_sd_mps: f64,
}

impl MoveSegment {
    /// Goes through the move, with more noise where it does not close; returns it but for its displacement and
    /// ends.
    pub fn run(&mut self, filter: &mut Filter<'_>) -> Move {
        let (span, samples) = (filter.at..self.end, filter.model.samples);
        let seconds = samples.time_s[span.end] - samples.time_s[span.start];
        let mut closed: Option<Closure> = None;
        let before = filter.clone();
        // First with what a car gains, to see what this move does.
        if samples.after_s(span.start, LEVELLED_S) < self.end {
            self.propagate(filter, &mut Recorder::default());
            self.gained_sd_mps = filter.gained_mps.clamp(MIN_GAINED_MPS, GAINED_SPEED_MPS);
            *filter = before.clone();
        }
        for enlarged in 0.. {
            self.propagate(filter, &mut Recorder::default());
            let Some(rest) = &self.rest else { break };
            let innovation = filter.rest_innovation(rest, REST_SPEED_MPS);
            let closed = closed.get_or_insert_with(|| Closure {
                velocity_chi2: innovation.chi2::<3>(0, 0.0),
                tilt_chi2: innovation.chi2::<2>(3, 0.0),
                widened: false,
            });
            let more = enlargement(&innovation, filter.nominal.gravity, seconds);
            let Some(more) = more.filter(|_| enlarged < MAX_ENLARGED) else {
                break;
            };
            closed.widened = true;
            self.added_noise.force += more.force;
            self.added_noise.rate += more.rate;
            *filter = before.clone();
        }
        let up = before.nominal.attitude.transpose() * Vector3::z() * before.nominal.gravity;
        let is_unseen = turned_unseen(samples, &span, &up, self.rest.as_ref());
        let interpolated = samples.interpolated.iter();
        let within = interpolated.filter(|b| b.rows.start < span.end && b.rows.end > span.start);
        Move {
            closure: closed,
            stances: self.stances.len(),
            unusable: unusable(samples, &span).or(is_unseen.then_some(Unusable::Unseen)),
            replaced: within.count(),
            samples: span,
            ..Move::default()
        }
    }

    /// Goes through the move with that noise.
    pub fn propagate(&self, filter: &mut Filter<'_>, recorder: &mut Recorder) {
        let model = filter.model;
        let samples = model.samples;
        let (from, end) = (filter.at, self.end);
        let seconds = samples.time_s[end] - samples.time_s[from];
        let most = ((NODE_S / seconds * (end - from) as f64) as usize).max(1);
        let node = ((end - from) / MIN_NODES).clamp(1, most);
        let node = node.max((end - from) / MAX_NODES);
        let rectified_sd = model.directions.rate_sd * RECTIFIED;
        let mean_square_rate = filter.mean_square_rate(from..end);
        let inflation = mean_square_rate * rectified_sd.powi(2);
        let mut added_noise = self.added_noise;
        if !self.stances.is_empty() {
            let strikes = mean_square_rate * model.directions.rate_sd.powi(2) * STRIKE_S;
            added_noise.rate.add_scalar_mut(strikes);
        }
        let added_noise = &added_noise;
        recorder.push(|| Record::StartMove(filter.nominal.position, Box::new(filter.covariance)));
        filter.inflate_covariance(RATE_BIAS, inflation);
        filter.start_move(self.gained_sd_mps);
        for &stance in &self.stances {
            let (before, mark) = (filter.clone(), recorder.records.len());
            let start = before.nominal.position;
            filter.propagate_levelled(stance, node, added_noise, recorder);
            let seconds = samples.time_s[stance] - samples.time_s[before.at];
            let mut innovation = filter.stance_innovation(&start);
            if let Some(more) = innovation.force_density(MAX_STEP_CHI2, seconds) {
                recorder.records.truncate(mark);
                *filter = before;
                let force = added_noise.force + more.force;
                let added_noise = Density {
                    force,
                    ..*added_noise
                };
                filter.propagate_levelled(stance, node, &added_noise, recorder);
                innovation = filter.stance_innovation(&start);
            }
            filter.update(&innovation, recorder);
        }
        filter.propagate_levelled(end, node, added_noise, recorder);
        filter.inflate_covariance(RATE_BIAS, inflation);
        recorder.push(|| Record::EndMove(filter.nominal.position, Box::new(filter.covariance)));
    }
}

/// Goes through a rest: closes the move before it with what its first second says, and levels before the next move
/// with what its last seconds say.
pub(crate) fn pass(filter: &mut Filter<'_>, rest: &Range<usize>, recorder: &mut Recorder) {
    let model = filter.model;
    let from = rest.start.max(filter.at);
    let zero_velocity_window = from..zero_velocity_window(&model, rest).end.max(from + 1);
    // What shakes more than the rests do may have some speed.
    let usual = model.noise.rest.force.sum();
    let shaken = tremor(model.samples, &zero_velocity_window).unwrap_or(usual) / usual;
    let speed_sd_mps = REST_SPEED_MPS * shaken.sqrt().clamp(1.0, MAX_SHAKEN);
    filter.rest(&zero_velocity_window, speed_sd_mps, recorder);
    filter.apply_zero_velocity(rest.end.max(filter.at + 1) - 1, recorder);
    let (time_s, last) = (&model.samples.time_s, filter.at);
    let since = time_s.partition_point(|t| *t < time_s[last] - LEADING_S);
    let leading = zero_velocity_window.end.max(since)..last + 1;
    if leading.len() > MIN_LEADING {
        filter.rest(&leading, REST_SPEED_MPS, recorder);
    }
}
