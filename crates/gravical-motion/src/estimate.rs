//! Motion of samples: the whole way, in order. Read this first.

use std::ops::Range;

use gravical_signal::detect_rests;

use crate::chain::RestSelector;
use crate::filter::{Action, Filter};
use crate::moves::{Keep, Leg, Tape, close, closing, level_before_move};
use crate::noise::{Noise, Roughness};
use crate::options::MotionOptions;
use crate::result::{Motion, Move, PathNode, ends};
use crate::samples::Samples;
use crate::smooth::Smoother;
use crate::stance::detect_stances;
use crate::stepper::Stepper;
use crate::transition::Model;

/// Velocity and position of calibrated samples.
///
/// 1. Rests: quiet spans ([`detect_rests`]) whose velocity closes, or those that are given.
/// 2. Noise: of the rests, and of what is rough besides.
/// 3. Forwards: strapdown and error-state filter; a rest is zero velocity, levelling, zero rate; a stance
///    zero velocity. A move whose closure fails is gone through again with more noise, the same along all
///    axes.
/// 4. Backwards: the smoother, from checkpoint to checkpoint.
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
    let noise = |rests: &[Range<usize>]| {
        Noise::new(samples, rests, rough.clone()).with_white(options.noise.as_ref(), samples)
    };
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
    let (stances, measured) = if options.zero_velocity {
        let stances = detect_stances(samples, &rests, options.max_stance_rate_rad_s);
        (stances, &rests[..])
    } else {
        (Vec::new(), std::slice::from_ref(first))
    };
    let first_noise = (!options.zero_velocity).then(|| noise(measured));
    model.noise = first_noise.as_ref().unwrap_or(&found_noise);
    let mut tape = Tape::new(Keep::Plan);
    let (end, mut moves) = forward(&model, &mut tape, measured, &stances);
    let path = backward(&model, tape, &end, &mut moves);
    moves
        .iter_mut()
        .for_each(|m| m.count_bridged(&samples.bridged));
    Motion {
        moves,
        path,
        noise: Some(model.noise.of_rests()),
        stances,
        rests,
    }
}

/// Goes through all rests and moves.
fn forward(
    model: &Model<'_>,
    tape: &mut Tape,
    rests: &[Range<usize>],
    stances: &[usize],
) -> (Filter, Vec<Move>) {
    let samples = model.samples;
    let mut filter = Filter::new(model, 0, &rests[0]);
    let mut moves = Vec::new();
    for k in 0..=rests.len() {
        if model.options.is_stopped() {
            break;
        }
        let rest = rests.get(k);
        let end = rest.map_or(samples.len() - 1, |rest| rest.start);
        if end > filter.at {
            let first = stances.partition_point(|i| *i <= filter.at);
            let leg = Leg {
                number: moves.len(),
                end,
                ends: ends(k > 0, rest.is_some()),
                rest: rest.filter(|_| k > 0).cloned(),
                stances: &stances[first..stances.partition_point(|i| *i < end).max(first)],
            };
            let one;
            (filter, one) = leg.run(model, tape, &filter);
            moves.push(one);
        }
        if let Some(rest) = rest {
            let from = end.max(filter.at);
            let closed = closing(model, rest).end.max(from + 1);
            close(model, tape, &mut filter, from..closed);
            let last = rest.end.max(filter.at + 1) - 1;
            tape.run(model, &mut filter, Action::Halt { to: last });
            level_before_move(model, tape, &mut filter, closed);
        }
    }
    (filter, moves)
}

/// Smooths from checkpoint to checkpoint: the filter runs again from each, with its records kept.
fn backward(model: &Model<'_>, mut tape: Tape, end: &Filter, moves: &mut [Move]) -> Vec<PathNode> {
    let mut smoother = Smoother::new(model.options.calibration.gravity_sd_mps2);
    let mut path = vec![PathNode::forward(&end.node())];
    let mut until = tape.plan.len();
    while let Some(checkpoint) = tape.checkpoints.pop() {
        if model.options.is_stopped() {
            break;
        }
        let (from, mut filter) = (checkpoint.action, checkpoint.filter);
        let mut records = Vec::new();
        for action in &tape.plan[from..until] {
            filter.run(model, action, Some(&mut records));
        }
        smoother.back(&records, &mut path, moves);
        until = from;
    }
    path.reverse();
    path.into_iter().map(PathNode::with_clock).collect()
}
