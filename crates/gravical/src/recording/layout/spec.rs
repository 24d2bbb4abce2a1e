//! Columns given by the user with `--columns`.

use crate::recording::dialect::Dialect;
use crate::recording::names::Quantity;
use crate::{Error, Result};

/// `--columns`: assigns columns to channels. Overrides the automatic assignment; other columns
/// are assigned automatically.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ColumnsSpec {
    /// `t=Timestamp,ax=…,gx=-`: channel and name of the column; `None` if the channel must not be
    /// read.
    Named(Vec<(Quantity, Option<String>)>),
    /// `ax,ay,az,_,-,gx`: the columns in order; further ones are assigned automatically.
    Ordered(Vec<Column>),
}

/// One column of an ordered list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// This channel.
    Channel(Quantity),
    /// `_`: assigned automatically.
    AsRecognised,
    /// `-`: not read.
    Skipped,
}

impl std::str::FromStr for ColumnsSpec {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let channel = |name: &str| -> Result<Quantity> {
            Ok(match name.trim() {
                "t" | "time" => Quantity::Time,
                "dt" => Quantity::TimeStep,
                "ax" => Quantity::Accel(0),
                "ay" => Quantity::Accel(1),
                "az" => Quantity::Accel(2),
                "gx" => Quantity::Gyro(0),
                "gy" => Quantity::Gyro(1),
                "gz" => Quantity::Gyro(2),
                "temp" | "temperature" => Quantity::Temperature,
                "label" | "part" => Quantity::Label,
                other => {
                    return Err(Error::usage(
                        "columns-syntax",
                        format!("there is no channel \"{other}\""),
                    )
                    .with_hint(
                        "channels are t, dt, ax, ay, az, gx, gy, gz, temp and label; _ leaves a column to recognition, - skips it",
                    ));
                }
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
                    Error::usage("columns-syntax", format!("\"{pair}\" has no ="))
                })?;
                let column = column.trim();
                let column = (!matches!(column, "" | "-" | "_")).then(|| column.to_owned());
                Ok((channel(name)?, column))
            });
            return Ok(ColumnsSpec::Named(pairs.collect::<Result<_>>()?));
        }
        let ordered = text.split(',').map(|name| match name.trim() {
            "_" | "" => Ok(Column::AsRecognised),
            "-" => Ok(Column::Skipped),
            name => channel(name).map(Column::Channel),
        });
        Ok(ColumnsSpec::Ordered(ordered.collect::<Result<_>>()?))
    }
}

impl ColumnsSpec {
    /// The part that does not concern a gyroscope's separate file; `None` without such a part.
    pub(in crate::recording) fn of_accelerometer(&self) -> Option<Self> {
        match self {
            ColumnsSpec::Named(pairs) => {
                let mut pairs = pairs.clone();
                pairs.retain(|(q, name)| !matches!(q, Quantity::Gyro(_)) || name.is_none());
                Some(ColumnsSpec::Named(pairs))
            }
            ColumnsSpec::Ordered(order) => {
                let any = |is: fn(&Quantity) -> bool| {
                    let of = |c: &Column| matches!(c, Column::Channel(q) if is(q));
                    order.iter().any(of)
                };
                let gyro_alone = any(|q| matches!(q, Quantity::Gyro(_)))
                    && !any(|q| matches!(q, Quantity::Accel(_)));
                (!gyro_alone).then(|| self.clone())
            }
        }
    }
}

/// The given channels with their columns, `None` for a channel that must not be read; and the
/// skipped columns.
#[derive(Debug, Default)]
pub(super) struct Given {
    channels: Vec<(Quantity, Option<usize>)>,
    skipped: Vec<usize>,
}

impl Given {
    /// # Errors
    ///
    /// `columns-missing` (usage) for a column that is not in the file.
    pub fn of(dialect: &Dialect, spec: Option<&ColumnsSpec>) -> Result<Self> {
        let names: &[String] = dialect.header.as_ref().map_or(&[], |h| &h.names);
        let mut given = Given::default();
        match spec {
            None => {}
            Some(ColumnsSpec::Ordered(order)) => {
                if order.len() > dialect.fields {
                    return Err(Error::usage(
                        "columns-missing",
                        format!(
                            "{} columns are named, the file has {}",
                            order.len(),
                            dialect.fields
                        ),
                    )
                    .of_option("columns"));
                }
                for (field, column) in order.iter().enumerate() {
                    match column {
                        Column::Channel(quantity) => given.channels.push((*quantity, Some(field))),
                        Column::Skipped => given.skipped.push(field),
                        Column::AsRecognised => {}
                    }
                }
            }
            Some(ColumnsSpec::Named(pairs)) => {
                for (quantity, name) in pairs {
                    let Some(name) = name else {
                        given.channels.push((*quantity, None));
                        continue;
                    };
                    let at = names
                        .iter()
                        .position(|n| n == name)
                        .or_else(|| names.iter().position(|n| n.eq_ignore_ascii_case(name)));
                    match at {
                        Some(at) => given.channels.push((*quantity, Some(at))),
                        None => {
                            return Err(Error::usage(
                                "columns-missing",
                                format!("there is no column \"{name}\""),
                            )
                            .with_hint(list_columns(names)));
                        }
                    }
                }
            }
        }
        Ok(given)
    }

    /// The column is assigned or skipped.
    pub fn uses(&self, field: usize) -> bool {
        self.skipped.contains(&field) || self.channels.iter().any(|(_, f)| *f == Some(field))
    }

    /// The channel is given.
    pub fn includes(&self, quantity: Quantity) -> bool {
        self.channels.iter().any(|(q, _)| *q == quantity)
    }

    /// The given column of a channel.
    pub fn field(&self, quantity: Quantity) -> Option<usize> {
        let of = |(q, f): &(Quantity, Option<usize>)| f.filter(|_| *q == quantity);
        self.channels.iter().find_map(of)
    }

    /// All three axes of a sensor are given.
    pub fn has_all(&self, of: fn(usize) -> Quantity) -> bool {
        (0..3).all(|i| self.field(of(i)).is_some())
    }
}

/// Hint that lists the columns of a file.
pub(super) fn list_columns(names: &[String]) -> String {
    if names.is_empty() {
        return "the file has no header: give the channels in order, as --columns t,ax,ay,az"
            .to_owned();
    }
    let list: Vec<&str> = names
        .iter()
        .map(String::as_str)
        .filter(|n| !n.is_empty())
        .collect();
    let shown: Vec<&str> = list.iter().copied().take(16).collect();
    let more = if list.len() > shown.len() {
        ", …"
    } else {
        ""
    };
    format!(
        "its columns are: {}{more}; assign them with --columns ax=…,ay=…,az=…",
        shown.join(", ")
    )
}
