//! What the user specifies about a recording; everything else is recognised from the file.

use std::str::FromStr;

use serde::Deserialize;

use crate::error::{Error, Result};
use crate::meter::Meter;
use crate::problem::Problem;
use crate::role::Role;
use crate::units::{AccelUnit, GyroUnit, POSSIBLE, TimeUnit};

/// Largest count of a converter of 32 bits.
const MAX_COUNT: f64 = 4.3e9;

/// How a recording is read where it does not say so itself.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "clap", command(next_help_heading = "Reading the recording"))]
pub struct ReadOptions {
    /// m/s^2, g, mg or counts [default: from the data]
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    #[cfg_attr(feature = "clap", arg(hide_possible_values = true))]
    #[cfg_attr(feature = "clap", arg(hide_short_help = true))]
    pub accel_unit: Option<AccelUnit>,
    /// Full scale in g, for counts [default: from the data]
    #[serde(rename = "accel_range")]
    #[cfg_attr(feature = "clap", arg(long = "accel-range", value_name = "G"))]
    #[cfg_attr(feature = "clap", arg(hide_short_help = true))]
    pub accel_range_g: Option<f64>,
    /// rad/s, deg/s or counts [default: from turns, header]
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    #[cfg_attr(feature = "clap", arg(hide_possible_values = true))]
    #[cfg_attr(feature = "clap", arg(hide_short_help = true))]
    pub gyro_unit: Option<GyroUnit>,
    /// Full scale in °/s, for counts [default: from turns]
    #[serde(rename = "gyro_range")]
    #[cfg_attr(feature = "clap", arg(long = "gyro-range", value_name = "DPS"))]
    #[cfg_attr(feature = "clap", arg(hide_short_help = true))]
    pub gyro_range_deg_s: Option<f64>,
    /// t=time,ax=acc_x,gx=- or in order: t,ax,ay,az,_,-
    ///
    /// `-` ignores a column, `_` leaves it to recognition.
    #[serde(deserialize_with = "crate::option_text::optional")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "LIST"))]
    #[cfg_attr(feature = "clap", arg(allow_hyphen_values = true))]
    #[cfg_attr(feature = "clap", arg(hide_short_help = true))]
    pub columns: Option<ColumnsSpec>,
    /// Sensor in the file: part of its name, or its number
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    #[cfg_attr(feature = "clap", arg(hide_short_help = true))]
    pub sensor: Option<String>,
    /// Sampling rate in Hz, where there are no time stamps
    #[serde(rename = "rate")]
    #[cfg_attr(feature = "clap", arg(long = "rate", value_name = "HZ"))]
    #[cfg_attr(feature = "clap", arg(hide_short_help = true))]
    pub rate_hz: Option<f64>,
    /// s, ms, us, ns, min, h or d [default: from the header or steps]
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT"))]
    #[cfg_attr(feature = "clap", arg(hide_possible_values = true))]
    #[cfg_attr(feature = "clap", arg(hide_short_help = true))]
    pub time_unit: Option<TimeUnit>,
    /// Subtracted from counts [default: 32768 if unsigned]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    #[cfg_attr(feature = "clap", arg(allow_negative_numbers = true))]
    #[cfg_attr(feature = "clap", arg(hide_short_help = true))]
    pub zero_offset: Option<f64>,
    /// Compute the SHA-256 of the file.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub hash: bool,
    /// Counts the bytes read, for a progress bar; default: none.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub meter: Option<Meter>,
    /// Memory that the recording may take, bytes; default: half of that of the machine.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    #[doc(hidden)]
    pub max_bytes: Option<u64>,
    /// Unit of the time stamps if neither header, dates nor the rate tell it.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    #[doc(hidden)]
    pub likely_time_unit: Option<TimeUnit>,
    /// The file holds the gyroscope of another one: its axes are read as those of an
    /// accelerometer, and are not judged by gravity.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    #[doc(hidden)]
    pub is_gyroscope: bool,
}

