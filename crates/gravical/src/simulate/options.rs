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
    /// Local gravity, m/s²
    #[serde(rename(deserialize = "gravity"))]
    #[cfg_attr(feature = "clap", arg(long = "gravity", value_name = "MPS2", default_value_t = SimulateOptions::default().gravity_mps2))]
    pub gravity_mps2: f64,
    /// True sampling rate, Hz
    #[serde(rename(deserialize = "rate"))]
    #[cfg_attr(feature = "clap", arg(long = "rate", value_name = "HZ", default_value_t = SimulateOptions::default().rate_hz))]
    pub rate_hz: f64,
    /// Rate error of the board's clock, parts per million: a stamp is the true time times (1 +
    /// this·10⁻⁶). Default 0; range ±50 000.
    #[serde(rename(deserialize = "clock_error"))]
    #[cfg_attr(feature = "clap", arg(skip = SimulateOptions::default().clock_error_ppm))]
    pub clock_error_ppm: f64,
    /// Jitter of the time stamps, ± ms
    #[serde(rename(deserialize = "jitter"))]
    #[cfg_attr(feature = "clap", arg(long = "jitter", value_name = "MS", default_value_t = SimulateOptions::default().stamp_jitter_ms))]
    pub stamp_jitter_ms: f64,
    /// Share of lost rows, 0 to 0.9
    #[serde(rename(deserialize = "drop"))]
    #[cfg_attr(feature = "clap", arg(long = "drop", value_name = "FRACTION", default_value_t = SimulateOptions::default().dropped_fraction))]
    pub dropped_fraction: f64,
    /// Tilt of a pose, ° (sd of each component)
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

/// Options that change several fields of [`SimulateOptions`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct SimulateChanges {
    /// Factor on all noise; 0 switches it off
    #[serde(rename = "noise")]
    #[cfg_attr(feature = "clap", arg(long = "noise", value_name = "FACTOR", default_value_t = SimulateChanges::default().noise_factor))]
    pub noise_factor: f64,
    /// Raw counts instead of m/s² and rad/s
    #[cfg_attr(feature = "clap", arg(long, conflicts_with_all = ["wrong_header", "decimals"]))]
    pub raw: bool,
    /// Header of g and °/s over m/s² and rad/s
    #[cfg_attr(feature = "clap", arg(long))]
    pub wrong_header: bool,
}

impl Default for SimulateChanges {
    fn default() -> Self {
        Self {
            noise_factor: 1.0,
            raw: false,
            wrong_header: false,
        }
    }
}

impl SimulateChanges {
    /// The options with the changes.
    ///
    /// # Errors
    ///
    /// `simulate-option` (usage) for raw counts under a header of units.
    pub fn of(self, mut options: SimulateOptions) -> Result<SimulateOptions> {
        options.sensor = options.sensor.with_noise_factor(self.noise_factor);
        options.file.format = match (self.raw, self.wrong_header) {
            (true, true) => return Err(bad("raw counts have no header of units")),
            (true, false) => FileFormat::Raw,
            (false, true) => FileFormat::WrongHeader,
            (false, false) => options.file.format,
        };
        Ok(options)
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
            clock_error_ppm: 0.0,
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
        within("clock-error", self.clock_error_ppm, -5e4, 5e4, "ppm")?;
        let jitter_limit_ms = 400.0 / self.rate_hz;
        within("jitter", self.stamp_jitter_ms, 0.0, jitter_limit_ms, "ms")?;
        within("drop", self.dropped_fraction, 0.0, 0.9, "of the rows")?;
        within("tilt", self.tilt_sd_deg, 0.0, 20.0, "°")?;
        self.sensor.validate()?;
        self.file.validate()?;
        if self.file.format == FileFormat::Raw && !self.sensor.quantise {
            return Err(bad(
                "raw counts need a quantised sensor: leave `quantise` on",
            ));
        }
        Ok(())
    }
}

