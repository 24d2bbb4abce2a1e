//! Which directions the static intervals test, and which they do not.

use gravical_core::matrix3::norm;

use super::types::Coverage;
use crate::calibrate::distinct;
use crate::segment::face::{AXES, Face, angle_deg};

/// Poses nearer to each other than this are one direction, degrees.
const SAME_DIRECTION_DEG: f64 = 25.0;

/// An axis is tested by a still within 60° of it.
pub(super) const TESTED_COSINE: f64 = 0.5;

/// Coverage by unit vectors in axes of the case.
pub(super) fn coverage(directions: &[[f64; 3]]) -> Coverage {
    let apart = distinct(directions);
    let ways: Vec<(bool, bool)> = (0..3)
        .map(|k| {
            (
                directions.iter().any(|n| n[k] >= TESTED_COSINE),
                directions.iter().any(|n| n[k] <= -TESTED_COSINE),
            )
        })
        .collect();
    let named = |wanted: fn((bool, bool)) -> bool| -> Vec<String> {
        (0..3)
            .filter(|k| wanted(ways[*k]))
            .map(|k| AXES[k].to_string())
            .collect()
    };
    let untested = named(|(up, down)| !up && !down);
    let one_way = named(|(up, down)| up != down);
    Coverage {
        text: text(directions, apart, &untested, &one_way),
        directions: apart as u32,
        untested_axes: untested,
        one_way_axes: one_way,
    }
}

fn text(directions: &[[f64; 3]], apart: usize, untested: &[String], one_way: &[String]) -> String {
    let count = directions.len();
    let nothing = |axes: &[String]| match axes {
        [one] => format!("the {one} axis"),
        several => format!("the {} axes", several.join(" and ")),
    };
    if apart <= 1 {
        let sum: [f64; 3] = std::array::from_fn(|i| directions.iter().map(|n| n[i]).sum());
        let length = norm(&sum).max(f64::MIN_POSITIVE);
        let middle = sum.map(|v| v / length);
        let (face, off) = Face::nearest(middle);
        let furthest = directions
            .iter()
            .map(|n| angle_deg(face.direction(), *n))
            .fold(0.0, f64::max);
        let place = if off > SAME_DIRECTION_DEG {
            format!("in one oblique direction ({off:.0}° off {})", face.name())
        } else {
            // Up to a whole degree, so that it is true.
            format!("within {:.0}° of {}", furthest.ceil().max(1.0), face.name())
        };
        let what = if untested.is_empty() {
            "tests one combination of the parameters out of nine".to_owned()
        } else {
            format!("does not test {}", nothing(untested))
        };
        return if count > 1 {
            format!("{count} static intervals, all {place}: {what}")
        } else {
            format!("1 static interval, {place}: {what}")
        };
    }
    let mut parts = Vec::new();
    if !untested.is_empty() {
        parts.push(format!("does not test {}", nothing(untested)));
    }
    if !one_way.is_empty() {
        parts.push(format!(
            "{} pointed in one direction only, where bias and scale are not distinguished",
            match one_way {
                [one] => one.clone(),
                [first, last] => format!("{first} and {last}"),
                _ => "x, y and z".to_owned(),
            }
        ));
    }
    if parts.is_empty() {
        parts.push("every axis was tested in both directions".to_owned());
    }
    let intervals = match count {
        1 => "1 static interval".to_owned(),
        n => format!("{n} static intervals"),
    };
    format!("{intervals} in {apart} directions: {}", parts.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_tested_is_said() {
        let up = coverage(&[[0.0, 0.0, 1.0], [0.1, 0.0, 0.995], [0.0, 0.14, 0.99]]);
        assert_eq!(
            up.text,
            "3 static intervals, all within 9° of +z: does not test the x and y axes"
        );
        let one = coverage(&[[-1.0, 0.0, 0.0]]);
        assert_eq!(
            one.text,
            "1 static interval, within 1° of -x: does not test the y and z axes"
        );
        let third = 1.0 / 3_f64.sqrt();
        let oblique = coverage(&[[third; 3]]);
        assert!(
            oblique.text.contains("one oblique direction (55° off"),
            "{}",
            oblique.text
        );
        assert!(oblique.untested_axes.is_empty());
    }

    #[test]
    fn axes_that_pointed_one_way() {
        let two = coverage(&[[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]);
        assert_eq!(
            two.text,
            "3 static intervals in 3 directions: does not test the y axis; x pointed in one direction only, where bias and scale are not distinguished"
        );
        let all: Vec<[f64; 3]> = Face::all().iter().map(|f| f.direction()).collect();
        assert!(
            coverage(&all)
                .text
                .ends_with("every axis was tested in both directions")
        );
    }
}
