//! Which poses are faces.

use std::f64::consts::TAU;

use super::variances::USUAL_TILT_DEG;
use crate::model::Parameters;
use crate::pose::{Face, Hint, angle_deg};
use crate::rows::{PoseState, force};

/// Beyond this nothing is a face, degrees.
const MAX_FACE_DEG: f64 = 25.0;

/// First roles: of the poses that may be a face the nearest to it, however far off the names are;
/// the others follow when the fit knows how faces lie.
pub(crate) fn assign_first_roles(poses: &mut [PoseState], x: &Parameters) {
    for pose in poses.iter_mut() {
        if let Hint::Face(face) = pose.hint {
            pose.face = Some(face);
        }
    }
    let candidates = candidates(poses, x);
    for face in Face::all() {
        let angle_deg = |k: usize| {
            let (_, angle_deg) = candidates[k].filter(|(own, _)| *own == face)?;
            let is_named = poses[k].hint == Hint::Named(face);
            (is_named || angle_deg <= MAX_FACE_DEG).then_some((k, angle_deg))
        };
        let near = (0..poses.len()).filter_map(angle_deg);
        let nearest = near.min_by(|a, b| a.1.total_cmp(&b.1));
        let is_given = poses.iter().any(|p| p.hint == Hint::Face(face));
        if let Some((k, _)) = nearest.filter(|_| !is_given) {
            poses[k].face = Some(face);
        }
    }
}

/// The face that each pose may lie on, and its angle to it in degrees.
fn candidates(poses: &[PoseState], x: &Parameters) -> Vec<Option<(Face, f64)>> {
    let candidate = |pose: &PoseState| {
        let force = <[f64; 3]>::from(force(x, pose)?);
        match pose.hint {
            Hint::Named(face) => Some((face, angle_deg(force, face.direction()))),
            Hint::Open => Some(Face::nearest(force)),
            Hint::Face(_) | Hint::Free => None,
        }
    };
    poses.iter().map(candidate).collect()
}

/// A pose is a face where that is likelier than that it points anywhere. Faces have the spread
/// that makes all angles together likeliest: an estimate from what was taken for faces would grow
/// with every deliberate tilt among them.
pub(super) fn assign_roles(poses: &mut [PoseState], x: &Parameters, tilt: Option<f64>) {
    let candidates = candidates(poses, x);
    let is_named = |pose: &PoseState| matches!(pose.hint, Hint::Named(_));
    let counted = poses.iter().zip(&candidates);
    let angles: Vec<(f64, bool)> = counted
        .filter(|(pose, _)| pose.bad.is_none())
        .filter_map(|(pose, candidate)| Some(((*candidate)?.1, is_named(pose))))
        .collect();
    let likeliest = FaceMixture::likeliest(&angles);
    let mut mixture = likeliest.unwrap_or(FaceMixture::USUAL);
    let given_deg = tilt.unwrap_or(0.0).to_degrees();
    mixture.spread_deg = mixture.spread_deg.max(given_deg);
    for (pose, candidate) in poses.iter_mut().zip(candidates) {
        let named = is_named(pose);
        let is_face = |(_, angle_deg): &(Face, f64)| {
            let [face, other] = mixture.likelihoods(*angle_deg, named);
            // Among poses that lie anywhere some are near an axis by chance.
            let possible = likeliest.is_some() || named;
            possible && *angle_deg <= MAX_FACE_DEG && face > other
        };
        pose.face = match pose.hint {
            Hint::Face(face) => Some(face),
            _ => candidate.filter(is_face).map(|(face, _)| face),
        };
    }
}

/// How poses near faces are distributed: faces, and others.
#[derive(Debug, Clone, Copy)]
struct FaceMixture {
    /// Standard deviation of each component of a face's tilt, degrees.
    spread_deg: f64,
    /// Share of the named poses that are meant to be faces.
    share: f64,
}

impl FaceMixture {
    /// Of poses that are named, where nothing else tells.
    const USUAL: FaceMixture = FaceMixture {
        spread_deg: USUAL_TILT_DEG,
        share: 0.95,
    };
    /// Angle of a deliberate tilt off the face that a pose is named after, degrees.
    const OFF_FACE_DEG: f64 = 10.0;
    /// Poses that lie anywhere, by chance near axes, raise the logarithm of the likelihood by less.
    const MIN_GAIN: f64 = 7.0;

    /// How likely a face lies at this angle, and another pose, each times its share and over the density of
    /// the latter. Named, that leans off its face; else it points anywhere, while faces have a sixth of the
    /// sphere each.
    fn likelihoods(self, angle_deg: f64, named: bool) -> [f64; 2] {
        let normal = |sd: f64| {
            let sd = sd.to_radians();
            let angle = angle_deg.to_radians();
            (-0.5 * (angle / sd).powi(2)).exp() / (TAU * sd * sd)
        };
        let (share, other) = if named {
            (self.share, normal(Self::OFF_FACE_DEG))
        } else {
            (0.5, 6.0 / (2.0 * TAU))
        };
        [share * normal(self.spread_deg) / other, 1.0 - share]
    }

    /// The likeliest mixture; none where nothing looks like a face. Spreads are those from a fixture
    /// to a hand.
    fn likeliest(angles: &[(f64, bool)]) -> Option<FaceMixture> {
        let spreads = (0..=60).map(|i| 0.1 * 35_f64.powf(f64::from(i) / 60.0));
        let mixtures = spreads
            .flat_map(|spread_deg| [0.95, 0.8, 0.5].map(|share| FaceMixture { spread_deg, share }));
        mixtures
            .map(|mixture| (mixture, mixture.gain(angles)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, gain)| *gain > Self::MIN_GAIN)
            .map(|(mixture, _)| mixture)
    }

    /// Logarithm of the likelihood over that of no face at all.
    fn gain(self, angles: &[(f64, bool)]) -> f64 {
        let one = |(angle_deg, named): &(f64, bool)| {
            let [face, other] = self.likelihoods(*angle_deg, *named);
            (face + other).ln()
        };
        angles.iter().map(one).sum()
    }
}
