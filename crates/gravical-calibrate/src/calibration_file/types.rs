//! Fields of a calibration file.

use gravical_fit::{Explained, FitQuality, Grade, NextPose, Undetected, WorstDirection};
use gravical_judge::utc::UtcTime;
use serde::{Deserialize, Serialize};

use super::input::InputFile;
use crate::recording::Finding;
use crate::recording::units::{AccelUnit, GyroUnit};

/// Value of `format`.
pub const FORMAT: &str = "gravical-calibration/3";

/// A calibration of one sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(title = "gravical-calibration/3"))]
// Written and read by `readable`.
#[serde(remote = "Self")]
pub struct Calibration {
    /// `gravical-calibration/3`.
    pub format: String,
    /// Time of the computation, RFC 3339, UTC.
    pub created: String,
    /// Name and version of the program.
    pub tool: String,
    /// When the session was recorded; absent if neither the recordings nor the user said so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recorded: Option<RecordingTime>,
    /// The sensor it belongs to.
    pub sensor: SensorInfo,
    /// Local gravity that the scale is based on, m/s².
    pub gravity_mps2: f64,
    /// Source of the gravity.
    pub gravity_source: GravitySource,
    /// Standard uncertainty of local gravity that is included in the covariance, m/s²: σ
    /// contributes (σ/g)² times the outer product of M's elements. 0 if gravity was given.
    pub gravity_sd_mps2: f64,
    /// Temperature during the poses, °C.
    pub temperature_c: Option<TemperatureRange>,
    /// Parameters of the accelerometer.
    pub accelerometer: Accelerometer,
    /// Parameters of the gyroscope; null without a gyroscope, or where its scale is not known.
    pub gyroscope: Option<Gyroscope>,
    /// How far the accelerometer can be trusted.
    pub reliability: Reliability,
    /// The poses.
    pub poses: Vec<PoseResult>,
    /// Drift of the readings with temperature; null if it was not measured.
    pub drift: Option<TemperatureModel>,
    /// The input files.
    pub inputs: Vec<InputFile>,
    /// Faults found in them.
    pub findings: Vec<Finding>,
    /// The command that computed it, if it was a command.
    pub command: Option<String>,
}

/// When a session was recorded: given, else the first time stamp, else the start stated above the header; a date
/// without a zone is UTC.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RecordingTime {
    /// The time, RFC 3339, UTC.
    pub time: UtcTime,
}

/// The sensor that a calibration belongs to.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorInfo {
    /// Serial number or name.
    pub id: Option<String>,
    /// Type, such as `MPU6050`.
    pub model: Option<String>,
}

/// Source of the local gravity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum GravitySource {
    /// Given by the user.
    Given,
    /// Computed from latitude and height (WGS 84).
    Latitude,
    /// 9.80665 m/s², assumed.
    Standard,
}

/// Temperatures of a session, °C.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TemperatureRange {
    /// Mean over the poses.
    pub mean: f64,
    /// Coldest pose.
    pub min: f64,
    /// Warmest pose.
    pub max: f64,
}

impl TemperatureRange {
    /// Of some temperatures, if there are any.
    #[doc(hidden)]
    pub fn of(t_c: impl Iterator<Item = f64>) -> Option<TemperatureRange> {
        let (mut sum, mut count) = (0.0, 0.0);
        let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
        for t in t_c {
            (sum, count) = (sum + t, count + 1.0);
            (min, max) = (t.min(min), t.max(max));
        }
        let mean = sum / count;
        (count > 0.0).then_some(TemperatureRange { mean, min, max })
    }

    /// From the lowest to the highest, °C.
    #[doc(hidden)]
    pub fn span_c(&self) -> f64 {
        self.max - self.min
    }
}

/// Parameters of the accelerometer and their basis.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
// Written and read by `readable`.
#[serde(remote = "Self")]
pub struct Accelerometer {
    /// How it was estimated.
    pub method: Method,
    /// Unit of the raw values.
    pub input_unit: AccelUnit,
    /// Bias, input unit (includes a zero offset).
    pub bias: [f64; 3],
    /// calibrated = matrix · (raw − bias), m/s² per input unit, row-major.
    pub matrix: [[f64; 3]; 3],
    /// Covariance of the twelve parameters of raw = M a + b, M = K R, and of the six nonlinearity coefficients if they
    /// were fitted; null if no standard errors are known.
    pub covariance: Option<Covariance>,
    /// Nonlinear response of the axes, not applied: what it adds to ‖a‖ as a share of g at 1 g,
    /// quadratic x, y, z, then cubic; null if it was not fitted.
    pub nonlinearity: Option<[f64; 6]>,
    /// Nominal scale, input unit per m/s²; null if it is unknown.
    #[serde(default)]
    pub nominal_scale: Option<f64>,
}

