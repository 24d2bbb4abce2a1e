//! Moves of which nobody knows how far they went.

use std::ops::Range;

use gravical_signal::{BLOCK_S, Samples, block_len, blocks};
use nalgebra::Vector3;

/// A hand moves by a few decimetres in so long, s: what it did in a longer gap is not known.
const MAX_MISSING_S: f64 = 0.5;
/// Standard deviation of the angle that a clipped gyroscope may have missed in a move, rad: 4°. Bands of
/// simulated turns of 1 s hold where the range is 0.4 of the highest rate, whatever the angle. Where it is
/// 0.24 they are too narrow by half; from 0.5 rad on that is 5° and more.
const MAX_MISSED_TURN_RAD: f64 = 0.07;
/// Without a gyroscope a rest that is tilted by more than this, rad, from the one before shows a turn: six times what the
/// band of such a move allows for …
const MAX_TILT_RAD: f64 = 0.05;
/// … and so does a specific force in the move that is tilted by more than this, rad, and as long as gravity, to m/s²: an
/// acceleration that tilts it by 30° makes it longer by 1.5 m/s².
const MAX_MOVING_TILT_RAD: f64 = 0.52;
const AS_GRAVITY_MPS2: f64 = 0.5;

/// Why nobody knows how far a move went: its deviations do not hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unusable {
    /// More than half a second is missing.
    Gap {
        /// The longest gap, less a period, s.
        missing_s: f64,
    },
    /// It was interrupted for an unknown time ([`Samples::with_breaks`]).
    Interrupted,
    /// The gyroscope was clipped, and the turn that it missed has a standard deviation above 4°: bands may
    /// be too narrow by half. They hold smaller ones.
    Turn,
    /// It turned, and there is no gyroscope.
    Unseen,
}

/// Whether so much is missing in a span that nobody knows how far the sensor went.
pub(crate) fn unusable(samples: &Samples, span: &Range<usize>) -> Option<Unusable> {
    if samples.gaps(span).any(|(_, interrupted)| interrupted) {
        return Some(Unusable::Interrupted);
    }
    let gaps = samples.gaps(span).map(|(seconds, _)| seconds);
    let missing_s = gaps.fold(0.0, f64::max) - samples.period_s;
    if missing_s > MAX_MISSING_S {
        return Some(Unusable::Gap { missing_s });
    }
    let turns = samples
        .interpolated_in(span)
        .filter(|(b, _)| b.channel >= 3 && b.is_clipped);
    let variance: f64 = turns.map(|(_, sd)| sd * sd).sum();
    (variance.sqrt() > MAX_MISSED_TURN_RAD).then_some(Unusable::Turn)
}

/// Whether a move without a gyroscope turned; `up` is the direction of gravity before it, `rest` is what follows.
pub(crate) fn turned_unseen(
    samples: &Samples,
    span: &Range<usize>,
    up: &Vector3<f64>,
    rest: Option<&Range<usize>>,
) -> bool {
    let force = |mean: &[f64; 6]| Vector3::new(mean[0], mean[1], mean[2]);
    let tilt = |force: &Vector3<f64>| force.angle(up);
    let is_turned = |force: Vector3<f64>| {
        let longer_mps2 = force.norm() - up.norm();
        longer_mps2.abs() < AS_GRAVITY_MPS2 && tilt(&force) > MAX_MOVING_TILT_RAD
    };
    let size = block_len(samples.period_s, BLOCK_S);
    let mut moving = blocks(samples, span, size).into_iter();
    !samples.has_gyro()
        && (rest.is_some_and(|rest| tilt(&force(&samples.mean(rest))) > MAX_TILT_RAD)
            || moving.any(|block| is_turned(force(&block.mean))))
}
