//! Which column is what: by the user, by names, else by units and last letters, else by numbers.

use std::collections::HashMap;

use super::format::Format;
use super::names::{Column, is_linear, role_from_unit, sensor_of_file, words};
use super::rows::Rows;
use crate::error::Error;
use crate::judge::{median, shows_gravity};
use crate::options::ColumnsSpec;
use crate::role::Role;
use crate::units::is_listed;

/// Rows from which on a column that always rises is a clock.
const MIN_CLOCK_ROWS: usize = 20;

/// Rows of each sensor from which on several are told apart.
const MIN_TURNS: usize = 4;

/// From one sensor to another the step between rows is more than so many times that within one.
const JUMP: f64 = 5.0;

/// Assigns roles: by the user, the names in the format, the rows of the head.
pub(crate) fn assign(format: &mut Format, sample: &Rows, file_name: &str) -> Result<(), Error> {
    let is_gyroscope = format.options.is_gyroscope;
    assign_given(format)?;
    let file = sensor_of_file(file_name).filter(|_| !is_gyroscope);
    let file = file.or(is_gyroscope.then_some(Role::Gyro(0)));
    add_roles_from_units(format, file, file_name);
    let has_axis = format.columns.iter().any(|c| is_accel(c) || is_gyro(c));
    let has_names = format.names.iter().filter(|n| n.is_empty()).count() < 3;
    let mut accel = triples(&format.columns, Role::Accel);
    let mut gyro = triples(&format.columns, Role::Gyro);
    if format.names.is_empty() || !(has_axis || has_names) {
        match by_numbers(format, sample) {
            Some((first, second)) if is_gyroscope => gyro.push(second.unwrap_or(first)),
            Some((first, second)) if accel.is_empty() => {
                format.is_guessed = true;
                accel.push(first);
                gyro.extend(second);
            }
            None if accel.is_empty() && !is_gyroscope => return Err(columns_unknown(format)),
            _ => {}
        }
    }
    format.sensor = find_sensor_column(format, sample);
    choose_sensors(format, &accel, &gyro, sample)?;
    let is_no_axis = |c: &usize| sample.is_text(*c) || format.columns[*c].is_dated;
    if format.channels().iter().any(is_no_axis) {
        return Err(columns_unknown(format));
    }
    // Numbers may tell an axis where a name tells a clock.
    for column in format.channels() {
        let column = &mut format.columns[column];
        if !is_accel(column) && !is_gyro(column) {
            column.role = Role::Other;
        }
    }
    find_clocks(format, sample);
    Ok(())
}

/// Gives the columns that the user names their roles; no other column keeps such a role.
fn assign_given(format: &mut Format) -> Result<(), Error> {
    let is_gyroscope = format.options.is_gyroscope;
    let is_clock = |role: &Role| matches!(role, Role::Time | Role::Step);
    let is_gyro = |role: &Role| matches!(role, Role::Gyro(_));
    // The column of each role; none for a role that is not read.
    let mut given: Vec<(Role, Option<usize>)> = Vec::new();
    match format.options.columns.clone() {
        None => return Ok(()),
        Some(ColumnsSpec::Ordered(order)) => {
            if is_gyroscope && !order.iter().flatten().any(is_gyro) {
                return Ok(());
            }
            if order.len() > format.columns.len() {
                let (named, columns) = (order.len(), format.columns.len());
                let text = format!("{named} columns are named, the file has {columns}");
                return Err(columns_missing(text).with_hint("leave the last ones out"));
            }
            let columns = order.into_iter().enumerate();
            given.extend(columns.filter_map(|(column, role)| Some((role?, Some(column)))));
        }
        Some(ColumnsSpec::Named(pairs)) => {
            for (role, name) in pairs {
                let column = name.as_ref().and_then(|n| find_column(&format.names, n));
                match (column, name) {
                    // The columns of the accelerometer's file, and its clock.
                    _ if is_gyroscope && !is_gyro(&role) && !is_clock(&role) => {}
                    (None, None) if is_gyroscope => {}
                    (None, Some(_)) if is_gyroscope && role == Role::Time => {}
                    (None, Some(name)) => {
                        let error = columns_missing(format!("there is no column \"{name}\""));
                        return Err(error.with_hint(list_columns(&format.names)));
                    }
                    _ => given.push((role, column)),
                }
            }
        }
    }
    let names_clock = given.iter().any(|(role, _)| is_clock(role));
    for column in &mut format.columns {
        let is_taken = given.iter().any(|(role, _)| *role == column.role);
        if is_taken || names_clock && is_clock(&column.role) {
            column.role = Role::Other;
            column.is_dropped = true;
        }
    }
    for (role, column) in given {
        if let Some(column) = column.map(|c| &mut format.columns[c]) {
            column.role = role;
            column.is_given = true;
            column.is_dropped = role == Role::Other;
        }
    }
    format.has_no_clock = names_clock && !format.columns.iter().any(|c| is_clock(&c.role));
    Ok(())
}

