//! Code: C, Rust, Python, MATLAB.

use super::formula::{Formula, Language};
use super::header::{about, ascii, c_comment, marked, without_drift};
use super::nominal::Matrix;
use super::{Export, Target};
use crate::calibration_file::CalibrationFile;
use crate::recording::units::{AccelUnit, GyroUnit};

/// The type of 16-bit counts in C and in Rust: without a sign where the bias contains their offset.
fn counts_type(zero_offset: f64) -> [&'static str; 2] {
    match zero_offset == 0.0 {
        true => ["int16_t", "i16"],
        false => ["uint16_t", "u16"],
    }
}

/// A header for C and C++: a function a sensor, and for counts another that takes integers.
pub(super) fn c(file: &CalibrationFile, name: &str) -> Export {
    let notes = without_drift(file);
    let variables = ["raw", "accel", "out"];
    let a = &file.accelerometer;
    let counts = |is_counts: bool, offset: f64| is_counts.then(|| counts_type(offset)[0]);
    let mut sensors = vec![(
        Formula::accelerometer(file, format!("{name}_accel"), variables),
        counts(a.input_unit == AccelUnit::Counts, a.zero_offset()),
    )];
    if let Some(g) = &file.gyroscope {
        sensors.push((
            Formula::gyroscope(g, format!("{name}_gyro"), variables, true),
            counts(g.input_unit == GyroUnit::Counts, g.zero_offset()),
        ));
    }
    let integers = sensors.iter().any(|(_, counts)| counts.is_some());
    let mut functions = Vec::new();
    for (mut formula, counts) in sensors {
        functions.push(formula.code(Language::Header { raw: "float" }));
        if let Some(raw) = counts {
            formula.function += "_counts";
            functions.push(formula.code(Language::Header { raw }));
        }
    }
    let include = if integers {
        "#include <stdint.h>\n\n"
    } else {
        ""
    };
    let guard = format!("GRAVICAL_{}_H", name.to_uppercase());
    let text = format!(
        "{}#ifndef {guard}\n#define {guard}\n\n{include}{}\n#endif\n",
        c_comment(&about(file, Target::C, &notes)),
        ascii(&functions.join("\n"))
    );
    Export { text, notes }
}

/// A matrix of three rows and four columns: out = matrix · raw + column, column = −matrix · bias.
pub(super) fn affine(matrix: &Matrix, bias: &[f64; 3]) -> [[f64; 4]; 3] {
    matrix.map(|row| {
        let offset: f64 = row.iter().zip(bias).map(|(m, b)| m * b).sum();
        [row[0], row[1], row[2], -offset]
    })
}

/// The matrix of what the acceleration adds: −matrix · g_sensitivity, output unit per m/s².
pub(super) fn of_acceleration(matrix: &Matrix, g_sensitivity: &Matrix) -> Matrix {
    gravical_core::matrix3::mul(matrix, g_sensitivity).map(|row| row.map(|v| -v))
}

/// Rows of numbers with nine digits, which reproduce a float.
pub(super) fn rows<const N: usize>(
    matrix: &[[f64; N]; 3],
    open: &str,
    close: &str,
    ending: &str,
) -> String {
    let row = |row: &[f64; N]| {
        let numbers: Vec<String> = row.iter().map(|v| format!("{v:.8e}{ending}")).collect();
        format!("    {open}{}{close},\n", numbers.join(", "))
    };
    matrix.iter().map(row).collect()
}

