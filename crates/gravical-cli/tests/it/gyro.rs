//! The gyroscope from motions between stills, on real recordings and from a
//! second file.

use std::path::Path;

use crate::support::*;

#[test]
fn the_xsens_set_against_its_published_result() {
    let Some(folder) = data() else { return };
    let set = "imu_tk-xsens/xsens_acc.txt.gz --gyro imu_tk-xsens/xsens_gyro.txt.gz";
    let found = calibrate(&folder, &format!("{set} --gravity 9.81744"), 0);
    let section = &found["gyroscope"];
    assert_eq!(section["method"], "motion");
    assert_eq!(section["input_unit"], "counts");
    let inputs = found["inputs"].as_array().unwrap();
    assert_eq!(inputs.len(), 2);
    assert_eq!(
        inputs[1]["sha256"].as_str().unwrap().len(),
        64,
        "{inputs:?}"
    );
    let matrix = [2.09294526e-4, 2.09898540e-4, 2.09482984e-4];
    let bias = [32777.13994, 32459.80288, 32511.84746];
    for i in 0..3 {
        close(number(&section["matrix"][i][i]) / matrix[i], 1.0, 0.01);
        // The listed bias is that of the first still; ours is without the
        // part that gravity has in it.
        close(number(&section["bias"][i]), bias[i], 12.0);
    }
    let residual = number(&section["residual_deg"]);
    assert!(residual < 0.2, "{residual}");
}

/// A simulated session in one file, and the same in two files without the other's columns.
fn divided(path: &Path) {
    for make in [
        "simulate poses -o sim --seed 5 --free 8 --quiet",
        "calibrate sim/poses.csv --gravity 9.80665 -o cal.json --quiet",
        "simulate line -o line --seed 5 --quiet",
    ] {
        ends(path, make, 0);
    }
    let text = read(path, "line/line.csv");
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
fn apply_joins_a_gyroscope() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    divided(path);
    let apply = |line: &str| {
        let run = ends(path, &format!("apply cal.json {line} --quiet -o -"), 0);
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
    // What cannot be joined.
    write(path, "means.csv", crate::report::MEANS);
    let line = "calibrate means.csv --method ferraris -o six.json --quiet";
    ends(path, line, 0);
    for (line, code) in [
        ("apply six.json accel.csv -o x.csv", "gyro-not-calibrated"),
        ("calibrate accel.csv line/line.csv", "gyro-inputs"),
        ("inspect accel.csv line/line.csv", "gyro-inputs"),
    ] {
        fails(path, &format!("{line} --gyro gyro.csv"), 2, code);
    }
}