fn columns_missing(text: String) -> Error {
    Error::usage("columns-missing", text).of_option("columns")
}

/// Names of columns that a hint lists.
const MAX_LISTED: usize = 16;

/// A hint that lists the columns of a file.
fn list_columns(names: &[String]) -> String {
    if names.is_empty() {
        return "the file has no header: give the channels in order, as t,ax,ay,az".to_owned();
    }
    let names = names.iter().map(String::as_str);
    let list: Vec<&str> = names.filter(|n| !n.is_empty()).collect();
    let more = if list.len() > MAX_LISTED { ", …" } else { "" };
    let shown = list[..list.len().min(MAX_LISTED)].join(", ");
    format!("its columns are: {shown}{more}; assign them, as ax=…,ay=…,az=…")
}

fn find_column(names: &[String], name: &str) -> Option<usize> {
    let exact = names.iter().position(|n| n == name);
    exact.or_else(|| names.iter().position(|n| n.eq_ignore_ascii_case(name)))
}

/// Of several sensors the first, or the one that the user asks for.
fn choose_sensors(
    format: &mut Format,
    accel: &[[usize; 3]],
    gyro: &[[usize; 3]],
    sample: &Rows,
) -> Result<(), Error> {
    if format.options.is_gyroscope {
        let none = || no_gyroscope(&format.names);
        format.accel = *gyro.first().ok_or_else(none)?;
        return Ok(());
    }
    // Names tell sensors apart that stand side by side.
    let are_named = !format.names.is_empty() && format.sensor.is_none();
    let named = if are_named { accel } else { &[] };
    let names = sensor_names(&format.columns, named);
    let at = match &format.options.sensor {
        Some(wanted) if are_named => find_sensor(wanted, &names, format, accel)?,
        _ => 0,
    };
    let first = accel.get(at).copied();
    format.accel = first.ok_or_else(|| no_accelerometer(!gyro.is_empty(), format))?;
    if format.options.sensor.is_none() {
        format.sensors = names;
    }
    // Of several gyroscopes the one whose name shares most with that of the accelerometer.
    let sensor = &format.columns[format.accel[0]].sensor;
    let shared = |t: &&[usize; 3]| {
        let other = &format.columns[t[0]].sensor;
        let is_shared = |word: &&str| other.split(' ').any(|w| w == *word);
        (other == sensor, sensor.split(' ').filter(is_shared).count())
    };
    // `max_by_key` returns the last of equals.
    let gyro = gyro.iter().rev().max_by_key(shared).copied();
    format.gyro = gyro.filter(|axes| !axes.iter().any(|c| sample.is_text(*c)));
    Ok(())
}

fn columns_unknown(format: &Format) -> Error {
    let columns = format.columns.len();
    let text = match &format.misfit {
        Some(misfit) => format!("{misfit}, and the numbers do not show their meaning"),
        None => format!(
            "the file has no header and {columns} columns whose meaning the numbers do not show"
        ),
    };
    Error::input("columns-unknown", text)
        .with_hint("name them in order, as t,ax,ay,az,gx,gy,gz; - skips one")
        .advise("columns", "")
}

