//! Units of the channels and of time.

use std::fmt;

use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use serde::{Deserialize, Serialize};

/// Sampling rates (Hz) and full-scale ranges (g, °/s) that are accepted: much wider than any real
/// sensor, so that windows, scales and durations computed from them are finite.
pub const POSSIBLE: std::ops::RangeInclusive<f64> = 1e-6..=1e9;
/// Temperatures that a sensor can have, °C.
pub const POSSIBLE_C: std::ops::RangeInclusive<f64> = -60.0..=150.0;

/// An enum whose values have one name in files and options.
macro_rules! units {
    ($(#[$meta:meta])* $unit:ident { $($(#[$value_meta:meta])* $value:ident $name:literal;)* }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
        pub enum $unit {
            $(
                $(#[$value_meta])*
                #[serde(rename = $name)]
                #[cfg_attr(feature = "clap", value(name = $name))]
                $value,
            )*
        }

        impl $unit {
            /// Name in files and options; in text it is displayed with its symbol.
            pub fn name(self) -> &'static str {
                match self {
                    $($unit::$value => $name,)*
                }
            }
        }

        impl fmt::Display for $unit {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(match self.name() {
                    "m/s^2" => "m/s²",
                    "deg/s" => "°/s",
                    name => name,
                })
            }
        }
    };
}

units! {
    /// Unit of an accelerometer channel.
    #[derive(Default)]
    AccelUnit {
        /// m/s².
        #[serde(alias = "m/s2", alias = "mps2")]
        #[cfg_attr(feature = "clap", value(aliases = ["m/s2", "mps2"]))]
        MetrePerSecondSquared "m/s^2";
        /// Standard gravity, 9.80665 m/s².
        StandardGravity "g";
        /// A thousandth of standard gravity.
        MilliGravity "mg";
        /// Raw counts of the converter.
        Counts "counts";
        /// Given neither by the header nor by the data.
        #[cfg_attr(feature = "clap", value(skip))]
        #[default]
        Unknown "unknown";
    }
}

units! {
    /// Unit of a gyroscope channel.
    #[derive(Default)]
    GyroUnit {
        /// rad/s.
        RadianPerSecond "rad/s";
        /// °/s.
        #[serde(alias = "dps")]
        #[cfg_attr(feature = "clap", value(alias = "dps"))]
        DegreePerSecond "deg/s";
        /// Raw counts of the converter.
        Counts "counts";
        /// Given neither by the header nor by the data.
        #[cfg_attr(feature = "clap", value(skip))]
        #[default]
        Unknown "unknown";
    }
}

units! {
    /// Unit of the time stamps.
    TimeUnit {
        /// Seconds.
        Second "s";
        /// Milliseconds.
        Millisecond "ms";
        /// Microseconds.
        Microsecond "us";
        /// Nanoseconds.
        Nanosecond "ns";
        /// Minutes.
        Minute "min";
        /// Hours.
        Hour "h";
        /// Days.
        Day "d";
    }
}

