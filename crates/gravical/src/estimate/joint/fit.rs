//! One fit with everything else held: which poses are faces, the tilt, the
//! model error.

use std::collections::HashMap;

use gravical_core::matrix3;

use crate::estimate::solve::{Covariance, Factor, Options, Problem, solve};
use crate::segment::face::Face;

use super::model::{Direction, Elements, Model, Place, Reading, State};

/// A mean reading and what it is taken for, in axes of the board.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose {
    pub mean: [f64; 3],
    pub sd: [f64; 3],
    pub face: Option<Face>,
    /// Poses of the same group lay the same way and share their tilt.
    pub group: usize,
    /// Temperature above the reference, °C.
    pub warmer_c: f64,
    /// Not fitted.
    pub left_out: bool,
}

/// What is held in a fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Held {
    pub gravity: f64,
    pub tilt: f64,
    pub prior: Option<f64>,
    /// Standard deviation that is added to every mean, input unit.
    pub model_error: f64,
    /// Standard deviation of poses of one group about their tilt, rad for each
    /// of two components.
    pub scatter: f64,
    /// Elements to be fitted; none: all, or what poses on too few faces determine.
    pub elements: Option<Elements>,
    /// The drift of the bias with temperature is fitted.
    pub drift: bool,
}

/// Where a search starts.
#[derive(Debug, Clone)]
pub(super) struct Start {
    pub m: [[f64; 3]; 3],
    pub b: [f64; 3],
    pub drift: [f64; 3],
    /// Directions of the poses, where they are known in the frame of `m`.
    pub at: Vec<Option<Direction>>,
}

/// The minimum, and what follows from it.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub model: Model,
    pub state: State,
    /// Place of every pose; none when it is left out.
    pub place_of: Vec<Option<usize>>,
    pub covariance: Covariance,
    /// Of the tilt of every face place, rad², by place.
    pub tilt_variance: Vec<Option<[f64; 2]>>,
    /// Well-determined tilt components: 2 N − tr(C)/σ².
    pub gamma: f64,
    /// Σ‖δ‖² over the faces, rad².
    pub tilt_squares: f64,
    /// Whitened squares of the readings, and their degrees of freedom.
    pub chi2: f64,
    pub freedom: f64,
    /// −∂χ²/∂σ_m² when σ_m² is added to every variance.
    pub chi2_slope: f64,
    pub converged: bool,
}

/// Number of different axes among some faces.
pub(super) fn axes_of(faces: impl Iterator<Item = Face>) -> usize {
    let mut seen = [false; 3];
    for face in faces {
        seen[face.axis] = true;
    }
    seen.iter().filter(|s| **s).count()
}

/// Fits M, b and the directions, to all digits. None when nothing finite comes
/// of it.
pub(super) fn fit(poses: &[Pose], held: &Held, start: &Start) -> Option<Fit> {
    fit_to(&EXACT, poses, held, start)
}

/// The same to a thousandth of a standard deviation, to decide by.
pub(super) fn rough_fit(poses: &[Pose], held: &Held, start: &Start) -> Option<Fit> {
    fit_to(&ROUGH, poses, held, start)
}

fn fit_to(options: &Options, poses: &[Pose], held: &Held, start: &Start) -> Option<Fit> {
    let (model, state, place_of) = placed(poses, held, start)?;
    let (state, summary) = solve(&model, state, options);
    let factor = Factor::new(&model, &state)?;
    let covariance = factor.covariance();
    let mut fit = Fit {
        place_of,
        tilt_variance: vec![None; model.places.len()],
        gamma: 0.0,
        tilt_squares: 0.0,
        chi2: 0.0,
        freedom: 0.0,
        chi2_slope: 0.0,
        converged: summary.converged(),
        covariance,
        model,
        state,
    };
    fit.count(&factor);
    Some(fit)
}

/// The parameters alone, as roughly.
pub(super) fn roughly(poses: &[Pose], held: &Held, start: &Start) -> Option<State> {
    let (model, state, _) = placed(poses, held, start)?;
    let (state, summary) = solve(&model, state, &ROUGH);
    summary.converged().then_some(state)
}

/// The problem, where its search starts, and the place of every pose.
type Placed = (Model, State, Vec<Option<usize>>);

