//! Noise of the sensor, kept with its calibration.

use serde::{Deserialize, Serialize};

/// Noise parameters of a sensor, from an Allan deviation ([`crate::noise`]).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NoiseSection {
    /// Sampling rate of that recording, Hz.
    pub rate_hz: f64,
    /// Duration of the samples that were used, s.
    pub used_s: f64,
    /// The channels `ax` … `gz`.
    pub channels: Vec<NoiseParameters>,
}

/// Noise parameters of one channel in SI units; null where the recording does not determine them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NoiseParameters {
    /// `ax` … `gz`.
    pub channel: String,
    /// Noise density as Allan deviation: m/s²/√Hz or rad/s/√Hz.
    pub n: Option<f64>,
    /// Bias instability: m/s² or rad/s.
    pub b: Option<f64>,
    /// Random walk: m/s²/√s or rad/s/√s.
    pub k: Option<f64>,
    /// Upper limit (95 %) of N where it is not determined.
    pub n_at_most: Option<f64>,
    /// The same of B.
    pub b_at_most: Option<f64>,
    /// The same of K.
    pub k_at_most: Option<f64>,
}

impl NoiseSection {
    /// True if all parameters are positive numbers.
    pub(super) fn is_sound(&self) -> bool {
        let values = |c: &NoiseParameters| [c.n, c.b, c.k, c.n_at_most, c.b_at_most, c.k_at_most];
        let each = self.channels.iter().flat_map(values);
        let all = each.flatten().chain([self.rate_hz, self.used_s]);
        all.into_iter().all(|v| v.is_finite() && v > 0.0)
    }
}
