//! Residuals of the motions, made linear once and then cheap: the motions one by
//! one with a robust loss, and in chains that know how neighbours hang
//! together.

use gravical_core::matrix3;
use nalgebra::{DMatrix, Matrix2x3, Matrix3, SMatrix, SVector, Vector3};

use super::integrate::turned;
use super::motions::{Motion, Motions};
use crate::estimate::solve::{Jacobian, Loss, Problem, Shape};

type Matrix = [[f64; 3]; 3];

/// Number of parameters: nine of E, three of β.
pub(super) const PARAMETERS: usize = 12;

/// A step of all parameters.
pub(super) type Delta = SVector<f64, PARAMETERS>;

/// ω = E (y − β).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct State {
    /// Near the identity: what is left to the nominal scale.
    pub e: Matrix,
    /// Bias that the stills do not show, rad/s by the nominal scale.
    pub beta: [f64; 3],
}

impl State {
    /// Nominal.
    pub(super) fn start() -> State {
        State {
            e: matrix3::identity(),
            beta: [0.0; 3],
        }
    }

    pub(super) fn moved(&self, step: &Delta) -> State {
        let mut next = *self;
        for r in 0..3 {
            for c in 0..3 {
                next.e[r][c] += step[3 * r + c];
            }
            next.beta[r] += step[9 + r];
        }
        next
    }
}

/// A motion's residual, its derivatives, and the rotation from the sensor
/// before to the sensor after.
#[derive(Debug, Clone)]
pub(super) struct Linear {
    /// Gravity as it was, turned into the sensor after the motion, less gravity as it is there.
    pub residual: Vector3<f64>,
    pub jacobian: SMatrix<f64, 3, PARAMETERS>,
    pub rotation: Matrix3<f64>,
}

impl Linear {
    /// dr = C (v₀ × ψ), C the rotation, ψ the turn seen from the start.
    pub(super) fn of(motions: &Motions, motion: &Motion, state: &State) -> Linear {
        let samples = &motions.samples[motion.samples.clone()];
        let at = turned(samples, &state.e, state.beta);
        // nalgebra's arrays are columns: this is the transpose already.
        let rotation = Matrix3::from(at.attitude);
        let before = Vector3::from(motion.gravity[0]);
        let by_turn = rotation * before.cross_matrix();
        let time = at.sums.map(|row| row.map(|s| s[3]));
        let by_bias = matrix3::mul(&time, &state.e);
        let mut jacobian = SMatrix::zeros();
        for i in 0..3 {
            for r in 0..3 {
                for c in 0..3 {
                    jacobian[(i, 3 * r + c)] =
                        (0..3).map(|k| by_turn[(i, k)] * at.sums[k][r][c]).sum();
                }
                jacobian[(i, 9 + r)] =
                    -(0..3).map(|k| by_turn[(i, k)] * by_bias[k][r]).sum::<f64>();
            }
        }
        Linear {
            residual: rotation * before - Vector3::from(motion.gravity[1]),
            jacobian,
            rotation,
        }
    }

    /// All motions at a state: one pass over the samples.
    pub(super) fn all(motions: &Motions, state: &State) -> Vec<Linear> {
        motions
            .list
            .iter()
            .map(|m| Linear::of(motions, m, state))
            .collect()
    }

    /// The residual after a step, as far as it is linear.
    pub(super) fn after(&self, step: &Delta) -> Vector3<f64> {
        self.residual + self.jacobian * step
    }
}

/// Holds β, which was `beta` where the step begins, to the stills.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    pub beta: [f64; 3],
    pub sigma: [f64; 3],
}

impl Prior {
    fn evaluate(&self, step: &Delta, out: &mut [f64], j: Option<Jacobian<'_>>) {
        for i in 0..3 {
            out[i] = (self.beta[i] + step[9 + i]) / self.sigma[i];
        }
        if let Some(j) = j {
            for i in 0..3 {
                j.shared[PARAMETERS * i + 9 + i] = self.sigma[i].recip();
            }
        }
    }
}

/// Every motion by itself: 3 residuals each over its standard deviation, and a
/// robust loss; the prior last.
pub(super) struct Alone<'a> {
    pub linear: &'a [Linear],
    /// Standard deviation of a component of each residual.
    pub sigma: &'a [f64],
    pub prior: Prior,
    pub loss: Loss,
}

impl Problem for Alone<'_> {
    type State = Delta;

    fn shared(&self) -> usize {
        PARAMETERS
    }

    fn blocks(&self) -> usize {
        self.linear.len() + 1
    }

    fn shape(&self, _block: usize) -> Shape {
        Shape {
            residuals: 3,
            local: 0,
        }
    }

    fn evaluate(&self, step: &Delta, block: usize, out: &mut [f64], j: Option<Jacobian<'_>>) {
        let Some(linear) = self.linear.get(block) else {
            return self.prior.evaluate(step, out, j);
        };
        let sigma = self.sigma[block];
        let r = linear.after(step);
        (0..3).for_each(|i| out[i] = r[i] / sigma);
        if let Some(j) = j {
            for i in 0..3 {
                for p in 0..PARAMETERS {
                    j.shared[PARAMETERS * i + p] = linear.jacobian[(i, p)] / sigma;
                }
            }
        }
    }

    fn moved(&self, state: &Delta, shared: &[f64], _local: &[f64]) -> Delta {
        state + Delta::from_column_slice(shared)
    }

    fn loss(&self, block: usize) -> Loss {
        if block < self.linear.len() {
            self.loss
        } else {
            Loss::Squared
        }
    }
}

