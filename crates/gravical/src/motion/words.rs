//! What was done, what the axes are, and what is odd, in words.

use std::ops::Range;

use gravical_core::matrix3::norm;

use super::gate::Judged;
use super::hidden::{Hidden, VisibleMove};
use super::misfit::GravityMisfit;
use super::options::{GravityRemoval, MotionOptions};
use super::plan::Stretch;
use super::result::{Ends, Move};
use super::samples::Samples;
use super::setup::Setup;
use super::still::Rests;
use crate::gravity::Gravity;
use crate::recording::board::why_calibrated;
use crate::recording::{Finding, FindingKind, LineSpans};

/// Gravity at rest that is off by less than this is not reported where nothing is
/// calibrated, relative.
const REPORTED_MISFIT: f64 = 0.005;

/// How motion was computed.
pub(super) fn procedure(options: &MotionOptions, gyro: bool) -> String {
    let gravity = match options.gravity_removal {
        GravityRemoval::Strapdown if gyro => {
            "attitude by strapdown, corrected from both ends of each move".to_owned()
        }
        GravityRemoval::Strapdown => {
            "tilt from rest to rest, without a gyroscope in between".to_owned()
        }
        GravityRemoval::ConstantTilt => "tilt as at the rest before".to_owned(),
        GravityRemoval::InitialMean => {
            format!("mean of the first {} rows subtracted", options.initial_rows)
        }
    };
    let ends = if options.zero_velocity {
        "velocity zero at rests"
    } else {
        "no zero-velocity correction"
    };
    let smoothing = smoothing(options, "smoothed");
    format!("{smoothing}{gravity}; trapezoid with the recorded stamps; {ends}")
}

fn smoothing(options: &MotionOptions, how: &str) -> String {
    if options.smooth.is_empty() {
        return String::new();
    }
    let names: Vec<String> = options.smooth.iter().map(ToString::to_string).collect();
    format!("{how} by {}; ", names.join(", "))
}

/// How it is computed sample by sample.
pub(super) fn causal_procedure(options: &MotionOptions, gyro: bool) -> String {
    let gravity = match options.gravity_removal {
        GravityRemoval::Strapdown if gyro => {
            "attitude by strapdown from the rest before".to_owned()
        }
        GravityRemoval::Strapdown | GravityRemoval::ConstantTilt => {
            "tilt as at the rest before".to_owned()
        }
        GravityRemoval::InitialMean => {
            format!("mean of the first {} rows subtracted", options.initial_rows)
        }
    };
    let ends = if options.zero_velocity {
        "velocity zero at rests, the position corrected there"
    } else {
        "no zero-velocity correction"
    };
    format!(
        "without look-ahead: {}{gravity}; trapezoid with the recorded stamps; {ends}",
        smoothing(options, "causally smoothed")
    )
}

/// What the axes of velocity and position are.
pub(super) fn frame(options: &MotionOptions, no_rest: bool) -> String {
    let at = if no_rest {
        "over the whole recording"
    } else {
        "at the first rest"
    };
    match options.gravity_removal {
        GravityRemoval::InitialMean => "the sensor's own axes".to_owned(),
        _ => format!("z up along gravity, x along the sensor's x {at}, made horizontal"),
    }
}

/// A calibration without covariance.
pub(super) fn no_covariance() -> Finding {
    Finding::new(
        FindingKind::CovarianceUnknown,
        "the calibration does not state its covariance: 0.5 % of scale, 0.02 m/s² of bias and 0.6° between the axes are assumed for the band",
    )
}

/// Rows that are no samples.
pub(super) fn rows_left_out(lines: &LineSpans) -> Option<Finding> {
    (!lines.is_empty()).then(|| {
        Finding::new(
            FindingKind::RowsLeftOut,
            "rows without a complete sample, or whose time stamp is before that of the row before; the steps go over them",
        )
        .at_lines(lines)
    })
}

/// Quiet stretches that are no rest, and rests against the odds.
pub(super) fn gate(samples: &Samples, judged: &[Judged]) -> Vec<Finding> {
    judged
        .iter()
        .filter_map(|j| {
            let (from, to) = (samples.t_s[j.span.start], samples.t_s[j.span.end - 1]);
            let speed = norm(&j.velocity);
            let sigma = norm(&j.sigma);
            if j.overruled {
                return Some(Finding::new(
                    FindingKind::RestAtSpeed,
                    format!(
                        "quiet from {from:.2} to {to:.2} s, where the integrated velocity is {speed:.2} m/s (1σ {sigma:.2}); taken for a rest since nothing after it comes nearer to one: the acceleration drifted by {:.3} m/s², or the sensor went on at constant speed (--rests sets the rests by hand)",
                        speed / j.seconds.max(1e-3)
                    ),
                ));
            }
            (!j.rest).then(|| {
                Finding::new(
                    FindingKind::ConstantSpeed,
                    format!(
                        "quiet from {from:.2} to {to:.2} s, but at {speed:.2} m/s (1σ {sigma:.2}): constant speed, no rest"
                    ),
                )
            })
        })
        .collect()
}

