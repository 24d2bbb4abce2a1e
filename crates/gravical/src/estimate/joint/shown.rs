//! What the residuals show of an error of each placement.

use gravical_core::matrix3;
use nalgebra::DMatrix;

use crate::estimate::reliability::{PoseTest, Reliability};
use crate::estimate::solve::Problem;

use super::fit::Fit;
use super::model::Rows;

/// Every placement that was fitted, with its rows reduced to the shared parameters. None
/// without a covariance.
pub(super) fn tests(found: &Fit, chi2_per_freedom: f64) -> Option<Reliability> {
    let covariance = found.full_covariance()?;
    let model = &found.model;
    // Of hundreds of poses over a range of temperature one hardly moves the drift.
    let elements = model.elements.list();
    let p = model.shared();
    let mut tests = Vec::new();
    let members = found.members();
    for (block, place) in model.places.iter().enumerate() {
        let Rows {
            residuals,
            shared,
            local,
        } = model.rows(&found.state, block);
        // A mean that is 1 m/s² too long.
        let force = matrix3::mul_vec(&found.state.m, &model.direction(&found.state, block));
        let members = &members[block];
        let longer = DMatrix::from_fn(residuals.len(), members.len(), |row, of| {
            match place.readings.get(row / 3) {
                Some(reading) if row / 3 == of => -force[row % 3] / reading.sd[row % 3],
                _ => 0.0,
            }
        });
        let mut rows = shared.resize_horizontally(p + 1 + members.len(), 0.0);
        rows.set_column(p, &residuals);
        rows.columns_mut(p + 1, members.len()).copy_from(&longer);
        let q = local.ncols();
        if q > 0 {
            local.qr().q_tr_mul(&mut rows);
        }
        let rows = rows.remove_rows(0, q);
        for (of, &pose) in members.iter().enumerate() {
            let d = rows.column(p + 1 + of);
            let mut influence = [0.0; 12];
            for (column, &element) in elements.iter().enumerate() {
                influence[element] = rows.column(column).dot(&d);
            }
            tests.push(PoseTest {
                pose,
                influence,
                weight: d.norm_squared(),
                misfit: rows.column(p).dot(&d),
            });
        }
    }
    Some(Reliability {
        covariance,
        tests,
        freedom: found.freedom,
        chi2_per_freedom,
    })
}
