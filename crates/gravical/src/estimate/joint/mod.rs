//! Faces and free poses in one fit, the tilt of every placement a nuisance.
//!
//! # The model
//!
//! At rest pose k reads u_k = M g n_k + b + noise. Of a *face* it is known that
//! n_k points along an axis of the case but for a small tilt δ_k, whose two
//! components have the standard deviation σ_tilt; of a *free* pose nothing is
//! known but that gravity is g long. Fitted are M, b and every n_k, at the
//! maximum of the posterior density:
//!
//! ```text
//! Σ ‖(u_k − b − g M n_k)/s_k‖² + Σ_faces ‖δ_k/σ_tilt‖² + data-sheet prior
//! ```
//!
//! The prior speaks of the lengths of M's rows (scale, 3 %), of the angles
//! between them (cross-axis, 2 % each) and of the bias (0.6 m/s²): of nothing
//! that depends on how the board sits in its case.
//!
//! # What is found out on the way
//!
//! Model error, tilt and the roles of the poses, repeatedly until none of them changes; then
//! repeats that lay the same way, once; then bad poses, one by one. After each of these two
//! the first three are found out again.
//!
//! 1. *Model error*: real sensors miss the model by more than the noise of
//!    their means. A variance is added to every mean until χ² equals its degrees
//!    of freedom (Paule and Mandel, J. Res. NBS 87 (1982) 377).
//! 2. *Tilt*: σ² ← Σ‖δ‖²/γ with γ = 2 N − tr(C_δδ)/σ², the maximum of the
//!    marginal likelihood (MacKay, Neural Comput. 4 (1992) 415), where γ ≥ 4;
//!    else 1° is assumed.
//! 3. *Face or free*: a pose is a face where its tilt under the fit is likelier
//!    for a placement than for a pose that points anywhere, by a mixture of both
//!    over all poses.
//! 4. *Repeats that lay the same way* share their tilt, pair by pair: they do not
//!    average it.
//! 5. *Bad poses*: one whose deletion lowers χ² more than chance allows is left
//!    out, unless a repeat that contradicts it could as well be the bad one.
//!
//! It fails where poses determine nothing: see [`JointError`].

mod bad;
mod curvature;
mod drift;
mod fit;
mod leave_out;
mod model;
mod reduced;
mod repeats;
mod roles;
mod shown;
mod sources;
mod types;

use gravical_core::matrix3;
use nalgebra::{DMatrix, DVector};

use crate::calibration_file::TiltSource;
use crate::estimate::observability::{condition, span};
use crate::predicted;
use crate::segment::face::Face;
use crate::stats::median;

pub use drift::{DriftTest, FOLDS, test_drift};
use fit::{Fit, Held, Pose, Start, fit, rough_fit};
pub use model::Elements;
use reduced::Reduced;
pub use roles::Role;
pub use sources::Source;
pub use types::*;

/// σ_tilt of a box on a table (sd of each of two components), degrees.
pub const ASSUMED_TILT_DEG: f64 = 1.0;
/// Tilts are estimated from at least so many well-determined components.
const LEAST_GAMMA: f64 = 4.0;
/// Limits of an estimated tilt, rad.
const TILT_RANGE: [f64; 2] = [0.02_f64.to_radians(), 10.0_f64.to_radians()];
/// ‖a‖ that is less well known than this share of gravity in some direction is
/// not known: the data sheet alone says as much.
const UNKNOWN: f64 = 0.028;
/// The same where elements are given: whoever assumes gets a result, poor as it may be, unless a
/// direction is as good as not there.
const UNKNOWN_ASSUMED: f64 = 0.25;
/// Poses determine nothing where the condition of the fit without a prior is worse:
/// rounding alone makes as much.
const MOST_CONDITION: f64 = 1e10;
/// Rounds in which tilt and model error have to settle.
const MOST_ROUNDS: i32 = 60;

