//! The errors of all stills with their joint covariance.

use gravical_core::matrix3::{inverse, mul_vec, norm};
use nalgebra::{Cholesky, DMatrix, DVector, SMatrix, SVector};

use super::rests::Rest;
use crate::calibrate::DRIFT_MPS2_PER_C;
use crate::calibration_file::AccelerometerSection;
use crate::gravity::Gravity;
use crate::predicted::{sensitivity, variance};
use crate::uncertainty::{Covariance12, norm_curvature};

/// No mean of a cheap accelerometer is better than this, m/s² (0.1 mg): its bias
/// wanders by as much from one minute to the next.
pub const FLOOR_MPS2: f64 = 0.001;

/// A rest of T seconds, cut out of a motion that comes to its end, may begin and
/// end at speeds that differ by this, m/s; its mean is off by as much over T. It
/// is 0.7 mg at 0.15 s and nothing at 3 s.
pub const REST_SPEED_MPS: f64 = 0.001;

/// Temperatures of a calibration and of a check that nobody recorded differ by
/// this, °C: a part that has just been switched on warms up by as much in some
/// minutes.
const UNKNOWN_TEMPERATURE_C: f64 = 2.0;

/// The covariance of a calibration, in the input unit, at a temperature that may
/// be another one: `differs` where it is not known to be the same.
pub(super) fn at_another_time(
    section: &AccelerometerSection,
    covariance: &Covariance12,
    differs: bool,
) -> Covariance12 {
    let mut out = *covariance;
    let drift = f64::from(differs) * UNKNOWN_TEMPERATURE_C * DRIFT_MPS2_PER_C;
    for axis in 0..3 {
        out[9 + axis][9 + axis] += (drift * section.scale[axis]).powi(2);
    }
    out
}

/// Poses this near to each other (chord of the unit sphere, 25°) share what the
/// model of twelve parameters leaves out.
const MODEL_LENGTH: f64 = 0.43;

/// A still reading and how well its length is known.
pub(super) struct Place {
    /// As it was read, input unit of the calibration.
    pub raw: [f64; 3],
    /// Unit vector of it, calibrated (axes of the board).
    pub direction: [f64; 3],
    /// Its length, m/s².
    pub length: f64,
    /// Variance of the length by the reading.
    pub reading_variance: f64,
    /// Variance by the calibration, its model error, and gravity where it is not
    /// given; none without a covariance.
    pub calibration_variance: Option<f64>,
}

impl Place {
    pub fn new(
        section: &AccelerometerSection,
        covariance: Option<&Covariance12>,
        rest: &Rest,
        calibrated: [f64; 3],
        gravity: &Gravity,
    ) -> Self {
        let length = norm(&calibrated);
        let direction = calibrated.map(|v| v / length.max(f64::MIN_POSITIVE));
        Place {
            raw: rest.mean,
            direction,
            length,
            reading_variance: reading_variance(
                &section.matrix,
                direction,
                rest.standard_error,
                rest.duration_s,
            ),
            calibration_variance: covariance.map(|c| {
                calibration_variance(section, c, direction, gravity.value_mps2)
                    + model_error(section).powi(2)
                    + gravity.uncertainty_mps2().powi(2)
            }),
        }
    }
}

/// What real sensors miss the model of twelve parameters by when nothing tells,
/// m/s²: 1.1 to 1.9 rms on three MPU-9150 and an MTi, some 40 poses each.
const USUAL_MODEL_ERROR_MPS2: f64 = 0.002;

/// What readings miss the model of twelve parameters by, m/s²: what the fit says
/// of itself, or what is usual where it leaves nothing to tell, else the error on placements that were left out beyond the
/// predicted one.
fn model_error(section: &AccelerometerSection) -> f64 {
    if let Some(fit) = &section.fit {
        let nothing_tells = fit.freedom < 1.0;
        let least = if nothing_tells {
            USUAL_MODEL_ERROR_MPS2
        } else {
            0.0
        };
        return fit.model_error_mps2.max(least);
    }
    let left_out = section.leave_one_out_rms_mps2.unwrap_or(0.0);
    let predicted = section.predicted_norm_error_mps2.unwrap_or(0.0);
    (left_out * left_out - predicted * predicted)
        .max(0.0)
        .sqrt()
}

