//! The gyroscope from motions between stills, on real recordings and from a
//! second file.

use std::path::{Path, PathBuf};

use gravical::calibrate::gyro::of_session;
use gravical::calibration_file::{CalibrationFile, GyroMethod};
use gravical::poses::{SegmentOptions, Segmentation, segment};
use gravical::recording::{ReadOptions, Recording, read};
use gravical_core::calibration::{Calibration, GyroscopeCalibration};
use serde_json::Value;

use crate::support::*;

fn xsens(folder: &Path) -> [PathBuf; 2] {
    ["xsens_acc.txt.gz", "xsens_gyro.txt.gz"].map(|n| folder.join("imu_tk-xsens").join(n))
}

/// Stills, and the accelerometer of a calibration for [`Recording::accel`].
fn prepared(recording: &Recording, file: &CalibrationFile) -> (Segmentation, Calibration<f64>) {
    let session = segment(std::slice::from_ref(recording), &SegmentOptions::default()).unwrap();
    let a = &file.accelerometer;
    let accelerometer = Calibration {
        matrix: a.matrix,
        bias: a.bias.map(|b| b - recording.zero_offset),
    };
    (session, accelerometer)
}

fn gyroscope_of(value: &Value) -> GyroscopeCalibration<f64> {
    serde_json::from_value::<gravical::calibration_file::GyroscopeSection>(value.clone())
        .map(|g| GyroscopeCalibration {
            matrix: g.matrix,
            bias: g.bias,
            g_sensitivity: g.g_sensitivity,
        })
        .unwrap()
}

#[test]
fn the_xsens_set_against_its_published_result() {
    let Some(folder) = data() else { return };
    let [acc, gyro] = xsens(&folder);
    let line = format!(
        "{} --gyro {} --gravity 9.81744",
        acc.display(),
        gyro.display()
    );
    let found = calibrate(Path::new("."), &line, 0);
    let section = &found["gyroscope"];
    assert_eq!(section["method"], "motion");
    assert_eq!(section["input_unit"], "counts");
    assert_eq!(found["inputs"].as_array().unwrap().len(), 2);
    assert_eq!(
        found["inputs"][1]["sha256"].as_str().unwrap().len(),
        64,
        "{}",
        found["inputs"]
    );
    let listed = GyroscopeCalibration {
        matrix: gravical_core::matrix3::diagonal([2.09294526e-4, 2.09898540e-4, 2.09482984e-4]),
        bias: [32777.13994, 32459.80288, 32511.84746],
        g_sensitivity: [[0.0; 3]; 3],
    };
    let own = gyroscope_of(section);
    for i in 0..3 {
        close(own.matrix[i][i] / listed.matrix[i][i], 1.0, 0.01);
        // The listed bias is that of the first still; ours is without the
        // part that gravity has in it.
        close(own.bias[i], listed.bias[i], 12.0);
    }

    let residual = section["residual_deg"].as_f64().unwrap();
    println!(
        "residual on {} motions: {residual:.3}°, leave-one-out {}",
        section["motions"], section["leave_one_out_deg"]
    );
    assert!(residual < 0.2, "{residual}");
}

#[test]
fn three_boards_turned_by_hand() {
    let Some(folder) = data() else { return };
    for name in ["imu0", "imu1", "imu2"] {
        let file = folder.join(format!("mikoff-mpu9150/{name}.log"));
        let run = run(words(&format!(
            "calibrate {} --rate 100 --json",
            file.display()
        )));
        let found = run.calibration();
        let g = &found["gyroscope"];
        println!(
            "{name}: residual {}°, left out {}°, {}; K {} b {}",
            g["residual_deg"], g["leave_one_out_deg"], g["motions"], g["scale"], g["bias"]
        );
        assert_eq!(g["method"], "motion", "{name}");
        assert!(g["residual_deg"].as_f64().unwrap() < 0.25, "{name}");
        assert!(g["leave_one_out_deg"].as_f64().unwrap() < 0.3, "{name}");
        // The data sheet allows 3 %.
        for k in numbers(&g["scale"]) {
            close(k, 1.0, 0.03);
        }
    }
}

#[test]
fn six_motions_that_were_not_too_fast_are_too_few() {
    let Some(folder) = data() else { return };
    let file = folder.join("tomisuarez-mpu6050/calibration.csv");
    let run = run(words(&format!("calibrate {} --json", file.display())));
    let found = run.calibration();
    let clipped = finding(&found, "gyro-motion-clipped");
    assert_eq!(clipped["count"], 18);
    finding(&found, "gyro-undetermined");
    let g = &found["gyroscope"];
    assert_eq!(g["method"], "bias");
    // The published result, within 0.08 °/s: this board's bias drifts.
    for (b, published) in numbers(&g["bias"]).iter().zip([-427.46, 147.95, -80.72]) {
        close(*b, published, 10.0);
    }
}