/// What a stream learnt of its rests too late, or decided against the velocity; those
/// are given by when they were taken for rests, s.
pub(super) fn causal_rests(taken_back: u32, at_speed: &[f64]) -> Vec<Finding> {
    let mut out = Vec::new();
    if taken_back > 0 {
        let text = match taken_back {
            1 => "1 short rest was withdrawn: as the velocity at the next rest shows, it was none; the moves on either side of it are one".to_owned(),
            _ => format!(
                "{taken_back} short rests were withdrawn: as the velocity at the next rest shows, they were none; the moves on either side of each are one"
            ),
        };
        out.push(Finding::new(FindingKind::RestTakenBack, text).counting(u64::from(taken_back)));
    }
    if let Some(first) = at_speed.first() {
        let (when, what, moves) = match at_speed.len() {
            1 => (
                format!("static once, until {first:.2} s, at a velocity that is not zero"),
                "a rest",
                "move before it",
            ),
            n => (
                format!(
                    "static {n} times, first until {first:.2} s, at velocities that are not zero"
                ),
                "rests",
                "moves before them",
            ),
        };
        let text = format!(
            "{when}; taken for {what} since it stays static: the acceleration drifted, or the sensor went on at constant speed; how far the {moves} went may be far off"
        );
        out.push(Finding::new(FindingKind::RestAtSpeed, text).counting(at_speed.len() as u64));
    }
    out
}

/// A velocity at the end of a move beyond so many σ is no chance: one in 16,000.
const CONTRADICTED: f64 = 4.0;

/// A rest that is shorter, s, hides nothing that is slower than what is found.
const LONG_REST_S: f64 = 14.0;

/// Moves that are too slow to be distinguished from rest, and those that may hide in one.
pub(super) fn slow(found: &Rests, options: &MotionOptions) -> Vec<Finding> {
    if !options.zero_velocity || options.rests_s.is_some() {
        return Vec::new();
    }
    found
        .doubts
        .iter()
        .map(|d| {
            Finding::new(
                FindingKind::SlowMoveDoubted,
                format!(
                    "from {:.1} to {:.1} s the force changes as in a move by {:.1} m, by more than chance and by too little to be certain (χ² {:.0}); taken for rest, so the position may be off by that much (--rests sets the rests by hand)",
                    d.start_s, d.end_s, d.distance_m, d.chi2
                ),
            )
        })
        .collect()
}

/// What may hide in a long rest, or in a recording in which no move is seen.
pub(super) fn hidden(
    hidden: &Hidden,
    visible: &[VisibleMove],
    no_move: bool,
    options: &MotionOptions,
) -> Option<Finding> {
    if !options.zero_velocity || visible.is_empty() || !no_move && hidden.rest_s() < LONG_REST_S {
        return None;
    }
    let ways: Vec<String> = visible
        .iter()
        .filter(|v| v.seconds >= 2.0 || visible.len() < 3)
        .map(|v| format!("{} m in {} s", rounded(v.distance_m), v.seconds))
        .collect();
    let cost = match no_move {
        true => format!(
            ": the position is 0 ± {} m for that (1σ)",
            rounded(hidden.sigma_m(hidden.rest_s()))
        ),
        false => String::new(),
    };
    Some(Finding::new(
        FindingKind::SlowMovesHidden,
        format!(
            "a move of less than {} cannot be distinguished from rest here{cost}",
            ways.join(", or "),
        ),
    ))
}

/// A length to two digits, m.
fn rounded(metres: f64) -> String {
    let decimals = (1.0 - metres.log10().floor()).clamp(0.0, 6.0);
    format!("{metres:.*}", decimals as usize)
}

/// A rest that is shorter, s, is not distinguished from constant velocity where it is the only one, …
const ALONE_S: f64 = 2.0;
/// … with motion on both sides of it, …
const BETWEEN_S: f64 = 5.0;
/// … and where there are others: the five blocks that agree, less what their edges take.
const AMONG_OTHERS_S: f64 = 0.8;

