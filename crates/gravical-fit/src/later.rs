//! Does a calibration still fit later readings, and do two calibrations of one sensor differ?
//!
//! [`consistent`] answers both. What both sides of a difference share (the gravity of the place, the bends of
//! the sensor) cancels in it and is not counted twice.
//!
//! Working units: readings are divided by the nominal scale, so that M is about 1 and everything
//! is in m/s².

#[cfg(test)]
mod tests;

use nalgebra::{
    DMatrix, DVector, Matrix3, Rotation3, SMatrix, SymmetricEigen, UnitQuaternion, Vector3,
};

use crate::consistent::{MAX_STEPS, Test, consistent};
use crate::model::{
    BENDS, Covariance, DIRECTIONS, Parameters, bend, bias, invariants, matrix, sensitivity, sphere,
};
use crate::sensor::{Gravity, Sensor, derivative_by_gravity};

/// Directions this near to each other (chord of the unit sphere, 25°) share the model error.
const MODEL_ERROR_CHORD: f64 = 0.43;

/// A mean reading at rest, in working units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticMean {
    /// Mean of the channels, at the temperature of reference.
    pub mean: Vector3<f64>,
    /// Standard deviation of this mean.
    pub sd: Vector3<f64>,
    /// Standard deviation of its length beside that, independent between intervals, m/s².
    pub sd_of_length_mps2: f64,
}

/// A static interval, calibrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    /// Specific force, axes of the board, m/s².
    pub force: Vector3<f64>,
    /// ‖a‖ less gravity, the bend of the sensor taken off, m/s².
    pub error_mps2: f64,
    /// Its standard deviation, if the calibration fits, m/s².
    pub sd_mps2: f64,
}

/// A calibration held against later readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Every static interval, as they were given.
    pub lengths: Vec<Length>,
    /// All errors that count together.
    pub test: Test,
}

/// Holds the lengths of static intervals against gravity: that of the calibration, or of another
/// place, `here`. Only those that `count` are tested. None without one, or where a value is no number.
///
/// The intervals share the errors of the parameters, of gravity and of the model; the noise of each
/// mean is its own.
pub fn check(
    sensor: &Sensor,
    here: Option<Gravity>,
    means: &[StaticMean],
    counts: impl Fn(usize) -> bool,
) -> Option<Check> {
    let counted: Vec<usize> = (0..means.len()).filter(|k| counts(*k)).collect();
    if counted.is_empty() || !sensor.is_finite() {
        return None;
    }
    let gravity = here.unwrap_or(sensor.gravity).value_mps2;
    let forces = |x: &Parameters| {
        let inverse = matrix(x).try_inverse()?;
        let force = |s: &StaticMean| inverse * (s.mean - bias(x, 0.0));
        Some(means.iter().map(force).collect::<Vec<_>>())
    };
    let errors = |x: &Parameters| {
        let error = |a: Vector3<f64>| a.norm() - gravity * (1.0 + bend(x, &a.normalize()));
        let errors = DVector::from_iterator(means.len(), forces(x)?.into_iter().map(error));
        errors.iter().all(|e| e.is_finite()).then_some(errors)
    };
    let x = &sensor.parameters;
    let mut covariance = propagated(x, &sensor.covariance, errors)?;
    let (forces, errors) = (forces(x)?, errors(x)?);
    let directions: Vec<Vector3<f64>> = forces.iter().map(Vector3::normalize).collect();
    let inverse = matrix(x).try_inverse()?;
    // Held against its own gravity, the error of that counts once.
    let elsewhere = here.map_or(0.0, |here| here.sd_mps2.powi(2));
    let of_gravity = sensor.gravity.sd_mps2.powi(2) + elsewhere;
    let noise = |i: usize| {
        let along = inverse.tr_mul(&directions[i]).component_mul(&means[i].sd);
        along.norm_squared() + means[i].sd_of_length_mps2.powi(2)
    };
    covariance += DMatrix::from_fn(means.len(), means.len(), |i, j| {
        let chord = (directions[i] - directions[j]).norm() / MODEL_ERROR_CHORD;
        let model_error = sensor.model_error_mps2.powi(2) * (-chord * chord).exp();
        of_gravity + model_error + if i == j { noise(i) } else { 0.0 }
    });
    let length = |i: usize| Length {
        force: forces[i],
        error_mps2: errors[i],
        sd_mps2: covariance[(i, i)].sqrt(),
    };
    Some(Check {
        lengths: (0..means.len()).map(length).collect(),
        test: consistent(
            &errors.select_rows(&counted),
            &covariance.select_rows(&counted).select_columns(&counted),
        ),
    })
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
    if !a.is_finite() || !b.is_finite() {
        return None;
    }
    let pair = Pair::new(a, b);
    Some(Compare {
        norm: pair.norm(a.gravity.value_mps2)?,
        invariants: pair.parameters.map(|x| invariants(&x)),
        magnitude: pair.difference([f64::INFINITY; 2], |x, y| {
            Some(invariants(y) - invariants(x))
        })?,
        turn: pair.difference([a.tilt_freedom, b.tilt_freedom], turn),
    })
}