#[test]
fn imucals_session_by_motions_and_by_turns() {
    let Some(folder) = data() else { return };
    let folder = folder.join("imucal-ferraris");
    let session = folder.join("example_ferraris_session.csv");
    let list = folder.join("example_ferraris_session_list.json");
    let line = format!(
        "{} --sections {} --gravity 9.81 --rate 102.4",
        session.display(),
        list.display()
    );
    let turns = run(words(&format!("calibrate {line} --json"))).json();
    assert_eq!(turns["gyroscope"]["method"], "turns");
    let file: CalibrationFile = serde_json::from_value(turns.clone()).unwrap();
    let recording = read(
        &session,
        &ReadOptions {
            rate_hz: Some(102.4),
            ..ReadOptions::default()
        },
    )
    .unwrap();
    let (cut, accelerometer) = prepared(&recording, &file);
    let recordings = std::slice::from_ref(&recording);
    let fit = of_session(recordings, &cut, &accelerometer);
    let section = fit.section.unwrap();
    assert_eq!(section.method, GyroMethod::Motion, "{:?}", fit.findings);
    let by_turns = gyroscope_of(&turns["gyroscope"]);
    println!(
        "imucal: {:?}, K {:?}, {:?}°",
        section.motions, section.scale, section.residual_deg
    );
    // A turn by hand is 360° but for a degree or two.
    for i in 0..3 {
        let scale = turns["gyroscope"]["scale"][i].as_f64().unwrap();
        close(section.scale[i] / scale, 1.0, 0.02);
        close(section.bias[i], by_turns.bias[i], 0.02);
    }
}

#[test]
fn a_second_file_that_does_not_fit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write_six_files(here, &Sensor::default());
    write(here, "gyro.txt", "1 2 3\n2 3 4\n3 4 6\n");
    let code = |line: &str, exit: i32| {
        let run = run_in(here, words(&format!("{line} --json")));
        assert_eq!(run.code, exit, "{line}\n{}{}", run.out, run.err);
        run.error_code()
    };
    let two = "x_axis_pos.csv x_axis_neg.csv --gyro gyro.txt";
    assert_eq!(code(&format!("calibrate {two}"), 2), "gyro-inputs");
    assert_eq!(code(&format!("inspect {two}"), 2), "gyro-inputs");
    write(
        here,
        "both.txt",
        "ax,ay,az,gx,gy,gz\n0,0,9.8,1,2,3\n0,0,9.7,1,2,4\n0,1,9.8,1,2,3\n",
    );
    assert_eq!(code("calibrate both.txt --gyro gyro.txt", 2), "gyro-twice");
    write(
        here,
        "acc.txt",
        "ax,ay,az\n0,0,9.8\n0,0,9.7\n0,0.1,9.8\n0,0.1,9.8\n",
    );
    assert_eq!(code("calibrate acc.txt --gyro gyro.txt", 3), "gyro-length");
    assert_eq!(code("calibrate acc.txt --gyro nowhere.txt", 3), "not-found");
}

/// A simulated session in one file, and the same in two files without the other's columns.
fn divided(path: &Path) {
    for make in [
        "simulate poses -o sim --seed 5 --free 8 --quiet",
        "calibrate sim/poses.csv --gravity 9.80665 -o cal.json --quiet",
        "simulate line -o line --seed 5 --quiet",
    ] {
        assert_eq!(run_in(path, words(make)).code, 0, "{make}");
    }
    let text = std::fs::read_to_string(path.join("line/line.csv")).unwrap();
    let rows = text.lines().filter(|line| !line.starts_with('#'));
    let (mut accel, mut gyro) = (String::new(), String::new());
    for row in rows {
        let cells: Vec<&str> = row.split(',').collect();
        accel += &format!("{}\n", cells[..4].join(","));
        gyro += &format!("{},{}\n", cells[0], cells[5..].join(","));
    }
    write(path, "accel.csv", &accel);
    write(path, "gyro.csv", &gyro);
}

#[test]
fn apply_and_check_join_a_gyroscope() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    divided(path);
    let apply = |line: &str| {
        let run = run_in(path, words(&format!("apply cal.json {line} --quiet -o -")));
        assert_eq!(run.code, 0, "{}", run.err);
        let rows = run.out.lines().map(str::to_owned);
        rows.collect::<Vec<String>>()
    };
    let (whole, joined) = (apply("line/line.csv"), apply("accel.csv --gyro gyro.csv"));
    assert_eq!(
        joined[0],
        "Timestamp (ms),ax_mps2,ay_mps2,az_mps2,gx_rad_s,gy_rad_s,gz_rad_s"
    );
    assert_eq!(whole.len(), joined.len());
    for (whole, joined) in whole.iter().zip(&joined).skip(1) {
        // The temperature is in the whole one only.
        let mut cells: Vec<&str> = whole.split(',').collect();
        cells.remove(4);
        assert_eq!(cells.join(","), *joined);
    }
    let checked = |line: &str| {
        let run = run_in(path, words(&format!("check cal.json {line} --json")));
        assert_eq!(run.code, 0, "{}", run.err);
        run.json()["gyroscope"]["judgement"].clone()
    };
    assert_eq!(checked("line/line.csv"), "fits");
    assert_eq!(checked("accel.csv --gyro gyro.csv"), "fits");
    assert!(checked("accel.csv").is_null());
    // What cannot be joined.
    let run = run_in(
        path,
        words("apply cal.json - --gyro gyro.csv --json -o x.csv"),
    );
    assert_eq!((run.code, run.error_code().as_str()), (2, "gyro-stdin"));
    let means = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n-y,0.46,-9.99,0.39\n\
                 +y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
    write(path, "means.csv", means);
    let line = "calibrate means.csv --method ferraris -o six.json --quiet";
    assert_eq!(run_in(path, words(line)).code, 0);
    let run = run_in(
        path,
        words("apply six.json accel.csv --gyro gyro.csv --json -o x.csv"),
    );
    assert_eq!(
        (run.code, run.error_code().as_str()),
        (2, "gyro-not-calibrated")
    );
}
