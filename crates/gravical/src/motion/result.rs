//! What motion says: the object of `gravical motion --json`, and the columns of
//! its table.

use std::ops::Range;

use serde::Serialize;

use super::hidden::VisibleMove;
use super::misfit::GravityMisfit;
use super::still::Rests;
use crate::recording::Finding;

/// Motion of one recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MotionResult {
    /// The recording as it was given.
    pub input: String,
    /// The calibration as it was given; null without one.
    pub calibration: Option<String>,
    /// What can be determined, and why.
    pub verdict: MotionVerdict,
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
    /// What the axes of velocity and position are.
    pub frame: String,
    /// Where the sensor rested.
    pub rests: Vec<Span>,
    /// Noise at rest; null without a rest.
    pub noise: Option<NoiseAtRest>,
    /// How far a move has to go, by its duration, to be distinguished from rest; empty without a
    /// rest.
    pub visible_moves: Vec<VisibleMove>,
    /// Gravity at the rest at which it is off most, by the calibration; null without a
    /// calibration or a rest.
    pub gravity_misfit: Option<GravityMisfit>,
    /// What lies between the rests.
    pub moves: Vec<Move>,
    /// At the end of the recording, counted from its start.
    pub r#final: FinalState,
    /// The same computed without the calibration; null without one.
    pub uncalibrated: Option<Uncalibrated>,
    /// Open-loop drift; null where the sensor moved.
    pub static_drift: Option<StaticDrift>,
    /// What the standard uncertainty of the final position consists of (root of
    /// the sum of squares over the axes), m; null without bands.
    pub budget_m: Option<PositionBudget>,
    /// Comparison with a reference; null without one.
    pub truth: Option<Comparison>,
    /// What is odd.
    pub findings: Vec<Finding>,
}

/// The verdict on a motion, with its reasons.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MotionVerdict {
    /// In a word.
    pub judgement: MotionJudgement,
    /// Why.
    pub reasons: Vec<String>,
}

/// The verdict in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum MotionJudgement {
    /// Every move is between two rests, which limits the drift.
    Bounded,
    /// At least one move has a rest at one end only.
    PartlyOpen,
    /// Some moves cannot be used.
    PartlyUsable,
    /// Gravity at rest contradicts the calibration; bands are widened by it.
    CalibrationInDoubt,
    /// No move can be used.
    NotUsable,
    /// No move was found.
    AtRest,
}

impl MotionJudgement {
    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            MotionJudgement::Bounded => "bounded",
            MotionJudgement::PartlyOpen => "partly open",
            MotionJudgement::PartlyUsable => "partly usable",
            MotionJudgement::CalibrationInDoubt => "calibration in doubt",
            MotionJudgement::NotUsable => "not usable",
            MotionJudgement::AtRest => "at rest",
        }
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

impl Span {
    pub(super) fn of(t_s: &[f64], rests: &[Range<usize>]) -> Vec<Self> {
        let span = |r: &Range<usize>| Span {
            start_s: t_s[r.start],
            end_s: t_s[r.end - 1],
        };
        rests.iter().map(span).collect()
    }
}

/// Noise of the samples at rest: σ of one sample, and how much wider a mean
/// scatters since neighbours are alike (variance inflation factor).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NoiseAtRest {
    /// Accelerometer, each axis, m/s².
    pub accel_sigma_mps2: [f64; 3],
    /// Its variance inflation factor.
    pub accel_vif: f64,
    /// Gyroscope, each axis, rad/s.
    pub gyro_sigma_rad_s: Option<[f64; 3]>,
    /// Its variance inflation factor.
    pub gyro_vif: Option<f64>,
}

impl NoiseAtRest {
    pub(super) fn of(rests: &Rests) -> Option<Self> {
        rests.accel.map(|a| NoiseAtRest {
            accel_sigma_mps2: a.sigma,
            accel_vif: a.vif,
            gyro_sigma_rad_s: rests.gyro.map(|g| g.sigma),
            gyro_vif: rests.gyro.map(|g| g.vif),
        })
    }
}

