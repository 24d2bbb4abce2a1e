//! Does a calibration still fit later readings, and do two calibrations of one sensor differ?
//!
//! [`consistent`] answers both. What both sides of a difference share (the gravity of the place, the bends of
//! the sensor) cancels in it and is not counted twice.
//!
//! Working units: readings are divided by the nominal scale, so that M is about 1 and everything
//! is in m/s².

#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector, SMatrix, SymmetricEigen, Vector3};

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::consistent::{MAX_STEPS, Test, consistent};
use crate::model::{
    BENDS, BIAS, Covariance, DIRECTIONS, DRIFT, PARAMETERS, Parameters, bend, bias, invariants,
    jacobian, matrix, sensitivity, sphere, tangents,
};
use crate::sensor::{Gravity, Sensor, derivative_by_gravity, turn};

/// Directions this near to each other (chord of the unit sphere, 25°) share the model error.
const MODEL_ERROR_CHORD: f64 = 0.43;

/// What is usual of tilts, a factor of e, tells as much of their variance as half a tilt.
const OF_USUAL_TILT: f64 = 0.5;

/// Of δ² that the fit adds to a row on average.
const SHORTFALL: f64 = 0.125;

/// Values that stand for what tilts leave open of their variance.
const QUANTILES: usize = 24;

/// A mean reading at rest, in working units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticMean {
    /// Mean of the channels, at the temperature of reference.
    pub mean: [f64; 3],
    /// Standard deviation of this mean.
    pub sd: [f64; 3],
    /// Standard deviation of its length beside that, independent between intervals, m/s².
    pub sd_of_length_mps2: f64,
}

/// A static interval, calibrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    /// Specific force, axes of the board, m/s².
    pub force: [f64; 3],
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
        let force = |s: &StaticMean| inverse * (Vector3::from(s.mean) - bias(x, 0.0));
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
        let sd = Vector3::from(means[i].sd);
        let along = inverse.tr_mul(&directions[i]).component_mul(&sd);
        along.norm_squared() + means[i].sd_of_length_mps2.powi(2)
    };
    covariance += DMatrix::from_fn(means.len(), means.len(), |i, j| {
        let chord = (directions[i] - directions[j]).norm() / MODEL_ERROR_CHORD;
        let model_error = sensor.model_error_mps2.powi(2) * (-chord * chord).exp();
        of_gravity + model_error + if i == j { noise(i) } else { 0.0 }
    });
    let length = |i: usize| Length {
        force: forces[i].into(),
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
    pub value: Vec<f64>,
    /// Their standard deviations by both covariances.
    pub sd: Vec<f64>,
    /// All together.
    pub test: Test,
}

/// Two calibrations of one sensor, the second less the first.
#[derive(Debug, Clone, PartialEq)]
pub struct Compare {
    /// The nine [`invariants`] of each, with the same bends.
    pub invariants: [Vec<f64>; 2],
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
    pub largest_at: [f64; 3],
}

/// The placements on faces that a sensor was fitted to.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tilts {
    /// Specific force of each, unit vectors.
    pub faces: Vec<[f64; 3]>,
    /// Standard deviation of each of the two components of a tilt, rad.
    pub sd_rad: f64,
    /// Tilts that it was estimated from; infinite where it was given.
    pub freedom: f64,
}

/// Compares two calibrations of one sensor. None where a matrix is singular or a number is no
/// number.
///
/// Both have the same bends: the second calibration is moved to those of the first or the other
/// way round, whichever knows them better. If one knows nothing of them, neither is moved: what they
/// leave open of M and b is in the covariance of the other. Equal gravities share their error.
///
/// Where σ of the tilts was estimated from a few of them, a probability is the mean over what they leave
/// open of it: F in place of χ² where tilts are all that tells, and the test of Behrens and Fisher with
/// two of them (Fisher, Annals of Eugenics 6, 1935).
pub fn compare(pair: [(&Sensor, &Tilts); 2]) -> Option<Compare> {
    let [(a, _), (b, _)] = pair;
    if !a.is_finite() || !b.is_finite() {
        return None;
    }
    let gravity = a.gravity.value_mps2;
    let pair = Pair::new(pair)?;
    let invariants_of = |x: &Parameters| invariants(x).as_slice().to_vec();
    Some(Compare {
        norm: pair.norm(gravity)?,
        invariants: pair.parameters.each_ref().map(invariants_of),
        magnitude: pair.difference(|x, y| Some(invariants(y) - invariants(x)), products)?,
        turn: pair.difference(turned, |_, _, _| ()),
    })
}

