//! C, Arduino, Rust, Python, MATLAB, x-io Fusion.

use super::*;

/// A program that calibrates lines of six numbers with `calls`.
fn main_in_c(head: &str, raw: &str, calls: &str) -> String {
    format!(
        "{head}\n#include <stdint.h>\n#include <stdio.h>\nint main(void) {{\n double v[6]; float a[3], w[3];\n while (scanf(\"%lf %lf %lf %lf %lf %lf\", &v[0], &v[1], &v[2], &v[3], &v[4], &v[5]) == 6) {{\n  {raw} r[3], g[3];\n  for (int i = 0; i < 3; i++) {{ r[i] = ({raw})v[i]; g[i] = ({raw})v[3 + i]; }}\n  {calls}\n  printf(\"%.9g %.9g %.9g %.9g %.9g %.9g\\n\", (double)a[0], (double)a[1], (double)a[2], (double)w[0], (double)w[1], (double)w[2]);\n }}\n return 0;\n}}\n"
    )
}

const STRICT: [&str; 6] = [
    "-Wall",
    "-Wextra",
    "-Werror",
    "-pedantic",
    "-Wdouble-promotion",
    "-Wshadow",
];

/// Compiles as C99 and as C++11, runs the first, and compares.
fn compiles_and_agrees(file: &CalibrationFile, header: &str, main: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    save(path, "cal.h", header);
    save(path, "main.c", main);
    let args = |rest: &[&'static str]| [rest, &STRICT[..]].concat();
    let c = ["-std=c99", "-Wno-unused-function", "-o", "main", "main.c"];
    let cpp = [
        "-std=c++11",
        "-Wno-unused-function",
        "-fsyntax-only",
        "-x",
        "c++",
        "main.c",
    ];
    if output("g++", &args(&cpp), path, "").is_none()
        || output("gcc", &args(&c), path, "").is_none()
    {
        return;
    }
    let program = path.join("main");
    let counts = file.accelerometer.input_unit == AccelUnit::Counts;
    let sizes = if counts { [32000.0; 2] } else { [4.0, 500.0] };
    let (accel, gyro) = (vectors(1, sizes[0]), vectors(2, sizes[1]));
    let out = output(program.to_str().unwrap(), &[], path, &lines(&accel, &gyro)).unwrap();
    agree(&out, &calibrated(file, &accel, &gyro));
}

#[test]
fn c_compiles_and_calibrates_alike() {
    for (file, raw, ending) in [
        (in_counts(), "int16_t", "_counts"),
        (in_counts(), "float", ""),
        (in_g(), "float", ""),
    ] {
        let options = ExportOptions {
            name: Some("imu_left".to_owned()),
            ..ExportOptions::default()
        };
        let header = export(&file, Target::C, &options).unwrap().text;
        let calls = format!("imu_left_accel{ending}(r, a); imu_left_gyro{ending}(g, a, w);");
        let main = main_in_c("#include \"cal.h\"", raw, &calls);
        compiles_and_agrees(&file, &header, &main);
    }
}

#[test]
fn the_arduino_header_compiles_and_calibrates_alike() {
    for (file, raw) in [(in_counts(), "int16_t"), (in_g(), "float")] {
        let header = written(&file, Target::Arduino).text;
        let calls = "gravical_apply(r, a); gravical_apply_gyro(g, a, w);";
        compiles_and_agrees(&file, &header, &main_in_c("#include \"cal.h\"", raw, calls));
        // The compiler of the board itself, where it is installed; it is no part of a build server.
        let folder = tempfile::tempdir().unwrap();
        save(folder.path(), "cal.h", &header);
        let sketch = format!(
            "#include \"cal.h\"\nvoid f(const {raw} r[3], float a[3]) {{ gravical_apply(r, a); }}\n"
        );
        save(folder.path(), "sketch.c", &sketch);
        if Command::new("avr-gcc").arg("--version").output().is_ok() {
            let args = [
                "-mmcu=atmega328p",
                "-std=gnu11",
                "-Os",
                "-Wall",
                "-Wno-unused-function",
                "-Werror",
                "-c",
                "sketch.c",
            ];
            output("avr-gcc", &args, folder.path(), "").unwrap();
        }
    }
}

/// Raw values of the sensor's converter for a calibration that was made in SI units or in counts
/// whose gyroscope does not say what they are.
fn for_the_converter() -> ExportOptions {
    ExportOptions {
        counts_per_g: Some(16384.0),
        counts_per_deg_s: Some(131.0),
        ..ExportOptions::default()
    }
}

#[test]
fn counts_of_a_converter_stand_for_the_unit_of_the_recordings() {
    // In counts of half the range, and in SI units: the same for a sketch that reads 16384 per g.
    let mut half = made(8192.0 / G, 131.0);
    half.accelerometer.input_unit = AccelUnit::Counts;
    half.accelerometer.scale_deviation_percent = Some([1.2, -0.7, 2.1]);
    half.gyroscope.as_mut().unwrap().input_unit = GyroUnit::Counts;
    let calls = "gravical_apply(r, a); gravical_apply_gyro(g, a, w);";
    for file in [in_counts(), half, in_g()] {
        let header = export(&file, Target::Arduino, &for_the_converter()).unwrap();
        assert!(!header.notes.iter().any(|n| n.contains("--counts-per-g")));
        let main = main_in_c("#include \"cal.h\"", "int16_t", calls);
        compiles_and_agrees(&in_counts(), &header.text, &main);
    }
    // A gyroscope in counts does not say of which range; its own scale shows that it is not that.
    let other = ExportOptions {
        counts_per_deg_s: Some(65.5),
        ..for_the_converter()
    };
    let refused = export(&in_counts(), Target::Arduino, &other).unwrap_err();
    assert_eq!(refused.code(), "export-unit");
    let message = refused.to_string();
    assert!(
        message.contains("13") && message.contains("65.5"),
        "{message}"
    );
    // What is not said is not assumed.
    let written = export(&in_g(), Target::Arduino, &ExportOptions::default()).unwrap();
    assert!(!written.text.contains("_apply_q") && written.notes[0].contains("--counts-per-g"));
}

/// The largest errors of both sensors in fixed point, m/s² and rad/s, over all counts that are
/// ends of bytes and 10⁵ random ones, computed in C with a compiler that traps overflows.
fn worst_of_fixed_point(file: &CalibrationFile, header: &str, folder: &Path) -> Option<[f64; 2]> {
    let numbers = |m: &[[f64; 3]; 3]| -> String {
        m.iter().flatten().map(|v| format!("{v:.17e}, ")).collect()
    };
    let one = |v: &[f64; 3]| -> String { v.iter().map(|v| format!("{v:.17e}, ")).collect() };
    let (a, g) = (&file.accelerometer, file.gyroscope.as_ref().unwrap());
    save(folder, "cal.h", header);
    save(
        folder,
        "worst.c",
        &format!(
            r"#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include {include}
static const double S[9] = {{ {} }}, o[3] = {{ {} }}, M[9] = {{ {} }}, b[3] = {{ {} }}, K[9] = {{ {} }};
static double most[2];
static void times(const double *m, const double *v, double *out) {{
    for (int i = 0; i < 3; i++) out[i] = m[3*i] * v[0] + m[3*i+1] * v[1] + m[3*i+2] * v[2];
}}
static void one(const int16_t r[3], const int16_t w[3]) {{
    int32_t a[3], g[3];
    double u[3], f[3], k[3], q[3];
    gravical_apply_q(r, a);
    gravical_apply_gyro_q(w, r, g);
    for (int i = 0; i < 3; i++) u[i] = r[i] - o[i];
    times(S, u, f);
    times(K, f, k);
    for (int i = 0; i < 3; i++) u[i] = w[i] - b[i] - k[i];
    times(M, u, q);
    for (int i = 0; i < 3; i++) {{
        most[0] = fmax(most[0], fabs(ldexp(a[i], -GRAVICAL_ACCEL_Q) - f[i]));
        most[1] = fmax(most[1], fabs(ldexp(g[i], -GRAVICAL_GYRO_Q) - q[i]));
    }}
    if (GRAVICAL_ACCEL_FROM_Q != (float)ldexp(1.0, -GRAVICAL_ACCEL_Q)) abort();
    if (GRAVICAL_GYRO_FROM_Q != (float)ldexp(1.0, -GRAVICAL_GYRO_Q)) abort();
}}
int main(void) {{
    static const int16_t ends[4] = {{ -32768, -32513, 32512, 32767 }};
    for (int n = 0; n < 4096; n++) {{
        int16_t v[6];
        for (int i = 0; i < 6; i++) v[i] = ends[n >> (2 * i) & 3];
        one(v, v + 3);
    }}
    uint64_t state = 1;
    for (long n = 0; n < 100000; n++) {{
        int16_t v[6];
        for (int i = 0; i < 6; i++) {{
            state = state * 6364136223846793005u + 1442695040888963407u;
            v[i] = (int16_t)(int)(state >> 48);
        }}
        one(v, v + 3);
    }}
    printf(EXPONENT EXPONENT, most[0], most[1]);
    return 0;
}}
",
            numbers(&a.matrix),
            one(&a.bias),
            numbers(&g.matrix),
            one(&g.bias),
            numbers(&g.g_sensitivity),
            include = "\"cal.h\"",
        )
        .replace("EXPONENT", "\"%.9e \""),
    );
    let args = [
        "-std=c99",
        "-O1",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-pedantic",
        "-fsanitize=undefined",
        "-fno-sanitize-recover=all",
        "-o",
        "worst",
        "worst.c",
        "-lm",
    ];
    output("gcc", &args, folder, "")?;
    let out = output(folder.join("worst").to_str().unwrap(), &[], folder, "").unwrap();
    let both: Vec<f64> = out.split_whitespace().map(|w| w.parse().unwrap()).collect();
    Some([both[0], both[1]])
}

/// The bound in the comment of a header, in `unit`.
fn stated(header: &str, unit: &str) -> f64 {
    let ending = format!(" {unit} at all counts");
    let (before, _) = header.split_once(&ending).unwrap();
    before.rsplit(' ').next().unwrap().parse().unwrap()
}

#[test]
fn fixed_point_is_as_close_as_the_header_says() {
    let mut uncoupled = in_counts();
    uncoupled.gyroscope.as_mut().unwrap().g_sensitivity = [[0.0; 3]; 3];
    for file in [in_counts(), uncoupled] {
        let folder = tempfile::tempdir().unwrap();
        let header = export(&file, Target::Arduino, &for_the_converter())
            .unwrap()
            .text;
        let Some(worst) = worst_of_fixed_point(&file, &header, folder.path()) else {
            return;
        };
        for (worst, unit) in worst.into_iter().zip(["m/s^2", "rad/s"]) {
            let stated = stated(&header, unit);
            println!("{worst:.3e} {unit} of {stated:.1e}");
            // A bound that is reached, to its two digits, at the ends of the bytes.
            assert!(worst <= stated && worst > 0.85 * stated, "{worst} {stated}");
        }
        // Small parts of a count.
        let (force, rate) = (G / 16384.0, 1_f64.to_radians() / 131.0);
        assert!(
            worst[0] < force / 50.0 && worst[1] < rate / 25.0,
            "{worst:?}"
        );
    }
}

#[test]
fn rust_compiles_without_the_standard_library_and_calibrates_alike() {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    for (file, raw, name) in [(in_counts(), "i16", None), (in_g(), "f32", Some("imu"))] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let options = ExportOptions {
            name: name.map(str::to_owned),
            ..ExportOptions::default()
        };
        save(
            path,
            "cal.rs",
            &export(&file, Target::Rust, &options).unwrap().text,
        );
        save(
            path,
            "lib.rs",
            "#![no_std]\n#![deny(warnings)]\npub mod cal;\n",
        );
        let module = name.map_or("cal".to_owned(), |n| format!("cal::{n}"));
        save(
            path,
            "main.rs",
            &format!(
                "mod cal;\nuse std::io::Read;\nfn main() {{\n let mut text = String::new();\n std::io::stdin().read_to_string(&mut text).unwrap();\n let mut out = String::new();\n for line in text.lines() {{\n  let v: Vec<f64> = line.split(' ').map(|w| w.parse().unwrap()).collect();\n  let a = {module}::apply([v[0] as {raw}, v[1] as {raw}, v[2] as {raw}]);\n  let w = {module}::apply_gyro([v[3] as {raw}, v[4] as {raw}, v[5] as {raw}], a);\n  out += &format!(\"{{}} {{}} {{}} {{}} {{}} {{}}\\n\", a[0], a[1], a[2], w[0], w[1], w[2]);\n }}\n print!(\"{{out}}\");\n}}\n"
            ),
        );
        let lib = [
            "--edition=2021",
            "--crate-type=lib",
            "--emit=metadata",
            "lib.rs",
        ];
        if output(&rustc, &lib, path, "").is_none() {
            return;
        }
        output(&rustc, &["--edition=2021", "main.rs"], path, "").unwrap();
        let sizes = if name.is_none() {
            [32000.0; 2]
        } else {
            [4.0, 500.0]
        };
        let (accel, gyro) = (vectors(3, sizes[0]), vectors(4, sizes[1]));
        let program = path.join("main");
        let out = output(program.to_str().unwrap(), &[], path, &lines(&accel, &gyro)).unwrap();
        agree(&out, &calibrated(&file, &accel, &gyro));
    }
}

