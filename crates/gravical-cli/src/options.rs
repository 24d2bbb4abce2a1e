//! Options that several verbs share.

use clap::{Args, ValueEnum};
use gravical::Result;
use gravical::gravity::Gravity;
use gravical::recording::{AccelUnit, ColumnsSpec, GyroUnit, ReadOptions, TimeUnit};
use gravical::segment::face::AxisMap;

use crate::progress;

/// What the user says about a recording.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "About the recording")]
pub struct RecordingArgs {
    /// Unit of the accelerometer [default: from the data]
    #[arg(long, value_enum, value_name = "UNIT")]
    pub accel_unit: Option<AccelUnitArg>,
    /// Full-scale range of the accelerometer in g, for raw counts [default: from the data]
    #[arg(long, value_name = "G")]
    pub accel_range: Option<f64>,
    /// Unit of the gyroscope [default: from turns, else the header]
    #[arg(long, value_enum, value_name = "UNIT")]
    pub gyro_unit: Option<GyroUnitArg>,
    /// Full-scale range of the gyroscope in °/s, for raw counts [default: from turns]
    #[arg(long, value_name = "DEG_S")]
    pub gyro_range: Option<f64>,
    /// Columns that are not recognised: t=Timestamp,ax=… by name (gx=- leaves out), or t,ax,ay,az,_,-
    /// in order (_ as recognised, - skips one)
    #[arg(long, value_name = "COLUMNS", allow_hyphen_values = true)]
    pub columns: Option<ColumnsSpec>,
    /// Which of several sensors in the file: a word of its name, or its number [default: the first]
    #[arg(long, value_name = "NAME|NUMBER")]
    pub sensor: Option<String>,
    /// Sampling rate in Hz, used only where there are no time stamps
    #[arg(long, value_name = "HZ")]
    pub rate: Option<f64>,
    /// Unit of the time stamps [default: from header or steps]
    #[arg(long, value_enum, value_name = "UNIT")]
    pub time_unit: Option<TimeUnitArg>,
    /// Counts subtracted on reading [default: 32768 for unsigned values, else 0]
    #[arg(long, value_name = "COUNTS", allow_negative_numbers = true)]
    pub zero_offset: Option<f64>,
    /// How the board sits in its case: the case's x, y and z in axes of the board
    #[arg(
        long,
        value_name = "X,Y,Z",
        default_value = "x,y,z",
        allow_hyphen_values = true,
        hide_default_value = true
    )]
    pub axes: AxisMapArg,
}

/// What the user says about gravity.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Local gravity")]
pub struct GravityArgs {
    /// Local gravity in m/s² [default: that of the calibration where one is given, else 9.80665]
    #[arg(long, value_name = "MPS2", conflicts_with = "latitude")]
    gravity: Option<f64>,
    /// Latitude in degrees, for local gravity
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
    /// Gravity as the user gives it; none when nothing is said.
    ///
    /// # Errors
    ///
    /// `option-range` for what is nowhere on Earth.
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
    /// As the library wants it.
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

/// The command as it was typed, with the program's plain name.
pub fn command_line() -> String {
    let words = std::env::args_os().skip(1).map(|word| {
        let word = word.to_string_lossy().into_owned();
        let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%^°".contains(c);
        if !word.is_empty() && word.chars().all(plain) {
            word
        } else {
            // As a shell wants it: a quote ends, stands alone, and begins again.
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    });
    std::iter::once("gravical".to_owned())
        .chain(words)
        .collect::<Vec<_>>()
        .join(" ")
}
