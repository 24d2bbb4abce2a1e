//! Which poses are faces.

use super::Search;
use super::variances::USUAL_TILT_DEG;
use crate::pose::{Face, Hint, angle_deg};
use crate::rows::force;

/// Beyond this nothing is a face, degrees.
const MAX_FACE_DEG: f64 = 25.0;

impl Search {
    /// First roles: of the poses that may be a face the nearest to it, however far off the names are;
    /// the others follow when the fit knows how faces lie.
    pub fn first_roles(&mut self) {
        let mut nearest: [Option<(usize, f64)>; 6] = [None; 6];
        for k in 0..self.poses.len() {
            if let Hint::Face(face) = self.poses[k].hint {
                self.poses[k].face = Some(face);
            }
            let Some((face, angle_deg)) = self.candidate(k) else {
                continue;
            };
            let named = self.poses[k].hint == Hint::Named(face);
            let best = &mut nearest[face.index()];
            if (named || angle_deg <= MAX_FACE_DEG) && best.is_none_or(|(_, a)| angle_deg < a) {
                *best = Some((k, angle_deg));
            }
        }
        for face in Face::all() {
            let is_given = self.poses.iter().any(|p| p.hint == Hint::Face(face));
            if let Some((k, _)) = nearest[face.index()].filter(|_| !is_given) {
                self.poses[k].face = Some(face);
            }
        }
    }

    /// The face that a pose may lie on, and its angle to it in degrees.
    fn candidate(&self, k: usize) -> Option<(Face, f64)> {
        let pose = &self.poses[k];
        let force = <[f64; 3]>::from(force(&self.x, pose)?);
        match pose.hint {
            Hint::Named(face) => Some((face, angle_deg(force, face.direction()))),
            Hint::Open => Some(Face::nearest(force)),
            Hint::Face(_) | Hint::Free => None,
        }
    }

    /// A pose is a face where that is likelier than that it points anywhere. Faces have the spread
    /// that makes all angles together likeliest: an estimate from what was taken for faces would grow
    /// with every deliberate tilt among them.
    pub(super) fn roles(&mut self) {
        let candidates: Vec<Option<(Face, f64)>> =
            (0..self.poses.len()).map(|k| self.candidate(k)).collect();
        let is_named = |k: usize| matches!(self.poses[k].hint, Hint::Named(_));
        let angles: Vec<(f64, bool)> = (0..self.poses.len())
            .filter(|&k| self.counts(k))
            .filter_map(|k| Some((candidates[k]?.1, is_named(k))))
            .collect();
        let likeliest = FaceMixture::likeliest(&angles);
        let mut mixture = likeliest.unwrap_or(FaceMixture::USUAL);
        mixture.spread_deg = mixture
            .spread_deg
            .max(self.tilt.unwrap_or(0.0).to_degrees());
        let roles: Vec<Option<Face>> = (0..self.poses.len())
            .map(|k| match (self.poses[k].hint, candidates[k]) {
                (Hint::Face(face), _) => Some(face),
                (_, Some((face, angle_deg))) => {
                    let [is_face, is_none] = mixture.densities(angle_deg, is_named(k));
                    // Among poses that lie anywhere some are near an axis by chance.
                    let possible = likeliest.is_some() || is_named(k);
                    (possible && angle_deg <= MAX_FACE_DEG && is_face > is_none).then_some(face)
                }
                (_, None) => None,
            })
            .collect();
        for (pose, face) in self.poses.iter_mut().zip(roles) {
            pose.face = face;
        }
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

    /// Density of a pose at this angle from a face, and of one that is none, each times its share.
    /// Named, the latter leans off its face; else it points anywhere, while faces have a sixth of the
    /// sphere each.
    fn densities(self, angle_deg: f64, named: bool) -> [f64; 2] {
        let normal = |sd: f64| {
            let sd = sd.to_radians();
            let angle = angle_deg.to_radians();
            (-0.5 * (angle / sd).powi(2)).exp() / (std::f64::consts::TAU * sd * sd)
        };
        if named {
            let leaning = (1.0 - self.share) * normal(Self::OFF_FACE_DEG);
            return [self.share * normal(self.spread_deg), leaning];
        }
        let anywhere = 1.0 / (4.0 * std::f64::consts::PI);
        [0.5 * normal(self.spread_deg) / 6.0, 0.5 * anywhere]
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
        let one = |&(angle_deg, named): &(f64, bool)| {
            let [face, none] = self.densities(angle_deg, named);
            let share = if named { 1.0 - self.share } else { 0.5 };
            ((face + none) / (none / share)).ln()
        };
        angles.iter().map(one).sum()
    }
}
