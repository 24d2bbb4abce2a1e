//! What the tests of the program share.

#[path = "../../../../tests/support/synthetic.rs"]
mod synthetic;

pub use synthetic::*;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use gravical::calibration_file::Calibration;
use serde_json::Value;

/// What a run of the program left behind.
pub struct Run {
    pub code: i32,
    pub out: String,
    pub err: String,
}

/// Runs `gravical` in `folder` with what `change` gives it.
pub fn run_with(folder: &Path, change: impl FnOnce(&mut Command) -> &mut Command) -> Run {
    let mut command = Command::new(program());
    Run::of(change(command.current_dir(folder)).output().unwrap())
}

/// Runs `gravical` with `args` in `folder`.
pub fn run_in<S: AsRef<OsStr>>(folder: &Path, args: impl IntoIterator<Item = S>) -> Run {
    let run = run_with(folder, |command| command.args(args));
    assert!(run.code != 1 && run.code != 101, "{}{}", run.out, run.err);
    run
}

/// Starts `gravical` with the words of `line` between pipes.
pub fn start(folder: &Path, line: &str) -> Child {
    let mut command = Command::new(program());
    let command = command.args(words(line)).current_dir(folder);
    let command = command.stdin(Stdio::piped()).stdout(Stdio::piped());
    command.stderr(Stdio::piped()).spawn().unwrap()
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
    pub fn of(output: Output) -> Self {
        let [out, err] = [output.stdout, output.stderr].map(|b| String::from_utf8(b).unwrap());
        assert!(!err.contains("panicked"), "{err}");
        let code = output.status.code().expect("ended by a signal");
        Run { code, out, err }
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}\n{}{}", self.out, self.err))
    }

    /// The calibration on stdout, held against the schema.
    pub fn calibration(&self) -> Value {
        let value = self.json();
        if let Err(error) = jsonschema::validate(&Calibration::schema(), &value) {
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
    let names = entries.map(|e| e.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
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

/// The entries of a list.
pub fn list(value: &Value) -> std::slice::Iter<'_, Value> {
    value.as_array().unwrap().iter()
}

pub fn text(value: &Value) -> &str {
    value.as_str().unwrap()
}

pub fn kinds(value: &Value) -> Vec<&str> {
    list(&value["findings"]).map(|f| text(&f["kind"])).collect()
}

pub fn finding<'a>(value: &'a Value, kind: &str) -> &'a Value {
    let found = list(&value["findings"]).find(|f| f["kind"] == kind);
    found.unwrap_or_else(|| panic!("no {kind} among {:?}", kinds(value)))
}

/// Every file under `folder` that may be a recording.
pub fn recordings(folder: &Path) -> Vec<PathBuf> {
    let mut all = below(folder);
    all.retain(|path| {
        let ending = path.extension().and_then(OsStr::to_str);
        ending.is_some_and(|e| ["csv", "tsv", "log", "txt", "gz", "cwa"].contains(&e))
    });
    all
}

/// No line of a terminal is longer.
pub fn narrow(text: &str) {
    for line in text.lines() {
        assert!(line.chars().count() <= 80, "{line}");
        assert_eq!(line, line.trim_end(), "{line:?}");
    }
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
        write(folder, &format!("{name}.csv"), &text);
    }
}

/// A path as the system writes it.
pub fn native(path: &str) -> String {
    path.replace('/', std::path::MAIN_SEPARATOR_STR)
}

pub fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}
