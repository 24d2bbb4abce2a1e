//! Why the joint fit failed, and what to do next.

use gravical_core::matrix3;

use crate::Error;
use crate::estimate::joint::{Elements, JointError};
use crate::estimate::observability::{coverage, in_words, poses_to_add, span};
use crate::numfmt::milli_g;
use crate::segment::Placement;
use crate::segment::face::{AXES, Face};

use super::{Method, Session, distinct};

/// The error for a fit of the poses `of` that failed.
pub(super) fn explain(
    error: JointError,
    of: &[usize],
    method: Method,
    session: &Session<'_>,
) -> Error {
    let placements: Vec<&Placement> = of
        .iter()
        .map(|&k| &session.segmentation.placements[k])
        .collect();
    let directions: Vec<[f64; 3]> = placements
        .iter()
        .filter(|p| p.mean.iter().all(|v| v.is_finite()))
        .map(|p| matrix3::unit(&session.axes.to_case(p.mean)))
        .collect();
    let count = directions.len();
    let error = match error {
        // Poses all alike may not even converge.
        JointError::NotConverged if count > 0 && span(&directions).0 < 3 => {
            JointError::Undetermined {
                direction: [0.0; 3],
                sd: f64::INFINITY,
            }
        }
        other => other,
    };
    let error = match error {
        JointError::NoPoses => Error::input("no-poses", "no pose has a mean reading")
            .with_hint("`gravical inspect` shows what is in the recording"),
        JointError::NotConverged => Error::input(
            "not-converged",
            format!("the fit of {count} poses did not converge"),
        )
        .with_hint("`gravical inspect` lists the poses; leave out one that moved, or name faces with --face-pose"),
        JointError::Undetermined { direction, sd } => {
            let direction = session.axes.to_case(direction);
            let exact = method == Method::Linear12;
            let elements = match method {
                Method::Magnitude6 => Elements::Diagonal,
                _ => Elements::Triangular,
            };
            let (spanned, missing) = span(&directions);
            let poses = match count {
                1 => "1 pose".to_owned(),
                _ => format!("{count} poses in {} directions", distinct(&directions)),
            };
            let mut message = format!("{poses}: {}", coverage(&directions));
            if sd.is_finite() {
                message.push_str(&format!(
                    ": ‖a‖ with {} up would be known to ±{:.0} mg only",
                    nearest_axis(direction),
                    milli_g(sd)
                ));
            }
            let open = poses_to_add(&directions, elements.list(), exact);
            let next = if spanned < 3 {
                let axes = uncovered(&directions, missing);
                let poses: Vec<String> = axes
                    .iter()
                    .map(|axis| format!("{axis} up and {axis} down"))
                    .collect();
                format!(
                    "record {} too, at rest for 3 s or more each, and calibrate again with all poses",
                    poses.join(", ")
                )
            } else if sd.is_infinite() && !open.is_empty() {
                format!(
                    "record {} too, at rest for 3 s or more each, and calibrate again with all poses",
                    open.join("; ")
                )
            } else {
                format!(
                    "add a pose ({}), at rest for 3 s or more, and calibrate again with all of them",
                    in_words(direction)
                )
            };
            let warmed = temperature_span(&placements) > MOST_TEMPERATURE_SPAN_C;
            Error::input("underdetermined", message).with_hint(if warmed {
                format!("{next}; for the drift with temperature alone, --method thermal")
            } else {
                next
            })
        }
    };
    match session.recordings {
        [one] => error.at(one.name.as_ref(), None),
        _ => error,
    }
}

/// Sessions that span more than this are soaks, °C.
const MOST_TEMPERATURE_SPAN_C: f64 = 5.0;

fn temperature_span(placements: &[&Placement]) -> f64 {
    let all = || placements.iter().filter_map(|p| p.temperature_c);
    all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
}

/// The axes that no pose has up or down; otherwise the one nearest to the missing direction.
fn uncovered(directions: &[[f64; 3]], missing: [f64; 3]) -> Vec<char> {
    let covers = |axis: usize| directions.iter().any(|n| Face::nearest(*n).0.axis == axis);
    let none: Vec<char> = (0..3)
        .filter(|&axis| !covers(axis))
        .map(|i| AXES[i])
        .collect();
    match none.is_empty() {
        true => vec![AXES[Face::nearest(missing).0.axis]],
        false => none,
    }
}

fn nearest_axis(n: [f64; 3]) -> String {
    let face = Face::nearest(n).0;
    format!("{}{}", if face.up { "+" } else { "−" }, AXES[face.axis])
}