/// The virtual MPU6050. Parameters that are not given are drawn from the seed.
///
/// Model, per sample: `u = M f + b(T)`, `v = M_g ω + b_g + K f`, both with
/// white noise, then a second-order low-pass, then rounding to counts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "clap", command(next_help_heading = "Sensor"))]
pub struct SensorOptions {
    /// Range, g: 2, 4, 8 or 16
    #[serde(rename(deserialize = "range"))]
    #[cfg_attr(feature = "clap", arg(long = "range", value_name = "G", default_value_t = SensorOptions::default().accel_range_g))]
    pub accel_range_g: u32,
    /// Measuring range of the gyroscope, °/s: 250, 500, 1000 or 2000.
    /// Default 250.
    #[serde(rename(deserialize = "gyro_range"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().gyro_range_deg_s))]
    pub gyro_range_deg_s: u32,
    /// Round to whole counts. Default true; false is for tests of the physics.
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().quantise))]
    pub quantise: bool,
    /// −3 dB frequency of the sensor's second-order low-pass, Hz; it delays the signal by 0.225/f
    /// (5.1 ms at 44 Hz). Default 44; range 1 to 260; `None` = no filter: the noise is then
    /// limited only by the 1 kHz of the simulation.
    #[serde(rename(deserialize = "low_pass"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().low_pass_hz))]
    pub low_pass_hz: Option<f64>,
    /// M of the accelerometer, row-major, dimensionless. Default drawn.
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().accel_matrix))]
    pub accel_matrix: Option<[[f64; 3]; 3]>,
    /// Bias of the accelerometer at 25 °C, m/s². Default drawn.
    #[serde(rename(deserialize = "accel_bias"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().accel_bias_mps2))]
    pub accel_bias_mps2: Option<[f64; 3]>,
    /// M of the gyroscope, row-major, dimensionless. Default drawn.
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().gyro_matrix))]
    pub gyro_matrix: Option<[[f64; 3]; 3]>,
    /// Bias of the gyroscope, rad/s. Default drawn.
    #[serde(rename(deserialize = "gyro_bias"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().gyro_bias_rad_s))]
    pub gyro_bias_rad_s: Option<[f64; 3]>,
    /// Scale error, % (sd)
    #[serde(rename(deserialize = "scale_sd"))]
    #[cfg_attr(feature = "clap", arg(long = "scale-sd", value_name = "PERCENT", default_value_t = SensorOptions::default().scale_sd_percent))]
    pub scale_sd_percent: f64,
    /// Standard deviation of every off-diagonal element of M, as an angle in
    /// degrees, both sensors. Default 1 (data sheet: ±2 % cross-axis); range 0
    /// to 10.
    #[serde(rename(deserialize = "misalignment"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().misalignment_sd_deg))]
    pub misalignment_sd_deg: f64,
    /// Half width of the uniform distribution of the accelerometer's bias,
    /// m/s². Default 0.5 (data sheet: ±50 mg); range 0 to 200.
    #[serde(rename(deserialize = "accel_bias_limit"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().accel_bias_limit_mps2))]
    pub accel_bias_limit_mps2: f64,
    /// Half width of the uniform distribution of the gyroscope's scale, %.
    /// Default 3 (data sheet); range 0 to 20.
    #[serde(rename(deserialize = "gyro_scale"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().gyro_scale_limit_percent))]
    pub gyro_scale_limit_percent: f64,
    /// Half width of the uniform distribution of the gyroscope's bias, °/s.
    /// Default 2; range 0 to 100.
    #[serde(rename(deserialize = "gyro_bias_limit"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().gyro_bias_limit_deg_s))]
    pub gyro_bias_limit_deg_s: f64,
    /// Standard deviation of every element of the gyroscope's sensitivity to
    /// acceleration, °/s per g. Default 0.1 (data sheet); range 0 to 5.
    #[serde(rename(deserialize = "g_sensitivity"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().g_sensitivity_sd_deg_s_per_g))]
    pub g_sensitivity_sd_deg_s_per_g: f64,
    /// Noise of the accelerometer, Allan N in m/s/√s: white noise of standard
    /// deviation N/√t in means over t seconds. Default 3.3e-3; range 0 to 1.
    #[serde(rename(deserialize = "accel_noise"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().accel_noise_mps_rts))]
    pub accel_noise_mps_rts: f64,
    /// Noise of the gyroscope, Allan N in °/√s. Default 0.005; range 0 to 1.
    #[serde(rename(deserialize = "gyro_noise"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().gyro_noise_deg_rts))]
    pub gyro_noise_deg_rts: f64,
    /// Bias instability of the accelerometer, B, m/s². Default 0; range 0 to 1.
    #[serde(skip_serializing_if = "is_zero")]
    #[serde(rename(deserialize = "accel_bias_instability"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().accel_bias_instability_mps2))]
    pub accel_bias_instability_mps2: f64,
    /// Random walk of the accelerometer's bias, K, m/s²/√s. Default 0; range 0 to 0.1.
    #[serde(skip_serializing_if = "is_zero")]
    #[serde(rename(deserialize = "accel_random_walk"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().accel_random_walk_mps2_rts))]
    pub accel_random_walk_mps2_rts: f64,
    /// Bias instability of the gyroscope, B, °/h. Default 0; range 0 to 10 000.
    #[serde(skip_serializing_if = "is_zero")]
    #[serde(rename(deserialize = "gyro_bias_instability"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().gyro_bias_instability_deg_h))]
    pub gyro_bias_instability_deg_h: f64,
    /// Random walk of the gyroscope's bias, K, °/s/√s. Default 0; range 0 to 1.
    #[serde(skip_serializing_if = "is_zero")]
    #[serde(rename(deserialize = "gyro_random_walk"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().gyro_random_walk_deg_s_rts))]
    pub gyro_random_walk_deg_s_rts: f64,
    /// Standard deviation of a temperature reading, °C. Default 0.02; range 0
    /// to 1.
    #[serde(rename(deserialize = "temperature_noise"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().temperature_noise_c))]
    pub temperature_noise_c: f64,
    /// Warming above 25 °C, °C
    #[serde(rename(deserialize = "temperature_rise"))]
    #[cfg_attr(feature = "clap", arg(long = "temperature-rise", value_name = "C", default_value_t = SensorOptions::default().temperature_rise_c, allow_negative_numbers = true))]
    pub temperature_rise_c: f64,
    /// Time constant of the warming, s. Default 120; range 1 to 10⁵.
    #[serde(rename(deserialize = "temperature_time"))]
    #[cfg_attr(feature = "clap", arg(skip = SensorOptions::default().temperature_time_s))]
    pub temperature_time_s: f64,
    /// Drift of bias, mg per °C
    #[serde(rename(deserialize = "temperature_drift"))]
    #[cfg_attr(feature = "clap", arg(long = "temperature-drift", value_name = "MG_C", default_value_t = SensorOptions::default().bias_drift_mg_per_c))]
    pub bias_drift_mg_per_c: f64,
}

