//! Motion of samples: the whole way, in order. Read this first.

use std::ops::Range;
use std::vec::IntoIter;

use gravical_signal::{detect_rests, detect_rests_causally};

use crate::chain::{chain, contradicts};
use crate::filter::{Filter, Record, Recorder};
use crate::moves::{Leg, closing, pass};
use crate::noise::{Noise, NoiseAtRest};
use crate::options::{Directions, MotionOptions};
use crate::result::{Ends, Motion, Move, PathNode};
use crate::samples::Samples;
use crate::smooth::Smoother;
use crate::stance::{Stance, detect_stances, steps};
use crate::transition::Model;

/// A causal run has the noise of the first seconds of the first rest, s.
const LEARNED_S: f64 = 3.0;
/// … and believes a rest that the velocity contradicts once it has lasted so long, s: what is wrong then is the
/// velocity.
const BELIEVED_S: f64 = 4.0;

/// Velocity and position of calibrated samples.
///
/// 1. Rests: quiet spans ([`detect_rests`]) whose velocity closes, or those that are given.
/// 2. Noise: of the rests, and of what is rough besides.
/// 3. Forwards: strapdown and error-state filter; a rest is zero velocity, levelling, zero rate; a stance
///    zero velocity. A move whose closure fails is gone through again with more noise, the same along all
///    axes.
/// 4. Backwards: the smoother, from rest to rest.
///
/// A causal run ends with the third. Its rests are those of [`detect_rests_causally`], and each is decided
/// where it begins.
///
/// Without a rest there is a [`Motion`] without moves, nor is there one if an option is negative or no number,
/// or rests that are given are not spans of samples in order.
pub fn estimate_motion(samples: &Samples, options: &MotionOptions) -> Motion {
    if !options.are_possible() {
        return Motion::default();
    }
    let found = match &options.rests {
        Some(given) => given.clone(),
        None if options.causal => detect_rests_causally(&samples.channels()),
        None => detect_rests(&samples.channels()),
    };
    let fits = |r: &Range<usize>| r.start < r.end && r.end <= samples.len();
    // Edges of detected ones may overlap; they may be given to another estimate.
    let is_later = |a: &Range<usize>, b: &Range<usize>| a.start < b.start && a.end < b.end;
    let in_order = found.iter().all(fits) && found.is_sorted_by(is_later);
    let are_possible = options.rests.is_none() || in_order;
    let Some(first) = found.first().filter(|_| are_possible) else {
        return Motion::default();
    };
    let learned = first.start..first.end.min(samples.after_s(first.start, LEARNED_S));
    let learned_from = if options.causal {
        std::slice::from_ref(&learned)
    } else {
        &found
    };
    let noise = Noise::new(samples, learned_from, &found);
    let directions = Directions::new(&options.calibration);
    let model = Model {
        samples,
        options,
        directions: &directions,
        noise: &noise,
    };
    let rests = if options.rests.is_some() || options.causal {
        found
    } else {
        chain(&model, &found)
    };
    let Some(first) = rests.first() else {
        return Motion::default();
    };
    // The rest that says what the attitude is.
    let levelled = if options.causal {
        learned
    } else {
        first.clone()
    };
    let course = Course {
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
        ..course.run(Filter::new(model, 0, &levelled), rests.into_iter())
    }
}

/// All rests, each with the move before it; the last move has none.
struct Course<'a> {
    model: Model<'a>,
    stances: Vec<Stance>,
}

/// How a move and the rest after it were gone through, for the way back.
struct Passed<'a> {
    before: Filter<'a>,
    leg: Option<Leg>,
    rest: Option<Range<usize>>,
}

