//! Which column is what: by names, else by units and last letters, else by numbers.

use super::batch::Batch;
use super::format::{Format, Layout};
use super::names::{Column, Role, role_from_unit, words};
use crate::error::{Error, Kind};
use crate::judge::{accel_scale, median};

/// Rows from which on a column that always rises is a clock.
const MIN_CLOCK_ROWS: usize = 20;

/// Rows of each sensor from which on several are told apart.
const MIN_TURNS: usize = 4;

/// Assigns roles, by the names in the format and the rows of the head.
pub(crate) fn assign(format: &mut Format, sample: &Batch, file_name: &str) -> Result<(), Error> {
    let is_gyro_file = file_name.to_lowercase().contains("gyr");
    add_roles_from_units(format, is_gyro_file);
    let has_axis = format.columns.iter().any(|c| is_accel(c) || is_gyro(c));
    let has_names = !format.names.is_empty();
    let (accel, gyro) = if has_names && has_axis {
        (
            triple(&format.columns, Role::Accel),
            triple(&format.columns, Role::Gyro),
        )
    } else if has_names && format.names.iter().filter(|n| n.is_empty()).count() < 3 {
        (None, None)
    } else {
        let (accel, gyro) = by_numbers(format, sample).ok_or(Kind::ColumnsUnknown)?;
        (Some(accel), gyro)
    };
    format.accel = accel.ok_or(Kind::NoAccelerometer)?;
    format.gyro = gyro;
    if format.channels().iter().any(|c| sample.is_text(*c)) {
        return Err(Kind::ColumnsUnknown.into());
    }
    find_clocks(format, sample);
    format.sensor = find_sensor_column(format, sample);
    Ok(())
}

fn is_accel(column: &Column) -> bool {
    matches!(column.role, Role::Accel(_))
}

fn is_gyro(column: &Column) -> bool {
    matches!(column.role, Role::Gyro(_))
}

fn add_roles_from_units(format: &mut Format, is_gyro_file: bool) {
    let has_accel = format.columns.iter().any(is_accel);
    let has_gyro = format.columns.iter().any(is_gyro);
    for (column, name) in format.columns.iter_mut().zip(&format.names) {
        if column.role != Role::Other {
            continue;
        }
        match role_from_unit(name, &column.unit, is_gyro_file) {
            Some(role @ Role::Accel(_)) if !has_accel => column.role = role,
            Some(role @ Role::Gyro(_)) if !has_gyro => column.role = role,
            _ => continue,
        }
        column.is_linear = words(name).iter().any(|w| w.starts_with("linea"));
    }
}

/// The first three axes of one sensor; acceleration without gravity only if there is no other.
fn triple(columns: &[Column], role: fn(usize) -> Role) -> Option<[usize; 3]> {
    let first = |linear: bool| {
        columns
            .iter()
            .position(|c| c.role == role(0) && c.is_linear <= linear)
    };
    let x = first(false).or_else(|| first(true))?;
    let is_same = |c: &Column| c.sensor == columns[x].sensor && c.is_linear == columns[x].is_linear;
    let axis = |i: usize| columns.iter().position(|c| c.role == role(i) && is_same(c));
    Some([x, axis(1)?, axis(2)?])
}

/// Accelerometer and gyroscope behind the clocks and counters, told by gravity.
fn by_numbers(format: &mut Format, sample: &Batch) -> Option<([usize; 3], Option<[usize; 3]>)> {
    let n = format.columns.len();
    let is_open = sample.columns[n - 1].iter().all(|v| v.is_nan()) && !sample.is_text(n - 1);
    let from = (0..n).take_while(|c| is_clock(&sample.columns[*c])).count();
    for (column, values) in format.columns.iter_mut().zip(&sample.columns).take(from) {
        column.role = if is_counter(values) {
            Role::Other
        } else {
            Role::Time
        };
    }
    let axes = |k: usize| [from + k, from + k + 1, from + k + 2];
    let (first, second) = match (n - usize::from(is_open)).checked_sub(from)? {
        3 | 4 => return Some((axes(0), None)),
        6 | 9 => (axes(0), axes(3)),
        7 => (axes(0), axes(4)),
        _ => return None,
    };
    let values = |axes: [usize; 3]| axes.map(|c| sample.columns[c].as_slice());
    let shows_gravity = |axes| accel_scale(values(axes), None).unit.is_some();
    let is_first = match (shows_gravity(first), shows_gravity(second)) {
        (a, b) if a != b => a,
        _ => {
            let spread = |axes| norm_spread(values(axes)).unwrap_or(f64::MAX);
            spread(first) <= spread(second)
        }
    };
    let gyro_behind_accel = if is_first {
        (first, second)
    } else {
        (axes(3), first)
    };
    Some((gyro_behind_accel.0, Some(gyro_behind_accel.1)))
}

