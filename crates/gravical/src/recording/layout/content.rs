//! Columns of a file without a header, by what the numbers look like.

use super::{Layout, with_claims};
use crate::recording::dialect::Dialect;
use crate::recording::finding::Finding;
use crate::recording::names::Quantity;
use crate::recording::units::{Evidence, accel_evidence};
use crate::stats::median;
use crate::{Error, Result};

/// Without names: a first column that rises steadily is time (or a counter);
/// of the triples that follow the accelerometer is the one whose magnitude
/// hardly changes, since gravity never leaves it.
pub(super) fn by_content(dialect: &Dialect, findings: &mut Vec<Finding>) -> Result<Layout> {
    let sample = &dialect.sample;
    let column =
        |i: usize| -> Vec<f64> { sample.iter().filter_map(|r| r.get(i).copied()).collect() };
    let first = column(0);
    let rises = first.len() > 3 && first.windows(2).all(|w| w[1] > w[0]);
    let counter = rises && first.windows(2).all(|w| w[1] - w[0] == 1.0);
    let from = usize::from(rises);
    let rest = dialect.fields - from;
    let triple = |at: usize| [from + at, from + at + 1, from + at + 2];
    let unknown = || {
        Error::input(
            "columns-unknown",
            format!(
                "the file has no header and {} columns whose meaning the numbers do not show",
                dialect.fields
            ),
        )
        .with_hint("name them in order, as --columns t,ax,ay,az,gx,gy,gz (_ skips one)")
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
        3 => (triple(0), None, None),
        4 => (triple(0), None, Some(from + 3)),
        6 | 9 => {
            let (a, b) = (
                steady(triple(0)).ok_or_else(unknown)?,
                steady(triple(3)).ok_or_else(unknown)?,
            );
            let gravity = |norm: f64| !matches!(accel_evidence(norm, true), Evidence::None);
            match (gravity(a.0), gravity(b.0)) {
                (true, false) => (triple(0), Some(triple(3)), None),
                (false, true) => (triple(3), Some(triple(0)), None),
                _ if a.1 < b.1 => (triple(0), Some(triple(3)), None),
                _ => (triple(3), Some(triple(0)), None),
            }
        }
        7 => {
            // The order of the sensor's registers, and of the report: the
            // temperature stands in the middle; else it stands last.
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
                (triple(0), Some(triple(4)), Some(from + 3))
            } else {
                (triple(0), Some(triple(3)), Some(from + 6))
            }
        }
        _ => return Err(unknown()),
    };
    let mut fields: Vec<(Quantity, usize)> =
        (0..3).map(|i| (Quantity::Accel(i), accel[i])).collect();
    if let Some(gyro) = gyro {
        fields.extend((0..3).map(|i| (Quantity::Gyro(i), gyro[i])));
    }
    if let Some(field) = temperature {
        fields.push((Quantity::Temperature, field));
    }
    if rises && !counter {
        fields.push((Quantity::Time, 0));
    }
    fields.sort_by_key(|(_, field)| *field);
    let shown: Vec<String> = (0..dialect.fields)
        .map(|i| match fields.iter().find(|(_, f)| *f == i) {
            Some((Quantity::Time, _)) => "t".to_owned(),
            Some((Quantity::Accel(a), _)) => format!("a{}", ["x", "y", "z"][*a]),
            Some((Quantity::Gyro(a), _)) => format!("g{}", ["x", "y", "z"][*a]),
            Some((Quantity::Temperature, _)) => "temp".to_owned(),
            _ => "_".to_owned(),
        })
        .collect();
    findings.push(Finding::warning(
        "columns-guessed",
        format!(
            "no header; taken by the numbers as --columns {} (give that option to be sure)",
            shown.join(",")
        ),
    ));
    Ok(with_claims(fields, &[]))
}
