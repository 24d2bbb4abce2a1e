//! Finds the parameters, and with them what poses cannot be fitted without: roles, tilt, model error,
//! bends, and the poses that do not fit.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::model::{
    BENDS, BIAS, DIRECTIONS, DRIFT, Parameters, inverse, matrix, sensitivity, sphere, tangents,
};
use crate::pose::{Face, Hint, angle_deg};
use crate::rows::{Held, Lengths, Linear, Placed, Solution, force, free_parameters};

/// Steps of the search for the parameters.
const MAX_STEPS: usize = 40;
/// Rounds in which roles and variances settle.
const MAX_ROUNDS: usize = 8;

/// The fit so far.
#[derive(Debug, Clone)]
pub(crate) struct Search {
    pub poses: Vec<Placed>,
    /// Place among them of every pose that was given: repeats are merged.
    pub place_of: Vec<usize>,
    /// Input unit per working unit.
    pub scale: f64,
    /// Mean temperature of the poses, °C.
    pub reference_c: f64,
    pub held: Held,
    /// Geometric mean of the likely spreads of bends; `held` has their root mean square.
    pub typical_bend: f64,
    /// Tilt that was given, rad.
    pub tilt: Option<f64>,
    /// The channel along each axis of the case.
    pub channel_of: [usize; 3],
    pub x: Parameters,
}

/// Parameters at which the search came to rest, the problem linearised there, and its solution.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub linear: Linear,
    pub solution: Solution,
}

impl Search {
    /// What parameters are estimated with. What is claimed of them has to allow for all bends that are
    /// likely, and `held` has their mean square; with that the parameters would trust directions across
    /// an axis, which no bend changes, more than is usually right.
    pub fn estimating(&self) -> Held {
        Held {
            bend: self.typical_bend,
            ..self.held
        }
    }

    pub fn is_oriented(&self) -> bool {
        let counted = self.poses.iter().filter(|p| p.bad.is_none());
        let mut faces = counted.filter_map(|p| p.face);
        let first = faces.next();
        first.is_some_and(|first| faces.any(|face| face.axis != first.axis))
    }

    /// Gauss–Newton with the weights of the present parameters; steps are halved until they help.
    pub fn fit(&self, held: &Held) -> Option<Found> {
        let oriented = self.is_oriented();
        let free = free_parameters(oriented, self.channel_of, held);
        let mut x = self.x;
        if held.bend == 0.0 {
            x.fixed_rows_mut::<6>(BENDS).fill(0.0);
        }
        if !oriented {
            upper_triangular(&mut x, self.channel_of)?;
        }
        let mut found: Option<Found> = None;
        for _ in 0..MAX_STEPS {
            let linear = Linear::new(&self.poses, &x, (oriented, &free), held)?;
            let solution = linear.solve_poses(held, |_| true)?;
            let now = linear.cost_at(&self.poses, &x, held)?;
            let no_worse = |x: &Parameters| {
                let cost = linear.cost_at(&self.poses, x, held);
                cost.is_some_and(|cost| cost <= now * (1.0 + 1e-9))
            };
            let shares = (0..14).map(|i| 0.5_f64.powi(i));
            let next = shares.map(|share| x + share * solution.step).find(no_worse);
            let converged = solution.decrement < 1e-3 || next.is_none();
            found = Some(Found { linear, solution });
            match next {
                Some(next) if !converged => x = next,
                _ => break,
            }
        }
        found
    }

    /// Roles and variances in turn until no role changes; then the shift of the scale by tilts.
    pub fn settle(&mut self) -> Option<Found> {
        self.poses.iter_mut().for_each(|p| p.shortfall = 0.0);
        for _ in 0..MAX_ROUNDS {
            let before: Vec<Option<Face>> = self.poses.iter().map(|p| p.face).collect();
            self.estimate_variances()?;
            self.assign_roles();
            if self.poses.iter().map(|p| p.face).eq(before) {
                break;
            }
        }
        let found = self.fit(&self.estimating())?;
        self.estimate_shortfalls(&found);
        let linear = self.fit(&self.estimating())?.linear;
        self.x = linear.x;
        let solution = linear.solve_poses(&self.held, |_| true)?;
        Some(Found { linear, solution })
    }

