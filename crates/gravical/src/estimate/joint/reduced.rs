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
    /// R of all rows, and of every block BᵀB and Bᵀr with B = A R⁻¹: where Σ BᵀB = I, a
    /// sum of squares loses no digits.
    whole: Option<(DMatrix<f64>, Vec<DMatrix<f64>>)>,
}

impl Reduced {
    pub fn new(found: &Fit) -> Reduced {
        let model = &found.model;
        let p = model.shared();
        let blocks: Vec<DMatrix<f64>> = (0..model.blocks())
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
        let upper = Triangle::of(&blocks, p).rows.columns(0, p).into_owned();
        let gram = |block: &DMatrix<f64>| {
            let mut whitened = block.transpose();
            let solved = upper.tr_solve_upper_triangular(&whitened.rows(0, p))?;
            whitened.rows_mut(0, p).copy_from(&solved);
            Some(solved * whitened.transpose())
        };
        let grams: Option<Vec<DMatrix<f64>>> = blocks.iter().map(gram).collect();
        Reduced {
            places: model.places.len(),
            shared: p,
            whole: grams.map(|grams| (upper, grams)),
            blocks,
        }
    }

    /// Cost that would be lost without a place, eᵀ(I − H)⁻¹e, and the degrees of
    /// freedom that go with it, tr(I − H); H = A C Aᵀ = B Bᵀ with the covariance C of
    /// the shared parameters, and (I − B Bᵀ)⁻¹ = I + B(I − BᵀB)⁻¹Bᵀ. None when the place
    /// alone determines something.
    pub fn deletion(&self, place: usize) -> Option<(f64, f64)> {
        let p = self.shared;
        let gram = &self.whole.as_ref()?.1[place];
        let rows = &self.blocks[place];
        let squares = gram.columns(0, p);
        let along = gram.column(p);
        let rest = DMatrix::identity(p, p) - squares;
        let lost = rows.column(p).norm_squared() + along.dot(&rest.cholesky()?.solve(&along));
        Some((lost, rows.nrows() as f64 - squares.trace()))
    }

    /// Condition of all places together, without the prior.
    pub fn condition(&self) -> f64 {
        Triangle::of(&self.blocks[..self.places], self.shared).condition()
    }

    /// The triangles of all places but those that are `gone`, without the prior and with
    /// it; none where they leave a parameter open.
    pub fn without(&self, gone: &[bool]) -> Option<[Triangle; 2]> {
        let (upper, grams) = self.whole.as_ref()?;
        let p = self.shared;
        let mut sum = DMatrix::zeros(p, p + 1);
        for (gram, _) in grams.iter().zip(gone).filter(|(_, gone)| !**gone) {
            sum += gram;
        }
        let triangle = |sum: &DMatrix<f64>| {
            let l = sum.columns(0, p).into_owned().cholesky()?.l();
            let right = l.solve_lower_triangular(&sum.column(p))?;
            let mut rows = (l.transpose() * upper).insert_column(p, 0.0);
            rows.set_column(p, &right);
            Some(Triangle { rows, shared: p })
        };
        let bare = triangle(&sum)?;
        for prior in &grams[self.places..] {
            sum += prior;
        }
        Some([bare, triangle(&sum)?])
    }
}

/// R of the rows' QR decomposition, the residual as the last column.
pub(super) struct Triangle {
    rows: DMatrix<f64>,
    shared: usize,
}

impl Triangle {
    fn of(blocks: &[DMatrix<f64>], shared: usize) -> Triangle {
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