/// Variance of ‖a‖ by the noise of a mean with standard errors `error` along
/// `direction`, by an unseen speed in a still of `duration_s`, and by the floor.
fn reading_variance(
    matrix: &[[f64; 3]; 3],
    direction: [f64; 3],
    error: Option<[f64; 3]>,
    duration_s: Option<f64>,
) -> f64 {
    let noise = error.map_or(0.0, |error| {
        (0..3)
            .map(|i| {
                let w: f64 = (0..3).map(|k| matrix[k][i] * direction[k]).sum();
                (w * error[i]).powi(2)
            })
            .sum()
    });
    let speed = duration_s
        .filter(|t| *t > 0.0)
        .map_or(0.0, |t| REST_SPEED_MPS / t);
    noise + speed * speed + FLOOR_MPS2 * FLOOR_MPS2
}

/// Steps of the iteration; it settles in a few.
const MOST_STEPS: usize = 30;

/// Errors of ‖a‖ with their covariance V = H C Hᵀ + R, R of readings and model.
pub(super) struct Spread {
    /// Errors as they would be if ‖a‖ were linear in the parameters.
    pub errors: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// Degrees of freedom of Student's t whose tails the errors have; none where they
    /// are as good as normal.
    pub freedom: Option<f64>,
}

/// Excess of the kurtosis of a product of two normal errors.
const EXCESS_OF_PRODUCTS: f64 = 6.0;

/// Degrees of freedom of the Student's t whose tails errors with the covariance
/// `whole` have, of which `second` is that of products of normal ones. A part of the
/// variance gives its share squared of a product's excess kurtosis, here the mean over
/// the whitened errors; that of Student's t is 6/(ν − 4).
fn tails(whole: &DMatrix<f64>, second: &DMatrix<f64>) -> Option<f64> {
    let shares = Cholesky::new(whole.clone())?.solve(second);
    let mean_square = (&shares * &shares).trace() / whole.nrows() as f64;
    let excess = EXCESS_OF_PRODUCTS * mean_square;
    Some(4.0 + 6.0 / excess).filter(|nu| *nu < 1e3)
}

/// Holds the readings against `gravity`; none where that is not possible in
/// numbers.
///
/// ‖a‖ is no linear function of the parameters: of a session with a tilt of 2.4°
/// the second order is 10 mm/s², many times the noise of a mean. So the least of
/// dᵀC⁻¹d + rᵀR⁻¹r is looked for over errors d of the parameters, r what is left
/// of the errors of ‖a‖ once d is taken off. By Gauss and Newton: with H the
/// derivatives at d and y = r − H d, it is yᵀ V⁻¹ y at d = −C Hᵀ V⁻¹ y. Without
/// curvature that is eᵀ V⁻¹ e at once.
pub(super) fn spread(
    section: &AccelerometerSection,
    covariance: &Covariance12,
    places: &[&Place],
    gravity: &Gravity,
) -> Option<Spread> {
    let common = gravity.uncertainty_mps2().powi(2);
    let gravity = gravity.value_mps2;
    let c = SMatrix::<f64, 12, 12>::from_fn(|r, k| covariance[r][k]);
    let second = second_order(section, &c, places, gravity);
    let mut r = readings(section, places) + &second;
    // All stills stand in the same place.
    r.add_scalar_mut(common);
    let model = inverse(&section.matrix)?;
    let mut d = SVector::<f64, 12>::zeros();
    let mut last: Option<(f64, Spread)> = None;
    for _ in 0..MOST_STEPS {
        let Some((left, h)) = residuals(&model, &section.bias, &d, places, gravity) else {
            break;
        };
        let y = left - &h * d;
        let ch = &h * c;
        let v = &ch * h.transpose() + &r;
        let Some(solved) = Cholesky::new(v.clone()).map(|v| v.solve(&y)) else {
            break;
        };
        let chi2 = y.dot(&solved);
        d = SVector::<f64, 12>::from_iterator((ch.transpose() * -solved).iter().copied());
        let settled = last
            .as_ref()
            .is_some_and(|(before, _)| (chi2 - before).abs() < 1e-6 * (1.0 + chi2));
        let spread = Spread {
            errors: y,
            freedom: tails(&v, &second),
            covariance: v,
        };
        last = Some((chi2, spread));
        if settled {
            break;
        }
    }
    last.map(|(_, spread)| spread)
}