/// Fits M and b.
///
/// # Errors
///
/// [`JointError`].
pub fn joint(poses: &[JointPose], options: &JointOptions) -> Result<JointFit, JointError> {
    let (mut work, mut search) = prepare(poses, options)?;
    let mut last = search.settle(&mut work)?;
    if options.elements.is_none()
        && let Some(scatter) = repeats::group(&mut work, &last, search.held.tilt)
    {
        search.held.scatter = scatter;
        last = search.settle(&mut work)?;
    }
    let mut bad = vec![None; poses.len()];
    let disputed = loop {
        if !options.find_bad {
            break Vec::new();
        }
        let misfits = bad::worst(&work, &last, &search.held, &bad);
        let Some((worst, chance)) = misfits.bad else {
            break misfits.disputed;
        };
        bad[worst] = Some(chance);
        work[worst].left_out = true;
        search.held.model_error = 0.0;
        last = search.settle(&mut work)?;
    };
    let mut fit = search.finish(&work, &bad)?;
    fit.disputed = disputed;
    Ok(fit)
}

/// The poses with their first roles, and the search.
fn prepare<'a>(
    poses: &'a [JointPose],
    options: &'a JointOptions,
) -> Result<(Vec<Pose>, Search<'a>), JointError> {
    let start = start(poses, options).ok_or(JointError::NoPoses)?;
    let alike = alike(poses, options.elements);
    let reference_c = reference_c(poses);
    let mut work: Vec<Pose> = poses
        .iter()
        .enumerate()
        .map(|(group, pose)| Pose {
            mean: pose.mean,
            sd: alike.unwrap_or(pose.standard_error),
            face: None,
            group,
            warmer_c: pose.temperature_c.map_or(0.0, |t| t - reference_c),
            left_out: false,
        })
        .collect();
    roles::first(poses, &mut work, start);
    Ok((work, Search::new(poses, options, start)))
}

/// Mean temperature of the poses that have one; NaN without any.
fn reference_c(poses: &[JointPose]) -> f64 {
    let known = poses.iter().filter_map(|p| p.temperature_c);
    known.clone().sum::<f64>() / known.count() as f64
}

/// The standard error of every mean where only lengths are fitted: all count alike, since real
/// sensors miss the model by more than the noise of their means.
fn alike(poses: &[JointPose], elements: Option<Elements>) -> Option<[f64; 3]> {
    elements.filter(|e| *e != Elements::All)?;
    let squares = poses.iter().flat_map(|p| p.standard_error).map(|s| s * s);
    Some([(squares.sum::<f64>() / (3 * poses.len()) as f64).sqrt(); 3])
}

/// M and b to start with: the nominal scale (or the one that readings of usual
/// length have), and no bias. Where lengths alone are fitted, the centre of the readings: no
/// data sheet says that the bias of such a sensor is small.
fn start(poses: &[JointPose], options: &JointOptions) -> Option<([[f64; 3]; 3], [f64; 3])> {
    let finite = |p: &JointPose| {
        matrix3::norm(&p.mean).is_finite()
            && p.standard_error.iter().all(|s| s.is_finite() && *s > 0.0)
    };
    if poses.is_empty() || !poses.iter().all(finite) {
        return None;
    }
    let usual = usual_scale(poses, options.gravity);
    // A nominal scale that is far off is a wrong unit, not a start.
    let near = |scale: f64, to: f64| (0.5..2.0).contains(&(scale / to));
    let nominal = options.nominal.filter(|n| near(usual, *n));
    let m = options
        .start
        .unwrap_or_else(|| matrix3::diagonal([nominal.unwrap_or(usual); 3]));
    let lengths = options.elements.is_some_and(|e| e != Elements::All);
    let sphere = nearest_sphere(poses)
        .filter(|_| lengths && options.start.is_none())
        .map(|(centre, radius)| (centre, radius / options.gravity))
        .filter(|(_, scale)| nominal.is_none_or(|n| near(*scale, n)));
    let (m, b) = match sphere {
        Some((centre, scale)) => (matrix3::diagonal([scale; 3]), centre),
        None => (m, [0.0; 3]),
    };
    (usual > 0.0).then_some((m, b))
}