/// A module of Rust, or with a name the same inside `pub mod`.
pub(super) fn rust(file: &CalibrationFile, name: Option<&str>) -> Export {
    let notes = without_drift(file);
    let a = &file.accelerometer;
    let types = |is_counts: bool, offset: f64| match is_counts {
        true => (counts_type(offset)[1], "raw.map(f32::from)"),
        false => ("f32", "raw"),
    };
    let table = |about: &str, of: &str, numbers: String, columns: usize| {
        format!("/// {about}\npub const {of}: [[f32; {columns}]; 3] = [\n{numbers}];\n")
    };
    let (raw, value) = types(a.input_unit == AccelUnit::Counts, a.zero_offset());
    let mut parts = vec![
        table(
            &format!(
                "Accelerometer: m/s² per {0}, and in the fourth column m/s².",
                a.input_unit.name()
            ),
            "ACCEL",
            rows(&affine(&a.matrix, &a.bias), "[", "]", ""),
            4,
        ),
        format!(
            "/// Specific force, m/s², of a reading of the accelerometer, {}.\n#[inline]\n#[must_use]\npub fn apply(raw: [{raw}; 3]) -> [f32; 3] {{\n    affine(&ACCEL, {value})\n}}\n",
            a.input_unit.name()
        ),
    ];
    if let Some(g) = &file.gyroscope {
        let (raw, value) = types(g.input_unit == GyroUnit::Counts, g.zero_offset());
        parts.push(table(
            &format!(
                "Gyroscope: rad/s per {}, and in the fourth column rad/s.",
                g.input_unit.name()
            ),
            "GYRO",
            rows(&affine(&g.matrix, &g.bias), "[", "]", ""),
            4,
        ));
        parts.push(table(
            "What acceleration adds to the gyroscope: rad/s per m/s².",
            "GYRO_ACCEL",
            rows(&of_acceleration(&g.matrix, &g.g_sensitivity), "[", "]", ""),
            3,
        ));
        parts.push(format!(
            "/// Angular rate, rad/s, of a reading of the gyroscope, {}, and the calibrated\n/// acceleration, m/s².\n#[inline]\n#[must_use]\npub fn apply_gyro(raw: [{raw}; 3], accel: [f32; 3]) -> [f32; 3] {{\n    let mut rate = affine(&GYRO, {value});\n    for (rate, k) in rate.iter_mut().zip(&GYRO_ACCEL) {{\n        *rate += k[0] * accel[0] + k[1] * accel[1] + k[2] * accel[2];\n    }}\n    rate\n}}\n",
            g.input_unit.name()
        ));
    }
    parts.push("#[inline]\nfn affine(rows: &[[f32; 4]; 3], r: [f32; 3]) -> [f32; 3] {\n    rows.map(|m| m[0] * r[0] + m[1] * r[1] + m[2] * r[2] + m[3])\n}\n".to_owned());
    let head = marked("//", &about(file, Target::Rust, &notes));
    let body = parts.join("\n");
    let text = match name {
        None => format!("{head}\n{body}"),
        Some(name) => {
            let indented: String = body
                .lines()
                .map(|l| match l {
                    "" => "\n".to_owned(),
                    l => format!("    {l}\n"),
                })
                .collect();
            format!("{head}\npub mod {name} {{\n{indented}}}\n")
        }
    };
    Export { text, notes }
}

/// A module of Python.
pub(super) fn python(file: &CalibrationFile, name: &str) -> Export {
    let notes = without_drift(file);
    let variables = ["raw", "accel", "out"];
    let mut parts = vec![
        Formula::accelerometer(file, format!("{name}_accel"), variables).code(Language::NumPy),
    ];
    if let Some(g) = &file.gyroscope {
        let gyro = Formula::gyroscope(g, format!("{name}_gyro"), variables, true);
        parts.push(gyro.code(Language::NumPy));
    }
    let text = format!(
        "{}# Arrays have three columns, or three elements.\n\nimport numpy as np\n\n\n{}",
        marked("#", &about(file, Target::Python, &notes)),
        parts.join("\n\n")
    );
    Export { text, notes }
}

/// A function file that returns a structure of functions.
pub(super) fn matlab(file: &CalibrationFile, name: &str) -> Export {
    let notes = without_drift(file);
    let row = |r: &[f64; 3]| {
        let [x, y, z] = r.map(|v| format!("{v:.12e}"));
        format!("{x} {y} {z}")
    };
    let matrix = |m: &Matrix| format!("[{}; {}; {}]", row(&m[0]), row(&m[1]), row(&m[2]));
    let a = &file.accelerometer;
    let mut body = format!(
        "accel_matrix = {};\naccel_bias = [{}];\n% raw: {}, N-by-3; result: m/s^2\ncal.accel = @(raw) bsxfun(@minus, raw, accel_bias) * accel_matrix.';\n",
        matrix(&a.matrix),
        row(&a.bias),
        a.input_unit.name()
    );
    if let Some(g) = &file.gyroscope {
        body += &format!(
            "gyro_matrix = {};\ngyro_bias = [{}];\ngyro_g_sensitivity = {};\n% raw: {}, accel: calibrated acceleration, m/s^2, both N-by-3; result: rad/s\ncal.gyro = @(raw, accel) (bsxfun(@minus, raw, gyro_bias) - accel * gyro_g_sensitivity.') * gyro_matrix.';\n",
            matrix(&g.matrix),
            row(&g.bias),
            matrix(&g.g_sensitivity),
            g.input_unit.name()
        );
    }
    let text = format!(
        "function cal = {name}()\n{}% Save as {name}.m; then cal = {name}(); f = cal.accel(raw).\n{body}end\n",
        marked("%", &about(file, Target::Matlab, &notes))
    );
    Export { text, notes }
}