/// Motions one after the other: the noise of a still's direction is in the
/// residual before it and in the one after it, with opposite signs.
struct Chain {
    /// Residuals over the root of their covariance, two for every motion.
    residual: DMatrix<f64>,
    /// Their derivatives.
    jacobian: DMatrix<f64>,
}

/// Longest chain: the covariance is dense, and what one still contributes is
/// soon forgotten.
const LONGEST_CHAIN: usize = 32;

/// Two unit vectors that make a frame with `v`.
fn across(v: Vector3<f64>) -> Matrix2x3<f64> {
    let first = v.cross(&Vector3::ith(v.iamin(), 1.0)).normalize();
    let second = v.cross(&first);
    Matrix2x3::from_rows(&[first.transpose(), second.transpose()])
}

/// Motions in chains: generalised least squares.
pub(super) struct Chained {
    chains: Vec<Chain>,
    prior: Prior,
}

impl Chained {
    /// Chains of the motions that are kept. `spread[still]` is the covariance
    /// of a still's direction, `own[motion]` the variance of what a motion
    /// adds. None when a covariance is none.
    pub(super) fn new(
        motions: &Motions,
        linear: &[Linear],
        kept: &[usize],
        spread: &[Matrix3<f64>],
        own: &[f64],
        prior: Prior,
    ) -> Option<Chained> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for &m in kept {
            let follows = groups
                .last()
                .and_then(|g| g.last())
                .is_some_and(|&before| motions.list[before].still + 1 == motions.list[m].still);
            match groups.last_mut() {
                Some(group) if follows && group.len() < LONGEST_CHAIN => group.push(m),
                _ => groups.push(vec![m]),
            }
        }
        let chains: Option<Vec<Chain>> = groups
            .iter()
            .map(|group| chain(motions, linear, group, spread, own))
            .collect();
        Some(Chained {
            chains: chains?,
            prior,
        })
    }
}

fn chain(
    motions: &Motions,
    linear: &[Linear],
    group: &[usize],
    spread: &[Matrix3<f64>],
    own: &[f64],
) -> Option<Chain> {
    let n = 2 * group.len();
    let mut covariance = DMatrix::zeros(n, n);
    let mut residual = DMatrix::zeros(n, 1);
    let mut jacobian = DMatrix::zeros(n, PARAMETERS);
    let mut before: Option<Matrix2x3<f64>> = None;
    for (i, &m) in group.iter().enumerate() {
        let at = 2 * i;
        let still = motions.list[m].still;
        let c = linear[m].rotation;
        let t = across(Vector3::from(motions.list[m].gravity[1]));
        let ends = c * spread[still] * c.transpose() + spread[still + 1];
        let mut block = t * ends * t.transpose();
        block[(0, 0)] += own[m];
        block[(1, 1)] += own[m];
        covariance.view_mut((at, at), (2, 2)).copy_from(&block);
        if let Some(earlier) = before {
            // −e of the still is in the one before, C e in this one.
            let shared = -(earlier * spread[still] * c.transpose() * t.transpose());
            covariance.view_mut((at - 2, at), (2, 2)).copy_from(&shared);
            covariance
                .view_mut((at, at - 2), (2, 2))
                .copy_from(&shared.transpose());
        }
        before = Some(t);
        residual
            .view_mut((at, 0), (2, 1))
            .copy_from(&(t * linear[m].residual));
        jacobian
            .view_mut((at, 0), (2, PARAMETERS))
            .copy_from(&(t * linear[m].jacobian));
    }
    let root = covariance.cholesky()?.unpack();
    let solved = root.solve_lower_triangular_mut(&mut residual)
        && root.solve_lower_triangular_mut(&mut jacobian);
    solved.then_some(Chain { residual, jacobian })
}

impl Problem for Chained {
    type State = Delta;

    fn shared(&self) -> usize {
        PARAMETERS
    }

    fn blocks(&self) -> usize {
        self.chains.len() + 1
    }

    fn shape(&self, block: usize) -> Shape {
        Shape {
            residuals: self.chains.get(block).map_or(3, |c| c.residual.nrows()),
            local: 0,
        }
    }

    fn evaluate(&self, step: &Delta, block: usize, out: &mut [f64], j: Option<Jacobian<'_>>) {
        let Some(chain) = self.chains.get(block) else {
            return self.prior.evaluate(step, out, j);
        };
        let moved = &chain.jacobian * step;
        for (i, r) in out.iter_mut().enumerate() {
            *r = chain.residual[(i, 0)] + moved[i];
        }
        if let Some(j) = j {
            for i in 0..chain.jacobian.nrows() {
                for p in 0..PARAMETERS {
                    j.shared[PARAMETERS * i + p] = chain.jacobian[(i, p)];
                }
            }
        }
    }

    fn moved(&self, state: &Delta, shared: &[f64], _local: &[f64]) -> Delta {
        state + Delta::from_column_slice(shared)
    }
}
