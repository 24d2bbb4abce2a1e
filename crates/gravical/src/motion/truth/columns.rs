//! Which columns of a table are a reference's, and in which unit they are.

use crate::recording::TimeUnit;
use crate::recording::dialect::Dialect;
use crate::recording::names::{Quantity, understand};
use crate::{Error, Result};

use super::TruthColumns;

/// Unit of a reference's positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LengthUnit {
    /// Metres.
    Metre,
    /// Millimetres.
    Millimetre,
}

impl LengthUnit {
    /// Metres per unit.
    #[must_use]
    pub fn metres(self) -> f64 {
        match self {
            LengthUnit::Metre => 1.0,
            LengthUnit::Millimetre => 1e-3,
        }
    }

    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            LengthUnit::Metre => "m",
            LengthUnit::Millimetre => "mm",
        }
    }

    fn parse(word: &str) -> Option<Self> {
        match word {
            "m" | "metre" | "metres" | "meter" | "meters" => Some(LengthUnit::Metre),
            "mm" | "millimetre" | "millimetres" | "millimeter" | "millimeters" => {
                Some(LengthUnit::Millimetre)
            }
            _ => None,
        }
    }
}

/// Which field holds what.
pub(super) struct Fields {
    pub time: Option<usize>,
    pub time_unit: Option<TimeUnit>,
    pub position: [usize; 3],
    pub unit: Option<LengthUnit>,
}

impl Fields {
    /// By the names that are given, else by what the names mean.
    ///
    /// # Errors
    ///
    /// `truth-columns-missing` (usage), with the columns that are there.
    pub fn find(
        dialect: &Dialect,
        columns: Option<&TruthColumns>,
        same_file: bool,
    ) -> Result<Self> {
        let names: &[String] = dialect.header.as_ref().map_or(&[], |h| &h.names);
        let missing = |what: String| {
            let shown: Vec<&str> = names.iter().take(24).map(String::as_str).collect();
            Error::usage("truth-columns-missing", what).with_hint(if names.is_empty() {
                "give the reference a header: t_s,px_m,py_m,pz_m".to_owned()
            } else {
                format!(
                    "its columns are: {}; name them with --truth-columns t=…,px=…,py=…,pz=…",
                    shown.join(", ")
                )
            })
        };
        let by_name = |wanted: &String| {
            names
                .iter()
                .position(|n| n == wanted)
                .or_else(|| names.iter().position(|n| n.eq_ignore_ascii_case(wanted)))
                .ok_or_else(|| missing(format!("there is no column \"{wanted}\"")))
        };
        let is_time = |n: &String| understand(n).is_some_and(|u| u.quantity == Quantity::Time);
        let named_time = columns.and_then(|c| c.time.as_ref());
        let time = match named_time {
            Some(name) => Some(by_name(name)?),
            None => names.iter().position(is_time),
        };
        let position = match columns {
            Some(c) => {
                let [x, y, z] = &c.position;
                [by_name(x)?, by_name(y)?, by_name(z)?]
            }
            None => by_meaning(names, same_file).ok_or_else(|| {
                missing("no three columns of it are named as a position".to_owned())
            })?,
        };
        let name_of = |field: usize| names.get(field).map_or("", String::as_str);
        let time_unit = time
            .and_then(|field| understand(name_of(field)))
            .and_then(|name| TimeUnit::parse(name.unit.as_deref()?));
        let [x, ..] = position;
        Ok(Fields {
            time,
            time_unit,
            position,
            unit: words(name_of(x))
                .iter()
                .rev()
                .find_map(|w| LengthUnit::parse(w)),
        })
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
    if words.len() > 1 && words.last().is_some_and(|w| LengthUnit::parse(w).is_some()) {
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