/// Centre and radius of the sphere nearest to the readings: ‖u‖² = 2 b·u + (r² − ‖b‖²) is linear in
/// b and the bracket. None where the poses do not determine it.
fn nearest_sphere(poses: &[JointPose]) -> Option<([f64; 3], f64)> {
    let usual = usual_scale(poses, 1.0);
    let rows = DMatrix::from_fn(poses.len(), 4, |k, j| match j {
        3 => 1.0,
        j => 2.0 * poses[k].mean[j] / usual,
    });
    let right = DVector::from_fn(poses.len(), |k, _| {
        (matrix3::norm(&poses[k].mean) / usual).powi(2)
    });
    // The decomposition may never end on what is not finite.
    if poses.len() < 4 || rows.iter().chain(&right).any(|v| !v.is_finite()) {
        return None;
    }
    let svd = rows.svd(true, true);
    if svd.singular_values.min() < svd.singular_values.max() / 100.0 {
        return None;
    }
    let x = svd.solve(&right, 0.0).ok()?;
    let centre = [x[0], x[1], x[2]];
    let square = x[3] + centre.iter().map(|v| v * v).sum::<f64>();
    (square > 0.0).then(|| (centre.map(|v| v * usual), square.sqrt() * usual))
}

/// Scale by the usual length of a reading; NaN without readings.
fn usual_scale(poses: &[JointPose], gravity: f64) -> f64 {
    let mut lengths: Vec<f64> = poses.iter().map(|p| matrix3::norm(&p.mean)).collect();
    median(&mut lengths).unwrap_or(f64::NAN) / gravity
}

/// The loop around the fit: model error, tilt and roles until they rest.
struct Search<'a> {
    poses: &'a [JointPose],
    options: &'a JointOptions,
    held: Held,
    start: Start,
    tilt_from: TiltSource,
}

impl<'a> Search<'a> {
    fn new(
        poses: &'a [JointPose],
        options: &'a JointOptions,
        (m, b): ([[f64; 3]; 3], [f64; 3]),
    ) -> Self {
        let usual = usual_scale(poses, options.gravity);
        Search {
            poses,
            options,
            held: Held {
                gravity: options.gravity,
                // Faces that are exact; a tilt of exactly 0 would divide by it.
                tilt: options
                    .tilt
                    .unwrap_or(ASSUMED_TILT_DEG.to_radians())
                    .max(1e-7),
                // A nominal scale that gravity contradicts is a wrong unit or
                // range: no knowledge.
                prior: options
                    .nominal
                    .filter(|n| options.prior && (0.8..1.25).contains(&(usual / n))),
                model_error: 0.0,
                scatter: 0.0,
                elements: options.elements,
                drift: options.drift,
            },
            start: Start {
                m,
                b,
                drift: [0.0; 3],
                at: Vec::new(),
            },
            tilt_from: match options.tilt {
                Some(_) => TiltSource::Given,
                None => TiltSource::Assumed,
            },
        }
    }

    /// Repeats the fit until roles, tilt and model error rest.
    fn settle(&mut self, work: &mut [Pose]) -> Result<Fit, JointError> {
        let mut seen: Vec<Vec<Option<Face>>> = Vec::new();
        let mut rounds = 0;
        loop {
            let found = self.balance(work)?;
            let before: Vec<Option<Face>> = work.iter().map(|p| p.face).collect();
            roles::sort(self.poses, work, &found, self.options.tilt.unwrap_or(0.0));
            let after: Vec<Option<Face>> = work.iter().map(|p| p.face).collect();
            rounds += 1;
            // Back and forth: what was there before is as good.
            if after == before || seen.contains(&after) || rounds == 10 {
                if after != before {
                    work.iter_mut().zip(before).for_each(|(p, f)| p.face = f);
                }
                return Ok(found);
            }
            seen.push(before);
        }
    }

