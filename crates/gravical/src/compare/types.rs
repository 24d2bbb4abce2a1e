//! What a comparison says.

use serde::{Deserialize, Serialize};

use crate::calibration_file::TemperatureRange;
use crate::recording::Finding;
pub use crate::uncertainty::ChiSquare;

/// Two calibrations, compared. A is the first one, B the second; every
/// difference is B − A.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Comparison {
    /// The files as they were given.
    pub files: [String; 2],
    /// Gravity that each scale rests on, m/s².
    pub gravity_mps2: [f64; 2],
    /// Temperatures of the two sessions, °C.
    pub temperature_c: [Option<TemperatureRange>; 2],
    /// The differences, one entry a parameter.
    pub parameters: Vec<ParameterDifference>,
    /// What changes ‖a‖: bias, scale and the angles between the sensor's axes.
    pub magnitude: MagnitudeDifference,
    /// How the frames are turned against each other; null when one is the
    /// mirror image of the other.
    pub orientation: Option<OrientationDifference>,
    /// Bias and scale of the gyroscopes; null unless both files have one.
    pub gyroscope: Option<GyroscopeDifference>,
    /// What has to be known to read the result.
    pub findings: Vec<Finding>,
    /// The judgement.
    pub verdict: CompareVerdict,
}

/// One parameter of both calibrations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ParameterDifference {
    /// `bias_x` … `scale_z`, `angle_xy` …, `rotation_x` ….
    pub name: String,
    /// Which part it belongs to.
    pub kind: ParameterKind,
    /// `m/s^2` for the bias, `%` of nominal for the scale, `deg` for angles.
    pub unit: String,
    /// Value in A; null for the rotation, which is between the two.
    pub a: Option<f64>,
    /// Value in B.
    pub b: Option<f64>,
    /// B − A.
    pub difference: f64,
    /// Its standard deviation by both covariances; null without them.
    pub sigma: Option<f64>,
    /// difference / sigma; null where sigma is zero or not known.
    pub z: Option<f64>,
}

/// Kinds of parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ParameterKind {
    /// Bias of an axis.
    Bias,
    /// Length of a row of M.
    Scale,
    /// Angle between two of the sensor's axes, beyond 90°.
    Misalignment,
    /// Component of the rotation of the frame.
    Orientation,
}

/// One judgement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Agreement {
    /// No difference beyond the uncertainty.
    Agree,
    /// They differ by more than their uncertainty.
    Differ,
    /// Nothing tells.
    Undecided,
}

impl Agreement {
    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Agreement::Agree => "agree",
            Agreement::Differ => "differ",
            Agreement::Undecided => "undecided",
        }
    }
}

/// The part that changes the length of what is measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MagnitudeDifference {
    /// χ² of the nine parameters.
    pub test: Option<ChiSquare>,
    /// The same with both scales brought to one gravity; null when gravity is
    /// the same already.
    pub test_at_one_gravity: Option<ChiSquare>,
    /// The judgement.
    pub judgement: Agreement,
    /// Root mean square over all directions of ‖a‖ by B less ‖a‖ by A for the
    /// same reading at rest, m/s².
    pub norm_rms_mps2: f64,
    /// Where it is largest: the difference with its sign, m/s².
    pub norm_largest_mps2: f64,
    /// In this direction (calibrated axes of A).
    pub largest_at: [f64; 3],
    /// What the two uncertainties predict for the RMS, m/s².
    pub predicted_rms_mps2: Option<f64>,
    /// What they predict where it is largest, m/s².
    pub predicted_at_largest_mps2: Option<f64>,
}

/// The part that changes the direction of what is measured and not its length.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OrientationDifference {
    /// Angle by which the frame of B is turned against that of A, degrees.
    pub angle_deg: f64,
    /// About this axis; zero for no turn.
    pub axis: [f64; 3],
    /// χ² of the three components of the rotation vector.
    pub test: Option<ChiSquare>,
    /// The judgement.
    pub judgement: Agreement,
}

/// The gyroscopes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GyroscopeDifference {
    /// Bias in A as an angular rate about the axes of the case, °/s.
    pub bias_a_deg_s: [f64; 3],
    /// Bias in B, °/s.
    pub bias_b_deg_s: [f64; 3],
    /// B − A, °/s.
    pub bias_difference_deg_s: [f64; 3],
    /// Scale of each channel of B against A, %; null where the input units differ.
    pub scale_difference_percent: Option<[f64; 3]>,
}

/// Whether the two calibrations say the same.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CompareVerdict {
    /// The judgement of both parts together.
    pub judgement: Agreement,
    /// Why, one sentence a part.
    pub reasons: Vec<String>,
}
