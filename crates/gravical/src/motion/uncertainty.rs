//! How far the parameters of a calibration may be off, as a covariance of what that makes of a reading.
//!
//! With u = M a + b and A = M⁻¹ the specific force f = A (u − b) changes by δf = −A (δM f + δb), the
//! angular rate alike. The sign of a change means nothing.
//!
//! Whether the calibration fits the recording is seen at rest. There the calibrated magnitude is
//! gravity, to what its covariance and the noise of the mean allow. Where it is not, the
//! parameters are off by more than the covariance says, in ways that rests in one attitude
//! do not show: the bands then allow for an error of that size in each of them.

use gravical_core::matrix3::{identity, mul, norm, transpose};
use gravical_fit::model::Covariance;
use gravical_motion::{ElementErrors, ForceCovariance, RateCovariance, Samples};
use nalgebra::SVector;
use serde::Serialize;

use super::estimate::Estimate;
use crate::calibration_file::{Accelerometer, Calibration, GyroMethod};
use crate::poses::face::AxisMap;

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

/// Uncertainty of an accelerometer by the covariance of its parameters.
pub(super) fn by_covariance(
    section: &Accelerometer,
    covariance: &Covariance,
    axes: &AxisMap,
) -> ForceCovariance {
    let change = changes(axes, &section.matrix);
    change * covariance.fixed_view::<12, 12>(0, 0) * change.transpose()
}

/// That of the gyroscope that was calibrated by `file`: by its covariance where it has one of M, else by how it
/// was calibrated.
pub(super) fn of_gyroscope(file: Option<&Calibration>, axes: &AxisMap) -> RateCovariance {
    let Some(section) = file.and_then(|f| f.gyroscope.as_ref()) else {
        return GYRO_DATA_SHEET.rate();
    };
    let covariance = section.covariance.as_ref();
    match covariance.and_then(|c| c.of_parameters()) {
        Some(covariance) => {
            let change = changes(&axes.of_rates(), &section.matrix);
            let change = change.fixed_view::<9, 9>(0, 0);
            change * covariance.fixed_view::<9, 9>(0, 0) * change.transpose()
        }
        None if section.method == GyroMethod::Bias => GYRO_DATA_SHEET.rate(),
        None => UNSTATED.rate(),
    }
}

/// What the calibration changes in samples of `nominal` counts per m/s²: by so much samples are off
/// that were calibrated already when they came.
pub(super) fn applied_twice(
    section: &Accelerometer,
    nominal: f64,
    axes: &AxisMap,
) -> ForceCovariance {
    let mut parameters = SVector::<f64, 12>::zeros();
    for i in 0..3 {
        parameters[4 * i] = nominal;
        parameters[9 + i] = -section.bias[i];
    }
    let mut change = changes(axes, &section.matrix) * parameters;
    (0..3).for_each(|i| change[4 * i] -= 1.0);
    change * change.transpose()
}

/// The error A (M f + o) of a specific force in the axes of the case that each of the parameters makes, M row by
/// row and o, in columns.
fn changes(axes: &AxisMap, a: &[[f64; 3]; 3]) -> ForceCovariance {
    let turn = transpose(&identity().map(|e| axes.to_case(e)));
    let turned = mul(&turn, a);
    ForceCovariance::from_fn(|i, k| match (i < 9, k < 9) {
        (true, true) => turned[i / 3][k / 3] * turn[i % 3][k % 3],
        (false, false) => turned[i - 9][k - 9],
        _ => 0.0,
    })
}

/// Variance of the magnitude of a specific force, (m/s²)².
pub(super) fn variance_of_magnitude(covariance: &ForceCovariance, force: &[f64; 3]) -> f64 {
    let size = norm(force).max(f64::MIN_POSITIVE);
    let up = force.map(|f| f / size);
    let along = SVector::<f64, 12>::from_fn(|k, _| match k {
        0..9 => up[k / 3] * force[k % 3],
        _ => up[k - 9],
    });
    along.dot(&(covariance * along))
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
    /// with other `samples` of the same rows, in those; none without a rest.
    pub(super) fn worst(
        estimate: &Estimate,
        samples: &Samples,
        covariance: &ForceCovariance,
        gravity_mps2: f64,
    ) -> Option<Self> {
        let rests = estimate.motion.rests.iter();
        let noise = estimate.motion.noise?;
        let noise = noise.accel_n.into_iter().fold(0.0, f64::max);
        // The largest of many differences is larger by chance alone.
        let limit = (CONTRADICTS * CONTRADICTS + 2.0 * (rests.len().max(1) as f64).ln()).sqrt();
        let t = &samples.time_s;
        rests
            .map(|rest| {
                let [x, y, z, ..] = samples.mean(rest);
                let measured_mps2 = norm(&[x, y, z]);
                let seconds = (t[rest.end - 1] - t[rest.start]).max(f64::MIN_POSITIVE);
                let unstable = UNSTABLE * gravity_mps2;
                let variance = variance_of_magnitude(covariance, &[x, y, z])
                    .max(unstable * unstable)
                    + noise * noise / seconds;
                let sigma_mps2 = variance.sqrt();
                GravityMisfit {
                    rest_s: t[rest.start],
                    measured_mps2,
                    gravity_mps2,
                    sigma_mps2,
                    contradicts: (measured_mps2 - gravity_mps2).abs() / sigma_mps2 > limit,
                }
            })
            .max_by(|a, b| a.sigmas().total_cmp(&b.sigmas()))
    }

    /// The difference, in standard uncertainties.
    pub fn sigmas(&self) -> f64 {
        (self.measured_mps2 - self.gravity_mps2).abs() / self.sigma_mps2
    }

    /// Errors of every parameter that are as likely as what the rest shows.
    pub(super) fn covariance(&self) -> ForceCovariance {
        let off = UNSEEN * (self.measured_mps2 - self.gravity_mps2).abs();
        let relative = off / self.gravity_mps2;
        ElementErrors {
            scale: relative,
            cross: relative,
            bias_mps2: off,
        }
        .force()
    }
}