/// How far an accelerometer can be trusted, in numbers; the verdict follows from them, the findings, the poses and the
/// covariance.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Reliability {
    /// Standard uncertainty of ‖a‖ over all directions, m/s², from the covariance.
    pub predicted_mps2: Option<f64>,
    /// The direction in which ‖a‖ is least certain.
    pub worst_direction: Option<WorstDirection>,
    /// What explains that the poses contradict each other, where noise does not, the likeliest first. The error in the
    /// worst direction holds whichever it is.
    pub explanations: Vec<Explained>,
    /// Error of ‖a‖ at poses left out of the fit, m/s² rms; null if the remaining poses do not
    /// determine the parameters.
    pub left_out_rms_mps2: Option<f64>,
    /// Effect of an undetected error of one pose; null without redundancy.
    pub undetected: Option<Undetected>,
    /// Tilt of the poses assumed in the uncertainty, degrees (standard deviation of each of two
    /// components).
    pub pose_tilt_deg: Option<PoseTilt>,
    /// Quality of the fit; null for the closed form.
    pub fit: Option<FitQuality>,
    /// Poses that lower the predicted error most, each after the ones before it.
    pub next_poses: Vec<NextPose>,
    /// What the uncertainty of ‖a‖ at rest consists of.
    pub budget: Option<Budget>,
}

/// How an accelerometer was estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Method {
    /// Faces and free poses in one fit that allows for tilted faces.
    #[default]
    Joint,
    /// Six faces in closed form.
    Ferraris,
    /// By another program, in a way that its file does not tell.
    #[cfg_attr(feature = "clap", value(skip))]
    Unknown,
}

/// A symmetric matrix with the names of its rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Covariance {
    /// `m_xx, m_xy, … m_zz, bias_x, bias_y, bias_z`, and for a fit `nonlinearity_x2 … nonlinearity_z3`; m in input
    /// unit per m/s², bias in input unit, nonlinearity as shares of g.
    pub parameters: Vec<String>,
    /// Rows.
    pub values: Vec<Vec<f64>>,
}

impl Covariance {
    /// Of the twelve parameters, of these and the six nonlinearity coefficients (18), or of the bias alone (3).
    pub fn new<const N: usize>(values: [[f64; N]; N]) -> Self {
        Covariance {
            parameters: Self::names(N),
            values: values.map(|row| row.to_vec()).to_vec(),
        }
    }

    /// Names of the rows of a covariance of this size, 3, 12 or 18; none for another.
    pub fn names(size: usize) -> Vec<String> {
        let rows = [
            "m_x",
            "m_y",
            "m_z",
            "bias_",
            "nonlinearity_",
            "nonlinearity_",
        ];
        let powers = ["", "", "", "", "2", "3"];
        let named = rows.iter().zip(powers);
        let names =
            named.flat_map(|(row, power)| ["x", "y", "z"].map(|a| format!("{row}{a}{power}")));
        let names: Vec<String> = names.collect();
        match size {
            3 => names[9..12].to_vec(),
            12 | 18 => names[..size].to_vec(),
            _ => Vec::new(),
        }
    }
}

/// Whether a pose had a known face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum PoseKind {
    /// One axis up or down.
    Face,
    /// Any direction.
    Free,
}

/// One pose of the sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
// Written and read by `readable`.
#[serde(remote = "Self")]
pub struct PoseResult {
    /// `+x` … for faces, otherwise its name.
    pub label: String,
    /// Face or free.
    pub kind: PoseKind,
    /// The file or files it was measured in.
    pub source: String,
    /// Number of rows in the mean.
    pub rows: u64,
    /// First and last line of these rows in the file.
    pub lines: Option<[u64; 2]>,
    /// Mean reading, input unit.
    pub raw: [f64; 3],
    /// Reading of an ideal sensor, m/s²; for a free pose the calibrated direction with the length
    /// of gravity.
    pub expected: [f64; 3],
    /// Calibrated mean, m/s².
    pub calibrated: [f64; 3],
    /// Tilt from the face, degrees; null for free poses. For `ferraris` the
    /// angle of the raw mean, which combines pose, bias and misalignment.
    pub tilt_deg: Option<f64>,
    /// Standard deviation of a fitted tilt, degrees (each of two components).
    pub tilt_sd_deg: Option<f64>,
    /// ‖calibrated‖ − gravity, m/s².
    pub magnitude_error_mps2: Option<f64>,
    /// The same with this pose and those within 25° of it left out of the fit; null if the
    /// remaining poses do not determine the parameters.
    pub left_out_error_mps2: Option<f64>,
    /// Expected standard deviation of this error, from the covariance of the fit without these
    /// poses and the noise of the mean, m/s²; null if the method does not compute it.
    pub left_out_sd_mps2: Option<f64>,
    /// False if it was not used in the fit.
    #[serde(default = "default_true")]
    pub fitted: bool,
}

impl PoseResult {
    /// Label with lines, since a face can occur several times.
    #[doc(hidden)]
    pub fn called(&self) -> String {
        match self.lines {
            Some([line, last]) if line == last => format!("{} in line {line}", self.label),
            Some([first, last]) => format!("{} in lines {first}-{last}", self.label),
            None => self.label.clone(),
        }
    }
}

