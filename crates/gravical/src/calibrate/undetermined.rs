//! Why there is no fit, and what to record next.

use gravical_core::matrix3;
use gravical_fit::Undetermined;

use crate::Error;
use crate::numfmt::{count, milli_g};
use crate::poses::face::{AXES, Face, in_words};

use super::estimate::Session;

/// The error for poses that leave the parameters open.
pub(super) fn explain(open: Undetermined, session: &Session<'_>) -> Error {
    let placements = &session.segmentation.poses;
    let directions: Vec<[f64; 3]> = placements
        .iter()
        .filter(|p| p.mean.iter().all(|v| v.is_finite()))
        .map(|p| matrix3::unit(&session.axes.to_case(p.mean)))
        .collect();
    let error = if directions.is_empty() {
        Error::input("no-poses", "no pose has a mean reading")
            .with_hint("`gravical inspect` shows what is in the recording")
    } else {
        let poses = count(directions.len(), "pose");
        let mut message = format!("{poses}: {}", coverage(&directions));
        if open.sd_mps2.is_finite() {
            message.push_str(&format!(
                ": ‖a‖ with {} would be known to ±{:.0} mg only",
                in_words(open.direction),
                milli_g(open.sd_mps2)
            ));
        }
        let missing: Vec<String> = uncovered(&directions)
            .iter()
            .map(|axis| format!("{axis} up and {axis} down"))
            .collect();
        let pose = if missing.is_empty() {
            in_words(open.direction)
        } else {
            missing.join(", ")
        };
        Error::input("underdetermined", message).with_hint(format!(
            "record {pose} too, at rest for 3 s or more each, and calibrate again with all poses"
        ))
    };
    match session.recordings {
        [one] => error.at(one.name.as_ref(), None),
        _ => error,
    }
}

/// The axes that no pose has up or down.
fn uncovered(directions: &[[f64; 3]]) -> Vec<char> {
    let covers = |axis: usize| directions.iter().any(|n| Face::nearest(*n).0.axis == axis);
    (0..3)
        .filter(|&axis| !covers(axis))
        .map(|i| AXES[i])
        .collect()
}

/// Which axes the poses cover: `only x and y are covered; z is missing`.
fn coverage(directions: &[[f64; 3]]) -> String {
    let missing = uncovered(directions);
    let covered: Vec<String> = AXES
        .iter()
        .filter(|axis| !missing.contains(axis))
        .map(char::to_string)
        .collect();
    match &missing[..] {
        [a, b] => format!(
            "only the {} axis is covered; {a} and {b} are missing",
            covered.join("")
        ),
        [axis] => format!(
            "only {} are covered; {axis} is missing",
            covered.join(" and ")
        ),
        _ => "all three axes are covered, but parameters remain undetermined".to_owned(),
    }
}
