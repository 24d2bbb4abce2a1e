//! `--store` and `gravical store`: what is filed, what is taken, what is said.

use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::compare_check::narrow;
use crate::support::*;

/// Runs a line that has to succeed.
fn does(folder: &Path, line: &str) -> Run {
    let run = run_in(folder, words(line));
    assert_eq!(run.code, 0, "{line}\n{}{}", run.out, run.err);
    run
}

/// Three sessions of one sensor in `cals`, and a move of it in `line/line.csv`.
fn sensor() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (seconds, day) in [(3, "2026-01-09"), (4, "2026-03-09"), (5, "2026-06-09")] {
        does(
            path,
            &format!(
                "simulate poses -o {day} --seed 3 --free 8 --hold {seconds} --temperature-drift 0 --quiet"
            ),
        );
        does(
            path,
            &format!(
                "calibrate {day}/poses.csv --gravity 9.80665 --sensor-id left --recorded {day} --store cals --quiet"
            ),
        );
    }
    does(
        path,
        "simulate line -o line --seed 3 --temperature-drift 0 --quiet",
    );
    folder
}

#[test]
fn what_is_filed_is_taken_and_recorded() {
    let folder = sensor();
    let path = folder.path();
    let list = does(path, "store list --store cals --json").json();
    assert_eq!(list["sensors"][0]["sensor_id"], "left");
    assert_eq!(list["sensors"][0]["calibrations"], 3);
    assert_eq!(list["sensors"][0]["last"], "2026-06-09T00:00:00Z");
    let of_march = |value: &Value| {
        let choice = &value["store"];
        assert_eq!(choice["time"], "2026-03-09T00:00:00Z", "{choice}");
        assert_eq!(choice["age_days"], 22.0);
        assert_eq!(
            choice["rejected"][0]["reasons"][0],
            "made 70.0 days after the recording"
        );
        choice["path"].as_str().unwrap().to_owned()
    };
    let with = "--store cals --sensor-id left --recorded 2026-03-31";
    let applied = does(path, &format!("apply line/line.csv {with} -o a.csv --json"));
    let file = of_march(&applied.json());
    assert!(
        file.starts_with("cals/left/2026-03-09T00-00-00Z-"),
        "{file}"
    );
    // The same as with the file itself.
    does(path, &format!("apply {file} line/line.csv -o b.csv"));
    let read = |name: &str| std::fs::read(path.join(name)).unwrap();
    assert_eq!(read("a.csv"), read("b.csv"));
    let moved = does(
        path,
        &format!("motion line/line.csv {with} -o m.csv --json"),
    );
    assert_eq!(of_march(&moved.json()), file);
    assert_eq!(moved.json()["calibration"], file.as_str());
    let causal = does(
        path,
        &format!("motion line/line.csv {with} -o c.csv --causal --json"),
    );
    of_march(&causal.json());
    let checked = does(path, &format!("check line/line.csv {with} --json"));
    assert_eq!(
        checked.json()["calibration"],
        of_march(&checked.json()).as_str()
    );
    let session = does(path, &format!("check 2026-06-09 {with} --json"));
    of_march(&session.json());
    // In words, too.
    let text = does(
        path,
        &format!("check line/line.csv {with} --report check.html"),
    );
    narrow(&text.out);
    assert!(
        text.out.contains("made 22.0 days before the recording"),
        "{}",
        text.out
    );
    let page = std::fs::read_to_string(path.join("check.html")).unwrap();
    assert!(page.contains("made 22.0 days before the recording"));
    let text = does(path, &format!("apply line/line.csv {with} -o d.csv"));
    assert!(text.err.contains(&file), "{}", text.err);
    // Without --store nothing is added.
    let plain = does(path, &format!("apply {file} line/line.csv -o e.csv --json")).json();
    assert!(plain.get("store").is_none());
}

#[test]
fn the_same_session_is_filed_once() {
    let folder = sensor();
    let path = folder.path();
    let again = does(
        path,
        "calibrate 2026-01-09/poses.csv --gravity 9.80665 --sensor-id left --recorded 2026-01-09 --store cals -o cal.json",
    );
    assert!(again.err.contains("In the store already"), "{}", again.err);
    assert!(again.out.contains("Saved to cal.json"), "{}", again.out);
    let list = does(path, "store list --store cals --json").json();
    assert_eq!(list["sensors"][0]["calibrations"], 3);
    // An existing file is filed under another id.
    let run = does(
        path,
        "store add cal.json --store cals --sensor-id right --recorded 2026-02-01 --json",
    );
    assert_eq!(run.json()["added"][0]["existed"], false);
    let list = does(path, "store list --store cals");
    narrow(&list.out);
    assert!(
        list.out.contains("2 sensors, 4 calibrations"),
        "{}",
        list.out
    );
}

