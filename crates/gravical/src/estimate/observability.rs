//! Which parameters poses leave open, and which pose would determine them, in words.

use gravical_core::matrix3;
use nalgebra::DMatrix;

use crate::predicted::{read_along, sensitivity, variance};
use crate::segment::face::{AXES, Face};

use super::solve::singular_values;

/// Directions count as spanned when the poses lie this far out of the plane (or
/// line) of the others, rms: sin 10°.
const SPANNED: f64 = 0.17;
/// A direction within this of an axis is called by the axis, degrees.
const MOST_OFF_AXIS_DEG: f64 = 25.0;

/// How many directions of space a set of unit vectors spans, and the direction
/// that they have least of.
#[must_use]
pub(super) fn span(directions: &[[f64; 3]]) -> (usize, [f64; 3]) {
    let mut moment = nalgebra::Matrix3::zeros();
    for n in directions {
        let n = nalgebra::Vector3::from(*n);
        moment += n * n.transpose() / directions.len() as f64;
    }
    let eigen = moment.symmetric_eigen();
    let spanned = eigen
        .eigenvalues
        .iter()
        .filter(|v| v.max(0.0).sqrt() > SPANNED)
        .count();
    let weakest = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    (spanned, [weakest[0], weakest[1], weakest[2]])
}

/// Largest over smallest singular value of a matrix whose columns are brought to length
/// one; infinite when one is empty.
pub(super) fn condition(mut rows: DMatrix<f64>) -> f64 {
    for mut column in rows.column_iter_mut() {
        let length = column.norm();
        if length == 0.0 {
            return f64::INFINITY;
        }
        column.unscale_mut(length);
    }
    singular_values(rows).map_or(f64::INFINITY, |values| values.max() / values.min())
}

/// Names at the most so many poses.
const MOST_NAMED: usize = 3;

/// Error of parameters that nothing determines, over that of a reading; and of an ‖a‖ that
/// counts as open.
const UNKNOWN: f64 = 1000.0;
const OPEN: f64 = 30.0;

/// A pose on an edge or corner has to determine so much more than one on a face.
const HARDER: f64 = 1.3;

fn axes(n: &[i8; 3]) -> usize {
    n.iter().filter(|v| **v != 0).count()
}

/// Faces, then edges, then corners.
fn candidates(faces_only: bool) -> Vec<[i8; 3]> {
    let mut all: Vec<[i8; 3]> = (0..27)
        .map(|i| [i % 3, i / 3 % 3, i / 9].map(|v| [0, 1, -1][v]))
        .collect();
    all.retain(|n| axes(n) > 0 && (!faces_only || axes(n) == 1));
    all.sort_by_key(axes);
    all
}

/// Poses that would determine what `directions` leave open of these elements of M and b, as
/// far as ‖a‖ depends on them, the best first; faces only, if nothing else is fitted.
pub(super) fn poses_to_add(
    directions: &[[f64; 3]],
    elements: &[usize],
    faces_only: bool,
) -> Vec<String> {
    // In shares of the scale and of gravity all derivatives are of the size of one.
    let along = |n: [f64; 3]| sensitivity(&matrix3::identity(), matrix3::unit(&n), 1.0);
    let mut covariance = [[0.0; 12]; 12];
    for &element in elements {
        covariance[element][element] = UNKNOWN.powi(2);
    }
    for n in directions {
        read_along(&mut covariance, &along(*n), 1.0);
    }
    let mut out = Vec::new();
    while out.len() < MOST_NAMED {
        let (mut best, mut largest): (Option<[i8; 3]>, f64) = (None, OPEN);
        for pose in candidates(faces_only) {
            let error = variance(&covariance, &along(pose.map(f64::from))).sqrt();
            let harder = best.is_some_and(|other| axes(&pose) > axes(&other));
            if error > largest * if harder { HARDER } else { 1.0 + 1e-6 } {
                (best, largest) = (Some(pose), error);
            }
        }
        let Some(pose) = best.map(|pose| pose.map(f64::from)) else {
            break;
        };
        read_along(&mut covariance, &along(pose), 1.0);
        out.push(in_words(pose));
    }
    out
}

