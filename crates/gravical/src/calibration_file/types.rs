//! What stands in a calibration file, field by field.

use gravical_core::matrix3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::trust::{
    Budget, ContradictedPose, Deviations, FitQuality, NextPose, UndetectedError, WorstDirection,
    WorstPose,
};
use super::{InputFile, TemperatureModel};
use crate::recording::Finding;
use crate::recording::units::{AccelUnit, GyroUnit};

/// A calibration of one sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(title = "gravical-calibration/1")]
pub struct CalibrationFile {
    /// `gravical-calibration/1`.
    pub format: String,
    /// When it was computed, RFC 3339, UTC.
    pub created: String,
    /// Name and version of the program.
    pub tool: String,
    /// Which sensor it belongs to.
    pub sensor: SensorInfo,
    /// Local gravity that the scale rests on, m/s².
    pub gravity_mps2: f64,
    /// How it is known.
    pub gravity_source: GravitySource,
    /// Temperature during the placements, °C.
    pub temperature_c: Option<TemperatureRange>,
    /// Parameters of the accelerometer.
    pub accelerometer: AccelerometerSection,
    /// Parameters of the gyroscope; null when there were no turns.
    pub gyroscope: Option<GyroscopeSection>,
    /// The files it was computed from.
    pub inputs: Vec<InputFile>,
    /// What was odd in them.
    pub findings: Vec<Finding>,
    /// How far to trust it.
    pub verdict: Verdict,
    /// The command that made it, where it was a command.
    #[serde(default)]
    pub command: Option<String>,
    /// How the readings drift with temperature; null where that was not
    /// measured.
    #[serde(default)]
    pub temperature_model: Option<TemperatureModel>,
}

/// Which sensor a calibration belongs to.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensorInfo {
    /// Serial number or name.
    pub id: Option<String>,
    /// Type, such as `MPU6050`.
    pub model: Option<String>,
}

/// How local gravity is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GravitySource {
    /// The user gave it.
    Given,
    /// From latitude and height (WGS 84).
    Latitude,
    /// 9.80665 m/s², for want of better.
    Standard,
}

/// Temperatures of a session, °C.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TemperatureRange {
    /// Mean over the placements.
    pub mean: f64,
    /// Coldest placement.
    pub min: f64,
    /// Warmest placement.
    pub max: f64,
}

/// Parameters of the accelerometer and what they rest on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AccelerometerSection {
    /// `ferraris`, ….
    pub method: String,
    /// Unit of the raw values.
    pub input_unit: AccelUnit,
    /// `m/s^2`.
    pub output_unit: AccelUnit,
    /// Bias, input unit (a zero offset is part of it).
    pub bias: [f64; 3],
    /// calibrated = matrix · (raw − bias), m/s² per input unit, row-major.
    pub matrix: [[f64; 3]; 3],
    /// K of raw = K R a + b: input unit per m/s².
    pub scale: [f64; 3],
    /// R: rows of length one, not orthogonal in general.
    pub orientation: [[f64; 3]; 3],
    /// Covariance of the twelve parameters of raw = M a + b, M = K R; null
    /// where no standard errors are known.
    pub covariance: Option<Covariance>,
    /// Standard uncertainty of local gravity that the covariance holds, m/s²: σ makes
    /// (σ/g)² times the outer product of M's elements. 0 where gravity was given.
    #[serde(default)]
    pub gravity_sd_mps2: f64,
    /// The placements.
    pub positions: Vec<Position>,
    /// Errors over the placements that the parameters were fitted to: no
    /// measure of accuracy.
    pub errors: Option<FitErrors>,
    /// Scale against nominal, %; null where the nominal scale is not known.
    pub scale_deviation_percent: Option<[f64; 3]>,
    /// Measured magnitudes less fitted parameters of the magnitude.
    pub degrees_of_freedom: u32,
    /// Error of ‖a‖ on placements left out of the fit, m/s²; null where what
    /// remains does not determine the parameters.
    pub leave_one_out_rms_mps2: Option<f64>,
    /// Standard uncertainty of ‖a‖ over all directions, m/s², by the
    /// covariance.
    pub predicted_norm_error_mps2: Option<f64>,
    /// The direction in which ‖a‖ is known least.
    #[serde(default)]
    pub worst_direction: Option<WorstDirection>,
    /// What an error of one placement could do unseen; null where there is nothing to
    /// hold placements against.
    #[serde(default)]
    pub undetected: Option<UndetectedError>,
    /// The placement that the others contradict, if one does.
    #[serde(default)]
    pub contradicted: Option<ContradictedPose>,
    /// Tilt of the placements that the uncertainty assumes, degrees (sd of each
    /// of two components).
    pub placement_tilt_deg: Option<PlacementTilt>,
    /// Standard deviations of bias, scale and the angles between the axes.
    #[serde(default)]
    pub deviations: Option<Deviations>,
    /// What the fit shows of itself (joint and magnitude fits).
    #[serde(default)]
    pub fit: Option<FitQuality>,
    /// The placement that the result suffers from most.
    #[serde(default)]
    pub worst_pose: Option<WorstPose>,
    /// Placements that would help most, each after the ones before it.
    #[serde(default)]
    pub next_poses: Vec<NextPose>,
    /// What the uncertainty of ‖a‖ at rest consists of.
    #[serde(default)]
    pub budget: Option<Budget>,
}