#[test]
fn python_calibrates_arrays_alike() {
    let python = std::env::var("GRAVICAL_IMUCAL_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let numpy = Command::new(&python).args(["-c", "import numpy"]).output();
    if !numpy.is_ok_and(|o| o.status.success()) {
        println!("skipped: {python} has no NumPy");
        return;
    }
    let file = in_g();
    let folder = tempfile::tempdir().unwrap();
    save(
        folder.path(),
        "cal.py",
        &written(&file, Target::Python).text,
    );
    save(
        folder.path(),
        "main.py",
        "import sys\nimport numpy as np\nfrom cal import gravical_accel, gravical_gyro\nv = np.loadtxt(sys.stdin)\na = gravical_accel(v[:, :3])\nw = gravical_gyro(v[:, 3:], a)\nassert np.allclose(gravical_accel(list(v[0, :3])), a[0])\nassert np.allclose(gravical_gyro(v[0, 3:], a[0]), w[0])\nnp.savetxt(sys.stdout, np.hstack([a, w]))\n",
    );
    let (accel, gyro) = (vectors(5, 4.0), vectors(6, 500.0));
    let out = output(&python, &["main.py"], folder.path(), &lines(&accel, &gyro)).unwrap();
    agree(&out, &calibrated(&file, &accel, &gyro));
}

/// The numbers between brackets behind `name = `.
fn literal(text: &str, name: &str) -> Vec<f64> {
    let (_, rest) = text.split_once(&format!("\n{name} = [")).unwrap();
    let (inside, _) = rest.split_once("];").unwrap();
    inside
        .split([' ', ';'])
        .filter(|w| !w.is_empty())
        .map(|w| w.parse().unwrap())
        .collect()
}

#[test]
fn the_matlab_function_holds_the_numbers_of_its_formula() {
    let file = in_counts();
    let text = written(&file, Target::Matlab).text;
    assert!(text.starts_with("function cal = gravical()\n") && text.ends_with("\nend\n"));
    for formula in [
        "cal.accel = @(raw) bsxfun(@minus, raw, accel_bias) * accel_matrix.';",
        "cal.gyro = @(raw, accel) (bsxfun(@minus, raw, gyro_bias) - accel * gyro_g_sensitivity.') * gyro_matrix.';",
    ] {
        assert!(text.contains(formula), "{text}");
    }
    let times = |m: &[f64], v: Vector| -> Vector {
        std::array::from_fn(|i| (0..3).map(|j| m[3 * i + j] * v[j]).sum())
    };
    let less = |a: Vector, b: &[f64]| -> Vector { std::array::from_fn(|i| a[i] - b[i]) };
    let (accel, gyro) = (vectors(7, 32000.0), vectors(8, 32000.0));
    let of = |name: &str| literal(&text, name);
    let out: String = accel
        .iter()
        .zip(&gyro)
        .map(|(a, w)| {
            let a = times(&of("accel_matrix"), less(*a, &of("accel_bias")));
            let bent = times(&of("gyro_g_sensitivity"), a);
            let w = times(&of("gyro_matrix"), less(less(*w, &of("gyro_bias")), &bent));
            format!(
                "{:e} {:e} {:e} {:e} {:e} {:e}\n",
                a[0], a[1], a[2], w[0], w[1], w[2]
            )
        })
        .collect();
    agree(&out, &calibrated(&file, &accel, &gyro));
}

/// The shapes of Fusion's types, and its model of inertial sensors.
const FUSION: &str = "#ifndef FUSION_H\n#define FUSION_H\ntypedef union { float array[3]; struct { float x, y, z; } axis; } FusionVector;\ntypedef union { float array[9]; struct { float xx, xy, xz, yx, yy, yz, zx, zy, zz; } element; } FusionMatrix;\nstatic void model(const float *u, FusionMatrix m, FusionVector s, FusionVector b, float *out) {\n float t[3];\n for (int i = 0; i < 3; i++) t[i] = (u[i] - b.array[i]) * s.array[i];\n for (int i = 0; i < 3; i++) out[i] = m.array[3 * i] * t[0] + m.array[3 * i + 1] * t[1] + m.array[3 * i + 2] * t[2];\n}\n#endif\n";

#[test]
fn fusion_compiles_and_calibrates_alike_in_its_units() {
    let mut file = in_counts();
    file.gyroscope.as_mut().unwrap().g_sensitivity = [[0.0; 3]; 3];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    save(path, "Fusion.h", FUSION);
    save(path, "cal.h", &written(&file, Target::Fusion).text);
    let call = |of: &str, raw: &str, out: &str| {
        format!(
            "model({raw}, gravical_{of}_misalignment, gravical_{of}_sensitivity, gravical_{of}_offset, {out});"
        )
    };
    let calls = format!(
        "{} {}",
        call("accelerometer", "r", "a"),
        call("gyroscope", "g", "w")
    );
    save(
        path,
        "main.c",
        &main_in_c("#include \"cal.h\"", "float", &calls),
    );
    let args = [
        "-std=c11",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-Wno-missing-braces",
        "-o",
        "main",
        "main.c",
    ];
    if output("gcc", &args, path, "").is_none() {
        return;
    }
    let (accel, gyro) = (vectors(9, 32000.0), vectors(10, 32000.0));
    let program = path.join("main");
    let out = output(program.to_str().unwrap(), &[], path, &lines(&accel, &gyro)).unwrap();
    let wanted: Vec<[Vector; 2]> = calibrated(&file, &accel, &gyro)
        .into_iter()
        .map(|[a, w]| [a.map(|v| v / G), w.map(f64::to_degrees)])
        .collect();
    agree(&out, &wanted);
}
