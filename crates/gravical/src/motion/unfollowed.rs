//! Turns that a gyroscope at the end of its range does not tell.

use std::ops::Range;

use gravical_core::matrix3::{norm, sub};

use super::plan::Stretch;
use super::result::Loss;
use super::samples::Samples;

/// A move in which more may be lost has an attitude that is not known, rad: 2°.
const MOST_RAD: f64 = 0.035;

/// Angle that the gyroscope may have missed in `rows`, rad; infinite where nothing tells.
///
/// Beyond the end of the range the rate goes on as it came and went: a parabola whose slope
/// at both ends is α, through the time D, has D²α/6 more than the straight line. What several
/// such times miss is added, since a swing back would hide it.
pub(super) fn missed_rad(samples: &Samples, rows: Range<usize>) -> f64 {
    let clipped = &samples.clipped;
    let from = clipped.partition_point(|i| *i < rows.start);
    let to = clipped.partition_point(|i| *i < rows.end);
    clipped[from..to]
        .chunk_by(|a, b| a + 1 == *b)
        .map(|run| {
            let (first, last) = (run[0], run[run.len() - 1]);
            let slope = slope(samples, first, -1).max(slope(samples, last, 1));
            let t = |i: usize| samples.t_s[i.min(samples.len() - 1)];
            let seconds = t(last + 1) - t(first.saturating_sub(1));
            match slope > 0.0 {
                true => slope * seconds * seconds / 6.0,
                false => f64::INFINITY,
            }
        })
        .sum()
}

/// How fast the rate changes beside a clipped sample, rad/s²: between its neighbour and the
/// one beyond. Zero where they are missing.
fn slope(samples: &Samples, at: usize, step: isize) -> f64 {
    let beside = at.checked_add_signed(step);
    let beyond = at.checked_add_signed(2 * step);
    let (Some(a), Some(b)) = (beside, beyond) else {
        return 0.0;
    };
    if a.max(b) >= samples.len() {
        return 0.0;
    }
    let seconds = (samples.t_s[b] - samples.t_s[a]).abs();
    let change = norm(&sub(&samples.rate_at(b), &samples.rate_at(a)));
    if seconds > 0.0 { change / seconds } else { 0.0 }
}

/// Takes the legs out of `plan` in which too much of the turn is missed.
pub(super) fn without_unfollowed(samples: &Samples, plan: &mut [Stretch]) {
    for stretch in plan {
        let Stretch::Leg { from, to, .. } = *stretch else {
            continue;
        };
        let radians = missed_rad(samples, from..to + 1);
        if radians > MOST_RAD {
            *stretch = Stretch::Lost {
                from,
                to,
                why: Loss::Turn { radians },
            };
        }
    }
}