fn default_true() -> bool {
    true
}

/// Uncertainty of ‖a‖ at rest, root mean square over all directions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
// Written and read by `readable`.
#[serde(remote = "Self")]
pub struct Budget {
    /// Contributions.
    pub contributions: Vec<Contribution>,
}

/// A contribution to the uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Contribution {
    /// Where it comes from.
    pub source: Source,
    /// Standard uncertainty of ‖a‖, m/s²; null if unknown.
    pub norm_mps2: Option<f64>,
}

/// Source of an uncertainty of ‖a‖.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// Noise of the means.
    Noise,
    /// Rounding of the readings.
    Quantisation,
    /// What the model misses of the readings beyond their noise.
    ModelError,
    /// Nonlinear response that the poses show.
    Nonlinearity,
    /// Tilt of face poses.
    PoseTilt,
    /// Data sheet, where the poses determine less.
    DataSheet,
    /// Noise and tilt together, by the closed form.
    NoiseAndTilt,
    /// Gravity at the place.
    LocalGravity,
    /// Change of temperature during the session.
    Temperature,
}

/// Tilt of the poses and its source.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PoseTilt {
    /// Standard deviation of each of the two components, degrees.
    pub value: f64,
    /// Source of the value.
    pub source: TiltSource,
}

/// Source of the tilt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum TiltSource {
    /// Given by the user.
    Given,
    /// Estimated from the data.
    Estimated,
    /// The usual value for a box on a table.
    Assumed,
}

/// Parameters of the gyroscope.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
// Written and read by `readable`.
#[serde(remote = "Self")]
pub struct Gyroscope {
    /// How it was estimated.
    #[serde(default)]
    pub method: GyroMethod,
    /// Unit of the raw values.
    pub input_unit: GyroUnit,
    /// Bias, input unit.
    pub bias: [f64; 3],
    /// calibrated = matrix · (raw − bias − g_sensitivity · a), rad/s per input
    /// unit.
    pub matrix: [[f64; 3]; 3],
    /// Input unit per m/s².
    pub g_sensitivity: [[f64; 3]; 3],
    /// Covariance of raw = M ω + b, M = K R, or of b alone; null if unknown.
    pub covariance: Option<Covariance>,
    /// Deviation of gravity rotated by the integrated rate after the fitted motions, root mean square,
    /// degrees.
    pub residual_deg: Option<f64>,
    /// The motions between static intervals.
    pub motions: Option<MotionCounts>,
    /// The angle for motions left out of the fit one by one, rms, degrees; null if the remaining
    /// ones do not determine the parameters.
    pub left_out_deg: Option<f64>,
}

/// How a gyroscope was estimated.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum GyroMethod {
    /// From full turns about the three axes (Ferraris).
    #[default]
    Turns,
    /// From the motions between static intervals.
    Motion,
    /// Only the bias, with the nominal matrix.
    Bias,
}

/// Motions between static intervals that a gyroscope was fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MotionCounts {
    /// Motions in the fit.
    pub used: u32,
    /// Motions with a gap, with clipped samples, or inconsistent with the others.
    pub left_out: u32,
}

/// Verdict on the accuracy of a calibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Verdict {
    /// The grade.
    pub grade: Grade,
    /// Reasons.
    pub reasons: Vec<String>,
}

/// Drift of a sensor's readings with its temperature T.
///
/// ```text
/// calibrated = matrix · (raw − drift(T) − bias), drift(T) = per_c · (T − reference_c)
/// ```
///
/// The drift is zero at `reference_c`. Outside `range_c` the value at its nearer edge is used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TemperatureModel {
    /// Temperature at which bias and matrix are valid, °C: the mean of the poses; of a soak alone its middle.
    pub reference_c: f64,
    /// Lowest and highest temperature at which the model was fitted and tested, °C.
    pub range_c: [f64; 2],
    /// Every channel; refused ones have no slope.
    pub channels: Vec<ChannelDrift>,
}

/// Whether the drift of a channel is subtracted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum DriftVerdict {
    /// Each direction predicts the other.
    Corrected,
    /// One direction does not predict the other, or it was not tested.
    #[default]
    NotCorrected,
}

/// Temperature drift of one channel, in the unit of the recording and °C.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChannelDrift {
    /// `ax` … `gz`, axes of the board.
    pub channel: String,
    /// Unit of the recording.
    pub input_unit: String,
    /// Whether it is corrected.
    pub verdict: DriftVerdict,
    /// Reason.
    pub reason: String,
    /// R² on the means while warming of the line fitted to those while cooling; null if it could
    /// not be tested.
    pub r2_cooling_to_warming: Option<f64>,
    /// R² the other way round.
    pub r2_warming_to_cooling: Option<f64>,
    /// Slope, input unit per °C; null if refused.
    pub per_c: Option<f64>,
}

/// Names of the channels, in the order of a row.
pub const CHANNELS: [&str; 6] = ["ax", "ay", "az", "gx", "gy", "gz"];
