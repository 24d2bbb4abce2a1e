//! C, Arduino, Rust, Python, and what a report has to paste.

use super::*;

/// A program that calibrates lines of six numbers with `calls`, from values of the type `raw` to those of
/// the type `real`.
const MAIN_C: &str = r#"#include <stdint.h>
#include <stdio.h>
int main(void) {
 double v[6]; real a[3], w[3];
 while (scanf("%lf %lf %lf %lf %lf %lf", v, v + 1, v + 2, v + 3, v + 4, v + 5) == 6) {
  raw r[3], g[3];
  for (int i = 0; i < 3; i++) { r[i] = (raw)v[i]; g[i] = (raw)v[3 + i]; }
  calls
  printf("%.9g %.9g %.9g", (double)a[0], (double)a[1], (double)a[2]);
  printf(" %.9g %.9g %.9g\n", (double)w[0], (double)w[1], (double)w[2]);
 }
 return 0;
}
"#;

fn main_c(head: &str, [raw, real]: [&str; 2], calls: &str) -> String {
    let main = MAIN_C.replace("raw", raw).replace("real", real);
    format!("{head}\n{}", main.replace("calls", calls))
}

const STRICT: &str =
    "-Wall -Wextra -Werror -pedantic -Wdouble-promotion -Wshadow -Wno-unused-function";

/// Compiles as C99 and as C++11, runs the first, and compares.
fn compiles_and_agrees(file: &Calibration, header: &str, raw: &str, calls: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    save(path, "cal.h", header);
    save(
        path,
        "main.c",
        &main_c("#include \"cal.h\"", [raw, "float"], calls),
    );
    let compile = |program, rest: &str| {
        let args: Vec<&str> = STRICT.split(' ').chain(rest.split(' ')).collect();
        output(program, &args, path, "")
    };
    if compile("g++", "-std=c++11 -fsyntax-only -x c++ main.c").is_none()
        || compile("gcc", "-std=c99 -o main main.c").is_none()
    {
        return;
    }
    let counts = file.accelerometer.input_unit == AccelUnit::Counts;
    agrees(file, if counts { [32000.0; 2] } else { [4.0, 500.0] }, path);
}

/// Compares what the program that was compiled into the folder makes of vectors of these sizes.
fn agrees(file: &Calibration, sizes: [f64; 2], path: &Path) {
    let (accel, gyro) = (vectors(1, sizes[0]), vectors(2, sizes[1]));
    let out = run_main(path, &lines(&accel, &gyro));
    agree(&out, &calibrated(file, &accel, &gyro));
}

/// Output of the program that was compiled into the folder.
fn run_main(folder: &Path, input: &str) -> String {
    let program = folder.join("main");
    output(program.to_str().unwrap(), &[], folder, input).unwrap()
}

#[test]
fn c_and_arduino_compile_and_calibrate_alike() {
    for (file, raw, ending) in [
        (in_counts(), "int16_t", "_counts"),
        (in_counts(), "float", ""),
        (in_g(), "float", ""),
    ] {
        let options = options_with(|o| o.name = Some("imu_left".to_owned()));
        let header = export_to(&file, "c", &options).unwrap().text;
        let calls = format!("imu_left_accel{ending}(r, a); imu_left_gyro{ending}(g, a, w);");
        compiles_and_agrees(&file, &header, raw, &calls);
    }
    let calls = "gravical_apply(r, a); gravical_apply_gyro(g, a, w);";
    // Raw values of the sensor's converter, for a calibration in counts of half the range and in SI units:
    // the same for a sketch that reads 16384 per g.
    let converter =
        options_with(|o| (o.counts_per_g, o.counts_per_deg_s) = (Some(16384.0), Some(131.0)));
    let half = calibration::in_counts(8192.0, 131.0);
    let plain = ExportOptions::default();
    for (file, read_as, options) in [
        (in_counts(), in_counts(), &plain),
        (in_g(), in_g(), &plain),
        (in_counts(), in_counts(), &converter),
        (half, in_counts(), &converter),
        (in_g(), in_counts(), &converter),
    ] {
        let header = export_to(&file, "arduino", options).unwrap();
        let is_counts = read_as.accelerometer.input_unit == AccelUnit::Counts;
        let raw = if is_counts { "int16_t" } else { "float" };
        compiles_and_agrees(&read_as, &header.text, raw, calls);
        // What is not said is not assumed.
        let mut notes = header.notes.iter();
        let asks = notes.any(|n| n.contains("give the counts per g"));
        assert_eq!(asks, !is_counts);
    }
    // A gyroscope in counts does not say of which range; its own scale shows that it is not that.
    let other =
        options_with(|o| (o.counts_per_g, o.counts_per_deg_s) = (Some(16384.0), Some(65.5)));
    let refused = export_to(&in_counts(), "arduino", &other).unwrap_err();
    assert_eq!(refused.code(), "export-unit");
}

/// The types of Fusion and its model of an inertial sensor: misalignment · ((raw − offset) ∘ sensitivity).
const FUSION_H: &str = "\
typedef union { float array[3]; struct { float x, y, z; } axis; } FusionVector;
typedef union { float array[3][3]; } FusionMatrix;
static void calibrate(const float r[3], FusionMatrix m, FusionVector s, FusionVector o, float unit, float out[3]) {
 for (int i = 0; i < 3; i++) { out[i] = 0.0f; for (int j = 0; j < 3; j++)
  out[i] += unit * m.array[i][j] * (r[j] - o.array[j]) * s.array[j]; }
}
";

