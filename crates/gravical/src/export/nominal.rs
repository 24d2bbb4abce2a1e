//! The calibration for programs that convert by the nominal scale first: raw values in m/s².

use crate::calibration_file::CalibrationFile;
use crate::{Error, Result};

/// Row-major.
pub(super) type Matrix = [[f64; 3]; 3];

/// `calibrated = matrix · (raw − bias)`, all in m/s² (or rad/s).
pub(super) struct Nominal {
    /// Near the identity.
    pub matrix: Matrix,
    /// m/s² (or rad/s).
    pub bias: [f64; 3],
}

/// The accelerometer with raw values that the nominal scale has brought to m/s².
///
/// # Errors
///
/// `export-unit` (input) if the nominal scale is not known.
pub(super) fn accelerometer(file: &CalibrationFile) -> Result<Nominal> {
    let a = &file.accelerometer;
    let per_mps2 = a.nominal_per_mps2().ok_or_else(|| {
        Error::input(
            "export-unit",
            format!(
                "this target takes m/s², and the calibration is for {} of unknown nominal scale",
                a.input_unit.name()
            ),
        )
        .with_hint("calibrate with --accel-range, which gives the counts their nominal scale; or export to c, which takes the counts themselves")
    })?;
    let zero = a.zero_offset();
    Ok(Nominal {
        matrix: a.matrix.map(|row| row.map(|v| v * per_mps2)),
        bias: a.bias.map(|b| (b - zero) / per_mps2),
    })
}

/// The gyroscope with raw values in rad/s, and its g-sensitivity in rad/s per m/s²; none without a
/// gyroscope or for counts.
pub(super) fn gyroscope(file: &CalibrationFile) -> Option<(Nominal, Matrix)> {
    let g = file.gyroscope.as_ref()?;
    let per_rad_s = g.nominal_per_rad_s()?;
    let scaled = |m: &Matrix, factor: f64| m.map(|row| row.map(|v| v * factor));
    let nominal = Nominal {
        matrix: scaled(&g.matrix, per_rad_s),
        bias: g.bias.map(|b| b / per_rad_s),
    };
    Some((nominal, scaled(&g.g_sensitivity, 1.0 / per_rad_s)))
}
