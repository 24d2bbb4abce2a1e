//! The temperature model of a calibration file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::InputFile;

/// How the readings of a sensor drift with its temperature T.
///
/// With x = T − `reference_c`, drift(T) = Σ coefficients\[k\] · x^(k+1) and
/// gain(T) = Σ scale_coefficients\[k\] · x^(k+1) of a channel,
///
/// ```text
/// calibrated = matrix · ((raw − drift(T)) / (1 + gain(T)) − bias)
/// ```
///
/// which is `matrix · (raw − bias − drift(T))` where no gain was found. Both
/// are zero at `reference_c`. Outside `range_c` nothing is known: there the
/// value at its nearer edge is held.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TemperatureModel {
    /// Temperature at which bias and matrix hold, °C.
    pub reference_c: f64,
    /// How that temperature is known.
    pub reference_source: ReferenceSource,
    /// Lowest and highest temperature that the model was fitted and tested in,
    /// °C.
    pub range_c: [f64; 2],
    /// Placements that were held while the temperature changed.
    pub poses: u32,
    /// The way of the temperature while still, in order.
    pub sweeps: Vec<Sweep>,
    /// Every channel, those that were refused too: they have no coefficients.
    pub channels: Vec<ChannelDrift>,
    /// The recordings it was computed from.
    pub inputs: Vec<InputFile>,
}

/// How the reference temperature of a model is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ReferenceSource {
    /// The mean temperature of the placements that bias and matrix come from.
    Session,
    /// The middle of the soak: the placements had no temperature.
    Soak,
}

/// A stretch in which the temperature went one way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Sweep {
    /// Falling or rising.
    pub direction: SweepDirection,
    /// Temperature at its start, °C.
    pub from_c: f64,
    /// Temperature at its end, °C.
    pub to_c: f64,
}

/// Which way the temperature goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SweepDirection {
    /// It falls.
    Cooling,
    /// It rises.
    Warming,
}

impl SweepDirection {
    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            SweepDirection::Cooling => "cooling",
            SweepDirection::Warming => "warming",
        }
    }

    /// The other one.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            SweepDirection::Cooling => SweepDirection::Warming,
            SweepDirection::Warming => SweepDirection::Cooling,
        }
    }
}

/// Whether a channel's drift is taken off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DriftVerdict {
    /// Each direction predicts the other.
    Accepted,
    /// It does not predict, or it was not tested.
    Refused,
}

/// What temperature does to one channel. Everything is in the unit of the
/// recording and in °C.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChannelDrift {
    /// `ax` … `gz`, axes of the board.
    pub channel: String,
    /// Unit of the recording.
    pub input_unit: String,
    /// Accepted or refused.
    pub verdict: DriftVerdict,
    /// Why, with numbers.
    pub reason: String,
    /// Order of the polynomial that was tested.
    pub order: u32,
    /// R² on the warming sweeps of what was fitted to the cooling ones; null
    /// when it could not be tested.
    pub r2_cooling_to_warming: Option<f64>,
    /// R² on the cooling sweeps of what was fitted to the warming ones.
    pub r2_warming_to_cooling: Option<f64>,
    /// Slope of the straight line through all of it, input unit per °C.
    pub slope: Option<f64>,
    /// The same of the cooling sweeps.
    pub slope_cooling: Option<f64>,
    /// The same of the warming sweeps.
    pub slope_warming: Option<f64>,
    /// Most that cooling and warming differ at one temperature, input unit;
    /// null where they were not held in one placement.
    pub hysteresis: Option<f64>,
    /// Standard deviation about the mean of its placement before …
    pub drift_rms: f64,
    /// … and after the model is taken off, every degree alike; null for a
    /// channel that was refused.
    pub residual_rms: Option<f64>,
    /// Input unit per °C, °C², …; empty when refused.
    pub coefficients: Vec<f64>,
    /// Relative change of the reading per °C, °C², …; empty when refused or
    /// not found.
    pub scale_coefficients: Vec<f64>,
    /// Which part of the drift is the bias and which the scale was told apart
    /// by placements in which gravity acts differently on the axis. Where it
    /// was not, all of it is ascribed to the bias.
    pub scale_observed: bool,
}

impl ChannelDrift {
    /// True when its drift is to be taken off.
    #[must_use]
    pub fn is_accepted(&self) -> bool {
        self.verdict == DriftVerdict::Accepted
    }
}

/// Names of the channels, in the order of a row.
pub const CHANNELS: [&str; 6] = ["ax", "ay", "az", "gx", "gy", "gz"];

impl TemperatureModel {
    /// The channel called `name`.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&ChannelDrift> {
        self.channels.iter().find(|c| c.channel == name)
    }

    /// True when any channel was accepted.
    #[must_use]
    pub fn any_accepted(&self) -> bool {
        self.channels.iter().any(ChannelDrift::is_accepted)
    }

    /// True when every number can be applied: finite, the range in order, the
    /// gain far from −1 everywhere in it, channels known and named once.
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
                crate::temperature::evaluate(&c.scale_coefficients, t_c - self.reference_c).abs()
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