    /// Tilt and model error for the present roles.
    fn balance(&mut self, work: &[Pose]) -> Result<Fit, JointError> {
        for round in 0.. {
            let found = rough_fit(work, &self.held, &self.start).ok_or_else(|| self.open(work))?;
            if found.covariance.values.is_none() {
                return Err(self.open(work));
            }
            if !found.converged {
                // Readings that contradict each other by many times their noise
                // bend the tilts far off: with more noise they cannot.
                if round == MOST_ROUNDS {
                    return Err(JointError::NotConverged);
                }
                self.held.model_error = (2.0 * self.held.model_error).max(work[0].sd[0]);
                continue;
            }
            self.start = found.start();
            let tilt = self.next_tilt(&found);
            let error = self.next_model_error(&found);
            let scale = matrix3::norm(&found.state.m[0]) * self.held.gravity;
            let rests = (tilt / self.held.tilt - 1.0).abs() < 1e-3
                && (error - self.held.model_error).abs()
                    < 1e-3 * self.held.model_error.max(1e-7 * scale);
            if rests || round == MOST_ROUNDS {
                return Ok(found);
            }
            (self.held.tilt, self.held.model_error) = (tilt, error);
        }
        Err(JointError::NotConverged)
    }

    fn next_tilt(&mut self, found: &Fit) -> f64 {
        if self.tilt_from == TiltSource::Given {
            return self.held.tilt;
        }
        if found.gamma < LEAST_GAMMA {
            self.tilt_from = TiltSource::Assumed;
            return ASSUMED_TILT_DEG.to_radians();
        }
        self.tilt_from = TiltSource::Estimated;
        (found.tilt_squares / found.gamma)
            .sqrt()
            .clamp(TILT_RANGE[0], TILT_RANGE[1])
    }

    /// Variance that makes χ² its degrees of freedom, never below 0: a step of
    /// Newton's on f/χ² − 1, which is linear in the variance where all are alike.
    fn next_model_error(&self, found: &Fit) -> f64 {
        if found.freedom < 1.0 || found.chi2_slope == 0.0 {
            return 0.0;
        }
        let excess = found.chi2 / found.freedom - 1.0;
        let change = excess * found.chi2 / found.chi2_slope;
        (self.held.model_error.powi(2) + change).max(0.0).sqrt()
    }

    /// What the poses leave open.
    fn open(&self, work: &[Pose]) -> JointError {
        let there = work.iter().filter(|p| !p.left_out);
        let directions: Vec<[f64; 3]> = there.map(|p| matrix3::unit(&p.mean)).collect();
        JointError::Undetermined {
            direction: span(&directions).1,
            sd: f64::INFINITY,
        }
    }

