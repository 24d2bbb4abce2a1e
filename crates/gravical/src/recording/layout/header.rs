//! Channels from the names in a header.

use super::Named;
use crate::recording::dialect::Header;
use crate::recording::names::{
    ColumnName, Quantity, SensorKind, axis_in_g, bare_axis, sensor_of_file, understand,
};
use crate::recording::units::{AccelUnit, GyroUnit};

/// Columns with known names, with their fields. If no name gives an accelerometer, bare
/// axes (`x`, `Y (m/s^2)`) are assigned to it, unless their unit or the file name contradicts.
pub(in crate::recording) fn understand_all(header: &Header, file: &str) -> Vec<Named> {
    let mut columns: Vec<Named> = header
        .names
        .iter()
        .enumerate()
        .filter_map(|(i, n)| Some((i, understand(n)?)))
        .collect();
    instead_of_gyro(&mut columns, header, file);
    if columns
        .iter()
        .all(|(_, c)| c.quantity != Quantity::Accel(0))
    {
        let named = columns.len();
        for (field, name) in header.names.iter().enumerate() {
            let Some((axis, unit)) = bare_axis(name) else {
                continue;
            };
            let unit = unit.or_else(|| header.unit(field).map(str::to_owned));
            let column = bare(axis, unit, file, &header.names);
            columns.extend(column.map(|c| (field, c)));
        }
        // Two sets of bare axes in one unit cannot be distinguished: use the first.
        let bare = &columns[named..];
        if bare.len() > 3 && bare.iter().all(|(_, c)| c.unit == bare[0].1.unit) {
            columns.truncate(named + 3);
        }
    }
    columns
}

/// Without an accelerometer, a `g` that ends the names of three axes is their unit, unless the
/// file is named after a gyroscope.
fn instead_of_gyro(columns: &mut Vec<Named>, header: &Header, file: &str) {
    if matches!(sensor_of_file(file), Some(SensorKind::Gyroscope)) {
        return;
    }
    let accel = |c: &ColumnName| matches!(c.quantity, Quantity::Accel(_));
    let in_g: Vec<Named> = header
        .names
        .iter()
        .enumerate()
        .filter_map(|(field, name)| Some((field, axis_in_g(name)?)))
        .collect();
    let readings = || in_g.iter().filter(|(_, c)| !is_spread(&c.sensor));
    let axes = |i| {
        readings()
            .filter(|(_, c)| c.quantity == Quantity::Accel(i))
            .count()
            == 1
    };
    if columns.iter().all(|(_, c)| !accel(c)) && (0..3).all(axes) {
        columns.retain(|(field, _)| in_g.iter().all(|(f, _)| f != field));
        columns.extend(readings().cloned());
    }
}

/// `sd_x_g` beside `mean_x_g`: the scatter of the rows that a mean is of.
fn is_spread(sensor: &str) -> bool {
    let spread = |word: &str| matches!(word, "sd" | "std" | "stdev" | "sigma" | "var" | "se");
    sensor.split(' ').any(spread)
}

fn bare(axis: usize, unit: Option<String>, file: &str, names: &[String]) -> Option<ColumnName> {
    let kind = sensor_of_file(file);
    let of_accel = unit.as_deref().and_then(AccelUnit::parse);
    let of_gyro = unit.as_deref().and_then(GyroUnit::parse);
    let by_unit = match (of_accel, of_gyro) {
        (Some(_), None) => Some(true),
        (None, Some(_)) => Some(false),
        (None, None) if unit.is_some() => return None,
        _ => None,
    };
    let is_accel = match (by_unit, kind) {
        (Some(is), _) => is,
        (None, Some(SensorKind::Accelerometer(_)) | None) => true,
        (None, Some(SensorKind::Gyroscope)) => false,
        (None, Some(SensorKind::Other)) => return None,
    };
    // The Sensor Logger app writes acceleration without gravity to Accelerometer.csv and raw
    // acceleration to TotalAcceleration.csv.
    let sensor_logger = names.iter().any(|n| n == "seconds_elapsed")
        && file.rsplit(['/', '\\']).next() == Some("Accelerometer.csv");
    let without_gravity = sensor_logger || kind == Some(SensorKind::Accelerometer(true));
    Some(ColumnName {
        quantity: match is_accel {
            true => Quantity::Accel(axis),
            false => Quantity::Gyro(axis),
        },
        unit,
        sensor: String::new(),
        without_gravity: is_accel && without_gravity,
    })
}
