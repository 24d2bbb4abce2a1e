//! Why a recording cannot be read.

use std::fmt;
use std::io;

/// Names of columns that a hint lists.
const LISTED: usize = 16;

/// Why a recording cannot be read.
#[derive(Debug)]
pub struct Error(Kind);

#[derive(Debug)]
pub(crate) enum Kind {
    Io(io::Error),
    Empty,
    NoTable(&'static str),
    /// Number of columns, line and number of names that do not fit.
    ColumnsUnknown(usize, Option<(usize, usize)>),
    /// A column that the user names, and those of the file.
    ColumnMissing(String, Vec<String>),
    /// Columns that the user names, columns of the file.
    TooManyColumns(usize, usize),
    NoAccelerometer {
        has_gyroscope: bool,
        header_line: usize,
        names: Vec<String>,
    },
    NoGyroscope {
        has_accelerometer: bool,
        names: Vec<String>,
    },
    /// The sensor that the user names, and those of the file.
    SensorUnknown(String, Vec<String>),
    /// A header with other columns, its line and what is wrong.
    HeaderDiffers(usize, &'static str),
    EpochsOfCounts,
    /// Why files of one axis each do not belong together.
    AxesDiffer(String),
    TooManyLabels,
    /// A channel of a table in memory is a column of texts, from 1.
    TextColumn(usize),
    TooLarge(usize),
    NoRows(String),
    /// Channel and rows.
    NoValues(&'static str, usize),
    /// Sensor and rows.
    AllZero(&'static str, usize),
}

impl Error {
    /// The case, for scripts: `columns-unknown`, `no-rows`, …
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self.0 {
            Kind::Io(_) => "io",
            Kind::Empty => "empty-file",
            Kind::NoTable(_) | Kind::NoRows(_) => "no-rows",
            Kind::ColumnsUnknown(..) => "columns-unknown",
            Kind::ColumnMissing(..) | Kind::TooManyColumns(..) => "columns-missing",
            Kind::NoAccelerometer { .. } => "no-accelerometer",
            Kind::NoGyroscope { .. } => "no-gyroscope",
            Kind::SensorUnknown(..) => "sensor-unknown",
            Kind::HeaderDiffers(..) => "header-differs",
            Kind::EpochsOfCounts => "epochs-of-counts",
            Kind::AxesDiffer(_) => "axes-differ",
            Kind::TooManyLabels => "too-many-labels",
            Kind::TooLarge(_) => "too-large",
            Kind::NoValues(..) | Kind::TextColumn(_) => "no-values",
            Kind::AllZero(..) => "all-zero",
        }
    }

    /// The error of the system, if reading failed.
    #[must_use]
    pub fn into_io(self) -> Option<io::Error> {
        match self.0 {
            Kind::Io(e) => Some(e),
            _ => None,
        }
    }

    /// An option does not fit the file: `columns` or `sensor`.
    #[must_use]
    pub fn option(&self) -> Option<&'static str> {
        match self.0 {
            Kind::ColumnMissing(..) | Kind::TooManyColumns(..) => Some("columns"),
            Kind::SensorUnknown(..) => Some("sensor"),
            _ => None,
        }
    }

    /// The line of the file, from 1.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        match self.0 {
            Kind::HeaderDiffers(line, _) => Some(line),
            Kind::NoAccelerometer { header_line, .. } => Some(header_line).filter(|l| *l > 0),
            _ => None,
        }
    }

    /// What to do.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        const ROWS: &str = "a recording is a table of text: one sample a line, its values separated by comma, semicolon, tab or spaces";
        Some(match &self.0 {
            Kind::Io(_) => return None,
            Kind::Empty => "record again: nothing was written to this file".to_owned(),
            Kind::NoTable(_) | Kind::NoRows(_) => ROWS.to_owned(),
            Kind::ColumnsUnknown(..) => {
                "name them in order, as --columns t,ax,ay,az,gx,gy,gz (- skips one)".to_owned()
            }
            Kind::ColumnMissing(_, names) => list_columns(names),
            Kind::TooManyColumns(..) => "leave the last ones out".to_owned(),
            Kind::NoAccelerometer {
                has_gyroscope: true,
                ..
            } => "give the accelerometer's recording as the input, and this file with --gyro"
                .to_owned(),
            Kind::NoAccelerometer { names, .. } => list_columns(names),
            Kind::NoGyroscope { names, .. } if names.is_empty() => {
                "a file for --gyro holds t,gx,gy,gz or gx,gy,gz, or has a header that names them"
                    .to_owned()
            }
            Kind::NoGyroscope { names, .. } => {
                let list = list_columns(names);
                let list = list.split(';').next().unwrap_or_default();
                format!(
                    "{list}; --gyro needs the file with the gyroscope; --columns gx=…,gy=…,gz=… names its columns"
                )
            }
            Kind::SensorUnknown(_, sensors) if sensors.len() < 2 => {
                "this file has one sensor: leave the option out".to_owned()
            }
            Kind::SensorUnknown(_, sensors) => format!("give one of: {}", sensors.join(", ")),
            Kind::HeaderDiffers(line, _) => {
                format!("cut the file before line {line} and read the parts separately")
            }
            Kind::EpochsOfCounts => {
                "export the raw acceleration (in ActiLife: a RAW CSV file)".to_owned()
            }
            Kind::AxesDiffer(_) => {
                "cut the files to the same samples, or record all axes in one file: t,ax,ay,az"
                    .to_owned()
            }
            Kind::TooManyLabels => {
                "leave the column out with --columns label=-, or cut the file".to_owned()
            }
            Kind::TextColumn(_) => {
                "convert it to numbers, or name other columns: --columns t=…,ax=…".to_owned()
            }
            Kind::TooLarge(_) => "cut the file, and read the parts separately".to_owned(),
            Kind::NoValues(..) => "choose other columns: --columns ax=…,ay=…,az=…".to_owned(),
            Kind::AllZero("gyroscope", _) => {
                "check that the sketch wakes the gyroscope, or leave --gyro out".to_owned()
            }
            Kind::AllZero(..) => {
                "check the wiring (SDA, SCL, power) and that the sketch wakes the sensor".to_owned()
            }
        })
    }

    /// Whether names were found, and none of a sensor.
    pub(crate) fn names_no_sensor(&self) -> bool {
        matches!(
            self.0,
            Kind::NoAccelerometer {
                has_gyroscope: false,
                ..
            }
        )
    }

    /// Whether the numbers may be wrapped in words.
    pub(crate) fn may_be_words(&self) -> bool {
        matches!(
            self.0,
            Kind::NoTable(_)
                | Kind::ColumnsUnknown(..)
                | Kind::ColumnMissing(..)
                | Kind::TooManyColumns(..)
                | Kind::NoAccelerometer { .. }
        )
    }
}

