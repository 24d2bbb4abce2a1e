//! Why there is no fit, and what to record next.

use gravical_core::matrix3;
use gravical_fit::Undetermined;

use crate::Error;
use crate::numfmt::{count, milli_g};
use crate::poses::face::{AXES, Face, in_words};

use super::estimate::Session;

/// The error for poses that leave the parameters open.
pub(super) fn explain(open: Undetermined, session: &Session<'_>) -> Error {
    let means = session.segmentation.poses.iter().map(|p| p.mean);
    let directions: Vec<[f64; 3]> = means
        .filter(|mean| mean.iter().all(|v| v.is_finite()))
        .map(|mean| matrix3::unit(&session.axes.to_case(mean)))
        .collect();
    let error = if directions.is_empty() {
        Error::input("no-poses", "no pose has a mean reading")
            .with_hint("`gravical inspect` shows what is in the recording")
    } else {
        let is_up = |axis: usize| directions.iter().any(|n| Face::nearest(*n).0.axis == axis);
        let (covered, missing): (Vec<usize>, Vec<usize>) = (0..3).partition(|axis| is_up(*axis));
        let [covered, missing] = [covered, missing].map(|axes| {
            let names = axes.into_iter().map(|i| AXES[i].to_string());
            names.collect::<Vec<_>>()
        });
        let coverage = match &missing[..] {
            [a, b] => format!(
                "only the {} axis is covered; {a} and {b} are missing",
                covered.join("")
            ),
            [axis] => format!(
                "only {} are covered; {axis} is missing",
                covered.join(" and ")
            ),
            _ => "all three axes are covered, but parameters remain undetermined".to_owned(),
        };
        let mut message = format!("{}: {coverage}", count(directions.len(), "pose"));
        let direction = in_words(open.direction);
        if open.sd_mps2.is_finite() {
            let sd = milli_g(open.sd_mps2);
            message += &format!(": ‖a‖ with {direction} would be known to ±{sd:.0} mg only");
        }
        let both = missing.iter().map(|a| format!("{a} up and {a} down"));
        let pose = match missing.is_empty() {
            true => direction,
            false => both.collect::<Vec<_>>().join(", "),
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
