//! Columns given by the user with `--columns`.

use gravical_recording::{ColumnChoice, ColumnsSpec, Role};

use crate::{Error, Result};

/// Reads `t=Timestamp,ax=…,gx=-` (channel and name of its column; `-`: the channel is not read) or
/// `ax,ay,az,_,-,gx` (the columns in order; `_` is recognised, `-` not read, as are further ones).
///
/// # Errors
///
/// `columns-syntax` (usage).
pub fn parse_columns(text: &str) -> Result<ColumnsSpec> {
    let channel = |name: &str| -> Result<Role> {
        Ok(match name.trim() {
            "t" | "time" => Role::Time,
            "dt" => Role::Step,
            "ax" => Role::Accel(0),
            "ay" => Role::Accel(1),
            "az" => Role::Accel(2),
            "gx" => Role::Gyro(0),
            "gy" => Role::Gyro(1),
            "gz" => Role::Gyro(2),
            "temp" | "temperature" => Role::Temperature,
            "label" | "part" => Role::Label,
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
            let (name, column) = pair
                .split_once('=')
                .ok_or_else(|| Error::usage("columns-syntax", format!("\"{pair}\" has no =")))?;
            let column = column.trim();
            let column = (!matches!(column, "" | "-" | "_")).then(|| column.to_owned());
            Ok((channel(name)?, column))
        });
        return Ok(ColumnsSpec::Named(pairs.collect::<Result<_>>()?));
    }
    let ordered = text.split(',').map(|name| match name.trim() {
        "_" | "" => Ok(ColumnChoice::AsRecognised),
        "-" => Ok(ColumnChoice::Skipped),
        name => channel(name).map(ColumnChoice::Channel),
    });
    Ok(ColumnsSpec::Ordered(ordered.collect::<Result<_>>()?))
}

/// The same for serde.
pub(super) fn optional<'de, D: serde::Deserializer<'de>>(
    from: D,
) -> Result<Option<ColumnsSpec>, D::Error> {
    let text: Option<String> = serde::Deserialize::deserialize(from)?;
    text.map(|text| crate::option_text::parse(&text, parse_columns))
        .transpose()
}

/// The part that does not concern a gyroscope's separate file; `None` without such a part.
pub(super) fn of_accelerometer(spec: &ColumnsSpec) -> Option<ColumnsSpec> {
    match spec {
        ColumnsSpec::Named(pairs) => {
            let mut pairs = pairs.clone();
            pairs.retain(|(role, name)| !matches!(role, Role::Gyro(_)) || name.is_none());
            Some(ColumnsSpec::Named(pairs))
        }
        ColumnsSpec::Ordered(order) => {
            let any = |is: fn(&Role) -> bool| {
                let of = |c: &ColumnChoice| matches!(c, ColumnChoice::Channel(role) if is(role));
                order.iter().any(of)
            };
            let gyro_alone =
                any(|r| matches!(r, Role::Gyro(_))) && !any(|r| matches!(r, Role::Accel(_)));
            (!gyro_alone).then(|| spec.clone())
        }
    }
}
