//! Which poses would determine what the present ones leave open.

use nalgebra::{DMatrix, DVector};

use super::undetermined::in_words;

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
        .map(|i| [i % 3, i / 3 % 3, i / 9].map(|v| [0, 1, -1][v]))
        .collect();
    all.retain(|n| axes(n) > 0 && (!faces_only || axes(n) == 1));
    all.sort_by_key(axes);
    all
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
        out.push(in_words(poses[best.0].map(f64::from)));
        // What that pose determines is open no more.
        let along = seen / length;
        let gone = &basis * &along;
        basis -= gone * along.transpose();
    }
    out
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
        assert!(named.len() == 1 && named[0].ends_with(" down"), "{named:?}");
        // Two open directions: two poses that tell them apart.
        let open = vec![vec![1.0, 0.0, 0.0, 0.0], vec![0.0, 1.0, 0.0, 0.0]];
        let named = wanted(&open, true, row);
        assert_eq!(named, ["x up", "y up"]);
    }
}