/// How velocity is tied down at the ends of a move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ends {
    /// A rest before and after.
    RestToRest,
    /// A rest before; the recording ends in motion, or zero velocity is off.
    FromRest,
    /// A rest after; the recording starts in motion.
    ToRest,
    /// No rest at either end.
    Free,
}

/// One move.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Move {
    /// Its start, s.
    pub start_s: f64,
    /// Its end, s.
    pub end_s: f64,
    /// What lies at its ends.
    pub ends: Ends,
    /// From its own start to its own end, m; null where something is missing in it, or its
    /// attitude is not known. Without a rest to believe it is given, though it is not usable.
    pub displacement_m: Option<[f64; 3]>,
    /// Standard uncertainty of it, m; null without bands.
    pub sigma_m: Option<[f64; 3]>,
    /// The displacement computed without the calibration, m; null without one.
    pub uncalibrated_m: Option<[f64; 3]>,
    /// Highest speed, m/s; null where something is missing in it, or its attitude is not known.
    pub peak_speed_mps: Option<f64>,
    /// Length of the path: the integral of the speed, m; null where the peak is.
    pub path_m: Option<f64>,
    /// Velocity that the zero-velocity correction took off at its end, m/s; null
    /// where nothing was taken off.
    pub velocity_error_mps: Option<[f64; 3]>,
    /// Tilt that was missing at the rest after it, degrees; null where there is
    /// none.
    pub levelling_error_deg: Option<f64>,
    /// What was left at its end, velocity or tilt, over its standard uncertainty, of the
    /// axis where that is most: far above 3 something is wrong that the uncertainty does not
    /// know of, and the bands are widened by it. Null without bands, and where there is no
    /// rest at both ends.
    pub closure_sigmas: Option<f64>,
    /// False when its displacement cannot be known: rows are missing in it, or there is no
    /// rest to believe; of the latter what is given is without a band.
    pub usable: bool,
    /// Why it cannot be known, or what it costs that there is no rest at one end.
    pub reason: Option<String>,
}

impl Move {
    /// One of which `gap_s` seconds are missing, or in which the recording is interrupted.
    pub(super) fn lost(start_s: f64, end_s: f64, why: Loss) -> Self {
        Move {
            start_s,
            end_s,
            ends: Ends::Free,
            displacement_m: None,
            sigma_m: None,
            uncalibrated_m: None,
            peak_speed_mps: None,
            path_m: None,
            velocity_error_mps: None,
            levelling_error_deg: None,
            closure_sigmas: None,
            usable: false,
            reason: Some(match why {
                Loss::Gap { seconds } if seconds > 0.0 => {
                    format!("{seconds:.2} s are missing in it: how far it went then is not known")
                }
                Loss::Gap { .. } => {
                    "the recording is interrupted in it: how far it went then is not known".to_owned()
                }
                Loss::Turn { radians } if radians.is_finite() => format!(
                    "it turns faster than the range of the gyroscope, which misses up to {:.0}° of it: the attitude is not known; record at a wider range",
                    radians.to_degrees()
                ),
                Loss::Turn { .. } => {
                    "it turns faster than the range of the gyroscope: the attitude is not known; record at a wider range".to_owned()
                }
            }),
        }
    }
}

/// What is missing in a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Loss {
    /// Samples: the longest gap, s; zero where nothing tells how long it is.
    Gap { seconds: f64 },
    /// A turn faster than the range of the gyroscope: so much of it, rad.
    Turn { radians: f64 },
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

/// The end without the calibration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Uncalibrated {
    /// Position, m.
    pub position_m: Option<[f64; 3]>,
    /// Velocity, m/s.
    pub velocity_mps: Option<[f64; 3]>,
}

/// Drift of a recording in which nothing moves, integrated without zero-velocity
/// correction: with it the drift would be zero by construction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StaticDrift {
    /// Rest that gravity was taken from, s from its start; the drift counts from
    /// there.
    pub levelled_over_s: f64,
    /// How long it drifted, s.
    pub duration_s: f64,
    /// Velocity at the end, m/s.
    pub velocity_mps: [f64; 3],
    /// Position at the end, m.
    pub position_m: [f64; 3],
    /// Standard uncertainty of the position that was predicted, m.
    pub predicted_sigma_m: [f64; 3],
    /// Constant acceleration that explains the drift best, m/s².
    pub bias_mps2: [f64; 3],
    /// Its slope, m/s³.
    pub slope_mps3: [f64; 3],
    /// Position at the end that both together do not explain, m.
    pub unexplained_m: [f64; 3],
}

