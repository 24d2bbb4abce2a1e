//! The bias alone, where no motion shows more.

use gravical_core::matrix3;

use super::rest::Rest;
use crate::calibration_file::{Covariance, GyroscopeSection};
use crate::recording::units::GyroUnit;
use crate::recording::{Finding, FindingKind};

/// A section with the bias of the stills and the nominal matrix, or why there is none.
pub(super) fn section(
    rest: &Rest,
    unit: GyroUnit,
    nominal: Option<f64>,
) -> (Option<GyroscopeSection>, Option<Finding>) {
    let Some(nominal) = nominal else {
        let finding = Finding::new(
            FindingKind::GyroScaleUnknown,
            format!(
                "the gyroscope reads {} at rest, and its scale follows neither from its unit nor from rotations: it is not calibrated; give --gyro-unit and, for counts, --gyro-range",
                rest.bias.map(|b| format!("{b:.4}")).join(", ")
            ),
        );
        return (None, Some(finding));
    };
    let variances = matrix3::diagonal(rest.bias_error.map(|s| s * s));
    let section = GyroscopeSection {
        method: "bias".to_owned(),
        input_unit: unit,
        bias: rest.bias,
        matrix: matrix3::diagonal([nominal.recip(); 3]),
        scale: [nominal; 3],
        orientation: matrix3::identity(),
        g_sensitivity: rest.g_sensitivity,
        covariance: Some(Covariance {
            parameters: ["bias_x", "bias_y", "bias_z"].map(str::to_owned).to_vec(),
            values: variances.map(|row| row.to_vec()).to_vec(),
        }),
        ..GyroscopeSection::default()
    };
    (Some(section), None)
}

#[cfg(test)]
mod tests {
    use gravical_core::calibration::Calibration;

    use super::super::of_session;
    use super::*;
    use crate::recording::{ReadOptions, Recording, read_bytes};
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
        let section = of_session(&session, &cut, &Calibration::identity())
            .section
            .unwrap();
        let deviation = section.covariance.unwrap().values[0][0].sqrt();
        assert!(
            (deviation / (0.01 / 12.0_f64.sqrt()) - 1.0).abs() < 0.01,
            "{deviation}"
        );
    }
}
