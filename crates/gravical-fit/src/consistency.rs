//! Does a calibration still fit later readings, and do two calibrations of one sensor agree?
//!
//! Both ask whether a difference is larger than its covariance explains: the lengths of readings at rest
//! less gravity ([`check`]), or those of the readings that one calibration predicts for its own poses, by the
//! other ([`compare`]). Errors that both sides share (the gravity of the place, the nonlinearity of the sensor) cancel.
//!
//! Readings are divided by the nominal scale, so that M is about 1 and everything is in m/s².

#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector, SMatrix, SymmetricEigen, Vector3};
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use crate::model::{
    Covariance, DIRECTIONS, MAX_STEPS, NONLINEARITY, PARAMETERS, Parameters, bias, invariants,
    matrix, nonlinear_error, sphere, tangents,
};
use crate::pose::Face;
use crate::sensor::{Gravity, Sensor, derivative_by_gravity, turn};

/// Below this probability chance is no explanation.
pub const SIGNIFICANCE: f64 = 0.01;

/// Eigenvalues of a covariance below this fraction of the largest count as zero. Rounding leaves
/// 1e-16; a well-placed session has 1e-7 between its best and worst direction.
const RANK_TOLERANCE: f64 = 1e-12;

/// Directions this near to each other (chord of the unit sphere, 25°) share the model error.
const MODEL_ERROR_CHORD: f64 = 0.43;

/// Degrees of freedom of the prior of σ of the tilts, a factor of e: var(ln σ) = 1/2ν.
const PRIOR_FREEDOM: f64 = 0.5;

/// A difference held against its covariance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Test {
    /// dᵀ C⁺ d.
    pub chi2: f64,
    /// Rank of C: its degrees of freedom; 0 where there was nothing to test.
    pub degrees_of_freedom: usize,
    /// Probability that chance makes as much, by χ², or by F where C rests on tilts of which σ was estimated; 1
    /// where there was nothing to test.
    pub p_value: f64,
}

impl Test {
    /// By χ², or by F where the scale of C was estimated with `freedom`.
    fn new(chi2: f64, rank: usize, freedom: f64) -> Test {
        let size = rank as f64;
        let p_value = match FisherSnedecor::new(size, freedom) {
            Ok(f) if freedom < 1e6 => f.sf(chi2.max(0.0) / size),
            _ => ChiSquared::new(size).map_or(1.0, |d| d.sf(chi2.max(0.0))),
        };
        Test {
            chi2,
            degrees_of_freedom: rank,
            p_value: p_value.clamp(0.0, 1.0),
        }
    }
}

/// χ² and rank of a `difference` (n) by its `covariance` (n × n), and C⁺ d. C⁺ is the pseudo-inverse: what no
/// reading determines is not tested. Components have to be of similar size. Rank 0 where the covariance is
/// zero, not finite, or of another size.
fn chi_square(difference: &DVector<f64>, covariance: &DMatrix<f64>) -> (f64, usize, DVector<f64>) {
    let n = difference.len();
    let mut weighted = DVector::zeros(n);
    let mut values = difference.iter().chain(covariance);
    if n == 0 || covariance.shape() != (n, n) || !values.all(|v| v.is_finite()) {
        return (0.0, 0, weighted);
    }
    let symmetric = covariance * 0.5 + covariance.transpose() * 0.5;
    let Some(eigen) = SymmetricEigen::try_new(symmetric, f64::EPSILON, MAX_STEPS) else {
        return (0.0, 0, weighted);
    };
    let least = (RANK_TOLERANCE * eigen.eigenvalues.max()).max(0.0);
    let mut rank = 0;
    for (axis, variance) in eigen.eigenvectors.column_iter().zip(&eigen.eigenvalues) {
        if *variance > least {
            weighted.axpy(axis.dot(difference) / variance, &axis, 1.0);
            rank += 1;
        }
    }
    (weighted.dot(difference), rank, weighted)
}

