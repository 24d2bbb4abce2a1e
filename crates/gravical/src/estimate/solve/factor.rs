//! A problem made linear and factored: Q R of every block's local columns, then
//! of what is left.

use nalgebra::{DMatrix, DVector};

use super::{Jacobian, Problem, Shape};

/// A column of R shorter than this share of the column before elimination is
/// not determined by the residuals.
const RANK_TOLERANCE: f64 = 1e-10;

/// Singular values are found to this, relative to the largest.
const SVD_TOLERANCE: f64 = 5.0 * f64::EPSILON;
/// … or given up after so many sweeps: without a limit a value that is no
/// number would never end.
const MOST_SWEEPS: usize = 1000;

/// Singular values, largest first; none when they are not found.
pub(crate) fn singular_values(matrix: DMatrix<f64>) -> Option<DVector<f64>> {
    let svd = matrix.try_svd(false, false, SVD_TOLERANCE, MOST_SWEEPS)?;
    let values = svd.singular_values;
    values.iter().all(|v| v.is_finite()).then_some(values)
}

/// A block after elimination, q rows: an upper triangle of the local columns,
/// then the shared ones, then the residual.
#[derive(Debug, Clone)]
struct Local {
    rows: DMatrix<f64>,
}

type View<'a> = nalgebra::DMatrixView<'a, f64>;

impl Local {
    fn upper(&self) -> View<'_> {
        self.rows.columns(0, self.rows.nrows())
    }

    fn coupling(&self) -> View<'_> {
        let q = self.rows.nrows();
        self.rows.columns(q, self.rows.ncols() - q - 1)
    }

    fn right(&self) -> View<'_> {
        self.rows.columns(self.rows.ncols() - 1, 1)
    }
}

/// Clears the first `count` of the columns, `height` rows each, below their
/// diagonal, by Householder reflections of all columns.
fn triangulate(columns: &mut [f64], height: usize, count: usize) {
    for k in 0..count.min(height) {
        let (done, others) = columns.split_at_mut((k + 1) * height);
        let own = &mut done[k * height + k..];
        let length = own.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length == 0.0 {
            continue;
        }
        // Reflected to the side away from it: no difference of near numbers.
        let diagonal = -length.copysign(own[0]);
        own[0] -= diagonal;
        let twice_over_square = -1.0 / (diagonal * own[0]);
        for other in others.chunks_exact_mut(height) {
            let other = &mut other[k..];
            let along: f64 = own.iter().zip(other.iter()).map(|(a, b)| a * b).sum();
            let share = twice_over_square * along;
            for (x, v) in other.iter_mut().zip(own.iter()) {
                *x -= share * v;
            }
        }
        own.fill(0.0);
        own[0] = diagonal;
    }
}

/// A linearised problem, factored: local parameters eliminated, shared ones in
/// an upper triangle.
#[derive(Debug, Clone)]
pub struct Factor {
    locals: Vec<Local>,
    /// p × p, upper triangular, columns divided by `scale`.
    upper: DMatrix<f64>,
    right: DVector<f64>,
    /// Length of every shared column.
    scale: DVector<f64>,
    cost: f64,
    /// Length of the residuals, weights applied.
    length: f64,
    local_gradient: f64,
}

/// Covariance of the shared parameters, and how well they are determined.
#[derive(Debug, Clone, PartialEq)]
pub struct Covariance {
    /// p × p, row-major; none when the rank is not full.
    pub values: Option<Vec<Vec<f64>>>,
    /// How many directions of the parameters the residuals determine.
    pub rank: usize,
    /// Largest over smallest singular value of the Jacobian with columns of
    /// length one; infinite without full rank.
    pub condition: f64,
}

