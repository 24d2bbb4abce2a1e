//! Options of the virtual sensor, with unit, default and range.

use gravical_core::unit::mpu6050_gyroscope_lsb_per_deg_s;
use serde::{Deserialize, Serialize};

use super::range::{bad, within};
use super::scenario_options::Scenario;
use crate::Result;

/// All options of a simulation: equal options give identical files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct SimulateOptions {
    /// What is simulated. Default: static.
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", arg(skip))]
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
        Self::new(Scenario::default())
    }
}

impl SimulateOptions {
    /// The defaults for `scenario`.
    #[must_use]
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
        within("gravity", self.gravity_mps2, 9.7, 9.9, "m/s²")?;
        within("rate", self.rate_hz, 1.0, 1000.0, "Hz")?;
        within(
            "jitter",
            self.stamp_jitter_ms,
            0.0,
            400.0 / self.rate_hz,
            "ms",
        )?;
        within("drop", self.dropped_fraction, 0.0, 0.9, "of the rows")?;
        within("tilt", self.tilt_sd_deg, 0.0, 20.0, "°")?;
        within(
            "decimals",
            f64::from(self.file.decimals),
            1.0,
            9.0,
            "digits",
        )?;
        if self.file.raw && self.file.wrong_header {
            return Err(bad("raw counts have no header of units"));
        }
        if self.file.raw && !self.sensor.quantise {
            return Err(bad(
                "raw counts need a quantised sensor: leave `quantise` on",
            ));
        }
        self.sensor.validate()
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
    /// Range of the gyroscope, °/s: 250, 500, 1000 or 2000. Default 250.
    #[serde(rename(deserialize = "gyro_range"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().gyro_range_deg_s))]
    pub gyro_range_deg_s: u32,
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
    /// −3 dB frequency of the second-order low-pass, Hz; it delays the signal by 0.225/f. `None`: no filter.
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().low_pass_hz))]
    pub low_pass_hz: Option<f64>,
    /// M of the accelerometer, row-major. Default drawn.
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub accel_matrix: Option<[[f64; 3]; 3]>,
    /// Bias of the accelerometer at 25 °C, m/s². Default drawn.
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub accel_bias_mps2: Option<[f64; 3]>,
    /// Factor on the errors that have no option: cross-axis, biases, gyroscope. Default 1; 0 is for tests.
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", arg(skip = 1.0))]
    pub error_factor: f64,
}

impl Default for SensorOptions {
    fn default() -> Self {
        Self {
            accel_range_g: 2,
            gyro_range_deg_s: 250,
            noise_factor: 1.0,
            scale_sd_percent: 2.0,
            temperature_rise_c: 1.5,
            bias_drift_mg_per_c: 0.5,
            temperature_time_s: 120.0,
            quantise: true,
            low_pass_hz: Some(44.0),
            accel_matrix: None,
            accel_bias_mps2: None,
            error_factor: 1.0,
        }
    }
}

impl SensorOptions {
    /// A sensor without any errors: M = 1, no bias, noise, low-pass or rounding, constant temperature. It
    /// still clips at its range.
    #[must_use]
    pub fn ideal() -> Self {
        Self {
            noise_factor: 0.0,
            scale_sd_percent: 0.0,
            temperature_rise_c: 0.0,
            bias_drift_mg_per_c: 0.0,
            quantise: false,
            low_pass_hz: None,
            error_factor: 0.0,
            ..Self::default()
        }
    }

    /// Counts per °/s; `None` for a range that the part does not have.
    pub(super) fn gyro_lsb_per_deg_s(&self) -> Option<f64> {
        mpu6050_gyroscope_lsb_per_deg_s(u16::try_from(self.gyro_range_deg_s).ok()?)
    }

    fn validate(&self) -> Result<()> {
        let (range_g, range_deg_s) = (self.accel_range_g, self.gyro_range_deg_s);
        if ![2, 4, 8, 16].contains(&range_g) {
            return Err(bad(format!(
                "range {range_g} g: the part has 2, 4, 8, 16 g"
            )));
        }
        if self.gyro_lsb_per_deg_s().is_none() {
            let text =
                format!("gyro-range {range_deg_s} °/s: the part has 250, 500, 1000, 2000 °/s");
            return Err(bad(text));
        }
        within(
            "low-pass",
            self.low_pass_hz.unwrap_or(44.0),
            1.0,
            260.0,
            "Hz",
        )?;
        within("noise", self.noise_factor, 0.0, 100.0, "")?;
        within("scale-sd", self.scale_sd_percent, 0.0, 10.0, "%")?;
        within(
            "temperature-rise",
            self.temperature_rise_c,
            -40.0,
            40.0,
            "°C",
        )?;
        within(
            "temperature-drift",
            self.bias_drift_mg_per_c,
            0.0,
            10.0,
            "mg/°C",
        )
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
