//! The temperature model of a calibration file.

use serde::{Deserialize, Serialize};

use super::InputFile;

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
    /// Poses in which the temperature changed.
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

    /// True if every number can be applied: finite, the range in order, the gain far from −1 in
    /// the range, channels known and unique.
    pub(super) fn is_usable(&self) -> bool {
        let [low, high] = self.range_c;
        let numbers = self
            .channels
            .iter()
            .flat_map(|c| c.coefficients.iter().chain(&c.scale_coefficients))
            .chain([&self.reference_c, &low, &high]);
        let known = |c: &ChannelDrift| CHANNELS.contains(&c.channel.as_str());
        let once = self
            .channels
            .iter()
            .enumerate()
            .all(|(i, c)| self.channels[..i].iter().all(|b| b.channel != c.channel));
        let gains = self.channels.iter().all(|c| {
            (0..=20).all(|i| {
                let t_c = low + (high - low) * f64::from(i) / 20.0;
                crate::polynomial::evaluate(&c.scale_coefficients, t_c - self.reference_c).abs()
                    < 0.5
            })
        });
        low <= high
            && once
            && gains
            && self.channels.iter().all(known)
            && numbers.clone().all(|v| v.is_finite())
    }
}