impl ReadOptions {
    /// The same options for a recording whose gyroscope is in a separate file: gyroscope columns named by the user belong to that file.
    pub fn beside_gyroscope_file(&self) -> Self {
        ReadOptions {
            columns: self.columns.as_ref().and_then(of_accelerometer),
            ..self.clone()
        }
    }

    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `option-range` (usage) for a rate or range that is not between 1e-6 and
    /// 1e9, and for an offset beyond 32-bit counts.
    pub fn validate(&self) -> Result<()> {
        for (name, value, possible) in [
            ("rate", self.rate_hz, POSSIBLE),
            ("accel_range", self.accel_range_g, POSSIBLE),
            ("gyro_range", self.gyro_range_deg_s, POSSIBLE),
            ("zero_offset", self.zero_offset, -MAX_COUNT..=MAX_COUNT),
        ] {
            if let Some(v) = value.filter(|v| !possible.contains(v)) {
                let (low, high) = (possible.start(), possible.end());
                let what = format!("{v} is not possible; {low:e} to {high:e} is");
                return Err(Error::range(name, what));
            }
        }
        Ok(())
    }
}

/// Columns of channels, as the user names them. Columns that are not named are recognised.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ColumnsSpec {
    /// Channel and name of its column; `None` if the channel must not be read
    Named(Vec<(Role, Option<String>)>),
    /// The columns in order: channel, [`Role::Other`] for one that is not read, `None` for one that
    /// is recognised
    Ordered(Vec<Option<Role>>),
}

impl FromStr for ColumnsSpec {
    type Err = Error;

    /// Reads `t=Timestamp,ax=…,gx=-` (channel and name of its column; `-`: the channel is not read)
    /// or `ax,ay,az,_,-,gx` (the columns in order; `_` is recognised, `-` not read, as are further
    /// ones).
    ///
    /// # Errors
    ///
    /// `columns-syntax` (usage).
    fn from_str(text: &str) -> Result<Self> {
        let channel = |name: &str| -> Result<Role> {
            let name = name.trim();
            Role::of_name(name).ok_or_else(|| {
                let name = name.to_owned();
                Problem::NoChannel { name }.error()
            })
        };
        if text.contains('=') {
            // A comma within the name of a column is not followed by a channel.
            let mut pairs: Vec<String> = Vec::new();
            for part in text.split(',') {
                match pairs.last_mut() {
                    Some(last) if !part.contains('=') => *last += &format!(",{part}"),
                    _ => pairs.push(part.to_owned()),
                }
            }
            let pairs = pairs.iter().map(|pair| {
                let (name, column) = pair.split_once('=').ok_or_else(|| {
                    let pair = pair.clone();
                    Problem::NoEqualsSign { pair }.error()
                })?;
                let column = column.trim();
                let column = (!matches!(column, "" | "-" | "_")).then(|| column.to_owned());
                Ok((channel(name)?, column))
            });
            let pairs: Vec<(Role, Option<String>)> = pairs.collect::<Result<_>>()?;
            check_once(pairs.iter().map(|(role, _)| *role))?;
            return Ok(ColumnsSpec::Named(pairs));
        }
        let ordered = text.split(',').map(|name| match name.trim() {
            "_" | "" => Ok(None),
            "-" => Ok(Some(Role::Other)),
            name => channel(name).map(Some),
        });
        let ordered: Vec<Option<Role>> = ordered.collect::<Result<_>>()?;
        check_once(ordered.iter().flatten().copied())?;
        Ok(ColumnsSpec::Ordered(ordered))
    }
}

/// Refuses a channel that is named twice.
fn check_once(roles: impl Iterator<Item = Role> + Clone) -> Result<()> {
    let count = |role: &Role| roles.clone().filter(|other| other == role).count();
    let is_twice = |role: &Role| *role != Role::Other && count(role) > 1;
    roles.clone().find(is_twice).map_or(Ok(()), |role| {
        let channel = role.name(0);
        Err(Problem::NamedTwice { channel }.error())
    })
}

/// The part that does not concern a gyroscope's separate file; `None` without such a part.
fn of_accelerometer(spec: &ColumnsSpec) -> Option<ColumnsSpec> {
    match spec {
        ColumnsSpec::Named(pairs) => {
            let mut pairs = pairs.clone();
            pairs.retain(|(role, name)| !matches!(role, Role::Gyro(_)) || name.is_none());
            Some(ColumnsSpec::Named(pairs))
        }
        ColumnsSpec::Ordered(order) => {
            let names = |is: fn(&Role) -> bool| order.iter().flatten().any(is);
            let gyro_alone =
                names(|r| matches!(r, Role::Gyro(_))) && !names(|r| matches!(r, Role::Accel(_)));
            (!gyro_alone).then(|| spec.clone())
        }
    }
}
