//! How far the parameters of a calibration may be off, as directions: each is a change of all
//! parameters together by one standard deviation, independent of the others.
//!
//! With u = M a + b and A = M⁻¹ the specific force f = A (u − b) changes by δf = −A (δM f + δb), the
//! angular rate alike. The sign of a direction means nothing.
//!
//! Whether the calibration fits the recording is seen at rest. There the calibrated magnitude is
//! gravity, to what its covariance and the noise of the mean allow. Where it is not, the
//! parameters are off by more than the covariance says, in directions that rests in one attitude
//! do not show: the bands then allow for an error of that size in each of them.

use gravical_core::matrix3::{mul, mul_vec, norm, transpose};
use gravical_fit::model::Covariance;
use gravical_motion::{ElementErrors, ForceDirection, Samples};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::estimate::Estimate;
use crate::calibration_file::{AccelerometerSection, CalibrationFile, GyroMethod};
use crate::poses::face::AxisMap;

/// Parameters of an accelerometer: nine of M, three of b.
const PARAMETERS: usize = 12;

/// Data sheet of the MPU6050, which is that of most cheap parts: ±3 % and ±0.6 m/s² are limits, between
/// which any value is as likely (JCGM 100:2008, 4.3.7), and a board sits askew by a degree.
pub(super) const DATA_SHEET: ElementErrors = ElementErrors {
    scale: 0.02,
    cross: 0.02,
    bias_mps2: 0.35,
};

/// Its gyroscope: limits of ±3 % of scale and ±2 % cross-axis.
const GYRO_DATA_SHEET: ElementErrors = ElementErrors {
    scale: 0.0173,
    cross: 0.0115,
    bias_mps2: 0.0,
};

/// A calibration that says nothing of its uncertainty: what six careful placements reach, or fitted turns.
pub(super) const UNSTATED: ElementErrors = ElementErrors {
    scale: 0.005,
    cross: 0.01,
    bias_mps2: 0.02,
};

/// Directions of an accelerometer by a covariance of its parameters.
pub(super) fn by_covariance(
    section: &AccelerometerSection,
    covariance: &Covariance,
    axes: &AxisMap,
) -> Vec<ForceDirection> {
    let a = &section.matrix;
    factor(&DMatrix::from_fn(PARAMETERS, PARAMETERS, |i, j| {
        covariance[(i, j)]
    }))
    .iter()
    .map(|step| ForceDirection {
        matrix: in_case(axes, &mul(a, &square(step))),
        offset: axes.to_case(mul_vec(a, &[step[9], step[10], step[11]])),
    })
    .collect()
}

/// Directions of the gyroscope that was calibrated by `file`: by its covariance where it has one of M,
/// else by how it was calibrated.
pub(super) fn of_gyroscope(file: Option<&CalibrationFile>, axes: &AxisMap) -> Vec<[[f64; 3]; 3]> {
    let Some(section) = file.and_then(|f| f.gyroscope.as_ref()) else {
        return GYRO_DATA_SHEET.matrices();
    };
    let covariance = section.covariance.as_ref().filter(|c| {
        let is_known = |row: &Vec<f64>| row.len() >= 9 && row.iter().all(|v| v.is_finite());
        c.values.len() >= 9 && c.values.iter().all(is_known)
    });
    match covariance {
        Some(c) => factor(&DMatrix::from_fn(9, 9, |i, j| c.values[i][j]))
            .iter()
            .map(|step| in_case(&axes.of_rates(), &mul(&section.matrix, &square(step))))
            .collect(),
        None if section.method == GyroMethod::Bias => GYRO_DATA_SHEET.matrices(),
        None => UNSTATED.matrices(),
    }
}

/// What the calibration changes in samples of `nominal` counts per m/s²: by so much samples are off
/// that were calibrated already when they came.
pub(super) fn applied_twice(
    section: &AccelerometerSection,
    nominal: f64,
    axes: &AxisMap,
) -> ForceDirection {
    let mut change = section.matrix.map(|row| row.map(|v| v * nominal));
    for (i, row) in change.iter_mut().enumerate() {
        row[i] -= 1.0;
    }
    ForceDirection {
        matrix: in_case(axes, &change),
        offset: axes.to_case(mul_vec(&section.matrix, &section.bias).map(|v| -v)),
    }
}

/// Variance of the magnitude of a specific force by these directions, (m/s²)².
pub(super) fn variance_of_magnitude(directions: &[ForceDirection], force: &[f64; 3]) -> f64 {
    let size = norm(force);
    let up = if size > 0.0 {
        force.map(|f| f / size)
    } else {
        [0.0, 0.0, 1.0]
    };
    let along = |d: &ForceDirection| -> f64 {
        let turned = mul_vec(&d.matrix, force);
        (0..3).map(|c| (turned[c] + d.offset[c]) * up[c]).sum()
    };
    directions.iter().map(|d| along(d).powi(2)).sum()
}

