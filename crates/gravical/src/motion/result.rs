//! What motion says: the object of `gravical motion --json`, and the columns of
//! its table.

pub use gravical_motion::{Budget, Closure, Ends, NoiseAtRest};

use serde::Serialize;

use super::uncertainty::GravityMisfit;
use crate::recording::Finding;

/// What was computed, and from what: the same for a motion and for its orientation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Computation {
    /// The recording as it was given.
    pub input: String,
    /// The calibration as it was given; null without one.
    pub calibration: Option<String>,
    /// How it was computed, for people.
    pub procedure: String,
    /// Sampling rates, Hz.
    pub rate_hz: Rates,
    /// From the first sample to the last, s.
    pub duration_s: f64,
    /// Rows of the recording.
    pub rows: u64,
    /// Rows without a complete sample, which were stepped over.
    pub rows_left_out: u64,
    /// What the axes of velocity and position, or of the attitude, are.
    pub frame: String,
    /// Where the sensor rested.
    pub rests: Vec<Span>,
}

/// Motion of one recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MotionResult {
    /// How it was computed, and from what.
    #[serde(flatten)]
    pub computation: Computation,
    /// What its position is worth, and why.
    pub verdict: MotionVerdict,
    /// Noise at rest; null without a rest.
    pub noise: Option<NoiseAtRest>,
    /// How far a move has to go, by its duration, to be distinguished from rest; empty without a
    /// rest, and where the rests were given.
    pub visible_moves: Vec<VisibleMove>,
    /// Speed below which a steady travel may look like a rest, m/s; null as above.
    pub visible_speed_mps: Option<f64>,
    /// Gravity at the rest at which it is off most, by the calibration; null without a
    /// calibration or a rest.
    pub gravity_misfit: Option<GravityMisfit>,
    /// What lies between the rests.
    pub moves: Vec<Move>,
    /// At the end of the recording, counted from its start.
    pub r#final: FinalState,
    /// The same computed without the calibration; null without one.
    pub uncalibrated: Option<FinalState>,
    /// What is odd.
    pub findings: Vec<Finding>,
}

/// The verdict on a motion, with its reasons.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MotionVerdict {
    /// In a word.
    pub judgement: MotionJudgement,
    /// Farthest distance from the start, m; null where no position is known.
    pub size_m: Option<f64>,
    /// Expanded uncertainty of the end (95 %, k = 2), m: of a single move along it, else on the worst axis; null
    /// where it is not known.
    pub expanded_m: Option<f64>,
    /// The uncertainty over the size; null where one of them is not known.
    pub ratio: Option<f64>,
    /// Why.
    pub reasons: Vec<String>,
}

/// The verdict in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum MotionJudgement {
    /// The uncertainty is at most a tenth of the size.
    Usable,
    /// It is at most the size.
    Rough,
    /// It is larger, or a displacement is not known.
    PositionNotKnown,
    /// The recording ends without a rest: nothing tests its end.
    Open,
    /// Nothing moved that can be told from rest.
    AtRest,
}

impl MotionJudgement {
    /// A position at the end is known.
    pub fn is_known(self) -> bool {
        !matches!(self, Self::PositionNotKnown | Self::Open)
    }
}

/// Sampling rates, Hz.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rates {
    /// Claimed by the recording or the user; null where nothing states it.
    pub nominal: Option<f64>,
    /// Samples over time, by the stamps; null without stamps.
    pub r#true: Option<f64>,
}

/// A span of time, s from the first row.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Span {
    /// First sample.
    pub start_s: f64,
    /// Last sample.
    pub end_s: f64,
}

/// How far a move has to go to be distinguished from rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct VisibleMove {
    /// Its duration, s.
    pub seconds: f64,
    /// A shorter way of it may be taken for rest, m.
    pub distance_m: f64,
}

/// One move.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Move {
    /// Its start, s.
    pub start_s: f64,
    /// Its end, s.
    pub end_s: f64,
    /// What lies at its ends.
    pub ends: Ends,
    /// From its own start to its own end, m; null where it cannot be known.
    pub displacement_m: Option<[f64; 3]>,
    /// Standard uncertainty of it, m; null without bands.
    pub sigma_m: Option<[f64; 3]>,
    /// What the standard uncertainty consists of; null without bands.
    pub budget_m: Option<Budget>,
    /// The displacement computed without the calibration, m; null without one.
    pub uncalibrated_m: Option<[f64; 3]>,
    /// Highest speed, m/s; null where the displacement is.
    pub peak_speed_mps: Option<f64>,
    /// Length of the path: the integral of the speed, m; null where the displacement is.
    pub path_m: Option<f64>,
    /// What the rest that ends it says of it; null without a rest at both ends.
    pub closure: Option<Closure>,
    /// Stances of a walking foot in it.
    pub stances: usize,
    /// Values in it that stood at the end of the range, or out of all others, in runs: they were
    /// replaced.
    pub replaced: usize,
    /// Why its displacement cannot be known; null where it is.
    pub unusable: Option<String>,
}

/// State at the end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FinalState {
    /// Position, m; null after a move that is not usable.
    pub position_m: Option<[f64; 3]>,
    /// Its standard uncertainty, m; null without bands.
    pub sigma_m: Option<[f64; 3]>,
    /// Velocity, m/s; null where it is not known.
    pub velocity_mps: Option<[f64; 3]>,
}
