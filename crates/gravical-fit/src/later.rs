//! Does a calibration still fit later readings, and do two calibrations of one sensor differ?
//!
//! One test answers both, [`consistent`]: a difference against its covariance. What both sides of
//! a difference share (the gravity of the place, the bends of the sensor) cancels in it and is not
//! counted twice.
//!
//! Working units: readings are divided by the nominal scale, so that M is about 1 and everything
//! is in m/s².

use nalgebra::{
    DMatrix, DVector, Matrix3, Rotation3, SMatrix, SymmetricEigen, UnitQuaternion, Vector3,
};
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use crate::model::{BENDS, BIAS, Covariance, Parameters, bend, bias, matrix, sensitivity, sphere};

/// Below this probability chance is no explanation.
pub const SIGNIFICANCE: f64 = 0.01;

/// Eigenvalues of a covariance below this fraction of the largest count as zero. Rounding leaves
/// 1e-16; a well-placed session has 1e-7 between its best and worst direction.
const RANK_TOLERANCE: f64 = 1e-12;

/// Steps of the decomposition; it takes some tens, and never ends on some broken matrices.
const MAX_STEPS: usize = 10_000;

/// Directions this near to each other (chord of the unit sphere, 25°) share the model error.
const MODEL_ERROR_CHORD: f64 = 0.43;

/// A bias is tested by readings within 60° of its axis: across them it would have to be enormous.
const MIN_COSINE: f64 = 0.5;

/// Directions over which lengths are averaged.
const DIRECTIONS: usize = 400;

/// A difference held against its covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Test {
    /// dᵀ C⁺ d.
    pub chi2: f64,
    /// Rank of C: its degrees of freedom; 0 where there was nothing to test.
    pub rank: usize,
    /// Probability that chance makes as much; 1 where there was nothing to test.
    pub p: f64,
}

impl Test {
    fn new(chi2: f64, rank: usize) -> Test {
        let tail = ChiSquared::new(rank as f64).map(|d| d.sf(chi2.max(0.0)));
        let p = tail.unwrap_or(1.0).clamp(0.0, 1.0);
        Test { chi2, rank, p }
    }

    /// The same where the size of the covariance is known by `freedom` residuals only: F in place
    /// of χ².
    fn with_freedom(self, freedom: f64) -> Test {
        let rank = self.rank as f64;
        match FisherSnedecor::new(rank, freedom) {
            Ok(f) if freedom.is_finite() => Test {
                p: f.sf(self.chi2 / rank).clamp(0.0, 1.0),
                ..self
            },
            _ => self,
        }
    }
}

/// χ² of `difference` (n) by its `covariance` (n × n) whatever its rank: C⁺ is the pseudo-inverse,
/// so that what no reading determines is not tested. Components have to be of similar size. Rank 0
/// where the covariance is zero, not finite, or of another size.
#[must_use]
pub fn consistent(difference: &DVector<f64>, covariance: &DMatrix<f64>) -> Test {
    let n = difference.len();
    let mut values = difference.iter().chain(covariance.iter());
    if n == 0 || covariance.shape() != (n, n) || !values.all(|v| v.is_finite()) {
        return Test::new(0.0, 0);
    }
    let symmetric = covariance * 0.5 + covariance.transpose() * 0.5;
    let Some(eigen) = SymmetricEigen::try_new(symmetric, f64::EPSILON, MAX_STEPS) else {
        return Test::new(0.0, 0);
    };
    let along = eigen.eigenvectors.tr_mul(difference);
    let least = RANK_TOLERANCE * eigen.eigenvalues.max();
    let parts = eigen.eigenvalues.iter().zip(along.iter());
    let kept = parts.filter(|(value, _)| **value > least.max(0.0));
    let (chi2, rank) = kept.fold((0.0, 0), |(chi2, rank), (value, part)| {
        (chi2 + part * part / value, rank + 1)
    });
    Test::new(chi2, rank)
}

/// Gravity, and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gravity {
    /// m/s².
    pub value_mps2: f64,
    /// Standard uncertainty, m/s²; 0 if it was given.
    pub sd_mps2: f64,
}