/// Rotation vector (rad) of Q in M_A⁻¹ M_B = Q P: what a_A = Q a_B turns by. None where one frame
/// is the mirror image of the other, or a matrix is singular.
fn turn(a: &Parameters, b: &Parameters) -> Option<DVector<f64>> {
    let t: Matrix3<f64> = matrix(a).try_inverse()? * matrix(b);
    let proper = t.iter().all(|v| v.is_finite()) && t.determinant() > 0.0;
    let svd = proper.then(|| t.try_svd(true, true, f64::EPSILON, MAX_STEPS))??;
    let q = Rotation3::from_matrix_unchecked(svd.u? * svd.v_t?);
    // By the quaternion: exact for the smallest turns, where a cosine is not.
    let turn = UnitQuaternion::from_rotation_matrix(&q).scaled_axis();
    Some(DVector::from_column_slice(turn.as_slice()))
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
    /// At known bends C_mb C_bb⁺ is the derivative of the other parameters by these, and
    /// C_mm − C_mb C_bb⁺ C_bm is what is left.
    fn new(a: &Sensor, b: &Sensor) -> Pair {
        const MIN_VARIANCE: f64 = 1e-14;
        let both = [a, b];
        let spreads: [SMatrix<f64, 6, 6>; 2] =
            both.map(|s| s.covariance.fixed_view::<6, 6>(BENDS, BENDS).into());
        let known = spreads.iter().all(|spread| spread.trace() > 0.0);
        let better = usize::from(spreads[0].trace() > spreads[1].trace());
        let bends = both[better].parameters.fixed_rows::<6>(BENDS);
        let root = root(&spreads[better]);
        let (mut parameters, mut covariances) =
            (both.map(|s| s.parameters), both.map(|s| s.covariance));
        let mut steps = [SMatrix::<f64, 21, 6>::zeros(); 2];
        for i in (0..2).filter(|_| known) {
            let with_bends: SMatrix<f64, 21, 6> =
                both[i].covariance.fixed_columns::<6>(BENDS).into();
            let inverse = spreads[i].pseudo_inverse(MIN_VARIANCE).unwrap_or_default();
            let by_bends = with_bends * inverse;
            parameters[i] += by_bends * (bends - both[i].parameters.fixed_rows::<6>(BENDS));
            covariances[i] -= by_bends * with_bends.transpose();
            steps[i] = by_bends * root;
        }
        let one = |k: usize| steps.map(|step| step.column(k).into_owned());
        let mut common: Vec<[Parameters; 2]> = (0..6).map(one).collect();
        if a.gravity != b.gravity {
            let none = Parameters::zeros();
            let by = |s: &Sensor| derivative_by_gravity(&s.parameters) * s.gravity.relative_sd();
            common.extend([[by(a), none], [none, by(b)]]);
        }
        Pair {
            parameters,
            covariances,
            common,
        }
    }

    /// A difference of both. The size of each covariance is known by so many residuals: the test has the
    /// degrees of freedom of Welch and Satterthwaite.
    fn difference(
        &self,
        freedom: [f64; 2],
        f: impl Fn(&Parameters, &Parameters) -> Option<DVector<f64>>,
    ) -> Option<Difference> {
        let [a, b] = &self.parameters;
        let value = f(a, b)?;
        let by_a = propagated(a, &self.covariances[0], |x| f(x, b))?;
        let by_b = propagated(b, &self.covariances[1], |x| f(a, x))?;
        let mut common = DMatrix::zeros(value.len(), value.len());
        for [of_a, of_b] in &self.common {
            let slope = (f(&(a + of_a), &(b + of_b))? - f(&(a - of_a), &(b - of_b))?) / 2.0;
            common += &slope * slope.transpose();
        }
        let (of_a, of_b) = (by_a.trace(), by_b.trace());
        let weighed = of_a * of_a / freedom[0] + of_b * of_b / freedom[1];
        let covariance = by_a + by_b + common;
        let test = consistent(&value, &covariance);
        Some(Difference {
            sd: covariance.diagonal().map(|v| v.max(0.0).sqrt()),
            test: test.with_freedom((of_a + of_b).powi(2) / weighed),
            value,
        })
    }

    fn norm(&self, gravity: f64) -> Option<NormDifference> {
        let [a, b] = &self.parameters;
        let [to_a, to_b] = [matrix(a).try_inverse()?, matrix(b).try_inverse()?];
        let force = |n: &Vector3<f64>| {
            let reading = matrix(a) * n * gravity + bias(a, 0.0);
            to_b * (reading - bias(b, 0.0))
        };
        let variance = |n: &Vector3<f64>| {
            let of_a = sensitivity(&to_a, n, gravity);
            let of_b = sensitivity(&to_b, &force(n).normalize(), gravity);
            let own = of_a.dot(&(self.covariances[0] * of_a));
            let own = own + of_b.dot(&(self.covariances[1] * of_b));
            let common = self.common.iter();
            let common = common.map(|[a, b]| (of_b.dot(b) - of_a.dot(a)).powi(2));
            own + common.sum::<f64>()
        };
        let each: Vec<Vector3<f64>> = sphere(DIRECTIONS).collect();
        let off = each.iter().map(|n| force(n).norm() - gravity);
        let off = DVector::from_iterator(DIRECTIONS, off);
        let largest = off.iamax();
        let predicted = each.iter().map(variance).sum::<f64>() / DIRECTIONS as f64;
        Some(NormDifference {
            rms_mps2: (off.norm_squared() / DIRECTIONS as f64).sqrt(),
            predicted_rms_mps2: predicted.max(0.0).sqrt(),
            largest_mps2: off[largest],
            largest_at: each[largest],
        })
    }
}

