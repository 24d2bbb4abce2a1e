//! Which poses are faces.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use gravical_core::matrix3;

use crate::segment::face::{Face, angle_deg};
use crate::stats::median;

use super::fit::{Fit, Pose};
use super::{ASSUMED_TILT, DEG, JointPose, model};

/// What is known of a pose's direction, in axes of the board.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Role {
    /// Found: it may be the face it is nearest to.
    Open,
    /// A name or label says so.
    Named(Face),
    /// The user says so.
    Face(Face),
    /// The user says that it is none.
    Free,
}

/// Faces have tilts up to so many σ: one in a thousand has more, with two
/// components.
const FACE_LIMIT: f64 = 3.72;
/// A named face that lies no further off than this stays one, degrees.
const NAMED_LIMIT_DEG: f64 = 10.0;
/// Beyond this nothing is a face, degrees.
const MOST_DEG: f64 = 25.0;
/// Tilts above this are no placements on faces but poses in the hand, rad.
const MOST_PLAUSIBLE: f64 = 3.5 / DEG;
/// Median of a tilt of two components, in units of their sd.
const RAYLEIGH_MEDIAN: f64 = 1.1774;
/// Repeats that agree so well by chance are rarer than this.
const SAME_WAY_CHANCE: f64 = 1e-3;

/// Angle of a reading to the face, degrees, under M and b.
fn off(mean: [f64; 3], inverse: &[[f64; 3]; 3], b: &[f64; 3], face: Face) -> f64 {
    let force = matrix3::mul_vec(inverse, &matrix3::sub(&mean, b));
    angle_deg(force, face.direction())
}

/// First roles: what is said, and of the rest the nearest to every face, if
/// those look like placements at all.
pub(super) fn first(poses: &[JointPose], work: &mut [Pose], (m, b): ([[f64; 3]; 3], [f64; 3])) {
    let Some(inverse) = matrix3::inverse(&m) else {
        return;
    };
    let mut nearest: [Option<(usize, f64)>; 6] = [None; 6];
    for (k, pose) in poses.iter().enumerate() {
        match pose.role {
            Role::Face(face) | Role::Named(face) => work[k].face = Some(face),
            Role::Free => {}
            Role::Open => {
                let force = matrix3::mul_vec(&inverse, &matrix3::sub(&pose.mean, &b));
                let (face, angle) = Face::nearest(force);
                let best = &mut nearest[face.index()];
                if angle <= MOST_DEG && best.is_none_or(|(_, a)| angle < a) {
                    *best = Some((k, angle));
                }
            }
        }
    }
    let said = |face: Face| {
        poses
            .iter()
            .any(|p| p.role == Role::Named(face) || p.role == Role::Face(face))
    };
    for face in Face::all() {
        if let Some((k, _)) = nearest[face.index()]
            && !said(face)
        {
            work[k].face = Some(face);
        }
    }
}

/// Sorts the poses again by a fit.
pub(super) fn sort(poses: &[JointPose], work: &mut [Pose], found: &Fit, tilt: f64) {
    let Some(inverse) = matrix3::inverse(&found.state.m) else {
        return;
    };
    let b = found.state.b;
    let sigma = DEG * believable(work, &inverse, &b, tilt);
    for (pose, work) in poses.iter().zip(work) {
        work.face = match pose.role {
            Role::Face(face) => Some(face),
            Role::Free => None,
            Role::Named(face) => {
                let limit = (FACE_LIMIT * sigma).clamp(NAMED_LIMIT_DEG, MOST_DEG);
                (off(pose.mean, &inverse, &b, face) <= limit).then_some(face)
            }
            Role::Open => {
                let force = matrix3::mul_vec(&inverse, &matrix3::sub(&pose.mean, &b));
                let (face, angle) = Face::nearest(force);
                (angle <= (FACE_LIMIT * sigma).min(MOST_DEG)).then_some(face)
            }
        };
    }
}

/// The tilt that roles are judged by. An estimate that is too large for
/// placements comes from poses that are none.
fn believable(work: &[Pose], inverse: &[[f64; 3]; 3], b: &[f64; 3], tilt: f64) -> f64 {
    let mut angles: Vec<f64> = work
        .iter()
        .filter(|p| !p.left_out)
        .filter_map(|p| Some(off(p.mean, inverse, b, p.face?)))
        .collect();
    let usual = median(&mut angles).map_or(0.0, |a| a / RAYLEIGH_MEDIAN / DEG);
    if usual > MOST_PLAUSIBLE {
        ASSUMED_TILT
    } else {
        tilt.min(MOST_PLAUSIBLE)
    }
}

/// True when placements of the same face agree far better than tilts of their
/// own would: they lay the same way, on the same table.
pub(super) fn lie_the_same_way(work: &[Pose], found: &Fit, tilt: f64) -> bool {
    let Some(inverse) = matrix3::inverse(&found.state.m) else {
        return false;
    };
    let (mut squares, mut freedom) = (0.0, 0.0);
    for face in Face::all() {
        let directions: Vec<[f64; 3]> = work
            .iter()
            .filter(|p| p.face == Some(face) && !p.left_out)
            .map(|p| {
                model::unit(matrix3::mul_vec(
                    &inverse,
                    &matrix3::sub(&p.mean, &found.state.b),
                ))
            })
            .collect();
        let n = directions.len() as f64;
        if n < 2.0 {
            continue;
        }
        let mean: [f64; 3] =
            std::array::from_fn(|i| directions.iter().map(|d| d[i]).sum::<f64>() / n);
        squares += directions
            .iter()
            .map(|d| model::norm(matrix3::sub(d, &mean)).powi(2))
            .sum::<f64>();
        freedom += 2.0 * (n - 1.0);
    }
    if freedom < 4.0 {
        return false;
    }
    ChiSquared::new(freedom).is_ok_and(|chi2| chi2.cdf(squares / (tilt * tilt)) < SAME_WAY_CHANCE)
}

/// Puts repeats of a face into one group.
pub(super) fn share_tilts(work: &mut [Pose]) {
    for k in 0..work.len() {
        let Some(face) = work[k].face else { continue };
        if let Some(first) = (0..k).find(|&j| work[j].face == Some(face)) {
            work[k].group = work[first].group;
        }
    }
}
