//! The foot on the ground: short times in which a walking sensor hardly moves.
//!
//! A foot in stance is no rest: it rolls a little, and the accelerometer still
//! rings. But its velocity is near zero, once a step, which ties position down as
//! nothing else does in a walk. It rolls from heel to toe, so that only the quietest
//! moment of each stance is taken. The angular rate tells: in stance its root mean
//! square over a tenth of a second stays under 0.6 rad/s (Fischer, Sukumar and
//! Hazas 2013), in the swing between it exceeds several times that.
//!
//! Only what looks like walking is taken for it: three stances at least, and
//! between neighbours a swing of more than [`SWING_RAD_S`] within
//! [`LONGEST_STEP_S`].

use std::ops::Range;

use gravical_core::matrix3::{dot, norm, sub};

use super::samples::Samples;
/// Root mean square of the angular rate over the window that a foot in stance stays under,
/// rad/s.
pub const STANCE_RATE_RAD_S: f64 = 0.6;
/// How far the specific force, averaged over the window, may be off gravity, m/s².
const FORCE_MPS2: f64 = 2.0;
/// The window, s.
const WINDOW_S: f64 = 0.1;

/// Between two stances the foot turns faster than this, rad/s: a slow walk has 3,
/// hands that carry something rarely 2.
pub const SWING_RAD_S: f64 = 2.5;

/// Two stances further apart are not neighbours of one walk, s.
pub const LONGEST_STEP_S: f64 = 3.0;

/// Fewer are no walk.
const LEAST: usize = 3;

/// Stances in `rows`, two samples each; `bias` is the gyroscope's, `gravity` the magnitude at rest,
/// `step_s` the median step of the samples, `rate_rad_s` as [`STANCE_RATE_RAD_S`].
pub(super) fn stances(
    samples: &Samples,
    rows: Range<usize>,
    bias: &[f64; 3],
    gravity: f64,
    step_s: f64,
    rate_rad_s: f64,
) -> Vec<Range<usize>> {
    if samples.rate_rad_s.is_none() || rows.len() < 3 || step_s.is_nan() {
        return Vec::new();
    }
    let half = ((0.5 * WINDOW_S / step_s).round() as usize).max(1);
    let n = rows.len();
    // Running sums of ‖ω‖² and ‖f‖.
    let (mut turning, mut force) = (vec![0.0; n + 1], vec![0.0; n + 1]);
    let mut rates = Vec::with_capacity(n);
    for (k, i) in rows.clone().enumerate() {
        let w = sub(&samples.rate_at(i), bias);
        let squared = dot(&w, &w);
        rates.push(squared.sqrt());
        turning[k + 1] = turning[k] + squared;
        force[k + 1] = force[k] + norm(&samples.force_at(i)) - gravity;
    }
    let quiet = |k: usize| {
        let window = k.saturating_sub(half)..(k + half + 1).min(n);
        let count = window.len() as f64;
        let square = (turning[window.end] - turning[window.start]) / count;
        let off = (force[window.end] - force[window.start]) / count;
        square < rate_rad_s.powi(2) && off.abs() < FORCE_MPS2
    };
    let mut found: Vec<Range<usize>> = Vec::new();
    let mut k = 0;
    while k < n {
        let end = (k..n).find(|k| !quiet(*k)).unwrap_or(n);
        // The ends of the leg belong to its rests.
        if end - k > half && k > 0 && end < n {
            found.push(k..end);
        }
        k = end.max(k) + 1;
    }
    let all = walked(&found, &rates, |a, b| {
        samples.t_s[rows.start + b] - samples.t_s[rows.start + a]
    });
    let square = |k: usize| {
        let window = k.saturating_sub(half)..(k + half + 1).min(n);
        (turning[window.end] - turning[window.start]) / window.len() as f64
    };
    all.into_iter()
        .map(|r| {
            // A foot rolls from heel to toe: its quietest moment alone is rest.
            let quietest = r
                .clone()
                .min_by(|a, b| square(*a).total_cmp(&square(*b)))
                .unwrap_or(r.start);
            let from = quietest.min(r.end - 2);
            rows.start + from..rows.start + from + 2
        })
        .collect()
}

/// The stances that stand in a walk: a swing parts neighbours. Quiet stretches
/// without a swing between them are one stance.
fn walked(
    found: &[Range<usize>],
    rates: &[f64],
    seconds: impl Fn(usize, usize) -> f64,
) -> Vec<Range<usize>> {
    let swing =
        |a: &Range<usize>, b: &Range<usize>| rates[a.end..b.start].iter().any(|r| *r > SWING_RAD_S);
    let mut out = Vec::new();
    let mut walk: Vec<Range<usize>> = Vec::new();
    let mut close = |walk: &mut Vec<Range<usize>>| {
        if walk.len() >= LEAST {
            out.append(walk);
        }
        walk.clear();
    };
    for stance in found {
        match walk.last() {
            Some(last) if seconds(last.end, stance.start) > LONGEST_STEP_S => close(&mut walk),
            // The longer part of a stance that a twitch interrupts.
            Some(last) if !swing(last, stance) => {
                if stance.len() > last.len()
                    && let Some(last) = walk.last_mut()
                {
                    *last = stance.clone();
                }
                continue;
            }
            _ => {}
        }
        walk.push(stance.clone());
    }
    close(&mut walk);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of one second: a swing of `peak` rad/s for 0.6 s, still for 0.4 s.
    fn walk(steps: usize, peak: f64) -> Samples {
        let n = 100 * steps + 140;
        let rate = |i: usize| {
            let (step, at) = (i.saturating_sub(40) / 100, i.saturating_sub(40) % 100);
            if i >= 40 && step < steps && at < 60 {
                peak * (std::f64::consts::PI * at as f64 / 60.0).sin()
            } else {
                0.02
            }
        };
        Samples {
            t_s: (0..n).map(|i| 0.01 * i as f64).collect(),
            force_mps2: [vec![0.0; n], vec![0.0; n], vec![9.8; n]],
            rate_rad_s: Some([vec![0.02; n], (0..n).map(rate).collect(), vec![0.0; n]]),
            breaks: Vec::new(),
            resolution: [0.0; 6],
            clipped: Vec::new(),
        }
    }

    fn found(samples: &Samples) -> Vec<Range<usize>> {
        let bias = [0.02, 0.02, 0.0];
        stances(
            samples,
            30..samples.len() - 30,
            &bias,
            9.8,
            0.01,
            STANCE_RATE_RAD_S,
        )
    }

    #[test]
    fn a_walk_has_a_stance_between_steps() {
        let all = found(&walk(10, 6.0));
        assert_eq!(all.len(), 9, "{all:?}");
        for (k, stance) in all.iter().enumerate() {
            let from = 40 + 100 * k + 60;
            assert!(
                stance.start >= from && stance.end <= from + 40,
                "{stance:?}"
            );
            assert_eq!(stance.len(), 2);
        }
    }

    #[test]
    fn what_is_no_walk_has_none() {
        // Carried by hand; two steps; without a gyroscope.
        assert!(found(&walk(10, 1.5)).is_empty());
        assert!(found(&walk(3, 6.0)).is_empty());
        let mut blind = walk(10, 6.0);
        blind.rate_rad_s = None;
        assert!(found(&blind).is_empty());
    }
}
