//! The temperature model of a calibration file.

use serde::{Deserialize, Serialize};

use super::CalibrationFile;

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

impl ChannelDrift {
    /// True if its drift is subtracted.
    pub fn is_corrected(&self) -> bool {
        self.verdict == DriftVerdict::Corrected
    }
}

/// Names of the channels, in the order of a row.
pub const CHANNELS: [&str; 6] = ["ax", "ay", "az", "gx", "gy", "gz"];

impl TemperatureModel {
    /// The channel with this name.
    pub fn channel(&self, name: &str) -> Option<&ChannelDrift> {
        self.channels.iter().find(|c| c.channel == name)
    }

    /// True if at least one channel is corrected.
    pub fn any_corrected(&self) -> bool {
        self.channels.iter().any(ChannelDrift::is_corrected)
    }

    /// Drift of `ax` … `gz` at `t_c`, input unit; outside the range that at the nearer edge. Zero for
    /// a channel that is not corrected.
    pub fn drift_at(&self, t_c: f64) -> [f64; 6] {
        let x = t_c.clamp(self.range_c[0], self.range_c[1]) - self.reference_c;
        CHANNELS.map(|name| {
            let channel = self.channel(name).filter(|c| c.is_corrected());
            channel.and_then(|c| c.per_c).map_or(0.0, |per_c| per_c * x)
        })
    }

    /// False where its range is none, or a corrected channel has no slope or is none.
    pub(super) fn is_applicable(&self) -> bool {
        let is_channel = |c: &ChannelDrift| {
            let has_slope = c.per_c.is_some_and(f64::is_finite);
            (!c.is_corrected() || has_slope) && CHANNELS.contains(&c.channel.as_str())
        };
        // Not where one is no number, either.
        let is_range = self.range_c[0] <= self.range_c[1] && self.reference_c.is_finite();
        is_range && self.channels.iter().all(is_channel)
    }
}

impl CalibrationFile {
    /// The temperature model, if it corrects a channel.
    pub(crate) fn drift_model(&self) -> Option<&TemperatureModel> {
        let model = self.temperature_model.as_ref();
        model.filter(|m| m.any_corrected())
    }
}
