//! The whole way: the firmware as it is compiled from the sketch, on an emulated Uno with a simulated
//! sensor of known truth; what it sends is calibrated and turned into a way.
#![allow(clippy::unwrap_used)] // helpers of a test may panic as it does

mod board;

use board::{in_hand, on};
use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::Calibration;
use gravical::motion::{MotionOptions, motion};
use gravical::poses::face::Face;
use gravical::recording::{Finding, ReadOptions, Recording, Severity, read_bytes};
use gravical::simulate::{AccelerometerTruth, LineOptions};

/// The whole lines among what is sent, below the head.
fn recording(head: &str, text: &str, name: &str) -> Recording {
    let [from, to] = [text.find('\n'), text.rfind('\n')].map(|at| at.unwrap() + 1);
    let text = format!("{head}{}", &text[from..to]);
    read_bytes(text.as_bytes(), name, &ReadOptions::default()).unwrap()
}

#[test]
fn from_the_sketch_to_the_way() {
    let Some(firmware) = board::firmware() else {
        eprintln!("skipped: neither GRAVICAL_FIRMWARE nor avr-gcc");
        return;
    };
    let (hands, reading) = in_hand(7);
    let mut board = on(firmware, reading);
    let text = board.text(1.0);
    let head = text.lines().filter(|line| line.starts_with(['#', 'T']));
    let head: String = head.map(|line| format!("{line}\n")).collect();

    // Six placements, a recording each.
    let recordings = Face::all().map(|face| {
        let rests_s = hands.borrow_mut().lay(face);
        board.text(rests_s + 1.0);
        let name = format!("pose-{}.csv", face.index());
        let recording = recording(&head, &board.text(10.0), &name);
        let is_warning = |f: &Finding| f.severity == Severity::Warning;
        assert!(!recording.findings.iter().any(is_warning), "{name}");
        recording
    });
    let options = CalibrateOptions::default();
    let file = calibrate(&recordings, &options).unwrap().calibration;
    calibrated(&recordings, &file, &hands.borrow().truth().accelerometer);

    // The same part is pushed along a line.
    let rests_s = hands.borrow_mut().lay(Face::all()[4]);
    board.text(rests_s + 1.0);
    let mut text = board.text(5.0);
    let rests_s = hands.borrow_mut().push(&LineOptions::default()).unwrap();
    text += &board.text(rests_s + 5.0);
    let way = recording(&head, &text, "way.csv");
    let calibration = (&file, "calibration.json");
    let result = motion(&way, Some(calibration), &MotionOptions::default());
    let moves = result.unwrap().result.moves;
    assert_eq!(moves.len(), 1);
    // 0.7 m, and two centimetres beside them.
    let norm = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    let is_m = norm(moves[0].displacement_m.unwrap());
    let sigma_m = norm(moves[0].sigma_m.unwrap());
    assert!((is_m - 0.7_f64.hypot(0.02)).abs() < 2.0 * sigma_m, "{is_m}");
    assert!(sigma_m < 0.035, "a band that wide says nothing: {sigma_m}");
}

/// Bias and scale are within what the file says of them.
fn calibrated(poses: &[Recording], file: &Calibration, truth: &AccelerometerTruth) {
    let found = &file.accelerometer;
    let deviations = found.deviations().unwrap();
    for (axis, pair) in poses.chunks(2).enumerate() {
        // It warms up meanwhile. The recordings of an axis are those that show its bias.
        let mean_c = 0.5 * pair.iter().map(temperature_c).sum::<f64>();
        let warmer_c = mean_c - 25.0;
        let bias = truth.bias_mps2[axis] + warmer_c * truth.bias_drift_mps2_per_c[axis];
        let scale = truth.matrix[axis].iter().map(|m| m * m).sum::<f64>().sqrt();
        for (error, sd) in [
            (found.bias[axis] - bias, deviations.bias[axis]),
            (found.scale()[axis] - scale, deviations.scale[axis]),
        ] {
            assert!(error.abs() < 3.5 * sd, "{axis}: {error} {sd}");
        }
    }
}

fn temperature_c(recording: &Recording) -> f64 {
    let all = recording.temperature_c.as_ref().unwrap();
    all.iter().sum::<f64>() / all.len() as f64
}