fn placed(poses: &[Pose], held: &Held, start: &Start) -> Option<Placed> {
    // Without faces on two axes nothing holds the frame to the case.
    let faces = poses.iter().filter(|p| !p.left_out).filter_map(|p| p.face);
    let elements = held.elements.unwrap_or(if axes_of(faces) < 2 {
        Elements::Triangular
    } else {
        Elements::All
    });
    let Start {
        mut m, b, drift, ..
    } = *start;
    if elements != Elements::All {
        m = upper(&m)?;
    }
    let known = |k: usize| {
        let same_frame = m == start.m;
        start.at.get(k).copied().flatten().filter(|_| same_frame)
    };
    let inverse = matrix3::inverse(&m)?;
    let face_of = |pose: &Pose| pose.face.filter(|_| elements == Elements::All);
    // Lengths count alike in m/s², not in the unit of each channel.
    let k = matrix3::row_norms(&m);
    let weight = match held.elements {
        Some(Elements::Triangular | Elements::Diagonal) => {
            k.map(|k_i| 3.0 * k_i / k.iter().sum::<f64>())
        }
        Some(Elements::All) | None => [1.0; 3],
    };
    // Face poses of one group and face: how many there are, and their place.
    let mut groups: HashMap<(usize, usize), (usize, Option<usize>)> = HashMap::new();
    for pose in poses.iter().filter(|p| !p.left_out) {
        if let Some(face) = face_of(pose) {
            groups.entry((pose.group, face.index())).or_default().0 += 1;
        }
    }
    let mut places: Vec<Place> = Vec::new();
    let mut at = Vec::new();
    let place_of = poses
        .iter()
        .enumerate()
        .map(|(k, pose)| {
            if pose.left_out {
                return None;
            }
            let face = face_of(pose);
            let mut group = face.and_then(|f| groups.get_mut(&(pose.group, f.index())));
            let across = match (face, &group) {
                (Some(f), Some((2.., _))) => {
                    held.scatter * held.gravity * matrix3::norm(&m[f.axis])
                }
                _ => 0.0,
            };
            let reading = Reading {
                mean: pose.mean,
                sd: std::array::from_fn(|i| {
                    let known = pose.sd[i].hypot(held.model_error);
                    match face {
                        Some(face) if face.axis != i => known.hypot(across),
                        _ => known * weight[i],
                    }
                }),
                warmer_c: pose.warmer_c,
            };
            if let Some((_, Some(place))) = group {
                places[*place].readings.push(reading);
                return Some(*place);
            }
            if let Some((_, place)) = &mut group {
                *place = Some(places.len());
            }
            at.push(match (face, known(k)) {
                (Some(_), Some(Direction::Tilted(d))) => Direction::Tilted(d),
                (Some(_), _) => Direction::Tilted([0.0; 2]),
                (None, Some(Direction::Any(n))) => Direction::Any(n),
                (None, _) => Direction::Any(matrix3::unit(&matrix3::mul_vec(
                    &inverse,
                    &matrix3::sub(&pose.mean, &b),
                ))),
            });
            places.push(Place {
                face,
                readings: vec![reading],
            });
            Some(places.len() - 1)
        })
        .collect();
    let model = Model {
        places,
        gravity: held.gravity,
        tilt: held.tilt,
        prior: held.prior,
        elements,
        drift: held.drift,
    };
    Some((model, State { m, b, drift, at }, place_of))
}

/// Fits of means in single precision do not need more.
const EXACT: Options = Options {
    most_steps: 60,
    cost_tolerance: 1e-12,
    gradient_tolerance: 1e-12,
    step_tolerance: 1e-12,
    damping: 1e-6,
};

/// A square of 1e-6 among some hundred, or as small a part of the way.
const ROUGH: Options = Options {
    cost_tolerance: 1e-8,
    step_tolerance: 1e-5,
    ..EXACT
};