/// A calibration as numbers, in working units.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// M, b, drift and bends; what is not known of the last two is 0.
    pub parameters: Parameters,
    /// Covariance of these by the readings: without the error of gravity, which later readings in
    /// the same place share. Rows of what is not known are 0.
    pub covariance: Covariance,
    /// Gravity that M rests on.
    pub gravity: Gravity,
    /// Standard deviation of what the model leaves out of a length, m/s².
    pub model_error_mps2: f64,
    /// Tilts of placements that σ_tilt, and with it the uncertainty of the frame, was estimated
    /// from; infinite where it was given.
    pub tilt_freedom: f64,
}

impl Sensor {
    fn is_finite(&self) -> bool {
        let gravity = [
            self.gravity.value_mps2,
            self.gravity.sd_mps2,
            self.model_error_mps2,
        ];
        let all = self.parameters.iter().chain(&self.covariance);
        all.chain(&gravity).all(|v| v.is_finite()) && self.gravity.value_mps2 > 0.0
    }

    /// Derivative of the parameters by ln g: M is fitted in proportion to 1/g, b does not depend
    /// on it.
    fn by_gravity(&self) -> Parameters {
        Parameters::from_fn(|i, _| if i < BIAS { -self.parameters[i] } else { 0.0 })
    }

    /// Derivatives (21 × 6) of the other parameters by the bends once these are fixed, and the
    /// covariance that is left: C_mb C_bb⁺ and C_mm − C_mb C_bb⁺ C_bm.
    fn at_known_bends(&self) -> (SMatrix<f64, 21, 6>, Covariance) {
        const LEAST: f64 = 1e-14;
        let with_bends: SMatrix<f64, 21, 6> = self.covariance.fixed_columns::<6>(BENDS).into();
        let of_bends = self.covariance_of_bends();
        let inverse = of_bends.pseudo_inverse(LEAST).unwrap_or_default();
        let by_bends = with_bends * inverse;
        (
            by_bends,
            self.covariance - by_bends * with_bends.transpose(),
        )
    }

    fn covariance_of_bends(&self) -> SMatrix<f64, 6, 6> {
        self.covariance.fixed_view::<6, 6>(BENDS, BENDS).into()
    }
}

/// A mean reading at rest, in working units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Still {
    /// Mean of the channels, at the temperature of reference.
    pub mean: Vector3<f64>,
    /// Standard deviation of this mean.
    pub sd: Vector3<f64>,
    /// What its length may be off by beside that, in no relation to other stills, m/s².
    pub sd_of_length_mps2: f64,
}

/// A still, calibrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    /// Specific force, axes of the board, m/s².
    pub force: Vector3<f64>,
    /// ‖a‖ less gravity, the bend of the sensor taken off, m/s².
    pub error_mps2: f64,
    /// Its standard deviation, if the calibration fits, m/s².
    pub sd_mps2: f64,
}

/// What one fault would have to be to explain errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Explanation {
    /// The change: a fraction of gravity, or m/s².
    pub change: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// The change alone.
    pub test: Test,
    /// The errors once it is taken off.
    pub left: Test,
}

impl Explanation {
    /// The change is more than chance, and what is left is not.
    #[must_use]
    pub fn is_enough(&self) -> bool {
        self.test.p < SIGNIFICANCE && self.left.p >= SIGNIFICANCE
    }
}

/// A calibration held against later readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// The stills, as they were given.
    pub lengths: Vec<Length>,
    /// All errors together.
    pub test: Test,
    /// All lengths wrong by one fraction: the scale, or gravity.
    pub share: Option<Explanation>,
    /// A changed bias of x, y, z alone, calibrated axes of the board.
    pub bias: [Option<Explanation>; 3],
}

impl Check {
    /// Probability that chance makes as much: the test of all errors dilutes a single fault among
    /// many stills, so half of the level is for that, half for the likeliest fault (Bonferroni).
    #[must_use]
    pub fn p(&self) -> f64 {
        let faults = self.bias.iter().chain([&self.share]).flatten();
        let each: Vec<f64> = faults.map(|e| e.test.p).collect();
        let fault = each.iter().fold(1.0, |least: f64, p| least.min(*p)) * each.len() as f64;
        match self.lengths.len() {
            // One length has one test.
            1 => self.test.p,
            _ => (2.0 * self.test.p.min(fault)).min(1.0),
        }
    }
}

