//! The temperature model of a calibration file.

use gravical_fit::polynomial::{evaluate, shift};
use serde::{Deserialize, Serialize};

use super::{CalibrationFile, InputFile};

/// Drift of a sensor's readings with its temperature T.
///
/// With x = T − `reference_c`, drift(T) = Σ coefficients\[k\] · x^(k+1) of a channel,
///
/// ```text
/// calibrated = matrix · (raw − drift(T) − bias)
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
    /// Every channel; refused ones have no coefficients.
    pub channels: Vec<ChannelDrift>,
    /// The recordings the model was computed from.
    pub inputs: Vec<InputFile>,
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
    /// Order of the polynomial that was tested; 0 without a test.
    pub order: u32,
    /// R² on the means while warming of the polynomial fitted to those while cooling; null if it
    /// could not be tested.
    pub r2_cooling_to_warming: Option<f64>,
    /// R² the other way round.
    pub r2_warming_to_cooling: Option<f64>,
    /// Input unit per °C, °C², …; empty if refused.
    pub coefficients: Vec<f64>,
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

    /// The same model with the drift zero at `reference_c`.
    #[must_use]
    pub fn about(mut self, reference_c: f64) -> Self {
        let by = reference_c - self.reference_c;
        for channel in &mut self.channels {
            channel.coefficients = shift(&channel.coefficients, by);
        }
        self.reference_c = reference_c;
        self
    }

    /// Drift of channel `name` at `t_c`, input unit; outside the range that at the nearer edge. Zero
    /// for a channel that is not corrected.
    pub fn drift_at(&self, name: &str, t_c: f64) -> f64 {
        let x = t_c.clamp(self.range_c[0], self.range_c[1]) - self.reference_c;
        let channel = self.channel(name).filter(|c| c.is_corrected());
        channel.map_or(0.0, |c| evaluate(&c.coefficients, x))
    }

    /// A reading of channel `channel` (0 to 5: ax to gz) at `t_c`, as it would be at the reference
    /// temperature.
    pub(crate) fn at_reference(&self, channel: usize, t_c: f64, raw: f64) -> f64 {
        raw - self.drift_at(CHANNELS[channel], t_c)
    }

    /// Why it cannot be applied; `None` if it can.
    pub(super) fn fault(&self) -> Option<String> {
        let [low, high] = self.range_c;
        // Not where one is no number, either.
        if !(low <= high && self.reference_c.is_finite()) {
            return Some(format!("its range is {low} to {high} °C"));
        }
        let is_faulty = |c: &&ChannelDrift| {
            let is_finite = c.coefficients.iter().all(|v| v.is_finite());
            !is_finite || !CHANNELS.contains(&c.channel.as_str())
        };
        let faulty = self.channels.iter().find(is_faulty)?;
        let name = &faulty.channel;
        Some(format!(
            "{name} is no channel, or a coefficient of it no number"
        ))
    }
}

impl CalibrationFile {
    /// The temperature model, if it corrects a channel.
    pub(crate) fn drift_model(&self) -> Option<&TemperatureModel> {
        let model = self.temperature_model.as_ref();
        model.filter(|m| m.any_corrected())
    }
}
