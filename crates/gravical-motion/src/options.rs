//! What is known of the sensor, and how its motion is estimated.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{Matrix3, Vector3};

/// One independent direction of the accelerometer's uncertainty, one standard deviation long:
/// δf = matrix · f + offset.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ForceDirection {
    /// Scale and cross-axis sensitivity, row-major.
    pub matrix: [[f64; 3]; 3],
    /// Bias, m/s².
    pub offset: [f64; 3],
}

/// How far the calibration may be off.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationUncertainty {
    /// Of the accelerometer; the first twelve count.
    pub force: Vec<ForceDirection>,
    /// Of the gyroscope likewise, δω = matrix · ω; the first nine count.
    pub rate: Vec<[[f64; 3]; 3]>,
    /// Standard deviation of a bias of the accelerometer beyond `force`, m/s².
    pub force_bias_sd_mps2: f64,
    /// Standard deviation of the magnitude at the first rest against gravity, m/s²: that of gravity, and what
    /// the calibration leaves of the magnitude.
    pub gravity_sd_mps2: f64,
}

/// Parameters of the accelerometer and of the gyroscope.
const FORCE_DIRECTIONS: usize = 12;
const RATE_DIRECTIONS: usize = 9;

fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from(*rows).transpose()
}

impl CalibrationUncertainty {
    /// δf = matrix · f + offset for one standard deviation.
    pub(crate) fn force_directions(&self) -> impl Iterator<Item = (Matrix3<f64>, Vector3<f64>)> {
        let force = self.force.iter().take(FORCE_DIRECTIONS);
        force.map(|d| (matrix(&d.matrix), Vector3::from(d.offset)))
    }

    /// δω = matrix · ω.
    pub(crate) fn rate_directions(&self) -> impl Iterator<Item = Matrix3<f64>> {
        self.rate.iter().take(RATE_DIRECTIONS).map(matrix)
    }

    /// Relative error of a rate, for each axis of the error.
    pub(crate) fn rate_sd(&self) -> f64 {
        let squares: f64 = self.rate_directions().map(|m| m.norm_squared()).sum();
        // A rate along one axis meets three of nine elements, one for each axis of its error.
        squares.sqrt() / 3.0
    }
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
    /// Directions of a gyroscope's uncertainty: nine, one for each element of the matrix, row by row.
    #[must_use]
    pub fn matrices(&self) -> Vec<[[f64; 3]; 3]> {
        let matrix = |k: usize| {
            let mut matrix = [[0.0; 3]; 3];
            // Every fourth one is on the diagonal.
            matrix[k / 3][k % 3] = if k.is_multiple_of(4) {
                self.scale
            } else {
                self.cross
            };
            matrix
        };
        (0..9).map(matrix).collect()
    }

    /// Directions of an accelerometer's: the same, and three biases.
    #[must_use]
    pub fn directions(&self) -> Vec<ForceDirection> {
        let matrices = self.matrices().into_iter().map(|matrix| ForceDirection {
            matrix,
            ..ForceDirection::default()
        });
        let biases = (0..3).map(|axis| {
            let mut bias = ForceDirection::default();
            bias.offset[axis] = self.bias_mps2;
            bias
        });
        matrices.chain(biases).collect()
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
            force: errors(2e-4, 2e-3).directions(),
            rate: errors(0.02, 0.0).matrices(),
            force_bias_sd_mps2: 1e-3,
            gravity_sd_mps2: 0.05,
        }
    }
}

/// How motion is estimated.
#[derive(Debug, Clone)]
pub struct MotionOptions {
    /// How far the calibration may be off.
    pub calibration: CalibrationUncertainty,
    /// Moments of a walking foot between its swings have no velocity.
    pub stances: bool,
    /// Rests that are known, as spans of samples in order; none: they are looked for.
    pub rests: Option<Vec<Range<usize>>>,
    /// Use the past only: no smoother. The path of a closed move, and its bands, are those after its end: a second
    /// into the rest that closes it, the noise of the whole move is known. Rests are looked for.
    pub causal: bool,
    /// Ends the estimate where it is once this is true, from another thread: what there is then is of no use.
    pub stopped: Option<Arc<AtomicBool>>,
}

impl MotionOptions {
    pub(crate) fn is_stopped(&self) -> bool {
        let stopped = self.stopped.as_ref();
        stopped.is_some_and(|stopped| stopped.load(Ordering::Relaxed))
    }

    /// Nothing is negative or no number, and a causal run looks for rests.
    pub(crate) fn are_possible(&self) -> bool {
        let known = &self.calibration;
        let sizes = [known.force_bias_sd_mps2, known.gravity_sd_mps2];
        let force = known.force.iter();
        let force = force.flat_map(|d| d.matrix.as_flattened().iter().chain(&d.offset));
        let rate = known.rate.iter().flat_map(|m| m.as_flattened());
        let is_size = |v: &f64| v.is_finite() && *v >= 0.0;
        !(self.causal && self.rests.is_some())
            && sizes.iter().all(is_size)
            && force.chain(rate).all(|v| v.is_finite())
    }
}

impl Default for MotionOptions {
    fn default() -> Self {
        MotionOptions {
            calibration: CalibrationUncertainty::default(),
            stances: true,
            rests: None,
            causal: false,
            stopped: None,
        }
    }
}