/// Holds the lengths of `stills` against gravity: that of the calibration, or of another place,
/// `here`. None without a still or where a number is no number.
///
/// The stills share the errors of the parameters, of gravity and of the model; the noise of each
/// mean is its own.
#[must_use]
pub fn check(sensor: &Sensor, here: Option<Gravity>, stills: &[Still]) -> Option<Check> {
    let gravity = here.unwrap_or(sensor.gravity).value_mps2;
    if stills.is_empty() || !sensor.is_finite() {
        return None;
    }
    let x = &sensor.parameters;
    let inverse = matrix(x).try_inverse()?;
    let forces: Vec<Vector3<f64>> = stills
        .iter()
        .map(|s| inverse * (s.mean - bias(x, 0.0)))
        .collect();
    let errors = length_errors(x, gravity, stills)?;
    let directions: Vec<Vector3<f64>> = forces.iter().map(Vector3::normalize).collect();
    let by_parameters = propagated(x, &sensor.covariance, |x| length_errors(x, gravity, stills))?;
    let covariance = by_parameters + covariance_of_the_rest(sensor, here, &directions, stills)?;
    let length = |i: usize| Length {
        force: forces[i],
        error_mps2: errors[i],
        sd_mps2: covariance[(i, i)].sqrt(),
    };
    let explain = |f: &dyn Fn(&Vector3<f64>) -> f64| {
        let effect = DVector::from_iterator(stills.len(), directions.iter().map(f));
        explanation(&errors, &covariance, &effect)
    };
    let sees = |axis: usize| directions.iter().any(|n| n[axis].abs() >= MIN_COSINE);
    Some(Check {
        lengths: (0..stills.len()).map(length).collect(),
        test: consistent(&errors, &covariance),
        share: explain(&|_| gravity),
        bias: std::array::from_fn(|axis| sees(axis).then(|| explain(&|n| n[axis])).flatten()),
    })
}

/// ‖a‖ less gravity, the bend taken off. None where that is no number.
fn length_errors(x: &Parameters, gravity: f64, stills: &[Still]) -> Option<DVector<f64>> {
    let inverse = matrix(x).try_inverse()?;
    let error = |s: &Still| {
        let force = inverse * (s.mean - bias(x, 0.0));
        force.norm() - gravity * (1.0 + bend(x, &force.normalize()))
    };
    let errors = DVector::from_iterator(stills.len(), stills.iter().map(error));
    errors.iter().all(|e| e.is_finite()).then_some(errors)
}

/// Covariance of `f` by the errors of the parameters, from steps of one standard deviation along
/// the axes of their covariance. With slopes s_k and curves q_k along these it is
/// Σ s_k s_kᵀ + 2 Σ q_k q_kᵀ + (Σ q_k)(Σ q_k)ᵀ: a frame known to 2° lengthens a reading by 0.06 %,
/// of which slopes know nothing.
fn propagated(
    x: &Parameters,
    covariance: &Covariance,
    f: impl Fn(&Parameters) -> Option<DVector<f64>>,
) -> Option<DMatrix<f64>> {
    let here = f(x)?;
    let eigen = SymmetricEigen::try_new(*covariance, f64::EPSILON, MAX_STEPS)?;
    let mut covariance = DMatrix::zeros(here.len(), here.len());
    let mut curved = DVector::zeros(here.len());
    for (variance, axis) in eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
    {
        if *variance <= 0.0 {
            continue;
        }
        let step = axis * variance.sqrt();
        let (up, down) = (f(&(x + step))?, f(&(x - step))?);
        let slope = (&up - &down) / 2.0;
        let curve = (up + down) / 2.0 - &here;
        covariance += &slope * slope.transpose() + &curve * curve.transpose() * 2.0;
        curved += curve;
    }
    covariance += &curved * curved.transpose();
    Some(covariance)
}

