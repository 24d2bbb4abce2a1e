//! Which poses would determine what the present ones leave open.

use nalgebra::{DMatrix, DVector};

use crate::segment::face::AXES;

/// Names at the most so many poses.
const MOST_NAMED: usize = 3;

/// A pose that is harder to hold has to help so much more.
const HARDER: f64 = 1.3;

fn axes(n: &[i8; 3]) -> usize {
    n.iter().filter(|v| **v != 0).count()
}

/// Faces, then edges, then corners.
fn candidates(faces_only: bool) -> Vec<[i8; 3]> {
    let mut all: Vec<[i8; 3]> = (0..27)
        .map(|i| [i / 9, i / 3 % 3, i % 3].map(|v| [0, 1, -1][v]))
        .collect();
    all.retain(|n| axes(n) > 0 && (!faces_only || axes(n) == 1));
    all.sort_by_key(axes);
    all
}

fn name(n: [i8; 3]) -> String {
    let axes: Vec<String> = (0..3)
        .filter(|&i| n[i] != 0)
        .map(|i| format!("{}{}", if n[i] > 0 { '+' } else { '-' }, AXES[i]))
        .collect();
    match axes.len() {
        1 => format!("{} up", axes[0]),
        2 => format!("halfway between {} and {} up", axes[0], axes[1]),
        _ => format!("between {}, {} and {} up", axes[0], axes[1], axes[2]),
    }
}

/// Poses that would determine the directions `open` of the parameters, the best
/// first. `row` is the derivative of a reading (in any direction n) by the
/// parameters, in the same units as `open`.
pub(super) fn wanted(
    open: &[Vec<f64>],
    faces_only: bool,
    row: impl Fn([f64; 3]) -> DVector<f64>,
) -> Vec<String> {
    let p = open.first().map_or(0, Vec::len);
    let mut basis = DMatrix::from_fn(p, open.len(), |i, j| open[j][i]);
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
        out.push(name(poses[best.0]));
        // What that pose determines is open no more.
        let along = seen / length;
        let gone = &basis * &along;
        basis -= gone * along.transpose();
    }
    out
}

/// How many directions of space the unit vectors span: eigenvalues of their
/// mean second moment above 0.01 (6° off a plane or line).
pub(super) fn spanned(directions: &[[f64; 3]]) -> usize {
    let mut moment = nalgebra::Matrix3::zeros();
    for n in directions {
        let n = nalgebra::Vector3::from(*n);
        moment += n * n.transpose();
    }
    moment /= directions.len().max(1) as f64;
    moment
        .symmetric_eigenvalues()
        .iter()
        .filter(|v| **v > 0.01)
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pose_that_helps_is_named() {
        // A plane through +x, +y and +z: any opposite face settles it.
        let open = vec![vec![0.5, 0.5, 0.5, -0.5]];
        let row = |n: [f64; 3]| DVector::from_vec(vec![n[0], n[1], n[2], 1.0]);
        let named = wanted(&open, true, row);
        assert!(named.len() == 1 && named[0].starts_with('-'), "{named:?}");
        // Two open directions: two poses that tell them apart.
        let open = vec![vec![1.0, 0.0, 0.0, 0.0], vec![0.0, 1.0, 0.0, 0.0]];
        let named = wanted(&open, true, row);
        assert_eq!(named, ["+x up", "+y up"]);
    }

    #[test]
    fn poses_in_a_plane_span_two_directions() {
        let n = |a: f64| [a.cos(), a.sin(), 0.03];
        let directions: Vec<_> = (0..7).map(|k| n(f64::from(k))).collect();
        assert_eq!(spanned(&directions), 2);
        assert_eq!(spanned(&[[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]), 1);
        assert_eq!(spanned(&[]), 0);
    }
}
