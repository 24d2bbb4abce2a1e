//! The temperature model of a calibration file.

use serde::{Deserialize, Serialize};

use super::{CalibrationFile, InputFile};
use crate::polynomial::evaluate;

/// Drift of a sensor's readings with its temperature T.
///
/// With x = T − `reference_c`, drift(T) = Σ coefficients\[k\] · x^(k+1) and
/// gain(T) = Σ scale_coefficients\[k\] · x^(k+1) of a channel,
///
/// ```text
/// calibrated = matrix · ((raw − drift(T)) / (1 + gain(T)) − bias)
/// ```
///
/// which is `matrix · (raw − bias − drift(T))` without a gain. Both are zero at `reference_c`.
/// Outside `range_c` the value at its nearer edge is used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TemperatureModel {
    /// Temperature at which bias and matrix are valid, °C.
    pub reference_c: f64,
    /// Source of the reference temperature.
    pub reference_source: ReferenceSource,
    /// Lowest and highest temperature at which the model was fitted and tested, °C.
    pub range_c: [f64; 2],
    /// Poses that the drift was computed from.
    pub poses: u32,
    /// Sweeps of the temperature at rest, in order.
    pub sweeps: Vec<Sweep>,
    /// Every channel; refused ones have no coefficients.
    pub channels: Vec<ChannelDrift>,
    /// The recordings the model was computed from.
    pub inputs: Vec<InputFile>,
}

/// Source of the reference temperature of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ReferenceSource {
    /// The mean temperature of the poses that bias and matrix were computed from.
    Session,
    /// The middle of the soak: the poses had no temperature.
    Soak,
}

/// An interval in which the temperature changed in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Sweep {
    /// Falling or rising.
    pub direction: SweepDirection,
    /// Temperature at its start, °C.
    pub from_c: f64,
    /// Temperature at its end, °C.
    pub to_c: f64,
}

/// Direction of a temperature change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SweepDirection {
    /// Falling.
    Cooling,
    /// Rising.
    Warming,
}

impl SweepDirection {
    /// Name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            SweepDirection::Cooling => "cooling",
            SweepDirection::Warming => "warming",
        }
    }

    /// The other direction.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            SweepDirection::Cooling => SweepDirection::Warming,
            SweepDirection::Warming => SweepDirection::Cooling,
        }
    }
}

/// Whether the drift of a channel is subtracted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum DriftVerdict {
    /// Each direction predicts the other.
    Corrected,
    /// One direction does not predict the other, or it was not tested.
    NotCorrected,
}

/// Temperature drift of one channel, in the unit of the recording and °C.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChannelDrift {
    /// `ax` … `gz`, axes of the board.
    pub channel: String,
    /// Unit of the recording.
    pub input_unit: String,
    /// Whether it is corrected.
    pub verdict: DriftVerdict,
    /// Reason, with numbers.
    pub reason: String,
    /// Order of the polynomial that was tested.
    pub order: u32,
    /// R² on the warming sweeps of the polynomial fitted to the cooling ones; null if it could
    /// not be tested.
    pub r2_cooling_to_warming: Option<f64>,
    /// R² on the cooling sweeps of the polynomial fitted to the warming ones.
    pub r2_warming_to_cooling: Option<f64>,
    /// Slope of the straight line through all sweeps, input unit per °C.
    pub slope: Option<f64>,
    /// The same for the cooling sweeps.
    pub slope_cooling: Option<f64>,
    /// The same for the warming sweeps.
    pub slope_warming: Option<f64>,
    /// Largest difference between cooling and warming at one temperature, input unit; null if
    /// they were not in one pose.
    pub hysteresis: Option<f64>,
    /// Standard deviation about the mean of each pose, before the model is subtracted.
    pub drift_rms: f64,
    /// The same after the model is subtracted, all degrees with equal weight; null for a refused
    /// channel.
    pub residual_rms: Option<f64>,
    /// Input unit per °C, °C², …; empty if refused.
    pub coefficients: Vec<f64>,
    /// Relative change of the reading per °C, °C², …; empty if refused or not found.
    pub scale_coefficients: Vec<f64>,
    /// True if the drifts of bias and scale were distinguished, by poses in which gravity acts
    /// differently on the axis. If false, all drift is assigned to the bias.
    pub scale_observed: bool,
}

