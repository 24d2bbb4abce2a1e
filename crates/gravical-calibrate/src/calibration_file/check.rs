//! Validation of a calibration, when it is read and before it is written.

use gravical_core::matrix3;
use nalgebra::DMatrix;

use super::{Calibration, Covariance, TemperatureModel};
use crate::Result;
use crate::problem::Problem;

/// Upper limit of all parameters, in any unit.
const MAX_PARAMETER: f64 = 1e9;
/// Largest bias of an accelerometer, m/s², zero offset of the counts included: 10,000 g, beyond any range, and beyond
/// counts of 16 bits that stand for m/s² where their scale is unknown.
const MAX_BIAS_MPS2: f64 = 1e5;
/// Largest bias of a gyroscope, rad/s: a hundred times the range of the fastest.
const MAX_BIAS_RAD_S: f64 = 1e5;
/// Lower limit of nonzero factors.
const MIN_FACTOR: f64 = 1e-12;
/// Smallest volume spanned by the rows of a matrix, scaled to length one, at which it is not
/// singular: that of axes 0.006° from one plane.
const MIN_VOLUME: f64 = 1e-4;
/// Rounded correlations may have eigenvalues this far below zero.
const ROUNDING: f64 = 1e-6;
/// Plausible gravity, m/s²: from that of the Moon to above that of the Earth.
const GRAVITY_MPS2: std::ops::RangeInclusive<f64> = 1.0..=12.0;

impl Calibration {
    /// Refuses parameters that cannot be applied; the message gives the field.
    pub(crate) fn check(&self) -> Result<()> {
        let mps2 = self.gravity_mps2;
        require(GRAVITY_MPS2.contains(&mps2), Problem::NoGravity { mps2 })?;
        let a = &self.accelerometer;
        sensor("accelerometer", &a.bias, &a.matrix, (MAX_BIAS_MPS2, "m/s²"))?;
        if let Some(c) = &a.covariance {
            c.check("accelerometer.covariance", [12, 18])?;
        }
        let is_scale = |n: f64| (MIN_FACTOR..MAX_PARAMETER).contains(&n);
        let field = "accelerometer.nominal_scale";
        require(
            a.nominal_scale.is_none_or(is_scale),
            Problem::NoSize { field },
        )?;
        let r = &self.reliability;
        let tilt_deg = r.pose_tilt_deg.map(|tilt| tilt.value);
        let worst_mps2 = r.worst_direction.map(|worst| worst.error_mps2);
        let hidden_mps2 = r.undetected.map(|undetected| undetected.effect_mps2);
        let left_out_sd = self.poses.iter().map(|pose| pose.left_out_sd_mps2);
        let sizes_of_poses = left_out_sd.map(|sd| ("poses.left_out_sd_mps2", sd));
        let sizes_of_file = [
            ("gravity_sd_mps2", Some(self.gravity_sd_mps2)),
            ("reliability.left_out_rms_mps2", r.left_out_rms_mps2),
            ("reliability.predicted_mps2", r.predicted_mps2),
            ("reliability.pose_tilt_deg", tilt_deg),
            ("reliability.worst_direction", worst_mps2),
            ("reliability.undetected", hidden_mps2),
        ];
        for (field, value) in sizes_of_file.into_iter().chain(sizes_of_poses) {
            let is_size = value.is_none_or(|v| (0.0..MAX_PARAMETER).contains(&v));
            require(is_size, Problem::NoSize { field })?;
        }
        if let Some(g) = &self.gyroscope {
            sensor("gyroscope", &g.bias, &g.matrix, (MAX_BIAS_RAD_S, "rad/s"))?;
            let coupling = g.g_sensitivity.as_flattened();
            sizes("gyroscope", "g_sensitivity", coupling)?;
            if let Some(c) = &g.covariance {
                c.check("gyroscope.covariance", [12, 3])?;
            }
        }
        let fault = self.drift.as_ref().and_then(TemperatureModel::fault);
        fault.map_or(Ok(()), |fault| Err(fault.error()))
    }
}

fn require(holds: bool, otherwise: Problem) -> Result<()> {
    if holds {
        Ok(())
    } else {
        Err(otherwise.error())
    }
}

fn sensor(
    section: &'static str,
    bias: &[f64; 3],
    matrix: &[[f64; 3]; 3],
    (most, unit): (f64, &'static str),
) -> Result<()> {
    sizes(section, "bias", bias)?;
    sizes(section, "matrix", matrix.as_flattened())?;
    let calibrated = matrix3::mul_vec(matrix, bias).map(f64::abs);
    let bias = calibrated.into_iter().fold(0.0, f64::max);
    let too_large = Problem::BiasTooLarge {
        section,
        bias,
        most,
        unit,
    };
    require(bias <= most, too_large)?;
    let lengths = matrix3::row_norms(matrix);
    let unit = matrix3::scale_rows(matrix, &lengths.map(f64::recip));
    let is_regular =
        lengths.iter().all(|l| *l >= MIN_FACTOR) && matrix3::det(&unit).abs() >= MIN_VOLUME;
    require(is_regular, Problem::SingularMatrix { section })
}

fn sizes(section: &'static str, field: &'static str, values: &[f64]) -> Result<()> {
    let possible = -MAX_PARAMETER..MAX_PARAMETER;
    let are_possible = values.iter().all(|v| possible.contains(v));
    require(are_possible, Problem::BeyondSensors { section, field })
}

impl Covariance {
    /// Checks names, size and properties of a covariance that may have one of two sizes.
    fn check(&self, field: &'static str, possible: [usize; 2]) -> Result<()> {
        let n = self.parameters.len();
        let is_named = possible.map(Self::names).contains(&self.parameters);
        require(
            is_named,
            Problem::OtherParameters {
                field,
                possible: possible.map(Covariance::names),
            },
        )?;
        let is_square = self.values.len() == n && self.values.iter().all(|row| row.len() == n);
        require(is_square, Problem::NotSquare { field, size: n })?;
        let c = DMatrix::from_fn(n, n, |i, j| self.values[i][j]);
        let sd: Vec<f64> = c.diagonal().iter().map(|v| v.sqrt()).collect();
        let is_sd = sd.iter().all(|s| (0.0..MAX_PARAMETER).contains(s));
        let are_numbers = is_sd && c.iter().all(|v| v.is_finite());
        require(are_numbers, Problem::NoVariance { field })?;
        // Normalised to correlations, since the parameters have different units.
        let correlations = DMatrix::from_fn(n, n, |i, j| match (sd[i] * sd[j], c[(i, j)]) {
            (0.0, 0.0) => 0.0,
            (size, v) => v / size,
        });
        let asymmetry = &correlations - correlations.transpose();
        // An infinity less another is no number.
        let is_symmetric = asymmetry.iter().all(|d| d.abs() <= ROUNDING);
        let is_covariance =
            is_symmetric && correlations.symmetric_eigenvalues().min() >= -(n as f64) * ROUNDING;
        require(is_covariance, Problem::NoCovariance { field })
    }
}
