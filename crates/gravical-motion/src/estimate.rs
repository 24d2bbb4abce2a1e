//! Motion of samples: the whole way, in order. Read this first.

use std::ops::Range;

use gravical_signal::detect_rests;

use crate::chain::RestSelector;
use crate::filter::{Filter, Recorder};
use crate::moves::{Leg, close, closing, level_before_move};
use crate::noise::{Density, Noise, Roughness};
use crate::options::MotionOptions;
use crate::result::{Motion, PathNode, ends};
use crate::samples::Samples;
use crate::smooth::Smoother;
use crate::stance::{Stance, StanceDetector, steps};
use crate::stepper::Stepper;
use crate::transition::Model;

/// Velocity and position of calibrated samples.
///
/// 1. Rests: quiet spans ([`detect_rests`]) whose velocity closes, or those that are given.
/// 2. Noise: of the rests, and of what is rough besides.
/// 3. Forwards: strapdown and error-state filter; a rest is zero velocity, levelling, zero rate; a stance
///    zero velocity. A move whose closure fails is gone through again with more noise, the same along all
///    axes.
/// 4. Backwards: the smoother, from rest to rest.
///
/// A causal run is that of a [`Stepper`] instead.
///
/// Without a rest there is a [`Motion`] without moves, nor is there one if an option is negative or no number,
/// or rests that are given are not spans of samples in order.
#[must_use]
pub fn estimate_motion(samples: &Samples, options: &MotionOptions) -> Motion {
    if !options.are_possible() {
        return Motion::default();
    }
    if options.causal {
        return Stepper::drive(samples, options);
    }
    let given = options.rests.clone();
    let found = given.unwrap_or_else(|| detect_rests(&samples.channels()));
    let fits = |r: &Range<usize>| r.start < r.end && r.end <= samples.len();
    let in_order = found.iter().all(fits) && found.is_sorted_by(|a, b| a.end <= b.start);
    if options.rests.is_some() && !in_order {
        return Motion::default();
    }
    let mut rough = Roughness::default();
    rough.extend(samples, &found);
    let noise =
        |rests: &[Range<usize>]| Noise::new(samples, rests, options.noise.as_ref(), rough.clone());
    let found_noise = noise(&found);
    let mut model = Model {
        samples,
        options,
        noise: &found_noise,
    };
    let rests = if options.rests.is_some() {
        found
    } else {
        RestSelector(model).chain(&found)
    };
    let Some(first) = rests.first() else {
        return Motion::default();
    };
    let measured = if options.zero_velocity {
        &rests[..]
    } else {
        std::slice::from_ref(first)
    };
    let first_noise = (!options.zero_velocity).then(|| noise(measured));
    model.noise = first_noise.as_ref().unwrap_or(&found_noise);
    let mut detector = StanceDetector::new(samples, first, options.max_stance_rate_rad_s);
    let mut stances = detector.update(samples);
    stances.extend(detector.quietest);
    stances.retain(|_| options.zero_velocity);
    let course = Course {
        model,
        rests: measured,
        stances,
        size: detector.size,
    };
    let motion = course.run();
    Motion {
        noise: Some(model.noise.of_rests()),
        rests,
        ..motion
    }
}

/// All rests, each with the move before it; the last move has none.
struct Course<'a> {
    model: Model<'a>,
    rests: &'a [Range<usize>],
    stances: Vec<Stance>,
    /// Samples that stances are away from rests.
    size: usize,
}

/// How a move and the rest after it were gone through, for the way back.
struct Passed {
    before: Filter,
    stances: Vec<usize>,
    /// None without a move.
    excess: Option<Density>,
}

impl Course<'_> {
    /// Forwards, and from rest to rest backwards: the filter goes through each move again, and its records are
    /// kept only until the smoother has gone back through them.
    fn run(&self) -> Motion {
        let model = &self.model;
        let mut filter = Filter::new(model, 0, &self.rests[0]);
        let (mut passed, mut moves, mut last_step) = (Vec::new(), Vec::new(), None);
        for k in 0..=self.rests.len() {
            if model.options.is_stopped() {
                break;
            }
            let from = if k == 0 { 0 } else { filter.at + 1 };
            let end = self.rests.get(k).map_or(usize::MAX, |rest| rest.start);
            let steps = steps(&self.stances, self.size, (from, end), last_step);
            last_step = steps.last().map(|s| s.swing).or(last_step);
            let stances: Vec<usize> = steps.iter().map(|s| s.sample).collect();
            let before = filter.clone();
            let excess = self.leg(k, filter.at, &stances).map(|leg| {
                let (excess, one) = leg.run(model, &mut filter, &mut Recorder::off());
                moves.push(one);
                excess
            });
            self.rest(k, &mut filter, &mut Recorder::off());
            passed.push(Passed {
                before,
                stances,
                excess,
            });
        }
        let stances = passed.iter().flat_map(|p| &p.stances).copied().collect();
        let mut smoother = Smoother::new(model.options.calibration.gravity_sd_mps2);
        let mut path = vec![PathNode::forward(&filter.node())];
        let mut unsmoothed = moves.iter_mut().rev();
        for (k, one) in passed.into_iter().enumerate().rev() {
            if model.options.is_stopped() {
                break;
            }
            let (mut filter, mut recorder) = (one.before, Recorder::on());
            let mut smoothed = None;
            let leg = self.leg(k, filter.at, &one.stances);
            if let (Some(leg), Some(excess)) = (leg, one.excess) {
                leg.propagate(model, &mut filter, &excess, &mut recorder);
                smoothed = unsmoothed.next();
            }
            self.rest(k, &mut filter, &mut recorder);
            smoother.back(&recorder.records, &mut path, smoothed);
        }
        path.reverse();
        Motion {
            moves,
            stances,
            path: path.into_iter().map(PathNode::with_clock).collect(),
            ..Motion::default()
        }
    }

    /// The move from sample `from` to rest `k`, or to the end; none where there is none.
    fn leg<'a>(&self, k: usize, from: usize, stances: &'a [usize]) -> Option<Leg<'a>> {
        let rest = self.rests.get(k);
        let end = rest.map_or(self.model.samples.len() - 1, |rest| rest.start);
        (end > from).then(|| Leg {
            end,
            ends: ends(k > 0, rest.is_some()),
            rest: rest.filter(|_| k > 0).cloned(),
            stances,
        })
    }

    /// Goes through rest `k`; nothing after the last one.
    fn rest(&self, k: usize, filter: &mut Filter, recorder: &mut Recorder) {
        let (model, Some(rest)) = (&self.model, self.rests.get(k)) else {
            return;
        };
        let from = rest.start.max(filter.at);
        let closed = closing(model, rest).end.max(from + 1);
        close(model, filter, &(from..closed), recorder);
        let last = rest.end.max(filter.at + 1) - 1;
        filter.halt(model, last, recorder);
        level_before_move(model, filter, closed, recorder);
    }
}
