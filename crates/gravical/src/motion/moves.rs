//! What an estimate says of the moves, of the end of the recording, and of what may hide in a rest.

use gravical_core::matrix3::norm;

use super::estimate::Estimate;
use super::options::MotionOptions;
use super::result::{FinalState, Move, VisibleMove};
use super::words;

/// Durations that visible moves are reported of, s.
const REPORTED_S: [f64; 5] = [0.5, 1.0, 2.0, 4.0, 8.0];
/// A single rest shorter than this, s, cannot be distinguished from a part of the move, and shows no bias.
const LONE_REST_S: f64 = 1.0;

/// The moves of an estimate.
pub(super) fn moves(
    own: &Estimate,
    uncalibrated: Option<&Estimate>,
    options: &MotionOptions,
) -> Vec<Move> {
    let t = own.samples.channels().time_s;
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
        let unusable = m.unusable.map(words::unusable);
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
    let last_s = own.samples.channels().time_s.last();
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
    if options.rests.is_some() || options.causal {
        return Vec::new();
    }
    let t = own.samples.channels().time_s;
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