/// What independent errors of one standard deviation do to a result, a column each: slopes s and curves q.
struct Effects {
    value: DVector<f64>,
    slopes: DMatrix<f64>,
    curves: DMatrix<f64>,
}

impl Effects {
    /// Of the errors `steps` of N sensors on `f`, from a `part` of each up and down: all of it where squares count;
    /// where they do not, little, since the third powers would look like what nothing determines. None where `f`
    /// has no value.
    fn new<const N: usize>(
        x: &SMatrix<f64, PARAMETERS, N>,
        steps: &[SMatrix<f64, PARAMETERS, N>],
        part: f64,
        f: impl Fn(&SMatrix<f64, PARAMETERS, N>) -> Option<DVector<f64>>,
    ) -> Option<Effects> {
        let value = f(x)?;
        let mut slopes = DMatrix::zeros(value.len(), steps.len());
        let mut curves = slopes.clone();
        for (k, step) in steps.iter().enumerate() {
            let (up, down) = (f(&(x + step * part))?, f(&(x - step * part))?);
            slopes.set_column(k, &((&up - &down) / (2.0 * part)));
            curves.set_column(k, &(((up + down) / 2.0 - &value) / (part * part)));
        }
        Some(Effects {
            value,
            slopes,
            curves,
        })
    }
}

/// Columns R with R Rᵀ = C, those that are zero left out.
fn steps(covariance: &Covariance) -> Option<Vec<Parameters>> {
    let eigen = SymmetricEigen::try_new(*covariance, f64::EPSILON, MAX_STEPS)?;
    let axes = eigen.eigenvectors.column_iter().zip(&eigen.eigenvalues);
    let axes = axes.filter(|(_, variance)| **variance > 0.0);
    Some(
        axes.map(|(axis, variance)| axis * variance.sqrt())
            .collect(),
    )
}

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
    /// ‖a‖ less gravity, the nonlinearity of the sensor taken off, m/s².
    pub error_mps2: f64,
    /// Its standard deviation, if the calibration fits, m/s².
    pub sd_mps2: f64,
}

/// Holds the lengths of static intervals against gravity: that of the calibration, or of another place,
/// `here`; and tests those that `count` together. None without one, or where a value is not finite.
///
/// The intervals share the errors of the parameters, of gravity and of the model; the noise of each mean is its
/// own. Errors of the parameters count with their squares, 2 Σ q qᵀ + (Σ q)(Σ q)ᵀ: a frame known to 2° lengthens
/// a reading by 0.06 %, which no slope shows.
pub fn check(
    sensor: &Sensor,
    here: Option<Gravity>,
    means: &[StaticMean],
    counts: impl Fn(usize) -> bool,
) -> Option<(Vec<Length>, Test)> {
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
        let error =
            |a: Vector3<f64>| a.norm() - gravity * (1.0 + nonlinear_error(x, &a.normalize()));
        let errors = DVector::from_iterator(means.len(), forces(x)?.into_iter().map(error));
        errors.iter().all(|e| e.is_finite()).then_some(errors)
    };
    let x = &sensor.parameters;
    let effects = Effects::new(x, &steps(&sensor.covariance)?, 1.0, errors)?;
    let (forces, inverse) = (forces(x)?, matrix(x).try_inverse()?);
    let directions: Vec<Vector3<f64>> = forces.iter().map(Vector3::normalize).collect();
    // Held against its own gravity, the error of that counts once.
    let elsewhere = here.map_or(0.0, |here| here.sd_mps2.powi(2));
    let of_gravity = sensor.gravity.sd_mps2.powi(2) + elsewhere;
    let noise = |i: usize| {
        let sd = Vector3::from(means[i].sd);
        let along = inverse.tr_mul(&directions[i]).component_mul(&sd);
        along.norm_squared() + means[i].sd_of_length_mps2.powi(2)
    };
    let mut covariance = DMatrix::from_fn(means.len(), means.len(), |i, k| {
        let chord = (directions[i] - directions[k]).norm() / MODEL_ERROR_CHORD;
        let model_error = sensor.model_error_mps2.powi(2) * (-chord * chord).exp();
        of_gravity + model_error + if i == k { noise(i) } else { 0.0 }
    });
    let curved = effects.curves.column_sum();
    covariance += &effects.slopes * effects.slopes.transpose();
    covariance += &effects.curves * effects.curves.transpose() * 2.0 + &curved * curved.transpose();
    let length = |i: usize| Length {
        force: forces[i].into(),
        error_mps2: effects.value[i],
        sd_mps2: covariance[(i, i)].sqrt(),
    };
    let (chi2, rank, _) = chi_square(
        &effects.value.select_rows(&counted),
        &covariance.select_rows(&counted).select_columns(&counted),
    );
    let lengths = (0..means.len()).map(length).collect();
    Some((lengths, Test::new(chi2, rank, f64::INFINITY)))
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
    /// The nine [`invariants`] of each, with the same nonlinearity.
    pub invariants: [Vec<f64>; 2],
    /// Their difference, and the test of what it does to ‖a‖ in the poses.
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
pub struct Placements {
    /// Calibrated specific force of each, any length.
    pub forces: Vec<[f64; 3]>,
    /// Standard deviation of each of the two components of a tilt, rad.
    pub tilt_rad: f64,
    /// Tilts that it was estimated from; infinite where it was given.
    pub freedom: f64,
}

