//! The bias alone, where no motion shows more.

use gravical_core::matrix3;

use super::rest::Rest;
use crate::calibration_file::{Covariance, GyroscopeSection};
use crate::recording::units::{GyroScale, GyroUnit};
use crate::recording::{Finding, FindingKind, Recording};
use crate::segment::Placement;
use crate::segment::hold::pooled_noise;

/// A section with the bias of the stills and the nominal matrix, or why there is none.
pub(super) fn section(
    rest: &Rest,
    unit: GyroUnit,
    nominal: Option<f64>,
) -> (Option<GyroscopeSection>, Option<Finding>) {
    let Some(nominal) = nominal else {
        return (None, Some(no_scale(rest.bias)));
    };
    let error = Some(rest.bias_error);
    let section = with_nominal(rest.bias, error, rest.g_sensitivity, unit, nominal);
    (Some(section), None)
}

fn no_scale(bias: [f64; 3]) -> Finding {
    Finding::new(
        FindingKind::GyroScaleUnknown,
        format!(
            "the gyroscope reads {} at rest, and its scale follows neither from its unit nor from rotations: it is not calibrated; give --gyro-unit and, for counts, --gyro-range",
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
/// reaction to gravity alike; and what rounding leaves, the same in all of them.
///
/// The section is none without a gyroscope or without a nominal scale; the
/// finding then says so.
#[must_use]
pub fn at_rest(
    recordings: &[Recording],
    placements: &[Placement],
    scale: Option<GyroScale>,
) -> super::GyroFit {
    let means: Vec<([f64; 3], usize)> = placements.iter().filter_map(|p| p.gyro_sum).collect();
    let rows: usize = means.iter().map(|(_, n)| n).sum();
    let mut fit = super::GyroFit::default();
    if rows == 0 {
        return fit;
    }
    let bias: [f64; 3] =
        std::array::from_fn(|i| means.iter().map(|(s, _)| s[i]).sum::<f64>() / rows as f64);
    let left = left_by_rounding(recordings, placements);
    let error = (means.len() > 2).then(|| {
        let n = means.len() as f64;
        std::array::from_fn(|i| {
            let squares: f64 = means
                .iter()
                .map(|(sum, rows)| (sum[i] / *rows as f64 - bias[i]).powi(2))
                .sum();
            (squares / (n * (n - 1.0))).sqrt().hypot(left[i])
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

/// What rounding leaves of the mean of each axis, unit of the file.
fn left_by_rounding(recordings: &[Recording], placements: &[Placement]) -> [f64; 3] {
    let mut holds: Vec<[&[f64]; 3]> = Vec::new();
    let mut step = [0.0_f64; 3];
    for placement in placements {
        let recording = &recordings[placement.recording];
        let Some(gyro) = &recording.gyro else {
            continue;
        };
        let own = recording.gyro_resolution();
        (0..3).for_each(|i| step[i] = step[i].max(own[i]));
        let rows = placement.rows.iter();
        holds.extend(rows.map(|r| gyro.each_ref().map(|c| &c[r.clone()])));
    }
    pooled_noise(&holds, step).rounding
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{ReadOptions, read_bytes};
    use crate::segment::{SegmentOptions, segment};

    /// Two decimals of a gyroscope in rad/s, whose noise is a tenth of a step: the bias is
    /// no better known than rounding lets it be.
    #[test]
    fn a_bias_of_coarse_digits_is_not_exact() {
        let faces = ["x_pos", "x_neg", "y_pos", "y_neg", "z_pos", "z_neg"];
        let session: Vec<Recording> = faces
            .iter()
            .enumerate()
            .map(|(k, name)| {
                let sign = if k % 2 == 0 { 9.81 } else { -9.81 };
                let rows: String = (0..400)
                    .map(|i| {
                        let mut a = [0.03 * f64::from(i % 7) - 0.09; 3];
                        a[k / 2] += sign;
                        let [x, y, z] = a;
                        format!("{},{x:.2},{y:.2},{z:.2},0.01,-0.02,0.00\n", 10 * i)
                    })
                    .collect();
                let text = format!("t_ms,ax,ay,az,gx,gy,gz\n{rows}");
                let options = ReadOptions {
                    gyro_unit: Some(GyroUnit::RadianPerSecond),
                    ..ReadOptions::default()
                };
                read_bytes(text.as_bytes(), &format!("{name}.csv"), &options).unwrap()
            })
            .collect();
        let cut = segment(&session, &SegmentOptions::default()).unwrap();
        let section = at_rest(&session, &cut.placements, cut.gyro_scale)
            .section
            .unwrap();
        let deviation = section.covariance.unwrap().values[0][0].sqrt();
        assert!(
            (deviation / (0.01 / 12.0_f64.sqrt()) - 1.0).abs() < 0.01,
            "{deviation}"
        );
    }
}
