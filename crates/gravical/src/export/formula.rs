//! A calibration as code: one function a sensor, term by term. The report and the exporters of C
//! and Python are this.

use crate::calibration_file::{CalibrationFile, GyroscopeSection};
use crate::numfmt::{digits, unit};

/// A language, and how its functions are called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// C in double precision.
    C,
    /// C or C++ in a header, in single precision.
    Header {
        /// Type of the raw values.
        raw: &'static str,
    },
    /// Python on lists of three numbers.
    Python,
    /// Python on arrays of NumPy, of three columns.
    NumPy,
    /// For people.
    Equation,
}

/// One sensor: `out = matrix · (raw − bias − coupling · accel)`.
pub struct Formula<'a> {
    /// What it measures.
    pub sensor: &'static str,
    /// Name of the function.
    pub function: String,
    /// Names of the raw value, of the calibrated acceleration, and of the result.
    pub variables: [&'static str; 3],
    /// Unit of the result.
    pub unit: &'static str,
    /// Unit of the raw values.
    pub raw_unit: String,
    /// Output unit per raw unit.
    pub matrix: &'a [[f64; 3]; 3],
    /// Raw unit.
    pub bias: &'a [f64; 3],
    /// Raw unit per m/s²; none where it is zero.
    pub coupling: Option<&'a [[f64; 3]; 3]>,
    /// True if the function takes the acceleration even where there is no coupling.
    pub takes_accel: bool,
}