/// Spellings of a unit, and for one that is read as counts of known sensitivity its counts per g or
/// per °/s.
type Spellings<U> = (&'static str, U, Option<f64>);

const MPS2: &str = "m/s2 mps2 ms-2 ms2 m/s/s m/sec2 m/s2r m.s-2 ms2r metre/s2 meter/s2 \
    meterspersecondsquared";
const COUNTS: &str = "counts count lsb raw adc a.u. int16";
const DEG_S: &str = "deg/s dps degs deg degs-1 deg/sec degree/s degrees/s deg.s-1 °s-1";
const RAD_S: &str = "rad/s rads rad rps rad/sec rads-1 rad.s-1 radians/s";
const MDPS: &str = "mdps mdeg/s millideg/s m°/s mdegs-1";
const MRAD_PER_DEG: f64 = 1000.0 * std::f64::consts::PI / 180.0;

const ACCEL_UNITS: [Spellings<AccelUnit>; 7] = [
    (MPS2, AccelUnit::MetrePerSecondSquared, None),
    ("g gs gn g0", AccelUnit::StandardGravity, None),
    ("mg millig", AccelUnit::MilliGravity, None),
    (COUNTS, AccelUnit::Counts, None),
    ("cm/s2 cms-2 gal", AccelUnit::Counts, Some(980.665)),
    ("mm/s2 mms-2", AccelUnit::Counts, Some(9806.65)),
    ("ug µg μg", AccelUnit::Counts, Some(1e6)),
];

const GYRO_UNITS: [Spellings<GyroUnit>; 7] = [
    (DEG_S, GyroUnit::DegreePerSecond, None),
    (RAD_S, GyroUnit::RadianPerSecond, None),
    (COUNTS, GyroUnit::Counts, None),
    (MDPS, GyroUnit::Counts, Some(MDPS_PER_DEG_S)),
    ("mrad/s mrads-1", GyroUnit::Counts, Some(MRAD_PER_DEG)),
    ("deg/h deg/hr °/h °/hr dph", GyroUnit::Counts, Some(3600.0)),
    ("rpm", GyroUnit::Counts, Some(1.0 / 6.0)),
];

/// m°/s in one °/s.
pub const MDPS_PER_DEG_S: f64 = 1000.0;

fn find<U: Copy>(units: &[Spellings<U>], word: &str) -> Option<Spellings<U>> {
    units.iter().find(|u| is_listed(u.0, word)).copied()
}

/// Whether a word is one of a list, in which blanks separate the words.
pub fn is_listed(list: &str, word: &str) -> bool {
    !word.is_empty() && list.split(' ').any(|w| w == word)
}

impl AccelUnit {
    /// Parses a unit; `None` if it is not a unit of acceleration.
    pub fn parse(text: &str) -> Option<Self> {
        find(&ACCEL_UNITS, &squeeze(text)).map(|u| u.1)
    }

    /// Counts per g of a unit that is read as counts.
    pub fn per_g(text: &str) -> Option<f64> {
        find(&ACCEL_UNITS, &squeeze(text))?.2
    }
}

impl GyroUnit {
    /// Parses a unit; `None` if it is not a unit of angular rate.
    pub fn parse(text: &str) -> Option<Self> {
        let unit = squeeze(text);
        // A degree sign lost in a conversion can be any character.
        let is_degree = unit.strip_suffix("/s").is_some_and(|sign| {
            sign.chars().count() == 1 && !sign.starts_with(|c: char| c.is_ascii_alphanumeric())
        });
        let named = find(&GYRO_UNITS, &unit).map(|u| u.1);
        named.or(is_degree.then_some(GyroUnit::DegreePerSecond))
    }

    /// Counts per °/s of a unit that is read as counts.
    pub fn per_deg_s(text: &str) -> Option<f64> {
        find(&GYRO_UNITS, &squeeze(text))?.2
    }
}

/// Lower case, without spaces, carets and underscores; `²` is `2`.
fn squeeze(text: &str) -> String {
    text.to_lowercase()
        .chars()
        .filter(|c| !c.is_whitespace() && !matches!(c, '^' | '*' | '_' | '[' | ']' | '(' | ')'))
        .map(|c| match c {
            '²' => '2',
            '⁻' | '−' => '-',
            '¹' => '1',
            '·' => '.',
            other => other,
        })
        .collect()
}

/// Whether a text is a unit of temperature.
pub fn is_celsius(text: &str) -> bool {
    is_listed("c °c ℃ degc 'c degreescelsius celsius", &squeeze(text))
}

/// True for the unit of any quantity that recorders measure, as in a row of units.
pub fn is_unit(text: &str) -> bool {
    const OTHERS: &str = "ut µt μt mt nt gauss mgauss hpa pa kpa mbar v mv % ° m mm m/s hz nounits \
        unitless n/a - localflux localfluxunits kohms cal yyyy/mm/ddhh:mm:ss.sss";
    AccelUnit::parse(text).is_some()
        || GyroUnit::parse(text).is_some()
        || time_scale_s(text).is_some()
        || is_celsius(text)
        || is_listed(OTHERS, &squeeze(text))
}

/// The units of time, in the order of the enum: seconds of one, and its spellings.
pub const TIME_UNITS: [(TimeUnit, f64, &str); 7] = [
    (TimeUnit::Second, 1.0, "s sec secs second seconds"),
    (TimeUnit::Millisecond, 1e-3, MILLISECONDS),
    (TimeUnit::Microsecond, 1e-6, MICROSECONDS),
    (TimeUnit::Nanosecond, 1e-9, NANOSECONDS),
    (TimeUnit::Minute, 60.0, "min mins minute minutes"),
    (TimeUnit::Hour, 3600.0, "h hr hrs hour hours"),
    (TimeUnit::Day, 86_400.0, "d day days"),
];
const MILLISECONDS: &str = "ms msec msecs millisec millisecs millis millisecond milliseconds";
const MICROSECONDS: &str = "us µs μs usec usecs microsec microsecs micros microsecond microseconds";
const NANOSECONDS: &str = "ns nsec nsecs nanosec nanosecs nanos nanosecond nanoseconds";

impl TimeUnit {
    /// Seconds per unit.
    pub fn seconds(self) -> f64 {
        TIME_UNITS[self as usize].1
    }

    /// The unit of so many seconds.
    pub fn of_seconds(seconds: f64) -> Option<Self> {
        let is_it = |u: &&(Self, f64, &str)| (u.1 / seconds - 1.0).abs() < 1e-9;
        TIME_UNITS.iter().find(is_it).map(|u| u.0)
    }

    /// Parses a unit.
    pub fn parse(text: &str) -> Option<Self> {
        let word = text.trim().to_lowercase();
        let is_it = |u: &&(Self, f64, &str)| is_listed(u.2, &word);
        TIME_UNITS.iter().find(is_it).map(|u| u.0)
    }
}

/// Seconds of one unit of time, which may have a number: `ms`, `[10ms]`.
pub fn time_scale_s(text: &str) -> Option<f64> {
    let text: String = text.chars().filter(|c| !"[]() ".contains(*c)).collect();
    let word = text.trim_start_matches(|c: char| c.is_ascii_digit());
    let many: f64 = text[..text.len() - word.len()].parse().unwrap_or(1.0);
    (many > 0.0).then_some(many * TimeUnit::parse(word)?.seconds())
}

/// Source of a unit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// Given by the user.
    Given,
    /// Determined from gravity, or from turns.
    Data,
    /// Given by the header, without verification.
    Header,
    /// Assumed.
    #[default]
    Assumed,
}

