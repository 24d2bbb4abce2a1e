//! Options that several commands share.

use clap::{Args, ValueEnum};
use gravical::apply::OutputUnit;
use gravical::gravity::Gravity;
use gravical::poses::face::AxisMap;
use gravical::recording::{AccelUnit, ColumnsSpec, GyroUnit, ReadOptions, TimeUnit, parse_columns};
use gravical::{Error, Result};

use crate::progress;

/// How a recording is read where it does not say so itself.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Reading the recording")]
pub struct RecordingArgs {
    /// Unit of the accelerometer [default: from the data]
    #[arg(long, hide_short_help = true, value_enum, value_name = "UNIT")]
    pub accel_unit: Option<AccelUnitArg>,
    /// Full-scale range of the accelerometer in g, for raw counts [default: from the data]
    #[arg(long, hide_short_help = true, value_name = "G")]
    pub accel_range: Option<f64>,
    /// Unit of the gyroscope [default: from rotations, else calibration, header or noise]
    #[arg(long, hide_short_help = true, value_enum, value_name = "UNIT")]
    pub gyro_unit: Option<GyroUnitArg>,
    /// Full-scale range of the gyroscope in °/s, for raw counts [default: from rotations]
    #[arg(long, hide_short_help = true, value_name = "DEG_S")]
    pub gyro_range: Option<f64>,
    /// What each column holds, by name (t=Timestamp,ax=acc_x,gx=-) or in order (t,ax,ay,az,_,-);
    /// - ignores a column, _ leaves it to recognition [default: recognised]
    #[arg(
        long,
        hide_short_help = true,
        value_name = "COLUMNS",
        value_parser = parse_columns,
        allow_hyphen_values = true
    )]
    pub columns: Option<ColumnsSpec>,
    /// Which of several sensors in the file: part of its name, or its number [default: the first]
    #[arg(long, hide_short_help = true, value_name = "NAME|NUMBER")]
    pub sensor: Option<String>,
    /// Sampling rate in Hz, for recordings without time stamps
    #[arg(long, hide_short_help = true, value_name = "HZ")]
    pub rate: Option<f64>,
    /// Unit of the time stamps [default: from the header or the steps]
    #[arg(long, hide_short_help = true, value_enum, value_name = "UNIT")]
    pub time_unit: Option<TimeUnitArg>,
    /// Offset of raw counts, subtracted from each value [default: 32768 for unsigned counts, else 0]
    #[arg(
        long,
        hide_short_help = true,
        value_name = "COUNTS",
        allow_negative_numbers = true
    )]
    pub zero_offset: Option<f64>,
    /// Sensor axes that point along x, y and z of the case, e.g. y,-x,z
    #[arg(
        long,
        hide_short_help = true,
        value_name = "X,Y,Z",
        default_value = "x,y,z",
        allow_hyphen_values = true,
        hide_default_value = true
    )]
    pub axes: AxisMapArg,
}

/// Local gravity.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Local gravity")]
pub struct GravityArgs {
    /// Local gravity in m/s² [default: that of the calibration where one is used, else 9.80665 ± 0.15 %]
    #[arg(long, value_name = "MPS2", conflicts_with = "latitude")]
    gravity: Option<f64>,
    /// Latitude in degrees, to compute local gravity
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    latitude: Option<f64>,
    /// Height above sea level in m, with --latitude
    #[arg(
        long,
        value_name = "M",
        requires = "latitude",
        allow_negative_numbers = true,
        default_value = "0",
        hide_default_value = true
    )]
    altitude: f64,
}

impl GravityArgs {
    /// Gravity as given; none without an option.
    ///
    /// # Errors
    ///
    /// `option-range` for values that do not occur on Earth.
    pub fn given(&self) -> Result<Option<Gravity>> {
        match (self.gravity, self.latitude) {
            (Some(g), _) => Gravity::given(g).map(Some),
            (None, Some(latitude)) => Gravity::at(latitude, self.altitude).map(Some),
            (None, None) => Ok(None),
        }
    }
}

/// [`AxisMap`] with a default for clap.
#[derive(Debug, Clone, Copy, Default)]
pub struct AxisMapArg(pub AxisMap);