fn no_gyroscope(names: &[String]) -> Error {
    let text = "no three columns of this file are a gyroscope's x, y and z";
    let columns = list_columns(names);
    let columns = columns.split(';').next().unwrap_or_default();
    Error::input("no-gyroscope", text)
        .with_hint(format!(
            "{columns}; give the file with the gyroscope, or name its columns, as gx=…,gy=…,gz=…"
        ))
        .advise("gyro", "")
        .advise("columns", "")
}

fn no_accelerometer(has_gyroscope: bool, format: &Format) -> Error {
    if has_gyroscope {
        let text = "this file holds a gyroscope and no accelerometer";
        let error = Error::input("gyroscope-alone", text);
        return error
            .with_hint("give the accelerometer's recording as the input, and this file beside it")
            .advise("gyro", "");
    }
    let text = "no three columns are named as an accelerometer's x, y and z";
    let error = Error::input("no-accelerometer", text)
        .with_hint(list_columns(&format.names))
        .advise("columns", "");
    match format.header_line {
        0 => error,
        line => error.at_line(line),
    }
}

/// `sensor-unknown`: there is no sensor `wanted` among these.
pub(crate) fn sensor_unknown(wanted: &str, sensors: &[String]) -> Error {
    let error = Error::usage("sensor-unknown", format!("there is no sensor {wanted}"));
    error.of_option("sensor").with_hint(if sensors.len() < 2 {
        "this file has one sensor: leave the option out".to_owned()
    } else {
        format!("give one of: {}", sensors.join(", "))
    })
}

fn is_accel(column: &Column) -> bool {
    matches!(column.role, Role::Accel(_))
}

fn is_gyro(column: &Column) -> bool {
    matches!(column.role, Role::Gyro(_))
}

fn add_roles_from_units(format: &mut Format, file: Option<Role>, file_name: &str) {
    // The Sensor Logger app writes acceleration without gravity to Accelerometer.csv and raw
    // acceleration to TotalAcceleration.csv.
    let is_sensor_logger =
        format.names.iter().any(|n| n == "seconds_elapsed") && file_name == "Accelerometer.csv";
    let is_linear_file = is_sensor_logger
        || file == Some(Role::Accel(0)) && words(file_name).iter().any(|w| is_linear(w));
    let has_accel = format.columns.iter().any(is_accel);
    let has_gyro = format.columns.iter().any(is_gyro);
    for (column, name) in format.columns.iter_mut().zip(&format.names) {
        if column.role != Role::Other || column.is_dropped {
            continue;
        }
        match role_from_unit(name, &column.unit, file) {
            Some(role @ Role::Accel(_)) if !has_accel => column.role = role,
            Some(role @ Role::Gyro(_)) if !has_gyro => column.role = role,
            _ => continue,
        }
        column.is_linear = is_linear_file && is_accel(column)
            || words(name).iter().any(|w| w.starts_with("linea"));
    }
}

/// The axes of all sensors of a kind; those without gravity are only there if no other is.
fn triples(columns: &[Column], role: fn(usize) -> Role) -> Vec<[usize; 3]> {
    let axis_of = |c: usize| Some((c, (0..3).find(|i| columns[c].role == role(*i))?));
    let mut axes: Vec<(usize, usize)> = (0..columns.len()).filter_map(axis_of).collect();
    // Where the user names an axis, the others need not be of a sensor of that name.
    axes.sort_by_key(|(c, _)| !columns[*c].is_given);
    let any_given = axes.first().is_some_and(|(c, _)| columns[*c].is_given);
    let mut sensors: HashMap<_, [Option<usize>; 3]> = HashMap::new();
    for (c, axis) in axes {
        let sensor = (&columns[c].sensor, columns[c].is_linear, &columns[c].unit);
        let own = sensors.entry((!any_given).then_some(sensor)).or_default();
        own[axis].get_or_insert(c);
    }
    let complete = |axes: &[Option<usize>; 3]| Some([axes[0]?, axes[1]?, axes[2]?]);
    let mut found: Vec<[usize; 3]> = sensors.values().filter_map(complete).collect();
    found.sort_unstable();
    // ROS calls raw acceleration linear, too; where another accelerometer stands beside it, gravity is
    // removed from it.
    let has_gravity = |axes: &[usize; 3]| {
        let column = &columns[axes[0]];
        !column.is_linear && !column.sensor.split(' ').any(|word| word == "linear")
    };
    if found.iter().any(has_gravity) {
        found.retain(has_gravity);
    }
    found
}