/// Covariance of the lengths along `directions` by gravity, model error and noise.
fn covariance_of_the_rest(
    sensor: &Sensor,
    here: Option<Gravity>,
    directions: &[Vector3<f64>],
    stills: &[Still],
) -> Option<DMatrix<f64>> {
    let inverse = matrix(&sensor.parameters).try_inverse()?;
    // Held against its own gravity, the error of that counts once.
    let elsewhere = here.map_or(0.0, |here| here.sd_mps2.powi(2));
    let of_gravity = sensor.gravity.sd_mps2.powi(2) + elsewhere;
    let model_error = |i: usize, j: usize| {
        let chord = (directions[i] - directions[j]).norm() / MODEL_ERROR_CHORD;
        sensor.model_error_mps2.powi(2) * (-chord * chord).exp()
    };
    let noise = |i: usize| {
        let along = inverse.tr_mul(&directions[i]).component_mul(&stills[i].sd);
        along.norm_squared() + stills[i].sd_of_length_mps2.powi(2)
    };
    Some(DMatrix::from_fn(stills.len(), stills.len(), |i, j| {
        let own = if i == j { noise(i) } else { 0.0 };
        of_gravity + model_error(i, j) + own
    }))
}

/// One change whose effect on the errors is known, by generalised least squares. None where the
/// covariance is singular or the effect zero.
fn explanation(
    errors: &DVector<f64>,
    covariance: &DMatrix<f64>,
    effect: &DVector<f64>,
) -> Option<Explanation> {
    let weighted = covariance.clone().cholesky()?.solve(effect);
    let information = weighted.dot(effect);
    let change = weighted.dot(errors) / information;
    let whole = consistent(errors, covariance);
    let explained = change * change * information;
    (information > 0.0 && change.is_finite()).then(|| Explanation {
        change,
        sd: information.sqrt().recip(),
        test: Test::new(explained, 1),
        left: Test::new(whole.chi2 - explained, whole.rank.saturating_sub(1)),
    })
}

/// What no turn of the board changes, and ‖a‖ depends on: b (m/s²), the lengths of the rows of M,
/// and the angles xy, xz, yz between them beyond 90° (rad).
fn invariants(x: &Parameters) -> DVector<f64> {
    let m = matrix(x);
    let row = |i: usize| m.row(i).transpose();
    let angle = |i: usize, j: usize| {
        let cosine = row(i).normalize().dot(&row(j).normalize());
        cosine.clamp(-1.0, 1.0).acos() - std::f64::consts::FRAC_PI_2
    };
    DVector::from_fn(9, |i, _| match i {
        0..3 => x[BIAS + i],
        3..6 => row(i - 3).norm(),
        6 => angle(0, 1),
        7 => angle(0, 2),
        _ => angle(1, 2),
    })
}

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

/// One number of both calibrations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Of the first and the second calibration; none of a turn, which is between them.
    pub values: Option<[f64; 2]>,
    /// Second less first.
    pub change: f64,
    /// Its standard deviation.
    pub sd: f64,
}

/// Two calibrations of one sensor, the second less the first.
#[derive(Debug, Clone, PartialEq)]
pub struct Compare {
    /// b (m/s²), lengths of the rows of M (1 is nominal), angles xy, xz, yz beyond 90° (rad).
    pub invariants: [Difference; 9],
    /// All nine together.
    pub magnitude: Test,
    /// Rotation vector of the frame (rad), and its three components together; none where one
    /// frame is the mirror image of the other.
    pub turn: Option<([Difference; 3], Test)>,
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
    /// This is there, calibrated axes of the first.
    pub largest_at: Vector3<f64>,
}

