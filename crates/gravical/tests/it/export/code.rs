//! C, Arduino, Rust, Python, MATLAB, and what a report has to paste.

use super::*;

/// A program that calibrates lines of six numbers with `calls`.
fn main_in_c(head: &str, raw: &str, calls: &str) -> String {
    format!(
        "{head}\n#include <stdint.h>\n#include <stdio.h>\nint main(void) {{\n double v[6]; float a[3], w[3];\n while (scanf(\"%lf %lf %lf %lf %lf %lf\", &v[0], &v[1], &v[2], &v[3], &v[4], &v[5]) == 6) {{\n  {raw} r[3], g[3];\n  for (int i = 0; i < 3; i++) {{ r[i] = ({raw})v[i]; g[i] = ({raw})v[3 + i]; }}\n  {calls}\n  printf(\"%.9g %.9g %.9g %.9g %.9g %.9g\\n\", (double)a[0], (double)a[1], (double)a[2], (double)w[0], (double)w[1], (double)w[2]);\n }}\n return 0;\n}}\n"
    )
}

const STRICT: &str =
    "-Wall -Wextra -Werror -pedantic -Wdouble-promotion -Wshadow -Wno-unused-function";

/// Compiles as C99 and as C++11, runs the first, and compares.
fn compiles_and_agrees(file: &CalibrationFile, header: &str, main: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    save(path, "cal.h", header);
    save(path, "main.c", main);
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
    let sizes = if counts { [32000.0; 2] } else { [4.0, 500.0] };
    let (accel, gyro) = (vectors(1, sizes[0]), vectors(2, sizes[1]));
    agree(
        &run_main(path, &lines(&accel, &gyro)),
        &calibrated(file, &accel, &gyro),
    );
}

/// Output of the program that was compiled into the folder.
fn run_main(folder: &Path, input: &str) -> String {
    let program = folder.join("main");
    output(program.to_str().unwrap(), &[], folder, input).unwrap()
}

#[test]
fn c_compiles_and_calibrates_alike() {
    for (file, raw, ending) in [
        (in_counts(), "int16_t", "_counts"),
        (in_counts(), "float", ""),
        (in_g(), "float", ""),
    ] {
        let options = options_with(|o| o.name = Some("imu_left".to_owned()));
        let header = export_to(&file, "c", &options).unwrap().text;
        let calls = format!("imu_left_accel{ending}(r, a); imu_left_gyro{ending}(g, a, w);");
        let main = main_in_c("#include \"cal.h\"", raw, &calls);
        compiles_and_agrees(&file, &header, &main);
    }
}

#[test]
fn the_arduino_header_compiles_and_calibrates_alike() {
    for (file, raw) in [(in_counts(), "int16_t"), (in_g(), "float")] {
        let header = written(&file, "arduino").text;
        let calls = "gravical_apply(r, a); gravical_apply_gyro(g, a, w);";
        compiles_and_agrees(&file, &header, &main_in_c("#include \"cal.h\"", raw, calls));
    }
}

/// Raw values of the sensor's converter for a calibration that was made in SI units or in counts
/// whose gyroscope does not say what they are.
fn for_the_converter() -> ExportOptions {
    options_with(|o| (o.counts_per_g, o.counts_per_deg_s) = (Some(16384.0), Some(131.0)))
}

