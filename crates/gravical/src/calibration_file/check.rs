//! Validation of a calibration, when it is read and before it is written.

use gravical_core::matrix3;
use nalgebra::DMatrix;

use super::{CalibrationFile, Covariance};
use crate::{Error, Result};

/// Upper limit of all parameters, in any unit.
const MAX_PARAMETER: f64 = 1e9;
/// Lower limit of nonzero factors.
const MIN_FACTOR: f64 = 1e-12;
/// Smallest volume spanned by the rows of a matrix, scaled to length one, at which it is not
/// singular: that of axes 0.006° from one plane.
const MIN_VOLUME: f64 = 1e-4;
/// Rounded correlations may have eigenvalues this far below zero.
const ROUNDING: f64 = 1e-6;
/// Plausible gravity, m/s²: from that of the Moon to above that of the Earth.
const GRAVITY_MPS2: std::ops::RangeInclusive<f64> = 1.0..=12.0;

impl CalibrationFile {
    /// Refuses parameters that cannot be applied; the message gives the field.
    pub(super) fn check(&self) -> Result<()> {
        if !GRAVITY_MPS2.contains(&self.gravity_mps2) {
            let what = format!("{} m/s² is not a possible gravity", self.gravity_mps2);
            return Err(wrong("gravity_mps2", &what));
        }
        let a = &self.accelerometer;
        let vectors = [&a.bias, &a.scale];
        sensor("accelerometer", vectors, [&a.matrix, &a.orientation])?;
        let all = Covariance::names_with_bends();
        if let Some(c) = &a.covariance {
            c.check("accelerometer.covariance", &[&all[..12], &all])?;
        }
        for (field, value) in [
            ("gravity_sd_mps2", Some(a.gravity_sd_mps2)),
            ("leave_one_out_rms_mps2", a.leave_one_out_rms_mps2),
            ("predicted_norm_error_mps2", a.predicted_norm_error_mps2),
            ("pose_tilt_deg", a.pose_tilt_deg.map(|t| t.value)),
        ] {
            if value.is_some_and(|v| !(0.0..MAX_PARAMETER).contains(&v)) {
                let field = format!("accelerometer.{field}");
                return Err(wrong(&field, "it has to be 0 or more and below 1e9"));
            }
        }
        if let Some(g) = &self.gyroscope {
            let vectors = [&g.bias, &g.scale];
            sensor("gyroscope", vectors, [&g.matrix, &g.orientation])?;
            sizes("gyroscope.g_sensitivity", g.g_sensitivity.as_flattened())?;
            if let Some(c) = &g.covariance {
                c.check("gyroscope.covariance", &[&all[..12], &all[9..12]])?;
            }
        }
        let model = self.temperature_model.as_ref();
        if let Some(why) = model.and_then(super::TemperatureModel::fault) {
            let why = format!("it cannot be applied: {why}");
            return Err(wrong("temperature_model", &why));
        }
        Ok(())
    }
}

fn wrong(field: &str, why: &str) -> Error {
    Error::input("calibration-values", format!("{field}: {why}"))
        .with_hint("use the file written by `gravical calibrate … -o cal.json`, or calibrate again")
}

fn sensor(
    name: &str,
    [bias, scale]: [&[f64; 3]; 2],
    [matrix, orientation]: [&[[f64; 3]; 3]; 2],
) -> Result<()> {
    let field = |part: &str| format!("{name}.{part}");
    sizes(&field("bias"), bias)?;
    sizes(&field("scale"), scale)?;
    if scale.iter().any(|v| v.abs() < MIN_FACTOR) {
        return Err(wrong(&field("scale"), "a scale is zero"));
    }
    for (part, m) in [("matrix", matrix), ("orientation", orientation)] {
        sizes(&field(part), m.as_flattened())?;
        let lengths = matrix3::row_norms(m);
        let is_zero = lengths.iter().any(|l| *l < MIN_FACTOR);
        let unit = matrix3::scale_rows(m, &lengths.map(f64::recip));
        if is_zero || matrix3::det(&unit).abs() < MIN_VOLUME {
            return Err(wrong(&field(part), "the matrix is singular"));
        }
    }
    Ok(())
}

fn sizes(field: &str, values: &[f64]) -> Result<()> {
    let is_beyond = |v: &&f64| !(-MAX_PARAMETER..MAX_PARAMETER).contains(*v);
    match values.iter().find(is_beyond) {
        None => Ok(()),
        Some(v) => Err(wrong(field, &format!("{v:e} is beyond any sensor"))),
    }
}

impl Covariance {
    /// Checks names, size and properties of a covariance.
    fn check(&self, field: &str, named: &[&[String]]) -> Result<()> {
        let n = self.parameters.len();
        if !named.contains(&&self.parameters[..]) {
            let names: Vec<String> = named.iter().map(|n| n.join(", ")).collect();
            let why = format!("they have to be {}, in this order", names.join("; or "));
            return Err(wrong(&format!("{field}.parameters"), &why));
        }
        let field = format!("{field}.values");
        if self.values.len() != n || self.values.iter().any(|row| row.len() != n) {
            return Err(wrong(&field, &format!("there have to be {n} rows of {n}")));
        }
        let c = DMatrix::from_fn(n, n, |i, j| self.values[i][j]);
        let sd: Vec<f64> = c.diagonal().iter().map(|v| v.sqrt()).collect();
        if c.iter().any(|v| !v.is_finite()) || sd.iter().any(|s| !(0.0..MAX_PARAMETER).contains(s))
        {
            let why = "a variance is negative, beyond any sensor, or not a number";
            return Err(wrong(&field, why));
        }
        // Normalised to correlations, since the parameters have different units.
        let correlations = DMatrix::from_fn(n, n, |i, j| match (sd[i] * sd[j], c[(i, j)]) {
            (0.0, 0.0) => 0.0,
            (size, v) => v / size,
        });
        let asymmetry = &correlations - correlations.transpose();
        // An infinity less another is no number.
        let is_symmetric = asymmetry.iter().all(|d| d.abs() <= ROUNDING);
        let lowest = || correlations.symmetric_eigenvalues().min();
        if !is_symmetric || lowest() < -(n as f64) * ROUNDING {
            let why = "not a covariance: it is not symmetric, or not positive semidefinite";
            return Err(wrong(&field, why));
        }
        Ok(())
    }
}
