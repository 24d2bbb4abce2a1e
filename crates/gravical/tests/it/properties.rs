//! Invariance: unit, order, and orientation of the board in its case must not matter.

use gravical::calibrate::CalibrateOptions;
use gravical::calibration_file::{AccelerometerSection, CalibrationFile};
use gravical::poses::face::AxisMap;
use gravical::recording::{ReadOptions, Recording, read_bytes};
use gravical::simulate::{Scenario, SimulateOptions, SixPositionOptions, simulate};

use crate::support::*;
use crate::truth::recordings;

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
            let name = format!("{name}.csv");
            read_bytes(text.as_bytes(), &name, &ReadOptions::default()).unwrap()
        })
        .collect()
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
        let mut options = given_gravity();
        options.segment.axes = map;
        let case = fit(&session, &options).accelerometer;
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
        let variance =
            |a: &AccelerometerSection, i: usize| a.covariance.as_ref().unwrap().values[i][i];
        for i in 9..12 {
            close(variance(&case, i) / variance(&board, i), 1.0, 1e-6);
        }
        let [case, board] = [&case, &board].map(|a| a.predicted_norm_error_mps2.unwrap());
        close(case, board, 1e-6);
    }
}

/// Accelerometer and gyroscope of a board rotated in its case have results in the same axes.
#[test]
fn the_gyroscope_is_rotated_with_the_board() {
    let six = SixPositionOptions {
        continuous: true,
        ..SixPositionOptions::default()
    };
    let simulation = simulate(&SimulateOptions::new(Scenario::SixPosition(six))).unwrap();
    let session = recordings(&simulation);
    let with_axes = |axes: &str| {
        let mut options = CalibrateOptions::default();
        options.segment.axes = axes.parse().unwrap();
        let file = fit(&session, &options);
        [
            file.accelerometer.orientation,
            file.gyroscope.unwrap().orientation,
        ]
    };
    for (plain, turned) in with_axes("x,y,z").into_iter().zip(with_axes("y,z,x")) {
        for channel in 0..3 {
            for case in 0..3 {
                close(turned[channel][case], plain[channel][(case + 1) % 3], 1e-6);
            }
        }
    }
}
