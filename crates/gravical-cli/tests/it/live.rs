//! Guided calibration in the terminal: a simulated sensor by typed commands, the folder of a
//! session, replay, resuming.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Child, ChildStdin};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::support::{self, Run, calibrate, ends, fails, list, number, read, run_in, words, write};

/// Commands of a whole session; the sensor lies on +z at its start.
const WHOLE: &str = "+x -x +y -y -z free free free free free free free free free free stop";

/// No wait is longer.
const PATIENCE: Duration = Duration::from_secs(120);

/// Runs `live …` and types these commands; its input stays open as long as it is held.
fn start(folder: &Path, line: &str, commands: &str) -> (Child, ChildStdin) {
    let mut child = support::start(folder, &format!("live {line}"));
    let mut input = child.stdin.take().unwrap();
    for command in words(commands) {
        writeln!(input, "{command}").unwrap();
    }
    (child, input)
}

/// Exit code, events on standard output, and standard error.
fn end(child: Child) -> (i32, Vec<Value>, String) {
    let run = Run::of(child.wait_with_output().unwrap());
    (run.code, events(&run.out), run.err)
}

fn events(text: &str) -> Vec<Value> {
    let lines = text.lines().map(serde_json::from_str::<Value>);
    lines.collect::<Result<_, _>>().unwrap()
}

fn of_type<'a>(events: &'a [Value], kind: &str) -> Vec<&'a Value> {
    events.iter().filter(|e| e["type"] == kind).collect()
}

fn json(folder: &Path, name: &str) -> Value {
    serde_json::from_str(&read(folder, name)).unwrap()
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

#[test]
fn a_simulated_session_ends_with_the_truth_and_its_folder_calibrates_to_the_last_digit() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let line = "--simulate --seed 4 --speed 0 --folder s --events -";
    let (child, _) = start(at, line, WHOLE);
    let (code, lived, err) = end(child);
    assert!(code == 0 && err.contains("Saved to s/calibration.json"));
    assert!(lived.iter().all(|e| e["v"] == 1 && e["t_s"].is_number()));
    let last = of_type(&lived, "verdict").pop().unwrap();
    assert!(last["final"] == true && last["grade"] == "good", "{last}");
    let truth = of_type(&lived, "truth")[0];
    let [before, after] = ["before_mg", "norm_error_mg"].map(|key| number(&truth[key]));
    assert!(before > 5.0 && after < 2.0, "{truth}");

    let saved = json(at, "s/calibration.json");
    let again = calibrate(at, "s", 0);
    for part in words("accelerometer gyroscope verdict temperature_c findings") {
        assert_eq!(saved[&part], again[&part], "{part}");
    }
    // What the session showed is what was saved.
    let fit = of_type(&lived, "fit").pop().unwrap();
    let worst = number(&saved["reliability"]["worst_direction"]["error_mps2"]);
    let shown = number(&fit["worst_mg"]);
    let off = (shown - worst * 1000.0 / 9.80665).abs();
    assert!(off < 1e-9 * shown, "{shown} {worst}");

    // A replay gives its poses, field by field.
    let text = read(at, "s/recording.csv");
    let gz = fs::File::create(at.join("r.csv.gz")).unwrap();
    let mut packer = flate2::write::GzEncoder::new(gz, flate2::Compression::fast());
    packer.write_all(text.as_bytes()).unwrap();
    packer.finish().unwrap();
    let line = "live --replay r.csv.gz --gravity 9.80665 --events - -o cal.json";
    let replayed = events(&ends(at, line, 0).out);
    for kind in ["identified", "pose_accepted", "pose_rejected"] {
        assert_eq!(of_type(&lived, kind), of_type(&replayed, kind));
    }
    let bias = &json(at, "cal.json")["accelerometer"]["bias"];
    assert_eq!(bias, &saved["accelerometer"]["bias"]);

    // A changed recording is no longer that of the journal.
    let mut lines: Vec<&str> = text.lines().collect();
    lines.remove(200);
    write(at, "s/recording.csv", &(lines.join("\n") + "\n"));
    fails(at, "calibrate s", 3, "recording-changed");
    let resume = || run_in(at, words("live --resume s --plain"));
    assert!(resume().err.contains("code: recording-changed"));
    let journal = read(at, "s/session.ndjson");
    let changed = journal.replace("\"lines\":[", "\"lines\":[9");
    write(at, "s/session.ndjson", &changed);
    assert!(resume().err.contains("code: recording-changed"));
}

