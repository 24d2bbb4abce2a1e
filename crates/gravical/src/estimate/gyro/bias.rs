//! The bias alone, where no motion shows more.

use gravical_core::matrix3;

use super::rest::Rest;
use crate::calibration_file::{Covariance, GyroscopeSection};
use crate::recording::Finding;
use crate::recording::units::{GyroScale, GyroUnit};
use crate::segment::Placement;

/// A section with the bias of the stills and the nominal matrix.
pub(super) fn section(
    rest: &Rest,
    unit: GyroUnit,
    nominal: Option<f64>,
    findings: &mut Vec<Finding>,
    file: &str,
) -> Option<GyroscopeSection> {
    let Some(nominal) = nominal else {
        findings.push(no_scale(rest.bias).in_file(file));
        return None;
    };
    Some(with_nominal(
        rest.bias,
        Some(rest.bias_error),
        rest.g_sensitivity,
        unit,
        nominal,
    ))
}

fn no_scale(bias: [f64; 3]) -> Finding {
    Finding::note(
        "gyro-scale-unknown",
        format!(
            "the gyroscope reads {} at rest, but neither unit nor turns tell its scale: it is not calibrated; --gyro-unit and, for counts, --gyro-range say it",
            bias.map(|b| format!("{b:.4}")).join(", ")
        ),
    )
}

fn with_nominal(
    bias: [f64; 3],
    error: Option<[f64; 3]>,
    g_sensitivity: [[f64; 3]; 3],
    unit: GyroUnit,
    nominal: f64,
) -> GyroscopeSection {
    let covariance = error.map(|s| Covariance {
        parameters: ["bias_x", "bias_y", "bias_z"].map(str::to_owned).to_vec(),
        values: matrix3::diagonal(s.map(|v| v * v))
            .iter()
            .map(|row| row.to_vec())
            .collect(),
    });
    GyroscopeSection {
        method: "bias".to_owned(),
        input_unit: unit,
        bias,
        matrix: matrix3::diagonal([nominal.recip(); 3]),
        scale: [nominal; 3],
        orientation: matrix3::identity(),
        g_sensitivity,
        covariance,
        ..GyroscopeSection::default()
    }
}

/// The gyroscope of a session without motions, such as six files: the mean over
/// all samples at rest as bias, the nominal matrix. Its standard error is that
/// of the mean over the placements, whose scatter holds noise, drift and the
/// reaction to gravity alike.
///
/// The section is none without a gyroscope or without a nominal scale; the
/// finding then says so.
#[must_use]
pub fn at_rest(placements: &[Placement], scale: Option<GyroScale>) -> super::GyroFit {
    let means: Vec<([f64; 3], usize)> = placements.iter().filter_map(|p| p.gyro_sum).collect();
    let rows: usize = means.iter().map(|(_, n)| n).sum();
    let mut fit = super::GyroFit::default();
    if rows == 0 {
        return fit;
    }
    let bias: [f64; 3] =
        std::array::from_fn(|i| means.iter().map(|(s, _)| s[i]).sum::<f64>() / rows as f64);
    let error = (means.len() > 2).then(|| {
        let n = means.len() as f64;
        std::array::from_fn(|i| {
            let squares: f64 = means
                .iter()
                .map(|(sum, rows)| (sum[i] / *rows as f64 - bias[i]).powi(2))
                .sum();
            (squares / (n * (n - 1.0))).sqrt()
        })
    });
    match scale.and_then(|s| Some((s.unit, s.nominal()?))) {
        Some((unit, nominal)) => {
            fit.section = Some(with_nominal(bias, error, [[0.0; 3]; 3], unit, nominal));
        }
        None => fit.findings.push(no_scale(bias)),
    }
    fit
}
