//! What is said of an estimate: its moves, its end, what may hide in a rest, what was done, what the axes are, and
//! what is odd.

use gravical_core::matrix3::norm;
use gravical_motion::{Samples, Unusable};

use super::estimate::Estimate;
use super::options::{MotionOptions, Procedure};
use super::result::{FinalState, Move, VisibleMove};
use crate::finding::Case;
use crate::gravity::Gravity;
use crate::recording::{Finding, LineSpans, Recording};

/// Durations that visible moves are reported of, s.
const REPORTED_S: [f64; 5] = [0.5, 1.0, 2.0, 4.0, 8.0];
/// A single rest shorter than this, s, cannot be distinguished from a part of the move, and shows no bias.
const LONE_REST_S: f64 = 1.0;
/// Gravity at rest that is off by less than this is not reported where nothing is calibrated, relative.
const REPORTED_MISFIT: f64 = 0.005;

/// The moves of an estimate.
pub(super) fn moves(
    own: &Estimate,
    uncalibrated: Option<&Estimate>,
    options: &MotionOptions,
) -> Vec<Move> {
    let t = &own.samples.time_s;
    let others = uncalibrated.map_or(&[][..], |plain| &plain.motion.moves);
    // The only rest of a recording may be constant speed.
    let lone_rest_s = match &own.motion.rests[..] {
        [only] if options.rests.is_none() => Some(t[only.end - 1] - t[only.start]),
        _ => None,
    };
    let lone_rest_s = lone_rest_s.filter(|s| *s < LONE_REST_S);
    let speeds = own.motion.states(&own.samples);
    let mut speeds = speeds.map(|state| norm(&state.velocity_mps)).enumerate();
    let mut moves = Vec::with_capacity(own.motion.moves.len());
    for m in &own.motion.moves {
        let unconfirmed = lone_rest_s.filter(|_| m.stances == 0).map(|rest_s| {
            format!(
                "the sensor rests once, for {rest_s:.1} s: too short to be distinguished from a part of the move; hold it still for 2 s at both ends"
            )
        });
        let unusable = m.unusable.map(unusable);
        let mut one = Move {
            start_s: t[m.samples.start],
            end_s: t[m.samples.end],
            ends: m.ends,
            closure: m.closure,
            stances: m.stances,
            replaced: m.replaced,
            unusable: unusable.or(unconfirmed),
            ..Move::default()
        };
        if one.unusable.is_none() {
            let middle = (m.samples.start + m.samples.end) / 2;
            let other = others.iter().find(|o| o.samples.contains(&middle));
            one.displacement_m = Some(m.displacement_m);
            one.uncalibrated_m = other.map(|o| o.displacement_m);
            one.sigma_m = options.has_bands().then_some(m.sd_m);
            one.budget_m = options.has_bands().then_some(m.budget);
            let (mut peak, mut path, mut before) = (0.0, 0.0, None);
            let from_start = speeds.by_ref().skip_while(|s| s.0 < m.samples.start);
            for (i, speed) in from_start.take(m.samples.len() + 1) {
                peak = f64::max(peak, speed);
                path += before.map_or(0.0, |b: f64| 0.5 * (b + speed) * (t[i] - t[i - 1]));
                before = Some(speed);
            }
            (one.peak_speed_mps, one.path_m) = (Some(peak), Some(path));
        }
        moves.push(one);
    }
    moves
}

/// The end of the recording.
pub(super) fn end(own: &Estimate, moves: &[Move], options: &MotionOptions) -> FinalState {
    let mut unusable = moves.iter().filter(|m| m.unusable.is_some());
    let is_known = unusable.clone().next().is_none();
    let last_s = own.samples.time_s.last();
    let ends_unknown = unusable.any(|m| Some(&m.end_s) == last_s);
    // At rest it is what may hide in the rest, not the noise.
    let has_band = is_known && options.has_bands() && !moves.is_empty();
    let is_finite = |v: [f64; 3]| v.iter().all(|v| v.is_finite());
    let last = own.motion.path.last().filter(|n| is_finite(n.position_m));
    FinalState {
        position_m: last.filter(|_| is_known).map(|n| n.position_m),
        sigma_m: last
            .map(|n| n.position_sd_m)
            .filter(|sigma| has_band && is_finite(*sigma)),
        velocity_mps: last.filter(|_| !ends_unknown).map(|n| n.velocity_mps),
    }
}