/// What the name of each sensor says beyond what all say; its number if that tells nothing.
fn sensor_names(columns: &[Column], found: &[[usize; 3]]) -> Vec<String> {
    let words = |t: &[usize; 3]| columns[t[0]].sensor.split(' ').filter(|w| !w.is_empty());
    let is_common = |word: &&str| found.iter().all(|t| words(t).any(|w| w == *word));
    let rest = |t: &[usize; 3]| {
        let words: Vec<&str> = words(t).filter(|w| !is_common(w)).collect();
        words.join("-")
    };
    let names: Vec<String> = found.iter().map(rest).collect();
    let name = |(i, name): (usize, &String)| {
        if name.is_empty() || names.iter().filter(|other| *other == name).count() > 1 {
            (i + 1).to_string()
        } else {
            name.clone()
        }
    };
    names.iter().enumerate().map(name).collect()
}

/// The sensor that the user asks for: by its name, by words of it, or by its number from 1.
fn find_sensor(
    wanted: &str,
    names: &[String],
    format: &Format,
    found: &[[usize; 3]],
) -> Result<usize, Error> {
    let asked = words(wanted);
    let has_name = |i: &usize| names[*i] == wanted;
    let has_words = |i: &usize| {
        let sensor = &format.columns[found[*i][0]].sensor;
        !asked.is_empty() && asked.iter().all(|w| sensor.split(' ').any(|o| o == w))
    };
    let has_number = |i: &usize| wanted == (i + 1).to_string();
    let ways: [&dyn Fn(&usize) -> bool; 3] = [&has_name, &has_words, &has_number];
    let fits = ways.map(|way| (0..found.len()).filter(way).collect::<Vec<_>>());
    match fits.iter().find(|fits| !fits.is_empty()).map(Vec::as_slice) {
        Some([only]) => Ok(*only),
        _ => Err(sensor_unknown(wanted, names)),
    }
}

/// Accelerometer and gyroscope behind the clocks and counters, told by gravity.
fn by_numbers(format: &mut Format, sample: &Rows) -> Option<([usize; 3], Option<[usize; 3]>)> {
    let n = format.columns.len();
    let is_open = sample.columns[n - 1].iter().all(|v| v.is_nan()) && !sample.is_text(n - 1);
    let clocks = (0..n).take_while(|c| is_clock(&sample.columns[*c])).count();
    // The rate of a turn may rise as time does.
    let from = if format.options.is_gyroscope {
        clocks.min((n - usize::from(is_open)).saturating_sub(3))
    } else {
        clocks
    };
    for (column, values) in format.columns.iter_mut().zip(&sample.columns).take(from) {
        column.role = if is_counter(values) {
            Role::Other
        } else {
            Role::Time
        };
    }
    let axes = |k: usize| [from + k, from + k + 1, from + k + 2];
    match (n - usize::from(is_open)).checked_sub(from)? {
        3 => return Some((axes(0), None)),
        // Which of four numbers would be the stamp?
        4 if format.options.is_gyroscope => return None,
        4 => {
            format.columns[from + 3].role = Role::Temperature;
            return Some((axes(0), None));
        }
        6 | 9 => {}
        // In the order of the sensor's registers the temperature is in the middle; otherwise it is
        // last.
        7 => {
            let [middle, last] = [3, 6].map(|k| spread(&sample.columns[from + k]));
            let (temperature, gyro) = if middle <= last { (3, 4) } else { (6, 3) };
            format.columns[from + temperature].role = Role::Temperature;
            return Some((axes(0), Some(axes(gyro))));
        }
        _ => return None,
    }
    let (first, second) = (axes(0), axes(3));
    let values = |axes: [usize; 3]| axes.map(|c| sample.columns[c].as_slice());
    let shows_gravity = |axes| shows_gravity(values(axes));
    let is_first = match (shows_gravity(first), shows_gravity(second)) {
        (a, b) if a != b => a,
        _ => {
            let spread = |axes| norm_spread(values(axes)).unwrap_or(f64::MAX);
            spread(first) <= spread(second)
        }
    };
    let (accel, gyro) = if is_first {
        (first, second)
    } else {
        (second, first)
    };
    Some((accel, Some(gyro)))
}

