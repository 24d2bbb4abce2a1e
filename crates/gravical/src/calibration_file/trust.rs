//! Fields of a calibration file about its uncertainty.

use gravical_fit::NextPose;
use serde::{Deserialize, Serialize};

use super::{AccelerometerSection, GravitySource, PoseKind, PoseResult};

/// Poses are proposed if all of them together bring an error below this share.
const MATTERS: f64 = 0.8;

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
        let now = self.undetected.as_ref().map(|u| u.effect_mps2);
        let then = self.next_poses.iter();
        let then = then.filter_map(|p| p.undetected_effect_mps2);
        let test_more = then.min_by(f64::total_cmp).is_some_and(|least| {
            now.is_none_or(|now| now > gravical_fit::GOOD_MPS2 && least < MATTERS * now)
        });
        if self.next_poses_lower_error() || test_more {
            &self.next_poses
        } else {
            &[]
        }
    }

    /// Predicted error of ‖a‖ without that of gravity, m/s², if gravity was assumed and is most of it.
    #[must_use]
    pub fn error_with_known_gravity(&self, source: GravitySource) -> Option<f64> {
        let squared = self.predicted_norm_error_mps2?.powi(2);
        let without = (squared - self.gravity_sd_mps2.powi(2)).max(0.0);
        let matters = source == GravitySource::Standard && 2.0 * without < squared;
        matters.then(|| without.sqrt())
    }

    /// The number of the pose with the largest leave-one-out error, in its own standard deviations, and
    /// that ratio.
    #[must_use]
    pub fn least_consistent(&self) -> Option<(usize, f64)> {
        let ratio = |p: &PoseResult| Some(p.left_out_error_mps2?.abs() / p.left_out_sd_mps2?);
        let each = self.poses.iter().enumerate();
        let each = each.filter_map(|(i, p)| Some((i, ratio(p)?)));
        each.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The pose that the others contradict most, if one is beyond what chance explains, and how many of
    /// its standard deviations it is off.
    #[must_use]
    pub fn contradiction(&self) -> Option<(usize, f64)> {
        self.least_consistent()
            .filter(|(_, z)| *z > gravical_fit::CONTRADICTION)
    }

    /// RMS of ‖a‖ − g over free poses that took no part in the fit, m/s², and their number.
    #[must_use]
    pub(crate) fn free_norm_error(&self) -> Option<(f64, usize)> {
        let free = self.poses.iter();
        let free = free.filter(|p| p.kind == PoseKind::Free && !p.fitted);
        let errors: Vec<f64> = free.filter_map(|p| p.magnitude_error_mps2).collect();
        let squares: f64 = errors.iter().map(|e| e * e).sum();
        (!errors.is_empty()).then(|| ((squares / errors.len() as f64).sqrt(), errors.len()))
    }
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