#[test]
fn counts_of_a_converter_stand_for_the_unit_of_the_recordings() {
    // In counts of half the range, and in SI units: the same for a sketch that reads 16384 per g.
    let half = calibration::in_counts(8192.0, 131.0);
    let calls = "gravical_apply(r, a); gravical_apply_gyro(g, a, w);";
    for file in [in_counts(), half, in_g()] {
        let header = export_to(&file, "arduino", &for_the_converter()).unwrap();
        assert!(
            !header
                .notes
                .iter()
                .any(|n| n.contains("give the counts per g"))
        );
        let main = main_in_c("#include \"cal.h\"", "int16_t", calls);
        compiles_and_agrees(&in_counts(), &header.text, &main);
    }
    // A gyroscope in counts does not say of which range; its own scale shows that it is not that.
    let other = ExportOptions {
        counts_per_deg_s: Some(65.5),
        ..for_the_converter()
    };
    let refused = export_to(&in_counts(), "arduino", &other).unwrap_err();
    assert_eq!(refused.code(), "export-unit");
    let message = refused.to_string();
    assert!(message.contains("13") && message.contains("65.5"));
    // What is not said is not assumed.
    assert!(written(&in_g(), "arduino").notes[0].contains("give the counts per g"));
}

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
        save(
            path,
            "main.rs",
            &format!(
                "mod cal;\nuse std::io::Read;\nfn main() {{\n let mut text = String::new();\n std::io::stdin().read_to_string(&mut text).unwrap();\n let mut out = String::new();\n for line in text.lines() {{\n  let v: Vec<f64> = line.split(' ').map(|w| w.parse().unwrap()).collect();\n  let a = cal::apply([v[0] as {raw}, v[1] as {raw}, v[2] as {raw}]);\n  let w = cal::apply_gyro([v[3] as {raw}, v[4] as {raw}, v[5] as {raw}], a);\n  out += &format!(\"{{}} {{}} {{}} {{}} {{}} {{}}\\n\", a[0], a[1], a[2], w[0], w[1], w[2]);\n }}\n print!(\"{{out}}\");\n}}\n"
            ),
        );
        let lib = "--edition=2021 --crate-type=lib --emit=metadata lib.rs";
        let lib: Vec<&str> = lib.split(' ').collect();
        if output(&rustc, &lib, path, "").is_none() {
            return;
        }
        output(&rustc, &["--edition=2021", "main.rs"], path, "").unwrap();
        let (accel, gyro) = (vectors(3, sizes[0]), vectors(4, sizes[1]));
        agree(
            &run_main(path, &lines(&accel, &gyro)),
            &calibrated(&file, &accel, &gyro),
        );
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
    save(folder.path(), "cal.py", &written(&file, "python").text);
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
    let text = written(&file, "matlab").text;
    assert!(text.starts_with("function cal = gravical()\n") && text.ends_with("\nend\n"));
    for formula in [
        "cal.accel = @(raw) bsxfun(@minus, raw, accel_bias) * accel_matrix.';",
        "cal.gyro = @(raw, accel) (bsxfun(@minus, raw, gyro_bias) - accel * gyro_g_sensitivity.') * gyro_matrix.';",
    ] {
        assert!(text.contains(formula), "{text}");
    }
    let (accel, gyro) = (vectors(7, 32000.0), vectors(8, 32000.0));
    let of = |name: &str| literal(&text, name);
    let own = accel.iter().zip(&gyro).map(|(a, w)| {
        let a = times(&of("accel_matrix"), less(*a, &of("accel_bias")));
        let bent = times(&of("gyro_g_sensitivity"), a);
        let w = less(less(*w, &of("gyro_bias")), &bent);
        [a, times(&of("gyro_matrix"), w)]
    });
    agree_rows(&own.collect::<Vec<_>>(), &calibrated(&file, &accel, &gyro));
}

#[test]
fn what_a_report_has_to_paste_compiles_and_calibrates_alike() {
    let mut uncoupled = in_g();
    uncoupled.gyroscope.as_mut().unwrap().g_sensitivity = [[0.0; 3]; 3];
    for (file, a) in [(in_g(), "a, "), (uncoupled, "")] {
        let [(_, _, c), (_, _, python), (_, _, equation)] = gravical::export::snippets(&file);
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
        let calls = format!("calibrate_accelerometer(v, a); calibrate_gyroscope(v + 3, {a}w);");
        save(
            path,
            "main.c",
            &format!(
                "{c}\n#include <stdio.h>\nint main(void) {{\n double v[6], a[3], w[3];\n while (scanf(\"%lf %lf %lf %lf %lf %lf\", v, v + 1, v + 2, v + 3, v + 4, v + 5) == 6) {{\n  {calls}\n  printf(\"%.12g %.12g %.12g %.12g %.12g %.12g\\n\", a[0], a[1], a[2], w[0], w[1], w[2]);\n }}\n return 0;\n}}\n"
            ),
        );
        let args = [
            "-Wall", "-Wextra", "-Werror", "-std=c99", "-o", "main", "main.c",
        ];
        if output("gcc", &args, path, "").is_some() {
            agree(&run_main(path, &input), &wanted);
        }
    }
}
