//! Fields of a calibration file about its uncertainty.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use serde::{Deserialize, Serialize};

use super::AccelerometerSection;

/// Standard deviations (1σ) from the covariance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Deviations {
    /// Of the bias, input unit.
    pub bias: [f64; 3],
    /// Of the scale, input unit per m/s².
    pub scale: [f64; 3],
    /// Of the angles between the sensitive axes xy, yz and zx, degrees.
    pub axis_angle_deg: [f64; 3],
    /// Factor on the standard deviations for an interval of 95 %: Student's t where a tilt was
    /// estimated from the same poses, the largest that any of them needs.
    pub coverage_factor_95: f64,
}

/// Quality of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FitQuality {
    /// χ² of the readings with the noise of their means, over its degrees of freedom; null
    /// without any. Above 1 the sensor deviates from the model by more than noise.
    pub chi2_per_freedom: Option<f64>,
    /// Degrees of freedom of the readings.
    pub freedom: f64,
    /// Standard deviation added to every mean so that χ² equals its expected value, m/s²;
    /// included in the covariance.
    pub model_error_mps2: f64,
    /// Condition number of the nine parameters determined by the magnitudes alone, with columns
    /// of length one; null for fewer than nine poses.
    pub condition: Option<f64>,
    /// False if too few faces determine the orientation of the sensor frame in the case; the
    /// matrix is then triangular by convention.
    pub oriented: bool,
    /// Repeats of a face had the same orientation and share their tilt.
    pub shared_tilts: bool,
    /// Components of the tilts that the data determine.
    pub tilt_degrees_of_freedom: f64,
    /// The data sheet was used.
    pub prior: bool,
}

/// The least consistent pose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LeastConsistentPose {
    /// Its label.
    pub label: String,
    /// Reason, with numbers.
    pub reason: String,
}

/// A pose that would lower the predicted error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NextPose {
    /// Unit vector of specific force: the calibrated reading in this pose, over gravity.
    pub direction: [f64; 3],
    /// How to hold the sensor.
    pub hint: String,
    /// Predicted error of ‖a‖ over all directions with this pose, m/s².
    pub predicted_norm_error_mps2: f64,
    /// Undetected error of ‖a‖ in the worst direction with this pose, m/s²; null without
    /// redundancy.
    #[serde(default)]
    pub undetected_effect_mps2: Option<f64>,
}

/// Poses are proposed if all of them together bring an error below this share.
const MATTERS: f64 = 0.8;
/// Error of ‖a‖ up to which a result is good, mg: as predicted in the worst direction (2σ), and
/// by an error of one pose that is not detected.
pub(crate) const GOOD_MG: f64 = 5.0;

impl AccelerometerSection {
    /// True if the proposed poses lower the predicted error of ‖a‖ by more than a fifth.
    #[must_use]
    pub fn next_poses_lower_error(&self) -> bool {
        let now = self.predicted_norm_error_mps2;
        let then = self.next_poses.last().map(|p| p.predicted_norm_error_mps2);
        then.zip(now)
            .is_some_and(|(then, now)| then < MATTERS * now)
    }

    /// The next poses, if they improve the result by more than a fifth: its predicted error, or,
    /// where that is above 5 mg, the error that one pose can cause undetected.
    #[must_use]
    pub fn proposed_poses(&self) -> &[NextPose] {
        let good = GOOD_MG * STANDARD_GRAVITY_MPS2 / 1000.0;
        let now = self.undetected.as_ref().map(|u| u.effect_mps2);
        let then = self.next_poses.iter();
        let then = then.filter_map(|p| p.undetected_effect_mps2);
        let test_more = then
            .min_by(f64::total_cmp)
            .is_some_and(|least| now.is_none_or(|now| now > good && least < MATTERS * now));
        match self.next_poses_lower_error() || test_more {
            true => &self.next_poses,
            false => &[],
        }
    }
}

/// What it would bring to know local gravity, which was assumed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct KnownGravity {
    /// Options that give it.
    pub hint: String,
    /// Predicted error of ‖a‖ over all directions without that of gravity, m/s².
    pub predicted_norm_error_mps2: f64,
}

/// The direction in which ‖a‖ is known least.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WorstDirection {
    /// Unit vector of specific force.
    pub direction: [f64; 3],
    /// How to hold the sensor for this direction.
    pub hint: String,
    /// Standard uncertainty of ‖a‖ there, m/s².
    pub sd_mps2: f64,
    /// Factor on it for a limit that errors stay below in 95 % of sessions: 2, larger if model
    /// error or tilt were estimated from few readings.
    pub coverage_factor: f64,
    /// The product, m/s².
    pub error_mps2: f64,
}

/// The error of one pose that has the largest effect without being detected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct UndetectedError {
    /// The pose; its number, from 1, if it has no name.
    pub label: String,
    /// Smallest error of its mean, along gravity, that the test against the other poses detects
    /// with a probability of 90 %, m/s².
    pub reading_mps2: f64,
    /// Effect of this error on ‖a‖ in the worst direction, m/s².
    pub effect_mps2: f64,
    /// That direction, unit vector of specific force.
    pub direction: [f64; 3],
    /// How to hold the sensor for this direction.
    pub hint: String,
}

/// A pose that is inconsistent with the others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ContradictedPose {
    /// The pose.
    pub label: String,
    /// Its test value over the limit that is exceeded by chance in at most 5 % of sessions.
    pub excess: f64,
}

/// Uncertainty of ‖a‖ at rest, root mean square over all directions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Budget {
    /// Contributions.
    pub contributions: Vec<Contribution>,
    /// Root of the sum of their squares, m/s².
    pub combined_mps2: f64,
    /// Coverage factor k.
    pub coverage_factor: f64,
    /// k times the combined uncertainty, m/s².
    pub expanded_mps2: f64,
}

/// A contribution to the uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Contribution {
    /// `noise`, `pose-tilt`, `quantisation`, `model-error`, `data-sheet`,
    /// `local-gravity`, `temperature`.
    pub source: String,
    /// Standard uncertainty of ‖a‖, m/s²; null if unknown.
    pub norm_mps2: Option<f64>,
    /// Basis of the value.
    pub basis: String,
}