/// Largest deviation of a column from its mean, as a share of it.
fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let most = values.iter().fold(0.0_f64, |m, v| m.max((v - mean).abs()));
    if mean.abs() > 1.0 {
        most / mean.abs()
    } else {
        f64::INFINITY
    }
}

/// Median deviation of the magnitude from its median, as a share of it.
fn norm_spread(axes: [&[f64]; 3]) -> Option<f64> {
    let norm = |row: usize| axes.iter().map(|c| c[row].powi(2)).sum::<f64>().sqrt();
    let norms: Vec<f64> = (0..axes[0].len()).map(norm).collect();
    let middle = median(norms.iter().copied())?;
    Some(median(norms.iter().map(|x| (x - middle).abs()))? / middle)
}

fn is_clock(values: &[f64]) -> bool {
    let mut steps = values.windows(2).map(|w| w[1] - w[0]);
    let seconds = values.windows(2).filter(|w| w[1] - w[0] == 1.0).count();
    if seconds >= 2 && steps.all(|s| s == 0.0 || s == 1.0) {
        return true;
    }
    let (up, down) = crate::judge::trend(values);
    up >= 0.1 && down < 0.1 && down < 0.2 * up
}

/// Numbers of rows.
pub(crate) fn is_counter(values: &[f64]) -> bool {
    values.windows(2).all(|w| w[1] - w[0] == 1.0)
}

/// Columns of dates are clocks; without any clock so is the only column that always rises.
fn find_clocks(format: &mut Format, sample: &Rows) {
    if format.has_no_clock {
        return;
    }
    let is_given_clock = |c: &Column| c.is_given && c.role == Role::Time;
    let names_clock = format.columns.iter().any(is_given_clock);
    let axes = format.channels();
    for c in 0..format.columns.len() {
        let column = &format.columns[c];
        let is_open = !column.is_dropped && !column.is_given && !names_clock;
        if column.is_dated && is_open && !axes.contains(&c) && !sample.is_text(c) {
            format.columns[c].role = Role::Time;
        }
    }
    let is_clock = |c: &Column| matches!(c.role, Role::Time | Role::Step);
    let has_clock = format.columns.iter().any(is_clock);
    if has_clock || format.names.is_empty() {
        return;
    }
    let rises = |c: &usize| {
        let values = &sample.columns[*c];
        format.columns[*c].role == Role::Other
            && !axes.contains(c)
            && !format.columns[*c].is_dropped
            && values.len() > MIN_CLOCK_ROWS
            && values.windows(2).all(|w| w[1] > w[0])
            && !counts_mostly(values)
    };
    format.unnamed_clocks = (0..format.columns.len()).filter(rises).collect();
    if let [only] = format.unnamed_clocks[..] {
        format.columns[only].role = Role::Time;
    }
}

/// Numbers of rows, perhaps with lost ones.
fn counts_mostly(values: &[f64]) -> bool {
    let is_whole = values.windows(2).all(|w| (w[1] - w[0]).fract() == 0.0);
    is_whole && median(values.windows(2).map(|w| w[1] - w[0])) == Some(1.0)
}