    fn finish(self, work: &[Pose], bad: &[Option<f64>]) -> Result<JointFit, JointError> {
        let found = fit(work, &self.held, &self.start).ok_or_else(|| self.open(work))?;
        let mut covariance = found.full_covariance().ok_or_else(|| self.open(work))?;
        // Given elements mean the least squares of other programs: the maximum itself.
        let (mut model, mut bias) = (found.state.m, found.state.b);
        let mut curved = [[0.0; 12]; 12];
        if self.options.elements.is_none() {
            let second = curvature::second_order(&found).ok_or_else(|| self.open(work))?;
            curved = second.covariance(&model);
            (model, bias) = second.mean(&model, &bias);
        }
        add(&mut covariance, &curved);
        let inverse = matrix3::inverse(&model).ok_or(JointError::NotConverged)?;
        let (direction, sd) = predicted::weakest(&inverse, &covariance, self.held.gravity);
        let reduced = Reduced::new(&found);
        // What only the prior knows is open, too.
        let unknown = match self.options.elements {
            Some(_) => UNKNOWN_ASSUMED,
            None => UNKNOWN,
        };
        if !(sd <= unknown * self.held.gravity && reduced.condition() < MOST_CONDITION) {
            return Err(JointError::Undetermined { direction, sd });
        }
        let left_out = leave_out::errors(work, &found, &reduced, &self.held);
        let results = work
            .iter()
            .enumerate()
            .map(|(k, pose)| {
                let place = found.place_of[k];
                let direction = match place {
                    Some(place) => found.model.direction(&found.state, place),
                    None => matrix3::unit(&matrix3::mul_vec(
                        &inverse,
                        &matrix3::sub(&pose.mean, &found.state.offset(pose.warmer_c)),
                    )),
                };
                let tilt = place.and_then(|place| {
                    let model::Direction::Tilted(d) = found.state.at[place] else {
                        return None;
                    };
                    let [p, q] = found.tilt_variance[place]?;
                    Some((d[0].hypot(d[1]), (0.5 * (p + q)).sqrt()))
                });
                FittedPose {
                    face: place.and_then(|place| found.model.places[place].face),
                    direction,
                    tilt,
                    bad: bad[k],
                    left_out_error: left_out[k].map(|l| l.error),
                    left_out_sd: left_out[k].map(|l| l.sd),
                }
            })
            .collect();
        let alone = rough_fit(
            work,
            &Held {
                model_error: 0.0,
                ..self.held
            },
            &self.start,
        );
        let mut sources = sources::by_source(
            work,
            &found,
            self.options.quantisation,
            self.held.model_error,
        )
        .ok_or_else(|| self.open(work))?;
        // The second order is that of the tilts where there are any.
        let faces = found.model.places.iter().any(|p| p.face.is_some());
        let of = if faces { Source::Tilt } else { Source::Noise };
        if let Some((_, part)) = sources.iter_mut().find(|(source, _)| *source == of) {
            add(part, &curved);
        }
        let chi2_per_freedom = alone
            .filter(|a| a.freedom >= 1.0)
            .map(|a| a.chi2 / a.freedom);
        let reliability = chi2_per_freedom.and_then(|chi2| shown::tests(&found, chi2));
        Ok(JointFit {
            reliability,
            sources,
            model,
            bias,
            drift: self.options.drift.then(|| BiasDrift {
                reference_c: reference_c(self.poses),
                per_c: found.state.drift,
                sd: found.drift_deviations(),
            }),
            covariance,
            poses: results,
            disputed: Vec::new(),
            tilt: self.held.tilt,
            tilt_from: self.tilt_from,
            gamma: found.gamma,
            model_error: self.held.model_error,
            chi2_per_freedom,
            freedom: found.freedom,
            condition: magnitude_condition(&found),
            oriented: found.model.elements == model::Elements::All,
            shared_tilts: found.model.places.iter().any(|p| p.readings.len() > 1),
        })
    }
}

fn add(sum: &mut [[f64; 12]; 12], more: &[[f64; 12]; 12]) {
    for (x, y) in sum.iter_mut().flatten().zip(more.iter().flatten()) {
        *x += y;
    }
}

/// Singular values of the derivatives of ‖a‖ by the parameters that it depends on, largest
/// over smallest: the nine of an upper triangular M, or the six of a diagonal one.
fn magnitude_condition(found: &Fit) -> f64 {
    let places = found.model.places.len();
    let elements = match found.model.elements {
        Elements::Diagonal => Elements::Diagonal.list(),
        Elements::All | Elements::Triangular => Elements::Triangular.list(),
    };
    let Some(upper) = fit::upper(&found.state.m).filter(|_| places >= elements.len()) else {
        return f64::INFINITY;
    };
    let Some(back) = matrix3::inverse(&upper) else {
        return f64::INFINITY;
    };
    // M = U Q: in the frame of U the direction n is Q n.
    let q = matrix3::mul(&back, &found.state.m);
    let mut rows = nalgebra::DMatrix::zeros(places, elements.len());
    for k in 0..places {
        let n = matrix3::mul_vec(&q, &found.model.direction(&found.state, k));
        let h = predicted::sensitivity(&back, n, found.model.gravity);
        for (column, &element) in elements.iter().enumerate() {
            rows[(k, column)] = h[element];
        }
    }
    condition(rows)
}
