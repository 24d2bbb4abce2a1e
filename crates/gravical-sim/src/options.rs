//! Scenarios and options of the virtual sensor, with unit, default and range.

use serde::{Deserialize, Serialize};

use crate::problem::Problem;
use gravical_judge::Result;

/// Displacement of a line along x, m.
pub(crate) const LINE_OFFSET_M: f64 = 0.02;

/// Refuses values outside their range, including NaN: name, value, lowest, highest, unit.
fn check(options: &[(&'static str, f64, f64, f64, &'static str)]) -> Result<()> {
    for &(name, value, low, high, unit) in options {
        if !(low..=high).contains(&value) {
            let problem = Problem::OutOfRange {
                name,
                value,
                unit,
                low,
                high,
            };
            return Err(problem.error());
        }
    }
    Ok(())
}

/// What is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "name", rename_all = "kebab-case")]
pub enum Scenario {
    /// Six static poses, one file each; or one recording of them and of three turns.
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
    pub fn name(&self) -> &'static str {
        match self {
            Self::SixPosition(_) => "six-position",
            Self::Poses(_) => "poses",
            Self::Static(_) => "static",
            Self::Line(_) => "line",
        }
    }

    pub(crate) fn validate(&self) -> Result<()> {
        match self {
            Self::SixPosition(o) => check(&[("hold", o.hold_s, 0.1, 3600.0, "s")]),
            Self::Poses(o) => check(&[
                ("hold", o.hold_s, 0.1, 3600.0, "s"),
                ("free", f64::from(o.free), 0.0, 50.0, "poses"),
            ]),
            Self::Static(o) => check(&[("duration", o.duration_s, 0.1, 2_592_000.0, "s")]),
            Self::Line(o) => check(&[
                ("distance", o.distance_m, -100.0, 100.0, "m"),
                ("move-time", o.move_time_s, 0.1, 3600.0, "s"),
                ("rest", o.rest_s, 0.1, 3600.0, "s"),
            ]),
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
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip = SixPositionOptions::default().turn_rest_s))]
    pub turn_rest_s: f64,
}

impl Default for SixPositionOptions {
    fn default() -> Self {
        Self {
            hold_s: 10.0,
            continuous: false,
            turn_rest_s: 3.0,
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
}

impl Default for StaticOptions {
    fn default() -> Self {
        Self { duration_s: 10.0 }
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
}

impl Default for LineOptions {
    fn default() -> Self {
        Self {
            distance_m: 0.7,
            move_time_s: 2.0,
            rest_s: 5.0,
        }
    }
}

/// All options of a simulation: equal options give identical files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct SimulateOptions {
    /// What is simulated. Default: static.
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", arg(skip = SimulateOptions::default().scenario))]
    pub scenario: Scenario,
    /// Seed; equal seeds give equal files
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = SimulateOptions::default().seed))]
    pub seed: u64,
    /// Local gravity, 9.7 to 9.9 m/s²
    #[serde(rename(deserialize = "gravity"))]
    #[cfg_attr(feature = "clap", arg(long = "gravity", value_name = "MPS2", default_value_t = SimulateOptions::default().gravity_mps2))]
    pub gravity_mps2: f64,
    /// True sampling rate, 1 to 1000 Hz
    #[serde(rename(deserialize = "rate"))]
    #[cfg_attr(feature = "clap", arg(long = "rate", value_name = "HZ", default_value_t = SimulateOptions::default().rate_hz))]
    pub rate_hz: f64,
    /// Jitter of the time stamps, ± ms
    #[serde(rename(deserialize = "jitter"))]
    #[cfg_attr(feature = "clap", arg(long = "jitter", value_name = "MS", default_value_t = SimulateOptions::default().stamp_jitter_ms))]
    pub stamp_jitter_ms: f64,
    /// Share of lost rows, 0 to 0.9
    #[serde(rename(deserialize = "drop"))]
    #[cfg_attr(feature = "clap", arg(long = "drop", value_name = "FRACTION", default_value_t = SimulateOptions::default().dropped_fraction))]
    pub dropped_fraction: f64,
    /// Tilt of a pose, 0 to 20° (sd of each component)
    #[serde(rename(deserialize = "tilt"))]
    #[cfg_attr(feature = "clap", arg(long = "tilt", value_name = "DEG", default_value_t = SimulateOptions::default().tilt_sd_deg))]
    pub tilt_sd_deg: f64,
    /// The sensor.
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", command(flatten))]
    pub sensor: SensorOptions,
    /// Format of the files.
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", command(flatten))]
    pub file: FileOptions,
}

impl Default for SimulateOptions {
    fn default() -> Self {
        Self::new(Scenario::Static(StaticOptions::default()))
    }
}

impl SimulateOptions {
    /// The defaults for `scenario`.
    pub fn new(scenario: Scenario) -> Self {
        Self {
            scenario,
            seed: 1,
            gravity_mps2: 9.80665,
            rate_hz: 100.0,
            stamp_jitter_ms: 0.0,
            dropped_fraction: 0.0,
            tilt_sd_deg: 1.0,
            sensor: SensorOptions::default(),
            file: FileOptions::default(),
        }
    }

