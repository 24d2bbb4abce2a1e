//! What single places contribute to a fit, linearised at its minimum: what
//! would change without some of them, with no new search.

use nalgebra::{DMatrix, DVector};

use crate::estimate::observability::condition;
use crate::estimate::solve::Problem;

use super::fit::Fit;
use super::model::Rows;

/// Every block's rows once its own parameters (tilt, direction) are eliminated:
/// derivatives by the shared parameters, then the residual.
pub(super) struct Reduced {
    blocks: Vec<DMatrix<f64>>,
    places: usize,
    /// p
    shared: usize,
}

impl Reduced {
    pub fn new(found: &Fit) -> Reduced {
        let model = &found.model;
        let p = model.shared();
        let blocks = (0..model.blocks())
            .map(|block| {
                let Rows {
                    residuals,
                    shared,
                    local,
                } = model.rows(&found.state, block);
                let mut rows = shared.insert_column(p, 0.0);
                rows.set_column(p, &residuals);
                let q = local.ncols();
                if q > 0 {
                    local.qr().q_tr_mul(&mut rows);
                }
                rows.remove_rows(0, q)
            })
            .collect();
        Reduced {
            blocks,
            places: model.places.len(),
            shared: p,
        }
    }

    /// Cost that would be lost without a place, eᵀ(I − H)⁻¹e, and the degrees of
    /// freedom that go with it, tr(I − H); H = A C Aᵀ with the covariance C of
    /// the shared parameters. None when the place alone determines something.
    pub fn deletion(&self, place: usize, covariance: &[Vec<f64>]) -> Option<(f64, f64)> {
        let p = self.shared;
        let rows = &self.blocks[place];
        let c = DMatrix::from_fn(p, p, |i, j| covariance[i][j]);
        let a = rows.columns(0, p);
        let e: DVector<f64> = rows.column(p).into_owned();
        let rest = DMatrix::identity(rows.nrows(), rows.nrows()) - a * c * a.transpose();
        let freed = rest.trace();
        let lost = e.dot(&rest.cholesky()?.solve(&e));
        Some((lost, freed))
    }

    /// The triangle of all places but those that are `gone`, without the prior.
    pub fn without(&self, gone: &[bool]) -> Triangle {
        let kept = (0..self.places).filter(|&k| !gone[k]);
        Triangle::of(kept.map(|k| &self.blocks[k]), self.shared)
    }

    /// The same with the prior, if there is one.
    pub fn with_prior(&self, triangle: &Triangle) -> Triangle {
        let prior = self.blocks.get(self.places);
        Triangle::of(std::iter::once(&triangle.rows).chain(prior), self.shared)
    }
}

/// R of the rows' QR decomposition, the residual as the last column.
pub(super) struct Triangle {
    rows: DMatrix<f64>,
    shared: usize,
}

impl Triangle {
    fn of<'a>(blocks: impl Iterator<Item = &'a DMatrix<f64>>, shared: usize) -> Triangle {
        let blocks: Vec<&DMatrix<f64>> = blocks.collect();
        let height: usize = blocks.iter().map(|b| b.nrows()).sum();
        let mut all = DMatrix::zeros(height.max(shared + 1), shared + 1);
        let mut at = 0;
        for block in blocks {
            all.rows_mut(at, block.nrows()).copy_from(block);
            at += block.nrows();
        }
        let rows = all.qr().unpack_r().remove_row(shared);
        Triangle { rows, shared }
    }

    /// Largest over smallest singular value, columns of length one; infinite
    /// when a column is empty.
    pub fn condition(&self) -> f64 {
        condition(self.rows.columns(0, self.shared).into_owned())
    }

    /// hᵀ (RᵀR)⁻¹ h: the variance of hᵀx, x the shared parameters.
    pub fn variance(&self, h: &[f64]) -> Option<f64> {
        let upper = self.rows.columns(0, self.shared);
        let solved = upper.tr_solve_upper_triangular(&DVector::from_column_slice(h))?;
        Some(solved.norm_squared()).filter(|v| v.is_finite())
    }

    /// The step of the shared parameters to the minimum.
    pub fn step(&self) -> Option<Vec<f64>> {
        let upper = self.rows.columns(0, self.shared);
        let right = -self.rows.column(self.shared).into_owned();
        let step = upper.solve_upper_triangular(&right)?;
        step.iter()
            .all(|v| v.is_finite())
            .then(|| step.as_slice().to_vec())
    }
}