/// Why nothing can be said of how far the sensor went; none where its rests can be
/// believed.
pub(super) fn unfounded(
    samples: &Samples,
    rests: &[Range<usize>],
    options: &MotionOptions,
) -> Option<String> {
    let throughout = matches!(rests, [one] if one.len() == samples.len());
    if !options.zero_velocity || options.rests_s.is_some() || throughout {
        return None;
    }
    let length = |r: &Range<usize>| samples.t_s[r.end - 1] - samples.t_s[r.start];
    let longest = rests.iter().map(length).fold(0.0, f64::max);
    match rests {
        [] if options.v0_mps.is_none() => Some(
            "it rests nowhere: tilt, velocity and noise are not known; what is given is as if it had started at rest"
                .to_owned(),
        ),
        [] => None,
        [one]
            if longest + 0.02
                < match one.start > 0 && one.end < samples.len() {
                    true => BETWEEN_S,
                    false => ALONE_S,
                } =>
        {
            Some(format!(
                "it rests once, for {longest:.1} s: too short to be distinguished from constant velocity; hold it still for 2 s at both ends"
            ))
        }
        _ if longest + 0.02 < AMONG_OTHERS_S => Some(format!(
            "its longest rest lasts {longest:.1} s: too short to be distinguished from a part of the move; hold it still for 2 s at both ends"
        )),
        _ => None,
    }
}

/// What the recording lacks, and what that costs.
pub(super) fn circumstances(
    setup: &Setup<'_>,
    rests: &[Range<usize>],
    plan: &[Stretch],
    moves: &[Move],
    options: &MotionOptions,
) -> Vec<Finding> {
    let mut out = Vec::new();
    let samples = setup.view.samples;
    if rests.is_empty() {
        out.push(Finding::new(
            FindingKind::NoStaticInterval,
            "the sensor never rests: tilt and gravity are the mean over the recording, the velocity at the start is taken as given or zero, and nothing corrects the drift, whose size nothing tells: there are no bands; hold it still for 2 s at both ends",
        ));
    }
    let strapdown = options.gravity_removal == GravityRemoval::Strapdown;
    if strapdown && samples.rate_rad_s.is_none() && !moves.is_empty() {
        let longest = moves
            .iter()
            .map(|m| m.end_s - m.start_s)
            .fold(0.0, f64::max);
        let cost = 9.8 * 1.0_f64.to_radians() * longest * longest / std::f64::consts::TAU;
        out.push(Finding::new(
            FindingKind::NoGyro,
            format!(
                "without a gyroscope the tilt between rests is not known: one swing of 1° during the longest move ({longest:.1} s) is {cost:.2} m; {}° are allowed for in the band (--tilt-change)",
                options.tilt_change_deg
            ),
        ));
    }
    if let Some(first) = plan.first()
        && let Stretch::Lost { to, .. } = first
    {
        out.push(Finding::new(
            FindingKind::StartLost,
            format!(
                "what came before the first rest is not known: position counts from there, {:.2} s",
                samples.t_s[*to]
            ),
        ));
    }
    for stretch in plan {
        if let Stretch::QuietGap { gap_s } = stretch {
            out.push(Finding::new(
                FindingKind::GapAtRest,
                format!(
                    "{} while the sensor rests in one pose: taken as not moved",
                    match *gap_s > 0.0 {
                        true => format!("{gap_s:.2} s are missing"),
                        false => "the recording is interrupted".to_owned(),
                    }
                ),
            ));
        }
    }
    let closures = || moves.iter().filter_map(|m| m.closure_sigmas);
    let contradicted = closures().filter(|s| *s > CONTRADICTED).count();
    if contradicted > 0 {
        let worst = closures().fold(0.0, f64::max);
        out.push(
            Finding::new(
                FindingKind::ClosureContradicts,
                format!(
                    "at the end of {contradicted} of {} moves the velocity, or the tilt, is up to {worst:.0} times its uncertainty off: a bias that drifts, a hand that did not stop, a reading out of range or a rest that is none; the bands of these moves are widened by it",
                    moves.len()
                ),
            )
            .counting(contradicted as u64),
        );
    }
    let lost = moves.iter().filter(|m| m.displacement_m.is_none()).count();
    if lost > 0 {
        out.push(
            Finding::new(
                FindingKind::MoveUnusable,
                format!(
                    "{lost} of {} moves have a gap in them, or turn faster than the gyroscope can tell: how far they went is not known, nor any position after; the other moves are computed each from its own start",
                    moves.len()
                ),
            )
            .counting(lost as u64),
        );
    }
    if !rests.is_empty()
        && let Some(reason) = unfounded(samples, rests, options)
    {
        out.push(Finding::new(FindingKind::RestUnconfirmed, reason));
    }
    if options.zero_velocity && !rests.is_empty() {
        let open: Vec<&Move> = moves
            .iter()
            .filter(|m| m.displacement_m.is_some() && m.ends != Ends::RestToRest)
            .collect();
        for one in open {
            let what = if one.ends == Ends::ToRest {
                "starts in motion: computed backwards from the first rest"
            } else {
                "ends in motion: after the last rest nothing corrects the drift"
            };
            out.push(Finding::new(
                if one.ends == Ends::ToRest {
                    FindingKind::StartsMoving
                } else {
                    FindingKind::EndsMoving
                },
                format!(
                    "the recording {what} ({:.2} to {:.2} s)",
                    one.start_s, one.end_s
                ),
            ));
        }
    }
    out
}

