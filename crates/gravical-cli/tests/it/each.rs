//! Many sessions in one run: each result is that of the command alone, nothing that fails stops
//! the others, and a run that was interrupted ends as if it had not been.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::support::*;

/// Sessions of `count` sensors: `fleet/unit-1.csv` …, a few kilobytes each.
pub fn fleet(count: u64) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("fleet")).unwrap();
    for seed in 1..=count {
        let line =
            format!("simulate poses -o one --free 2 --hold 3 --rate 25 --seed {seed} --force -q");
        assert_eq!(run_in(at, words(&line)).code, 0);
        fs::rename(
            at.join("one/poses.csv"),
            at.join(format!("fleet/unit-{seed}.csv")),
        )
        .unwrap();
    }
    folder
}

/// The program with a fixed time, so that results can be compared byte for byte.
pub fn gravical(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(program());
    command
        .args(words(line))
        .current_dir(folder)
        .env("SOURCE_DATE_EPOCH", "1767225600");
    command
}

pub fn ends_with(folder: &Path, line: &str, code: i32) -> (String, String) {
    let output = gravical(folder, line).output().unwrap();
    let (out, err) = (
        String::from_utf8(output.stdout).unwrap(),
        String::from_utf8(output.stderr).unwrap(),
    );
    assert_eq!(output.status.code(), Some(code), "{line}\n{out}{err}");
    (out, err)
}

/// The rows of a summary.
pub fn rows(path: &Path) -> Vec<Value> {
    let text = fs::read_to_string(path).unwrap();
    let value: Value = serde_json::from_str(&text).unwrap();
    value["rows"].as_array().unwrap().clone()
}

/// Files of a folder with their bytes, without the journal.
pub fn results(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all: Vec<(String, Vec<u8>)> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| !p.to_string_lossy().ends_with(".ndjson"))
        .map(|p| {
            (
                p.file_name().unwrap().to_string_lossy().into_owned(),
                fs::read(&p).unwrap(),
            )
        })
        .collect();
    all.sort();
    all
}

#[test]
fn each_result_is_that_of_the_command_alone() {
    let folder = fleet(2);
    let at = folder.path();
    fs::create_dir(at.join("fleet/folder")).unwrap();
    write_six_files(&at.join("fleet/folder"), &Sensor::default());
    write(at, "fleet/broken.csv", "t,ax,ay,az\n1,2\n");
    write(
        at,
        "fleet/one-pose.csv",
        &Sensor::default().file([0.0, 0.0, 1.0], 500, 1),
    );
    write(at, "fleet/notes.md", "not a recording");
    let line = "calibrate --each fleet gone.csv --gravity 9.81 -o out --summary out/all.json";
    let (out, err) = ends_with(at, line, 4);
    assert!(err.contains("notes.md"), "{err}");
    let names: Vec<&str> = out
        .lines()
        .map(|l| l[14..].split_whitespace().next().unwrap())
        .collect();
    let expected = ["broken", "folder", "one-pose", "unit-1", "unit-2", "gone"];
    assert_eq!(names, expected, "{out}");
    let rows = rows(&at.join("out/all.json"));
    for (row, name) in rows.iter().zip(expected) {
        assert_eq!(row["name"], name);
    }
    let codes: Vec<&str> = [0, 2, 5]
        .map(|i: usize| rows[i]["error_code"].as_str().unwrap())
        .into();
    assert_eq!(codes, ["no-rows", "underdetermined", "not-found"]);
    assert!(rows[5]["sha256"].is_null() && rows[2]["hint"].is_string());
    for (row, input) in [(&rows[1], "folder"), (&rows[3], "unit-1.csv")] {
        let result = row["result"].as_str().unwrap();
        let command = format!("calibrate fleet/{input} --gravity=9.81 -o alone-{input}.json");
        ends_with(at, &command, 0);
        let read = |path: &str| -> Value {
            serde_json::from_slice(&fs::read(at.join(path)).unwrap()).unwrap()
        };
        let (mut own, mut alone) = (read(result), read(&format!("alone-{input}.json")));
        assert_eq!(
            own["command"],
            format!("gravical calibrate fleet/{input} --gravity=9.81 -o {result}")
        );
        for (key, value) in [
            ("bias_x", &own["accelerometer"]["bias"][0]),
            (
                "scale_z_sd",
                &own["accelerometer"]["deviations"]["scale"][2],
            ),
        ] {
            assert_eq!(row[key], *value);
        }
        own["command"] = Value::Null;
        alone["command"] = Value::Null;
        assert!(own == alone, "{input}");
    }
    let written: Vec<String> = results(&at.join("out"))
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    assert_eq!(
        written,
        ["all.json", "folder.json", "unit-1.json", "unit-2.json"]
    );
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let folder = fleet(6);
    let at = folder.path();
    fs::copy(at.join("fleet/unit-3.csv"), at.join("fleet/unit-0.csv")).unwrap();
    write(at, "fleet/unit-2b.csv", "");
    let run = |threads: u32| {
        let line = format!(
            "calibrate --each fleet -o out-{threads} --summary all-{threads}.csv --threads {threads} --json"
        );
        let (out, err) = ends_with(at, &line, 4);
        assert!(
            err.contains("1 session with the content of an earlier one"),
            "{err}"
        );
        let same = |text: String| text.replace(&format!("out-{threads}"), "out");
        let mut files = results(&at.join(format!("out-{threads}")));
        for (_, bytes) in &mut files {
            *bytes = same(String::from_utf8(bytes.clone()).unwrap()).into_bytes();
        }
        let summary = same(fs::read_to_string(at.join(format!("all-{threads}.csv"))).unwrap());
        (same(out), summary, files)
    };
    let one = run(1);
    assert!(
        one.1.contains("unit-3,fleet/unit-3.csv,done,")
            && one.1.contains(",unit-0,out/unit-3.json,")
    );
    assert_eq!(one.2.len(), 7);
    assert!(run(2) == one && run(7) == one);
}

