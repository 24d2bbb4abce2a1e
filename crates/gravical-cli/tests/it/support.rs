//! What the tests of the program share.

#[path = "../../../../tests/support/synthetic.rs"]
mod synthetic;

pub use synthetic::*;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use gravical::calibration_file::CalibrationFile;
use serde_json::Value;

/// What a run of the program left behind.
pub struct Run {
    pub code: i32,
    pub out: String,
    pub err: String,
}

/// Runs `gravical` with `args` in `folder`.
pub fn run_in<S: AsRef<OsStr>>(folder: &Path, args: impl IntoIterator<Item = S>) -> Run {
    let output = Command::new(program())
        .args(args)
        .current_dir(folder)
        .output()
        .unwrap();
    let run = Run {
        code: output.status.code().expect("ended by a signal"),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    };
    assert!(!run.err.contains("panicked"), "{}", run.err);
    assert!(run.code != 1 && run.code != 101, "{}{}", run.out, run.err);
    run
}

pub fn run<S: AsRef<OsStr>>(args: impl IntoIterator<Item = S>) -> Run {
    run_in(Path::new("."), args)
}

/// The words of a command line; none of the paths in it has a space.
pub fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(str::to_owned).collect()
}

pub fn program() -> PathBuf {
    PathBuf::from(env!("CARGO_BIN_EXE_gravical"))
}

impl Run {
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}\n{}{}", self.out, self.err))
    }

    /// The calibration on stdout, held against the schema.
    pub fn calibration(&self) -> Value {
        let value = self.json();
        if let Err(error) = jsonschema::validate(&CalibrationFile::schema(), &value) {
            panic!("{error} at {}", error.instance_path());
        }
        value
    }
}

/// Runs the words of `line`; the exit code has to be `code`.
pub fn ends(folder: &Path, line: &str, code: i32) -> Run {
    let run = run_in(folder, words(line));
    assert_eq!(run.code, code, "{line}\n{}{}", run.out, run.err);
    run
}

/// The same with `--json`: what is printed.
pub fn json(folder: &Path, line: &str, code: i32) -> Value {
    ends(folder, &format!("{line} --json"), code).json()
}

/// The call is refused with this exit code and code; the error.
pub fn fails(folder: &Path, line: &str, exit: i32, code: &str) -> Value {
    let error = json(folder, line, exit);
    assert_eq!(error["code"], code, "{line}\n{error}");
    error
}

/// `calibrate … --json` of words; the exit code has to be `code`.
pub fn calibrate(folder: &Path, line: &str, code: i32) -> Value {
    ends(folder, &format!("calibrate {line} --json"), code).calibration()
}

pub fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

/// Every file below a folder, in order.
pub fn below(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => all.extend(below(&path)),
            false => all.push(path),
        }
    }
    all.sort();
    all
}

/// What is in a folder, in order.
pub fn listed(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// A folder with the recordings of `gravical demo` in `d`, and the calibration by its poses.
pub fn demo() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/demo");
    for name in ["poses/poses.csv", "line/line.csv"] {
        let to = folder.path().join("d").join(name);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(examples.join(name), to).unwrap();
    }
    let line = "calibrate d/poses/poses.csv --gravity 9.80665 -o d/calibration.json -q";
    ends(folder.path(), line, 0);
    folder
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

pub fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        other => vec![number(other)],
    }
}

/// Every number agrees relative to the largest of its kind.
pub fn agree(got: &[f64], want: &[f64], relative: f64, what: &str) {
    assert_eq!(got.len(), want.len(), "{what}");
    for (g, w) in got.iter().zip(want) {
        assert!(
            (g - w).abs() <= relative * w.abs().max(f64::MIN_POSITIVE),
            "{what}: {g} against {w}"
        );
    }
}

pub fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} against {b} ± {tolerance}");
}

pub fn kinds(value: &Value) -> Vec<String> {
    value["findings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| f["kind"].as_str().unwrap().to_owned())
        .collect()
}

pub fn finding<'a>(value: &'a Value, kind: &str) -> &'a Value {
    value["findings"]
        .as_array()
        .unwrap()
        .iter()
        .find(|f| f["kind"] == kind)
        .unwrap_or_else(|| panic!("no {kind} among {:?}", kinds(value)))
}

pub fn poses(calibration: &Value) -> &[Value] {
    calibration["accelerometer"]["poses"].as_array().unwrap()
}

/// A folder with the six files of a synthetic sensor.
pub fn six_files(sensor: &Sensor) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_six_files(folder.path(), sensor);
    folder
}

pub fn write_six_files(folder: &Path, sensor: &Sensor) {
    for (i, (name, up)) in FACES.iter().enumerate() {
        let text = sensor.file(*up, 500, 100 + i as u64);
        std::fs::write(folder.join(format!("{name}.csv")), text).unwrap();
    }
}

pub fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}