impl Factor {
    /// Linearises `problem` at `state`; none when something is not finite.
    #[must_use]
    pub fn new<P: Problem>(problem: &P, state: &P::State) -> Option<Factor> {
        let p = problem.shared();
        let shapes: Vec<Shape> = (0..problem.blocks()).map(|b| problem.shape(b)).collect();
        let rows: usize = shapes.iter().map(|s| s.residuals - s.local).sum();
        // At least p rows, so that R is square.
        let height = rows.max(p);
        let mut stacked = DMatrix::zeros(height, p + 1);
        let mut locals = Vec::with_capacity(shapes.len());
        let (mut cost, mut squares, mut at) = (0.0, 0.0, 0);
        let mut local_gradient = 0.0_f64;
        let (mut residuals, mut shared, mut local) = (Vec::new(), Vec::new(), Vec::new());
        let mut columns = Vec::new();
        for (block, shape) in shapes.iter().enumerate() {
            let (m, q) = (shape.residuals, shape.local);
            residuals.clear();
            residuals.resize(m, 0.0);
            shared.clear();
            shared.resize(m * p, 0.0);
            local.clear();
            local.resize(m * q, 0.0);
            let jacobian = Jacobian {
                shared: &mut shared,
                local: &mut local,
            };
            problem.evaluate(state, block, &mut residuals, Some(jacobian));
            let finite = |v: &[f64]| v.iter().all(|x| x.is_finite());
            if !(finite(&residuals) && finite(&shared) && finite(&local)) {
                return None;
            }
            let square: f64 = residuals.iter().map(|r| r * r).sum();
            let (rho, slope) = problem.loss(block).of(square);
            cost += rho;
            squares += slope * square;
            let weight = slope.sqrt();
            columns.clear();
            for j in 0..q {
                columns.extend((0..m).map(|i| weight * local[i * q + j]));
            }
            for j in 0..p {
                columns.extend((0..m).map(|i| weight * shared[i * p + j]));
            }
            columns.extend(residuals.iter().map(|r| weight * r));
            triangulate(&mut columns, m, q);
            let below = columns.chunks_exact(m.max(1)).skip(q);
            for (column, all) in below.zip(stacked.as_mut_slice().chunks_exact_mut(height)) {
                all[at..at + m - q].copy_from_slice(&column[q..]);
            }
            at += m - q;
            if q == 0 {
                continue;
            }
            let rows = DMatrix::from_fn(q, q + p + 1, |i, j| columns[j * m + i]);
            let own = Local { rows };
            // Cosine of the residuals with what the local columns span.
            if square > 0.0 {
                let length = (slope * square).sqrt().max(1e-300);
                local_gradient = local_gradient.max(own.right().norm() / length);
            }
            locals.push(own);
        }
        let scale = DVector::from_fn(p, |j, _| {
            let length = stacked.column(j).norm();
            if length > 0.0 { length } else { 1.0 }
        });
        for j in 0..p {
            stacked.column_mut(j).unscale_mut(scale[j]);
        }
        triangulate(stacked.as_mut_slice(), height, p);
        let upper = stacked.view((0, 0), (p, p)).into_owned();
        let right = stacked.view((0, p), (p, 1)).column(0).into_owned();
        // Squares of finite numbers may not be.
        if !(cost.is_finite() && upper.iter().chain(&right).all(|v| v.is_finite())) {
            return None;
        }
        Some(Factor {
            locals,
            upper,
            right,
            scale,
            cost,
            length: squares.sqrt(),
            local_gradient,
        })
    }

    /// Sum of squares, losses applied.
    #[must_use]
    pub fn cost(&self) -> f64 {
        self.cost
    }

    /// Largest cosine between the residuals and a column.
    pub(super) fn gradient(&self) -> f64 {
        if self.length == 0.0 {
            return 0.0;
        }
        let shared = (self.upper.tr_mul(&self.right)).amax() / self.length;
        shared.max(self.local_gradient)
    }

    /// Raises `longest` to the lengths of the shared columns.
    pub(super) fn lengthen(&self, longest: &mut Vec<f64>) {
        longest.resize(self.scale.len(), 0.0);
        for (j, length) in longest.iter_mut().enumerate() {
            // An empty column has no length; the others are of length one here.
            if self.upper.column(j).norm_squared() > 0.5 {
                *length = length.max(self.scale[j]);
            }
        }
    }

