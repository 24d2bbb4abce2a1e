//! Channels of a file without a header, from its numbers.

use super::Named;
use super::clock::first_column_rises;
use crate::recording::dialect::Dialect;
use crate::recording::names::{ColumnName, Quantity};
use crate::recording::units::{Evidence, accel_evidence};
use crate::stats::median;
use crate::{Error, Result};

/// Assigns the columns of a file without a header.
///
/// A first column that rises steadily is time (or a counter); of the triples after it the
/// accelerometer is the one whose magnitude varies least, since it always includes gravity.
///
/// # Errors
///
/// `columns-unknown` (input).
pub(super) fn by_content(dialect: &Dialect) -> Result<Vec<Named>> {
    let sample = &dialect.sample;
    let column =
        |i: usize| -> Vec<f64> { sample.iter().filter_map(|r| r.get(i).copied()).collect() };
    let (rises, counter) = first_column_rises(sample);
    let from = usize::from(rises);
    // A delimiter at the end of each row makes an empty last field.
    let last = dialect.fields.saturating_sub(1);
    let open_ended = sample
        .iter()
        .all(|r| r.get(last).is_none_or(|v| v.is_nan()));
    let rest = dialect.fields - from - usize::from(open_ended && last > from);
    let triple = |at: usize| [from + at, from + at + 1, from + at + 2];
    let unknown = || {
        let why = match dialect.misfit {
            Some((line, names)) => format!(
                "line {line} has {names} names for {} columns, so it cannot be their header, and the numbers do not show their meaning",
                dialect.fields
            ),
            None => format!(
                "the file has no header and {} columns whose meaning the numbers do not show",
                dialect.fields
            ),
        };
        Error::input("columns-unknown", why)
            .with_hint("name them in order, as --columns t,ax,ay,az,gx,gy,gz (- skips one)")
    };
    let steady = |t: [usize; 3]| -> Option<(f64, f64)> {
        let mut norms: Vec<f64> = sample
            .iter()
            .map(|r| t.iter().map(|i| r[*i] * r[*i]).sum::<f64>().sqrt())
            .filter(|n| n.is_finite())
            .collect();
        let middle = median(&mut norms)?;
        let mut off: Vec<f64> = norms.iter().map(|n| (n - middle).abs()).collect();
        Some((middle, median(&mut off)? / middle.max(f64::MIN_POSITIVE)))
    };
    let (accel, gyro, temperature) = match rest {
        3 => (Some(triple(0)), None, None),
        4 => (Some(triple(0)), None, Some(from + 3)),
        6 | 9 => {
            let (a, b) = (
                steady(triple(0)).ok_or_else(unknown)?,
                steady(triple(3)).ok_or_else(unknown)?,
            );
            let gravity = |norm: f64| !matches!(accel_evidence(norm, true), Evidence::None);
            match (gravity(a.0), gravity(b.0)) {
                (true, false) => (Some(triple(0)), Some(triple(3)), None),
                (false, true) => (Some(triple(3)), Some(triple(0)), None),
                _ if a.1 < b.1 => (Some(triple(0)), Some(triple(3)), None),
                _ => (Some(triple(3)), Some(triple(0)), None),
            }
        }
        7 => {
            // In the order of the sensor's registers the temperature is in the middle; otherwise
            // it is last.
            let spread = |i: usize| {
                let c = column(from + i);
                let mean = c.iter().sum::<f64>() / c.len().max(1) as f64;
                let most = c.iter().fold(0.0_f64, |m, v| m.max((v - mean).abs()));
                if mean.abs() > 1.0 {
                    most / mean.abs()
                } else {
                    f64::INFINITY
                }
            };
            if spread(3) <= spread(6) {
                (Some(triple(0)), Some(triple(4)), Some(from + 3))
            } else {
                (Some(triple(0)), Some(triple(3)), Some(from + 6))
            }
        }
        _ => return Err(unknown()),
    };
    let mut columns = Vec::new();
    let mut add = |quantity, field| {
        let name = ColumnName {
            quantity,
            unit: None,
            sensor: String::new(),
            without_gravity: false,
        };
        columns.push((field, name));
    };
    for i in 0..3 {
        if let Some(accel) = accel {
            add(Quantity::Accel(i), accel[i]);
        }
        if let Some(gyro) = gyro {
            add(Quantity::Gyro(i), gyro[i]);
        }
    }
    if let Some(field) = temperature {
        add(Quantity::Temperature, field);
    }
    if rises {
        add(
            if counter {
                Quantity::Index
            } else {
                Quantity::Time
            },
            0,
        );
    }
    Ok(columns)
}
