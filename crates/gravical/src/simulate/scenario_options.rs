//! Scenarios and their options.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::range::{bad, within};
use crate::{Error, Result};

/// Duration of a turn, s; the peak rate is 1.875·angle/duration.
pub(super) const TURN_S: f64 = 4.0;
/// Displacement of a line along x, m.
pub(super) const LINE_OFFSET_M: f64 = 0.02;

/// What is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "name", rename_all = "kebab-case")]
pub enum Scenario {
    /// Six static poses, one file each; or a complete Ferraris session.
    SixPosition(SixPositionOptions),
    /// Six faces and free poses in one continuous recording.
    Poses(PosesOptions),
    /// Static, z up.
    Static(StaticOptions),
    /// Rest, one straight move, rest.
    Line(LineOptions),
}

impl Default for Scenario {
    fn default() -> Self {
        Self::Static(StaticOptions::default())
    }
}

impl Scenario {
    /// `six-position`, `poses`, `static` or `line`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::SixPosition(_) => "six-position",
            Self::Poses(_) => "poses",
            Self::Static(_) => "static",
            Self::Line(_) => "line",
        }
    }

    /// Options of the chamber, if there is one.
    pub(super) fn soak(&self) -> Option<SoakOptions> {
        match self {
            Self::Static(o) => o.soak,
            _ => None,
        }
    }

    /// Drift of the gyroscope's bias, °/s per °C.
    pub(super) fn gyro_drift_deg_s_per_c(&self) -> f64 {
        match self {
            Self::Static(o) => o.gyro_drift_deg_s_per_c,
            _ => 0.0,
        }
    }

    pub(super) fn validate(&self) -> Result<()> {
        match self {
            Self::SixPosition(o) => {
                within("hold", o.hold_s, 0.1, 3600.0, "s")?;
                within("rest", o.rest_s, 0.1, 3600.0, "s")?;
                within("turn-angle", o.turn_angle_deg, -3600.0, 3600.0, "°")
            }
            Self::Poses(o) => {
                within("hold", o.hold_s, 0.1, 3600.0, "s")?;
                if o.free > 50 {
                    return Err(bad(format!("free is {}; 50 poses at most", o.free)));
                }
                Ok(())
            }
            Self::Static(o) => {
                within("duration", o.duration_s, 0.1, 2_592_000.0, "s")?;
                within("gyro-drift", o.gyro_drift_deg_s_per_c, 0.0, 1.0, "°/s/°C")?;
                o.soak.map_or(Ok(()), |soak| soak.validate())
            }
            Self::Line(o) => {
                within("distance", o.distance_m, -100.0, 100.0, "m")?;
                within("move-time", o.move_time_s, 0.1, 3600.0, "s")?;
                within("rest", o.rest_s, 0.1, 3600.0, "s")?;
                within("tilt change", o.tilt_change_deg, -45.0, 45.0, "°")
            }
        }
    }
}

/// Six poses: +x, −x, +y, −y, +z, −z (the axis that points up).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct SixPositionOptions {
    /// Duration of each pose, s
    #[serde(rename(deserialize = "hold"))]
    #[cfg_attr(feature = "clap", arg(long = "hold", value_name = "S", default_value_t = SixPositionOptions::default().hold_s))]
    pub hold_s: f64,
    /// One recording: poses, then full turns
    #[cfg_attr(feature = "clap", arg(long))]
    pub continuous: bool,
    /// Rest before and after each turn, s
    #[serde(rename(deserialize = "rest"))]
    #[cfg_attr(feature = "clap", arg(long = "rest", value_name = "S", default_value_t = SixPositionOptions::default().rest_s, requires = "continuous"))]
    pub rest_s: f64,
    /// Angle of each turn, right-handed, °
    #[serde(rename(deserialize = "turn_angle"))]
    #[cfg_attr(feature = "clap", arg(long = "turn-angle", value_name = "DEG", default_value_t = SixPositionOptions::default().turn_angle_deg, allow_negative_numbers = true, requires = "continuous"))]
    pub turn_angle_deg: f64,
}

impl Default for SixPositionOptions {
    fn default() -> Self {
        Self {
            hold_s: 10.0,
            continuous: false,
            rest_s: 3.0,
            turn_angle_deg: -360.0,
        }
    }
}