#[test]
fn fusion_calibrates_alike_in_g_and_degrees() {
    for mut file in [in_counts(), in_g()] {
        let coupled = written(&file, "fusion").notes;
        assert_eq!(coupled, ["Without the g-sensitivity of the gyroscope."]);
        file.gyroscope.as_mut().unwrap().g_sensitivity = [[0.0; 3]; 3];
        let header = written(&file, "fusion");
        assert!(header.notes.is_empty());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        save(path, "Fusion.h", FUSION_H);
        save(path, "cal.h", &header.text);
        let call = |name: &str, raw: &str, unit: f64, out: &str| {
            let of = ["misalignment", "sensitivity", "offset"]
                .map(|part| format!("gravical_{name}_{part}"))
                .join(", ");
            format!("calibrate({raw}, {of}, {unit:.9}f, {out});")
        };
        let calls =
            call("accelerometer", "r", G, "a") + &call("gyroscope", "g", 1f64.to_radians(), "w");
        let main = main_c("#include \"cal.h\"", ["float"; 2], &calls);
        save(path, "main.c", &main);
        let args = "-Wall -Wextra -Werror -std=c99 -I. -o main main.c";
        let args: Vec<&str> = args.split(' ').collect();
        if output("gcc", &args, path, "").is_some() {
            let counts = file.accelerometer.input_unit == AccelUnit::Counts;
            agrees(
                &file,
                if counts { [32000.0; 2] } else { [4.0, 500.0] },
                path,
            );
        }
    }
}

const MAIN_RS: &str = r#"mod cal;
use std::io::Read;
fn main() {
 let mut text = String::new();
 std::io::stdin().read_to_string(&mut text).unwrap();
 for line in text.lines() {
  let v: Vec<f64> = line.split(' ').map(|w| w.parse().unwrap()).collect();
  let a = cal::apply([v[0] as raw, v[1] as raw, v[2] as raw]);
  let w = cal::apply_gyro([v[3] as raw, v[4] as raw, v[5] as raw], a);
  println!("{} {} {} {} {} {}", a[0], a[1], a[2], w[0], w[1], w[2]);
 }
}
"#;

#[test]
fn rust_compiles_without_the_standard_library_and_calibrates_alike() {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    for (file, raw, sizes) in [
        (in_counts(), "i16", [32000.0; 2]),
        (in_g(), "f32", [4.0, 500.0]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        save(path, "cal.rs", &written(&file, "rust").text);
        let lib = "#![no_std]\n#![deny(warnings)]\npub mod cal;\n";
        save(path, "lib.rs", lib);
        save(path, "main.rs", &MAIN_RS.replace("raw", raw));
        let lib = "--edition=2021 --crate-type=lib --emit=metadata lib.rs";
        let lib: Vec<&str> = lib.split(' ').collect();
        if output(&rustc, &lib, path, "").is_none() {
            return;
        }
        output(&rustc, &["--edition=2021", "main.rs"], path, "").unwrap();
        agrees(&file, sizes, path);
    }
}

const MAIN_PY: &str = "import sys
import numpy as np
from cal import gravical_accel, gravical_gyro
v = np.loadtxt(sys.stdin)
a = gravical_accel(v[:, :3])
w = gravical_gyro(v[:, 3:], a)
assert np.allclose(gravical_accel(list(v[0, :3])), a[0])
assert np.allclose(gravical_gyro(v[0, 3:], a[0]), w[0])
np.savetxt(sys.stdout, np.hstack([a, w]))
";

#[test]
fn python_calibrates_arrays_alike() {
    let python = std::env::var("GRAVICAL_NUMPY_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let numpy = Command::new(&python).args(["-c", "import numpy"]).output();
    if !numpy.is_ok_and(|o| o.status.success()) {
        println!("skipped: {python} has no NumPy");
        return;
    }
    let file = in_g();
    let folder = tempfile::tempdir().unwrap();
    save(folder.path(), "cal.py", &written(&file, "python").text);
    save(folder.path(), "main.py", MAIN_PY);
    let (accel, gyro) = (vectors(5, 4.0), vectors(6, 500.0));
    let out = output(&python, &["main.py"], folder.path(), &lines(&accel, &gyro)).unwrap();
    agree(&out, &calibrated(&file, &accel, &gyro));
}

#[test]
fn what_a_report_has_to_paste_compiles_and_calibrates_alike() {
    let mut uncoupled = in_g();
    uncoupled.gyroscope.as_mut().unwrap().g_sensitivity = [[0.0; 3]; 3];
    for (file, a) in [(in_g(), "a, "), (uncoupled, "")] {
        let [(_, c), (_, python), (_, equation)] = gravical::export::snippets(&file);
        assert!(equation.starts_with("(r: accelerometer, raw, g; a: m/s²)\nux = rx - 0.0316"));
        assert_eq!(equation.contains(" ax "), !a.is_empty(), "{equation}");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let (accel, gyro) = (vectors(16, 4.0), vectors(17, 500.0));
        let wanted = calibrated(&file, &accel, &gyro);
        let input = lines(&accel, &gyro);
        let main = format!(
            "import sys\nfor line in sys.stdin:\n    v = [float(w) for w in line.split()]\n    a = calibrate_accelerometer(v[:3])\n    print(*a, *calibrate_gyroscope(v[3:], {a}))\n"
        );
        save(path, "main.py", &format!("{python}\n{main}"));
        if let Some(out) = output("python3", &["main.py"], path, &input) {
            agree(&out, &wanted);
        }
        let calls = format!("calibrate_accelerometer(r, a); calibrate_gyroscope(g, {a}w);");
        save(path, "main.c", &main_c(&c, ["double"; 2], &calls));
        let args = "-Wall -Wextra -Werror -std=c99 -o main main.c";
        let args: Vec<&str> = args.split(' ').collect();
        if output("gcc", &args, path, "").is_some() {
            agree(&run_main(path, &input), &wanted);
        }
    }
}
