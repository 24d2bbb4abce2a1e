//! `gravical denoise`: what is written, what is said, and what is refused.

mod stamps;

use crate::support::*;
use serde_json::Value;
use std::path::Path;

/// A rest of 600 rows with two more columns, one of them text.
fn rest(folder: &Path) -> Vec<String> {
    let mut lines = report_lines(
        "t_ms,ax,ay,az,Temp (C),gx (rad/s),gy (rad/s),gz (rad/s)",
        600,
    );
    for (i, line) in lines.iter_mut().enumerate() {
        line.push_str(if i == 0 { ",note" } else { ",\"a, b\"" });
    }
    write(folder, "rest.csv", &(lines.join("\n") + "\n"));
    lines
}

/// The summary of `denoise FILE -o out.csv --force …`.
fn summary(folder: &Path, line: &str) -> Value {
    let run = run_in(
        folder,
        words(&format!("denoise {line} -o out.csv --force --json --quiet")),
    );
    assert_eq!(run.code, 0, "{line}\n{}{}", run.out, run.err);
    assert!(run.err.is_empty(), "{}", run.err);
    run.json()
}

fn written(folder: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join("out.csv")).unwrap();
    text.lines()
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect()
}

#[test]
fn only_the_channels_change() {
    let folder = tempfile::tempdir().unwrap();
    let before = rest(folder.path());
    let reported = summary(
        folder.path(),
        "rest.csv --filter savgol:5,2 --channels accel",
    );
    let after = written(folder.path());
    assert_eq!(after.len(), before.len());
    assert_eq!(after[0].join(","), before[0]);
    assert_eq!(reported["columns"][1], "ax");
    let mut changed = 0;
    for (after, before) in after.iter().zip(&before).skip(1) {
        let before: Vec<&str> = before.split(',').collect();
        assert_eq!(after[0], before[0]);
        assert_eq!(after[4..], before[4..]);
        changed +=
            usize::from(after[1].parse::<f64>().unwrap() != before[1].parse::<f64>().unwrap());
    }
    assert!(changed > 500, "{changed}");
    assert!(reported["recorded"]["gyroscope"].is_null());

    // What it says of the noise is true of what was written.
    let gain = reported["filters"][0]["noise_gain"].as_f64().unwrap();
    close(gain, (17.0_f64 / 35.0).sqrt(), 1e-12);
    let sigma = |of: &Value| numbers(&of["accelerometer"]);
    let (recorded, filtered) = (
        sigma(&reported["recorded"]),
        sigma(&reported["filters"][0]["sigma"]),
    );
    for (recorded, filtered) in recorded.iter().zip(filtered) {
        close(filtered / recorded, gain, 0.06);
    }
}

#[test]
fn a_pipe_gives_what_a_file_gives() {
    let folder = tempfile::tempdir().unwrap();
    let lines = rest(folder.path());
    let line = "--filter butter:4,5Hz --filter mean:3";
    let file = run_in(folder.path(), words(&format!("denoise rest.csv {line}")));
    assert_eq!(file.code, 0, "{}", file.err);
    assert!(
        file.err.contains("600 rows filtered → stdout"),
        "{}",
        file.err
    );
    assert!(file.err.contains("does not reduce drift"), "{}", file.err);
    for row in file.err.lines() {
        assert!(row.chars().count() <= 80, "{row}");
    }
    let mut child = std::process::Command::new(program())
        .args(words(&format!("denoise - {line} --quiet")))
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    std::io::Write::write_all(
        &mut child.stdin.take().unwrap(),
        (lines.join("\n") + "\n").as_bytes(),
    )
    .unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert_eq!(String::from_utf8(output.stdout).unwrap(), file.out);
}

#[test]
fn derivatives_say_so_in_the_names() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "t_ms,ax,ay,az\n".to_owned();
    for i in 0..200 {
        let t = 0.01 * f64::from(i);
        text += &format!("{},{:.6},{:.6},9.81\n", 10 * i, 0.5 * t, t * t);
    }
    write(folder.path(), "ramp.csv", &text);
    let reported = summary(folder.path(), "ramp.csv --filter savgol:7,2,1");
    assert_eq!(
        reported["columns"],
        serde_json::json!(["t_ms", "ax_per_s", "ay_per_s", "az_per_s"])
    );
    for (i, row) in written(folder.path()).iter().skip(1).enumerate() {
        close(row[1].parse().unwrap(), 0.5, 2e-4);
        close(row[2].parse().unwrap(), 0.02 * i as f64, 2e-4);
        close(row[3].parse().unwrap(), 0.0, 2e-4);
    }
}

