//! Which poses are faces.

use gravical_core::matrix3;

use crate::segment::face::{Face, angle_deg};

use super::fit::{Fit, Pose};
use super::{ASSUMED_TILT, DEG, JointPose};

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

/// Beyond this nothing is a face, rad.
const MOST: f64 = 25.0 / DEG;
/// Tilts of placements on faces, rad, between which their spread is looked for.
/// More is a pose in the hand; less is finer than any fixture, and a face that
/// lies as well as this is one whatever the others do.
const SPREAD: [f64; 2] = [0.1 / DEG, 3.5 / DEG];
/// Steps between these.
const STEPS: i32 = 60;
/// Poses that lie anywhere, by chance near axes, raise the logarithm of the
/// likelihood by less than this.
const NO_FACES: f64 = 5.0;
/// A name says which of the six faces it is, and is right 19 times in 20.
const NAME: f64 = 6.0 * 19.0;

/// Angle of a reading to the face, rad, under M and b.
fn off(mean: [f64; 3], inverse: &[[f64; 3]; 3], b: &[f64; 3], face: Face) -> f64 {
    let force = matrix3::mul_vec(inverse, &matrix3::sub(&mean, b));
    angle_deg(force, face.direction()) / DEG
}

/// First roles: of the poses that may be a face the nearest to it, however far
/// off the names are; the others follow when the fit knows how faces lie.
pub(super) fn first(poses: &[JointPose], work: &mut [Pose], (m, b): ([[f64; 3]; 3], [f64; 3])) {
    let Some(inverse) = matrix3::inverse(&m) else {
        return;
    };
    let mut nearest: [Option<(usize, f64)>; 6] = [None; 6];
    for (k, pose) in poses.iter().enumerate() {
        if let Role::Face(face) = pose.role {
            work[k].face = Some(face);
        }
        let Some((face, angle, _)) = candidate(pose, &inverse, &b) else {
            continue;
        };
        let best = &mut nearest[face.index()];
        if (angle <= MOST || pose.role == Role::Named(face)) && best.is_none_or(|(_, a)| angle < a)
        {
            *best = Some((k, angle));
        }
    }
    for face in Face::all() {
        if let Some((k, _)) = nearest[face.index()]
            && !poses.iter().any(|p| p.role == Role::Face(face))
        {
            work[k].face = Some(face);
        }
    }
}

/// The face that a pose may be, its angle to it in rad, and how many times more
/// likely that is than for a pose of which nothing is said.
fn candidate(pose: &JointPose, inverse: &[[f64; 3]; 3], b: &[f64; 3]) -> Option<(Face, f64, f64)> {
    match pose.role {
        Role::Named(face) => Some((face, off(pose.mean, inverse, b, face), NAME)),
        Role::Open => {
            let force = matrix3::mul_vec(inverse, &matrix3::sub(&pose.mean, b));
            let (face, angle_deg) = Face::nearest(force);
            Some((face, angle_deg / DEG, 1.0))
        }
        Role::Face(_) | Role::Free => None,
    }
}

/// How many times more likely a pose `angle` from an axis lies on one of the six
/// faces with tilts of `spread` than it points anywhere: the normal density of
/// two components over a sixth of the sphere each, e^(−a²/2σ²)/(2πσ²)/6 over
/// 1/4π.
fn odds(angle: f64, spread: f64) -> f64 {
    let variance = spread * spread;
    (-angle * angle / (2.0 * variance)).exp() / (3.0 * variance)
}

/// Sorts the poses again by a fit: each is a face where that is more likely than
/// a pose that points anywhere. Faces have the spread that makes all angles
/// together likeliest, as a mixture: an estimate from what was taken for faces
/// would grow with every deliberate lean among them. `least` is a tilt that was
/// given.
pub(super) fn sort(poses: &[JointPose], work: &mut [Pose], found: &Fit, least: f64) {
    let Some(inverse) = matrix3::inverse(&found.state.m) else {
        return;
    };
    let candidates: Vec<Option<(Face, f64, f64)>> = poses
        .iter()
        .map(|pose| candidate(pose, &inverse, &found.state.b))
        .collect();
    let there: Vec<(f64, f64)> = candidates
        .iter()
        .zip(work.iter())
        .filter(|(_, pose)| !pose.left_out)
        .filter_map(|(c, _)| c.map(|(_, angle, weight)| (angle, weight)))
        .collect();
    let spread = spread(&there).max(least);
    for ((pose, candidate), work) in poses.iter().zip(candidates).zip(work) {
        work.face = match (pose.role, candidate) {
            (Role::Face(face), _) => Some(face),
            (_, Some((face, angle, weight))) => {
                (angle <= MOST && weight * odds(angle, spread) > 1.0).then_some(face)
            }
            (_, None) => None,
        };
    }
}

/// The likeliest tilt of the faces among poses with these angles and weights;
/// the usual one where nothing looks like a face.
fn spread(there: &[(f64, f64)]) -> f64 {
    let [low, high] = SPREAD;
    (0..=STEPS)
        .map(|i| low * (high / low).powf(f64::from(i) / f64::from(STEPS)))
        .map(|spread| {
            let gain = |(angle, weight): &(f64, f64)| (weight * odds(*angle, spread)).ln_1p();
            (spread, there.iter().map(gain).sum::<f64>())
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, likelihood)| *likelihood > NO_FACES)
        .map_or(ASSUMED_TILT, |(spread, _)| spread)
}