/// Errors of ‖a‖ once `d` is taken off the parameters, and their derivatives
/// by d.
fn residuals(
    model: &[[f64; 3]; 3],
    bias: &[f64; 3],
    d: &SVector<f64, 12>,
    places: &[&Place],
    gravity: f64,
) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let moved: [[f64; 3]; 3] =
        std::array::from_fn(|r| std::array::from_fn(|k| model[r][k] - d[3 * r + k]));
    let matrix = inverse(&moved)?;
    let mut left = DVector::zeros(places.len());
    let mut h = DMatrix::zeros(places.len(), 12);
    for (i, place) in places.iter().enumerate() {
        let a = mul_vec(
            &matrix,
            &std::array::from_fn(|k| place.raw[k] - bias[k] + d[9 + k]),
        );
        let length = norm(&a).max(f64::MIN_POSITIVE);
        left[i] = length - gravity;
        let row = sensitivity(&matrix, a.map(|v| v / length), length);
        (0..12).for_each(|k| h[(i, k)] = row[k]);
    }
    Some((left, h))
}

/// Variance of ‖a‖ along `direction` by the calibration: hᵀCh, and the second
/// order. Of normal errors d of the parameters the second-order part dᵀQ d has the mean
/// square 2 tr(QCQC) + tr(QC)².
fn calibration_variance(
    section: &AccelerometerSection,
    covariance: &Covariance12,
    direction: [f64; 3],
    gravity: f64,
) -> f64 {
    let h = sensitivity(&section.matrix, direction, gravity);
    let c = SMatrix::<f64, 12, 12>::from_fn(|r, k| covariance[r][k]);
    let qc = norm_curvature(&section.matrix, direction, gravity) * c;
    let second = 2.0 * (qc * qc).trace() + qc.trace().powi(2);
    (variance(covariance, &h) + second).max(0.0)
}

/// The covariance of a session is itself of first order in the tilts of its
/// placements. What that neglects has the size of the second order of ‖a‖, for
/// normal errors 2 tr(Q_i C Q_j C) + tr(Q_i C) tr(Q_j C), and heavier tails.
fn second_order(
    section: &AccelerometerSection,
    c: &SMatrix<f64, 12, 12>,
    places: &[&Place],
    gravity: f64,
) -> DMatrix<f64> {
    let qc: Vec<SMatrix<f64, 12, 12>> = places
        .iter()
        .map(|p| norm_curvature(&section.matrix, p.direction, gravity) * c)
        .collect();
    DMatrix::from_fn(places.len(), places.len(), |i, j| {
        let trace = qc[i].component_mul(&qc[j].transpose()).sum();
        2.0 * trace + qc[i].trace() * qc[j].trace()
    })
}

/// Covariance of what does not come from the parameters.
fn readings(section: &AccelerometerSection, places: &[&Place]) -> DMatrix<f64> {
    let model = model_error(section).powi(2);
    DMatrix::from_fn(places.len(), places.len(), |i, j| {
        let chord: f64 = (0..3)
            .map(|k| (places[i].direction[k] - places[j].direction[k]).powi(2))
            .sum();
        let reading = if i == j {
            places[i].reading_variance
        } else {
            0.0
        };
        model * (-chord / (MODEL_LENGTH * MODEL_LENGTH)).exp() + reading
    })
}

/// Without a covariance: every still by itself, uncertain by `sigma` each.
pub(super) fn assumed(places: &[&Place], sigma: f64) -> DMatrix<f64> {
    DMatrix::from_diagonal(&DVector::from_iterator(
        places.len(),
        places.iter().map(|p| p.reading_variance + sigma * sigma),
    ))
}
