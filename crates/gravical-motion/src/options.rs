//! What is known of the sensor, and how its motion is estimated.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Covariance of the error δf = M f + o of a specific force: the nine elements of M (scale and cross-axis
/// sensitivity, row by row) and the bias o, m/s².
pub type ForceCovariance = SMatrix<f64, 12, 12>;
/// Covariance of the error δω = M ω of an angular rate: the nine elements of M, row by row.
pub type RateCovariance = SMatrix<f64, 9, 9>;

/// How far the calibration may be off.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationUncertainty {
    /// Of the accelerometer.
    pub force: ForceCovariance,
    /// Of the gyroscope.
    pub rate: RateCovariance,
    /// Standard deviation of the magnitude at the first rest against gravity, m/s²: that of gravity, and what
    /// the calibration leaves of the magnitude.
    pub gravity_sd_mps2: f64,
}

/// Independent errors of the elements of a calibration: their standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementErrors {
    /// Relative scale.
    pub scale: f64,
    /// Cross-axis terms.
    pub cross: f64,
    /// Bias, m/s².
    pub bias_mps2: f64,
}

impl ElementErrors {
    /// As a covariance of an accelerometer.
    pub fn force(&self) -> ForceCovariance {
        let sd = |k: usize| match k {
            0 | 4 | 8 => self.scale,
            1..9 => self.cross,
            _ => self.bias_mps2,
        };
        ForceCovariance::from_diagonal(&SVector::from_fn(|k, _| sd(k).powi(2)))
    }

    /// As one of a gyroscope.
    pub fn rate(&self) -> RateCovariance {
        self.force().fixed_view::<9, 9>(0, 0).into_owned()
    }
}

impl Default for CalibrationUncertainty {
    /// A calibrated accelerometer (0.02 %, 2 mm/s²) and a gyroscope by its data sheet (2 % in each element).
    fn default() -> Self {
        let errors = |sd: f64, bias_mps2: f64| ElementErrors {
            scale: sd,
            cross: sd,
            bias_mps2,
        };
        CalibrationUncertainty {
            force: errors(2e-4, 2e-3).force(),
            rate: errors(0.02, 0.0).rate(),
            gravity_sd_mps2: 0.05,
        }
    }
}

/// Independent directions of that uncertainty, one standard deviation long, in columns: of the elements of M, row by
/// row, and of o.
#[derive(Debug, Clone)]
pub(crate) struct Directions {
    /// δf = M f + o.
    pub force: SMatrix<f64, 12, 12>,
    /// δω = M ω.
    pub rate: SMatrix<f64, 9, 9>,
    /// Relative error of a rate, for each axis of the error.
    pub rate_sd: f64,
}

impl Directions {
    pub fn new(calibration: &CalibrationUncertainty) -> Directions {
        Directions {
            force: factor(&calibration.force),
            rate: factor(&calibration.rate),
            // A rate along one axis meets three of nine elements, one for each axis of its error.
            rate_sd: calibration.rate.trace().max(0.0).sqrt() / 3.0,
        }
    }
}

/// L with C = L Lᵀ, by the eigenvectors of the correlations: a covariance may be singular.
fn factor<const N: usize>(c: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let sd = DVector::from_fn(N, |i, _| c[(i, i)].max(0.0).sqrt());
    let unit = sd.map(|s| if s > 0.0 { s } else { 1.0 });
    let correlation = DMatrix::from_fn(N, N, |i, j| {
        0.5 * (c[(i, j)] + c[(j, i)]) / unit[i] / unit[j]
    });
    let eigen = correlation.symmetric_eigen();
    SMatrix::from_fn(|i, k| {
        eigen.eigenvectors[(i, k)] * sd[i] * eigen.eigenvalues[k].max(0.0).sqrt()
    })
}

/// How motion is estimated.
#[derive(Debug, Clone, Default)]
pub struct MotionOptions {
    /// How far the calibration may be off.
    pub calibration: CalibrationUncertainty,
    /// Stances of a walking foot are not used as zero-velocity updates.
    pub no_stances: bool,
    /// Rests that are known, as spans of samples in order; none: they are looked for.
    pub rests: Option<Vec<Range<usize>>>,
    /// Ends the estimate where it is once this is true, from another thread: what there is then is of no use.
    pub stopped: Option<Arc<AtomicBool>>,
}

impl MotionOptions {
    pub(crate) fn is_stopped(&self) -> bool {
        let stopped = self.stopped.as_ref();
        stopped.is_some_and(|stopped| stopped.load(Ordering::Relaxed))
    }

    /// Nothing is negative or no number.
    pub(crate) fn are_possible(&self) -> bool {
        let known = &self.calibration;
        (0.0..f64::INFINITY).contains(&known.gravity_sd_mps2)
            && known.force.iter().chain(&known.rate).all(|v| v.is_finite())
    }
}
