//! A header for a sketch: functions in floating point, and on counts also in fixed point.

use gravical_core::matrix3::{mul, mul_vec};
use gravical_core::unit::{RADIANS_PER_DEGREE, STANDARD_GRAVITY_MPS2};

use super::code::{affine, of_acceleration, rows};
use super::fixed::Fixed;
use super::header::{about, c_comment, plain, without_drift};
use super::nominal::Matrix;
use super::{Export, ExportOptions, Target};
use crate::calibration_file::CalibrationFile;
use crate::recording::units::{AccelUnit, GyroUnit};
use crate::{Error, Result};

/// A sketch whose counts are taken for others by this much has another range: they differ by two.
const SAME_RANGE: f64 = 0.2;

/// One sensor, `out = matrix · (raw − bias)`, for what a sketch has.
struct Sensor {
    matrix: Matrix,
    bias: [f64; 3],
    /// Unit of the raw values, as written.
    unit: String,
    /// The raw values are counts of 16 bits, with a sign.
    counts: bool,
    /// Counts per g or per °/s, where known.
    per_unit: Option<f64>,
}

impl Sensor {
    /// Type of the raw values.
    fn raw(&self) -> &'static str {
        if self.counts { "int16_t" } else { "float" }
    }

    fn affine(&self) -> [[f64; 4]; 3] {
        affine(&self.matrix, &self.bias)
    }

    /// For counts of `wanted` per g or °/s, of which a unit of the result is `per_result`.
    fn for_counts(self, wanted: f64, per_result: f64, option: &str, of: &str) -> Result<Self> {
        let Sensor { matrix, bias, .. } = self;
        let factor = match self.per_unit {
            Some(per_unit) => per_unit / wanted,
            // The recording did not say what a count is. A sensor is off by a few percent.
            None => {
                let row = |r: &[f64; 3]| r.iter().map(|v| v * v).sum::<f64>().sqrt();
                let own = per_result * 3.0 / matrix.iter().map(row).sum::<f64>();
                if (own / wanted - 1.0).abs() > SAME_RANGE {
                    return Err(Error::input(
                        "export-unit",
                        format!(
                            "the calibration's own scale is {own:.1} counts per {of}, not {wanted}"
                        ),
                    )
                    .with_hint(format!(
                        "give {option} for the range in which the recordings were made"
                    )));
                }
                1.0
            }
        };
        Ok(Sensor {
            matrix: matrix.map(|row| row.map(|v| v * factor)),
            bias: bias.map(|b| b / factor),
            unit: format!("counts, {} per {of}", written(wanted)),
            counts: true,
            per_unit: Some(wanted),
        })
    }
}

/// A number of counts without the rounding of a division.
fn written(counts: f64) -> f64 {
    (counts * 1000.0).round() / 1000.0
}

/// What is unsigned does not fit into 16 bits with a sign: it is given less its offset.
fn less(unit: String, zero_offset: f64) -> String {
    match zero_offset == 0.0 {
        true => unit,
        false => format!("{unit}, less {zero_offset}"),
    }
}

fn accelerometer(file: &CalibrationFile, options: &ExportOptions) -> Result<Sensor> {
    let a = &file.accelerometer;
    let zero = a.zero_offset();
    let counts = a.input_unit == AccelUnit::Counts;
    let per_unit = a.nominal_per_mps2().map(|n| n * STANDARD_GRAVITY_MPS2);
    let unit = match per_unit.filter(|_| counts) {
        Some(n) => format!("counts, {} per g", written(n)),
        None => a.input_unit.name().to_owned(),
    };
    let sensor = Sensor {
        matrix: a.matrix,
        bias: a.bias.map(|b| b - zero),
        unit: less(unit, zero),
        counts,
        per_unit,
    };
    match options.counts_per_g {
        Some(n) => sensor.for_counts(n, STANDARD_GRAVITY_MPS2, "--counts-per-g", "g"),
        None => Ok(sensor),
    }
}

/// The gyroscope, and what an acceleration adds to its result, rad/s per m/s².
fn gyroscope(file: &CalibrationFile, options: &ExportOptions) -> Result<Option<(Sensor, Matrix)>> {
    let Some(g) = &file.gyroscope else {
        return Ok(None);
    };
    let counts = g.input_unit == GyroUnit::Counts;
    let zero = g.zero_offset();
    let sensor = Sensor {
        matrix: g.matrix,
        bias: g.bias.map(|b| b - zero),
        unit: less(g.input_unit.name().to_owned(), zero),
        counts,
        per_unit: g.nominal_per_rad_s().map(|n| n * RADIANS_PER_DEGREE),
    };
    let sensor = match options.counts_per_deg_s {
        Some(n) => sensor.for_counts(n, RADIANS_PER_DEGREE, "--counts-per-deg-s", "deg/s")?,
        None => sensor,
    };
    Ok(Some((sensor, of_acceleration(&g.matrix, &g.g_sensitivity))))
}