/// Median deviation of the magnitude from its median, as a share of it.
fn norm_spread(axes: [&[f64]; 3]) -> Option<f64> {
    let norm = |row: usize| axes.iter().map(|c| c[row].powi(2)).sum::<f64>().sqrt();
    let norms: Vec<f64> = (0..axes[0].len()).map(norm).collect();
    let middle = median(norms.iter().copied())?;
    Some(median(norms.iter().map(|x| (x - middle).abs()))? / middle)
}

fn is_clock(values: &[f64]) -> bool {
    let (up, down) = crate::judge::trend(values);
    up >= 0.1 && down < 0.1 && down < 0.2 * up
}

/// Numbers of rows.
pub(crate) fn is_counter(values: &[f64]) -> bool {
    values.windows(2).all(|w| w[1] - w[0] == 1.0)
}

/// Columns of dates are clocks; without any clock so is a column that always rises.
fn find_clocks(format: &mut Format, sample: &Batch) {
    for c in 0..format.columns.len() {
        if format.columns[c].is_dated && !format.is_axis(c) && !sample.is_text(c) {
            format.columns[c].role = Role::Time;
        }
    }
    let has_clock = format
        .columns
        .iter()
        .any(|c| matches!(c.role, Role::Time | Role::Step));
    if has_clock || format.names.is_empty() {
        return;
    }
    let rises = |c: &usize| {
        let values = &sample.columns[*c];
        format.columns[*c].role == Role::Other
            && values.len() > MIN_CLOCK_ROWS
            && values.windows(2).all(|w| w[1] > w[0])
            && !is_counter(values)
    };
    if let Some(c) = (0..format.columns.len()).find(rises) {
        format.columns[c].role = Role::Time;
    }
}

/// The column that tells several sensors apart whose rows take turns, and how many they are: few
/// values, each as often as the others, another one in nearly every row, and rows of one instant
/// or a name that says so.
fn find_sensor_column(format: &Format, sample: &Batch) -> Option<(usize, usize)> {
    const NAMES: [&str; 7] = ["i", "id", "instance", "sensor", "device", "channel", "node"];
    let rows = sample.rows();
    (0..format.columns.len()).find_map(|c| {
        let is_text = sample.is_text(c) && !matches!(format.layout, Layout::Sentences(_));
        let role = format.columns[c].role;
        if format.is_axis(c) || role == Role::Label || role != Role::Other && !is_text {
            return None;
        }
        let values = sensor_codes(sample, c)?;
        let mut counts = [0; 16];
        for v in &values {
            counts[usize::from(*v)] += 1;
        }
        let kinds = counts.iter().filter(|k| **k > 0).count();
        let is_even = rows >= MIN_TURNS * kinds
            && counts
                .iter()
                .all(|k| *k == 0 || (*k * kinds).abs_diff(rows) * 5 <= rows);
        let changes = values.windows(2).filter(|w| w[0] != w[1]).count();
        let takes_turns = (2..=8).contains(&kinds) && is_even && changes * 5 >= rows * 4;
        let is_named = || {
            let name = format.names.get(c);
            name.is_some_and(|n| words(n).iter().any(|w| NAMES.contains(&w.as_str())))
        };
        let has_pairs = || {
            let stamps =
                (0..format.columns.len()).filter(|c| format.columns[*c].role == Role::Time);
            stamps.map(|c| &sample.columns[c]).any(|v| {
                let same = v.windows(2).filter(|w| w[0] == w[1]).count();
                same * kinds * 5 >= rows * (kinds - 1) * 4
            })
        };
        (takes_turns && (is_text || is_named() || has_pairs())).then_some((c, kinds))
    })
}

/// The values of a column as small numbers, if that is what they are.
pub(crate) fn sensor_codes(batch: &Batch, column: usize) -> Option<Vec<u8>> {
    if batch.is_text(column) {
        let codes = &batch.texts[column];
        return codes.iter().all(|c| *c < 16).then(|| codes.clone());
    }
    let is_code = |v: &f64| v.fract() == 0.0 && (0.0..16.0).contains(v);
    let values = &batch.columns[column];
    values
        .iter()
        .all(is_code)
        .then(|| values.iter().map(|v| *v as u8).collect())
}
