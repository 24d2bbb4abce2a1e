//! What a user notices: the difference of ‖a‖ over all directions, and the
//! gyroscopes.

use gravical_core::matrix3::{mul_vec, norm};

use super::types::GyroscopeDifference;
use super::unit::NominalModel;
use crate::calibration_file::CalibrationFile;
use crate::predicted::{sensitivity, sphere, variance};

/// Directions that are looked at.
const DIRECTIONS: usize = 400;

pub(super) struct Norms {
    pub rms: f64,
    pub largest: f64,
    pub largest_at: [f64; 3],
    pub predicted_rms: Option<f64>,
    pub predicted_at_largest: Option<f64>,
}

/// ‖a‖ by B less ‖a‖ by A for readings that A calls rest, in every direction;
/// and its standard deviation by both covariances.
pub(super) fn difference(a: &NominalModel, b: &NominalModel) -> Norms {
    let (mut squares, mut variances) = (0.0, Some(0.0));
    let (mut largest, mut at, mut variance_at) = (0.0_f64, [0.0; 3], None);
    for n in sphere(DIRECTIONS) {
        let raw = mul_vec(&a.model, &n.map(|v| a.gravity * v));
        let over: [f64; 3] = std::array::from_fn(|i| raw[i] + a.bias[i] - b.bias[i]);
        let by_b = mul_vec(&b.matrix, &over);
        let length = norm(&by_b);
        let off = length - a.gravity;
        squares += off * off;
        let here = a
            .covariance
            .as_ref()
            .zip(b.covariance.as_ref())
            .map(|(ca, cb)| {
                let ha = sensitivity(&a.matrix, n, a.gravity);
                let hb = sensitivity(&b.matrix, by_b.map(|v| v / length), length);
                variance(ca, &ha) + variance(cb, &hb)
            });
        variances = variances.zip(here).map(|(sum, v)| sum + v);
        if off.abs() > largest.abs() {
            (largest, at, variance_at) = (off, n, here);
        }
    }
    let root = |v: f64| v.max(0.0).sqrt();
    Norms {
        rms: (squares / DIRECTIONS as f64).sqrt(),
        largest,
        largest_at: at,
        predicted_rms: variances.map(|sum| root(sum / DIRECTIONS as f64)),
        predicted_at_largest: variance_at.map(root),
    }
}

impl NominalModel {
    /// The same calibration with its scale resting on another gravity.
    pub fn at_gravity(&self, gravity: f64) -> NominalModel {
        let ratio = self.gravity / gravity;
        let factor = |i: usize| if i < 9 { ratio } else { 1.0 };
        NominalModel {
            model: self.model.map(|row| row.map(|v| v * ratio)),
            matrix: self.matrix.map(|row| row.map(|v| v / ratio)),
            bias: self.bias,
            covariance: self.covariance.map(|c| {
                std::array::from_fn(|r| std::array::from_fn(|k| c[r][k] * factor(r) * factor(k)))
            }),
            gravity,
            tilt_degrees_of_freedom: self.tilt_degrees_of_freedom,
        }
    }
}

/// Bias and scale of both gyroscopes, without a judgement: a gyroscope's bias moves with every
/// start by more than the uncertainty of its file says.
pub(super) fn gyroscope(a: &CalibrationFile, b: &CalibrationFile) -> Option<GyroscopeDifference> {
    let (ga, gb) = (a.gyroscope.as_ref()?, b.gyroscope.as_ref()?);
    let (bias_a, bias_b) = (ga.bias_deg_s(), gb.bias_deg_s());
    let ratios: [f64; 3] = std::array::from_fn(|i| 100.0 * (gb.scale[i] / ga.scale[i] - 1.0));
    // Counts of two ranges are no scale difference.
    let same = ga.input_unit == gb.input_unit && ratios.iter().all(|r| r.abs() < 20.0);
    Some(GyroscopeDifference {
        bias_a_deg_s: bias_a,
        bias_b_deg_s: bias_b,
        bias_difference_deg_s: std::array::from_fn(|i| bias_b[i] - bias_a[i]),
        scale_difference_percent: same.then_some(ratios),
    })
}
