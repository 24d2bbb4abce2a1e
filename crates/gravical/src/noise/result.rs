//! The noise of a sensor, as it is written, beside that of data sheets.

use std::path::Path;
use std::str::FromStr;

use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use serde::{Deserialize, Serialize};

use super::Term;
use crate::calibration_file::{InputFile, InputRole, NoiseParameters, NoiseSection};
use crate::finding::Finding;
use crate::{Error, Result};

/// Value of `format`.
pub const NOISE_FORMAT: &str = "gravical-noise/1";

/// Noise of a sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NoiseResult {
    /// `gravical-noise/1`.
    pub format: String,
    /// Program and version.
    pub tool: String,
    /// The recording.
    pub inputs: Vec<InputFile>,
    /// Text format of the recording in words.
    pub description: String,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Duration of the recording, s.
    pub recorded_s: f64,
    /// Duration of the samples that were used, s.
    pub used_s: f64,
    /// Number of static intervals that were used.
    pub static_intervals: usize,
    /// Number of segments between gaps.
    pub segments: u64,
    /// Lowest and highest temperature of the samples that were used, °C.
    pub temperature_c: Option<[f64; 2]>,
    /// One for each of ax, ay, az, gx, gy, gz that was recorded.
    pub channels: Vec<ChannelNoise>,
    /// What is odd.
    pub findings: Vec<Finding>,
}

impl NoiseResult {
    /// The channel with this name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&ChannelNoise> {
        self.channels.iter().find(|c| c.channel == name)
    }

    /// What a calibration file keeps.
    #[must_use]
    pub fn section(&self) -> NoiseSection {
        NoiseSection {
            rate_hz: self.rate_hz,
            used_s: self.used_s,
            channels: self.channels.iter().map(ChannelNoise::parameters).collect(),
        }
    }
}

#[cfg(feature = "schema")]
impl NoiseResult {
    /// JSON schema of the file.
    #[must_use]
    pub fn schema() -> serde_json::Value {
        schemars::schema_for!(NoiseResult).to_value()
    }
}

/// Reads the result that `gravical noise` wrote.
///
/// # Errors
///
/// `not-noise` for any other file; errors of the file system.
pub fn read_noise(path: &Path) -> Result<(NoiseResult, InputFile)> {
    InputFile::read(path, InputRole::Noise, parse)
}

fn parse(bytes: &[u8]) -> Result<NoiseResult> {
    let hint = "give the file of `gravical noise REST.csv -o noise.json`";
    let result: NoiseResult = serde_json::from_slice(bytes).map_err(|e| {
        Error::input("not-noise", format!("no result of `gravical noise`: {e}"))
            .with_hint(hint)
            .advise("noise", "")
    })?;
    if result.format != NOISE_FORMAT {
        return Err(Error::input(
            "not-noise",
            format!("the format is {:?}, not {NOISE_FORMAT}", result.format),
        )
        .with_hint(hint)
        .advise("noise", ""));
    }
    let numbers = result.channels.iter().flat_map(|c| [c.n, c.b, c.k]);
    if numbers
        .flatten()
        .any(|e| !(e.value.is_finite() && e.value > 0.0))
    {
        return Err(
            Error::input("not-noise", "a parameter is not a positive number").with_hint(hint),
        );
    }
    Ok(result)
}

/// Noise of one channel, in its [unit](Self::unit), seconds and hertz.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChannelNoise {
    /// `ax` … `gz`.
    pub channel: String,
    /// `m/s^2` or `rad/s`.
    pub unit: String,
    /// The Allan deviation.
    pub adev: Vec<AllanPoint>,
    /// Noise density (velocity or angle random walk), unit/√Hz; null if it is not observable.
    pub n: Option<Estimate>,
    /// Bias instability, unit.
    pub b: Option<Estimate>,
    /// Random walk (of the acceleration or rate), unit/√s.
    pub k: Option<Estimate>,
    /// Terms that are not observable.
    pub not_observable: Vec<NotObservable>,
    /// The fitted curve; null without one.
    pub fit: Option<FittedCurve>,
    /// N by the power spectral density.
    pub density: Option<DensityCheck>,
    /// N by the data sheet.
    pub data_sheet: Option<DataSheet>,
    /// Dependence on the temperature, where it explains most of the slow changes.
    pub temperature: Option<TemperatureDrift>,
}

impl ChannelNoise {
    /// The estimate of a term.
    #[must_use]
    pub fn estimate(&self, term: Term) -> Option<&Estimate> {
        match term {
            Term::N => self.n.as_ref(),
            Term::B => self.b.as_ref(),
            Term::K => self.k.as_ref(),
        }
    }

    /// Why a term is not observable.
    #[must_use]
    pub fn missing(&self, term: Term) -> Option<&NotObservable> {
        self.not_observable.iter().find(|t| t.term == term.symbol())
    }

    /// What a calibration file keeps.
    fn parameters(&self) -> NoiseParameters {
        let value = |term: Term| self.estimate(term).map(|e| e.value);
        let most = |term: Term| self.missing(term)?.at_most;
        NoiseParameters {
            channel: self.channel.clone(),
            n: value(Term::N),
            b: value(Term::B),
            k: value(Term::K),
            n_at_most: most(Term::N),
            b_at_most: most(Term::B),
            k_at_most: most(Term::K),
        }
    }

    /// True for an axis of the gyroscope.
    #[must_use]
    pub fn is_gyroscope(&self) -> bool {
        self.channel.starts_with('g')
    }
}