    /// Checks every field against its range.
    ///
    /// # Errors
    ///
    /// `simulate-option` (usage), with the option, its value and its range.
    pub fn validate(&self) -> Result<()> {
        self.scenario.validate()?;
        let sensor = &self.sensor;
        let (rise_c, drift) = (sensor.temperature_rise_c, sensor.bias_drift_mg_per_c);
        let decimals = f64::from(self.file.decimals);
        let max_jitter_ms = 400.0 / self.rate_hz;
        check(&[
            ("gravity", self.gravity_mps2, 9.7, 9.9, "m/s²"),
            ("rate", self.rate_hz, 1.0, 1000.0, "Hz"),
            ("jitter", self.stamp_jitter_ms, 0.0, max_jitter_ms, "ms"),
            ("drop", self.dropped_fraction, 0.0, 0.9, "of the rows"),
            ("tilt", self.tilt_sd_deg, 0.0, 20.0, "°"),
            ("decimals", decimals, 1.0, 9.0, "digits"),
            ("noise", sensor.noise_factor, 0.0, 100.0, "times the usual"),
            ("scale-sd", sensor.scale_sd_percent, 0.0, 10.0, "%"),
            ("temperature-rise", rise_c, -40.0, 40.0, "°C"),
            ("temperature-drift", drift, 0.0, 10.0, "mg/°C"),
        ])?;
        if ![2, 4, 8, 16].contains(&sensor.accel_range_g) {
            let range_g = sensor.accel_range_g;
            return Err(Problem::OtherRange { range_g }.error());
        }
        if self.file.raw && self.file.wrong_header {
            return Err(Problem::RawWithHeader.error());
        }
        Ok(())
    }
}

/// The virtual MPU6050; its errors are drawn from the seed.
///
/// Model, per sample: `u = M f + b(T)`, `v = M_g ω + b_g + K f`, both with white noise, then a second-order
/// low-pass, then rounding to counts. Widths by the data sheet are constants of `sensor.rs`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "clap", command(next_help_heading = "Sensor"))]
pub struct SensorOptions {
    /// Range, g: 2, 4, 8 or 16
    #[serde(rename(deserialize = "range"))]
    #[cfg_attr(feature = "clap", arg(long = "range", value_name = "G", default_value_t = SensorOptions::default().accel_range_g))]
    pub accel_range_g: u32,
    /// Factor on all noise, 0 to 100
    #[serde(rename(deserialize = "noise"))]
    #[cfg_attr(feature = "clap", arg(long = "noise", value_name = "FACTOR", default_value_t = SensorOptions::default().noise_factor))]
    pub noise_factor: f64,
    /// Scale error, 0 to 10 % (sd)
    #[serde(rename(deserialize = "scale_sd"))]
    #[cfg_attr(feature = "clap", arg(long = "scale-sd", value_name = "PERCENT", default_value_t = SensorOptions::default().scale_sd_percent))]
    pub scale_sd_percent: f64,
    /// Warming above 25 °C, ±40 °C
    #[serde(rename(deserialize = "temperature_rise"))]
    #[cfg_attr(feature = "clap", arg(long = "temperature-rise", value_name = "C", default_value_t = SensorOptions::default().temperature_rise_c, allow_negative_numbers = true))]
    pub temperature_rise_c: f64,
    /// Drift of bias, 0 to 10 mg per °C
    #[serde(rename(deserialize = "temperature_drift"))]
    #[cfg_attr(feature = "clap", arg(long = "temperature-drift", value_name = "MG_C", default_value_t = SensorOptions::default().bias_drift_mg_per_c))]
    pub bias_drift_mg_per_c: f64,
    /// Time constant of the warming, s. Default 120.
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().temperature_time_s))]
    pub temperature_time_s: f64,
    /// Round to whole counts. Default true; false is for tests of the physics.
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", arg(skip = true))]
    pub quantise: bool,
    /// M of the accelerometer, row-major. Default drawn.
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub accel_matrix: Option<[[f64; 3]; 3]>,
    /// Bias of the accelerometer at 25 °C, m/s². Default drawn.
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub accel_bias_mps2: Option<[f64; 3]>,
}

impl Default for SensorOptions {
    fn default() -> Self {
        Self {
            accel_range_g: 2,
            noise_factor: 1.0,
            scale_sd_percent: 2.0,
            temperature_rise_c: 1.5,
            bias_drift_mg_per_c: 0.5,
            temperature_time_s: 120.0,
            quantise: true,
            accel_matrix: None,
            accel_bias_mps2: None,
        }
    }
}

/// Format of a recording: m/s² and rad/s under a header that says so.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct FileOptions {
    /// Decimal places, 1 to 9
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = FileOptions::default().decimals))]
    pub decimals: u8,
    /// Raw counts instead of m/s² and rad/s
    #[cfg_attr(feature = "clap", arg(long, conflicts_with_all = ["wrong_header", "decimals"]))]
    pub raw: bool,
    /// Header of g and °/s over m/s² and rad/s
    #[cfg_attr(feature = "clap", arg(long))]
    pub wrong_header: bool,
}

impl Default for FileOptions {
    fn default() -> Self {
        Self {
            decimals: 4,
            raw: false,
            wrong_header: false,
        }
    }
}
