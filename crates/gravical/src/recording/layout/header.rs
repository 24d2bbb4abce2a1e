//! Columns by the names in the header.

use super::spec::columns_there;
use super::{Layout, with_claims};
use crate::recording::finding::Finding;
use crate::recording::names::{ColumnName, Quantity, understand};
use crate::{Error, Result};

/// Columns whose names say something, with their fields.
pub(super) fn understand_all(names: &[String]) -> Vec<(usize, ColumnName)> {
    names
        .iter()
        .enumerate()
        .filter_map(|(i, n)| Some((i, understand(n)?)))
        .collect()
}

/// Fields of x, y and z of every sensor of a kind: one sensor is one choice of
/// (name, unit) with all three axes.
pub(super) fn sensors(
    understood: &[(usize, ColumnName)],
    of: fn(usize) -> Quantity,
) -> Vec<[usize; 3]> {
    let mut found: Vec<[usize; 3]> = Vec::new();
    for (_, first) in understood.iter().filter(|(_, c)| c.quantity == of(0)) {
        let axis = |i: usize| {
            understood
                .iter()
                .find(|(_, c)| {
                    c.quantity == of(i)
                        && c.sensor == first.sensor
                        && c.without_gravity == first.without_gravity
                        && c.unit == first.unit
                })
                .map(|(f, _)| *f)
        };
        if let (Some(x), Some(y), Some(z)) = (axis(0), axis(1), axis(2))
            && !found.contains(&[x, y, z])
        {
            found.push([x, y, z]);
        }
    }
    found
}

/// The layout that the names show.
pub(super) fn by_names(names: &[String], findings: &mut Vec<Finding>) -> Result<Layout> {
    let understood = understand_all(names);
    let name_of = |field: usize| understood.iter().find(|(f, _)| *f == field).map(|(_, c)| c);
    let mut accels = sensors(&understood, Quantity::Accel);
    accels.sort_by_key(|a| name_of(a[0]).is_some_and(|c| c.without_gravity));
    let Some(&accel) = accels.first() else {
        return Err(Error::input(
            "no-accelerometer",
            "no three columns of this file are named as an accelerometer's x, y and z",
        )
        .with_hint(columns_there(names)));
    };
    let sensor = name_of(accel[0]).map_or("", |c| &c.sensor);
    let gyros = sensors(&understood, Quantity::Gyro);
    let gyro = gyros
        .iter()
        .find(|g| name_of(g[0]).is_some_and(|c| c.sensor == sensor))
        .or(gyros.first());
    if accels.len() > 1 {
        let list: Vec<&str> = accels
            .iter()
            .filter_map(|a| names.get(a[0]))
            .map(String::as_str)
            .collect();
        findings.push(Finding::warning(
            "several-sensors",
            format!(
                "{} accelerometers ({}); the first is read, --columns chooses another",
                accels.len(),
                list.join(", ")
            ),
        ));
    }
    let mut fields: Vec<(Quantity, usize)> =
        (0..3).map(|i| (Quantity::Accel(i), accel[i])).collect();
    if let Some(gyro) = gyro {
        fields.extend((0..3).map(|i| (Quantity::Gyro(i), gyro[i])));
    }
    for quantity in [Quantity::Time, Quantity::Temperature, Quantity::Label] {
        let of_sensor =
            |(_, c): &&(usize, ColumnName)| c.quantity == quantity && c.sensor == sensor;
        if let Some((field, _)) = understood
            .iter()
            .find(of_sensor)
            .or_else(|| understood.iter().find(|(_, c)| c.quantity == quantity))
        {
            fields.push((quantity, *field));
        }
    }
    let claims: Vec<(Quantity, ColumnName)> = fields
        .iter()
        .filter_map(|(q, f)| Some((*q, name_of(*f)?.clone())))
        .collect();
    if claims
        .iter()
        .any(|(q, c)| matches!(q, Quantity::Accel(_)) && c.without_gravity)
    {
        findings.push(Finding::warning(
            "without-gravity",
            "the only acceleration here may have gravity taken out by the device; calibration needs the raw specific force",
        ));
    }
    Ok(with_claims(fields, &claims))
}
