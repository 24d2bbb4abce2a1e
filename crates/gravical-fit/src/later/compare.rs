//! Do two calibrations of one sensor differ?

use super::propagated;
use crate::consistent::{MAX_STEPS, Test, consistent};
use crate::model::{
    BENDS, Covariance, DIRECTIONS, Parameters, bias, invariants, matrix, sensitivity, sphere,
};
use crate::sensor::{Sensor, derivative_by_gravity};
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, SMatrix, UnitQuaternion, Vector3};

/// Rotation vector (rad) of Q in M_A⁻¹ M_B = Q P: what a_A = Q a_B turns by. None where one frame
/// is the mirror image of the other, or a matrix is singular.
fn turn(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Option<Vector3<f64>> {
    let t = a.try_inverse()? * b;
    let proper = t.iter().all(|v| v.is_finite()) && t.determinant() > 0.0;
    let svd = proper.then(|| t.try_svd(true, true, f64::EPSILON, MAX_STEPS))??;
    let q = Rotation3::from_matrix_unchecked(svd.u? * svd.v_t?);
    // By the quaternion: exact for the smallest turns, where a cosine is not.
    Some(UnitQuaternion::from_rotation_matrix(&q).scaled_axis())
}

/// A difference of two calibrations, the second less the first.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Its components.
    pub value: DVector<f64>,
    /// Their standard deviations by both covariances.
    pub sd: DVector<f64>,
    /// All together.
    pub test: Test,
}

impl Difference {
    /// `freedom`: residuals that the size of the covariance is known by.
    fn new(value: DVector<f64>, covariance: &DMatrix<f64>, freedom: f64) -> Difference {
        Difference {
            sd: covariance.diagonal().map(|v| v.max(0.0).sqrt()),
            test: consistent(&value, covariance).with_freedom(freedom),
            value,
        }
    }
}

/// Two calibrations of one sensor, the second less the first.
#[derive(Debug, Clone, PartialEq)]
pub struct Compare {
    /// The nine [`invariants`] of each, with the same bends.
    pub invariants: [DVector<f64>; 2],
    /// Their difference: what changes ‖a‖.
    pub magnitude: Difference,
    /// Rotation vector of the frame (rad); none where one frame is the mirror image of the other.
    pub turn: Option<Difference>,
    /// ‖a‖ by the second of what the first calls rest, less gravity, over the sphere.
    pub norm: NormDifference,
}

/// Difference of ‖a‖ between two calibrations, m/s².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormDifference {
    /// Root mean square over all directions.
    pub rms_mps2: f64,
    /// What the covariances predict for it.
    pub predicted_rms_mps2: f64,
    /// Where it is largest, with its sign.
    pub largest_mps2: f64,
    /// Direction of the largest difference, calibrated axes of the first.
    pub largest_at: Vector3<f64>,
}

/// Compares two calibrations of one sensor. None where a matrix is singular or a number is no
/// number.
///
/// Both have the same bends: the second calibration is moved to those of the first or the other
/// way round, whichever knows them better. If one knows nothing of them, neither is moved: what they
/// leave open of M and b is in the covariance of the other. Equal gravities share their error.
pub fn compare(a: &Sensor, b: &Sensor) -> Option<Compare> {
    let models = [matrix(&a.parameters), matrix(&b.parameters)];
    let regular = models.iter().all(|m| m.try_inverse().is_some());
    if !regular || !a.is_finite() || !b.is_finite() {
        return None;
    }
    let pair = Pair::new(a, b);
    let nine = |x: &Parameters, y: &Parameters| Some(invariants(y) - invariants(x));
    let (change, [by_a, by_b, common]) = pair.difference(nine)?;
    let magnitude = Difference::new(change, &(by_a + by_b + common), f64::INFINITY);
    let three = |x: &Parameters, y: &Parameters| {
        turn(&matrix(x), &matrix(y)).map(|t| DVector::from_column_slice(t.as_slice()))
    };
    let turn = pair.difference(three).map(|(turn, [by_a, by_b, common])| {
        // Welch and Satterthwaite.
        let parts = [(by_a.trace(), a), (by_b.trace(), b)];
        let weighed = parts.map(|(variance, s)| variance * variance / s.tilt_freedom);
        let freedom = (by_a.trace() + by_b.trace()).powi(2) / (weighed[0] + weighed[1]);
        Difference::new(turn, &(by_a + by_b + common), freedom)
    });
    Some(Compare {
        invariants: pair.parameters.map(|x| invariants(&x)),
        magnitude,
        turn,
        norm: pair.norm(a.gravity.value_mps2)?,
    })
}