/// Compares two calibrations of one sensor. None where a matrix is singular or a number is no
/// number.
///
/// Both have the same bends: the second calibration is moved to those of the first or the other
/// way round, whichever knows them better. Equal gravities share their error.
#[must_use]
pub fn compare(a: &Sensor, b: &Sensor) -> Option<Compare> {
    let models = [matrix(&a.parameters), matrix(&b.parameters)];
    let regular = models.iter().all(|m| m.try_inverse().is_some());
    if !regular || !a.is_finite() || !b.is_finite() {
        return None;
    }
    let pair = Pair::new(a, b);
    let nine = |x: &Parameters, y: &Parameters| Some(invariants(y) - invariants(x));
    let (change, [by_a, by_b, common]) = pair.difference(nine)?;
    let covariance = by_a + by_b + common;
    let values = pair.parameters.map(|x| invariants(&x));
    let three = |x: &Parameters, y: &Parameters| {
        turn(&matrix(x), &matrix(y)).map(|t| DVector::from_column_slice(t.as_slice()))
    };
    let difference = |change: &DVector<f64>, covariance: &DMatrix<f64>, i: usize| Difference {
        values: None,
        change: change[i],
        sd: covariance[(i, i)].max(0.0).sqrt(),
    };
    Some(Compare {
        invariants: std::array::from_fn(|i| Difference {
            values: Some([values[0][i], values[1][i]]),
            ..difference(&change, &covariance, i)
        }),
        magnitude: consistent(&change, &covariance),
        turn: pair
            .difference(three)
            .map(|(change, [by_a, by_b, common])| {
                // Welch and Satterthwaite.
                let parts = [(by_a.trace(), a), (by_b.trace(), b)];
                let weighed = parts.map(|(variance, s)| variance * variance / s.tilt_freedom);
                let freedom = (by_a.trace() + by_b.trace()).powi(2) / (weighed[0] + weighed[1]);
                let covariance = by_a + by_b + common;
                let each = std::array::from_fn(|i| difference(&change, &covariance, i));
                (each, consistent(&change, &covariance).with_freedom(freedom))
            }),
        norm: pair.norm(a.gravity.value_mps2)?,
    })
}

/// Two calibrations with the same bends.
struct Pair {
    parameters: [Parameters; 2],
    /// Of each, at known bends.
    covariances: [Covariance; 2],
    /// Derivatives of each by something that both do not share or share with another weight, times
    /// its standard deviation: bends, the gravity of the first, of the second.
    common: Vec<[Parameters; 2]>,
}

impl Pair {
    fn new(a: &Sensor, b: &Sensor) -> Pair {
        let [(by_a, free_a), (by_b, free_b)] = [a.at_known_bends(), b.at_known_bends()];
        let [of_a, of_b] = [a, b].map(Sensor::covariance_of_bends);
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
            let by = |s: &Sensor| s.by_gravity() * (s.gravity.sd_mps2 / s.gravity.value_mps2);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{DRIFT, PARAMETERS};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    const G: f64 = 9.80665;
    const NOISE: f64 = 0.001;

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        rng.sample(StandardNormal)
    }

    fn truth() -> Parameters {
        let mut x = Parameters::zeros();
        let m = [1.02, 0.01, -0.02, 0.0, 0.97, 0.03, -0.01, 0.02, 1.01];
        x.fixed_rows_mut::<9>(0).copy_from_slice(&m);
        x.fixed_rows_mut::<3>(BIAS)
            .copy_from_slice(&[0.3, -0.2, 0.1]);
        x
    }

    /// M and b by the fit of lengths to `directions`, linear about the truth, and what orients it;
    /// the true sensor reads `bends` that the fit knows to `sd_of_bends` only.
    fn fitted(
        rng: &mut ChaCha8Rng,
        directions: usize,
        sd_of_bends: f64,
        bends: &Parameters,
    ) -> Sensor {
        let x = truth();
        let inverse = matrix(&x).try_inverse().unwrap();
        let mut information = Covariance::zeros();
        let mut pulled = Parameters::zeros();
        for n in sphere(directions) {
            // −hᵀd = error of the length: noise, and the bends that are 0 in x.
            let h = sensitivity(&inverse, &n, G);
            let length = NOISE * normal(rng) + h.dot(bends);
            information += h * h.transpose() / NOISE.powi(2);
            pulled += h * length / NOISE.powi(2);
        }
        // The frame and the bends by another source; the drift, and bends without one, are held.
        let mut held = Vec::new();
        for i in 0..PARAMETERS {
            let sd = match i {
                0..BIAS => 2e-4,
                BIAS..DRIFT => 1.0,
                DRIFT..BENDS => 0.0,
                _ => sd_of_bends,
            };
            if sd == 0.0 {
                information.row_mut(i).fill(0.0);
                information.column_mut(i).fill(0.0);
                information[(i, i)] = 1.0;
                pulled[i] = 0.0;
                held.push(i);
                continue;
            }
            information[(i, i)] += 1.0 / (sd * sd);
            pulled[i] += if i < BIAS { normal(rng) / sd } else { 0.0 };
        }
        let mut covariance = information.try_inverse().unwrap();
        let estimate = covariance * pulled;
        held.into_iter().for_each(|i| covariance[(i, i)] = 0.0);
        Sensor {
            parameters: x + estimate,
            covariance,
            gravity: Gravity {
                value_mps2: G,
                sd_mps2: 0.0,
            },
            model_error_mps2: 0.0,
            tilt_freedom: f64::INFINITY,
        }
    }