/// What a standard uncertainty consists of, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PositionBudget {
    /// Noise of the accelerometer.
    pub noise: f64,
    /// Bias of the accelerometer, and what goes along with it in the covariance.
    pub bias: f64,
    /// Scale and cross-axis terms of the accelerometer.
    pub scale: f64,
    /// Clock of the recorder.
    pub clock: f64,
    /// Attitude: noise, bias and scale of the gyroscope, levelling, yaw.
    pub tilt: f64,
}

/// Comparison with a reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The reference as it was given.
    pub source: String,
    /// Distance at the end, m.
    pub end_error_m: f64,
    /// Root mean square distance, m.
    pub rmse_m: f64,
    /// End error over the length of the reference's path, %; null where it hardly
    /// moves.
    pub percent_of_path: Option<f64>,
    /// Length of the reference's path over means of 0.1 s, m.
    pub path_m: f64,
    /// First time at which both are known, s: there both start at 0.
    pub from_s: f64,
    /// Last time at which both are known, s: the end error is the distance there.
    pub to_s: f64,
    /// Added to the reference's stamps, s.
    pub time_offset_s: f64,
    /// By what the reference was turned about the vertical into the frame of the result, degrees.
    pub yaw_deg: f64,
    /// Its moves one by one; those that the reference does not see are left out.
    pub moves: Vec<MoveComparison>,
    /// Points compared.
    pub points: u64,
}

/// One move beside the reference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MoveComparison {
    /// Start of the move, s.
    pub start_s: f64,
    /// Its end, s.
    pub end_s: f64,
    /// Error of its displacement, m.
    pub end_error_m: [f64; 3],
    /// Its standard uncertainty, m; null without bands.
    pub sigma_m: Option<[f64; 3]>,
    /// Root mean square distance within it, both starting at 0, m.
    pub rmse_m: f64,
}

/// One sample of a motion. What is not known is NaN.
#[derive(Debug, Clone, Copy)]
pub struct MotionSample {
    /// Time, s.
    pub t_s: f64,
    /// Specific force by the nominal scale alone, m/s².
    pub raw_mps2: [f64; 3],
    /// Specific force, calibrated (and smoothed, where asked for), m/s².
    pub force_mps2: [f64; 3],
    /// At rest.
    pub still: bool,
    /// Attitude w, x, y, z, sensor → frame (Hamilton).
    pub attitude: [f64; 4],
    /// Acceleration in the frame, gravity taken off, m/s².
    pub acceleration_mps2: [f64; 3],
    /// Velocity, m/s.
    pub velocity_mps: [f64; 3],
    /// Position, m.
    pub position_m: [f64; 3],
    /// Standard uncertainty of the velocity, m/s.
    pub sigma_velocity_mps: [f64; 3],
    /// Standard uncertainty of the position, m.
    pub sigma_position_m: [f64; 3],
}

/// Where the samples of a motion go, one by one and in order.
pub trait MotionSink {
    /// Before the first of them: the times of all, s, the samples before which others
    /// are missing, and whether there are bands.
    fn begin(&mut self, t_s: &[f64], breaks: &[usize], bands: bool);

    /// The next sample.
    fn sample(&mut self, sample: &MotionSample);
}