/// Two calibrations with the same bends.
struct Pair {
    parameters: [Parameters; 2],
    /// Of each, at known bends.
    covariances: [Covariance; 2],
    /// Sources of error that both depend on with different derivatives: these, times the standard
    /// deviation. Bends, the gravity of the first, of the second.
    common: Vec<[Parameters; 2]>,
}

impl Pair {
    fn new(a: &Sensor, b: &Sensor) -> Pair {
        let [of_a, of_b] = [a, b].map(Sensor::covariance_of_bends);
        let known = of_a.trace() > 0.0 && of_b.trace() > 0.0;
        let [(by_a, free_a), (by_b, free_b)] = [a, b].map(|s| {
            if known {
                s.at_known_bends()
            } else {
                (SMatrix::zeros(), s.covariance)
            }
        });
        let better = if of_a.trace() <= of_b.trace() { a } else { b };
        let bends = better.parameters.fixed_rows::<6>(BENDS);
        let moved = |s: &Sensor, by: &SMatrix<f64, 21, 6>| {
            s.parameters + by * (bends - s.parameters.fixed_rows::<6>(BENDS))
        };
        let parameters = [moved(a, &by_a), moved(b, &by_b)];
        let root = root(&better.covariance_of_bends());
        let mut common: Vec<[Parameters; 2]> = root
            .column_iter()
            .map(|step| [by_a * step, by_b * step])
            .collect();
        if a.gravity != b.gravity {
            let none = Parameters::zeros();
            let by = |s: &Sensor| derivative_by_gravity(&s.parameters) * s.gravity.relative_sd();
            common.extend([[by(a), none], [none, by(b)]]);
        }
        Pair {
            parameters,
            covariances: [free_a, free_b],
            common,
        }
    }

    /// A difference of both, and its covariance by the first, the second, and what is common.
    fn difference(
        &self,
        f: impl Fn(&Parameters, &Parameters) -> Option<DVector<f64>>,
    ) -> Option<(DVector<f64>, [DMatrix<f64>; 3])> {
        let [a, b] = &self.parameters;
        let of_a = propagated(a, &self.covariances[0], |x| f(x, b))?;
        let of_b = propagated(b, &self.covariances[1], |x| f(a, x))?;
        let mut common = DMatrix::zeros(of_a.nrows(), of_a.ncols());
        for [by_a, by_b] in &self.common {
            let slope = (f(&(a + by_a), &(b + by_b))? - f(&(a - by_a), &(b - by_b))?) / 2.0;
            common += &slope * slope.transpose();
        }
        Some((f(a, b)?, [of_a, of_b, common]))
    }

    fn norm(&self, gravity: f64) -> Option<NormDifference> {
        let [a, b] = &self.parameters;
        let [to_a, to_b] = [matrix(a).try_inverse()?, matrix(b).try_inverse()?];
        let mut out = NormDifference {
            rms_mps2: 0.0,
            predicted_rms_mps2: 0.0,
            largest_mps2: 0.0,
            largest_at: Vector3::z(),
        };
        for n in sphere(DIRECTIONS) {
            let reading = matrix(a) * n * gravity + bias(a, 0.0);
            let force = to_b * (reading - bias(b, 0.0));
            let off = force.norm() - gravity;
            let h = [(to_a, n), (to_b, force.normalize())]
                .map(|(inverse, n)| sensitivity(&inverse, &n, gravity));
            out.rms_mps2 += off * off / DIRECTIONS as f64;
            out.predicted_rms_mps2 += self.variance(&h) / DIRECTIONS as f64;
            if off.abs() > out.largest_mps2.abs() {
                (out.largest_mps2, out.largest_at) = (off, n);
            }
        }
        out.rms_mps2 = out.rms_mps2.sqrt();
        out.predicted_rms_mps2 = out.predicted_rms_mps2.max(0.0).sqrt();
        Some(out)
    }

    /// Variance of a difference whose derivatives are −h of the first and h of the second.
    fn variance(&self, h: &[Parameters; 2]) -> f64 {
        let [a, b] = &self.covariances;
        let own = h[0].dot(&(a * h[0])) + h[1].dot(&(b * h[1]));
        let step = |[a, b]: &[Parameters; 2]| (h[1].dot(b) - h[0].dot(a)).powi(2);
        own + self.common.iter().map(step).sum::<f64>()
    }
}

/// R with R Rᵀ = C, whatever the rank of C.
fn root(covariance: &SMatrix<f64, 6, 6>) -> SMatrix<f64, 6, 6> {
    let eigen = (0.5 * (covariance + covariance.transpose())).symmetric_eigen();
    let roots = eigen.eigenvalues.map(|v| v.max(0.0).sqrt());
    eigen.eigenvectors * SMatrix::<f64, 6, 6>::from_diagonal(&roots)
}
