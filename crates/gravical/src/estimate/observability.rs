//! Which parameters poses leave open, and which pose would determine them, in words.

use nalgebra::{DMatrix, DVector};

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

/// What rows leave open of the parameters that they are derivatives by.
pub(super) struct Undetermined {
    /// Unit vectors of the parameters that nothing determines.
    pub open: Vec<DVector<f64>>,
    /// Largest over smallest singular value, columns of length one.
    pub condition: f64,
}

/// What is open where an error of a row may be enlarged so many times; none where a row is
/// not finite. Columns are to be of the size of one.
pub(super) fn undetermined(rows: &[DVector<f64>], most_enlarged: f64) -> Option<Undetermined> {
    let n = rows.len();
    let p = rows.first().map_or(0, DVector::len);
    // As many rows as columns at least, so that there are as many singular values.
    let mut stacked = DMatrix::zeros(n.max(p), p);
    for (k, row) in rows.iter().enumerate() {
        stacked.set_row(k, &row.transpose());
    }
    // The decomposition may never end on what is not finite.
    if stacked.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let svd = stacked.clone().svd(false, true);
    let limit = (n as f64).sqrt() / most_enlarged;
    let v_t = svd.v_t.as_ref()?;
    let open = (0..p)
        .filter(|&i| svd.singular_values[i] < limit)
        .map(|i| v_t.row(i).transpose())
        .collect();
    Some(Undetermined {
        open,
        condition: condition(stacked),
    })
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

/// Poses that would determine the directions `open` of the parameters, the best
/// first. `row` is the derivative of a reading (in any direction n) by the
/// parameters, in the same units as `open`.
pub(super) fn settling(
    open: &[DVector<f64>],
    faces_only: bool,
    row: impl Fn([f64; 3]) -> DVector<f64>,
) -> Vec<String> {
    let mut basis = DMatrix::from_columns(open);
    let poses = candidates(faces_only);
    let rows: Vec<DVector<f64>> = poses
        .iter()
        .map(|n| {
            let n = n.map(f64::from);
            let length = n.iter().map(|v| v * v).sum::<f64>().sqrt();
            row(n.map(|v| v / length))
        })
        .collect();
    let mut out = Vec::new();
    for _ in 0..open.len().min(MOST_NAMED) {
        let mut best = (0, 1e-9);
        for (k, row) in rows.iter().enumerate() {
            let seen = basis.tr_mul(row).norm();
            let harder = axes(&poses[k]) > axes(&poses[best.0]);
            if seen > best.1 * if harder { HARDER } else { 1.0 + 1e-6 } {
                best = (k, seen);
            }
        }
        let seen = basis.tr_mul(&rows[best.0]);
        let length = seen.norm();
        if length < 1e-9 {
            break;
        }
        out.push(in_words(poses[best.0].map(f64::from)));
        // What that pose determines is open no more.
        let along = seen / length;
        let gone = &basis * &along;
        basis -= gone * along.transpose();
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
    fn the_pose_that_helps_is_named() {
        // A plane through +x, +y and +z: any opposite face settles it.
        let open = [DVector::from_vec(vec![0.5, 0.5, 0.5, -0.5])];
        let row = |n: [f64; 3]| DVector::from_vec(vec![n[0], n[1], n[2], 1.0]);
        let named = settling(&open, true, row);
        assert!(named.len() == 1 && named[0].ends_with(" down"), "{named:?}");
        // Two open directions: two poses that distinguish them.
        let open = [0, 1].map(|i| DVector::from_fn(4, |k, _| f64::from(k == i)));
        let named = settling(&open, true, row);
        assert_eq!(named, ["x up", "y up"]);
    }
}