#[cfg(unix)]
fn signal(run: &std::process::Child, name: &str) {
    let kill = Command::new("kill")
        .args(["-s", name, &run.id().to_string()])
        .status()
        .unwrap();
    assert!(kill.success());
}

/// Starts a run, and sends it a signal once some of its results are there.
#[cfg(unix)]
fn interrupted(at: &Path, line: &str, out: &str, name: &str) -> std::process::Output {
    let mut command = gravical(at, line);
    let run = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while fs::read_dir(at.join(out)).map_or(0, Iterator::count) < 5 {
        assert!(
            begun.elapsed() < Duration::from_secs(120),
            "it does not begin"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
    signal(&run, name);
    run.wait_with_output().unwrap()
}

#[test]
#[cfg(unix)]
fn an_interrupted_run_ends_as_an_uninterrupted_one() {
    use std::os::unix::process::ExitStatusExt as _;
    let folder = fleet(3);
    let at = folder.path();
    for i in 0..150 {
        fs::copy(
            at.join("fleet/unit-2.csv"),
            at.join(format!("fleet/copy-{i}.csv")),
        )
        .unwrap();
    }
    write(at, "fleet/copy-0b.csv", "");
    let line =
        |out: &str| format!("calibrate --each fleet -o {out} --summary {out}.csv --threads 2");
    let (whole, _) = ends_with(at, &line("out"), 4);
    let whole = (
        whole,
        fs::read(at.join("out.csv")).unwrap(),
        results(&at.join("out")),
    );
    for name in ["KILL", "INT"] {
        fs::rename(at.join("out"), at.join("before")).unwrap();
        fs::remove_file(at.join("out.csv")).unwrap();
        let ended = interrupted(at, &line("out"), "out", name);
        let done = results(&at.join("out")).len();
        assert!(done < whole.2.len(), "{name}: it was not interrupted");
        if name == "KILL" {
            assert_eq!(ended.status.signal(), Some(9));
            assert!(!at.join("out.csv").exists());
        } else {
            let err = String::from_utf8(ended.stderr).unwrap();
            assert_eq!(ended.status.code(), Some(130), "{err}");
            assert!(err.contains("--resume"), "{err}");
            // What is done is in the summary.
            let rows = fs::read_to_string(at.join("out.csv"))
                .unwrap()
                .lines()
                .count();
            assert!(rows > 1 && rows < whole.2.len(), "{rows}");
        }
        let refused = run_in(at, words(&format!("{} --json", line("out"))));
        assert_eq!((refused.code, refused.error_code().as_str()), (2, "exists"));
        let (out, err) = ends_with(at, &format!("{} --resume", line("out")), 4);
        assert!(err.contains("by an earlier run"), "{err}");
        assert!(out == whole.0, "{name}");
        assert!(fs::read(at.join("out.csv")).unwrap() == whole.1, "{name}");
        assert!(results(&at.join("out")) == whole.2, "{name}");
        fs::remove_dir_all(at.join("before")).unwrap();
    }
}

#[test]
fn resume_does_again_what_changed_and_nothing_else() {
    let folder = fleet(4);
    let at = folder.path();
    let run = |options: &str, code: i32| {
        ends_with(
            at,
            &format!("calibrate --each fleet -o out --resume {options}"),
            code,
        )
    };
    let stamp = |name: &str| fs::metadata(at.join(name)).unwrap().modified().unwrap();
    let names = [
        "out/unit-1.json",
        "out/unit-2.json",
        "out/unit-3.json",
        "out/unit-4.json",
    ];
    run("", 0);
    let first = names.map(stamp);
    // Another content, a result that is gone, and one that somebody changed.
    fs::copy(at.join("fleet/unit-3.csv"), at.join("fleet/unit-1.csv")).unwrap();
    fs::remove_file(at.join(names[1])).unwrap();
    let (_, err) = run("", 0);
    assert!(err.contains("2 of them by an earlier run"), "{err}");
    let second = names.map(stamp);
    assert!(first[0] != second[0] && first[1] != second[1] && first[2..] == second[2..]);
    // Other options: all again, but not over what somebody else wrote.
    fs::write(at.join(names[3]), "mine").unwrap();
    let (out, err) = run("--gravity 9.81", 4);
    assert!(
        !err.contains("earlier run") && err.contains("1 error (exists)"),
        "{err}"
    );
    assert!(out.lines().last().unwrap().contains("exists"), "{out}");
    assert_eq!(fs::read(at.join(names[3])).unwrap(), b"mine");
    let (_, err) = run("--gravity 9.81 --force", 0);
    assert!(err.contains("3 of them by an earlier run"), "{err}");
    // A session that fails keeps its result, says so, and gets it back.
    let content = fs::read(at.join("fleet/unit-2.csv")).unwrap();
    fs::write(at.join("fleet/unit-2.csv"), "").unwrap();
    let (out, _) = run("--gravity 9.81", 4);
    assert!(
        out.contains("out/unit-2.json is still that of an earlier run"),
        "{out}"
    );
    fs::write(at.join("fleet/unit-2.csv"), content).unwrap();
    run("--gravity 9.81", 0);
    // --force alone begins anew.
    let (_, err) = ends_with(at, "calibrate --each fleet -o out --force", 0);
    assert!(!err.contains("earlier run"), "{err}");
}

#[test]
fn what_makes_no_sense_is_said_before_the_work() {
    let folder = fleet(1);
    let at = folder.path();
    ends_with(at, "calibrate fleet/unit-1.csv -o cal.json", 0);
    write(at, "mine.csv", "mine");
    for (line, code) in [
        ("calibrate fleet/unit-1.csv --summary s.csv", "each-option"),
        ("check cal.json fleet/unit-1.csv --resume", "each-option"),
        ("apply cal.json fleet/unit-1.csv --threads 2", "each-option"),
        (
            "calibrate --each fleet --gyro fleet/unit-1.csv",
            "each-option",
        ),
        ("calibrate --each fleet --report r.html", "each-option"),
        ("calibrate --each fleet --figures f", "each-option"),
        ("calibrate --each fleet --resume", "each-option"),
        ("calibrate --each fleet -o -", "each-option"),
        ("apply cal.json fleet/unit-1.csv mine.csv", "each-option"),
        ("calibrate --each -", "each-input"),
        ("calibrate --each fleet --summary s.txt", "summary-target"),
        ("calibrate --each fleet --summary mine.csv", "exists"),
        (
            "calibrate --each fleet --summary nowhere/s.csv",
            "no-folder",
        ),
        ("calibrate --each fleet -o mine.csv", "no-folder"),
        ("calibrate --each fleet --pose-tilt 50", "option-range"),
        ("apply cal.json --each fleet -o fleet", "target-is-input"),
        (
            "check cal.json --each mine.csv --summary cal.json --force",
            "target-is-input",
        ),
        (
            "check cal.json --each . --summary fleet/unit-1.csv --force",
            "target-is-input",
        ),
        ("calibrate --each fleet --threads 0", "usage"),
        ("calibrate --each fleet --shard 3/2", "usage"),
        ("calibrate fleet/unit-1.csv --shard 1/2", "each-option"),
        ("noise fleet/unit-1.csv mine.csv", "one-recording"),
    ] {
        let run = run_in(at, words(&format!("{line} --json")));
        assert_eq!((run.code, run.error_code().as_str()), (2, code), "{line}");
        assert!(!at.join("s.csv").exists(), "{line}");
    }
    assert_eq!(fs::read(at.join("mine.csv")).unwrap(), b"mine");
    let run = run_in(at, words("calibrate --each @nowhere --json"));
    assert_eq!((run.code, run.error_code().as_str()), (3, "not-found"));
    // Without results and summary there are lines alone, and no journal.
    let before = fs::read_dir(at).unwrap().count();
    let (out, _) = ends_with(at, "calibrate --each fleet", 0);
    assert_eq!(
        (out.lines().count(), fs::read_dir(at).unwrap().count()),
        (1, before)
    );
}

#[test]
fn a_production_line_is_told_what_does_not_fit() {
    let folder = fleet(2);
    let at = folder.path();
    ends_with(
        at,
        "calibrate fleet/unit-1.csv -o cal.json --gravity 9.80665",
        0,
    );
    // The sensor of the calibration once more, and another one.
    let again = "simulate poses -o again --free 4 --hold 3 --rate 25 --seed 1 -q";
    assert_eq!(run_in(at, words(again)).code, 0);
    write(
        at,
        "list",
        "# today\nagain/poses.csv\nfleet/unit-2.csv\nnone.csv\n",
    );
    let line = "check cal.json --each @list --summary all.json";
    let (out, _) = ends_with(at, line, 4);
    let first: Vec<&str> = out.lines().map(|l| l[..14].trim_end()).collect();
    assert_eq!(first, ["fits", "does not fit", "error"], "{out}");
    let rows = rows(&at.join("all.json"));
    let status: Vec<&str> = rows.iter().map(|r| r["status"].as_str().unwrap()).collect();
    assert_eq!(status, ["done", "poor", "error"]);
    assert!(
        rows[1]["p_value"].as_f64().unwrap() < 0.01 && rows[0]["p_value"].as_f64().unwrap() > 0.01
    );
    let (out, err) = ends_with(at, "check cal.json --each @list --quiet", 4);
    assert_eq!((out.lines().count(), err.as_str()), (2, ""));
    let (_, err) = ends_with(at, &format!("{line} --resume"), 4);
    // An error is tried again.
    assert!(err.contains("2 of them by an earlier run"), "{err}");
    ends_with(at, "check cal.json --each again", 0);
}

#[test]
fn apply_writes_each_recording_under_its_name() {
    let folder = fleet(2);
    let at = folder.path();
    ends_with(at, "calibrate fleet/unit-1.csv -o cal.json", 0);
    let plain = fs::read(at.join("fleet/unit-2.csv")).unwrap();
    let file = fs::File::create(at.join("fleet/packed.csv.gz")).unwrap();
    let mut packed = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
    std::io::Write::write_all(&mut packed, &plain).unwrap();
    packed.finish().unwrap();
    write(at, "fleet/empty.txt", "");
    fs::create_dir(at.join("fleet/inside")).unwrap();
    let (out, err) = ends_with(at, "apply cal.json --each fleet -o out --output-unit g", 4);
    assert_eq!(out.lines().count(), 4);
    assert!(err.contains("folders inside are not read: inside"), "{err}");
    let written = results(&at.join("out"));
    let names: Vec<&str> = written.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["packed.csv", "unit-1.csv", "unit-2.csv"]);
    assert!(written[0].1 == written[2].1);
    for (name, bytes) in &written[1..] {
        ends_with(
            at,
            &format!("apply cal.json fleet/{name} -o alone.csv --force --output-unit g"),
            0,
        );
        assert!(&fs::read(at.join("alone.csv")).unwrap() == bytes, "{name}");
    }
    assert!(written[1].1.starts_with(b"Timestamp (ms),ax_calibrated_g,"));
    // As named, without --each: a folder is no recording.
    let (out, _) = ends_with(at, "apply cal.json fleet/unit-1.csv fleet -o named", 4);
    assert!(out.contains("is-a-directory"), "{out}");
}