/// A point of the Allan deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AllanPoint {
    /// Averaging time, s.
    pub tau_s: f64,
    /// Allan deviation.
    pub sigma: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// Equivalent degrees of freedom of its square.
    pub edf: f64,
}

/// Parameters of the fitted curve; zero for a term that is not part of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FittedCurve {
    /// Shortest averaging time that was used, s.
    pub from_s: f64,
    /// N, B, K.
    pub parameters: [f64; 3],
    /// Steady drift of the bias, unit/s, that is not random; null where there is none.
    pub drift_per_s: Option<f64>,
    /// Where the recording deviates most from the curve, by more than chance; null if nowhere.
    pub misfit: Option<Misfit>,
}

/// A deviation from the fitted curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Misfit {
    /// Averaging time, s.
    pub tau_s: f64,
    /// Allan variance over that of the curve.
    pub ratio: f64,
}

impl FittedCurve {
    /// Allan deviation at an averaging time.
    #[must_use]
    pub fn deviation(&self, tau_s: f64) -> f64 {
        let terms = Term::ALL.iter().zip(self.parameters);
        let noise: f64 = terms.map(|(term, x)| x * x * term.shape(tau_s)).sum();
        let drift = self.drift_per_s.unwrap_or(0.0) * tau_s;
        (noise + 0.5 * drift * drift).sqrt()
    }
}

/// N by the power spectral density.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DensityCheck {
    /// N.
    pub n: f64,
    /// Band, Hz.
    pub band_hz: [f64; 2],
    /// Power in the band over that of the fitted curve.
    pub ratio: f64,
    /// Standard deviation of the ratio by chance.
    pub ratio_sd: f64,
}

/// Dependence of the slow changes on the temperature.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TemperatureDrift {
    /// Change for each °C.
    pub slope_per_c: f64,
    /// Share of the variance of slow changes that it explains, 0 to 1.
    pub explained: f64,
}

/// A parameter with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// A term that this recording does not determine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NotObservable {
    /// `N`, `B` or `K`.
    pub term: String,
    /// Why, and what to do.
    pub reason: String,
    /// Upper limit (95 %), in the unit of the term; null if there is none.
    pub at_most: Option<f64>,
    /// Length of a recording that would show a term as large as the limit, s; null if even a
    /// thousand times the length would not.
    pub record_s: Option<f64>,
}

/// A part, with the noise densities of its data sheet.
///
/// Data sheets state the root of the one-sided power spectral density; N of the Allan deviation is
/// smaller by √2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Its name.
    pub name: &'static str,
    /// Noise density of the accelerometer, µg/√Hz.
    pub accel_ug_rthz: f64,
    /// Noise density of the gyroscope, °/s/√Hz.
    pub gyro_deg_s_rthz: f64,
}

/// The parts whose data sheets were read, with typical values: MPU-6000/MPU-6050 revision 3.4 (at
/// 10 Hz), MPU-9250 revision 1.0 (low-noise mode), ICM-42688-P revision 1.7.
pub const PARTS: &[Part] = &[
    Part {
        name: "MPU6050",
        accel_ug_rthz: 400.0,
        gyro_deg_s_rthz: 0.005,
    },
    Part {
        name: "MPU9250",
        accel_ug_rthz: 300.0,
        gyro_deg_s_rthz: 0.01,
    },
    Part {
        name: "ICM42688P",
        accel_ug_rthz: 70.0,
        gyro_deg_s_rthz: 0.0028,
    },
];

impl Part {
    /// N of the accelerometer, m/s²/√Hz, or of the gyroscope, rad/s/√Hz.
    #[must_use]
    pub fn n(&self, gyroscope: bool) -> f64 {
        let density = if gyroscope {
            self.gyro_deg_s_rthz.to_radians()
        } else {
            self.accel_ug_rthz * 1e-6 * STANDARD_GRAVITY_MPS2
        };
        density / 2_f64.sqrt()
    }

    /// N of a channel beside that of the part.
    pub(super) fn data_sheet(&self, channel: &ChannelNoise) -> DataSheet {
        let n = self.n(channel.is_gyroscope());
        DataSheet {
            part: self.name.to_owned(),
            n,
            ratio: channel.n.map(|e| e.value / n),
        }
    }
}

impl FromStr for Part {
    type Err = Error;

    /// The part of that name, whatever its case and hyphens.
    ///
    /// # Errors
    ///
    /// `usage` (usage), with those that are known.
    fn from_str(name: &str) -> Result<Self> {
        let plain = |text: &str| text.replace(['-', ' ', '_'], "").to_ascii_uppercase();
        let part = PARTS.iter().find(|part| plain(part.name) == plain(name));
        part.copied().ok_or_else(|| {
            let known: Vec<&str> = PARTS.iter().map(|part| part.name).collect();
            Error::usage("usage", format!("{name:?} is no part that is known"))
                .with_hint(format!("one of {}", known.join(", ")))
        })
    }
}

/// N of a channel beside that of the data sheet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DataSheet {
    /// Name of the part.
    pub part: String,
    /// N by the data sheet: its one-sided density over √2.
    pub n: f64,
    /// N of the recording over it; null if N is not observable.
    pub ratio: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_one_sided_density_of_the_mpu6050() {
        let part: Part = "mpu-6050".parse().unwrap();
        assert!((part.n(false) - 2.774e-3).abs() < 1e-6);
        // 0.212 °/√h.
        assert!((part.n(true).to_degrees() * 60.0 - 0.2121).abs() < 1e-4);
        assert!("ADXL999".parse::<Part>().is_err());
    }
}
