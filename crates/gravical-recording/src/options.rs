//! What the user specifies about a recording.

use crate::role::Role;
use crate::time_unit::TimeUnit;
use crate::units::{AccelUnit, GyroUnit};

/// What the user specifies about a recording; everything else is told from the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadOptions {
    /// Unit of the accelerometer
    pub accel_unit: Option<AccelUnit>,
    /// Full-scale range of the accelerometer in g, for counts of a 16-bit converter
    pub accel_range_g: Option<f64>,
    /// Unit of the gyroscope
    pub gyro_unit: Option<GyroUnit>,
    /// Full-scale range of the gyroscope in °/s, for counts
    pub gyro_range_deg_s: Option<f64>,
    /// Which column is which
    pub columns: Option<ColumnsSpec>,
    /// Which of several sensors: words of its name, or its number from 1
    pub sensor: Option<String>,
    /// Sampling rate in Hz, used only where there are no time stamps
    pub rate_hz: Option<f64>,
    /// Unit of the time stamps
    pub time_unit: Option<TimeUnit>,
    /// Counts subtracted from every value of the accelerometer
    pub zero_offset: Option<f64>,
    /// The file holds the gyroscope of another one: its axes are read as
    /// [`Recording::accel`](crate::Recording::accel), and are not judged by gravity
    pub is_gyroscope: bool,
}

/// Columns of channels, as the user names them. Columns that are not named are recognised.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ColumnsSpec {
    /// Channel and name of its column; `None` if the channel must not be read
    Named(Vec<(Role, Option<String>)>),
    /// The columns in order
    Ordered(Vec<ColumnChoice>),
}

/// One column of an ordered list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnChoice {
    /// This channel
    Channel(Role),
    /// Recognised
    AsRecognised,
    /// Not read
    Skipped,
}
