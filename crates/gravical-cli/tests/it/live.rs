//! Guided calibration in the terminal: a simulated sensor by typed commands, the folder of a
//! session, replay, resuming.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::support::{calibrate, ends, fails, number, program, read, run_in, words};

/// Commands of a whole session; the sensor lies on +z at its start.
const WHOLE: [&str; 16] = [
    "+x", "-x", "+y", "-y", "-z", "free", "free", "free", "free", "free", "free", "free", "free",
    "free", "free", "stop",
];

/// No wait is longer.
const PATIENCE: Duration = Duration::from_secs(120);

fn start(folder: &Path, line: &str) -> Child {
    Command::new(program())
        .args(words(line))
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn type_in(child: &mut Child, commands: &[&str]) {
    let input = child.stdin.as_mut().unwrap();
    for command in commands {
        writeln!(input, "{command}").unwrap();
    }
}

/// Exit code, standard output and standard error.
fn end(child: Child) -> (i32, String, String) {
    let output = child.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let (out, err) = (text(output.stdout), text(output.stderr));
    assert!(!err.contains("panicked"), "{err}");
    (output.status.code().expect("ended by a signal"), out, err)
}

fn events(text: &str) -> Vec<Value> {
    text.lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect()
}

fn of_type<'a>(events: &'a [Value], kind: &str) -> Vec<&'a Value> {
    events.iter().filter(|e| e["type"] == kind).collect()
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// Waits for poses in the journal of `s`.
fn wait_for_poses(folder: &Path, count: usize) -> usize {
    let began = Instant::now();
    loop {
        let text = fs::read_to_string(folder.join("s/session.ndjson")).unwrap_or_default();
        let lines = text.lines();
        let accepted = lines.filter(|l| l.contains("pose_accepted") && l.ends_with('}'));
        let accepted = accepted.count();
        if accepted >= count {
            return accepted;
        }
        assert!(began.elapsed() < PATIENCE, "no pose was accepted");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// A finished session of a simulated sensor in the folder `s`; returns its events.
fn simulated(folder: &Path, seed: u32) -> Vec<Value> {
    let line = format!("live --simulate --seed {seed} --speed 0 --folder s --events -");
    let mut child = start(folder, &line);
    type_in(&mut child, &WHOLE);
    let (code, out, err) = end(child);
    assert_eq!(code, 0, "{err}");
    assert!(err.contains("Saved to s/calibration.json"), "{err}");
    events(&out)
}

#[test]
fn a_simulated_session_ends_with_the_truth_and_its_folder_calibrates_to_the_last_digit() {
    let folder = tempfile::tempdir().unwrap();
    let events = simulated(folder.path(), 4);
    let kinds: Vec<&str> = events.iter().map(|e| e["type"].as_str().unwrap()).collect();
    assert_eq!((kinds[0], kinds[kinds.len() - 1]), ("session", "end"));
    assert!(events.iter().all(|e| e["v"] == 1 && e["t_s"].is_number()));
    let verdicts = of_type(&events, "verdict");
    let last = verdicts.last().unwrap();
    assert_eq!(
        (&last["final"], &last["grade"]),
        (&Value::Bool(true), &"good".into())
    );
    let truth = of_type(&events, "truth")[0];
    assert!(truth["norm_error_mg"].as_f64().unwrap() < 2.0, "{truth}");
    assert!(truth["before_mg"].as_f64().unwrap() > 5.0, "{truth}");

    let saved = json(&folder.path().join("s/calibration.json"));
    let again = calibrate(folder.path(), "s", 0);
    for part in [
        "accelerometer",
        "gyroscope",
        "verdict",
        "gravity_mps2",
        "temperature_c",
        "findings",
    ] {
        assert_eq!(saved[part], again[part], "{part}");
    }
    assert_eq!(saved["gyroscope"]["method"], "motion");
    // What the session showed is what was saved.
    let fit = of_type(&events, "fit").pop().unwrap();
    let worst = number(&saved["accelerometer"]["worst_direction"]["error_mps2"]);
    let shown = number(&fit["worst_mg"]);
    let off = (shown - worst * 1000.0 / 9.80665).abs();
    assert!(off < 1e-9 * shown, "{shown} {worst}");

    // A changed recording is no longer that of the journal.
    let text = read(folder.path(), "s/recording.csv");
    let mut lines: Vec<&str> = text.lines().collect();
    lines.remove(200);
    fs::write(
        folder.path().join("s/recording.csv"),
        lines.join("\n") + "\n",
    )
    .unwrap();
    fails(folder.path(), "calibrate s", 3, "recording-changed");
    let resume = || run_in(folder.path(), words("live --resume s --plain"));
    assert!(resume().err.contains("code: recording-changed"));
    let journal = read(folder.path(), "s/session.ndjson");
    let journal = journal.replace("\"lines\":[", "\"lines\":[9");
    fs::write(folder.path().join("s/session.ndjson"), journal).unwrap();
    assert!(resume().err.contains("code: recording-changed"));
}

#[test]
fn a_replay_gives_the_events_of_the_session() {
    let folder = tempfile::tempdir().unwrap();
    let lived = simulated(folder.path(), 5);
    let gz = folder.path().join("r.csv.gz");
    let mut packer =
        flate2::write::GzEncoder::new(fs::File::create(&gz).unwrap(), flate2::Compression::fast());
    packer
        .write_all(&fs::read(folder.path().join("s/recording.csv")).unwrap())
        .unwrap();
    packer.finish().unwrap();
    let line = "live --replay r.csv.gz --gravity 9.80665 --events - -o cal.json";
    let replayed = events(&ends(folder.path(), line, 0).out);
    // Without the commands: poses and rejections are the same, field by field.
    let same = |all: &[Value]| -> Vec<Value> {
        let kinds = ["identified", "pose_accepted", "pose_rejected"];
        all.iter()
            .filter(|e| kinds.contains(&e["type"].as_str().unwrap()))
            .cloned()
            .collect()
    };
    assert_eq!(same(&lived), same(&replayed));
    let (a, b) = (
        json(&folder.path().join("cal.json")),
        json(&folder.path().join("s/calibration.json")),
    );
    assert_eq!(a["accelerometer"]["bias"], b["accelerometer"]["bias"]);
    assert!(!folder.path().join("session.ndjson").exists());
}

#[test]
fn a_killed_session_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = start(
        folder.path(),
        "live --simulate --seed 6 --speed 20 --folder s --gravity 9.80665",
    );
    type_in(&mut child, &WHOLE[1..5]);
    wait_for_poses(folder.path(), 3);
    child.kill().unwrap();
    child.wait().unwrap();
    let before = wait_for_poses(folder.path(), 3);
    // What a crash may leave: half a line in both files.
    for (name, half) in [
        ("session.ndjson", "{\"v\":1,\"t_s\":3"),
        ("recording.csv", "12345,0.1"),
    ] {
        let mut file = fs::OpenOptions::new()
            .append(true)
            .open(folder.path().join("s").join(name))
            .unwrap();
        file.write_all(half.as_bytes()).unwrap();
    }
    // The hand lays it on every face again; those that are done are refused.
    let mut child = start(folder.path(), "live --resume s --speed 0 --events -");
    type_in(&mut child, &WHOLE);
    let (code, out, err) = end(child);
    assert_eq!(code, 0, "{err}");
    let all = events(&out);
    events(&read(folder.path(), "s/session.ndjson"));
    let resumed = of_type(&all, "resumed")[0];
    assert_eq!(resumed["poses"], before as u64, "{err}");
    let poses = of_type(&all, "pose_accepted");
    let numbers: Vec<u64> = poses.iter().map(|p| p["pose"].as_u64().unwrap()).collect();
    let mut unique = numbers.clone();
    unique.dedup();
    assert_eq!(numbers, unique);
    let saved = json(&folder.path().join("s/calibration.json"));
    let again = calibrate(folder.path(), "s", 0);
    assert_eq!(saved["accelerometer"], again["accelerometer"]);
    assert_eq!(
        saved["accelerometer"]["poses"].as_array().unwrap().len(),
        poses.len()
    );
}

#[test]
fn what_a_session_cannot_use_or_write_is_refused_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("r.csv"), "ax,ay,az\n0.1,0.2,9.8\n").unwrap();
    fs::write(path.join("cal.json"), "mine").unwrap();
    let absent = "live --plain --folder s --port none/ttyNone";
    let other = "try: name another file\n";
    for (line, code, what) in [
        ("live --simulate --rate 200", 2, "--rate"),
        ("live --replay r.csv --baud 9600", 2, "--baud"),
        ("live --speed 2 --plain", 2, "--speed is for a replay"),
        ("live --replay r.csv -o none/cal.json", 2, "no-folder"),
        ("live --replay r.csv -o cal.json", 2, other),
        (absent, 5, "ttyNone"),
    ] {
        let run = ends(path, line, code);
        assert!(run.err.contains(what), "{line}: {}", run.err);
    }
}

