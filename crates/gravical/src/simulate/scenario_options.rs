//! Scenarios and their options.

use serde::{Deserialize, Serialize};

use super::range::{bad, within};
use crate::Result;

/// What is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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

    pub(super) fn validate(&self) -> Result<()> {
        match self {
            Self::SixPosition(o) => {
                within("hold", o.hold_s, 0.1, 3600.0, "s")?;
                within("rest", o.rest_s, 0.1, 3600.0, "s")?;
                within("turn-time", o.turn_time_s, 0.5, 60.0, "s")?;
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
                o.soak.map_or(Ok(()), |soak| soak.validate())
            }
            Self::Line(o) => {
                within("distance", o.distance_m, -100.0, 100.0, "m")?;
                within("offset", o.offset_m, -100.0, 100.0, "m")?;
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
pub struct SixPositionOptions {
    /// Duration of each pose, s. Default 10; range 0.1 to 3600.
    pub hold_s: f64,
    /// One recording `session.csv` with movements by hand between the poses and three turns after
    /// them, instead of six files. Default false.
    pub continuous: bool,
    /// Rest before and after each turn, s. Default 3; range 0.1 to 3600.
    pub rest_s: f64,
    /// Angle of each turn, right-handed about the axis, °. Default −360;
    /// range ±3600.
    pub turn_angle_deg: f64,
    /// Duration of a turn, s; the peak rate is 1.875·angle/duration.
    /// Default 4; range 0.5 to 60.
    pub turn_time_s: f64,
}

impl Default for SixPositionOptions {
    fn default() -> Self {
        Self {
            hold_s: 10.0,
            continuous: false,
            rest_s: 3.0,
            turn_angle_deg: -360.0,
            turn_time_s: 4.0,
        }
    }
}

/// Six faces, then free poses distributed over the sphere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PosesOptions {
    /// Duration of each pose, s. Default 4; range 0.1 to 3600.
    pub hold_s: f64,
    /// Number of free poses. Default 6; range 0 to 50.
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
pub struct StaticOptions {
    /// Length of the recording, s. Default 10; range 0.1 to 2 592 000 (30 days).
    pub duration_s: f64,
    /// Cooling and warming in a chamber. Default: warming up on a table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub soak: Option<SoakOptions>,
}

impl Default for StaticOptions {
    fn default() -> Self {
        Self {
            duration_s: 10.0,
            soak: None,
        }
    }
}

/// A temperature chamber: once from the highest temperature to the lowest and back, following a
/// cosine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SoakOptions {
    /// Temperature at start and end, °C. Default 50; range −40 to 105.
    pub high_c: f64,
    /// Temperature in the middle, °C. Default −10; range −40 to 105.
    pub low_c: f64,
    /// Width of the hysteresis: the drift lags behind the thermometer by half of it in both
    /// directions, °C. Default 0; range 0 to 100.
    pub hysteresis_c: f64,
    /// Drift of the gyroscope's bias, °/s per °C. Default 0; range 0 to 1.
    pub gyro_drift_deg_s_per_c: f64,
}

impl Default for SoakOptions {
    fn default() -> Self {
        Self {
            high_c: 50.0,
            low_c: -10.0,
            hysteresis_c: 0.0,
            gyro_drift_deg_s_per_c: 0.0,
        }
    }
}

impl SoakOptions {
    fn validate(&self) -> Result<()> {
        within("soak", self.high_c, -40.0, 105.0, "°C")?;
        within("soak", self.low_c, -40.0, 105.0, "°C")?;
        within("soak-hysteresis", self.hysteresis_c, 0.0, 100.0, "°C")?;
        within(
            "gyro-drift",
            self.gyro_drift_deg_s_per_c,
            0.0,
            1.0,
            "°/s/°C",
        )
    }
}

/// Rest, a minimum-jerk move mainly along y of the frame (z up, x along the horizontal component
/// of the sensor's x at rest), rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LineOptions {
    /// Displacement along y, m. Default 0.7; range ±100.
    pub distance_m: f64,
    /// Displacement along x, m. Default 0.02; range ±100.
    pub offset_m: f64,
    /// Duration of the move, s. Default 2; range 0.1 to 3600.
    pub move_time_s: f64,
    /// Rest before and after, s. Default 5; range 0.1 to 3600.
    pub rest_s: f64,
    /// Amplitude of one full sine of tilt about the sensor's x during the
    /// move, °. Default 0; range ±45. The rate jumps at both ends of the move.
    pub tilt_change_deg: f64,
}

impl Default for LineOptions {
    fn default() -> Self {
        Self {
            distance_m: 0.7,
            offset_m: 0.02,
            move_time_s: 2.0,
            rest_s: 5.0,
            tilt_change_deg: 0.0,
        }
    }
}