/// The accelerometer that changes nothing, of which nothing is known beyond its
/// parameters; its unit is not known.
impl Default for AccelerometerSection {
    fn default() -> Self {
        AccelerometerSection {
            method: String::new(),
            input_unit: AccelUnit::Unknown,
            output_unit: AccelUnit::MetrePerSecondSquared,
            bias: [0.0; 3],
            matrix: matrix3::identity(),
            scale: [1.0; 3],
            orientation: matrix3::identity(),
            covariance: None,
            gravity_sd_mps2: 0.0,
            positions: Vec::new(),
            errors: None,
            scale_deviation_percent: None,
            degrees_of_freedom: 0,
            leave_one_out_rms_mps2: None,
            predicted_norm_error_mps2: None,
            worst_direction: None,
            undetected: None,
            contradicted: None,
            placement_tilt_deg: None,
            deviations: None,
            fit: None,
            worst_pose: None,
            next_poses: Vec::new(),
            budget: None,
        }
    }
}

/// A symmetric matrix with the names of its rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Covariance {
    /// `m_xx, m_xy, … m_zz, bias_x, bias_y, bias_z`; m in input unit per m/s²,
    /// bias in input unit.
    pub parameters: Vec<String>,
    /// Rows.
    pub values: Vec<Vec<f64>>,
}

impl Covariance {
    /// Names of the twelve parameters.
    #[must_use]
    pub fn parameter_names() -> Vec<String> {
        let axes = ["x", "y", "z"];
        let elements = axes
            .iter()
            .flat_map(|r| axes.iter().map(move |c| format!("m_{r}{c}")));
        elements
            .chain(axes.iter().map(|a| format!("bias_{a}")))
            .collect()
    }
}

/// Whether a placement had a known face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PositionKind {
    /// One axis up or down.
    Face,
    /// Any direction.
    Free,
}

/// One placement of the sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Position {
    /// `+x` … for faces, else its own name.
    pub label: String,
    /// Face or free.
    pub kind: PositionKind,
    /// The file or files it is from.
    pub source: String,
    /// Rows that the mean is over.
    pub rows: u64,
    /// First and last line of the file that they stand in.
    #[serde(default)]
    pub lines: Option<[u64; 2]>,
    /// Mean reading, input unit.
    pub raw: [f64; 3],
    /// What an ideal sensor reads there, m/s²; for a free position the
    /// calibrated direction at the length of gravity.
    pub expected: [f64; 3],
    /// Calibrated mean, m/s².
    pub calibrated: [f64; 3],
    /// calibrated − expected, m/s².
    pub error: [f64; 3],
    /// Its length.
    pub error_norm: f64,
    /// Tilt off the face, degrees; null for free positions. Fitted by `joint`;
    /// by `ferraris` the angle of the raw mean: placement, bias and misalignment
    /// together.
    pub tilt_deg: Option<f64>,
    /// Standard deviation of a fitted tilt, degrees (each of two components).
    #[serde(default)]
    pub tilt_sd_deg: Option<f64>,
    /// ‖calibrated‖ − gravity, m/s².
    #[serde(default)]
    pub magnitude_error_mps2: Option<f64>,
    /// The same with this position and those within 25° of it left out of the
    /// fit; null where the rest determines too little.
    #[serde(default)]
    pub left_out_error_mps2: Option<f64>,
    /// Standard deviation that this error should have, by the covariance of the
    /// fit without them and the noise of the mean, m/s²; null where the method
    /// does not say.
    #[serde(default)]
    pub left_out_sd_mps2: Option<f64>,
    /// False when it took no part in the fit.
    #[serde(default = "yes")]
    pub fitted: bool,
}

