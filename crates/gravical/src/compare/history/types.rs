//! What a history says.

use serde::{Deserialize, Serialize};

use super::super::types::{Agreement, ParameterKind};
use crate::recording::Finding;
use crate::uncertainty::ChiSquare;

/// Several calibrations of one sensor, in order of time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct History {
    /// The calibrations.
    pub entries: Vec<HistoryEntry>,
    /// Number of those that are tested.
    pub tested: usize,
    /// The mean of the tested ones, weighted by their covariances; empty for less than two.
    pub mean: Vec<HistoryParameter>,
    /// What changes ‖a‖: bias, scale and angles between the axes; null for less than two.
    pub magnitude: Option<ChangeTest>,
    /// The same with all scales brought to the gravity of the last calibration; null when gravity
    /// is the same already.
    pub magnitude_at_one_gravity: Option<ChangeTest>,
    /// Rotation of the frame.
    pub orientation: Option<ChangeTest>,
    /// What has to be known to read the result.
    pub findings: Vec<Finding>,
    /// The judgement.
    pub verdict: HistoryVerdict,
}

/// A calibration of a history.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HistoryEntry {
    /// Its name, as given.
    pub name: String,
    /// Why it is not tested; null if it is.
    pub not_tested: Option<String>,
    /// Bias (m/s²), deviation of the scale from nominal (%), angles between the axes beyond 90°
    /// and rotation of the frame relative to the first tested calibration (°). Without a
    /// covariance there are no standard deviations; empty if the unit cannot be converted.
    pub parameters: Vec<HistoryParameter>,
    /// The test against the tested calibration before it, as by `compare`; null for the first.
    pub since_previous: Option<SincePrevious>,
}

/// A parameter of one calibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HistoryParameter {
    /// `bias_x` … `scale_z`, `angle_xy` …, `rotation_x` ….
    pub name: String,
    /// Which part it belongs to.
    pub kind: ParameterKind,
    /// `m/s^2`, `%` or `deg`.
    pub unit: String,
    /// The value.
    pub value: f64,
    /// Its standard deviation, with that of gravity; null without a covariance.
    pub sigma: Option<f64>,
    /// Interval of 95 %; null without a covariance.
    pub interval_95: Option<[f64; 2]>,
}

/// The difference from the calibration before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SincePrevious {
    /// Name of that calibration.
    pub name: String,
    /// Test of what changes ‖a‖.
    pub magnitude: Option<ChiSquare>,
    /// Test of the rotation.
    pub orientation: Option<ChiSquare>,
    /// Judgement on these two alone.
    pub judgement: Agreement,
}

/// Test of a change over all calibrations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChangeTest {
    /// χ² of all calibrations about their weighted mean.
    pub whole: ChiSquare,
    /// The step that explains most.
    pub step: Option<StepTest>,
    /// Probability of both together by chance, if nothing changed: twice the smaller one, that of
    /// the steps multiplied by their number (Bonferroni). That of `whole` for two calibrations.
    pub p_value: f64,
}

/// A step between two calibrations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StepTest {
    /// Name of the last calibration before it.
    pub after: String,
    /// Name of the first one behind it.
    pub until: String,
    /// χ² of the difference of the means on both sides.
    pub test: ChiSquare,
    /// The parameter that changed most, by its standard deviation: the mean after the step less
    /// the mean before.
    pub largest: HistoryParameter,
}

/// Whether a sensor changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Stability {
    /// No change beyond the uncertainty.
    Unchanged,
    /// It changed by more than the uncertainty.
    Changed,
    /// Less than two calibrations can be tested.
    Undecided,
}

impl Stability {
    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Stability::Unchanged => "unchanged",
            Stability::Changed => "changed",
            Stability::Undecided => "undecided",
        }
    }
}

/// The judgement on a history.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HistoryVerdict {
    /// Whether the sensor changed.
    pub judgement: Stability,
    /// Why, one sentence a part.
    pub reasons: Vec<String>,
}
