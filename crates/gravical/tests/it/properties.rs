//! Invariance: unit, order, and orientation of the board in its case must not matter.

use gravical::calibrate::CalibrateOptions;
use gravical::calibration_file::CalibrationFile;
use gravical::poses::SegmentOptions;
use gravical::poses::face::AxisMap;
use gravical::recording::{ReadOptions, Recording, read_bytes};

use crate::support::*;

/// A clearly tilted session, so that interchanged poses are detected.
fn tilted() -> Vec<Recording> {
    let sensor = Sensor {
        decimals: 12,
        ..Sensor::default()
    };
    FACES
        .iter()
        .enumerate()
        .map(|(i, (name, up))| {
            let mut up = *up;
            up[(i / 2 + 1) % 3] += 0.03;
            up[(i / 2 + 2) % 3] -= 0.02;
            let length = up.iter().map(|v| v * v).sum::<f64>().sqrt();
            let text = sensor.file(up.map(|v| v / length), 400, i as u64);
            read_bytes(
                text.as_bytes(),
                &format!("{name}.csv"),
                &ReadOptions::default(),
            )
            .unwrap()
        })
        .collect()
}

fn with_axes(axes: &str) -> CalibrateOptions {
    CalibrateOptions {
        segment: SegmentOptions {
            axes: axes.parse().unwrap(),
            ..SegmentOptions::default()
        },
        ..given_gravity()
    }
}

fn fit(session: &[Recording], options: &CalibrateOptions) -> CalibrationFile {
    calibrated(session, options).file
}

#[test]
fn the_orientation_of_the_board_only_rotates_the_result() {
    let session = tilted();
    let board = fit(&session, &given_gravity()).accelerometer;
    for axes in ["y,z,x", "z,x,y", "x,-z,y", "-y,x,z", "-x,-y,z"] {
        let map: AxisMap = axes.parse().unwrap();
        let case = fit(&session, &with_axes(axes)).accelerometer;
        for reading in [[9.0, -2.0, 3.0], [0.1, 0.2, 9.8], [-4.0, -5.0, 6.0]] {
            let apply = |matrix: &[[f64; 3]; 3], bias: &[f64; 3]| -> [f64; 3] {
                std::array::from_fn(|i| (0..3).map(|j| matrix[i][j] * (reading[j] - bias[j])).sum())
            };
            let want = map.to_case(apply(&board.matrix, &board.bias));
            let got = apply(&case.matrix, &case.bias);
            for i in 0..3 {
                close(got[i], want[i], 1e-9);
            }
        }
        for i in 0..3 {
            close(case.bias[i], board.bias[i], 1e-9);
            close(case.scale[i], board.scale[i], 1e-9);
        }
        // The uncertainties are rotated too: the bias is known as well as before.
        let variance = |a: &gravical::calibration_file::AccelerometerSection, i: usize| {
            a.covariance.as_ref().unwrap().values[i][i]
        };
        for i in 9..12 {
            close(variance(&case, i) / variance(&board, i), 1.0, 1e-6);
        }
        close(
            case.predicted_norm_error_mps2.unwrap(),
            board.predicted_norm_error_mps2.unwrap(),
            1e-6,
        );
    }
}

#[test]
fn a_session_measured_twice_halves_the_variance() {
    let sensor = Sensor::default();
    let once = six_files(&sensor, 800);
    let mut twice = once.clone();
    for mut recording in six_files(&sensor, 800) {
        recording.name = format!("again/{}", recording.name);
        twice.push(recording);
    }
    let options = CalibrateOptions {
        estimate: by_ferraris(Some(0.0)),
        ..given_gravity()
    };
    let sd = |session: &[Recording]| {
        let file = fit(session, &options);
        let c = file.accelerometer.covariance.unwrap();
        c.values[9][9].sqrt()
    };
    close(sd(&once) / sd(&twice), 2_f64.sqrt(), 0.01);
    let file = fit(&twice, &options);
    assert_eq!(file.accelerometer.degrees_of_freedom, 6);
    assert_eq!(file.accelerometer.poses.len(), 12);
}

/// Accelerometer and gyroscope of a board rotated in its case have results in the same axes.
#[test]
fn the_gyroscope_is_rotated_with_the_board() {
    use gravical::calibrate::{CalibrateOptions, calibrate};
    use gravical::recording::{ReadOptions, read};
    use gravical::simulate::{Scenario, SimulateOptions, SixPositionOptions, simulate_to};

    let folder = tempfile::tempdir().unwrap();
    let session = SixPositionOptions {
        continuous: true,
        ..SixPositionOptions::default()
    };
    let options = SimulateOptions::new(Scenario::SixPosition(session));
    let (_, files) = simulate_to(&options, folder.path(), false).unwrap();
    let recording = [read(&files[0], &ReadOptions::default()).unwrap()];
    let with_axes = |axes: &str| {
        let mut options = CalibrateOptions::default();
        options.segment.axes = axes.parse().unwrap();
        calibrate(&recording, &options).unwrap().file
    };
    let (plain, turned) = (with_axes("x,y,z"), with_axes("y,z,x"));
    let gyroscope = |file: &gravical::calibration_file::CalibrationFile| {
        file.gyroscope.as_ref().unwrap().orientation
    };
    for channel in 0..3 {
        for case in 0..3 {
            let board = (case + 1) % 3;
            for (a, b) in [
                (
                    plain.accelerometer.orientation,
                    turned.accelerometer.orientation,
                ),
                (gyroscope(&plain), gyroscope(&turned)),
            ] {
                let off = a[channel][board] - b[channel][case];
                assert!(off.abs() < 1e-6, "{channel} {case}: {off}");
            }
        }
    }
}