/// The upper triangular matrix with the same M Mᵀ and a positive diagonal: the
/// frame that the convention chooses.
pub(super) fn upper(m: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    // M Mᵀ = U Uᵀ is Cholesky's L Lᵀ with rows and columns reversed.
    let product = matrix3::mul(m, &matrix3::transpose(m));
    let reversed = nalgebra::Matrix3::from_fn(|i, j| product[2 - i][2 - j]);
    let l = reversed.cholesky()?.l();
    Some(std::array::from_fn(|i| {
        std::array::from_fn(|j| l[(2 - i, 2 - j)])
    }))
}

impl Fit {
    /// Counts degrees of freedom. The trace of the hat matrix over all rows is
    /// the number of unknowns; what the rows of priors take of it, the readings
    /// keep.
    fn count(&mut self, factor: &Factor) {
        let model = &self.model;
        let p = model.shared();
        let mut taken_by_priors = 0.0;
        let mut faces = 0;
        let (mut readings, mut locals) = (0, 0);
        let Some(values) = &self.covariance.values else {
            return;
        };
        for (k, place) in model.places.iter().enumerate() {
            readings += place.readings.len();
            let shape = model.shape(k);
            locals += shape.local;
            let mut r = vec![0.0; shape.residuals];
            model.evaluate(&self.state, k, &mut r, None);
            for (r, sd) in r.iter().zip(place.readings.iter().flat_map(|r| r.sd)) {
                self.chi2 += r * r;
                self.chi2_slope += (r / sd).powi(2);
            }
            if let Direction::Tilted(d) = self.state.at[k] {
                faces += 1;
                self.tilt_squares += d[0] * d[0] + d[1] * d[1];
                let Some(own) = factor.local_covariance(k, values) else {
                    return;
                };
                let own = [own[0][0], own[1][1]];
                self.tilt_variance[k] = Some(own);
                taken_by_priors += (own[0] + own[1]) / (model.tilt * model.tilt);
            }
        }
        self.gamma = 2.0 * f64::from(faces) - taken_by_priors;
        if model.prior.is_some() {
            let rows = model.rows(&self.state, model.places.len()).shared;
            for row in rows.row_iter() {
                taken_by_priors += (0..p)
                    .map(|a| row[a] * (0..p).map(|b| values[a][b] * row[b]).sum::<f64>())
                    .sum::<f64>();
            }
        }
        self.freedom = 3.0 * readings as f64 - p as f64 - locals as f64 + taken_by_priors;
    }

    /// The poses of every place.
    pub fn members(&self) -> Vec<Vec<usize>> {
        let mut members = vec![Vec::new(); self.model.places.len()];
        for (pose, place) in self.place_of.iter().enumerate() {
            if let Some(place) = place {
                members[*place].push(pose);
            }
        }
        members
    }

    /// A search from here.
    pub fn start(&self) -> Start {
        Start {
            m: self.state.m,
            b: self.state.b,
            drift: self.state.drift,
            at: self
                .place_of
                .iter()
                .map(|place| place.map(|place| self.state.at[place]))
                .collect(),
        }
    }

    /// Variance of hᵀ(M, b, drift of b).
    pub fn variance(&self, h: &[f64; 15]) -> Option<f64> {
        let values = self.covariance.values.as_ref()?;
        let at = |i: usize| h[self.model.list()[i]];
        let row = |i: usize| (0..values.len()).map(|j| values[i][j] * at(j)).sum::<f64>();
        Some((0..values.len()).map(|i| at(i) * row(i)).sum())
    }

    /// Standard deviations of the drift of b; infinite without a covariance.
    pub fn drift_deviations(&self) -> [f64; 3] {
        std::array::from_fn(|i| {
            let mut h = [0.0; 15];
            h[12 + i] = 1.0;
            self.variance(&h).map_or(f64::INFINITY, f64::sqrt)
        })
    }

    /// Specific force that a pose reads, times a rotation where no faces hold the frame.
    pub fn force(&self, inverse: &[[f64; 3]; 3], pose: &Pose) -> [f64; 3] {
        let offset = self.state.offset(pose.warmer_c);
        matrix3::mul_vec(inverse, &matrix3::sub(&pose.mean, &offset))
    }

    /// The twelve by twelve covariance; zero for what the convention fixes.
    pub fn full_covariance(&self) -> Option<[[f64; 12]; 12]> {
        let values = self.covariance.values.as_ref()?;
        Some(self.model.twelve(|i, j| values[i][j]))
    }
}
