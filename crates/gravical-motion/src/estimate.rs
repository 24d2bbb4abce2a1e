//! Motion of samples: the whole way, in order. Read this first.

use std::ops::Range;

use gravical_signal::{RestTolerance, detect_rests};

use crate::chain::chain;
use crate::filter::{Filter, GAINED_SPEED_MPS, Recorder};
use crate::moves::{MoveSegment, pass};
use crate::noise::{Noise, NoiseAtRest};
use crate::options::{Directions, MotionOptions};
use crate::result::{Ends, Motion, Move, PathNode};
use crate::smooth::Smoother;
use crate::stance::{Stance, detect_stances, steps};
use crate::transition::Model;
use gravical_signal::Samples;

/// Velocity and position of calibrated samples.
///
/// 1. Rests: spans in which force and rate are constant ([`detect_rests`]) that agree with the filter; where nothing
///    is constant, quiet spans, as of a hand; or those that are given.
/// 2. Noise: of the rests, and of what is rough besides.
/// 3. Forwards: strapdown and error-state filter; a rest is zero velocity, levelling, zero rate; a stance
///    zero velocity; every 10 s the mean force of a move levels, the better the less its velocity gains. A move whose
///    closure fails is gone through again with more noise, the same along all axes.
/// 4. Backwards: the smoother, from rest to rest.
///
/// Without a rest there is a [`Motion`] without moves, nor is there one if an option is negative or no number,
/// or rests that are given are not spans of samples in order.
pub fn estimate_motion(samples: &Samples, options: &MotionOptions) -> Motion {
    if !options.are_possible() {
        return Motion::default();
    }
    let found = match &options.rests {
        Some(given) => given.clone(),
        None => {
            let found = detect_rests(samples, RestTolerance::CONSTANT);
            // How a hand wanders that holds the sensor is noise of the rest.
            if found.is_empty() {
                detect_rests(samples, RestTolerance::UNLIMITED)
            } else {
                found
            }
        }
    };
    let fits = |r: &Range<usize>| r.start < r.end && r.end <= samples.len();
    let is_later = |a: &Range<usize>, b: &Range<usize>| a.start < b.start && a.end < b.end;
    let in_order = found.iter().all(fits) && found.is_sorted_by(is_later);
    let are_possible = options.rests.is_none() || in_order;
    if found.is_empty() || !are_possible {
        return Motion::default();
    }
    let noise = Noise::new(samples, &found);
    let directions = Directions::new(&options.calibration);
    let model = Model {
        samples,
        options,
        directions: &directions,
        noise: &noise,
    };
    let rests = if options.rests.is_some() {
        found
    } else {
        chain(&model, &found)
    };
    // The rest that says what the attitude is.
    let Some(levelled) = rests.first().cloned() else {
        return Motion::default();
    };
    let estimator = Estimator {
        model,
        stances: if options.no_stances {
            Vec::new()
        } else {
            detect_stances(samples, &levelled)
        },
    };
    let has_gyro = samples.has_gyro();
    Motion {
        noise: Some(NoiseAtRest {
            accel_n: noise.rest.force.map(f64::sqrt).into(),
            gyro_n: has_gyro.then(|| noise.rest.rate.map(f64::sqrt).into()),
        }),
        ..estimator.run(Filter::new(model, 0, &levelled), rests)
    }
}

/// All rests, each with the move before it; the last move has none.
struct Estimator<'a> {
    model: Model<'a>,
    stances: Vec<Stance>,
}

/// How a move and the rest after it were gone through, for the way back.
struct ForwardPass<'a> {
    before: Filter<'a>,
    leg: Option<MoveSegment>,
    rest: Option<Range<usize>>,
}

impl Estimator<'_> {
    /// Forwards, and from rest to rest backwards: the filter goes through each move again, and its records are
    /// kept only until the smoother has gone back through them.
    fn run(&self, mut filter: Filter<'_>, rests: Vec<Range<usize>>) -> Motion {
        let (model, off) = (&self.model, &mut Recorder::default());
        let (mut motion, mut passed, mut last_step) = (Motion::default(), Vec::new(), None);
        let last = model.samples.len() - 1;
        for rest in rests.into_iter().map(Some).chain([None]) {
            if model.options.is_stopped() {
                return Motion::default();
            }
            let is_first = motion.rests.is_empty();
            let from = if is_first { 0 } else { filter.at + 1 };
            let before = filter.clone();
            let mut leg = None;
            if rest.as_ref().map_or(last, |rest| rest.start) > filter.at {
                let end = rest.as_ref().map_or(usize::MAX, |rest| rest.start);
                let steps = steps(&self.stances, model.samples, (from, end), last_step);
                last_step = steps.last().map(|s| s.swing).or(last_step);
                let end = end.min(last);
                let mut this = MoveSegment {
                    end,
                    added_noise: model.noise.added_noise(filter.at, end),
                    rest: rest.clone().filter(|_| !is_first),
                    gained_sd_mps: GAINED_SPEED_MPS,
                    stances: steps.iter().map(|s| s.sample).collect(),
                };
                motion.moves.push(Move {
                    ends: match (is_first, &rest) {
                        (false, Some(_)) => Ends::RestToRest,
                        (true, Some(_)) => Ends::ToRest,
                        (false, None) => Ends::FromRest,
                        (true, None) => Ends::Free,
                    },
                    ..this.run(&mut filter)
                });
                leg = Some(this);
            }
            if let Some(rest) = &rest {
                pass(&mut filter, rest, off);
            }
            motion.rests.extend(rest.clone());
            passed.push(ForwardPass { before, leg, rest });
        }
        motion.path.push(PathNode::forward(&filter.node()));
        self.smooth(passed, &mut motion);
        motion
    }

    /// Smooths the moves, and puts the nodes before that at the end.
    fn smooth(&self, passed: Vec<ForwardPass<'_>>, motion: &mut Motion) {
        let model = &self.model;
        let mut smoother = Smoother::new(model.options.calibration.gravity_sd_mps2);
        let mut moves = motion.moves.iter_mut().rev();
        for one in passed.into_iter().rev() {
            if model.options.is_stopped() {
                break;
            }
            let (mut filter, mut recorder) = (one.before, Recorder::new(true));
            let mut smoothed = None;
            if let Some(leg) = &one.leg {
                leg.propagate(&mut filter, &mut recorder);
                smoothed = moves.next();
            }
            if let Some(rest) = &one.rest {
                pass(&mut filter, rest, &mut recorder);
            }
            smoother.back(&recorder.records, &mut motion.path, smoothed);
        }
        motion.path.reverse();
    }
}