    /// The step that minimises the linearised cost plus `damping` times the
    /// squared length of the shared step, each parameter in units of one over
    /// `longest`; with it the cost that the linearisation promises to lose, and
    /// the scaled length. None when the step is not finite: then a block does not
    /// determine its local parameters.
    pub(super) fn step(&self, damping: f64, longest: &[f64]) -> Option<Step> {
        let p = self.scale.len();
        let mut augmented = DMatrix::zeros(2 * p, p + 1);
        augmented.view_mut((0, 0), (p, p)).copy_from(&self.upper);
        augmented.view_mut((0, p), (p, 1)).copy_from(&self.right);
        let mut damped = DVector::zeros(p);
        for j in 0..p {
            let ratio = if longest[j] > 0.0 {
                longest[j] / self.scale[j]
            } else {
                1.0
            };
            damped[j] = damping.sqrt() * ratio;
            augmented[(p + j, j)] = damped[j];
        }
        triangulate(augmented.as_mut_slice(), 2 * p, p);
        let right = augmented.view((0, p), (p, 1)).column(0).into_owned();
        let scaled = -augmented
            .view((0, 0), (p, p))
            .solve_upper_triangular(&right)?;
        let shared = scaled.component_div(&self.scale);
        let mut local = Vec::new();
        let mut promised = 0.0;
        let mut length = scaled.norm_squared();
        for block in &self.locals {
            let right = -(block.right() + block.coupling() * &shared);
            let own = block.upper().solve_upper_triangular(&right)?;
            for (column, step) in block.upper().column_iter().zip(own.iter()) {
                length += column.norm_squared() * step * step;
            }
            local.extend(own.iter());
            promised += block.right().norm_squared();
        }
        // ‖r‖² − ‖r + Js‖² for this s, without the cancellation.
        promised += (&self.upper * &scaled).norm_squared()
            + 2.0 * damped.component_mul(&scaled).norm_squared();
        let finite = shared.iter().chain(&local).all(|v| v.is_finite());
        finite.then(|| Step {
            shared: shared.as_slice().to_vec(),
            local,
            promised,
            length: length.sqrt(),
        })
    }

    /// Rank, condition and covariance (unit weight) of the shared parameters,
    /// the local ones marginalised.
    #[must_use]
    pub fn covariance(&self) -> Covariance {
        let p = self.scale.len();
        let Some(values) = singular_values(self.upper.clone()) else {
            return Covariance {
                values: None,
                rank: 0,
                condition: f64::INFINITY,
            };
        };
        let (largest, smallest) = (values.max(), values.min());
        let rank = (values.iter())
            .filter(|v| **v > RANK_TOLERANCE * largest)
            .count();
        let full = rank == p;
        let inverse = self
            .upper
            .solve_upper_triangular(&DMatrix::identity(p, p))
            .filter(|_| full);
        let values_out = inverse.map(|inverse| {
            let half = DMatrix::from_fn(p, p, |i, j| inverse[(i, j)] / self.scale[i]);
            let c = &half * half.transpose();
            (0..p)
                .map(|i| (0..p).map(|j| c[(i, j)]).collect())
                .collect()
        });
        Covariance {
            rank,
            condition: if full {
                largest / smallest
            } else {
                f64::INFINITY
            },
            values: values_out,
        }
    }

    /// Covariance of the local parameters of the `nth` block that has some,
    /// row-major q × q, the shared ones marginalised. `shared` is the covariance
    /// of these. None where there are fewer such blocks.
    #[must_use]
    pub fn local_covariance(&self, nth: usize, shared: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
        let block = self.locals.get(nth)?;
        let p = self.scale.len();
        let c = DMatrix::from_fn(p, p, |i, j| shared[i][j]);
        let q = block.rows.nrows();
        let inverse = block
            .upper()
            .solve_upper_triangular(&DMatrix::identity(q, q))
            .unwrap_or_else(|| DMatrix::from_element(q, q, f64::INFINITY));
        let follows = &inverse * block.coupling();
        let total = &inverse * inverse.transpose() + &follows * &c * follows.transpose();
        let row = |i: usize| (0..q).map(|j| total[(i, j)]).collect();
        Some((0..q).map(row).collect())
    }
}

/// A step of all parameters.
pub(super) struct Step {
    pub shared: Vec<f64>,
    pub local: Vec<f64>,
    /// Cost that the linearisation says is lost.
    pub promised: f64,
    /// Length of the step, every parameter times the length of its column.
    pub length: f64,
}
