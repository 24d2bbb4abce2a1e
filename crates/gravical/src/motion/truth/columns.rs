//! Which columns of a table are a reference's, and in which unit they are.

use gravical_recording::{Format, Role, TimeUnit};

use crate::{Error, Result};

/// Which field holds what.
pub(super) struct Fields {
    pub time: Option<usize>,
    /// Seconds of one unit of the stamps.
    pub time_unit_s: Option<f64>,
    pub position: [usize; 3],
    /// Metres per unit of the positions: 1 without a unit in their names.
    pub metres: f64,
}

impl Fields {
    /// By what the names mean.
    ///
    /// # Errors
    ///
    /// `truth-columns-missing` (usage), with the columns that are there.
    pub fn find(format: &Format, same_file: bool) -> Result<Self> {
        let names = &format.names;
        let position = by_meaning(names, same_file).ok_or_else(|| {
            let shown: Vec<&str> = names.iter().take(24).map(String::as_str).collect();
            let there = if names.is_empty() {
                "it has no header".to_owned()
            } else {
                format!("its columns are: {}", shown.join(", "))
            };
            Error::usage(
                "truth-columns-missing",
                "no three columns of the reference are named as a position",
            )
            .with_hint(format!("{there}; name them t_s,px_m,py_m,pz_m"))
        })?;
        let time = format.columns.iter().position(|c| c.role == Role::Time);
        let time_unit_s = time.and_then(|field| match &format.columns[field] {
            column if column.is_dated => Some(1.0),
            column => TimeUnit::parse(&column.unit).map(TimeUnit::seconds),
        });
        let unit = |field: usize| words(&names[field]).iter().rev().find_map(|w| metres(w));
        let units = position.map(unit);
        if units[1] != units[0] || units[2] != units[0] {
            let what = "the positions of the reference are in different units";
            return Err(Error::usage("truth-columns-missing", what)
                .with_hint("name them alike: t_s,px_m,py_m,pz_m"));
        }
        Ok(Fields {
            time,
            time_unit_s,
            position,
            metres: units[0].unwrap_or(1.0),
        })
    }
}

/// Metres per unit that a word names.
fn metres(word: &str) -> Option<f64> {
    match word {
        "m" | "metre" | "metres" | "meter" | "meters" => Some(1.0),
        "mm" | "millimetre" | "millimetres" | "millimeter" | "millimeters" => Some(1e-3),
        _ => None,
    }
}

/// Columns called `px_m`, `pos_x`, `Position X (mm)` …; in a file of its own also
/// plain `x`, `y`, `z`, which in a recording would be acceleration.
fn by_meaning(names: &[String], same_file: bool) -> Option<[usize; 3]> {
    let styles: &[&[&str]] = if same_file {
        &[&["p", "pos", "position"]]
    } else {
        &[&["p", "pos", "position"], &[""]]
    };
    styles.iter().find_map(|prefixes| {
        let find = |axis: &str| {
            names
                .iter()
                .position(|name| is_position(name, prefixes, axis))
        };
        Some([find("x")?, find("y")?, find("z")?])
    })
}

fn is_position(name: &str, prefixes: &[&str], axis: &str) -> bool {
    let mut words = words(name);
    if words.len() > 1 && words.last().is_some_and(|w| metres(w).is_some()) {
        words.pop();
    }
    let plain = words.concat();
    prefixes.iter().any(|p| plain == format!("{p}{axis}"))
}

/// Words of a name in lower case, cut at what is no letter or digit.
fn words(name: &str) -> Vec<String> {
    name.split(|c: char| !c.is_alphanumeric())
        .filter(|w| !w.is_empty())
        .map(str::to_lowercase)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_have_many_names() {
        let named = |names: &[&str], same: bool| {
            let names: Vec<String> = names.iter().map(|n| (*n).to_owned()).collect();
            by_meaning(&names, same)
        };
        assert_eq!(
            named(&["t_s", "px_m", "py_m", "pz_m"], false),
            Some([1, 2, 3])
        );
        assert_eq!(named(&["pos_z", "pos_y", "pos_x"], true), Some([2, 1, 0]));
        assert_eq!(
            named(
                &["Position X (mm)", "Position Y (mm)", "Position Z (mm)"],
                true
            ),
            Some([0, 1, 2])
        );
        assert_eq!(named(&["x", "y", "z"], false), Some([0, 1, 2]));
        assert_eq!(named(&["x", "y", "z"], true), None);
        assert_eq!(named(&["left_pos_x", "pos_y", "pos_z"], true), None);
    }
}