#[test]
fn a_recording_names_sensor_and_date() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::create_dir(path.join("session")).unwrap();
    let sensor = Sensor::default();
    // A logger that writes a serial number and seconds since 1970.
    let file = |up, rows, start: f64| {
        let mut text =
            "Serial Number: MOS2D12345678\nepoch (s),ax (m/s^2),ay (m/s^2),az (m/s^2)\n".to_owned();
        for (i, [x, y, z]) in sensor.hold(up, rows, start as u64).iter().enumerate() {
            text += &format!("{:.2},{x:.4},{y:.4},{z:.4}\n", start + 0.01 * i as f64);
        }
        text
    };
    for (i, (name, up)) in FACES.iter().enumerate() {
        let text = file(*up, 300, 1_767_225_600.0 + 10.0 * i as f64);
        write(&path.join("session"), &format!("{name}.csv"), &text);
    }
    let run = does(path, "calibrate session --gravity 9.81 --store cals --json");
    let calibration = run.calibration();
    assert_eq!(calibration["sensor"]["id"], "MOS2D12345678");
    assert_eq!(calibration["recorded"]["time"], "2026-01-01T00:00:00Z");
    assert_eq!(calibration["recorded"]["source"], "time-stamps");
    write(
        path,
        "later.csv",
        &file([0.0, 0.0, 1.0], 300, 1_768_089_600.0),
    );
    let checked = does(path, "check later.csv --store cals --json").json();
    assert_eq!(checked["store"]["age_days"], 10.0);
    assert_eq!(checked["store"]["recording_time_source"], "time-stamps");
    // A recording from before the calibration.
    write(
        path,
        "early.csv",
        &file([0.0, 0.0, 1.0], 300, 1_766_000_000.0),
    );
    let early = run_in(path, words("check early.csv --store cals"));
    assert_eq!(early.code, 3);
    assert!(early.err.contains("--nearest"), "{}", early.err);
    does(path, "check early.csv --store cals --nearest");
    let near = run_in(
        path,
        words("check early.csv --store cals --nearest --max-age 7"),
    );
    assert_eq!(near.code, 3);
    assert!(near.err.contains("the limit is 7 days"), "{}", near.err);
}

#[test]
fn wrong_calls_say_what_to_do() {
    let folder = sensor();
    let path = folder.path();
    let file = std::fs::read_dir(path.join("cals/left"))
        .unwrap()
        .next()
        .unwrap();
    let file = file.unwrap().path().display().to_string();
    let refused = |line: &str, code: &str, exit: i32, says: &str| {
        let run = run_in(path, words(&format!("{line} --json")));
        assert_eq!(run.code, exit, "{line}\n{}{}", run.out, run.err);
        let error = run.json();
        assert_eq!(error["code"], code, "{line}: {error}");
        let text = format!("{} {}", error["message"], error["hint"]);
        assert!(text.contains(says), "{line}: {text}");
    };
    let session = "calibrate 2026-01-09/poses.csv";
    refused(
        &format!("{session} --store new"),
        "sensor-id-missing",
        2,
        "--sensor-id NAME",
    );
    refused(
        &format!("{session} --store new --recorded monday"),
        "date-syntax",
        2,
        "2026-03-09",
    );
    assert!(!path.join("new").exists());
    let both = "--store cals --sensor-id left";
    refused(
        &format!("apply {file} line/line.csv {both} -o x.csv"),
        "store-and-file",
        2,
        "leave out --store",
    );
    refused(
        &format!("check {file} line/line.csv {both}"),
        "store-and-file",
        2,
        "leave out --store",
    );
    refused(
        &format!("motion line/line.csv -c {file} {both}"),
        "store-and-file",
        2,
        "leave out --store",
    );
    refused("apply line/line.csv -o x.csv", "usage", 2, "<INPUT>");
    refused("check line/line.csv", "usage", 2, "RECORDING");
    refused(
        "check line/line.csv --store cals",
        "sensor-id-missing",
        2,
        "it has",
    );
    refused(
        "check line/line.csv --store cals --sensor-id Left",
        "no-such-sensor",
        3,
        "left",
    );
    refused(
        "check line/line.csv --store no --sensor-id left",
        "no-store",
        3,
        "--store DIR",
    );
    refused(
        "check - --store cals --sensor-id left",
        "store-stdin",
        2,
        "as a file",
    );
    refused(
        "check line/line.csv --store cals --sensor-id left --max-age -1",
        "option-range",
        2,
        "--max-age",
    );
    refused(
        "check line/line.csv --store cals --sensor-id left --recorded 2026-01-19 --max-age 5",
        "no-calibration",
        3,
        "10.0 days before the recording, the limit is 5 days",
    );
    refused("motion line/line.csv --nearest", "usage", 2, "--store");
    refused(
        "store history right --store cals",
        "no-such-sensor",
        3,
        "left",
    );
    refused(
        "store add line/line.csv --store cals",
        "calibration-syntax",
        3,
        "",
    );
    refused(
        "store add line/truth.json --store cals",
        "calibration-format",
        3,
        "",
    );
}

