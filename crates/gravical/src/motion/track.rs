//! A motion sample by sample.

use std::ops::Range;

use gravical_motion::SampleState;

use super::estimate::Estimate;
use super::{Motion, MotionResult};

/// One sample of a motion. What is not known is NaN.
#[derive(Debug, Clone, Copy)]
pub struct MotionSample {
    /// Time, s.
    pub t_s: f64,
    /// Specific force by the nominal scale alone, m/s².
    pub raw_mps2: [f64; 3],
    /// Specific force, calibrated (and smoothed, where asked for), m/s².
    pub force_mps2: [f64; 3],
    /// Attitude, acceleration, velocity and position with their standard deviations, in the frame of the result.
    pub state: SampleState,
}

/// What figures and comparisons show, sample by sample; all columns are equally long. Where a
/// value is not known it is NaN.
#[derive(Debug, Clone, Default)]
pub struct Track {
    /// Time, s.
    pub t_s: Vec<f64>,
    /// Samples before which others are missing, or the recording is parted.
    pub breaks: Vec<usize>,
    /// Acceleration in the frame, gravity taken off, m/s².
    pub acceleration_mps2: Vec<[f64; 3]>,
    /// Velocity, m/s.
    pub velocity_mps: Vec<[f64; 3]>,
    /// Position, m.
    pub position_m: Vec<[f64; 3]>,
    /// Standard uncertainty of the velocity, m/s; empty without bands.
    pub sigma_velocity_mps: Vec<[f64; 3]>,
    /// Standard uncertainty of the position, m; empty without bands.
    pub sigma_position_m: Vec<[f64; 3]>,
    /// The same without the calibration; none without one.
    pub uncalibrated: Option<UncalibratedTrack>,
}

/// A reference on the clock and in the frame of the result, where both are known.
#[derive(Debug, Clone, Default)]
pub struct ReferenceTrack {
    /// Time, s.
    pub t_s: Vec<f64>,
    /// Position, m; it starts where the result is at that time.
    pub position_m: Vec<[f64; 3]>,
}

/// Velocity and position without the calibration, sample by sample; as long as the
/// columns of [`Track`].
#[derive(Debug, Clone, Default)]
pub struct UncalibratedTrack {
    /// Velocity, m/s.
    pub velocity_mps: Vec<[f64; 3]>,
    /// Position, m.
    pub position_m: Vec<[f64; 3]>,
}

impl Track {
    /// All samples of a motion.
    pub(super) fn new(motion: &Motion) -> Self {
        let pieces = motion.own.samples.pieces().iter();
        let mut track = Track {
            breaks: pieces.skip(1).map(|p| p.start).collect(),
            uncalibrated: motion.uncalibrated.as_ref().map(|plain| {
                let mut track = UncalibratedTrack::default();
                for state in known(plain, &motion.result) {
                    track.velocity_mps.push(state.velocity_mps);
                    track.position_m.push(state.position_m);
                }
                track
            }),
            ..Track::default()
        };
        for sample in motion.samples() {
            track.t_s.push(sample.t_s);
            let state = sample.state;
            track.acceleration_mps2.push(state.acceleration_mps2);
            track.velocity_mps.push(state.velocity_mps);
            track.position_m.push(state.position_m);
            if motion.bands {
                track.sigma_velocity_mps.push(state.velocity_sd_mps);
                track.sigma_position_m.push(state.position_sd_m);
            }
        }
        track
    }
}

/// The samples of a motion, in order.
pub(super) fn samples(motion: &Motion) -> impl Iterator<Item = MotionSample> {
    let own = &motion.own.samples;
    let raw = motion
        .uncalibrated
        .as_ref()
        .map_or(own, |plain| &plain.samples);
    known(&motion.own, &motion.result)
        .enumerate()
        .map(move |(i, state)| MotionSample {
            t_s: own.time_s()[i],
            raw_mps2: raw.force_mps2()[i],
            force_mps2: own.force_mps2()[i],
            state,
        })
}

/// The states of an estimate: in a move that is not usable only that it moves is known, and from there on no
/// position.
fn known<'a>(
    estimate: &'a Estimate,
    result: &MotionResult,
) -> impl Iterator<Item = SampleState> + 'a {
    let time_s = estimate.samples.time_s();
    let at = |t_s: f64| time_s.partition_point(|t| *t < t_s);
    let unusable: Vec<Range<usize>> = (result.moves.iter())
        .filter(|m| m.unusable.is_some())
        .map(|m| {
            // At its ends it may rest.
            let (from, to) = (at(m.start_s), at(m.end_s));
            let first = from + usize::from(from > 0);
            first..to + usize::from(to + 1 == time_s.len())
        })
        .collect();
    let mut next = 0;
    estimate.states().enumerate().map(move |(i, mut state)| {
        while unusable.get(next).is_some_and(|span| span.end <= i) {
            next += 1;
        }
        if unusable.get(next).is_some_and(|span| span.contains(&i)) {
            state = SampleState {
                at_rest: false,
                ..SampleState::UNKNOWN
            };
        }
        if unusable.first().is_some_and(|span| span.start <= i) {
            state.position_m = [f64::NAN; 3];
            state.position_sd_m = [f64::NAN; 3];
        }
        state
    })
}