impl<'a> Formula<'a> {
    /// The accelerometer as `function`.
    pub fn accelerometer(
        file: &'a CalibrationFile,
        function: String,
        variables: [&'static str; 3],
    ) -> Self {
        let a = &file.accelerometer;
        Formula {
            sensor: "accelerometer",
            function,
            variables,
            unit: "m/s²",
            raw_unit: unit(a.input_unit.name()),
            matrix: &a.matrix,
            bias: &a.bias,
            coupling: None,
            takes_accel: false,
        }
    }

    /// The gyroscope as `function`. It takes the acceleration if it needs it or `always` is true.
    pub fn gyroscope(
        g: &'a GyroscopeSection,
        function: String,
        variables: [&'static str; 3],
        always: bool,
    ) -> Self {
        let some = g.g_sensitivity.iter().flatten().any(|v| *v != 0.0);
        Formula {
            sensor: "gyroscope",
            function,
            variables,
            unit: "rad/s",
            raw_unit: unit(g.input_unit.name()),
            matrix: &g.matrix,
            bias: &g.bias,
            coupling: some.then_some(&g.g_sensitivity),
            takes_accel: always || some,
        }
    }

    /// The function, with a comment that gives its units. Nine digits reproduce an `f32`; zero
    /// terms are omitted.
    pub fn code(&self, language: Language) -> String {
        let [r, a, out] = self.variables;
        let Formula {
            sensor, function, ..
        } = self;
        let also = match self.takes_accel {
            true => format!("; {a}: calibrated acceleration, m/s²"),
            false => String::new(),
        };
        let about = format!(
            "{r}: {sensor}, raw, {}; {out}: {}{also}",
            self.raw_unit, self.unit
        );
        let head = comment(language, &about);
        let raw: Vec<String> = (0..3).map(|i| self.raw_less_bias(language, i)).collect();
        let rows: Vec<String> = (0..3).map(|i| self.row(language, i)).collect();
        let c = |storage: &str, raw_type: &str, real: &str| {
            let accel = match self.takes_accel {
                true => format!("const {real} {a}[3], "),
                false => String::new(),
            };
            let unused = match self.takes_accel && self.coupling.is_none() {
                true => format!("    (void){a};\n"),
                false => String::new(),
            };
            format!(
                "{head}{storage}void {function}(const {raw_type} {r}[3], {accel}{real} {out}[3])\n{{\n    const {real} u[3] = {{\n        {}\n    }};\n{unused}    {};\n}}\n",
                raw.join(",\n        "),
                rows.join(";\n    ")
            )
        };
        let accel = match self.takes_accel {
            true => format!(", {a}"),
            false => String::new(),
        };
        let list = |lines: &[String]| lines.join(",\n        ");
        match language {
            Language::C => c("", "double", "double"),
            Language::Header { raw } => c("static inline ", raw, "float"),
            Language::Python => format!(
                "{head}def {function}({r}{accel}):\n    u = [\n        {}\n    ]\n    return [\n        {}\n    ]\n",
                list(&raw),
                list(&rows)
            ),
            Language::NumPy => {
                let columns = |name: &str| {
                    format!("    {name} = np.moveaxis(np.asarray({name}, dtype=float), -1, 0)\n")
                };
                let accel_columns = match self.coupling.is_some() {
                    true => columns(a),
                    false => String::new(),
                };
                format!(
                    "{head}def {function}({r}{accel}):\n{}{accel_columns}    u = [\n        {}\n    ]\n    return np.stack([\n        {}\n    ], axis=-1)\n",
                    columns(r),
                    list(&raw),
                    list(&rows)
                )
            }
            Language::Equation => format!("{head}{}\n{}\n", raw.join("\n"), rows.join("\n")),
        }
    }

    /// One axis of the raw value minus its offset.
    fn raw_less_bias(&self, language: Language, j: usize) -> String {
        let [r, a, _] = self.variables;
        let mut terms = vec![(-self.bias[j], String::new())];
        let coupled = self.coupling.map_or([0.0; 3], |s| s[j]);
        terms.extend((0..3).map(|k| (-coupled[k], variable(language, a, k))));
        let rest = sum(language, terms);
        let value = format!("{}{rest}", variable(language, r, j));
        match language {
            Language::Equation => format!("{} = {value}", variable(language, "u", j)),
            _ => value,
        }
    }

    /// One axis of the result.
    fn row(&self, language: Language, i: usize) -> String {
        let terms = (0..3).map(|j| (self.matrix[i][j], variable(language, "u", j)));
        let sum = sum(language, terms);
        let sum = match (sum.strip_prefix(" + "), sum.strip_prefix(" - ")) {
            (Some(rest), _) => rest.to_owned(),
            (_, Some(rest)) => format!("-{rest}"),
            _ => "0.0".to_owned(),
        };
        match language {
            Language::Python | Language::NumPy => sum,
            _ => format!("{} = {sum}", variable(language, self.variables[2], i)),
        }
    }
}

/// A line of comment.
pub fn comment(language: Language, text: &str) -> String {
    match language {
        Language::C | Language::Header { .. } => format!("/* {text} */\n"),
        Language::Python | Language::NumPy => format!("# {text}\n"),
        Language::Equation => format!("({text})\n"),
    }
}

fn variable(language: Language, name: &str, i: usize) -> String {
    match language {
        Language::Equation => format!("{name}{}", ["x", "y", "z"][i.min(2)]),
        _ => format!("{name}[{i}]"),
    }
}

/// The non-zero terms, each with its sign.
fn sum(language: Language, terms: impl IntoIterator<Item = (f64, String)>) -> String {
    let terms = terms.into_iter().filter(|(factor, _)| *factor != 0.0);
    terms
        .map(|(factor, of)| term(language, factor, &of))
        .collect()
}

/// ` + 1.5e0 * of` with its sign; without `of` the number alone.
fn term(language: Language, factor: f64, of: &str) -> String {
    let sign = if factor < 0.0 { '-' } else { '+' };
    let size = factor.abs();
    let number = match language {
        Language::Equation if size >= 0.01 => digits(size, 6),
        Language::Equation => format!("{size:.5e}"),
        Language::Header { .. } => format!("{size:.8e}f"),
        _ => format!("{size:.8e}"),
    };
    match (of, language) {
        ("", _) => format!(" {sign} {number}"),
        (_, Language::Equation) => format!(" {sign} {number} {of}"),
        _ => format!(" {sign} {number} * {of}"),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;
    use std::process::{Command, Output};

    use super::super::nominal::Matrix;
    use super::*;
    use gravical_core::matrix3::mul_vec;

    /// Every sign, and zeros.
    const ACCEL: (Matrix, [f64; 3]) = (
        [[1.0 / 3.0, 0.0, -2e-7], [-1.02, 0.0, 0.0], [0.0; 3]],
        [-0.5, 0.0, 12345.678],
    );
    const GYRO: (Matrix, [f64; 3]) = (
        [[1.1, -0.01, 0.0], [0.0, 0.9, 0.02], [0.0, 0.0, 1.0]],
        [0.01, -0.02, 0.0],
    );
    const COUPLING: Matrix = [[0.0; 3], [1e-4, 0.0, -3e-4], [0.0; 3]];

    fn formulas() -> [Formula<'static>; 2] {
        let accelerometer = Formula {
            sensor: "accelerometer",
            function: "calibrate_accelerometer".to_owned(),
            variables: ["r", "a", "a"],
            unit: "m/s²",
            raw_unit: "counts".to_owned(),
            matrix: &ACCEL.0,
            bias: &ACCEL.1,
            coupling: None,
            takes_accel: false,
        };
        let gyroscope = Formula {
            sensor: "gyroscope",
            function: "calibrate_gyroscope".to_owned(),
            variables: ["r", "a", "w"],
            unit: "rad/s",
            raw_unit: "°/s".to_owned(),
            matrix: &GYRO.0,
            bias: &GYRO.1,
            coupling: Some(&COUPLING),
            takes_accel: true,
        };
        [accelerometer, gyroscope]
    }

    fn code(language: Language, formulas: &[Formula<'_>]) -> String {
        let parts: Vec<String> = formulas.iter().map(|f| f.code(language)).collect();
        parts.join("\n")
    }

    /// Output of the program; none where it is not installed.
    fn run(
        program: &str,
        call: impl Fn(&mut Command) -> std::io::Result<Output>,
    ) -> Option<String> {
        match call(&mut Command::new(program)) {
            Ok(output) => {
                assert!(
                    output.status.success(),
                    "{}",
                    String::from_utf8_lossy(&output.stderr)
                );
                Some(String::from_utf8(output.stdout).unwrap())
            }
            Err(e) => {
                assert!(std::env::var_os("CI").is_none(), "{program}: {e}");
                println!("skipped: {program}: {e}");
                None
            }
        }
    }

    #[test]
    fn what_is_pasted_compiles_and_calibrates() {
        let raw = [1.25, -9.5, 3.0];
        let less = |b: [f64; 3]| std::array::from_fn(|i| raw[i] - b[i]);
        let accel: [f64; 3] = mul_vec(&ACCEL.0, &less(ACCEL.1));
        let coupled = mul_vec(&COUPLING, &accel);
        let offset = std::array::from_fn(|i| GYRO.1[i] + coupled[i]);
        let rate = mul_vec(&GYRO.0, &less(offset));
        let agrees = |out: Option<String>| {
            let Some(out) = out else { return };
            let numbers: Vec<f64> = out.split_whitespace().map(|w| w.parse().unwrap()).collect();
            assert_eq!(numbers.len(), 6, "{out}");
            for (n, want) in numbers.iter().zip(accel.iter().chain(&rate)) {
                assert!(
                    (n - want).abs() <= 1e-7 * want.abs().max(1e-3),
                    "{n} {want}"
                );
            }
        };
        let folder = tempfile::tempdir().unwrap();
        let source = folder.path().join("paste.c");
        let program = folder.path().join("paste");
        let main = "\n#include <stdio.h>\nint main(void) { double r[3] = {1.25, -9.5, 3.0}, a[3], w[3];\n calibrate_accelerometer(r, a); calibrate_gyroscope(r, a, w);\n for (int i = 0; i < 3; i++) printf(\"%.12g \", a[i]);\n for (int i = 0; i < 3; i++) printf(\"%.12g \", w[i]);\n return 0; }\n";
        let mut text = std::fs::File::create(&source).unwrap();
        write!(text, "{}{main}", code(Language::C, &formulas())).unwrap();
        let built = run("gcc", |c| {
            c.args(["-Wall", "-Wextra", "-Werror", "-std=c99", "-o"])
                .arg(&program)
                .arg(&source)
                .output()
        });
        agrees(built.and_then(|_| run(program.to_str().unwrap(), Command::output)));
        let main = "r = [1.25, -9.5, 3.0]\na = calibrate_accelerometer(r)\nprint(*a, *calibrate_gyroscope(r, a))\n";
        let python = format!("{}{main}", code(Language::Python, &formulas()));
        agrees(run("python3", |c| c.arg("-c").arg(&python).output()));
    }

    #[test]
    fn terms_that_are_zero_are_left_out() {
        assert_eq!(
            code(Language::Equation, &formulas()[..1]),
            "(r: accelerometer, raw, counts; a: m/s²)\nux = rx + 0.500000\nuy = ry\nuz = rz - 12345.7\nax = 0.333333 ux - 2.00000e-7 uz\nay = -1.02000 ux\naz = 0.0\n"
        );
    }
}
