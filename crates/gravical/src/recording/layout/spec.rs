//! Columns that the user names with `--columns`.

use super::{Layout, with_claims};
use crate::recording::dialect::Dialect;
use crate::recording::names::{ColumnName, Quantity, understand};
use crate::{Error, Result};

/// `--columns`: which column holds what.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ColumnsSpec {
    /// `t=Timestamp,ax=…`: channel and name of the column.
    Named(Vec<(Quantity, String)>),
    /// `ax,ay,az,_,gx`: channels in the order of the columns; none skips one.
    Ordered(Vec<Option<Quantity>>),
}

impl std::str::FromStr for ColumnsSpec {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let channel = |name: &str| -> Result<Quantity> {
            Ok(match name.trim() {
                "t" | "time" => Quantity::Time,
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
                        format!("--columns: there is no channel \"{other}\""),
                    )
                    .with_hint(
                        "channels are t, ax, ay, az, gx, gy, gz, temp and label; _ skips a column",
                    ));
                }
            })
        };
        if text.contains('=') {
            let pairs = text.split(',').map(|pair| {
                let (name, column) = pair.split_once('=').ok_or_else(|| {
                    Error::usage("columns-syntax", format!("--columns: \"{pair}\" has no ="))
                })?;
                Ok((channel(name)?, column.trim().to_owned()))
            });
            return Ok(ColumnsSpec::Named(pairs.collect::<Result<_>>()?));
        }
        let ordered = text.split(',').map(|name| match name.trim() {
            "_" | "" => Ok(None),
            name => channel(name).map(Some),
        });
        Ok(ColumnsSpec::Ordered(ordered.collect::<Result<_>>()?))
    }
}

/// The layout that `spec` asks for.
pub(super) fn by_spec(dialect: &Dialect, spec: &ColumnsSpec) -> Result<Layout> {
    let names: &[String] = dialect.header.as_ref().map_or(&[], |h| &h.names);
    let mut fields = Vec::new();
    match spec {
        ColumnsSpec::Ordered(order) => {
            if order.len() > dialect.fields {
                return Err(Error::usage(
                    "columns-missing",
                    format!(
                        "--columns names {} columns, the file has {}",
                        order.len(),
                        dialect.fields
                    ),
                ));
            }
            fields.extend(
                order
                    .iter()
                    .enumerate()
                    .filter_map(|(i, q)| Some(((*q)?, i))),
            );
        }
        ColumnsSpec::Named(pairs) => {
            for (quantity, name) in pairs {
                let at = names
                    .iter()
                    .position(|n| n == name)
                    .or_else(|| names.iter().position(|n| n.eq_ignore_ascii_case(name)))
                    .ok_or_else(|| {
                        Error::usage("columns-missing", format!("there is no column \"{name}\""))
                            .with_hint(columns_there(names))
                    })?;
                fields.push((*quantity, at));
            }
        }
    }
    let claims: Vec<(Quantity, ColumnName)> = fields
        .iter()
        .filter_map(|(q, f)| Some((*q, understand(names.get(*f)?)?)))
        .collect();
    let layout = with_claims(fields, &claims);
    if (0..3).any(|i| layout.field(Quantity::Accel(i)).is_none()) {
        return Err(Error::usage(
            "columns-missing",
            "--columns has to name ax, ay and az",
        ));
    }
    Ok(layout)
}

/// Hint that lists the columns of a file.
pub(super) fn columns_there(names: &[String]) -> String {
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
        "its columns are: {}{more}; say which is which with --columns ax=…,ay=…,az=…",
        shown.join(", ")
    )
}