impl Default for SensorOptions {
    fn default() -> Self {
        Self {
            accel_range_g: 2,
            gyro_range_deg_s: 250,
            quantise: true,
            low_pass_hz: Some(44.0),
            accel_matrix: None,
            accel_bias_mps2: None,
            gyro_matrix: None,
            gyro_bias_rad_s: None,
            scale_sd_percent: 2.0,
            misalignment_sd_deg: 1.0,
            accel_bias_limit_mps2: 0.5,
            gyro_scale_limit_percent: 3.0,
            gyro_bias_limit_deg_s: 2.0,
            g_sensitivity_sd_deg_s_per_g: 0.1,
            accel_noise_mps_rts: 3.3e-3,
            gyro_noise_deg_rts: 0.005,
            accel_bias_instability_mps2: 0.0,
            accel_random_walk_mps2_rts: 0.0,
            gyro_bias_instability_deg_h: 0.0,
            gyro_random_walk_deg_s_rts: 0.0,
            temperature_noise_c: 0.02,
            temperature_rise_c: 1.5,
            temperature_time_s: 120.0,
            bias_drift_mg_per_c: 0.5,
        }
    }
}

/// Options that are off are not written: files of earlier versions stay as they are.
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl SensorOptions {
    /// A sensor without any errors: M = 1, no bias, no noise, no low-pass, no rounding, constant
    /// temperature. It still clips at its range.
    #[must_use]
    pub fn ideal() -> Self {
        Self {
            quantise: false,
            low_pass_hz: None,
            scale_sd_percent: 0.0,
            misalignment_sd_deg: 0.0,
            accel_bias_limit_mps2: 0.0,
            gyro_scale_limit_percent: 0.0,
            gyro_bias_limit_deg_s: 0.0,
            g_sensitivity_sd_deg_s_per_g: 0.0,
            temperature_rise_c: 0.0,
            bias_drift_mg_per_c: 0.0,
            ..Self::default()
        }
        .with_noise_factor(0.0)
    }

    /// Multiplies the noise of accelerometer, gyroscope and thermometer.
    #[must_use]
    pub fn with_noise_factor(mut self, factor: f64) -> Self {
        self.accel_noise_mps_rts *= factor;
        self.gyro_noise_deg_rts *= factor;
        self.accel_bias_instability_mps2 *= factor;
        self.accel_random_walk_mps2_rts *= factor;
        self.gyro_bias_instability_deg_h *= factor;
        self.gyro_random_walk_deg_s_rts *= factor;
        self.temperature_noise_c *= factor;
        self
    }

    /// Counts per °/s; `None` for a range that the part does not have.
    pub(super) fn gyro_lsb_per_deg_s(&self) -> Option<f64> {
        mpu6050_gyroscope_lsb_per_deg_s(u16::try_from(self.gyro_range_deg_s).ok()?)
    }

    fn validate(&self) -> Result<()> {
        if ![2, 4, 8, 16].contains(&self.accel_range_g) {
            let given = self.accel_range_g;
            return Err(bad(format!("range {given} g: the part has 2, 4, 8, 16 g")));
        }
        if self.gyro_lsb_per_deg_s().is_none() {
            let given = self.gyro_range_deg_s;
            return Err(bad(format!(
                "gyro-range {given} °/s: the part has 250, 500, 1000, 2000 °/s"
            )));
        }
        if let Some(f) = self.low_pass_hz {
            within("low-pass", f, 1.0, 260.0, "Hz")?;
        }
        for (name, value, low, high, unit) in [
            ("scale-sd", self.scale_sd_percent, 0.0, 10.0, "%"),
            ("misalignment", self.misalignment_sd_deg, 0.0, 10.0, "°"),
            ("bias", self.accel_bias_limit_mps2, 0.0, 200.0, "m/s²"),
            ("gyro-scale", self.gyro_scale_limit_percent, 0.0, 20.0, "%"),
            ("gyro-bias", self.gyro_bias_limit_deg_s, 0.0, 100.0, "°/s"),
            (
                "g-sensitivity",
                self.g_sensitivity_sd_deg_s_per_g,
                0.0,
                5.0,
                "°/s/g",
            ),
            ("accel-noise", self.accel_noise_mps_rts, 0.0, 1.0, "m/s/√s"),
            ("gyro-noise", self.gyro_noise_deg_rts, 0.0, 1.0, "°/√s"),
            (
                "accel-bias-instability",
                self.accel_bias_instability_mps2,
                0.0,
                1.0,
                "m/s²",
            ),
            (
                "accel-random-walk",
                self.accel_random_walk_mps2_rts,
                0.0,
                0.1,
                "m/s²/√s",
            ),
            (
                "gyro-bias-instability",
                self.gyro_bias_instability_deg_h,
                0.0,
                1e4,
                "°/h",
            ),
            (
                "gyro-random-walk",
                self.gyro_random_walk_deg_s_rts,
                0.0,
                1.0,
                "°/s/√s",
            ),
            (
                "temperature-noise",
                self.temperature_noise_c,
                0.0,
                1.0,
                "°C",
            ),
            (
                "temperature-rise",
                self.temperature_rise_c,
                -40.0,
                40.0,
                "°C",
            ),
            ("temperature-time", self.temperature_time_s, 1.0, 1e5, "s"),
            (
                "temperature-drift",
                self.bias_drift_mg_per_c,
                0.0,
                10.0,
                "mg/°C",
            ),
        ] {
            within(name, value, low, high, unit)?;
        }
        let given = [self.accel_matrix, self.gyro_matrix];
        let matrices = given.iter().flatten().flatten().flatten();
        let given = [self.accel_bias_mps2, self.gyro_bias_rad_s];
        let biases = given.iter().flatten().flatten();
        if !matrices.chain(biases).all(|v| v.is_finite()) {
            return Err(bad(
                "a given matrix or bias holds a value that is not finite",
            ));
        }
        Ok(())
    }
}

/// Format of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct FileOptions {
    /// Header and units. Default [`FileFormat::TrueHeader`].
    #[serde(skip_deserializing)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub format: FileFormat,
    /// Decimal places
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = FileOptions::default().decimals))]
    pub decimals: u8,
}

impl Default for FileOptions {
    fn default() -> Self {
        Self {
            format: FileFormat::TrueHeader,
            decimals: 4,
        }
    }
}

impl FileOptions {
    fn validate(self) -> Result<()> {
        within("decimals", f64::from(self.decimals), 1.0, 9.0, "digits")
    }
}

/// Header and units of a written recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FileFormat {
    #[default]
    /// m/s² and rad/s, and a header that says so.
    TrueHeader,
    /// The same values under the header of the student report's logger, which names g and °/s.
    WrongHeader,
    /// Counts of the part, int16.
    Raw,
}