#[test]
fn a_killed_session_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let line = "--simulate --seed 6 --speed 20 --folder s --gravity 9.80665";
    let (mut child, _input) = start(at, line, "-x +y -y -z");
    wait_for_poses(at, 3);
    child.kill().unwrap();
    child.wait().unwrap();
    let before = wait_for_poses(at, 3);
    // What a crash may leave: half a line in both files.
    for (name, half) in [
        ("s/session.ndjson", "{\"v\":1,\"t_s\":3"),
        ("s/recording.csv", "12345,0.1"),
    ] {
        write(at, name, &(read(at, name) + half));
    }
    // The hand lays it on every face again; those that are done are refused.
    let (child, _) = start(at, "--resume s --speed 0 --events -", WHOLE);
    let (code, all, err) = end(child);
    assert_eq!(code, 0, "{err}");
    events(&read(at, "s/session.ndjson"));
    assert_eq!(of_type(&all, "resumed")[0]["poses"], before as u64, "{err}");
    let poses = of_type(&all, "pose_accepted");
    let numbers: Vec<u64> = poses.iter().map(|p| p["pose"].as_u64().unwrap()).collect();
    let mut unique = numbers.clone();
    unique.dedup();
    assert_eq!(numbers, unique);
    let saved = json(at, "s/calibration.json");
    let again = calibrate(at, "s", 0);
    assert_eq!(saved["accelerometer"], again["accelerometer"]);
    let saved = list(&saved["poses"]);
    assert_eq!(saved.len(), poses.len());
}

#[test]
fn what_a_session_cannot_use_or_write_is_refused_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write(path, "r.csv", "ax,ay,az\n0.1,0.2,9.8\n");
    write(path, "cal.json", "mine");
    for (line, code, what) in [
        ("--simulate --rate 200", 2, "--rate"),
        ("--replay r.csv --baud 9600", 2, "--baud"),
        ("--speed 2 --plain", 2, "--speed is for a replay"),
        ("--replay r.csv -o none/cal.json", 2, "no-folder"),
        ("--replay r.csv -o cal.json", 2, "try: name another file\n"),
        ("--plain --folder s --port none/ttyNone", 5, "ttyNone"),
    ] {
        let run = ends(path, &format!("live {line}"), code);
        assert!(run.err.contains(what), "{line}: {}", run.err);
    }
    // A replay without stamps has the rate that is given, and one pose is no calibration.
    let mut text = "ax,ay,az\n".to_owned();
    for i in 0..1200 {
        let noise = f64::from(i * 7919 % 61) * 1e-3;
        text += &format!("{noise:.3},0.1,{:.3}\n", 9.8 + noise);
    }
    write(path, "r.csv", &text);
    let line = "live --replay r.csv --rate 50 --plain --events e.jsonl";
    let err = ends(path, line, 3).err;
    assert!(err.contains("✓ +z") && err.contains("1 pose"), "{err}");
    let seen = events(&read(path, "e.jsonl"));
    assert_eq!(of_type(&seen, "status").last().unwrap()["rate_hz"], 50.0);
}

/// Nothing is calibrated, and nothing lost.
#[test]
fn a_session_is_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let line = "--simulate --seed 4 --speed 20 --plain --folder s --events -";
    let (child, _open) = start(at, line, "+x cancel");
    let (code, all, err) = end(child);
    assert_eq!(code, 130, "{err}");
    let last = all.last().unwrap();
    assert_eq!(last["reason"], "cancelled");
    assert_eq!(last["resume"], "gravical live --resume s");
    assert!(at.join("s/recording.csv").exists() && !at.join("s/calibration.json").exists());
    assert!(err.contains("Go on with: gravical live --resume s"));
    // Nothing is overwritten.
    let again = ends(at, "live --simulate --folder s", 2).err;
    assert!(again.contains("--resume s"), "{again}");
}

/// A session whose events are wanted, and cannot be written, does not go on in silence.
#[test]
#[cfg(target_os = "linux")]
fn events_that_cannot_be_written_end_the_session() {
    let folder = tempfile::tempdir().unwrap();
    for target in ["/dev/full", ".", "-"] {
        let line = format!("--simulate --seed 4 --plain --folder s --events {target}");
        // The end of its input would end the session.
        let (mut child, _open) = start(folder.path(), &line, "");
        // Nobody reads.
        drop(child.stdout.take());
        let (code, _, err) = end(child);
        let said = code != 0 && err.contains("error: ");
        assert!(said, "{target}: {code} {err}");
        let _ = fs::remove_dir_all(folder.path().join("s"));
    }
}
