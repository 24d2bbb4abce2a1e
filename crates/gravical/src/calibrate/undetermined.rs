//! Why there is no fit, and what to record next.

use gravical_core::matrix3;
use gravical_fit::Undetermined;

use crate::Error;
use crate::numfmt::milli_g;
use crate::poses::face::{AXES, Face, in_words};

use super::session::Session;

/// Directions count as spanned when the poses lie this far out of the plane (or line) of the others,
/// rms: sin 10°.
const SPANNED: f64 = 0.17;

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
        let poses = match directions.len() {
            1 => "1 pose".to_owned(),
            count => format!("{count} poses in {} directions", distinct(&directions)),
        };
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

/// Directions that are further than 25° from every one counted before.
fn distinct(directions: &[[f64; 3]]) -> usize {
    let mut kept: Vec<[f64; 3]> = Vec::new();
    for d in directions {
        if kept
            .iter()
            .all(|k| crate::poses::face::angle_deg(*k, *d) > 25.0)
        {
            kept.push(*d);
        }
    }
    kept.len()
}

/// Which axes the poses cover: `only x and y are covered; z is missing`.
fn coverage(directions: &[[f64; 3]]) -> String {
    let mut moment = nalgebra::Matrix3::zeros();
    for n in directions {
        let n = nalgebra::Vector3::from(*n);
        moment += n * n.transpose() / directions.len() as f64;
    }
    let eigen = moment.symmetric_eigen().eigenvalues;
    let spanned = eigen.iter().filter(|v| v.max(0.0).sqrt() > SPANNED).count();
    let missing = uncovered(directions);
    let covered: Vec<String> = AXES
        .iter()
        .filter(|axis| !missing.contains(axis))
        .map(char::to_string)
        .collect();
    match (&missing[..], spanned) {
        ([a, b], _) => format!(
            "only the {} axis is covered; {a} and {b} are missing",
            covered.join("")
        ),
        ([axis], _) => format!(
            "only {} are covered; {axis} is missing",
            covered.join(" and ")
        ),
        (_, 3) => "all three axes are covered, but parameters remain undetermined".to_owned(),
        (_, 2) => "all poses lie in one plane".to_owned(),
        _ => "all poses lie along one line".to_owned(),
    }
}