impl Position {
    /// By its label and lines: a face may occur several times.
    pub(crate) fn called(&self) -> String {
        match self.lines {
            Some([first, last]) => format!("{} in lines {first}-{last}", self.label),
            None => self.label.clone(),
        }
    }
}

fn yes() -> bool {
    true
}

/// The three error figures of the classical report, over the fitted faces.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FitErrors {
    /// Root mean square over all components of all faces, m/s².
    pub rms: f64,
    /// Largest absolute component, m/s².
    pub max: f64,
    /// Mean of the error norms, m/s².
    pub mean_norm: f64,
}

/// A placement tilt and how it is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlacementTilt {
    /// Standard deviation of each of the two components, degrees.
    pub value: f64,
    /// How it is known.
    pub source: TiltSource,
}

/// How the placement tilt is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TiltSource {
    /// The user said so.
    Given,
    /// From the data.
    Estimated,
    /// The usual value of a box on a table.
    Assumed,
}

/// Parameters of the gyroscope.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GyroscopeSection {
    /// `turns`: from three known turns (Ferraris); `motion`: from the motions
    /// between stills; `bias`: the bias alone, with the nominal matrix.
    #[serde(default = "turns")]
    pub method: String,
    /// Unit of the raw values.
    pub input_unit: GyroUnit,
    /// `rad/s`.
    pub output_unit: GyroUnit,
    /// Bias, input unit.
    pub bias: [f64; 3],
    /// calibrated = matrix · (raw − bias − g_sensitivity · a), rad/s per input
    /// unit.
    pub matrix: [[f64; 3]; 3],
    /// K_g, input unit per rad/s.
    pub scale: [f64; 3],
    /// R_g.
    pub orientation: [[f64; 3]; 3],
    /// Input unit per m/s².
    pub g_sensitivity: [[f64; 3]; 3],
    /// Covariance of raw = M ω + b, M = K R, or of b alone; null where it is
    /// not known.
    #[serde(default)]
    pub covariance: Option<Covariance>,
    /// How far gravity, turned by the integrated rate, is off after the motions
    /// that were fitted: root mean square length of the difference of unit
    /// vectors.
    #[serde(default)]
    pub residual: Option<f64>,
    /// The same as an angle, degrees.
    #[serde(default)]
    pub residual_deg: Option<f64>,
    /// The motions between stills.
    #[serde(default)]
    pub motions: Option<MotionCounts>,
    /// The angle for motions that are left out of the fit one by one, rms,
    /// degrees; null where what remains does not determine the parameters.
    #[serde(default)]
    pub leave_one_out_deg: Option<f64>,
}

/// The gyroscope that changes nothing, for want of better; its unit is not known.
impl Default for GyroscopeSection {
    fn default() -> Self {
        GyroscopeSection {
            method: turns(),
            input_unit: GyroUnit::Unknown,
            output_unit: GyroUnit::RadianPerSecond,
            bias: [0.0; 3],
            matrix: matrix3::identity(),
            scale: [1.0; 3],
            orientation: matrix3::identity(),
            g_sensitivity: [[0.0; 3]; 3],
            covariance: None,
            residual: None,
            residual_deg: None,
            motions: None,
            leave_one_out_deg: None,
        }
    }
}

/// The method of files that do not name one.
fn turns() -> String {
    "turns".to_owned()
}

/// Motions between stills that a gyroscope was fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct MotionCounts {
    /// Motions in the fit.
    pub used: u32,
    /// Motions with a gap, with clipped samples, or that contradict the others.
    pub left_out: u32,
}

/// How far a calibration can be trusted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verdict {
    /// The grade.
    pub grade: Grade,
    /// Why.
    pub reasons: Vec<String>,
}

/// Grades of a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Grade {
    /// Verified on data that were left out, and accurate.
    Good,
    /// Verified, less accurate.
    Fair,
    /// Something is wrong; the reasons say what.
    Poor,
    /// Nothing that was left out of the fit verifies it.
    NotVerifiable,
}

impl Grade {
    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Grade::Good => "good",
            Grade::Fair => "fair",
            Grade::Poor => "poor",
            Grade::NotVerifiable => "not verifiable",
        }
    }
}
