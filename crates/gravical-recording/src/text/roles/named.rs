//! Columns whose names, units or last letters tell them.

use std::collections::HashMap;
use std::hash::Hash;

use gravical_judge::Role;

use crate::problem::Problem;
use crate::text::format::Format;
use crate::text::names::{Column, axis, is_linear, role_from_unit, words};

/// Roles by unit and last letter, where no word is known.
pub(super) fn add_roles_from_units(format: &mut Format, file: Option<Role>, file_name: &str) {
    // The Sensor Logger app writes acceleration without gravity to Accelerometer.csv and raw
    // acceleration to TotalAcceleration.csv.
    let is_sensor_logger =
        format.names.iter().any(|n| n == "seconds_elapsed") && file_name == "Accelerometer.csv";
    let is_linear_file = is_sensor_logger
        || file == Some(Role::Accel(0)) && words(file_name).iter().any(|w| is_linear(w));
    let has_accel = format
        .columns
        .iter()
        .any(|c| c.is_accel() && !c.may_be_linear());
    let has_gyro = format.columns.iter().any(Column::is_gyro);
    for (column, name) in format.columns.iter_mut().zip(&format.names) {
        if column.role != Role::Other || column.is_dropped || column.is_foreign {
            continue;
        }
        match role_from_unit(name, &column.unit, file) {
            Some(role @ Role::Accel(_)) if !has_accel => column.role = role,
            Some(role @ Role::Gyro(_)) if !has_gyro => column.role = role,
            _ => continue,
        }
        column.is_linear = is_linear_file && column.is_accel()
            || words(name).iter().any(|w| w.starts_with("linea"));
    }
}

/// Rates of a body are p, q, r in flight mechanics.
pub(super) fn add_body_rates(format: &mut Format) {
    let find = |name: &str| {
        let mut names = format.names.iter().zip(&format.columns);
        names.position(|(n, c)| words(n) == [name] && c.role == Role::Other && !c.is_dropped)
    };
    let has_accel = format.columns.iter().any(Column::is_accel) || format.options.is_gyroscope;
    if let [Some(p), Some(q), Some(r)] = ["p", "q", "r"].map(find)
        && has_accel
        && !format.columns.iter().any(Column::is_gyro)
    {
        for (axis, column) in [p, q, r].into_iter().enumerate() {
            format.columns[column].role = Role::Gyro(axis);
        }
    }
}

/// The axes of all sensors of a kind.
pub(super) fn triples(columns: &[Column], role: fn(usize) -> Role) -> Vec<[usize; 3]> {
    let axis_of = |c: usize| Some((c, (0..3).find(|i| columns[c].role == role(*i))?));
    let mut axes: Vec<(usize, usize)> = (0..columns.len()).filter_map(axis_of).collect();
    // Where the user names an axis, the others need not be of a sensor of that name.
    axes.sort_by_key(|(c, _)| !columns[*c].is_given);
    let any_given = axes.first().is_some_and(|(c, _)| columns[*c].is_given);
    let keyed = axes.into_iter().map(|(c, axis)| {
        let sensor = (&columns[c].sensor, columns[c].is_linear, &columns[c].unit);
        ((!any_given).then_some(sensor), axis, c)
    });
    group_axes(keyed).into_iter().map(|group| group.1).collect()
}

/// What three axes have in common, and their columns, of keys, axes and columns.
fn group_axes<K: Eq + Hash>(axes: impl Iterator<Item = (K, usize, usize)>) -> Vec<(K, [usize; 3])> {
    let mut groups: HashMap<K, [Option<usize>; 3]> = HashMap::new();
    for (key, axis, column) in axes {
        groups.entry(key).or_default()[axis].get_or_insert(column);
    }
    let complete = |(key, [x, y, z]): (K, [Option<usize>; 3])| Some((key, [x?, y?, z?]));
    let mut found: Vec<(K, [usize; 3])> = groups.into_iter().filter_map(complete).collect();
    found.sort_unstable_by_key(|group| group.1);
    found
}

/// Takes those out whose names say that gravity is removed, if there are others.
pub(super) fn take_linear(columns: &[Column], accel: &mut Vec<[usize; 3]>) -> Vec<[usize; 3]> {
    let is_linear = |axes: &mut [usize; 3]| columns[axes[0]].may_be_linear();
    let linear: Vec<[usize; 3]> = accel.extract_if(.., is_linear).collect();
    if accel.is_empty() {
        *accel = linear;
        return Vec::new();
    }
    linear
}

/// Acceleration without gravity, and gravity, whose sum is what an accelerometer measures: phones give
/// them apart.
pub(super) fn parts(format: &Format, accel: &[[usize; 3]]) -> Option<([usize; 3], [usize; 3])> {
    let linear = *accel.first()?;
    let gravity = axes_of_names(format).into_iter().find(|(name, axes)| {
        name.split(' ')
            .any(|word| word == "gravity" || word == "grav")
            && !axes.iter().any(|c| format.columns[*c].is_dropped)
    });
    gravity.map(|(_, gravity)| (linear, gravity))
}

/// Columns of three axes under a common name that tells no sensor, and no quantity that is not one.
pub(super) fn other_triples(format: &Format) -> Vec<[usize; 3]> {
    let is_open = |c: &usize| {
        let column = &format.columns[*c];
        column.role == Role::Other && !column.is_foreign && !column.is_dropped
    };
    let triples = axes_of_names(format).into_iter().map(|(_, axes)| axes);
    triples.filter(|axes| axes.iter().all(is_open)).collect()
}

/// Columns whose names differ in a last word x, y, z alone, and what is common.
fn axes_of_names(format: &Format) -> Vec<(String, [usize; 3])> {
    let names = format.names.iter().enumerate();
    let axes = names.filter_map(|(c, name)| {
        let mut words = words(name);
        let at = words.iter().rposition(|w| axis(w).is_some())?;
        let axis = axis(&words.remove(at))?;
        Some((words.join(" "), axis, c))
    });
    group_axes(axes)
}

/// What the name of each sensor says beyond what all say; its number if that tells nothing.
pub(super) fn sensor_names(columns: &[Column], found: &[[usize; 3]]) -> Vec<String> {
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
pub(super) fn find_sensor(
    wanted: &str,
    names: &[String],
    format: &Format,
    found: &[[usize; 3]],
) -> Result<usize, Problem> {
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
        _ => Err(Problem::SensorUnknown {
            wanted: wanted.to_owned(),
            sensors: names.to_vec(),
        }),
    }
}