/// What products of errors do to the lengths of the rows of M, which slopes know nothing of: takes their
/// expected value off a difference, and adds their covariance.
///
/// ‖a‖ of a pose is right whatever the angles between the axes. So an error δ of the angle xy changes the rows
/// x and y by −δ²/2, and two calibrations by −(δ_B² − δ_A²)/2 = −d (δ_A + δ_B)/2, of which the difference d of
/// their angles is known, and with it δ_A + δ_B: to d (v_B − v_A)/(v_A + v_B) and the variance
/// 4 v_A v_B/(v_A + v_B). Angles that six faces leave open by 1° are worth 1.5 mm/s².
///
/// `fitted` are the covariances by which the fit expected squares, `own` those that hold.
fn products(
    difference: &mut DVector<f64>,
    [fitted, own]: [[&DMatrix<f64>; 2]; 2],
    covariance: &mut DMatrix<f64>,
) {
    for (angle, rows) in [(6, [3, 4]), (7, [3, 5]), (8, [4, 5])] {
        let of = |both: [&DMatrix<f64>; 2]| both.map(|c| c[(angle, angle)]);
        let ([returned_a, returned_b], [a, b]) = (of(fitted), of(own));
        if a + b > 0.0 {
            let square = difference[angle].powi(2);
            let returned = SHORTFALL * (returned_b - returned_a);
            let mean = returned - square * (b - a) / (a + b) / 2.0;
            let variance = square * a * b / (a + b);
            for i in rows {
                difference[i] -= mean;
                rows.iter().for_each(|k| covariance[(i, *k)] += variance);
            }
        }
    }
}

/// Rotation vector (rad) of Q in M_A⁻¹ M_B = Q P: what a_A = Q a_B turns by. None where one frame
/// is the mirror image of the other, or a matrix is singular.
fn turned(a: &Parameters, b: &Parameters) -> Option<DVector<f64>> {
    turn(&(matrix(a).try_inverse()? * matrix(b)))
}

/// Two calibrations with the same bends.
struct Pair {
    parameters: [Parameters; 2],
    /// Of each, at known bends.
    covariances: [Covariance; 2],
    /// What tilts are to each.
    tilted: [Tilted; 2],
    /// Sources of error that both depend on with different derivatives: these, times the standard
    /// deviation. Bends, the gravity of the first, of the second.
    common: Vec<[Parameters; 2]>,
}

/// The part of a covariance that tilts have. With rows J of whitened angles of faces, C Jᵀ U and Λ of
/// J C Jᵀ = U Λ Uᵀ: with tilts of s times the variance it is C + (C Jᵀ U) D (C Jᵀ U)ᵀ, with
/// D = (1 − 1/s)/(1 − (1 − 1/s) Λ).
struct Tilted {
    gain: DMatrix<f64>,
    share: DVector<f64>,
    /// Equally probable values of s.
    factors: Vec<f64>,
}

impl Tilted {
    fn new(x: &Parameters, covariance: &Covariance, gravity: f64, tilts: &Tilts) -> Option<Tilted> {
        let to_force = matrix(x).try_inverse()?.transpose();
        let row = |face: &Vector3<f64>, across: Vector3<f64>| {
            let w = to_force * across / tilts.sd_rad;
            Parameters::from_fn(|i, _| match i {
                0..BIAS => w[i / 3] * face[i % 3],
                BIAS..DRIFT => w[i - BIAS] / gravity,
                _ => 0.0,
            })
        };
        let faces = tilts.faces.iter().map(|face| Vector3::from(*face));
        let rows = faces.flat_map(|face| tangents(&face).map(|across| row(&face, across)));
        let rows: Vec<Parameters> = rows
            .filter(|row| row.iter().all(|v| v.is_finite()))
            .collect();
        let by_tilts = DMatrix::from_fn(PARAMETERS, rows.len(), |i, k| rows[k][i]);
        let covariance = DMatrix::from_column_slice(PARAMETERS, PARAMETERS, covariance.as_slice());
        if rows.is_empty() {
            return Some(Tilted {
                gain: by_tilts,
                share: DVector::zeros(0),
                factors: vec![1.0],
            });
        }
        let taken = by_tilts.tr_mul(&covariance) * &by_tilts;
        let eigen = SymmetricEigen::try_new(taken, f64::EPSILON, MAX_STEPS)?;
        let open = ChiSquared::new(tilts.freedom + OF_USUAL_TILT);
        let open = open.ok().filter(|_| tilts.freedom.is_finite());
        let quantile = |i: usize| (i as f64 + 0.5) / QUANTILES as f64;
        Some(Tilted {
            gain: covariance * by_tilts * eigen.eigenvectors,
            share: eigen.eigenvalues.map(|share| share.clamp(0.0, 1.0)),
            factors: open.map_or(vec![1.0], |open| {
                let freedom = tilts.freedom + OF_USUAL_TILT;
                let factor = |i| freedom / open.inverse_cdf(quantile(i)).max(f64::EPSILON);
                (0..QUANTILES).map(factor).collect()
            }),
        })
    }

    /// What a covariance grows by with tilts of `factor` times the variance; `slopes` are those of what it is of.
    fn growth(&self, slopes: &DMatrix<f64>, factor: f64) -> DMatrix<f64> {
        let gain = slopes * &self.gain;
        let more = 1.0 - 1.0 / factor;
        let growth = self.share.map(|share| more / (1.0 - more * share));
        &gain * DMatrix::from_diagonal(&growth) * gain.transpose()
    }
}

