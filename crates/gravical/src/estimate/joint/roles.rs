//! Which poses are faces.

use std::f64::consts::PI;

use gravical_core::matrix3;

use crate::segment::face::{Face, angle_deg};

use super::fit::{Fit, Pose};
use super::{ASSUMED_TILT_DEG, JointPose};

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
const MOST: f64 = 25.0_f64.to_radians();
/// Tilts of placements on faces, rad, between which their spread is looked for.
/// More is a pose in the hand; less is finer than any fixture, and a face that
/// lies as well as this is one whatever the others do.
const SPREAD: [f64; 2] = [0.1_f64.to_radians(), 3.5_f64.to_radians()];
/// Steps between these.
const STEPS: i32 = 60;
/// Poses that lie anywhere, by chance near axes, raise the logarithm of the
/// likelihood by less than this.
const NO_FACES: f64 = 5.0;
/// Angle of a deliberate tilt off the face that a pose is named after, rad.
const OFF_FACE: f64 = 10.0_f64.to_radians();
/// Shares of the named poses that lie on their face, of which the likeliest is
/// taken: all but one in twenty, most, and half.
const SHARES: [f64; 3] = [0.95, 0.8, 0.5];

/// Angle of a reading to the face, rad, under M and b.
fn off(mean: [f64; 3], inverse: &[[f64; 3]; 3], b: &[f64; 3], face: Face) -> f64 {
    let force = matrix3::mul_vec(inverse, &matrix3::sub(&mean, b));
    angle_deg(force, face.direction()).to_radians()
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
        let Some((face, angle)) = candidate(pose, &inverse, &b) else {
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

/// The face that a pose may be, and its angle to it in rad.
fn candidate(pose: &JointPose, inverse: &[[f64; 3]; 3], b: &[f64; 3]) -> Option<(Face, f64)> {
    match pose.role {
        Role::Named(face) => Some((face, off(pose.mean, inverse, b, face))),
        Role::Open => {
            let force = matrix3::mul_vec(inverse, &matrix3::sub(&pose.mean, b));
            let (face, angle_deg) = Face::nearest(force);
            Some((face, angle_deg.to_radians()))
        }
        Role::Face(_) | Role::Free => None,
    }
}

/// How the poses near the faces are distributed: face poses and others.
#[derive(Debug, Clone, Copy)]
struct FaceMixture {
    /// Standard deviation of each component of a face's tilt, rad.
    spread: f64,
    /// Share of the named poses that are meant to be faces.
    share: f64,
}

impl FaceMixture {
    /// Density of a pose `angle` from a face with this tilt, and of one that is
    /// none, each times its share. Named, that one leans off its face; else it
    /// points anywhere, while faces have a sixth of the sphere each.
    fn densities(self, angle: f64, named: bool) -> [f64; 2] {
        let normal = |sd: f64| (-0.5 * (angle / sd).powi(2)).exp() / (2.0 * PI * sd * sd);
        if named {
            [
                self.share * normal(self.spread),
                (1.0 - self.share) * normal(OFF_FACE),
            ]
        } else {
            [0.5 * normal(self.spread) / 6.0, 0.5 / (4.0 * PI)]
        }
    }

    /// Of poses that are named, where nothing else tells.
    const USUAL: FaceMixture = FaceMixture {
        spread: ASSUMED_TILT_DEG.to_radians(),
        share: SHARES[0],
    };

    /// The likeliest for poses with these angles, named or not, as a mixture of
    /// both kinds; none where nothing looks like a face.
    fn likeliest(poses: &[(f64, bool)]) -> Option<FaceMixture> {
        let [low, high] = SPREAD;
        let spreads = (0..=STEPS).map(|i| low * (high / low).powf(f64::from(i) / f64::from(STEPS)));
        spreads
            .flat_map(|spread| SHARES.map(|share| FaceMixture { spread, share }))
            .map(|mixture| {
                // Against none being a face.
                let gain = |(angle, named): &(f64, bool)| {
                    let [face, none] = mixture.densities(*angle, *named);
                    let alone = if *named {
                        none / (1.0 - mixture.share)
                    } else {
                        2.0 * none
                    };
                    ((face + none) / alone).ln()
                };
                (mixture, poses.iter().map(gain).sum::<f64>())
            })
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, likelihood)| *likelihood > NO_FACES)
            .map(|(mixture, _)| mixture)
    }
}

/// Sorts the poses again by a fit: each is a face where that is likelier than
/// that it is none. Faces have the spread that makes all angles together
/// likeliest: an estimate from what was taken for faces would grow with every
/// deliberate tilt among them. `least` is a tilt that was given.
pub(super) fn sort(poses: &[JointPose], work: &mut [Pose], found: &Fit, least: f64) {
    let Some(inverse) = matrix3::inverse(&found.state.m) else {
        return;
    };
    let named = |k: usize| matches!(poses[k].role, Role::Named(_));
    let candidates: Vec<Option<(Face, f64)>> = poses
        .iter()
        .map(|pose| candidate(pose, &inverse, &found.state.b))
        .collect();
    let there: Vec<(f64, bool)> = (0..poses.len())
        .filter(|&k| !work[k].left_out)
        .filter_map(|k| Some((candidates[k]?.1, named(k))))
        .collect();
    let found = FaceMixture::likeliest(&there);
    let mut mixture = found.unwrap_or(FaceMixture::USUAL);
    mixture.spread = mixture.spread.max(least);
    for k in 0..poses.len() {
        work[k].face = match (poses[k].role, candidates[k]) {
            (Role::Face(face), _) => Some(face),
            (_, Some((face, angle))) => {
                let [is_face, none] = mixture.densities(angle, named(k));
                // Among poses that lie anywhere some are near an axis by chance.
                let some_are_faces = found.is_some() || named(k);
                (some_are_faces && angle <= MOST && is_face > none).then_some(face)
            }
            (_, None) => None,
        };
    }
}
