//! Columns of a file that is read for its gyroscope alone (`--gyro`).

use super::content::by_content;
use super::header::{sensors, understand_all};
use super::spec::columns_there;
use super::{Layout, with_claims};
use crate::recording::dialect::Dialect;
use crate::recording::finding::Finding;
use crate::recording::names::{ColumnName, Quantity};
use crate::{Error, Result};

/// Finds time and gyroscope. A header names them, `x`, `y`, `z` alone will do;
/// without one four columns are t, gx, gy, gz, three are gx, gy, gz, and in
/// more the numbers decide as for any recording.
///
/// # Errors
///
/// `no-gyroscope` or `columns-unknown` (input), with what is there.
pub(crate) fn find_gyroscope(dialect: &Dialect, findings: &mut Vec<Finding>) -> Result<Layout> {
    match &dialect.header {
        Some(header) => by_header(&header.names),
        None => by_numbers(dialect, findings),
    }
}

fn no_gyroscope(what: &str) -> Error {
    Error::input("no-gyroscope", what.to_owned())
}

fn by_header(names: &[String]) -> Result<Layout> {
    let understood = understand_all(names);
    let named = sensors(&understood, Quantity::Gyro);
    let bare = || -> Option<[usize; 3]> {
        let at = |axis: &str| {
            names
                .iter()
                .position(|n| n.trim().trim_matches('"').eq_ignore_ascii_case(axis))
        };
        Some([at("x")?, at("y")?, at("z")?])
    };
    let Some(gyro) = named.first().copied().or_else(bare) else {
        let what = if sensors(&understood, Quantity::Accel).is_empty() {
            "no three columns of this file are named as a gyroscope's x, y and z"
        } else {
            "this file has an accelerometer, but no gyroscope"
        };
        let list = columns_there(names);
        let list = list.split(';').next().unwrap_or_default();
        return Err(no_gyroscope(what).with_hint(format!(
            "{list}; --gyro wants the file with the gyroscope, its columns named gx, gy, gz"
        )));
    };
    let mut fields: Vec<(Quantity, usize)> = (0..3).map(|i| (Quantity::Gyro(i), gyro[i])).collect();
    if let Some((field, _)) = understood
        .iter()
        .find(|(_, c)| c.quantity == Quantity::Time)
    {
        fields.push((Quantity::Time, *field));
    }
    let claims: Vec<(Quantity, ColumnName)> = fields
        .iter()
        .filter_map(|(q, f)| {
            let (_, name) = understood.iter().find(|(at, _)| at == f)?;
            Some((*q, name.clone()))
        })
        .collect();
    Ok(with_claims(fields, &claims))
}

fn by_numbers(dialect: &Dialect, findings: &mut Vec<Finding>) -> Result<Layout> {
    let first: Vec<f64> = dialect
        .sample
        .iter()
        .filter_map(|r| r.first().copied())
        .collect();
    let steps = || first.windows(2).map(|w| w[1] - w[0]);
    // Every second step of an angular rate goes down; of a clock only a reset
    // or a late row does.
    let down = steps().filter(|d| *d < 0.0).count();
    let rises = first.len() > 3 && down * 10 < first.len() && steps().any(|d| d > 0.0);
    let counts = rises && steps().all(|d| d == 1.0);
    let layout = match dialect.fields {
        3 => triple(0, false),
        4 if rises => triple(1, !counts),
        4 => {
            return Err(Error::input(
                "columns-unknown",
                "the file has no header and four columns, of which the first is no rising time",
            )
            .with_hint(
                "a file for --gyro holds t,gx,gy,gz or gx,gy,gz, or has a header that names them",
            ));
        }
        _ => {
            let mut layout = by_content(dialect, findings)?;
            layout
                .fields
                .retain(|(q, _)| matches!(q, Quantity::Time | Quantity::Gyro(_)));
            layout
        }
    };
    if !layout.has_gyro() {
        return Err(
            no_gyroscope("the numbers of this file show no gyroscope").with_hint(
                "a file for --gyro holds t,gx,gy,gz or gx,gy,gz, or has a header that names them",
            ),
        );
    }
    Ok(layout)
}

fn triple(from: usize, timed: bool) -> Layout {
    let mut fields: Vec<(Quantity, usize)> =
        (0..3).map(|i| (Quantity::Gyro(i), from + i)).collect();
    if timed {
        fields.push((Quantity::Time, 0));
    }
    with_claims(fields, &[])
}