/// The header.
///
/// # Errors
///
/// `export-unit` (input) where counts of unknown nominal scale are clearly others than the options
/// say.
pub(super) fn arduino(
    file: &CalibrationFile,
    name: &str,
    options: &ExportOptions,
) -> Result<Export> {
    let mut notes = without_drift(file);
    let prefix = name.to_uppercase();
    let accel = accelerometer(file, options)?;
    let gyro = gyroscope(file, options)?;
    if !accel.counts || gyro.as_ref().is_some_and(|(g, _)| !g.counts) {
        notes.push("For the raw counts of a sensor, and in fixed point, give --counts-per-g (16384 for ±2 g) and --counts-per-deg-s (131 for ±250 °/s).".to_owned());
    }
    let mut parts = vec![float_accelerometer(&accel, name)];
    parts.extend(fixed_accelerometer(&accel, name, &prefix));
    if let Some((gyro, coupling)) = &gyro {
        parts.push(float_gyroscope(gyro, coupling, name));
        parts.extend(fixed_gyroscope(gyro, coupling, &accel, name, &prefix));
    }
    let of_accel = accel.per_unit.filter(|_| accel.counts);
    let of_gyro = gyro
        .as_ref()
        .and_then(|(g, _)| g.per_unit.filter(|_| g.counts));
    let mut defines = format!("#define {prefix}_CREATED \"{}\"\n", plain(&file.created));
    if gyro.is_some() {
        defines += &format!("#define {prefix}_GYRO 1\n");
    }
    for (of, counts) in [
        ("ACCEL_COUNTS_PER_G", of_accel),
        ("GYRO_COUNTS_PER_DEG_S", of_gyro),
    ] {
        if let Some(counts) = counts {
            defines += &format!("#define {prefix}_{of} {:?}\n", written(counts));
        }
    }
    let text = format!(
        "{}#ifndef GRAVICAL_{prefix}_ARDUINO_H\n#define GRAVICAL_{prefix}_ARDUINO_H\n\n#include <stdint.h>\n\n{defines}\n/* Three rows; the fourth column is what an axis reads without acceleration, negated. */\n{}\n#endif\n",
        c_comment(&about(file, Target::Arduino, &notes)),
        parts.join("\n")
    );
    Ok(Export { text, notes })
}

fn table(name: &str, of: &str, numbers: &str, columns: usize) -> String {
    format!("static const float {name}_{of}_rows[3][{columns}] = {{\n{numbers}}};\n")
}

fn float_accelerometer(sensor: &Sensor, name: &str) -> String {
    format!(
        "{}\n/* raw: accelerometer, {}; out: m/s^2 */\nstatic inline void {name}_apply(const {} raw[3], float out[3])\n{{\n    const float x = raw[0], y = raw[1], z = raw[2];\n    for (int i = 0; i < 3; i++) {{\n        const float *m = {name}_accel_rows[i];\n        out[i] = m[0] * x + m[1] * y + m[2] * z + m[3];\n    }}\n}}\n",
        table(name, "accel", &rows(&sensor.affine(), "{", "}", "f"), 4),
        sensor.unit,
        sensor.raw(),
    )
}

fn float_gyroscope(sensor: &Sensor, coupling: &Matrix, name: &str) -> String {
    format!(
        "{}{}\n/* raw: gyroscope, {}; accel: calibrated acceleration, m/s^2; out: rad/s */\nstatic inline void {name}_apply_gyro(const {} raw[3], const float accel[3], float out[3])\n{{\n    const float x = raw[0], y = raw[1], z = raw[2];\n    const float ax = accel[0], ay = accel[1], az = accel[2];\n    for (int i = 0; i < 3; i++) {{\n        const float *m = {name}_gyro_rows[i], *k = {name}_gyro_accel_rows[i];\n        out[i] = m[0] * x + m[1] * y + m[2] * z + m[3] + k[0] * ax + k[1] * ay + k[2] * az;\n    }}\n}}\n",
        table(name, "gyro", &rows(&sensor.affine(), "{", "}", "f"), 4),
        table(name, "gyro_accel", &rows(coupling, "{", "}", "f"), 3),
        sensor.unit,
        sensor.raw(),
    )
}