impl Course<'_> {
    /// Forwards, and from rest to rest backwards: the filter goes through each move again, and its records are
    /// kept only until the smoother has gone back through them.
    fn run(&self, mut filter: Filter<'_>, mut rests: IntoIter<Range<usize>>) -> Motion {
        let model = &self.model;
        let causal = model.options.causal;
        let (mut motion, mut passed, mut last_step) = (Motion::default(), Vec::new(), None);
        loop {
            if model.options.is_stopped() {
                return Motion::default();
            }
            let is_first = motion.rests.is_empty();
            let from = if is_first { 0 } else { filter.at + 1 };
            let rest = if causal && !is_first {
                self.next_rest(&filter, &mut rests, last_step)
            } else {
                rests.next()
            };
            let before = filter.clone();
            let mut recorder = Recorder::new(causal);
            let last = model.samples.len() - 1;
            let mut leg = None;
            if rest.as_ref().map_or(last, |rest| rest.start) > filter.at {
                let end = rest.as_ref().map_or(usize::MAX, |rest| rest.start);
                let steps = steps(&self.stances, model.samples, (from, end), last_step);
                last_step = steps.last().map(|s| s.swing).or(last_step);
                let end = end.min(last);
                let mut this = Leg {
                    end,
                    excess: model.noise.excess(filter.at, end),
                    // A causal run knows the first second of it.
                    rest: rest.as_ref().filter(|_| !is_first).map(|rest| {
                        if causal {
                            closing(model, rest)
                        } else {
                            rest.clone()
                        }
                    }),
                    stances: steps.iter().map(|s| s.sample).collect(),
                };
                motion.moves.push(Move {
                    ends: match (is_first, &rest) {
                        (false, Some(_)) => Ends::RestToRest,
                        (true, Some(_)) => Ends::ToRest,
                        (false, None) => Ends::FromRest,
                        (true, None) => Ends::Free,
                    },
                    ..this.run(&mut filter, &mut recorder)
                });
                leg = Some(this);
            }
            let closed = match &rest {
                Some(rest) => pass(&mut filter, rest, &mut recorder),
                None => recorder.records.len(),
            };
            if causal && leg.is_some() {
                let mut smoother = Smoother::new(model.options.calibration.gravity_sd_mps2);
                let records = &recorder.records[..closed];
                smoother.back(records, &mut Vec::new(), motion.moves.last_mut());
            }
            motion.rests.extend(rest.clone());
            let nodes = recorder.records.iter().filter_map(|record| match record {
                Record::Node(node) => Some(PathNode::forward(node)),
                _ => None,
            });
            motion.path.extend(nodes);
            let is_last = rest.is_none();
            if !causal {
                passed.push(Passed { before, leg, rest });
            }
            if is_last {
                break;
            }
        }
        motion.path.push(PathNode::forward(&filter.node()));
        if !causal {
            self.smooth(passed, &mut motion);
        }
        motion
    }

    /// Smooths the moves, and puts the nodes before that at the end.
    fn smooth(&self, passed: Vec<Passed<'_>>, motion: &mut Motion) {
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

    /// The first candidate after the rest that the filter left whose velocity and tilt are those of a rest when it
    /// begins, or that lasts.
    fn next_rest(
        &self,
        filter: &Filter<'_>,
        candidates: &mut IntoIter<Range<usize>>,
        last_step: Option<usize>,
    ) -> Option<Range<usize>> {
        let (model, mut trail) = (&self.model, filter.clone());
        candidates.find(|rest| {
            if rest.start > trail.at {
                let span = (filter.at + 1, rest.start);
                let steps = steps(&self.stances, model.samples, span, last_step);
                let samples = steps.iter().map(|s| s.sample);
                let leg = Leg {
                    end: rest.start,
                    excess: model.noise.excess(trail.at, rest.start),
                    rest: None,
                    stances: samples.filter(|i| *i > trail.at).collect(),
                };
                leg.propagate(&mut trail, &mut Recorder::default());
            }
            model.samples.duration_s(rest) >= BELIEVED_S
                || !contradicts(&trail, &closing(model, rest))
        })
    }
}
