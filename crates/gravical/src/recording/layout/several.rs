//! Choice among several sensors in one file.

use super::Named;
use crate::recording::names::{Quantity, split_words};
use crate::{Error, Result};

/// Largest number of sensors that a column may distinguish.
const MOST_INSTANCES: usize = 16;

/// Fields of x, y and z of every sensor of a kind: columns with equal name and unit and all three
/// axes. Those without gravity are last.
pub(super) fn triples(columns: &[Named], of: fn(usize) -> Quantity) -> Vec<[usize; 3]> {
    let mut found: Vec<([usize; 3], bool)> = Vec::new();
    for (_, first) in columns.iter().filter(|(_, c)| c.quantity == of(0)) {
        let axis = |i: usize| {
            columns
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
            && !found.iter().any(|(t, _)| *t == [x, y, z])
        {
            found.push(([x, y, z], first.without_gravity));
        }
    }
    found.sort_by_key(|(_, without_gravity)| *without_gravity);
    found.into_iter().map(|(t, _)| t).collect()
}

fn column(columns: &[Named], field: usize) -> Option<&Named> {
    columns.iter().find(|(f, _)| *f == field)
}

/// Words of a sensor's name.
pub(super) fn words_of(columns: &[Named], triple: [usize; 3]) -> Vec<String> {
    column(columns, triple[0])
        .map(|(_, c)| c.sensor.split(' ').map(str::to_owned).collect())
        .unwrap_or_default()
}

/// Chooses the accelerometer that `wanted` names, by words of its name or by its number from 1;
/// without `wanted` the first.
///
/// # Errors
///
/// `sensor-unknown` (usage), with the sensors in the file.
pub(super) fn choose(
    columns: &[Named],
    found: &[[usize; 3]],
    wanted: Option<&str>,
) -> Result<Option<[usize; 3]>> {
    let free = |t: &[usize; 3]| column(columns, t[0]).is_some_and(|(_, c)| c.without_gravity);
    // Acceleration without gravity in addition to raw acceleration is not another sensor.
    let with_gravity: Vec<[usize; 3]> = found.iter().copied().filter(|t| !free(t)).collect();
    let found = if with_gravity.is_empty() {
        found
    } else {
        &with_gravity
    };
    let names: Vec<Vec<String>> = found.iter().map(|t| words_of(columns, *t)).collect();
    let labels: Vec<String> = (0..found.len())
        .map(|i| {
            let shared = |w: &String| (0..found.len()).all(|o| names[o].contains(w));
            let own: Vec<&str> = names[i]
                .iter()
                .filter(|w| !shared(w))
                .map(String::as_str)
                .collect();
            own.join("-")
        })
        .collect();
    let label = |i: usize| -> String {
        let twice = labels.iter().filter(|l| **l == labels[i]).count() > 1;
        if labels[i].is_empty() || twice {
            (i + 1).to_string()
        } else {
            labels[i].clone()
        }
    };
    let all: Vec<String> = (0..found.len()).map(label).collect();
    if let Some(wanted) = wanted {
        let words = split_words(wanted);
        let mut fit: Vec<usize> = (0..found.len()).filter(|i| all[*i] == wanted).collect();
        if fit.is_empty() && !words.is_empty() {
            fit = (0..found.len())
                .filter(|i| words.iter().all(|w| names[*i].contains(w)))
                .collect();
        }
        if fit.is_empty() {
            fit.extend(
                wanted
                    .parse::<usize>()
                    .ok()
                    .and_then(|n| n.checked_sub(1))
                    .filter(|n| *n < found.len()),
            );
        }
        return match fit[..] {
            [one] => Ok(Some(found[one])),
            _ => Err(unknown(wanted, &all)),
        };
    }
    Ok(found.first().copied())
}

fn unknown(wanted: &str, there: &[String]) -> Error {
    let hint = match there {
        [] | [_] => "this file has one sensor: leave the option out".to_owned(),
        several => format!("give one of: {}", several.join(", ")),
    };
    Error::usage("sensor-unknown", format!("there is no sensor {wanted}"))
        .of_option("sensor")
        .with_hint(hint)
}

/// If a column distinguishes the rows of several sensors: that column and the value to read. The
/// value is `wanted`, otherwise the lowest.
///
/// # Errors
///
/// `sensor-unknown` (usage), with the sensors in the file.
pub(super) fn instance(
    sample: &[Vec<f64>],
    columns: &[Named],
    wanted: Option<&str>,
) -> Result<Option<(usize, f64)>> {
    let several = |field: usize| -> Option<Vec<f64>> {
        let mut values: Vec<f64> = sample
            .iter()
            .filter_map(|row| row.get(field).copied())
            .filter(|value| value.is_finite())
            .collect();
        let changes = values.windows(2).filter(|w| w[0] != w[1]).count();
        let rows = values.len();
        if !values.iter().all(|v| v.fract() == 0.0) {
            return None;
        }
        values.sort_unstable_by(f64::total_cmp);
        values.dedup();
        // The sensors alternate.
        let few = (2..=MOST_INSTANCES).contains(&values.len());
        (few && changes * 4 > rows).then_some(values)
    };
    let found = columns
        .iter()
        .filter(|(_, c)| c.quantity == Quantity::Instance)
        .find_map(|(field, _)| Some((*field, several(*field)?)));
    let Some((field, values)) = found else {
        return Ok(None);
    };
    let list: Vec<String> = values.iter().map(f64::to_string).collect();
    if let Some(wanted) = wanted {
        let value = wanted.parse::<f64>().ok().filter(|v| values.contains(v));
        return match value {
            Some(value) => Ok(Some((field, value))),
            None => Err(unknown(wanted, &list)),
        };
    }
    Ok(Some((field, values[0])))
}