impl std::str::FromStr for AxisMapArg {
    type Err = gravical::Error;

    fn from_str(text: &str) -> Result<Self> {
        Ok(AxisMapArg(text.parse()?))
    }
}

/// Units of the accelerometer, as options.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum AccelUnitArg {
    /// metres per second squared
    #[value(name = "m/s^2", alias = "m/s2", alias = "mps2")]
    Mps2,
    /// standard gravity
    G,
    /// thousandths of it
    Mg,
    /// raw counts
    Counts,
}

/// Units of the gyroscope, as options.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum GyroUnitArg {
    /// radians per second
    #[value(name = "rad/s")]
    RadS,
    /// degrees per second
    #[value(name = "deg/s", alias = "dps")]
    DegS,
    /// raw counts
    Counts,
}

/// Units of time, as options.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum TimeUnitArg {
    /// seconds
    S,
    /// milliseconds
    Ms,
    /// microseconds
    Us,
    /// nanoseconds
    Ns,
}

impl RecordingArgs {
    /// Refuses --axes for a command that does not rotate; `what` it does.
    ///
    /// # Errors
    ///
    /// `axes-unused` (usage).
    pub fn refuse_axes(&self, what: &str) -> Result<()> {
        if self.axes.0 == AxisMap::default() {
            return Ok(());
        }
        Err(Error::usage("axes-unused", what)
            .with_hint("remove --axes; `gravical apply --axes` writes the axes of the case"))
    }

    /// The same for the library.
    pub fn read_options(&self, hash: bool) -> ReadOptions {
        ReadOptions {
            accel_unit: self.accel_unit.map(|u| match u {
                AccelUnitArg::Mps2 => AccelUnit::MetrePerSecondSquared,
                AccelUnitArg::G => AccelUnit::StandardGravity,
                AccelUnitArg::Mg => AccelUnit::MilliGravity,
                AccelUnitArg::Counts => AccelUnit::Counts,
            }),
            accel_range_g: self.accel_range,
            gyro_unit: self.gyro_unit.map(|u| match u {
                GyroUnitArg::RadS => GyroUnit::RadianPerSecond,
                GyroUnitArg::DegS => GyroUnit::DegreePerSecond,
                GyroUnitArg::Counts => GyroUnit::Counts,
            }),
            gyro_range_deg_s: self.gyro_range,
            columns: self.columns.clone(),
            sensor: self.sensor.clone(),
            rate_hz: self.rate,
            time_unit: self.time_unit.map(|u| match u {
                TimeUnitArg::S => TimeUnit::Second,
                TimeUnitArg::Ms => TimeUnit::Millisecond,
                TimeUnitArg::Us => TimeUnit::Microsecond,
                TimeUnitArg::Ns => TimeUnit::Nanosecond,
            }),
            zero_offset: self.zero_offset,
            hash,
            meter: Some(progress::meter()),
        }
    }
}

/// Units of acceleration in a table, as options.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum OutputUnitArg {
    /// metres per second squared
    #[value(name = "m/s^2", alias = "m/s2", alias = "mps2")]
    Mps2,
    /// standard gravity, 9.80665 m/s²
    G,
}

impl From<OutputUnitArg> for OutputUnit {
    fn from(unit: OutputUnitArg) -> Self {
        match unit {
            OutputUnitArg::Mps2 => OutputUnit::MetrePerSecondSquared,
            OutputUnitArg::G => OutputUnit::StandardGravity,
        }
    }
}

/// For commands whose first argument is the calibration.
pub const SWAPPED: &str = "the arguments are swapped: the calibration comes first";

/// The command line as typed, with the plain name of the program.
pub fn command_line() -> String {
    let words = std::env::args_os().skip(1).map(|word| {
        let word = word.to_string_lossy().into_owned();
        let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%^°".contains(c);
        if !word.is_empty() && word.chars().all(plain) {
            word
        } else {
            // Quoted for a shell.
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    });
    std::iter::once("gravical".to_owned())
        .chain(words)
        .collect::<Vec<_>>()
        .join(" ")
}
