//! Moves of which nobody knows how far they went.

use std::ops::Range;

use gravical_signal::Samples;

/// A hand moves by a few decimetres in so long, s: what it did in a longer gap is not known.
const MAX_MISSING_S: f64 = 0.5;
/// Standard deviation of the angle that a clipped gyroscope may have missed in a move, rad: 4°. Bands of
/// simulated turns of 1 s hold where the range is 0.4 of the highest rate, whatever the angle. Where it is
/// 0.24 they are too narrow by half; from 0.5 rad on that is 5° and more.
const MAX_MISSED_TURN_RAD: f64 = 0.07;

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
        .bridged_in(span)
        .filter(|(b, _)| b.channel >= 3 && b.is_clipped);
    let variance: f64 = turns.map(|(_, sd)| sd * sd).sum();
    (variance.sqrt() > MAX_MISSED_TURN_RAD).then_some(Unusable::Turn)
}
