//! The whole way: the firmware as it is compiled from the sketch, on an emulated Uno
//! with a simulated sensor of known truth, recorded by the program, calibrated and
//! turned into a way. In real time, so it takes about two minutes.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // helpers of a test may panic

#[path = "../board/mod.rs"]
mod board;
mod desk;

use std::path::{Path, PathBuf};

use desk::{Desk, gravical};
use gravical::calibration_file::CalibrationFile;
use gravical::recording::{ReadOptions, Recording, read};
use gravical::simulate::AccelerometerTruth;
use serde_json::Value;

/// What the sensors of this seed are is nothing special; the motion sees the same.
const SEED: u64 = 7;
/// Recordings of the faces, two for each axis.
const FILES: [&str; 6] = [
    "x_axis_pos.csv",
    "x_axis_neg.csv",
    "y_axis_pos.csv",
    "y_axis_neg.csv",
    "z_axis_pos.csv",
    "z_axis_neg.csv",
];

#[test]
fn from_the_sketch_to_the_way() {
    let Some(firmware) = board::firmware() else {
        eprintln!("skipped: neither GRAVICAL_FIRMWARE nor avr-gcc");
        return;
    };
    let folder = empty_folder("whole_way");

    // Six placements, a file each.
    let seed = SEED.to_string();
    let hands = ["--hands", "--seed", &seed, "--truth", "truth.json"];
    let mut desk = Desk::new(&folder, firmware, &hands);
    for (name, face) in FILES.iter().zip(["+x", "-x", "+y", "-y", "+z", "-z"]) {
        desk.lay(face);
        desk.log(name, 1000);
        let warned = warnings(&folder, name);
        assert!(warned.is_empty(), "{name}: {warned:?}");
    }
    drop(desk);

    let mut call = vec!["calibrate", "-o", "calibration.json"];
    call.extend(FILES);
    gravical(&folder, &call);
    let calibration = CalibrationFile::read(&folder.join("calibration.json")).unwrap();
    calibrated(&folder, &calibration, &truth(&folder));

    // The same part is pushed along a line.
    let simulate = ["simulate", "line", "-o", "line", "--seed", &seed];
    gravical(&folder, &simulate);
    let line = ["--recording", "line/line.csv"];
    let desk = Desk::new(&folder, firmware, &line);
    desk.log("line.csv", 1180);
    drop(desk);
    let call = ["motion", "line.csv", "-c", "calibration.json", "--json"];
    moved(&serde_json::from_str(&gravical(&folder, &call)).unwrap());
}

fn empty_folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn truth(folder: &Path) -> AccelerometerTruth {
    let text = std::fs::read_to_string(folder.join("truth.json")).unwrap();
    let truth: Value = serde_json::from_str(&text).unwrap();
    serde_json::from_value(truth["accelerometer"].clone()).unwrap()
}

/// Kinds of what `inspect` warns of.
fn warnings(folder: &Path, name: &str) -> Vec<String> {
    let text = gravical(folder, &["inspect", "--json", name]);
    let json: Value = serde_json::from_str(&text).unwrap();
    let all = json["recordings"][0]["findings"].as_array().unwrap().iter();
    all.filter(|f| f["severity"] != "note")
        .map(|f| f["kind"].as_str().unwrap().to_owned())
        .collect()
}

/// Bias and scale are within what the file says of them.
fn calibrated(folder: &Path, file: &CalibrationFile, truth: &AccelerometerTruth) {
    let found = &file.accelerometer;
    let deviations = found.deviations.as_ref().unwrap();
    for (axis, names) in FILES.chunks(2).enumerate() {
        // It warms up meanwhile. The files of an axis are those that show its bias.
        let mut warmer_c = -25.0;
        for name in names {
            let recording = read(&folder.join(name), &ReadOptions::default()).unwrap();
            warmer_c += 0.5 * temperature_c(&recording);
        }
        let bias = truth.bias_mps2[axis] + warmer_c * truth.bias_drift_mps2_per_c[axis];
        let bias_error = found.bias[axis] - bias;
        let row = truth.matrix[axis];
        let scale = row.iter().map(|m| m * m).sum::<f64>().sqrt();
        let scale_error = found.scale[axis] / scale - 1.0;
        let [bias_sd, scale_sd] = [deviations.bias[axis], deviations.scale[axis] / scale];
        assert!(
            bias_error.abs() < 3.5 * bias_sd,
            "{axis}: {bias_error} {bias_sd}"
        );
        assert!(
            scale_error.abs() < 3.5 * scale_sd,
            "{axis}: {scale_error} {scale_sd}"
        );
    }
}

fn temperature_c(recording: &Recording) -> f64 {
    let all = recording.temperature_c.as_ref().unwrap();
    all.iter().sum::<f64>() / all.len() as f64
}

/// The 0.7 m, and the two centimetres beside them, lie inside the 2σ band.
fn moved(json: &Value) {
    let moves = json["moves"].as_array().unwrap();
    assert_eq!(moves.len(), 1, "{moves:?}");
    for (axis, want_m) in [0.02, 0.7, 0.0].into_iter().enumerate() {
        let is_m = moves[0]["displacement_m"][axis].as_f64().unwrap();
        let sigma_m = moves[0]["sigma_m"][axis].as_f64().unwrap();
        println!("axis {axis}: {is_m:.4} m, sd {sigma_m:.4} m, true {want_m} m");
        assert!((is_m - want_m).abs() < 2.0 * sigma_m, "axis {axis}");
        assert!(sigma_m < 0.02, "a band that wide says nothing");
    }
}