/// Unit and sensitivity of the accelerometer; by default neither header nor data tell the unit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct AccelScale {
    /// The unit.
    pub unit: AccelUnit,
    /// Counts per g from the data sheet, for counts with a known range.
    pub lsb_per_g: Option<f64>,
    /// Source of the unit.
    pub origin: Origin,
}

impl AccelScale {
    pub(crate) fn new(unit: AccelUnit, lsb_per_g: Option<f64>, origin: Origin) -> Self {
        AccelScale {
            unit,
            lsb_per_g,
            origin,
        }
    }

    /// Input units per m/s² by definition or data sheet; `None` for counts of unknown range.
    pub fn nominal(&self) -> Option<f64> {
        match self.unit {
            AccelUnit::MetrePerSecondSquared => Some(1.0),
            AccelUnit::StandardGravity => Some(1.0 / STANDARD_GRAVITY_MPS2),
            AccelUnit::MilliGravity => Some(1000.0 / STANDARD_GRAVITY_MPS2),
            AccelUnit::Counts => self.lsb_per_g.map(|lsb| lsb / STANDARD_GRAVITY_MPS2),
            AccelUnit::Unknown => None,
        }
    }
}

/// Unit and sensitivity of the gyroscope.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GyroScale {
    /// The unit.
    pub unit: GyroUnit,
    /// Counts per °/s from the data sheet, for counts with a known range.
    pub lsb_per_deg_s: Option<f64>,
    /// Source of the unit.
    pub origin: Origin,
}

impl GyroScale {
    /// Input units per rad/s by definition or data sheet; `None` if unknown.
    pub fn nominal(&self) -> Option<f64> {
        let degrees_per_radian = 180.0 / std::f64::consts::PI;
        match self.unit {
            GyroUnit::RadianPerSecond => Some(1.0),
            GyroUnit::DegreePerSecond => Some(degrees_per_radian),
            GyroUnit::Counts => self.lsb_per_deg_s.map(|lsb| lsb * degrees_per_radian),
            GyroUnit::Unknown => None,
        }
    }
}

/// Units of a recording, as judged by what the user says, by gravity, and by the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Units {
    /// Unit of the accelerometer
    pub accel: AccelScale,
    /// Unit of the gyroscope; `None` without one
    pub gyro: Option<GyroScale>,
    /// Value subtracted from the accelerometer's counts
    pub zero_offset: f64,
    /// Resolution of the axes of accelerometer and gyroscope, each in its own unit; 0 where it is
    /// unknown
    pub resolution: [[f64; 3]; 2],
    /// The header claims another unit of the accelerometer than the magnitude at rest or the user
    pub contradicts_header: bool,
    /// The magnitude at rest contradicts the unit that the user gives
    pub contradicts_given: bool,
    /// The device has subtracted gravity
    pub is_without_gravity: bool,
    /// There are temperatures, but not in °C, and they are not read
    pub has_unknown_temperature: bool,
}

/// Counts per °/s of gyroscopes in use: InvenSense and Bosch at ±250, 500, 1000 and
/// 2000 °/s (MPU-6050 Product Specification 3.4, section 6.1), then ST at 8.75, 17.5,
/// 35 and 70 m°/s a count (LSM6DS3 data sheet, table 3).
pub const LSB_PER_DEG_S: [f64; 8] = [
    131.0,
    65.5,
    32.8,
    16.4,
    1000.0 / 8.75,
    1000.0 / 17.5,
    1000.0 / 35.0,
    1000.0 / 70.0,
];
