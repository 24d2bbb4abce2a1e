//! What a check says.

use serde::{Deserialize, Serialize};

use crate::calibration_file::{GravitySource, TemperatureRange};
use crate::recording::Finding;
use crate::recording::units::GyroUnit;
pub use crate::uncertainty::ChiSquare;

/// A calibration held against still readings that it was not made from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CheckReport {
    /// The calibration as it was given.
    pub calibration: String,
    /// The recordings as they were given.
    pub recordings: Vec<String>,
    /// What ‖a‖ has to be at rest, m/s².
    pub gravity_mps2: f64,
    /// How it is known; of the calibration where none was given here.
    pub gravity_source: GravitySource,
    /// True when gravity is the calibration's, for want of another.
    pub gravity_of_calibration: bool,
    /// The stills, in the order of the recordings.
    pub static_intervals: Vec<StillCheck>,
    /// Root mean square of the errors of the stills that count, m/s².
    pub rms_mps2: f64,
    /// What the uncertainty predicts for it, m/s²; null without a covariance.
    pub predicted_rms_mps2: Option<f64>,
    /// Index of the still with the largest |z|, or error where there is no z.
    pub worst: usize,
    /// All stills together, with the errors that they share.
    pub test: Option<ChiSquare>,
    /// p of the likeliest single fault (one share for all, one bias), corrected
    /// for how many were looked for.
    pub single_fault_p_value: Option<f64>,
    /// What the verdict rests on: twice the smaller of both, 1 at most.
    pub p_value: Option<f64>,
    /// Which directions were tested, and which were not.
    pub coverage: Coverage,
    /// What would explain the errors; empty when they need no explanation.
    pub explanations: Vec<Explanation>,
    /// The gyroscope at rest; null where file or recording has none.
    pub gyroscope: Option<GyroscopeCheck>,
    /// Temperature of the calibration, °C.
    pub calibration_temperature_c: Option<TemperatureRange>,
    /// What is odd.
    pub findings: Vec<Finding>,
    /// The judgement.
    pub verdict: CheckVerdict,
}

/// One still.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StillCheck {
    /// The file.
    pub file: String,
    /// Label of a placement that was named; null for a still that was found.
    pub label: Option<String>,
    /// First and last line of the file.
    pub lines: [u64; 2],
    /// Seconds from the start of the recording; null without a rate.
    pub start_s: Option<f64>,
    /// Rows that the mean is over.
    pub rows: u64,
    /// Mean reading, input unit of the calibration; at the reference temperature
    /// where the calibration has a temperature model.
    pub raw: [f64; 3],
    /// The same, calibrated, in axes of the case, m/s².
    pub calibrated: [f64; 3],
    /// Its length, m/s².
    pub norm_mps2: f64,
    /// The axis that is nearest to up: `+x` ….
    pub nearest: String,
    /// Angle to it, degrees.
    pub face_angle_deg: f64,
    /// ‖a‖ − g, m/s².
    pub error_mps2: f64,
    /// The same in thousandths of standard gravity.
    pub error_mg: f64,
    /// Standard deviation of the error that the calibration predicts here,
    /// m/s²; null without a covariance.
    pub sigma_calibration_mps2: Option<f64>,
    /// Standard deviation by the noise of the mean and the floor, m/s².
    pub sigma_reading_mps2: f64,
    /// All of it, model error included, m/s².
    pub sigma_mps2: Option<f64>,
    /// error / sigma.
    pub z: Option<f64>,
    /// Mean temperature, °C.
    pub temperature_c: Option<f64>,
    /// Samples at the end of the range.
    pub clipped: u64,
    /// Whether it counts: not with clipped samples, nor where the calibration was fitted to it,
    /// unless no other is left.
    pub counts: bool,
}

/// Directions that the stills cover.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Coverage {
    /// Directions more than 25° from each other.
    pub directions: u32,
    /// Axes that no still has within 60°, case: `x` ….
    pub untested_axes: Vec<String>,
    /// Axes that were up or down only: bias and scale are not distinguished there.
    pub one_way_axes: Vec<String>,
    /// The same for people.
    pub text: String,
}

/// One thing that would explain the errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Explanation {
    /// What it is.
    pub cause: Cause,
    /// Change of the bias in calibrated axes of the board, m/s²; null for the
    /// scale.
    pub bias_mps2: Option<[f64; 3]>,
    /// Change of the scale or of gravity, %; null for a bias.
    pub share_percent: Option<f64>,
    /// Standard deviation of the change (m/s² or %); of the biases of three axes the largest.
    pub sigma: f64,
    /// p of what is left when it is taken off; null when nothing is left to
    /// test.
    pub p_value_left: Option<f64>,
    /// True when it is more than nothing, and what is left is within the
    /// uncertainty.
    pub explains: bool,
}

/// Causes of errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// All stills are off by one share: scale or local gravity.
    Share,
    /// Bias of x.
    BiasX,
    /// Bias of y.
    BiasY,
    /// Bias of z.
    BiasZ,
    /// Biases of all three axes.
    Bias,
}

/// The gyroscope at rest, where it has to read zero.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GyroscopeCheck {
    /// Unit of the calibration's bias.
    pub input_unit: GyroUnit,
    /// Calibrated rate at rest, °/s.
    pub rate_deg_s: [f64; 3],
    /// Its standard error, °/s.
    pub standard_error_deg_s: Option<[f64; 3]>,
    /// The bias that would make it zero, input unit.
    pub bias_now: [f64; 3],
    /// What it is judged against, °/s.
    pub limit_deg_s: f64,
    /// The judgement; that of the accelerometer does not depend on it.
    pub judgement: Judgement,
}

/// The judgement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CheckVerdict {
    /// In a word.
    pub judgement: Judgement,
    /// Why.
    pub reasons: Vec<String>,
}

/// Does it fit?
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Judgement {
    /// Within what its uncertainty allows.
    Fits,
    /// Off by more.
    DoesNotFit,
    /// Nothing tells.
    Undecided,
}

impl Judgement {
    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Judgement::Fits => "fits",
            Judgement::DoesNotFit => "does not fit",
            Judgement::Undecided => "undecided",
        }
    }
}