/// Compares two calibrations of one sensor. None where a matrix is singular or a number is not finite.
///
/// *Magnitude.* A pose says that ‖a‖ = g along its own direction, whatever the angles between the axes are. Six
/// faces leave these open by δ, about the tilt, and with them the lengths of the rows of M by δ²/2 (6 mm/s² of g at
/// 2°, several times the noise), of which a covariance knows nothing. The length along a face as it lay is as
/// certain as its mean, so the test is of ‖a‖ by both for the same six readings, those that the less known one
/// predicts for its faces, and of the angles: δ² cancels, and products of δ with the tilt are slopes.
///
/// *Tilts.* σ of the tilts may be estimated from few of them, ν. With T the covariance by tilts and its share
/// w = dᵀC⁺TC⁺d/dᵀC⁺d, the test is F with 1/ν = w_A/ν_A + w_B/ν_B: exact if one estimated tilt is all that tells,
/// χ² if tilts tell nothing. Shares are not squared as by Welch (Biometrika 34, 1947), whose ν suits the mean and
/// not the tail: 1.7 % of equal pairs then differ at a level of 1 %.
///
/// *Nonlinearity.* Both have the same: one calibration is moved to those of the other, whichever knows them better. If
/// one knows nothing of them, neither is moved: what they leave open of M and b is in the covariance of the other.
pub fn compare(pair: [(&Sensor, &Placements); 2]) -> Option<Compare> {
    let sensors = pair.map(|(sensor, _)| sensor);
    if !sensors.iter().all(|sensor| sensor.is_finite()) {
        return None;
    }
    let both = Pair::new(sensors)?;
    let of = |x: &Both, i: usize| invariants(&x.column(i).into_owned());
    let invariants = both.effects(|x| Some(of(x, 1) - of(x, 0)))?;
    let everywhere: Vec<Vector3<f64>> = sphere(DIRECTIONS).collect();
    let norm = both.effects(|x| both.lengths(x, 0, &everywhere))?;
    let less_known = usize::from(sensors[1].predicted_mps2() > sensors[0].predicted_mps2());
    let directions = pair[less_known].1.directions();
    let magnitude = both.effects(|x| {
        let lengths = both.lengths(x, less_known, &directions)?;
        let angles = (of(x, 1) - of(x, 0)).rows(6, 3) * both.gravity_mps2[0];
        Some(DVector::from_iterator(
            9,
            lengths.iter().chain(&angles).copied(),
        ))
    })?;
    let tilts = [0, 1].map(|i| both.tilts(i, pair[i].1));
    let largest = norm.value.iamax();
    Some(Compare {
        invariants: [0, 1].map(|i| of(&both.x, i).as_slice().to_vec()),
        magnitude: Difference::new(&invariants, magnitude.test(&tilts)),
        turn: both
            .effects(turned)
            .map(|turn| Difference::new(&turn, turn.test(&tilts))),
        norm: NormDifference {
            rms_mps2: norm.value.norm() / (DIRECTIONS as f64).sqrt(),
            predicted_rms_mps2: norm.slopes.norm() / (DIRECTIONS as f64).sqrt(),
            largest_mps2: norm.value[largest],
            largest_at: everywhere[largest].into(),
        },
    })
}

