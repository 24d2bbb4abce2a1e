//! Settings and commands of the firmware (`firmware/mpu6050_logger`).

pub use gravical::recording::board::BoardSettings as Settings;
use gravical::{Error, Result};

/// Settings that the board must have; none: as they are.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Wanted {
    /// Full scale of the accelerometer, g: 2, 4, 8 or 16.
    pub accel_range_g: Option<u16>,
    /// Full scale of the gyroscope, °/s: 250, 500, 1000 or 2000.
    pub gyro_range_deg_s: Option<u16>,
    /// Low-pass, Hz: 184, 94, 44, 21, 10 or 5.
    pub low_pass_hz: Option<u16>,
    /// Sampling rate, Hz: 4 to 250.
    pub rate_hz: Option<u16>,
    /// 0 text in SI units, 1 text in counts, 3 calibrated text.
    pub format: Option<u8>,
}

/// Highest sampling rates in SI units and as counts, Hz. 115200 baud are 11520 bytes a second; a
/// row has up to 70 bytes in SI units and 45 in counts.
const MAX_SI_HZ: u16 = 150;
const MAX_COUNTS_HZ: u16 = 250;

impl Wanted {
    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `option-range` (usage) for values that the sensor does not have, and for a rate above
    /// the capacity of the serial line.
    pub fn validate(&self) -> Result<()> {
        let one_of = |name: &str, value: Option<u16>, of: &[u16]| match value {
            Some(v) if !of.contains(&v) => Err(Error::usage(
                "option-range",
                format!("{name} is one of {of:?}, not {v}"),
            )),
            _ => Ok(()),
        };
        one_of("--range", self.accel_range_g, &[2, 4, 8, 16])?;
        one_of(
            "--gyro-range",
            self.gyro_range_deg_s,
            &[250, 500, 1000, 2000],
        )?;
        one_of("--low-pass", self.low_pass_hz, &[184, 94, 44, 21, 10, 5])?;
        let most = match self.format {
            Some(1) => MAX_COUNTS_HZ,
            _ => MAX_SI_HZ,
        };
        match self.rate_hz {
            Some(rate) if !(4..=most).contains(&rate) => {
                let text = match self.format {
                    Some(1) => " as counts",
                    Some(3) => " as calibrated text",
                    _ => " as text in SI units",
                };
                let error = Error::usage(
                    "option-range",
                    format!("--rate has to be between 4 and {most} Hz{text}, not {rate}"),
                );
                Err(match rate {
                    5..=250 => error.with_hint("--format counts carries 250 Hz"),
                    _ => error,
                })
            }
            _ => Ok(()),
        }
    }

    /// No setting is wanted.
    pub fn is_empty(&self) -> bool {
        *self == Wanted::default()
    }

    /// The commands for these settings, one a line.
    pub fn commands(&self) -> Vec<u8> {
        let one = |letter: char, value: Option<u16>| {
            value.map_or_else(String::new, |v| format!("{letter}{v}\n"))
        };
        [
            one('a', self.accel_range_g),
            one('g', self.gyro_range_deg_s),
            one('d', self.low_pass_hz),
            one('r', self.rate_hz),
            one('f', self.format.map(u16::from)),
        ]
        .concat()
        .into_bytes()
    }

    /// Whether the board has these settings.
    pub fn is_met_by(&self, settings: &Settings) -> bool {
        let met = |wanted: Option<u16>, is: u16| wanted.is_none_or(|w| w == is);
        met(self.accel_range_g, settings.accel_range_g)
            && met(self.gyro_range_deg_s, settings.gyro_range_deg_s)
            && met(self.low_pass_hz, settings.low_pass_hz)
            && met(self.format.map(u16::from), u16::from(settings.format))
            && self.rate_hz.is_none_or(|rate| {
                // The period of the sensor is a whole number of milliseconds.
                let period_ms = 1000 / rate.clamp(4, 1000);
                // The board prints two decimals, truncated.
                (settings.rate_hz - 1000.0 / f64::from(period_ms)).abs() < 0.011
            })
    }

    /// All settings as they are now, to be restored after a reset.
    pub fn exactly(settings: &Settings) -> Self {
        // Rounded down, so that the board's division gives the same period.
        let rate = settings.rate_hz.floor().clamp(4.0, 1000.0);
        Wanted {
            accel_range_g: Some(settings.accel_range_g),
            gyro_range_deg_s: Some(settings.gyro_range_deg_s),
            low_pass_hz: Some(settings.low_pass_hz),
            rate_hz: Some(rate as u16),
            format: Some(settings.format),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: &str = "# gravical mpu6050_logger 1.0, MPU6050, accelerometer +-4 g, gyroscope +-500 deg/s, low-pass 44 Hz, rate 66.66 Hz, format 0";

    #[test]
    fn commands_and_whether_they_are_met() {
        let settings = Settings::parse(LINE).unwrap();
        let mut wanted = Wanted {
            accel_range_g: Some(4),
            rate_hz: Some(64),
            ..Wanted::default()
        };
        assert_eq!(wanted.commands(), b"a4\nr64\n");
        // 1000 / 64 is 15 ms, so that the rate is 66.7 Hz.
        assert!(wanted.is_met_by(&settings));
        wanted.low_pass_hz = Some(21);
        assert!(!wanted.is_met_by(&settings));
        let all = Wanted::exactly(&settings);
        assert_eq!(all.commands(), b"a4\ng500\nd44\nr66\nf0\n");
        assert!(Wanted::default().is_empty() && Wanted::default().commands().is_empty());
    }

    #[test]
    fn settings_are_restored_exactly() {
        for rate in 4..=1000_u16 {
            let period_ms = 1000 / rate;
            let settings = Settings {
                rate_hz: (100_000.0 / f64::from(period_ms)).floor() / 100.0,
                ..Settings::parse(LINE).unwrap()
            };
            assert!(Wanted::exactly(&settings).is_met_by(&settings), "{rate}");
        }
    }

    #[test]
    fn values_that_the_sensor_does_not_have_are_refused() {
        let none = Wanted::default();
        none.validate().unwrap();
        let counts = Some(1);
        for (wanted, fits) in [
            (
                Wanted {
                    accel_range_g: Some(3),
                    ..none
                },
                false,
            ),
            (
                Wanted {
                    low_pass_hz: Some(43),
                    ..none
                },
                false,
            ),
            (
                Wanted {
                    gyro_range_deg_s: Some(0),
                    ..none
                },
                false,
            ),
            (
                Wanted {
                    rate_hz: Some(3),
                    ..none
                },
                false,
            ),
            (
                Wanted {
                    rate_hz: Some(200),
                    ..none
                },
                false,
            ),
            (
                Wanted {
                    rate_hz: Some(200),
                    format: counts,
                    ..none
                },
                true,
            ),
            (
                Wanted {
                    rate_hz: Some(1000),
                    format: counts,
                    ..none
                },
                false,
            ),
        ] {
            assert_eq!(wanted.validate().is_ok(), fits, "{wanted:?}");
        }
        let fast = Wanted {
            rate_hz: Some(200),
            ..none
        };
        let error = fast.validate().unwrap_err();
        assert!(error.hint().unwrap().contains("--format counts"), "{error}");
    }
}