    fn stills(rng: &mut ChaCha8Rng, count: usize, x: &Parameters) -> Vec<Still> {
        let still = |n: Vector3<f64>| Still {
            mean: matrix(x) * n * (G * (1.0 + bend(x, &n)))
                + bias(x, 0.0)
                + Vector3::from_fn(|_, _| NOISE * normal(rng)),
            sd: Vector3::repeat(NOISE),
            sd_of_length_mps2: 0.0,
        };
        sphere(count).map(still).collect()
    }

    fn share_below(values: &[f64], level: f64) -> f64 {
        values.iter().filter(|p| **p < level).count() as f64 / values.len() as f64
    }

    #[test]
    fn chi_square_of_any_rank() {
        let d = DVector::from_vec(vec![2.0, 3.0]);
        let c = DMatrix::from_diagonal(&DVector::from_vec(vec![4.0, 9.0]));
        let test = consistent(&d, &c);
        assert!((test.chi2 - 2.0).abs() < 1e-12 && test.rank == 2);
        // Two degrees of freedom: e^(−χ²/2).
        assert!((test.p - (-1.0_f64).exp()).abs() < 1e-9);
        // Variance only along (1, 1)/√2.
        let test = consistent(
            &DVector::from_vec(vec![1.0, 0.0]),
            &DMatrix::repeat(2, 2, 1.0),
        );
        assert!((test.chi2 - 0.25).abs() < 1e-12 && test.rank == 1);
        // Tables: 1 %, 5 %, 1 %.
        for (chi2, rank, p) in [(6.635, 1, 0.01), (16.919, 9, 0.05), (26.217, 12, 0.01)] {
            assert!((Test::new(chi2, rank).p - p).abs() < 1e-5);
        }
        // F of 3 and 10 degrees of freedom: 6.552 at 1 %.
        assert!((Test::new(3.0 * 6.552, 3).with_freedom(10.0).p - 0.01).abs() < 1e-5);
    }

    #[test]
    fn nothing_to_test_is_no_panic() {
        let two = DVector::repeat(2, 1.0);
        for (d, c) in [
            (DVector::zeros(0), DMatrix::zeros(0, 0)),
            (two.clone(), DMatrix::zeros(2, 2)),
            (two.clone(), DMatrix::identity(3, 3)),
            (two.clone(), DMatrix::repeat(2, 2, f64::NAN)),
            (two.clone(), -DMatrix::<f64>::identity(2, 2)),
            (two * f64::INFINITY, DMatrix::identity(2, 2)),
        ] {
            let test = consistent(&d, &c);
            assert_eq!((test.rank, test.p), (0, 1.0));
        }
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let good = fitted(&mut rng, 12, 0.0, &Parameters::zeros());
        let some = stills(&mut rng, 3, &truth());
        assert!(check(&good, None, &[]).is_none());
        for i in [0, 10, 20] {
            let mut bad = good.clone();
            bad.parameters[i] = f64::NAN;
            assert!(check(&bad, None, &some).is_none() && compare(&good, &bad).is_none());
        }
        let mut singular = good.clone();
        singular.parameters = Parameters::zeros();
        assert!(check(&singular, None, &some).is_none() && compare(&good, &singular).is_none());
    }

