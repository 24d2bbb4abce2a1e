//! What stands in a calibration file about its own uncertainty.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Standard deviations (1σ), by the covariance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Deviations {
    /// Of the bias, input unit.
    pub bias: [f64; 3],
    /// Of the scale, input unit per m/s².
    pub scale: [f64; 3],
    /// Of the angles between the sensitive axes xy, yz and zx, degrees.
    pub axis_angle_deg: [f64; 3],
    /// So many of them on either side make an interval of 95 %: Student's t for
    /// what follows from a tilt that was estimated from the same placements, the
    /// largest that any of them needs.
    pub coverage_factor_95: f64,
}

/// What a fit shows of itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FitQuality {
    /// χ² of the readings by the noise of their means, over its degrees of
    /// freedom; null without any. Above 1 the sensor misses the model by more
    /// than noise.
    pub chi2_per_freedom: Option<f64>,
    /// Degrees of freedom of the readings.
    pub freedom: f64,
    /// Standard deviation added to every mean so that χ² is what it should be,
    /// m/s²; it is part of the covariance.
    pub model_error_mps2: f64,
    /// Condition of what the magnitudes alone say of their nine parameters,
    /// columns of length one; null for fewer than nine placements.
    pub condition: Option<f64>,
    /// False when too few faces tell how the frame lies in the case: the matrix
    /// is triangular by convention then.
    pub oriented: bool,
    /// Repeats of faces lay the same way and share their tilt.
    pub shared_tilts: bool,
    /// Components of the tilts that the data determine.
    pub tilt_freedom: f64,
    /// The data sheet took part.
    pub prior: bool,
}

/// The placement that hurts most.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WorstPose {
    /// Its label.
    pub label: String,
    /// Why, with numbers.
    pub reason: String,
}

/// A placement that would help.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NextPose {
    /// Unit vector of specific force: what a calibrated sensor would read there,
    /// over gravity.
    pub direction: [f64; 3],
    /// How to hold the sensor.
    pub hint: String,
    /// Predicted error of ‖a‖ over all directions with it, m/s².
    pub predicted_norm_error_mps2: f64,
    /// What an error of one placement could still do to ‖a‖ unseen with it, in the worst
    /// direction, m/s²; null where nothing is left over to show one.
    #[serde(default)]
    pub undetected_effect_mps2: Option<f64>,
}

/// The direction in which ‖a‖ is known least.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WorstDirection {
    /// Unit vector of specific force.
    pub direction: [f64; 3],
    /// How the sensor is held then.
    pub hint: String,
    /// Standard uncertainty of ‖a‖ there, m/s².
    pub sd_mps2: f64,
    /// So many of them are a limit that errors keep in 95 % of sessions: 2, more where
    /// model error or tilt were estimated from few readings.
    pub coverage_factor: f64,
    /// The product, m/s².
    pub error_mps2: f64,
}

/// The error of one placement that would do most harm unseen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct UndetectedError {
    /// The placement; its number, from 1, where it has no name of its own.
    pub label: String,
    /// The smallest error of its mean, along gravity, that its test against the others
    /// shows with 90 %, m/s².
    pub reading_mps2: f64,
    /// What that does to ‖a‖ in the worst direction, m/s².
    pub effect_mps2: f64,
    /// That direction, unit vector of specific force.
    pub direction: [f64; 3],
    /// How the sensor is held then.
    pub hint: String,
}

/// A placement that the others contradict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContradictedPose {
    /// The placement.
    pub label: String,
    /// Its test over the limit that chance exceeds in 5 % of sessions at most.
    pub excess: f64,
}

/// Uncertainty of ‖a‖ at rest, root mean square over all directions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Budget {
    /// Its parts.
    pub contributions: Vec<Contribution>,
    /// Root of the sum of their squares, m/s².
    pub combined_mps2: f64,
    /// k.
    pub coverage_factor: f64,
    /// k times that, m/s².
    pub expanded_mps2: f64,
}

/// A part of the uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Contribution {
    /// `noise`, `placement-tilt`, `quantisation`, `model-error`, `data-sheet`,
    /// `local-gravity`, `temperature`.
    pub source: String,
    /// Standard uncertainty of ‖a‖, m/s²; null when nothing tells it.
    pub norm_mps2: Option<f64>,
    /// Where the figure is from.
    pub basis: String,
}
