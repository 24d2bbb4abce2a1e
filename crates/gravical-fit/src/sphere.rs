//! The sphere on which readings at rest lie.

use gravical_core::matrix3::{dot, norm, sub};
use nalgebra::{DMatrix, DVector};

/// Deviation from a sphere that scale and misalignment make, of its radius, rms.
const MAX_DEVIATION: f64 = 0.05;
/// With a bias below this fraction of the radius the largest reading of a face pose is still on its own axis.
const MIN_CENTRE: f64 = 0.35;
/// A centre whose standard deviation exceeds this fraction of the radius is not used.
const MAX_CENTRE_SD: f64 = 0.1;

/// The sphere nearest to readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Unit of the readings.
    pub centre: [f64; 3],
    /// Standard deviation of the centre in the direction in which it is known least, if readings deviate by as
    /// much as those of a usual sensor may.
    centre_sd: f64,
    radius: f64,
    /// Deviation of the readings from it, of its radius, rms.
    deviation: f64,
}

impl Sphere {
    /// ‖u‖² = 2 c·u + d is linear in the centre c. `None` if the readings are too few or in a plane.
    pub fn nearest(readings: &[[f64; 3]]) -> Option<Sphere> {
        let squares = readings.iter().map(|u| dot(u, u));
        let right = DVector::from_iterator(readings.len(), squares);
        let left = DMatrix::from_fn(readings.len(), 4, |k, i| match i {
            3 => 1.0,
            _ => 2.0 * readings[k][i],
        });
        let normal = left.tr_mul(&left).cholesky()?;
        let x = normal.solve(&left.tr_mul(&right));
        let centre = [x[0], x[1], x[2]];
        let radius = (x[3] + dot(&centre, &centre)).sqrt();
        let off = |u: &[f64; 3]| norm(&sub(u, &centre)) / radius - 1.0;
        let sum: f64 = readings.iter().map(|u| off(u).powi(2)).sum();
        // ‖u − c‖² errs by 2 r times the error of ‖u − c‖.
        let variance = normal
            .inverse()
            .fixed_view::<3, 3>(0, 0)
            .symmetric_eigenvalues()
            .max();
        let sphere = Sphere {
            centre,
            centre_sd: 2.0 * MAX_DEVIATION * radius.powi(2) * variance.sqrt(),
            radius,
            deviation: (sum / readings.len() as f64).sqrt(),
        };
        sphere.deviation.is_finite().then_some(sphere)
    }

    /// True if readings of one sensor can lie so.
    pub fn is_near(&self) -> bool {
        self.deviation < MAX_DEVIATION
    }
}

/// The point from which the directions of mean readings are seen: the centre of their sphere if a bias moves
/// it so far that faces are mistaken; else, or if they do not determine it, zero.
pub fn centre<'a>(readings: impl IntoIterator<Item = &'a [f64; 3]>) -> [f64; 3] {
    let finite = readings.into_iter().filter(|u| norm(u).is_finite());
    let is_large = |sphere: &Sphere| {
        norm(&sphere.centre) > MIN_CENTRE * sphere.radius
            && sphere.centre_sd < MAX_CENTRE_SD * sphere.radius
    };
    let sphere = Sphere::nearest(&finite.copied().collect::<Vec<_>>());
    let sphere = sphere.filter(|sphere| sphere.is_near() && is_large(sphere));
    sphere.map_or([0.0; 3], |sphere| sphere.centre)
}