/// Six faces, then free poses distributed over the sphere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct PosesOptions {
    /// Duration of each pose, s
    #[serde(rename(deserialize = "hold"))]
    #[cfg_attr(feature = "clap", arg(long = "hold", value_name = "S", default_value_t = PosesOptions::default().hold_s))]
    pub hold_s: f64,
    /// Number of free poses after the six faces
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = PosesOptions::default().free))]
    pub free: u32,
}

impl Default for PosesOptions {
    fn default() -> Self {
        Self {
            hold_s: 4.0,
            free: 6,
        }
    }
}

/// Static, z up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct StaticOptions {
    /// Length of the recording, s
    #[serde(rename(deserialize = "duration"))]
    #[cfg_attr(feature = "clap", arg(long = "duration", value_name = "S", default_value_t = StaticOptions::default().duration_s))]
    pub duration_s: f64,
    /// In a thermal chamber that goes from HIGH to LOW °C and back
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "HIGH,LOW", allow_hyphen_values = true)
    )]
    #[serde(
        skip_serializing_if = "Option::is_none",
        deserialize_with = "crate::option_text::optional"
    )]
    pub soak: Option<SoakOptions>,
    /// Drift of the gyroscope's bias in the chamber, °/s per °C
    #[serde(rename(deserialize = "gyro_drift"))]
    #[cfg_attr(feature = "clap", arg(long = "gyro-drift", value_name = "DEG_S_C", default_value_t = StaticOptions::default().gyro_drift_deg_s_per_c, requires = "soak"))]
    pub gyro_drift_deg_s_per_c: f64,
}

impl Default for StaticOptions {
    fn default() -> Self {
        Self {
            duration_s: 10.0,
            soak: None,
            gyro_drift_deg_s_per_c: 0.0,
        }
    }
}

/// A temperature chamber: once from the highest temperature to the lowest and back, following a
/// cosine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SoakOptions {
    /// Temperature at start and end, °C. Default 50; range −40 to 105.
    pub high_c: f64,
    /// Temperature in the middle, °C. Default −10; range −40 to 105.
    pub low_c: f64,
}

impl Default for SoakOptions {
    fn default() -> Self {
        Self {
            high_c: 50.0,
            low_c: -10.0,
        }
    }
}

impl FromStr for SoakOptions {
    type Err = Error;

    /// `50,-10`: highest and lowest temperature, °C.
    fn from_str(text: &str) -> Result<Self> {
        let numbers = text
            .split_once(',')
            .and_then(|(high, low)| Some((high.trim().parse().ok()?, low.trim().parse().ok()?)));
        let (high_c, low_c) = numbers
            .ok_or_else(|| Error::usage("usage", "expected two temperatures such as 50,-10"))?;
        Ok(SoakOptions { high_c, low_c })
    }
}

impl SoakOptions {
    fn validate(&self) -> Result<()> {
        if self.low_c > self.high_c {
            return Err(bad("soak: the highest temperature comes first, as 50,-10"));
        }
        within("soak", self.high_c, -40.0, 105.0, "°C")?;
        within("soak", self.low_c, -40.0, 105.0, "°C")
    }
}

/// Rest, a minimum-jerk move mainly along y of the frame (z up, x along the horizontal component
/// of the sensor's x at rest), rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct LineOptions {
    /// Displacement along y, m
    #[serde(rename(deserialize = "distance"))]
    #[cfg_attr(feature = "clap", arg(long = "distance", value_name = "M", default_value_t = LineOptions::default().distance_m, allow_negative_numbers = true))]
    pub distance_m: f64,
    /// Duration of the move, s
    #[serde(rename(deserialize = "move_time"))]
    #[cfg_attr(feature = "clap", arg(long = "move-time", value_name = "S", default_value_t = LineOptions::default().move_time_s))]
    pub move_time_s: f64,
    /// Rest before and after the move, s
    #[serde(rename(deserialize = "rest"))]
    #[cfg_attr(feature = "clap", arg(long = "rest", value_name = "S", default_value_t = LineOptions::default().rest_s))]
    pub rest_s: f64,
    /// Amplitude of one full sine of tilt about the sensor's x during the
    /// move, °. Default 0; range ±45. The rate jumps at both ends of the move.
    #[serde(rename(deserialize = "tilt_change"))]
    #[cfg_attr(feature = "clap", arg(skip = LineOptions::default().tilt_change_deg))]
    pub tilt_change_deg: f64,
}

impl Default for LineOptions {
    fn default() -> Self {
        Self {
            distance_m: 0.7,
            move_time_s: 2.0,
            rest_s: 5.0,
            tilt_change_deg: 0.0,
        }
    }
}