/// The accelerometer in fixed point; none where the raw values are no counts.
fn fixed_accelerometer(sensor: &Sensor, name: &str, prefix: &str) -> Option<String> {
    let affine = sensor.counts.then(|| sensor.affine())?;
    let fixed = Fixed::new(&affine.map(first_three), &affine.map(|row| row[3]))?;
    Some(fixed_code(
        &fixed,
        &format!("raw: accelerometer, {}", sensor.unit),
        "m/s^2",
        &format!("{prefix}_ACCEL"),
        &format!("{name}_apply_q(const int16_t raw[3], int32_t out[3])"),
    ))
}

/// The gyroscope in fixed point, with what acceleration adds straight from the counts of the
/// accelerometer; none where one that is needed does not come in counts.
fn fixed_gyroscope(
    sensor: &Sensor,
    coupling: &Matrix,
    accel: &Sensor,
    name: &str,
    prefix: &str,
) -> Option<String> {
    let affine = sensor.counts.then(|| sensor.affine())?;
    let of = format!("raw: gyroscope, {}", sensor.unit);
    let prefix = format!("{prefix}_GYRO");
    let function = format!(
        "{name}_apply_gyro_q(const int16_t raw[3], const int16_t accel[3], int32_t out[3])"
    );
    if coupling.iter().flatten().all(|v| *v == 0.0) {
        let fixed = Fixed::new(&affine.map(first_three), &affine.map(|row| row[3]))?;
        return Some(fixed_code(&fixed, &of, "rad/s", &prefix, &function));
    }
    let force = accel.counts.then(|| accel.affine())?;
    let added = mul(coupling, &force.map(first_three));
    let at_zero = mul_vec(coupling, &force.map(|row| row[3]));
    let rows = std::array::from_fn(|i| {
        let ([x, y, z, _], [u, v, w]) = (affine[i], added[i]);
        [x, y, z, u, v, w]
    });
    let fixed = Fixed::new(&rows, &std::array::from_fn(|i| affine[i][3] + at_zero[i]))?;
    let of = format!("{of}; accel: accelerometer, {}", accel.unit);
    Some(fixed_code(&fixed, &of, "rad/s", &prefix, &function))
}

fn first_three([x, y, z, _]: [f64; 4]) -> [f64; 3] {
    [x, y, z]
}

/// Names of the counts in a function, and after `_` of their upper bytes.
const COUNTS: [&str; 6] = ["x", "y", "z", "u", "v", "w"];

/// `fixed` as a function of `raw`, and of `accel` where it has six columns.
///
/// On an 8-bit AVR the spelling matters: a sign-extended byte times a small number is one
/// instruction, and an unsigned sum keeps the compiler from widening each product to 32 bits.
fn fixed_code<const N: usize>(
    fixed: &Fixed<N>,
    inputs: &str,
    unit: &str,
    prefix: &str,
    function: &str,
) -> String {
    let from = |array: &str, names: &[&str]| {
        let whole: Vec<String> = (names.iter().enumerate())
            .map(|(j, n)| format!("{n} = {array}[{j}]"))
            .collect();
        let upper: Vec<String> = (names.iter())
            .map(|n| format!("{n}_ = (int8_t)((uint16_t){n} >> 8)"))
            .collect();
        format!(
            "    const int16_t {};\n    const int8_t {};\n",
            whole.join(", "),
            upper.join(", ")
        )
    };
    let mut body = from("raw", &COUNTS[..3]);
    if N > 3 {
        body += &from("accel", &COUNTS[3..]);
    } else if function.contains("accel[") {
        body += "    (void)accel;\n";
    }
    for (i, row) in fixed.rows.iter().enumerate() {
        body += &format!("    out[{i}] = {:.0}", row.constant);
        for (of, name) in row.coarse.iter().zip(COUNTS) {
            body += &format!(" + (int32_t){name} * (int32_t){of:.0}");
        }
        // Three products of a byte and 64 fit into 16 bits.
        for (of, names) in row.fine.chunks(3).zip(COUNTS.chunks(3)) {
            let terms: Vec<String> = (of.iter().zip(names))
                .map(|(of, name)| format!("(uint16_t)({name}_ * {of:.0})"))
                .collect();
            body += &format!("\n        + 2 * (int32_t)(int16_t)({})", terms.join(" + "));
        }
        body += ";\n";
    }
    let bits = fixed.bits;
    // Two digits that are no less than the value.
    let error = 1.05 * fixed.error;
    format!(
        "/* Fixed point. {inputs};\n * out: {unit} times 2^{bits}, right to {error:.1e} {unit} at all counts;\n * (float)out[i] * {prefix}_FROM_Q is in {unit}. */\n#define {prefix}_Q {bits}\n#define {prefix}_FROM_Q {:.8e}f\nstatic inline void {function}\n{{\n{body}}}\n",
        (-f64::from(bits)).exp2()
    )
}
