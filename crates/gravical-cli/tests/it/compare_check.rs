//! `gravical compare` and `gravical check`: what they print and how they end.

use std::path::Path;

use serde_json::Value;

use crate::support::*;

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
