//! `gravical compare` and `gravical check`: what they print and how they end.

use std::path::Path;

use serde_json::Value;

use crate::support::*;

/// A session of six faces and, later, of the same sensor, twelve poses.
fn sensor(folder: &Path) {
    for line in [
        "simulate six-position -o first --seed 5 --tilt 0.1 --temperature-drift 0 --quiet",
        "simulate poses -o later --seed 5 --tilt 0.1 --temperature-drift 0 --hold 10 --quiet",
        "calibrate first -o first.json --gravity 9.80665 --pose-tilt 0.1 --quiet",
        "calibrate later/poses.csv -o later.json --gravity 9.80665 --pose-tilt 0.1 --quiet",
    ] {
        let run = run_in(folder, words(line));
        assert_eq!(run.code, 0, "{line}\n{}{}", run.out, run.err);
    }
}

/// Moves one bias of `first.json` by `sigmas` of its standard deviation.
fn alter(folder: &Path, sigmas: f64) {
    let text = std::fs::read_to_string(folder.join("first.json")).unwrap();
    let mut file: Value = serde_json::from_str(&text).unwrap();
    let a = &mut file["accelerometer"];
    let variance = a["covariance"]["values"][10][10].as_f64().unwrap();
    let bias = a["bias"][1].as_f64().unwrap();
    a["bias"][1] = (bias + sigmas * variance.sqrt()).into();
    write(folder, "altered.json", &file.to_string());
}

fn json(folder: &Path, line: &str, code: i32) -> Value {
    let run = run_in(folder, words(&format!("{line} --json")));
    assert_eq!(run.code, code, "{line}\n{}{}", run.out, run.err);
    run.json()
}

pub fn narrow(text: &str) {
    for line in text.lines() {
        assert!(line.chars().count() <= 80, "{line}");
        assert_eq!(line, line.trim_end(), "{line:?}");
    }
}

#[test]
fn a_good_calibration_fits_and_an_altered_one_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    sensor(path);
    let good = json(path, "check first.json later/poses.csv", 0);
    assert_eq!(good["verdict"]["judgement"], "fits");
    assert_eq!(good["static_intervals"].as_array().unwrap().len(), 12);
    assert!(good["untested_axes"].as_array().unwrap().is_empty());

    // Six faces leave nothing to tell the model error: 2 mm/s², twice the deviation of
    // the bias, are reckoned with.
    alter(path, 12.0);
    let run = run_in(
        path,
        words("check altered.json later/poses.csv --latitude 45"),
    );
    assert_eq!(run.code, 4);
    narrow(&run.out);
    for text in [
        "Verdict: does not fit",
        "changed bias of y explains it",
        "from latitude",
    ] {
        assert!(run.out.contains(text), "{}", run.out);
    }
    assert!(
        run.out.ends_with("\nNext: Calibrate again\n"),
        "{}",
        run.out
    );
}

#[test]
fn two_sessions_agree_and_an_altered_one_differs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    sensor(path);
    let agree = json(path, "compare first.json later.json", 0);
    assert_eq!(agree["verdict"]["judgement"], "agree");
    assert_eq!(agree["parameters"].as_array().unwrap().len(), 12);
    alter(path, 10.0);
    let run = run_in(path, words("compare altered.json later.json"));
    assert_eq!(run.code, 4);
    narrow(&run.out);
    assert!(run.out.contains("Verdict: differ"), "{}", run.out);
}

/// A recording is known by its checksum.
#[test]
fn a_recording_of_the_calibration_does_not_count_beside_a_new_one() {
    let folder = six_files(&Sensor::default());
    let path = folder.path();
    let line = "calibrate . --gravity 9.81 --method ferraris -o cal.json --quiet";
    assert_eq!(run_in(path, words(line)).code, 0);
    let file = Sensor::default().file([0.0, 0.0, 1.0], 300, 7);
    std::fs::create_dir(path.join("new")).unwrap();
    write(&path.join("new"), "z.csv", &file);
    let both = json(path, "check cal.json z_axis_pos.csv new/z.csv", 0);
    finding(&both, "same-recordings");
    assert_eq!(both["verdict"]["judgement"], "fits");
    let counts = both["static_intervals"].as_array().unwrap().iter();
    let counts: Vec<bool> = counts.map(|s| s["counts"].as_bool().unwrap()).collect();
    assert_eq!(counts, [false, true]);
    for (line, code) in [
        ("check cal.json", 2),
        ("compare cal.json", 2),
        ("check cal.json new/z.csv --gravity 20", 2),
        ("check cal.json missing.csv", 3),
        ("compare cal.json missing.json", 3),
    ] {
        assert_eq!(run_in(path, words(line)).code, code, "{line}");
    }
}

/// Three sensors of one type, 22 or 23 poses each: they differ from each other,
/// and each one's later poses fit its earlier ones.
#[test]
fn mikoff_sensors_differ_and_the_later_half_fits_the_earlier() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for sensor in 0..3 {
        let name = format!("mikoff-mpu9150/imu{sensor}.log");
        let text = std::fs::read_to_string(data.join(name)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let cut = lines.len() * 2 / 3;
        write(
            path,
            &format!("early{sensor}.log"),
            &lines[..cut].join("\n"),
        );
        write(path, &format!("late{sensor}.log"), &lines[cut..].join("\n"));
        let columns = "--columns ax,ay,az,gx,gy,gz --rate 100";
        let line = format!("calibrate early{sensor}.log {columns} -o {sensor}.json --quiet");
        assert_eq!(run_in(path, words(&line)).code, 0);
        let report = json(
            path,
            &format!("check {sensor}.json late{sensor}.log {columns}"),
            0,
        );
        assert_eq!(
            report["verdict"]["judgement"], "fits",
            "{}",
            report["verdict"]
        );
        println!("imu{sensor}: {}", report["verdict"]["reasons"][0]);
    }
    for (a, b) in [(0, 1), (1, 2), (0, 2)] {
        let result = json(path, &format!("compare {a}.json {b}.json"), 4);
        assert_eq!(result["magnitude"]["judgement"], "differ");
    }
}

/// imucal's file says nothing of its uncertainty.
#[test]
fn without_a_covariance_nothing_is_claimed() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    let imucal = data.join("imucal-ferraris/published_example_cal.json");
    let (imucal, session) = (
        imucal.display(),
        data.join("imucal-ferraris/annotated_session.csv"),
    );
    let line = format!(
        "check {imucal} {} --rate 204.8 --gravity 9.81",
        session.display()
    );
    let report = json(folder.path(), &line, 0);
    assert_eq!(report["verdict"]["judgement"], "undecided");
    assert!(report["rms_mps2"].as_f64().unwrap() < 0.01);
}