impl Placements {
    /// Where each face lay, on average; one that is missing lies exactly.
    fn directions(&self) -> [Vector3<f64>; 6] {
        Face::all().map(|face| {
            let own = self.forces.iter().filter(|a| Face::nearest(**a).0 == face);
            let sum: Vector3<f64> = own.map(|a| Vector3::from(*a).normalize()).sum();
            sum.try_normalize(0.5)
                .unwrap_or_else(|| face.direction().into())
        })
    }
}

impl Difference {
    fn new(effects: &Effects, test: Test) -> Difference {
        Difference {
            value: effects.value.as_slice().to_vec(),
            sd: effects.slopes.row_iter().map(|row| row.norm()).collect(),
            test,
        }
    }
}

impl Effects {
    /// With the effects of the same errors on tilts, over σ of these, and the degrees of freedom of that σ.
    fn test(&self, tilts: &[Option<(Effects, f64)>]) -> Test {
        let (chi2, rank, weighted) =
            chi_square(&self.value, &(&self.slopes * self.slopes.transpose()));
        let by_errors = self.slopes.tr_mul(&weighted);
        let term = |(tilts, freedom): &(Effects, f64)| {
            let share = (&tilts.slopes * &by_errors).norm_squared() / chi2.max(f64::MIN_POSITIVE);
            share / freedom
        };
        let inverse: f64 = tilts.iter().flatten().map(term).sum();
        Test::new(chi2, rank, 1.0 / inverse)
    }
}

/// Parameters of two sensors.
type Both = SMatrix<f64, PARAMETERS, 2>;

/// Two calibrations with the same nonlinearity.
struct Pair {
    x: Both,
    gravity_mps2: [f64; 2],
    /// Errors of one standard deviation: of each at known nonlinearity, then of nonlinearity and gravities.
    steps: Vec<Both>,
}

impl Pair {
    /// C_mb C_bb⁺ is the derivative of the other parameters by the nonlinearity, and C_mm − C_mb C_bb⁺ C_bm is what is
    /// left at known nonlinearity. Gravities that are equal have the same error.
    fn new(sensors: [&Sensor; 2]) -> Option<Pair> {
        const MIN_VARIANCE: f64 = 1e-14;
        type Nonlinearity<const R: usize> = SMatrix<f64, R, 6>;
        let spreads: [Nonlinearity<6>; 2] = sensors.map(|s| {
            s.covariance
                .fixed_view::<6, 6>(NONLINEARITY, NONLINEARITY)
                .into()
        });
        let are_known = spreads.iter().all(|spread| spread.trace() > 0.0);
        let better = usize::from(spreads[0].trace() > spreads[1].trace());
        let nonlinearity = sensors[better].parameters.fixed_rows::<6>(NONLINEARITY);
        let of_one = |i: usize, step: Parameters| {
            let mut both = Both::zeros();
            both.set_column(i, &step);
            both
        };
        let mut x = Both::from_columns(&sensors.map(|s| s.parameters));
        let mut by_nonlinearity = [Nonlinearity::<PARAMETERS>::zeros(); 2];
        let mut errors = Vec::new();
        for (i, sensor) in sensors.into_iter().enumerate() {
            let mut covariance = sensor.covariance;
            if are_known {
                let with_nonlinearity: Nonlinearity<PARAMETERS> =
                    covariance.fixed_columns::<6>(NONLINEARITY).into();
                by_nonlinearity[i] =
                    with_nonlinearity * spreads[i].pseudo_inverse(MIN_VARIANCE).ok()?;
                let change = nonlinearity - sensor.parameters.fixed_rows::<6>(NONLINEARITY);
                x += of_one(i, by_nonlinearity[i] * change);
                covariance -= by_nonlinearity[i] * with_nonlinearity.transpose();
            }
            errors.extend(steps(&covariance)?.into_iter().map(|step| of_one(i, step)));
            if sensors[0].gravity != sensors[1].gravity {
                let by_gravity = derivative_by_gravity(&sensor.parameters);
                errors.push(of_one(i, by_gravity * sensor.gravity.relative_sd()));
            }
        }
        if are_known {
            let mut covariance = Covariance::zeros();
            covariance
                .fixed_view_mut::<6, 6>(NONLINEARITY, NONLINEARITY)
                .copy_from(&spreads[better]);
            errors.extend(steps(&covariance)?.iter().map(|step| {
                Both::from_columns(
                    &by_nonlinearity.map(|by| by * step.fixed_rows::<6>(NONLINEARITY)),
                )
            }));
        }
        let gravity_mps2 = sensors.map(|s| s.gravity.value_mps2);
        Some(Pair {
            x,
            gravity_mps2,
            steps: errors,
        })
    }