/// The same uncertainty in twelve directions.
pub(super) fn in_twelve(directions: Vec<ForceDirection>) -> Vec<ForceDirection> {
    if directions.len() <= PARAMETERS {
        return directions;
    }
    let columns: Vec<DVector<f64>> = directions
        .iter()
        .map(|d| {
            let all = d.matrix.as_flattened().iter().chain(&d.offset);
            DVector::from_iterator(PARAMETERS, all.copied())
        })
        .collect();
    let all = DMatrix::from_columns(&columns);
    factor(&(&all * all.transpose()))
        .iter()
        .map(|step| ForceDirection {
            matrix: square(step),
            offset: [step[9], step[10], step[11]],
        })
        .collect()
}

/// Columns of L with C = L Lᵀ, by the eigenvectors of the correlations: a covariance may be singular.
fn factor(c: &DMatrix<f64>) -> Vec<DVector<f64>> {
    let sd = c.diagonal().map(|v| v.max(0.0).sqrt());
    let unit = sd.map(|s| if s > 0.0 { s } else { 1.0 });
    let correlation = DMatrix::from_fn(c.nrows(), c.nrows(), |i, j| {
        0.5 * (c[(i, j)] + c[(j, i)]) / unit[i] / unit[j]
    });
    let eigen = correlation.symmetric_eigen();
    (0..c.nrows())
        .map(|k| {
            let column = eigen.eigenvectors.column(k).component_mul(&sd);
            column * eigen.eigenvalues[k].max(0.0).sqrt()
        })
        .collect()
}

/// The first nine, row by row.
fn square(step: &DVector<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| step[3 * i + j]))
}

/// A matrix of the board in the axes of the case.
fn in_case(axes: &AxisMap, m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        .map(|e| axes.to_case(mul_vec(m, &axes.to_board(e))));
    transpose(&columns)
}

/// Standard deviations beyond which one rest contradicts the calibration: one in 16,000.
const CONTRADICTS: f64 = 4.0;

/// What a calibration of a cheap part drifts by within hours, relative to gravity.
const UNSTABLE: f64 = 1e-3;

/// A rest shows one of six directions in which the parameters may be off; in the others it may
/// be more.
const UNSEEN: f64 = 2.0;

/// Gravity as it is measured at a rest: that of all rests at which it is off most.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GravityMisfit {
    /// Start of the rest, s.
    pub rest_s: f64,
    /// Magnitude of the mean calibrated specific force at the rest, m/s².
    pub measured_mps2: f64,
    /// Local gravity, m/s².
    pub gravity_mps2: f64,
    /// Standard uncertainty of the difference that calibration and noise allow, m/s².
    pub sigma_mps2: f64,
    /// The difference contradicts the calibration, which no longer describes this sensor; the
    /// bands are widened by it.
    pub contradicts: bool,
}

impl GravityMisfit {
    /// Of the rests of `estimate`, the one at which gravity is off most, as `estimate` was calibrated or,
    /// with other `samples` of the same rows, in those; none without a rest. A causal run knows the first
    /// one when it begins to move.
    pub(super) fn worst(
        estimate: &Estimate,
        samples: &Samples,
        directions: &[ForceDirection],
        gravity_mps2: f64,
        causal: bool,
    ) -> Option<Self> {
        let mut rests = estimate.rests_in(samples);
        rests.truncate(if causal { 1 } else { rests.len() });
        let noise = estimate.motion.noise?;
        let noise = noise.force_mps2_sqrt_s.into_iter().fold(0.0, f64::max);
        let t = samples.time_s();
        // The largest of many differences is larger by chance alone.
        let limit = (CONTRADICTS * CONTRADICTS + 2.0 * (rests.len().max(1) as f64).ln()).sqrt();
        let channels = samples.channels();
        rests
            .iter()
            .map(|rest| {
                let [x, y, z, ..] = channels.mean(rest);
                let measured_mps2 = norm(&[x, y, z]);
                let seconds = (t[rest.end - 1] - t[rest.start]).max(f64::MIN_POSITIVE);
                let unstable = UNSTABLE * gravity_mps2;
                let variance = variance_of_magnitude(directions, &[x, y, z])
                    .max(unstable * unstable)
                    + noise * noise / seconds;
                let mut one = GravityMisfit {
                    rest_s: t[rest.start],
                    measured_mps2,
                    gravity_mps2,
                    sigma_mps2: variance.sqrt(),
                    contradicts: false,
                };
                one.contradicts = one.sigmas() > limit;
                one
            })
            .max_by(|a, b| a.sigmas().total_cmp(&b.sigmas()))
    }

    /// The difference, in standard uncertainties.
    #[must_use]
    pub fn sigmas(&self) -> f64 {
        (self.measured_mps2 - self.gravity_mps2).abs() / self.sigma_mps2
    }

    /// Errors of every parameter that are as likely as what the rest shows.
    pub(super) fn directions(&self) -> Vec<ForceDirection> {
        let off = UNSEEN * (self.measured_mps2 - self.gravity_mps2).abs();
        let relative = off / self.gravity_mps2;
        ElementErrors {
            scale: relative,
            cross: relative,
            bias_mps2: off,
        }
        .directions()
    }
}