    /// What ‖a‖ of the faces falls short of by angles that the stretch of M leaves open. A rotation of
    /// the frame changes no length and does not count.
    fn estimate_shortfalls(&mut self, found: &Found) {
        let by_case = inverse(&found.linear.x).transpose();
        let gravity = self.held.gravity;
        let covariance = &found.solution.covariance;
        for pose in &mut self.poses {
            let Some(face) = pose.face else { continue };
            let n = Vector3::from(face.direction());
            let across = |t: &Vector3<f64>| {
                let (along, aside) = (by_case * n, by_case * t);
                let h = Parameters::from_fn(|i, _| match i {
                    0..BIAS => 0.5 * (aside[i / 3] * n[i % 3] + along[i / 3] * t[i % 3]),
                    BIAS..DRIFT => aside[i - BIAS] / gravity,
                    _ => 0.0,
                });
                (covariance * h).dot(&h)
            };
            let variance: f64 = tangents(&n).iter().map(across).sum();
            pose.shortfall = 0.5 * gravity * variance;
        }
    }
}

/// M = U Q with U upper triangular in the axes of the channels, by a Cholesky decomposition of M Mᵀ = U Uᵀ
/// from its last row up: turns the frame of the case, which no length tells.
fn upper_triangular(x: &mut Parameters, channel_of: [usize; 3]) -> Option<()> {
    let m = matrix(x);
    let flip = |m: Matrix3<f64>| Matrix3::from_fn(|r, c| m[(2 - r, 2 - c)]);
    let upper = flip(flip(m * m.transpose()).cholesky()?.l());
    for (axis, channel) in channel_of.into_iter().enumerate() {
        let sign = m[(channel, axis)].signum();
        for r in 0..3 {
            x[3 * r + axis] = sign * upper[(r, channel)];
        }
    }
    x.iter().all(|v| v.is_finite()).then_some(())
}