/// A direction of specific force as an attitude of the case: `x up`, or `x up, tilted 30°,
/// z lowered`.
#[must_use]
pub fn in_words(n: [f64; 3]) -> String {
    let (face, angle_deg) = Face::nearest(n);
    let name = |face: Face| AXES[face.axis];
    let up = format!("{} {}", name(face), if face.up { "up" } else { "down" });
    if angle_deg < 12.0 {
        return up;
    }
    let moved = |face: Face| {
        let how = if face.up { "raised" } else { "lowered" };
        format!("{} {how}", name(face))
    };
    let mut rest = n;
    rest[face.axis] = 0.0;
    let (second, aside_deg) = Face::nearest(rest);
    rest[second.axis] = 0.0;
    let third = match aside_deg < 15.0 {
        true => String::new(),
        false => format!(", {}", moved(Face::nearest(rest).0)),
    };
    format!("{up}, tilted {angle_deg:.0}°, {}{third}", moved(second))
}

/// Which axes the poses cover: `only x and y are covered; z is missing`.
#[must_use]
pub(super) fn coverage(directions: &[[f64; 3]]) -> String {
    let (spanned, missing) = span(directions);
    let near = |n: [f64; 3]| {
        let (face, angle_deg) = Face::nearest(n);
        (angle_deg < MOST_OFF_AXIS_DEG).then_some(face.axis)
    };
    let others = |axis: usize| [(axis + 1) % 3, (axis + 2) % 3];
    let list = |axes: [usize; 2]| {
        let [first, last] = [axes[0].min(axes[1]), axes[0].max(axes[1])];
        format!("{} and {}", AXES[first], AXES[last])
    };
    match spanned {
        3 => "all three axes are covered, but parameters remain open".to_owned(),
        2 => match near(missing) {
            Some(axis) => format!(
                "only {} are covered; {} is missing",
                list(others(axis)),
                AXES[axis]
            ),
            None => "all poses lie in one plane".to_owned(),
        },
        _ => match directions.first().and_then(|n| near(*n)) {
            Some(axis) => format!(
                "only the {} axis is covered; {} are missing",
                AXES[axis],
                list(others(axis))
            ),
            None => "all poses lie along one line".to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_in_words() {
        assert_eq!(in_words([0.0, 0.05, -1.0]), "z down");
        assert_eq!(in_words([0.8, 0.0, -0.6]), "x up, tilted 37°, z lowered");
        assert_eq!(
            in_words([0.6, 0.58, 0.57]),
            "x up, tilted 54°, y raised, z raised"
        );
    }

    #[test]
    fn a_plane_is_two_directions() {
        let plane = [[1.0, 0.0, 0.02], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.03]];
        let (spanned, missing) = span(&plane);
        assert_eq!(spanned, 2);
        assert!(missing[2].abs() > 0.99);
        assert_eq!(coverage(&plane), "only x and y are covered; z is missing");
        assert_eq!(
            coverage(&plane[..2]),
            "only the x axis is covered; y and z are missing"
        );
    }

    #[test]
    fn poses_that_help_are_named() {
        let faces = Face::all().map(Face::direction);
        let triangular = [0, 1, 2, 4, 5, 8, 9, 10, 11];
        let diagonal = [0, 4, 8, 9, 10, 11];
        // Six faces say nothing of the angles between the axes: edges do.
        let named = poses_to_add(&faces, &triangular, false);
        assert_eq!(named.len(), 3, "{named:?}");
        assert!(named.iter().all(|n| n.contains("tilted 45°")), "{named:?}");
        assert!(poses_to_add(&faces, &diagonal, false).is_empty());
        assert_eq!(poses_to_add(&faces[1..], &diagonal, false), ["x up"]);
        let corner = [faces[0], faces[2], faces[4]];
        let named = poses_to_add(&corner, &triangular, true);
        assert!(named.iter().all(|n| n.ends_with(" down")), "{named:?}");
    }
}