/// The column that tells several sensors apart whose rows take turns: few values, each as often as
/// the others, another one in nearly every row, and rows of one instant or a name that says so; or
/// another one in every fifth row, a name or words, and measurements that jump with it.
fn find_sensor_column(format: &Format, sample: &Rows) -> Option<usize> {
    const NAMES: &str = "i id instance sensor device channel node type kind";
    (0..format.columns.len()).find_map(|c| {
        let (column, is_text) = (&format.columns[c], sample.is_text(c));
        let is_read = is_accel(column) || is_gyro(column) || column.role == Role::Label;
        if is_read || column.role != Role::Other && !is_text {
            return None;
        }
        let values = sensor_codes(sample, c)?;
        let rows = values.len();
        let counts = (0..16).map(|code| values.iter().filter(|v| **v == code).count());
        let counts: Vec<usize> = counts.filter(|count| *count > 0).collect();
        let kinds = counts.len();
        let is_near = |count: &usize| (*count * kinds).abs_diff(rows) * 5 <= rows;
        let is_even = rows >= MIN_TURNS * kinds && counts.iter().all(is_near);
        let changes = values.windows(2).filter(|w| w[0] != w[1]).count();
        let takes_turns = (2..=8).contains(&kinds) && is_even && changes * 5 >= rows * 4;
        let is_named = || {
            let name = format.names.get(c);
            name.is_some_and(|n| words(n).iter().any(|w| is_listed(NAMES, w)))
        };
        let has_pairs = || {
            let columns = format.columns.iter().zip(&sample.columns);
            let mut clocks = columns.filter(|(column, _)| column.role == Role::Time);
            clocks.any(|(_, stamps)| {
                let same = stamps.windows(2).filter(|w| w[0] == w[1]).count();
                same * kinds * 5 >= stamps.len() * (kinds - 1) * 4
            })
        };
        let is_mixed = || {
            let axes = 0..format.columns.len();
            let axes = axes.filter(|c| is_accel(&format.columns[*c]));
            let axes = sample.slices(&axes.collect::<Vec<_>>());
            (2..=8).contains(&kinds)
                && (is_text || is_named())
                && counts.iter().all(|count| *count >= MIN_TURNS)
                && changes * 5 >= rows
                && rows == sample.rows()
                && jumps(&axes, &values)
        };
        let is_told = takes_turns && (is_text || is_named() || has_pairs());
        (is_told || is_mixed()).then_some(c)
    })
}

/// Whether measurements jump from one kind of row to another as they do not within each kind.
fn jumps(axes: &[&[f64]], kinds: &[u8]) -> bool {
    let mut last = HashMap::new();
    let (mut within, mut across) = (Vec::new(), Vec::new());
    for (row, kind) in kinds.iter().enumerate() {
        let step = |before: usize| {
            let steps = axes.iter().map(|axis| (axis[row] - axis[before]).abs());
            steps.fold(0.0, f64::max)
        };
        within.extend(last.insert(kind, row).map(step));
        if row > 0 && kinds[row - 1] != *kind {
            across.push(step(row - 1));
        }
    }
    let jump = median(across).zip(median(within));
    jump.is_some_and(|(across, within)| across > JUMP * within)
}

/// The values of a column as small numbers, if that is what they are.
fn sensor_codes(rows: &Rows, column: usize) -> Option<Vec<u8>> {
    if rows.is_text(column) {
        let codes = &rows.texts[column];
        return codes.iter().all(|c| *c < 16).then(|| codes.clone());
    }
    let is_code = |v: &f64| v.fract() == 0.0 && (0.0..16.0).contains(v);
    let values = rows.columns[column].iter().filter(|v| !v.is_nan());
    let are_codes = values.clone().all(is_code);
    are_codes.then(|| values.map(|v| *v as u8).collect())
}