#[test]
fn a_history_is_tested_and_drawn() {
    let folder = sensor();
    let path = folder.path();
    let run = run_in(
        path,
        words("store history left --store cals --report h.html --json"),
    );
    assert_eq!(run.code, 0, "{}", run.err);
    let same = run.json();
    assert_eq!(same["history"]["verdict"]["judgement"], "unchanged");
    assert_eq!(same["history"]["tested"], 3);
    let page = std::fs::read_to_string(path.join("h.html")).unwrap();
    assert_eq!(page.matches("<figure").count(), 2);
    assert!(page.contains("Bias over time") && page.contains("days since 2026-01-09"));
    // Another sensor filed under the same id.
    does(
        path,
        "simulate poses -o other --seed 8 --free 8 --temperature-drift 0 --quiet",
    );
    does(
        path,
        "calibrate other/poses.csv --gravity 9.80665 --sensor-id left --recorded 2026-09-01 --store cals --quiet",
    );
    let run = run_in(path, words("store history left --store cals --report h.md"));
    assert_eq!(run.code, 4, "{}{}", run.out, run.err);
    narrow(&run.out);
    assert!(run.out.contains("Verdict: changed"), "{}", run.out);
    assert!(
        run.out.contains("between 2026-06-09") || run.out.contains("2026-06-09 to 2026-09-01"),
        "{}",
        run.out
    );
    assert!(path.join("h_figures/bias-history.svg").is_file());
    let shown = does(path, "store show left --store cals --at 2026-07-01 --json").json();
    assert_eq!(shown["choice"]["time"], "2026-06-09T00:00:00Z");
    assert_eq!(shown["calibration"]["sensor"]["id"], "left");
    let shown = does(path, "store show left --store cals --at 2026-07-01");
    narrow(&shown.out);
    assert!(shown.out.contains("made 22.0 days before"), "{}", shown.out);
}

#[test]
fn many_processes_at_once_lose_nothing() {
    let folder = sensor();
    let path = folder.path();
    let file = std::fs::read_dir(path.join("cals/left"))
        .unwrap()
        .next()
        .unwrap();
    let text = std::fs::read_to_string(file.unwrap().path()).unwrap();
    const PROCESSES: usize = 12;
    let started: Vec<_> = (0..PROCESSES)
        .map(|i| {
            // Two of each: as if a command ran twice.
            let mut value: Value = serde_json::from_str(&text).unwrap();
            value["accelerometer"]["bias"][0] = (i / 2).into();
            let name = format!("{i}.json");
            write(path, &name, &value.to_string());
            Command::new(program())
                .args([
                    "store",
                    "add",
                    &name,
                    "--store",
                    "new/store",
                    "--sensor-id",
                    "CON",
                ])
                .current_dir(path)
                .stderr(Stdio::null())
                .spawn()
                .unwrap()
        })
        .collect();
    for mut process in started {
        assert!(process.wait().unwrap().success());
    }
    let list = does(path, "store list --store new/store --json").json();
    assert_eq!(list["sensors"][0]["calibrations"], PROCESSES / 2, "{list}");
    assert_eq!(list["sensors"][0]["sensor_id"], "CON");
    assert_eq!(list["left_out"].as_array().unwrap().len(), 0, "{list}");
}

#[test]
fn a_folder_of_imucal_is_a_store() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let own = path.join("cals/a45f/Ferraris");
    std::fs::create_dir_all(&own).unwrap();
    for day in ["2020-08-12_13-21", "2021-02-03_09-00"] {
        let name = own.join(format!("a45f_{day}.json"));
        std::fs::copy(
            data.join("imucal-ferraris/published_example_cal.json"),
            name,
        )
        .unwrap();
    }
    let recording = data.join("imucal-ferraris/annotated_session.csv");
    let mut line =
        words("apply --store cals --sensor-id a45f --recorded 2020-12-24 -o out.csv --json");
    line.push(recording.display().to_string());
    let run = run_in(path, &line);
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let choice = &run.json()["store"];
    assert_eq!(choice["time"], "2020-08-12T13:21:00Z");
    assert_eq!(choice["time_source"], "file-name");
    // Filed under an id, it has that and the given time.
    let mut line = words("store add --store cals --sensor-id b --json");
    line.push(own.join("a45f_2020-08-12_13-21.json").display().to_string());
    let undated = run_in(path, &line);
    assert_eq!(
        (undated.code, undated.error_code().as_str()),
        (2, "date-missing")
    );
    line.extend(words("--recorded 2022-01-01"));
    assert_eq!(run_in(path, &line).code, 0);
    let list = does(path, "store list --store cals --json").json();
    assert_eq!(list["sensors"][1]["sensor_id"], "b", "{list}");
    assert_eq!(list["left_out"].as_array().unwrap().len(), 0, "{list}");
    let history = does(path, "store history a45f --store cals --json").json();
    assert_eq!(history["history"]["verdict"]["judgement"], "undecided");
    assert_eq!(
        history["history"]["entries"][0]["not_tested"],
        "the file has no uncertainty"
    );
}