/// Gravity at a rest that the calibration does not allow.
pub(super) fn misfit(misfit: &GravityMisfit) -> Option<Finding> {
    misfit.contradicts.then(|| {
        Finding::warning(
            FindingKind::GravityOff,
            format!(
                "at the rest from {:.2} s on the calibrated magnitude is {:.3} m/s², gravity is {:.3}: off by {:.1} times what the calibration allows (1σ {:.3}); the calibration does not fit this recording, and the bands are widened for an error of that size: test it with `gravical check`",
                misfit.rest_s,
                misfit.measured_mps2,
                misfit.gravity_mps2,
                misfit.sigmas(),
                misfit.sigma_mps2
            ),
        )
    })
}

/// Columns that may have been calibrated before.
pub(super) fn already_calibrated(by_board: bool) -> Finding {
    if by_board {
        return Finding::new(
            FindingKind::AlreadyCalibrated,
            format!(
                "{}: the calibration is applied for the second time, and the bands are widened by what it changes; leave out --calibration, or use a raw recording",
                why_calibrated(true)
            ),
        );
    }
    Finding::new(
        FindingKind::AlreadyCalibrated,
        "its columns are named as this program names calibrated ones, and gravity at the rests does not contradict it: the calibration may be applied for the second time, and the bands are widened by what it changes; leave out --calibration, or use the raw recording",
    )
}

/// The magnitude at rest without a calibration, where it is not gravity.
pub(super) fn size(force: [f64; 3], gravity: &Gravity, moves: &[Move]) -> Option<Finding> {
    let size = norm(&force);
    let g = gravity.value_mps2;
    let off = size / g - 1.0;
    if off.abs() <= REPORTED_MISFIT {
        return None;
    }
    let farthest = moves
        .iter()
        .filter_map(|m| m.displacement_m)
        .max_by(|a, b| norm(a).total_cmp(&norm(b)));
    let example = farthest.map_or_else(String::new, |d| {
        let way = norm(&d);
        format!(
            "; the longest displacement is {way:.4} m in the one case, {:.4} m in the other",
            way / (1.0 + off)
        )
    });
    let text = format!(
        "at rest the magnitude is {size:.2} m/s², {:+.1} % off gravity ({g:.2}): a bias, which levelling takes off, or an error of scale, which stays{example}; the band allows for both, a calibration decides",
        100.0 * off
    );
    Some(if off.abs() > 0.02 {
        Finding::warning(FindingKind::GravityOff, text)
    } else {
        Finding::note(FindingKind::GravityOff, text)
    })
}

/// A velocity at the start that has no part in the result.
pub(super) fn start_velocity(options: &MotionOptions, rests: bool) -> Option<Finding> {
    (options.v0_mps.is_some() && options.zero_velocity && rests).then(|| {
        Finding::new(
            FindingKind::V0NotUsed,
            "--v0 is not used: velocity is zero at the rests, and what comes before the first follows from it; --zero-velocity off integrates from the start",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_rest_is_told_in_the_singular() {
        let texts = |taken_back: u32, at_speed: &[f64]| -> Vec<String> {
            let found = causal_rests(taken_back, at_speed);
            found.into_iter().map(|f| f.message).collect()
        };
        let one = texts(1, &[12.3]);
        assert!(one[0].starts_with("1 short rest was withdrawn:"), "{one:?}");
        assert!(
            one[1].starts_with("static once, until 12.30 s, at a velocity that is not zero;"),
            "{one:?}"
        );
        let two = texts(2, &[12.3, 20.0]);
        assert!(
            two[0].starts_with("2 short rests were withdrawn:"),
            "{two:?}"
        );
        assert!(
            two[1].starts_with("static 2 times, first until 12.30 s,"),
            "{two:?}"
        );
        assert!(texts(0, &[]).is_empty());
    }
}