/// How far a move has to go to be seen, for durations that fit into the longest rest.
pub(super) fn visible_moves(own: &Estimate, options: &MotionOptions) -> Vec<VisibleMove> {
    if options.rests.is_some() {
        return Vec::new();
    }
    let t = &own.samples.time_s;
    let rests = own.motion.rests.iter();
    let longest_s = rests.map(|r| t[r.end - 1] - t[r.start]).fold(0.0, f64::max);
    let fits = REPORTED_S.into_iter().filter(|s| *s <= longest_s);
    fits.filter_map(|seconds| {
        let distance_m = own.motion.hidden_displacement_m(seconds)?;
        Some(VisibleMove {
            seconds,
            distance_m,
        })
    })
    .collect()
}

/// How motion was computed, and what the axes of velocity and position are.
pub(super) fn procedure(options: &MotionOptions, gyro: bool) -> [String; 2] {
    if options.procedure == Procedure::Report {
        let how = "smoothed by savgol:5,2; mean of the first 500 rows subtracted; trapezoid; no zero-velocity update";
        return [how, "the sensor's own axes"].map(str::to_owned);
    }
    let attitude = if gyro {
        "attitude by strapdown, levelled at the rests"
    } else {
        "tilt by the rests, without a gyroscope"
    };
    let frame = "z up along gravity, x along the sensor's x at the start, made horizontal";
    [
        format!("{attitude}; velocity zero at rests; error-state filter and smoother"),
        frame.to_owned(),
    ]
}

/// Rows that are no samples: incomplete, or behind in time.
pub(super) fn rows_left_out(recording: &Recording, samples: &Samples) -> Option<Finding> {
    let mut kept = samples.rows.iter().peekable();
    let left_out =
        (0..recording.rows()).filter(|row| kept.next_if(|k| **k as usize == *row).is_none());
    let lines: LineSpans = left_out.map(|row| recording.line(row)).collect();
    (!lines.is_empty()).then(|| Case::RowsLeftOut.finding().at_lines(&lines))
}

/// What the recording lacks, and what that costs.
pub(super) fn context_findings(
    gyro: bool,
    moves: &[Move],
    options: &MotionOptions,
) -> Vec<Finding> {
    let mut out = Vec::new();
    let strapdown = options.procedure == Procedure::Strapdown;
    if strapdown && !gyro && !moves.is_empty() {
        let lasts = moves.iter().map(|m| m.end_s - m.start_s);
        let longest_s = lasts.fold(0.0, f64::max);
        let swing_m = 9.8 * 1.0_f64.to_radians() * longest_s * longest_s / std::f64::consts::TAU;
        out.push(Case::NoGyro { longest_s, swing_m }.finding());
    }
    let closures = moves.iter().filter_map(|m| m.closure);
    let widened = closures.filter(|c| c.widened).count();
    if widened > 0 {
        let moves = moves.len();
        let case = Case::ClosureContradicts { widened, moves };
        out.push(case.finding().counting(widened as u64));
    }
    let runs = moves.iter().map(|m| m.replaced).sum::<usize>();
    if runs > 0 {
        let case = Case::ValuesReplaced { runs };
        out.push(case.finding().counting(runs as u64));
    }
    out
}

/// Why the displacement of a move cannot be known.
pub(super) fn unusable(why: Unusable) -> String {
    match why {
        Unusable::Gap { missing_s } => {
            format!("{missing_s:.2} s are missing in it: how far it went then is not known")
        }
        Unusable::Interrupted => {
            "the recording is interrupted in it: how far it went then is not known".to_owned()
        }
        Unusable::Turn => {
            "it turns faster than the range of the gyroscope: the attitude is not known; record at a wider range".to_owned()
        }
        Unusable::Unseen => {
            "it turns, and no gyroscope measures by how much: the attitude is not known".to_owned()
        }
    }
}

/// The magnitude at rest without a calibration, where it is not gravity.
pub(super) fn size(force: [f64; 3], gravity: &Gravity) -> Option<Finding> {
    let (norm_mps2, gravity_mps2) = (norm(&force), gravity.value_mps2);
    let off = norm_mps2 / gravity_mps2 - 1.0;
    let case = Case::GravityOff {
        norm_mps2,
        off_percent: 100.0 * off,
        gravity_mps2,
    };
    let mut finding = case.finding();
    if off.abs() <= 0.02 {
        finding = finding.as_note();
    }
    (off.abs() > REPORTED_MISFIT).then_some(finding)
}
