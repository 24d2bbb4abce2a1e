//! What the covariance consists of.

use nalgebra::{DMatrix, DVector};

use crate::estimate::solve::Problem;

use super::fit::{Fit, Pose};
use super::model::Rows;

/// Where uncertainty of the parameters comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Noise of the means.
    Noise,
    /// Steps of the converter.
    Quantisation,
    /// What the readings miss the model by beyond that.
    ModelError,
    /// Tilts of the faces.
    Tilt,
    /// What only the data sheet says.
    DataSheet,
}

/// Covariance of (M, b) by source; their sum is the covariance.
///
/// With whitened residuals of unit variance the estimate is
/// x̂ = −Σ C Jᵀ(I − P) r over all rows, P the projector on a block's own local
/// columns; so every row gives the outer product of its column, and a reading's
/// row is divided in the proportion of its variances.
pub(super) fn by_source(
    work: &[Pose],
    found: &Fit,
    quantisation: [f64; 3],
    model_error: f64,
) -> Option<Vec<(Source, [[f64; 12]; 12])>> {
    let values = found.covariance.values.as_ref()?;
    let model = &found.model;
    let p = model.shared();
    let c = DMatrix::from_fn(p, p, |i, j| values[i][j]);
    let all = [
        Source::Noise,
        Source::Quantisation,
        Source::ModelError,
        Source::Tilt,
        Source::DataSheet,
    ];
    let mut sums: Vec<DMatrix<f64>> = vec![DMatrix::zeros(p, p); all.len()];
    let members = found.members();
    for block in 0..model.blocks() {
        let Rows {
            shared: mut rows,
            local,
            ..
        } = model.rows(&found.state, block);
        let m = rows.nrows();
        if local.ncols() > 0 {
            let basis = local.qr().q();
            rows -= &basis * basis.tr_mul(&rows);
        }
        let columns: DMatrix<f64> = &c * rows.transpose();
        let members = members.get(block).map_or(&[][..], Vec::as_slice);
        for row in 0..m {
            let column: DVector<f64> = columns.column(row).into_owned();
            let mut add = |source: usize, share: f64| {
                if share > 0.0 {
                    sums[source].ger(share, &column, &column, 1.0);
                }
            };
            if block == model.places.len() {
                add(4, 1.0);
            } else if row >= 3 * members.len() {
                add(3, 1.0);
            } else {
                let axis = row % 3;
                let known = work[members[row / 3]].sd[axis].powi(2);
                let steps = quantisation[axis].powi(2).min(known);
                // The scatter of repeats about their tilt is what is left.
                let total = match model.places[block].face {
                    Some(_) => model.places[block].readings[row / 3].sd[axis].powi(2),
                    None => known + model_error.powi(2),
                };
                add(0, (known - steps) / total);
                add(1, steps / total);
                add(2, model_error.powi(2) / total);
                add(3, 1.0 - (known + model_error.powi(2)) / total);
            }
        }
    }
    Some(
        all.into_iter()
            .zip(sums)
            .map(|(source, sum)| (source, model.twelve(|i, j| sum[(i, j)])))
            .collect(),
    )
}