/// What the table holds, sample by sample; all columns are equally long. Where a
/// value is not known it is NaN.
#[derive(Debug, Clone, Default)]
pub struct Track {
    /// Time, s.
    pub t_s: Vec<f64>,
    /// Samples before which others are missing, or the recording is parted.
    pub breaks: Vec<usize>,
    /// Specific force by the nominal scale alone, m/s².
    pub raw_mps2: [Vec<f64>; 3],
    /// Specific force, calibrated (and smoothed, where asked for), m/s².
    pub force_mps2: [Vec<f64>; 3],
    /// There are bands.
    pub bands: bool,
    /// At rest.
    pub still: Vec<bool>,
    /// Attitude w, x, y, z, sensor → frame (Hamilton).
    pub attitude: Vec<[f64; 4]>,
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
    /// The same without the calibration; none without one, or where
    /// [`keep_uncalibrated`](super::MotionOptions::keep_uncalibrated) is off.
    pub uncalibrated: Option<UncalibratedTrack>,
    /// The reference that it was compared with; none without one.
    pub reference: Option<ReferenceTrack>,
    /// Open-loop drift of a recording in which nothing moved; none where it moved,
    /// or where [`keep_uncalibrated`](super::MotionOptions::keep_uncalibrated) is
    /// off.
    pub static_drift: Option<DriftTrack>,
}

impl Track {
    /// The sample at place `i`.
    pub(super) fn at(&self, i: usize) -> MotionSample {
        let unknown = [f64::NAN; 3];
        MotionSample {
            t_s: self.t_s[i],
            raw_mps2: self.raw_mps2.each_ref().map(|c| c[i]),
            force_mps2: self.force_mps2.each_ref().map(|c| c[i]),
            still: self.still[i],
            attitude: self.attitude[i],
            acceleration_mps2: self.acceleration_mps2[i],
            velocity_mps: self.velocity_mps[i],
            position_m: self.position_m[i],
            sigma_velocity_mps: self.sigma_velocity_mps.get(i).copied().unwrap_or(unknown),
            sigma_position_m: self.sigma_position_m.get(i).copied().unwrap_or(unknown),
        }
    }
}

impl MotionSink for Track {
    fn begin(&mut self, t_s: &[f64], breaks: &[usize], bands: bool) {
        self.breaks = breaks.to_vec();
        self.bands = bands;
        // No more than that: of a long recording they are most of the memory.
        let rows = t_s.len();
        self.still.reserve_exact(rows);
        self.attitude.reserve_exact(rows);
        let three = self.raw_mps2.iter_mut().chain(&mut self.force_mps2);
        three
            .chain([&mut self.t_s])
            .for_each(|column| column.reserve_exact(rows));
        let vectors = [
            &mut self.acceleration_mps2,
            &mut self.velocity_mps,
            &mut self.position_m,
        ];
        let sigmas = [&mut self.sigma_velocity_mps, &mut self.sigma_position_m];
        let sigmas = sigmas.into_iter().filter(|_| bands);
        vectors
            .into_iter()
            .chain(sigmas)
            .for_each(|column| column.reserve_exact(rows));
    }

    fn sample(&mut self, sample: &MotionSample) {
        self.t_s.push(sample.t_s);
        for i in 0..3 {
            self.raw_mps2[i].push(sample.raw_mps2[i]);
            self.force_mps2[i].push(sample.force_mps2[i]);
        }
        self.still.push(sample.still);
        self.attitude.push(sample.attitude);
        self.acceleration_mps2.push(sample.acceleration_mps2);
        self.velocity_mps.push(sample.velocity_mps);
        self.position_m.push(sample.position_m);
        if self.bands {
            self.sigma_velocity_mps.push(sample.sigma_velocity_mps);
            self.sigma_position_m.push(sample.sigma_position_m);
        }
    }
}

/// A reference on the clock and in the frame of the result, where both are known.
#[derive(Debug, Clone, Default)]
pub struct ReferenceTrack {
    /// Time, s.
    pub t_s: Vec<f64>,
    /// Position, m; it starts where the result is at that time.
    pub position_m: Vec<[f64; 3]>,
}

/// Drift from a rest on without zero-velocity correction, point by point: thousands
/// of them at the most, evenly taken.
#[derive(Debug, Clone, Default)]
pub struct DriftTrack {
    /// Time since the rest, s.
    pub t_s: Vec<f64>,
    /// Position, m.
    pub position_m: Vec<[f64; 3]>,
    /// Standard uncertainty of it that was predicted, m.
    pub sigma_m: Vec<[f64; 3]>,
    /// Position without the calibration, m; empty without one.
    pub uncalibrated_m: Vec<[f64; 3]>,
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
