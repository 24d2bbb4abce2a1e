//! Which column is what: guesses, each for one shape of file, and an arbiter that holds them against
//! the rows.

mod behaviour;
mod clocks;
mod errors;
mod given;
mod in_rows;
mod named;
mod numbers;

pub(crate) use clocks::is_counter;

use super::format::Format;
use super::names::sensor_of_file;
use super::rows::Rows;
use crate::problem::Problem;
use behaviour::{Axes, answers};
use errors::{columns_unknown, no_accelerometer};
use gravical_judge::finding::Misfit;
use gravical_judge::{Role, shows_gravity};

/// Assigns roles: by the user, the names in the format, the rows of the head.
pub(crate) fn assign(format: &mut Format, sample: &Rows, file_name: &str) -> Result<(), Problem> {
    let is_gyroscope = format.options.is_gyroscope;
    given::assign(format)?;
    let file = sensor_of_file(file_name).filter(|_| !is_gyroscope);
    let file = file.or(is_gyroscope.then_some(Role::Gyro(0)));
    named::add_roles_from_units(format, file, file_name);
    named::add_body_rates(format);
    let has_axis = format.columns.iter().any(|c| c.is_accel() || c.is_gyro());
    let has_names = format.names.iter().filter(|n| n.is_empty()).count() < 3;
    let mut accel = named::triples(&format.columns, Role::Accel);
    let mut gyro = named::triples(&format.columns, Role::Gyro);
    if format.names.is_empty() || !(has_axis || has_names) {
        match numbers::guess(format, sample) {
            Some((first, second)) if is_gyroscope => gyro.push(second.unwrap_or(first)),
            Some((first, second)) if accel.is_empty() => {
                format.is_guessed = true;
                accel.push(first);
                gyro.extend(second);
            }
            None if accel.is_empty() && !is_gyroscope => {
                return Err(columns_unknown(format, sample));
            }
            _ => {}
        }
    }
    format.sensor = in_rows::find_column(format, sample);
    choose_sensors(format, accel, &gyro, sample)?;
    let is_no_axis = |c: &usize| sample.is_text(*c) || format.columns[*c].is_dated;
    if format.channels().iter().any(is_no_axis) {
        return Err(columns_unknown(format, sample));
    }
    // Numbers may tell an axis where a name tells a clock.
    for column in format.channels() {
        let column = &mut format.columns[column];
        if !column.is_accel() && !column.is_gyro() {
            column.role = Role::Other;
        }
    }
    clocks::assign(format, sample);
    Ok(())
}

/// The sensors that are read: of several that the user does not choose from, the first that answers
/// and shows gravity at rest; where no name tells one that does, other columns of three axes.
fn choose_sensors(
    format: &mut Format,
    mut accel: Vec<[usize; 3]>,
    gyro: &[[usize; 3]],
    sample: &Rows,
) -> Result<(), Problem> {
    if format.options.is_gyroscope {
        let names = format.names.clone();
        format.accel = *gyro.first().ok_or(Problem::NoGyroscope { names })?;
        return Ok(());
    }
    // Names tell sensors apart that stand side by side.
    let are_named = !format.names.is_empty() && format.sensor.is_none();
    let values = |axes: &[usize; 3]| -> Axes<'_> { axes.map(|c| sample.columns[c].as_slice()) };
    let is_force = |axes: &[usize; 3]| shows_gravity(values(axes));
    let linear = named::take_linear(&format.columns, &mut accel);
    let shows_none = |accel: &[[usize; 3]]| !accel.iter().any(is_force);
    let is_given = accel.iter().flatten().any(|c| format.columns[*c].is_given);
    if are_named && !is_given && format.options.sensor.is_none() && shows_none(&accel) {
        if let Some((linear, gravity)) = named::parts(format, &accel) {
            format.added = Some(gravity);
            accel = vec![linear];
        } else {
            let mut others = named::other_triples(format).into_iter().chain(linear);
            if let Some(other) = others.find(is_force) {
                accel.insert(0, other);
                format.is_guessed = !accel.is_empty();
                format.misfit = Some(Misfit::NoGravity);
            }
        }
    }
    let named = if are_named { &accel[..] } else { &[] };
    let names = named::sensor_names(&format.columns, named);
    let at = match &format.options.sensor {
        Some(wanted) if are_named => named::find_sensor(wanted, &names, format, &accel)?,
        // `max_by_key` returns the last of equals.
        _ => (0..accel.len())
            .rev()
            .max_by_key(|i| (is_force(&accel[*i]), answers(values(&accel[*i]))))
            .unwrap_or(0),
    };
    let none = || no_accelerometer(!gyro.is_empty(), format, sample);
    let chosen = accel.get(at).copied().ok_or_else(none)?;
    format.accel = chosen;
    if format.options.sensor.is_none() {
        format.sensors = names;
        format.chosen = at;
    }
    // Of several gyroscopes the one whose name shares most with that of the accelerometer.
    let sensor = &format.columns[chosen[0]].sensor;
    let shared = |t: &&[usize; 3]| {
        let other = &format.columns[t[0]].sensor;
        let is_shared = |word: &&str| other.split(' ').any(|w| w == *word);
        (other == sensor, sensor.split(' ').filter(is_shared).count())
    };
    let is_number = |axes: &&[usize; 3]| !axes.iter().any(|c| sample.is_text(*c));
    let gyro = gyro.iter().filter(is_number).rev().max_by_key(shared);
    format.gyro = gyro.copied();
    Ok(())
}