impl ChannelDrift {
    /// True if its drift is subtracted.
    #[must_use]
    pub fn is_corrected(&self) -> bool {
        self.verdict == DriftVerdict::Corrected
    }
}

/// Names of the channels, in the order of a row.
pub const CHANNELS: [&str; 6] = ["ax", "ay", "az", "gx", "gy", "gz"];

impl TemperatureModel {
    /// The channel with this name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&ChannelDrift> {
        self.channels.iter().find(|c| c.channel == name)
    }

    /// True if at least one channel is corrected.
    #[must_use]
    pub fn any_corrected(&self) -> bool {
        self.channels.iter().any(ChannelDrift::is_corrected)
    }

    /// Drift (input unit) and gain (relative) of channel `name` at `t_c`; outside the range those
    /// at the nearer edge. Zero for a channel that is not corrected.
    #[must_use]
    pub fn drift_at(&self, name: &str, t_c: f64) -> (f64, f64) {
        let x = t_c.clamp(self.range_c[0], self.range_c[1]) - self.reference_c;
        let channel = self.channel(name).filter(|c| c.is_corrected());
        channel.map_or((0.0, 0.0), |c| {
            (
                evaluate(&c.coefficients, x),
                evaluate(&c.scale_coefficients, x),
            )
        })
    }

    /// A reading of channel `channel` (0 to 5: ax to gz) at `t_c`, as it would be at the reference
    /// temperature.
    pub(crate) fn at_reference(&self, channel: usize, t_c: f64, raw: f64) -> f64 {
        let (drift, gain) = self.drift_at(CHANNELS[channel], t_c);
        (raw - drift) / (1.0 + gain)
    }

    /// The inverse of [`at_reference`](Self::at_reference).
    pub(crate) fn at_temperature(&self, channel: usize, t_c: f64, value: f64) -> f64 {
        let (drift, gain) = self.drift_at(CHANNELS[channel], t_c);
        value * (1.0 + gain) + drift
    }

    /// Why it cannot be applied; `None` if it can.
    pub(super) fn fault(&self) -> Option<String> {
        let [low, high] = self.range_c;
        if ![self.reference_c, low, high].iter().all(|v| v.is_finite()) {
            return Some("its reference or its range is not finite".to_owned());
        }
        if low > high {
            return Some(format!("its range is reversed: {low} to {high} °C"));
        }
        self.channels.iter().enumerate().find_map(|(i, c)| {
            let name = &c.channel;
            let mut numbers = c.coefficients.iter().chain(&c.scale_coefficients);
            let gain = |share: i32| {
                let t_c = low + (high - low) * f64::from(share) / 20.0;
                evaluate(&c.scale_coefficients, t_c - self.reference_c)
            };
            if !CHANNELS.contains(&name.as_str()) {
                Some(format!("there is no channel {name}"))
            } else if self.channels[..i]
                .iter()
                .any(|before| before.channel == *name)
            {
                Some(format!("the channel {name} is there twice"))
            } else if !numbers.all(|v| v.is_finite()) {
                Some(format!("a coefficient of {name} is not finite"))
            } else if !(0..=20).all(|share| gain(share).abs() < 0.5) {
                Some(format!(
                    "the gain of {name} reaches a half within its range"
                ))
            } else {
                None
            }
        })
    }
}

impl CalibrationFile {
    /// The temperature model, if it corrects a channel.
    pub(crate) fn drift_model(&self) -> Option<&TemperatureModel> {
        let model = self.temperature_model.as_ref();
        model.filter(|m| m.any_corrected())
    }
}