/// It has the rate that is given, and one pose is no calibration.
#[test]
fn a_replay_without_stamps_and_poses() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "ax,ay,az\n".to_owned();
    for i in 0..1200 {
        let noise = f64::from(i * 7919 % 61) * 1e-3;
        text += &format!("{noise:.3},0.1,{:.3}\n", 9.8 + noise);
    }
    fs::write(folder.path().join("r.csv"), text).unwrap();
    let line = "live --replay r.csv --rate 50 --plain --events e.jsonl";
    let err = ends(folder.path(), line, 3).err;
    assert!(err.contains("✓ +z") && err.contains("1 pose"), "{err}");
    assert!(!err.contains("no rate"), "{err}");
    let seen = events(&read(folder.path(), "e.jsonl"));
    assert_eq!(of_type(&seen, "status").last().unwrap()["rate_hz"], 50.0);
}

/// Nothing is calibrated, and nothing lost.
#[test]
fn a_session_is_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let line = "live --simulate --seed 4 --speed 20 --plain --folder s --events -";
    let mut child = start(folder.path(), line);
    type_in(&mut child, &["+x", "cancel"]);
    let _open = child.stdin.take();
    let (code, out, err) = end(child);
    assert_eq!(code, 130, "{err}");
    let all = events(&out);
    let last = all.last().unwrap();
    assert_eq!(last["reason"], "cancelled");
    let text = last["text"].as_str().unwrap();
    assert!(text.ends_with("recorded is in s."), "{text}");
    assert_eq!(last["resume"], "gravical live --resume s");
    assert!(folder.path().join("s/recording.csv").exists());
    assert!(!folder.path().join("s/calibration.json").exists());
    assert!(
        err.contains("Go on with: gravical live --resume s"),
        "{err}"
    );
    // Nothing is overwritten.
    let again = ends(folder.path(), "live --simulate --folder s", 2).err;
    assert!(again.contains("--resume s"), "{again}");
}

/// A session whose events are wanted, and cannot be written, does not go on in silence.
#[test]
#[cfg(target_os = "linux")]
fn events_that_cannot_be_written_end_the_session() {
    let folder = tempfile::tempdir().unwrap();
    for target in ["/dev/full", ".", "-"] {
        let line = format!("live --simulate --seed 4 --plain --folder s --events {target}");
        let mut child = start(folder.path(), &line);
        // Nobody reads; the end of its input would end the session.
        drop(child.stdout.take());
        let _open = child.stdin.take();
        let (code, _, err) = end(child);
        assert!(
            code != 0 && err.contains("error: "),
            "{target}: {code} {err}"
        );
        let _ = fs::remove_dir_all(folder.path().join("s"));
    }
}