/// Hint that lists the columns of a file.
fn list_columns(names: &[String]) -> String {
    if names.is_empty() {
        return "the file has no header: give the channels in order, as --columns t,ax,ay,az"
            .to_owned();
    }
    let list: Vec<&str> = names
        .iter()
        .map(String::as_str)
        .filter(|n| !n.is_empty())
        .collect();
    let more = if list.len() > LISTED { ", …" } else { "" };
    let shown = &list[..list.len().min(LISTED)];
    format!(
        "its columns are: {}{more}; assign them with --columns ax=…,ay=…,az=…",
        shown.join(", ")
    )
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Kind::Io(e) => e.fmt(f),
            Kind::Empty => write!(f, "the file is empty"),
            Kind::NoTable(what) => write!(f, "no table of samples was found: {what}"),
            Kind::ColumnsUnknown(columns, Some((line, names))) => write!(
                f,
                "line {line} has {names} names for {columns} columns, so it cannot be their header, and the numbers do not show their meaning"
            ),
            Kind::ColumnsUnknown(columns, None) => write!(
                f,
                "the file has no header and {columns} columns whose meaning the numbers do not show"
            ),
            Kind::ColumnMissing(name, _) => write!(f, "there is no column \"{name}\""),
            Kind::TooManyColumns(named, columns) => {
                write!(f, "{named} columns are named, the file has {columns}")
            }
            Kind::NoAccelerometer {
                has_gyroscope: true,
                ..
            } => {
                write!(f, "this file holds a gyroscope and no accelerometer")
            }
            Kind::NoAccelerometer { header_line, .. } => write!(
                f,
                "no three columns of the header in line {header_line} are named as an accelerometer's x, y and z"
            ),
            Kind::NoGyroscope {
                has_accelerometer: true,
                ..
            } => {
                write!(f, "this file has an accelerometer, but no gyroscope")
            }
            Kind::NoGyroscope { .. } => {
                write!(
                    f,
                    "no three columns of this file are a gyroscope's x, y and z"
                )
            }
            Kind::SensorUnknown(wanted, _) => write!(f, "there is no sensor {wanted}"),
            Kind::HeaderDiffers(line, why) => write!(f, "the header in line {line} {why}"),
            Kind::EpochsOfCounts => {
                write!(
                    f,
                    "the file holds activity counts per epoch, not acceleration"
                )
            }
            Kind::AxesDiffer(why) => {
                write!(f, "the files of the axes do not belong together: {why}")
            }
            Kind::TooManyLabels => write!(f, "the label column holds more than 254 words"),
            Kind::TextColumn(column) => write!(f, "column {column} holds texts, not numbers"),
            Kind::TooLarge(bytes) => {
                write!(
                    f,
                    "the columns take more than {} MiB of memory",
                    bytes >> 20
                )
            }
            Kind::NoRows(lines) => write!(f, "no row could be read: {lines}"),
            Kind::NoValues(channel, rows) => write!(
                f,
                "{channel} has no value in any of the {rows} rows (empty or NaN)"
            ),
            Kind::AllZero(sensor, rows) => write!(
                f,
                "the {sensor} reads zero or nothing in all {rows} rows: it did not answer"
            ),
        }
    }
}

impl std::error::Error for Error {}

impl From<Kind> for Error {
    fn from(kind: Kind) -> Self {
        Error(kind)
    }
}

impl From<io::Error> for Error {
    fn from(e: io::Error) -> Self {
        Error(Kind::Io(e))
    }
}