/// R with R Rᵀ = C, whatever the rank of C.
fn root(covariance: &SMatrix<f64, 6, 6>) -> SMatrix<f64, 6, 6> {
    let eigen = (0.5 * (covariance + covariance.transpose())).symmetric_eigen();
    let roots = eigen.eigenvalues.map(|v| v.max(0.0).sqrt());
    eigen.eigenvectors * SMatrix::<f64, 6, 6>::from_diagonal(&roots)
}

/// Covariance of `f` by the errors of the parameters, from steps of one standard deviation along the axes of
/// their covariance.
///
/// With slopes s_k and curves q_k from steps of ±1 it is Σ s_k s_kᵀ + 2 Σ q_k q_kᵀ + (Σ q_k)(Σ q_k)ᵀ: a
/// frame known to 2° lengthens a reading by 0.06 %, of which slopes know nothing. None where `f` does not
/// exist after a step.
fn propagated(
    x: &Parameters,
    covariance: &Covariance,
    f: impl Fn(&Parameters) -> Option<DVector<f64>>,
) -> Option<DMatrix<f64>> {
    let eigen = SymmetricEigen::try_new(*covariance, f64::EPSILON, MAX_STEPS)?;
    let here = f(x)?;
    let mut curved = DVector::zeros(here.len());
    let mut out = DMatrix::zeros(here.len(), here.len());
    let axes = eigen.eigenvectors.column_iter().zip(&eigen.eigenvalues);
    for (axis, variance) in axes.filter(|(_, variance)| **variance > 0.0) {
        let step = axis * variance.sqrt();
        let (up, down) = (f(&(x + step))?, f(&(x - step))?);
        let slope = (&up - &down) / 2.0;
        let curve = (up + down) / 2.0 - &here;
        out += &slope * slope.transpose() + &curve * curve.transpose() * 2.0;
        curved += curve;
    }
    Some(out + &curved * curved.transpose())
}