#[test]
fn wrong_calls() {
    let folder = tempfile::tempdir().unwrap();
    rest(folder.path());
    write(
        folder.path(),
        "untimed.csv",
        &"ax,ay,az\n0.1,0.2,9.8\n".repeat(30),
    );
    for (line, exit, code) in [
        ("rest.csv", 2, "no-filter"),
        ("rest.csv --filter butter:4,60Hz", 2, "filter-range"),
        ("rest.csv --filter butter:4,1e-9Hz", 2, "filter-range"),
        ("rest.csv --filter mean:3 -o rest.csv", 2, "target-is-input"),
        ("untimed.csv --filter butter:4,5Hz", 2, "rate-unknown"),
        ("untimed.csv --filter savgol:5,2,1", 2, "rate-unknown"),
        (
            "untimed.csv --filter mean:3 --channels gyro",
            3,
            "no-gyroscope",
        ),
        ("gone.csv --filter mean:3", 3, "not-found"),
        (". --filter mean:3", 3, "is-a-directory"),
    ] {
        let output = if line.contains("-o") {
            ""
        } else {
            "-o new.csv"
        };
        let run = run_in(
            folder.path(),
            words(&format!("denoise {line} {output} --json")),
        );
        assert_eq!(
            (run.code, run.error_code().as_str()),
            (exit, code),
            "{line}"
        );
        assert!(run.json()["hint"].is_string(), "{line}: {}", run.out);
        assert!(!folder.path().join("new.csv").exists(), "{line}");
    }
    let run = run_in(
        folder.path(),
        words("denoise rest.csv --filter mean:3 --json"),
    );
    assert_eq!(
        (run.code, run.error_code().as_str()),
        (2, "json-needs-output")
    );
    for (spec, code) in [
        ("kalman:1", "savgol:5,2"),
        ("savgol:5,7", "below the window"),
    ] {
        let run = run_in(folder.path(), ["denoise", "rest.csv", "--filter", spec]);
        assert_eq!(run.code, 2);
        assert!(
            run.err.contains(code) || run.err.contains("not a filter"),
            "{}",
            run.err
        );
    }
}

#[test]
fn counts_stay_counts() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    // Unsigned counts: what is subtracted on reading is there again when written.
    let path = data.join("imu_tk-xsens/xsens_acc.txt.gz");
    let reported = summary(
        folder.path(),
        &format!("{} --filter savgol:11,2", path.display()),
    );
    assert_eq!(reported["accel_unit"], "counts");
    let rows = std::fs::read_to_string(folder.path().join("out.csv")).unwrap();
    let first: Vec<f64> = rows
        .lines()
        .nth(1)
        .unwrap()
        .split('\t')
        .map(|v| v.parse().unwrap())
        .collect();
    close(first[1], 33108.0, 20.0);
    // A band-pass leaves nothing of it.
    summary(
        folder.path(),
        &format!("{} --filter butter:2,5-20Hz", path.display()),
    );
    let rows = std::fs::read_to_string(folder.path().join("out.csv")).unwrap();
    let first: Vec<f64> = rows
        .lines()
        .nth(100)
        .unwrap()
        .split('\t')
        .map(|v| v.parse().unwrap())
        .collect();
    close(first[1], 0.0, 20.0);
}

#[test]
fn every_real_recording_is_filtered_and_read_again() {
    let Some(data) = data() else { return };
    for (name, stretches) in [
        ("tomisuarez-mpu6050/calibration.csv", 1),
        ("mikoff-mpu9150/imu0.log", 1),
        ("xio-gait/short_walk.csv", 1),
        ("pabrod-elevator/skyscrapper_up.csv", 2),
        ("tofupilot-thermal/part1_rows0-5249.tsv", 1),
        ("airbrakes-sixmoves/zplus.csv", 1),
        ("openshoe-square2/square2_u.csv", 1),
        ("mjs513-handheld/acc_A.txt.gz", 1),
        ("gaitmap-example/imu_sample.csv.gz", 1),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = data.join(name);
        let untimed = ["mikoff", "tomisuarez", "openshoe", "mjs513", "gaitmap"];
        let rate = match untimed.iter().any(|part| name.contains(part)) {
            true => " --rate 100",
            false => "",
        };
        // The thermal chamber was recorded at 2 Hz.
        let cutoff = if name.contains("thermal") { 0.2 } else { 5.0 };
        let line = format!(
            "{}{rate} --filter hampel:7,5 --filter savgol:5,2 --filter butter:4,{cutoff}Hz",
            path.display()
        );
        let reported = summary(folder.path(), &line);
        assert_eq!(reported["segments"], stretches, "{name}");
        let filters = reported["filters"].as_array().unwrap();
        let last = &filters[2]["sigma"]["accelerometer"];
        if reported["static_intervals"].as_u64().unwrap() > 0 {
            let before = numbers(&reported["recorded"]["accelerometer"]);
            // Some rests are too short for 5 Hz.
            let after = if last.is_null() {
                vec![0.0; 3]
            } else {
                numbers(last)
            };
            assert!(
                before.iter().zip(&after).all(|(b, a)| a < b),
                "{name}: {before:?} {after:?}"
            );
        } else {
            finding(&reported, "never-static");
        }
        // It is a recording like the one it came from.
        let looked = run_in(folder.path(), words("inspect out.csv --json"));
        assert_eq!(looked.code, 0, "{name}: {}", looked.out);
        assert_eq!(
            looked.json()["recordings"][0]["row_counts"]["rows"],
            reported["rows"],
            "{name}"
        );
    }
}
