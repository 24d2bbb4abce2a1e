//! Invariance: unit, order, and orientation of the board in its case must not matter.

use gravical_calibrate::calibrate::CalibrateOptions;
use gravical_calibrate::poses::face::{AxisMap, CaseAxes, Face};
use gravical_sim::{Scenario, SimulateOptions, SixPositionOptions, simulate};

use crate::support::*;
use crate::truth::recordings;

/// Accelerometer and gyroscope of a board rotated in its case have results in the same axes, known as
/// well as before.
#[test]
fn the_orientation_of_the_board_only_rotates_the_result() {
    let six = SixPositionOptions {
        continuous: true,
        ..SixPositionOptions::default()
    };
    let simulation = simulate(&SimulateOptions::new(Scenario::SixPosition(six))).unwrap();
    let continuous = recordings(&simulation);
    let six_files = six_files(&Sensor::default(), 400);
    let all = [
        (&continuous, CalibrateOptions::default(), 1e-6, "y,z,x"),
        (&six_files, given_gravity(), 1e-9, "z,x,y"),
        (&six_files, given_gravity(), 1e-9, "x,-z,y"),
        (&six_files, given_gravity(), 1e-9, "-x,-y,z"),
    ];
    for (session, mut options, tolerance, axes) in all {
        let board = calibrated(session, &options).calibration;
        options.segment.axes = axes.parse().unwrap();
        let case = calibrated(session, &options).calibration;
        let is_turned = |case: &[[f64; 3]; 3], board: &[[f64; 3]; 3]| {
            for (case, board) in case.iter().zip(board) {
                let want = options.segment.axes.to_case(*board);
                (0..3).for_each(|k| close(case[k], want[k], tolerance));
            }
        };
        let [a, b] = [&case, &board].map(|f| &f.accelerometer);
        is_turned(&a.orientation(), &b.orientation());
        for i in 0..3 {
            close(a.bias[i], b.bias[i], tolerance);
            close(a.scale()[i], b.scale()[i], tolerance);
        }
        let [a, b] = [&case, &board].map(|f| f.reliability.predicted_mps2.unwrap());
        close(a, b, 1e-6);
        let [a, b] = [&case, &board].map(|f| f.mounting().unwrap().rotation_deg);
        let turned = options.segment.axes.to_case(b);
        (0..3).for_each(|i| close(a[i], turned[i], 0.1));
        if simulation.files.len() == session.len() {
            let [a, b] = [&case, &board].map(|f| f.gyroscope.as_ref().unwrap().orientation());
            is_turned(&a, &b);
        }
    }
}

/// `--axes` as it is proposed makes the first placement z up, and the next one on another axis x up.
#[test]
fn two_placements_tell_the_axes_of_the_case() {
    for z in Face::all() {
        for x in Face::all() {
            let lying = [z, z, z.opposite(), x].map(Face::direction);
            let Some(told) = CaseAxes::of(lying) else {
                assert_eq!(z.axis, x.axis);
                continue;
            };
            assert_eq!((told.z_up, told.x_up), (1, 4));
            let axes: AxisMap = told.axes.to_string().parse().unwrap();
            let up = |face: Face| Face::nearest(axes.to_case(face.direction())).0.name();
            assert_eq!([up(z), up(x)], ["+z", "+x"], "{told:?}");
        }
    }
}