    #[test]
    fn a_sensor_that_did_not_change_fits_and_agrees() {
        let (mut fits, mut agrees, mut turned) = (Vec::new(), Vec::new(), Vec::new());
        for seed in 0..400 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let a = fitted(&mut rng, 14, 0.0, &Parameters::zeros());
            let b = fitted(&mut rng, 20, 0.0, &Parameters::zeros());
            let later = stills(&mut rng, 8, &truth());
            fits.push(check(&a, None, &later).unwrap().test.p);
            let compared = compare(&a, &b).unwrap();
            agrees.push(compared.magnitude.p);
            turned.push(compared.turn.unwrap().1.p);
        }
        // 400 at a level of 5 %: 1.1 % of scatter.
        for p in [&fits, &agrees, &turned] {
            let share = share_below(p, 0.05);
            assert!((0.015..=0.085).contains(&share), "{share}");
        }
    }

    /// Bends of 0.2 % that the fit knows to 0.2 %, seen by few poses: shared, they make no
    /// difference between two calibrations, and the second one of more poses none either.
    #[test]
    fn bends_are_shared() {
        for (first, second) in [(12, 12), (12, 30)] {
            let mut p = Vec::new();
            for seed in 0..300 {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                let mut bends = Parameters::zeros();
                (BENDS..21).for_each(|i| bends[i] = 0.002 * normal(&mut rng));
                let a = fitted(&mut rng, first, 0.002, &bends);
                let b = fitted(&mut rng, second, 0.002, &bends);
                p.push(compare(&a, &b).unwrap().magnitude.p);
            }
            let share = share_below(&p, 0.05);
            assert!((0.005..=0.09).contains(&share), "{first} {second}: {share}");
        }
    }

    #[test]
    fn one_fault_is_found_and_named() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let a = fitted(&mut rng, 20, 0.0, &Parameters::zeros());
        let mut moved = truth();
        moved[BIAS + 1] += 0.02;
        let result = check(&a, None, &stills(&mut rng, 12, &moved)).unwrap();
        assert!(result.test.p < SIGNIFICANCE);
        let named = result.bias.map(|e| e.is_some_and(|e| e.is_enough()));
        assert_eq!(named, [false, true, false]);
        assert!((result.bias[1].unwrap().change - 0.02 / 0.97).abs() < 0.003);
        assert!(!result.share.unwrap().is_enough());
        // A scale, and the gravity of another place, look alike.
        let there = Some(Gravity {
            value_mps2: 9.78,
            sd_mps2: 0.0005,
        });
        let result = check(&a, there, &stills(&mut rng, 12, &truth())).unwrap();
        let share = result.share.unwrap();
        assert!(share.is_enough() && (share.change - 0.0027).abs() < 3e-4);
    }

    /// Assumed gravity hides a scale of the same size, and is shared by two calibrations.
    #[test]
    fn gravity_is_counted_once() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let mut a = fitted(&mut rng, 20, 0.0, &Parameters::zeros());
        let mut b = a.clone();
        a.gravity.sd_mps2 = 0.015;
        b.gravity = a.gravity;
        b.parameters.fixed_rows_mut::<9>(0).scale_mut(1.002);
        assert!(compare(&a, &b).unwrap().magnitude.p < 1e-6);
        b.gravity.value_mps2 = 9.8;
        assert!(compare(&a, &b).unwrap().magnitude.p > 0.5);
        let later = stills(&mut rng, 8, &truth());
        assert!(check(&a, None, &later).unwrap().test.p > SIGNIFICANCE);
        assert!(check(&b, None, &later).unwrap().test.p > SIGNIFICANCE);
    }

    #[test]
    fn a_turn_changes_no_length_and_a_mirror_is_seen() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let a = fitted(&mut rng, 20, 0.0, &Parameters::zeros());
        let by = Vector3::new(0.3, -0.9, 0.4);
        let with = |q: Matrix3<f64>| {
            let (mut b, m) = (a.clone(), matrix(&a.parameters) * q);
            (0..BIAS).for_each(|i| b.parameters[i] = m[(i / 3, i % 3)]);
            b
        };
        let turned = compare(&a, &with(Rotation3::new(by).into_inner())).unwrap();
        assert!(turned.magnitude.chi2 < 1e-12 && turned.norm.rms_mps2 < 1e-10);
        let (vector, test) = turned.turn.unwrap();
        assert!((0..3).all(|i| (vector[i].change - by[i]).abs() < 1e-9));
        assert!(test.rank == 3 && test.p < 1e-6);
        let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
        assert!(compare(&a, &with(mirror)).unwrap().turn.is_none());
    }
}