    fn effects(&self, f: impl Fn(&Both) -> Option<DVector<f64>>) -> Option<Effects> {
        Effects::new(&self.x, &self.steps, 1e-4, f)
    }

    /// ‖a‖ by the second calibration less that by the first, of what calibration `i` reads at rest in some `directions`.
    fn lengths(&self, x: &Both, i: usize, directions: &[Vector3<f64>]) -> Option<DVector<f64>> {
        let (from, gravity) = (self.x.column(i).into_owned(), self.gravity_mps2[i]);
        let mut out = DVector::zeros(directions.len());
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let by = x.column(side).into_owned();
            let inverse = matrix(&by).try_inverse()?;
            for (k, n) in directions.iter().enumerate() {
                let reading = matrix(&from) * n * gravity + bias(&from, 0.0);
                out[k] += sign * (inverse * (reading - bias(&by, 0.0))).norm();
            }
        }
        Some(out)
    }

    /// What errors make of the tilts of the faces of calibration `i`, over their σ, if that was estimated; and
    /// how many tilts it was estimated from.
    fn tilts(&self, i: usize, placements: &Placements) -> Option<(Effects, f64)> {
        let x = self.x.column(i).into_owned();
        let gravity = self.gravity_mps2[i];
        let unit = gravity * placements.tilt_rad;
        let faces = placements.forces.iter().map(|a| Face::nearest(*a).0);
        let faces: Vec<_> = faces.map(|face| Vector3::from(face.direction())).collect();
        let tilts = |both: &Both| {
            let erroneous = both.column(i).into_owned();
            let inverse = matrix(&erroneous).try_inverse()?;
            let offset = bias(&x, 0.0) - bias(&erroneous, 0.0);
            let angles = faces.iter().flat_map(|n| {
                let force = inverse * (matrix(&x) * n * gravity + offset);
                tangents(n).map(|across| across.dot(&force) / unit)
            });
            Some(DVector::from_vec(angles.collect()))
        };
        let is_estimated = placements.freedom.is_finite() && unit > 0.0;
        let effects = is_estimated.then(|| self.effects(tilts))??;
        Some((effects, placements.freedom + PRIOR_FREEDOM))
    }
}

/// Rotation vector (rad) of Q in M_A⁻¹ M_B = Q P: what a_A = Q a_B turns by. None where one frame
/// is the mirror image of the other, or a matrix is singular.
fn turned(x: &Both) -> Option<DVector<f64>> {
    let [a, b] = [0, 1].map(|i| matrix(&x.column(i).into_owned()));
    turn(&(a.try_inverse()? * b))
}
