//! x-io Fusion: `misalignment · (sensitivity ∘ (raw − offset))`, in g and °/s.

use gravical_core::matrix3::{row_norms, scale_rows, transpose};
use gravical_core::unit::{DEGREES_PER_RADIAN, STANDARD_GRAVITY_MPS2};

use super::header::{about, c_comment, without_drift};
use super::nominal::Matrix;
use super::{Export, Target};
use crate::calibration_file::CalibrationFile;

/// Initialisers of matrices and vectors for both sensors.
pub(super) fn fusion(file: &CalibrationFile, name: &str) -> Export {
    let mut notes = without_drift(file);
    let a = &file.accelerometer;
    let mut body = sensor(
        &format!("{name}_accelerometer"),
        &format!("raw: {}; result: g", a.input_unit.name()),
        &a.matrix,
        1.0 / STANDARD_GRAVITY_MPS2,
        &a.bias,
    );
    if let Some(g) = &file.gyroscope {
        if g.g_sensitivity.iter().flatten().any(|v| *v != 0.0) {
            notes.push(
                "Without the g-sensitivity of the gyroscope, which Fusion does not know."
                    .to_owned(),
            );
        }
        body += "\n";
        body += &sensor(
            &format!("{name}_gyroscope"),
            &format!("raw: {}; result: deg/s", g.input_unit.name()),
            &g.matrix,
            DEGREES_PER_RADIAN,
            &g.bias,
        );
    }
    let guard = format!("GRAVICAL_{}_FUSION_H", name.to_uppercase());
    let text = format!(
        "{}#ifndef {guard}\n#define {guard}\n\n#include \"Fusion.h\"\n\n{body}\n#endif\n",
        c_comment(&about(file, Target::Fusion, &notes))
    );
    Export { text, notes }
}

/// The three arguments of `FusionModelInertial` after the raw value. The sensitivities are the
/// lengths of the matrix's columns, so that the misalignment has columns of length one.
fn sensor(name: &str, units: &str, matrix: &Matrix, factor: f64, bias: &[f64; 3]) -> String {
    let columns = transpose(matrix).map(|row| row.map(|v| v * factor));
    let lengths = row_norms(&columns);
    let misalignment = transpose(&scale_rows(&columns, &lengths.map(|l| 1.0 / l)));
    let three = |v: &[f64; 3]| {
        let [x, y, z] = v.map(|v| format!("{v:.8e}f"));
        format!("{x}, {y}, {z}")
    };
    let [x, y, z] = misalignment.map(|row| format!("    {},\n", three(&row)));
    format!(
        "/* FusionModelInertial(raw, {name}_misalignment, {name}_sensitivity, {name}_offset); {units} */\nstatic const FusionMatrix {name}_misalignment = {{\n{x}{y}{z}}};\nstatic const FusionVector {name}_sensitivity = {{\n    {},\n}};\nstatic const FusionVector {name}_offset = {{\n    {},\n}};\n",
        three(&lengths),
        three(bias)
    )
}