/// Where ‖a‖ of a direction is known least, and its standard deviation there by M and b, m/s².
pub(crate) fn least_known(found: &Found, gravity: f64) -> Option<(Vector3<f64>, f64)> {
    let inverse = matrix(&found.linear.x).try_inverse()?;
    sphere(DIRECTIONS)
        .map(|n| {
            let mut h = sensitivity(&inverse, &n, gravity);
            h.fixed_rows_mut::<6>(BENDS).fill(0.0);
            (n, (found.solution.covariance * h).dot(&h).max(0.0).sqrt())
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

/// What is known of the tilt before any pose, degrees: a box on a table, give or take a factor of e.
pub(crate) const USUAL_TILT_DEG: f64 = 1.0;
/// What is known of a bend before any pose: 0.05 % of g at 1 g, give or take a factor of e^1.5.
pub(crate) const USUAL_BEND: (f64, f64) = (5e-4, 1.5);
/// Shares by which a variance may still change.
const CLOSE: f64 = 2e-3;

impl Search {
    /// Tilt, bends and model error by restricted maximum likelihood (Patterson and Thompson, Biometrika 58,
    /// 1971) of the linearised problem.
    fn estimate_variances(&mut self) -> Option<()> {
        for _ in 0..MAX_ROUNDS {
            let before = self.held;
            let found = self.fit(&self.held)?;
            self.x = found.linear.x;
            let likelihood = |held: &Held| {
                let solution = found.linear.solve_poses(held, |_| true);
                solution.map_or(f64::NEG_INFINITY, |s| s.log_likelihood)
            };
            if self.tilt.is_none() && self.is_oriented() {
                self.held.tilt = likeliest_tilt(&self.held, likelihood);
            }
            let (grid, _) = self.likely_bends(&found)?;
            let all: f64 = grid.iter().map(|(_, weight)| weight).sum();
            let mean = |value: fn(f64) -> f64| {
                let each = grid.iter().map(|(bend, weight)| value(*bend) * weight);
                each.sum::<f64>() / all
            };
            self.held.bend = mean(|bend| bend * bend).sqrt();
            self.typical_bend = mean(f64::ln).exp();
            let mut bare = self.held;
            bare.model_error = 0.0;
            let exact = found.linear.solve_poses(&bare, |_| true)?;
            // Without a length left over there is no error to see.
            let lengths = found.linear.lengths(&bare, &exact, |_| true);
            self.held.model_error = if lengths.freedom < 1.0 {
                0.0
            } else {
                likeliest_error(&self.held, likelihood)
            };
            let values = |held: &Held| [held.tilt, held.bend, held.model_error];
            let mut pairs = values(&self.held).into_iter().zip(values(&before));
            if pairs.all(|(a, b)| (a - b).abs() <= CLOSE * a.abs().max(b.abs())) {
                break;
            }
        }
        Some(())
    }

    /// Spreads of bends with their density, prior times likelihood, as a share of the largest; and the
    /// logarithm of that. Six bends tell little of their spread: all that are likely count.
    fn likely_bends(&self, found: &Found) -> Option<(Vec<(f64, f64)>, f64)> {
        let normal = found.linear.normal(&self.held, |_| true)?;
        let (usual, factor) = USUAL_BEND;
        let density = |i: i32| {
            let bend = 3e-5 * 2_f64.powi(i);
            let before = -0.5 * ((bend / usual).ln() / factor).powi(2);
            let solution = found.linear.solve(&normal, &Held { bend, ..self.held });
            let likelihood = solution.map_or(f64::NEG_INFINITY, |s| s.log_likelihood);
            (bend, before + likelihood)
        };
        let grid: Vec<(f64, f64)> = (0..10).map(density).collect();
        let best = grid.iter().map(|g| g.1).fold(f64::NEG_INFINITY, f64::max);
        let shares = grid.iter().map(|(bend, log)| (*bend, (log - best).exp()));
        best.is_finite().then(|| (shares.collect(), best))
    }
}

/// The largest of a function between `low` and `high`, by golden sections.
fn golden_section(mut low: f64, mut high: f64, value: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5_f64.sqrt() - 1.0);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (value(left), value(right));
    for _ in 0..24 {
        if at_left > at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - ratio * (high - low);
            at_left = value(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + ratio * (high - low);
            at_right = value(right);
        }
    }
    0.5 * (low + high)
}

fn likeliest_tilt(held: &Held, likelihood: impl Fn(&Held) -> f64) -> f64 {
    let value = |log: f64| {
        let tilt = log.exp();
        let before = -0.5 * (tilt.to_degrees() / USUAL_TILT_DEG).ln().powi(2);
        before + likelihood(&Held { tilt, ..*held })
    };
    golden_section(0.1_f64.to_radians().ln(), 8_f64.to_radians().ln(), value).exp()
}

/// The model error, m/s²; none where that is likelier.
fn likeliest_error(held: &Held, likelihood: impl Fn(&Held) -> f64) -> f64 {
    let value = |model_error: f64| {
        likelihood(&Held {
            model_error,
            ..*held
        })
    };
    let best = golden_section(1e-4_f64.ln(), 0.3_f64.ln(), |log| value(log.exp())).exp();
    if value(best) > value(0.0) { best } else { 0.0 }
}

/// Beyond this nothing is a face, degrees.
const MAX_FACE_DEG: f64 = 25.0;

impl Search {
    /// First roles: of the poses that may be a face the nearest to it, however far off the names are;
    /// the others follow when the fit knows how faces lie.
    pub fn assign_first_roles(&mut self) {
        for pose in &mut self.poses {
            if let Hint::Face(face) = pose.hint {
                pose.face = Some(face);
            }
        }
        let candidates = self.candidates();
        for face in Face::all() {
            let angle_deg = |k: usize| {
                let (_, angle_deg) = candidates[k].filter(|(own, _)| *own == face)?;
                let is_named = self.poses[k].hint == Hint::Named(face);
                (is_named || angle_deg <= MAX_FACE_DEG).then_some((k, angle_deg))
            };
            let near = (0..self.poses.len()).filter_map(angle_deg);
            let nearest = near.min_by(|a, b| a.1.total_cmp(&b.1));
            let is_given = self.poses.iter().any(|p| p.hint == Hint::Face(face));
            if let Some((k, _)) = nearest.filter(|_| !is_given) {
                self.poses[k].face = Some(face);
            }
        }
    }

    /// The face that each pose may lie on, and its angle to it in degrees.
    fn candidates(&self) -> Vec<Option<(Face, f64)>> {
        let candidate = |pose: &Placed| {
            let force = <[f64; 3]>::from(force(&self.x, pose)?);
            match pose.hint {
                Hint::Named(face) => Some((face, angle_deg(force, face.direction()))),
                Hint::Open => Some(Face::nearest(force)),
                Hint::Face(_) | Hint::Free => None,
            }
        };
        self.poses.iter().map(candidate).collect()
    }

    /// A pose is a face where that is likelier than that it points anywhere. Faces have the spread
    /// that makes all angles together likeliest: an estimate from what was taken for faces would grow
    /// with every deliberate tilt among them.
    fn assign_roles(&mut self) {
        let candidates = self.candidates();
        let is_named = |pose: &Placed| matches!(pose.hint, Hint::Named(_));
        let counted = self.poses.iter().zip(&candidates);
        let angles: Vec<(f64, bool)> = counted
            .filter(|(pose, _)| pose.bad.is_none())
            .filter_map(|(pose, candidate)| Some(((*candidate)?.1, is_named(pose))))
            .collect();
        let likeliest = FaceMixture::likeliest(&angles);
        let mut mixture = likeliest.unwrap_or(FaceMixture::USUAL);
        let given_deg = self.tilt.unwrap_or(0.0).to_degrees();
        mixture.spread_deg = mixture.spread_deg.max(given_deg);
        for (pose, candidate) in self.poses.iter_mut().zip(candidates) {
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

/// What is known of χ² per degree of freedom before any residual is seen: about 4, since real sensors
/// miss the model by more than the noise of their means (8.8 was seen on 38 poses), worth as much as
/// four residuals.
pub(crate) const USUAL_CHI2: f64 = 4.0;
/// … so many.
pub(crate) const USUAL_FREEDOM: f64 = 4.0;
/// A pose is bad when one as far off is rarer than this among all poses.
const CHANCE: f64 = 1e-3;
/// More poses than this are no session by hand.
pub(crate) const MAX_SESSION: usize = 64;
/// With fewer degrees of freedom one bad pose can look like another: the worst has to be so many times
/// rarer than the next.
const PLENTY_OF_FREEDOM: f64 = 3.0;
const CLEARLY: f64 = 100.0;
/// At most this share of the poses is left out.
const MAX_SHARE_OUT: f64 = 0.2;

/// A pose, tried without.
struct Deletion {
    pose: usize,
    /// Probability that deleting a good pose lowers χ² by as much.
    chance: f64,
    /// Degrees of freedom of what remains.
    freedom: f64,
}

impl Search {
    /// The pose whose deletion lowers χ² of the lengths by more than chance, and the chance of that: an
    /// F test by noise alone against what remains, with Bonferroni's correction for having picked the
    /// worst. Bends are left out, since they would take in what one bad pose does. Of more poses than a
    /// session by hand has, all that are rarer than chance.
    pub fn misfits(&self) -> Vec<(usize, f64)> {
        let held = self.held.bare();
        let counted = (0..self.poses.len()).filter(|k| self.poses[*k].bad.is_none());
        let count = counted.clone().count();
        let out = (self.poses.len() - count) as f64;
        let spare = MAX_SHARE_OUT * self.poses.len() as f64 - out;
        let Some(found) = self.fit(&held).filter(|_| spare >= 1.0) else {
            return Vec::new();
        };
        let whole = found.linear.lengths(&held, &found.solution, |_| true);
        let trials = counted.map(|k| self.delete(k, &found, &held, whole));
        let mut trials: Vec<Deletion> = trials.collect();
        trials.sort_by(|a, b| a.chance.total_cmp(&b.chance));
        let next = trials.get(1).map_or(1.0, |d| d.chance);
        let is_many = count > MAX_SESSION;
        let is_bad = |d: &&Deletion| {
            let is_clear = is_many || d.freedom >= PLENTY_OF_FREEDOM || next > CLEARLY * d.chance;
            is_clear && count as f64 * d.chance < CHANCE
        };
        let most = if is_many { spare as usize } else { 1 };
        let bad = trials.iter().take(most).filter(is_bad);
        bad.map(|d| (d.pose, count as f64 * d.chance)).collect()
    }

    /// The fit without pose `k`. Of many poses, by the residual and its share of the redundancy, which
    /// is exact for a free pose. The scale of χ² is known by what remains and by what is usual.
    fn delete(&self, k: usize, found: &Found, held: &Held, whole: Lengths) -> Deletion {
        let linear = &found.linear;
        let rest = if self.poses.len() <= MAX_SESSION {
            let solution = linear.solve_poses(held, |i| i != k);
            solution.map(|solution| linear.lengths(held, &solution, |i| i != k))
        } else {
            let row = &linear.rows[k];
            let derivative = row.jacobian.row(0);
            let variance = row.noise[(0, 0)];
            let taken = (derivative * found.solution.covariance * derivative.transpose())[0];
            let share = (1.0 - taken / variance).max(1e-6);
            Some(Lengths {
                chi2: whole.chi2 - row.residual[0].powi(2) / variance / share,
                freedom: whole.freedom - share,
            })
        };
        let chance = |rest: Lengths| {
            let freed = (whole.freedom - rest.freedom).max(0.5);
            let chi2 = rest.chi2.max(0.0) + USUAL_FREEDOM * USUAL_CHI2;
            let freedom = rest.freedom + USUAL_FREEDOM;
            let ratio = (whole.chi2 - rest.chi2).max(0.0) / freed / (chi2 / freedom);
            FisherSnedecor::new(freed, freedom).map_or(1.0, |f| f.sf(ratio.min(1e6)))
        };
        let rest = rest.filter(|rest| rest.freedom >= 1.0);
        Deletion {
            pose: k,
            chance: rest.map_or(1.0, chance),
            freedom: rest.map_or(0.0, |rest| rest.freedom),
        }
    }

    /// An error of pose `k` explains the session better than a nonlinear response does: the evidence for
    /// both, a pose in fifty being off by some 50 mg.
    pub fn is_outlier(&self, k: usize, found: &Found) -> bool {
        const SHARE: f64 = 0.02;
        const ERROR_MPS2: f64 = 0.5;
        if self.poses.len() > MAX_SESSION {
            return true;
        }
        let mut other = self.clone();
        other.poses[k].outlier_sd = ERROR_MPS2;
        let Some(without) = other.settle() else {
            return false;
        };
        other.evidence(&without) + SHARE.ln() > self.evidence(found)
    }

    /// Logarithm of the likelihood of the session, integrated over parameters and the spread of bends
    /// (MacKay, Neural Computation 4, 1992).
    fn evidence(&self, found: &Found) -> f64 {
        let sum = |(grid, best): (Vec<(f64, f64)>, f64)| {
            best + grid.iter().map(|(_, weight)| weight).sum::<f64>().ln()
        };
        self.likely_bends(found).map_or(f64::NEG_INFINITY, sum)
    }
}
