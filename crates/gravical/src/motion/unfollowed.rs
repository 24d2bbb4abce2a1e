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

#[cfg(test)]
mod tests {
    use super::*;

    /// One swing of a rate with the amplitude 2 rad/s, clipped at 1.5.
    fn swing() -> Samples {
        let n = 200;
        let rate = |i: usize| 2.0 * (std::f64::consts::PI * i as f64 / 100.0).sin();
        let inside = |i: usize| rate(i).clamp(-1.5, 1.5);
        Samples {
            t_s: (0..n).map(|i| 0.01 * i as f64).collect(),
            force_mps2: [vec![0.0; n], vec![0.0; n], vec![9.8; n]],
            rate_rad_s: Some([(0..n).map(inside).collect(), vec![0.0; n], vec![0.0; n]]),
            clipped: (0..n).filter(|i| rate(*i).abs() >= 1.5).collect(),
            ..Samples::default()
        }
    }

    #[test]
    fn what_is_missed_is_told_by_the_slopes() {
        let samples = swing();
        let truth: f64 = (0..200)
            .map(|i| 2.0 * (std::f64::consts::PI * f64::from(i) / 100.0).sin())
            .map(|w| 0.01 * (w.abs() - 1.5).max(0.0))
            .sum();
        let missed = missed_rad(&samples, 0..200);
        assert!((missed / truth - 1.0).abs() < 0.2, "{missed} {truth}");
        assert!((missed_rad(&samples, 0..100) / missed - 0.5).abs() < 0.01);
        assert_eq!(missed_rad(&samples, 0..10), 0.0);
        // Nothing beside it tells how it goes on.
        assert!(missed_rad(&samples.first(50), 0..50) > 0.0);
        let alone = Samples {
            clipped: vec![0, 1, 2],
            ..samples.first(3)
        };
        assert_eq!(missed_rad(&alone, 0..3), f64::INFINITY);
    }

    #[test]
    fn a_move_that_turns_too_fast_is_lost() {
        let leg = Stretch::Leg {
            from: 0,
            to: 199,
            ends: super::super::result::Ends::RestToRest,
            before: Some(0),
            after: Some(1),
        };
        let mut plan = [leg.clone()];
        without_unfollowed(&swing(), &mut plan);
        assert!(matches!(
            plan[0],
            Stretch::Lost {
                why: Loss::Turn { .. },
                ..
            }
        ));
        let mut plan = [leg.clone()];
        without_unfollowed(
            &Samples {
                clipped: Vec::new(),
                ..swing()
            },
            &mut plan,
        );
        assert_eq!(plan, [leg]);
    }
}