impl Pair {
    /// At known bends C_mb C_bb⁺ is the derivative of the other parameters by these, and
    /// C_mm − C_mb C_bb⁺ C_bm is what is left.
    fn new(pair: [(&Sensor, &Tilts); 2]) -> Option<Pair> {
        const MIN_VARIANCE: f64 = 1e-14;
        let both = pair.map(|(sensor, _)| sensor);
        let spreads: [SMatrix<f64, 6, 6>; 2] =
            both.map(|s| s.covariance.fixed_view::<6, 6>(BENDS, BENDS).into());
        let known = spreads.iter().all(|spread| spread.trace() > 0.0);
        let better = usize::from(spreads[0].trace() > spreads[1].trace());
        let bends = both[better].parameters.fixed_rows::<6>(BENDS);
        let root = root(&spreads[better]);
        let (mut parameters, mut covariances) =
            (both.map(|s| s.parameters), both.map(|s| s.covariance));
        let mut steps = [SMatrix::<f64, PARAMETERS, 6>::zeros(); 2];
        for i in (0..2).filter(|_| known) {
            let with_bends: SMatrix<f64, PARAMETERS, 6> =
                both[i].covariance.fixed_columns::<6>(BENDS).into();
            let inverse = spreads[i].pseudo_inverse(MIN_VARIANCE).unwrap_or_default();
            let by_bends = with_bends * inverse;
            parameters[i] += by_bends * (bends - both[i].parameters.fixed_rows::<6>(BENDS));
            covariances[i] -= by_bends * with_bends.transpose();
            steps[i] = by_bends * root;
        }
        let one = |k: usize| steps.map(|step| step.column(k).into_owned());
        let mut common: Vec<[Parameters; 2]> = (0..6).map(one).collect();
        let [a, b] = both;
        if a.gravity != b.gravity {
            let none = Parameters::zeros();
            let by = |s: &Sensor| derivative_by_gravity(&s.parameters) * s.gravity.relative_sd();
            common.extend([[by(a), none], [none, by(b)]]);
        }
        let tilted = |i: usize| {
            let (sensor, tilts) = pair[i];
            let gravity = sensor.gravity.value_mps2;
            Tilted::new(&parameters[i], &covariances[i], gravity, tilts)
        };
        Some(Pair {
            tilted: [tilted(0)?, tilted(1)?],
            parameters,
            covariances,
            common,
        })
    }

    /// A difference of both; `curve` adds what is not linear in errors to it and to a covariance.
    fn difference(
        &self,
        f: impl Fn(&Parameters, &Parameters) -> Option<DVector<f64>>,
        curve: impl Fn(&mut DVector<f64>, [[&DMatrix<f64>; 2]; 2], &mut DMatrix<f64>),
    ) -> Option<Difference> {
        let [a, b] = &self.parameters;
        let value = f(a, b)?;
        let slopes = [jacobian(a, |x| f(x, b))?, jacobian(b, |x| f(a, x))?];
        let own = |i: usize| &slopes[i] * self.covariances[i] * slopes[i].transpose();
        let [of_a, of_b] = [own(0), own(1)];
        let mut common = DMatrix::zeros(value.len(), value.len());
        for [of_a, of_b] in &self.common {
            let slope = (f(&(a + of_a), &(b + of_b))? - f(&(a - of_a), &(b - of_b))?) / 2.0;
            common += &slope * slope.transpose();
        }
        // With tilts of other variances.
        let tested = |[more_a, more_b]: [&DMatrix<f64>; 2]| {
            let (own_a, own_b) = (&of_a + more_a, &of_b + more_b);
            let (mut straight, mut covariance) = (value.clone(), &own_a + &own_b + &common);
            let own = [[&of_a, &of_b], [&own_a, &own_b]];
            curve(&mut straight, own, &mut covariance);
            (consistent(&straight, &covariance), covariance)
        };
        let growths = [0, 1].map(|i: usize| {
            let factors = self.tilted[i].factors.iter();
            let growth = |factor: &f64| self.tilted[i].growth(&slopes[i], *factor);
            factors.map(growth).collect::<Vec<_>>()
        });
        let none = DMatrix::zeros(value.len(), value.len());
        let (test, covariance) = tested([&none, &none]);
        let [in_a, in_b] = &growths;
        let each = in_a.iter().flat_map(|a| in_b.iter().map(move |b| [a, b]));
        let p_values: f64 = each.map(|growth| tested(growth).0.p_value).sum();
        Some(Difference {
            sd: covariance
                .diagonal()
                .iter()
                .map(|v| v.max(0.0).sqrt())
                .collect(),
            test: Test {
                p_value: p_values / (in_a.len() * in_b.len()) as f64,
                ..test
            },
            value: value.as_slice().to_vec(),
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
            largest_at: each[largest].into(),
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
