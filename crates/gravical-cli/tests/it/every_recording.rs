//! Every file of the folder with real recordings goes through `inspect`: no
//! crash, every line accounted for, and findings that are true.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::support::*;

const ENDINGS: [&str; 6] = ["csv", "tsv", "log", "txt", "gz", "cwa"];

/// Every file under `folder` that may be a recording.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut out = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            out.extend(files(&path));
        } else if path
            .extension()
            .is_some_and(|e| ENDINGS.iter().any(|known| *known == e))
        {
            out.push(path);
        }
    }
    out.sort();
    out
}

#[test]
fn no_file_of_the_folder_crashes_and_every_account_balances() {
    let Some(data) = data() else { return };
    let all = files(&data);
    assert!(all.len() > 30, "{}", all.len());
    let mut read = 0;
    for path in &all {
        let run = run(["inspect".as_ref(), path.as_os_str(), "--json".as_ref()]);
        let name = path.display();
        assert!([0, 3].contains(&run.code), "{name}: {}", run.code);
        assert!(run.err.is_empty(), "{name}: {}", run.err);
        let value = run.json();
        let recordings = value["recordings"].as_array().unwrap();
        let errors = value["errors"].as_array().unwrap();
        assert_eq!(recordings.len() + errors.len(), 1, "{name}");
        assert_eq!(run.code == 0, errors.is_empty(), "{name}");
        for error in errors {
            assert!(error["hint"].is_string(), "{name}: {error}");
        }
        for recording in recordings {
            read += 1;
            let account = &recording["row_counts"];
            let aside: u64 = account["aside"]
                .as_array()
                .unwrap()
                .iter()
                .map(|a| a[1].as_u64().unwrap())
                .sum();
            let (lines, rows) = (
                account["lines"].as_u64().unwrap(),
                account["rows"].as_u64().unwrap(),
            );
            assert_eq!(lines, rows + aside, "{name}");
            assert!(rows > 0, "{name}");
            for still in recording["static_intervals"].as_array().unwrap() {
                assert!(still["end_row"].as_u64().unwrap() <= rows, "{name}");
            }
        }
        // The same as text, for people.
        let text = crate::support::run(["inspect".as_ref(), path.as_os_str()]);
        assert_eq!(text.code, run.code, "{name}");
        assert_eq!(text.out.is_empty(), run.code == 3, "{name}");
    }
    assert_eq!(read, 31, "recordings among {} files", all.len());
}

fn inspected(data: &Path, path: &str, more: &str) -> Value {
    let run = run_in(data, words(&format!("inspect {path} --json {more}")));
    assert_eq!(run.code, 0, "{}", run.out);
    run.json()["recordings"][0].clone()
}

fn stills(looked: &Value) -> usize {
    looked["static_intervals"].as_array().unwrap().len()
}

#[test]
fn handheld_rows_repeat() {
    let Some(data) = data() else { return };
    let looked = inspected(&data, "mjs513-handheld/acc_A.txt.gz", "");
    finding(&looked, "repeated-rows");
    finding(&looked, "columns-guessed");
    assert_eq!(looked["accelerometer"]["unit"], "counts");
    // The hand pauses three times.
    assert!(looked["static_share"].as_f64().unwrap() < 0.05);
}

#[test]
fn elevator_channels_arrive_one_by_one() {
    let Some(data) = data() else { return };
    let looked = inspected(&data, "pabrod-elevator/skyscrapper_up.csv", "");
    let reported = finding(&looked, "empty-cells")["message"].as_str().unwrap();
    assert!(reported.contains("when it arrives"), "{reported}");
    assert_eq!(looked["timing"]["unit"], "ms");
    assert_eq!(looked["accelerometer"]["unit"], "m/s^2");
}

#[test]
fn foot_walk_has_205_repeated_stamps() {
    let Some(data) = data() else { return };
    let looked = inspected(&data, "xio-gait/short_walk.csv", "");
    assert_eq!(finding(&looked, "duplicate-time")["count"], 205);
    assert_eq!(looked["accelerometer"]["unit"], "g");
    close(
        looked["timing"]["median_rate_hz"].as_f64().unwrap(),
        400.0,
        5.0,
    );
}

#[test]
fn two_feet_are_two_sensors() {
    let Some(data) = data() else { return };
    let path = "gaitmap-example/imu_sample.csv.gz";
    let looked = inspected(&data, path, "");
    finding(&looked, "several-sensors");
    let right = inspected(
        &data,
        path,
        "--columns ax=right_sensor.acc_x,ay=right_sensor.acc_y,az=right_sensor.acc_z",
    );
    assert_ne!(
        looked["static_intervals"][0]["mean"],
        right["static_intervals"][0]["mean"]
    );
}

#[test]
fn thermal_chamber_stamps_are_microseconds() {
    let Some(data) = data() else { return };
    let looked = inspected(&data, "tofupilot-thermal/part1_rows0-5249.tsv", "");
    assert_eq!(looked["timing"]["unit"], "us");
    finding(&looked, "time-unit-assumed");
    let span = numbers(&looked["temperature_c"]);
    assert!(span[0] < -17.0 && span[1] > 51.0, "{span:?}");
}

#[test]
fn xsens_counts_are_unsigned_and_38_poses_are_found() {
    let Some(data) = data() else { return };
    let looked = inspected(&data, "imu_tk-xsens/xsens_acc.txt.gz", "");
    finding(&looked, "unsigned-counts");
    assert_eq!(stills(&looked), 38);
    close(
        looked["timing"]["median_rate_hz"].as_f64().unwrap(),
        100.0,
        0.1,
    );
    let gyro = inspected(&data, "imu_tk-xsens/xsens_gyro.txt.gz", "");
    finding(&gyro, "not-an-accelerometer");
}

#[test]
fn mikoff_poses_are_found_in_all_three() {
    let Some(data) = data() else { return };
    for n in 0..3 {
        let looked = inspected(&data, &format!("mikoff-mpu9150/imu{n}.log"), "");
        // A twitch parts the third in two of them: one pose, and two intervals.
        assert!((21..=24).contains(&stills(&looked)), "{}", stills(&looked));
        assert_eq!(looked["accelerometer"]["unit"], "m/s^2");
        assert!(looked["gyroscope"].is_object());
    }
}

#[test]
fn broad_rests_between_the_bouts_are_found() {
    let Some(data) = data() else { return };
    let path = "broad-translation/14_undisturbed_slow_translation_with_breaks_B.csv.gz";
    let looked = inspected(&data, path, "");
    assert!((4..=6).contains(&stills(&looked)), "{}", stills(&looked));
    close(
        looked["timing"]["median_rate_hz"].as_f64().unwrap(),
        285.714,
        0.05,
    );
    let first = &looked["static_intervals"][0];
    assert!(first["start_s"].as_f64().unwrap() < 1.0);
    close(first["end_s"].as_f64().unwrap(), 42.0, 2.0);
}
