//! Settings and commands of our firmware (`firmware/mpu6050_logger`).

use gravical_judge::{Error, Result};
use gravical_recording::BoardSettings;

/// Settings that the board must have; none: as they are.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct WantedSettings {
    /// Of the accelerometer in g: 2, 4, 8, 16
    #[cfg_attr(feature = "clap", arg(id = "range", long = "range", value_name = "G", value_parser = one_of(["2", "4", "8", "16"]), hide_possible_values = true))]
    pub range_g: Option<u16>,
    /// Of the gyroscope in °/s: 250, 500, 1000, 2000
    #[cfg_attr(feature = "clap", arg(id = "gyro_range", long = "gyro-range", value_name = "DPS", value_parser = one_of(["250", "500", "1000", "2000"]), hide_possible_values = true))]
    pub gyro_range_deg_s: Option<u16>,
    /// In Hz: 4 to 150, with counts to 250
    #[cfg_attr(feature = "clap", arg(id = "rate", long = "rate", value_name = "HZ"))]
    pub rate_hz: Option<u16>,
    /// In Hz: 184, 94, 44, 21, 10, 5
    #[cfg_attr(feature = "clap", arg(id = "low_pass", long = "low-pass", value_name = "HZ", value_parser = one_of(["184", "94", "44", "21", "10", "5"]), hide_possible_values = true))]
    pub low_pass_hz: Option<u16>,
    /// si, counts, or calibrated by the board's sketch
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "NAME", hide_possible_values = true)
    )]
    pub format: Option<RowFormat>,
}

/// One of these numbers.
#[cfg(feature = "clap")]
fn one_of<const N: usize>(
    values: [&'static str; N],
) -> impl clap::builder::TypedValueParser<Value = u16> {
    use clap::builder::{PossibleValuesParser, TypedValueParser as _};
    PossibleValuesParser::new(values).try_map(|value| value.parse::<u16>())
}

/// Unit and scale of the rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum RowFormat {
    /// m/s², °C and °/s
    Si = 0,
    /// raw counts
    Counts = 1,
    /// m/s², °C and rad/s, calibrated by a board whose sketch has a calibration
    Calibrated = 3,
}

/// Highest sampling rates as text in SI units and as counts, Hz. 115200 baud are 11520 bytes a
/// second; a row has up to 70 bytes in SI units and 45 in counts.
const MAX_SI_HZ: u16 = 150;
const MAX_COUNTS_HZ: u16 = 250;

impl WantedSettings {
    /// Checks the rate.
    ///
    /// # Errors
    ///
    /// `option-range` (usage) above the capacity of the serial line.
    pub fn validate(&self) -> Result<()> {
        let (max, unit) = match self.format {
            Some(RowFormat::Counts) => (MAX_COUNTS_HZ, "as counts"),
            _ => (MAX_SI_HZ, "in SI units"),
        };
        let Some(rate) = self.rate_hz.filter(|rate| !(4..=max).contains(rate)) else {
            return Ok(());
        };
        let text = format!("{rate} is not between 4 and {max} Hz {unit}");
        let error = Error::range("rate", text);
        if max == MAX_COUNTS_HZ {
            return Err(error);
        }
        let hint = format!("counts carry up to {MAX_COUNTS_HZ} Hz");
        Err(error.with_hint(hint).advise("format", "counts"))
    }

    /// The commands for these settings, one a line; empty if none is wanted.
    pub fn commands(&self) -> String {
        let all = [
            ('a', self.range_g),
            ('g', self.gyro_range_deg_s),
            ('d', self.low_pass_hz),
            ('r', self.rate_hz),
            ('f', self.format.map(|format| format as u16)),
        ];
        let wanted = all.iter().filter_map(|(letter, v)| Some((letter, (*v)?)));
        wanted.map(|(letter, v)| format!("{letter}{v}\n")).collect()
    }

    /// Whether the board has these settings.
    pub fn is_met_by(&self, settings: &BoardSettings) -> bool {
        let met = |wanted: Option<u16>, is: u16| wanted.is_none_or(|w| w == is);
        met(self.range_g, settings.accel_range_g)
            && met(self.gyro_range_deg_s, settings.gyro_range_deg_s)
            && met(self.low_pass_hz, settings.low_pass_hz)
            && met(self.format.map(|f| f as u16), settings.format.into())
            && self.rate_hz.is_none_or(|rate| {
                // The period of the sensor is a whole number of milliseconds.
                let period_ms = 1000 / rate.clamp(4, 250);
                // The board prints two decimals, truncated.
                (settings.rate_hz - 1000.0 / f64::from(period_ms)).abs() < 0.011
            })
    }
}
