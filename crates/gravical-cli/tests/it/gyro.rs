//! The gyroscope from motions between stills, on real recordings and from a
//! second file.

use std::path::{Path, PathBuf};

use gravical_core::calibration::GyroscopeCalibration;
use serde_json::Value;

use crate::support::*;

fn xsens(folder: &Path) -> [PathBuf; 2] {
    ["xsens_acc.txt.gz", "xsens_gyro.txt.gz"].map(|n| folder.join("imu_tk-xsens").join(n))
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
    let means = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n-y,0.46,-9.99,0.39\n\
                 +y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
    write(path, "means.csv", means);
    let line = "calibrate means.csv --method ferraris -o six.json --quiet";
    assert_eq!(run_in(path, words(line)).code, 0);
    for (line, code) in [
        ("apply six.json accel.csv -o x.csv", "gyro-not-calibrated"),
        ("calibrate accel.csv line/line.csv", "gyro-inputs"),
        ("inspect accel.csv line/line.csv", "gyro-inputs"),
    ] {
        let run = run_in(path, words(&format!("{line} --gyro gyro.csv --json")));
        assert_eq!((run.code, run.error_code().as_str()), (2, code), "{line}");
    }
}
