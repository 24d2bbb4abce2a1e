//! Simulated sensors with known truth.

use std::ops::Range;

use super::*;
use crate::poses::{SegmentOptions, segment};
use crate::recording::{ReadOptions, read_bytes};
use crate::simulate::{PosesOptions, Scenario, SimulateOptions, Simulation, simulate};

/// Six faces and `free` poses, without drift of the accelerometer's bias: that
/// is an error of the accelerometer's calibration.
fn poses(seed: u64, free: u32, change: impl Fn(&mut SimulateOptions)) -> Simulation {
    let mut options = SimulateOptions::new(Scenario::Poses(PosesOptions { hold_s: 3.0, free }));
    options.seed = seed;
    options.sensor.bias_drift_mg_per_c = 0.0;
    change(&mut options);
    simulate(&options).unwrap()
}

/// The recording as if its file had been read; `gyro` makes the file's numbers
/// of rates in rad/s.
fn recording(simulation: &Simulation, gyro: impl Fn(usize, [f64; 3]) -> [f64; 3]) -> Recording {
    part_of(simulation, 0..simulation.files[0].rows.len(), gyro)
}

/// The same of some of its rows.
fn part_of(
    simulation: &Simulation,
    rows: Range<usize>,
    gyro: impl Fn(usize, [f64; 3]) -> [f64; 3],
) -> Recording {
    use std::fmt::Write;
    let file = &simulation.files[0];
    let mut text = "t_ms,ax,ay,az,gx,gy,gz\n".to_owned();
    for row in rows {
        let a = file.rows[row].reading.accel_mps2;
        let g = gyro(row, file.rows[row].reading.gyro_rad_s);
        write!(text, "{}", file.rows[row].stamp_ms).unwrap();
        for v in a.iter().chain(&g) {
            write!(text, ",{v:.6}").unwrap();
        }
        text.push('\n');
    }
    read_bytes(text.as_bytes(), &file.name, &ReadOptions::default()).unwrap()
}

fn true_accelerometer(simulation: &Simulation) -> Calibration<f64> {
    let truth = &simulation.truth.accelerometer;
    Calibration {
        matrix: matrix3::inverse(&truth.matrix).unwrap(),
        bias: truth.bias_mps2,
    }
}

fn fitted(simulation: &Simulation, recording: &Recording) -> Gyroscope {
    fitted_to_all(simulation, std::slice::from_ref(recording))
}

fn fitted_to_all(simulation: &Simulation, recordings: &[Recording]) -> Gyroscope {
    let session = segment(recordings, &SegmentOptions::default()).unwrap();
    gyroscope(recordings, &session, &true_accelerometer(simulation))
}

fn kinds(fit: &Gyroscope) -> Vec<&str> {
    fit.findings.iter().map(|f| f.kind.name()).collect()
}

/// Errors of M and b over their standard deviations.
fn scores(simulation: &Simulation, section: &GyroscopeSection) -> Vec<f64> {
    let truth = &simulation.truth.gyroscope;
    let covariance = &section.covariance.as_ref().unwrap().values;
    let model = matrix3::inverse(&section.matrix).unwrap();
    let errors: Vec<f64> = model
        .concat()
        .iter()
        .zip(truth.matrix.concat())
        .map(|(found, t)| found - t)
        .chain((0..3).map(|i| section.bias[i] - truth.bias_rad_s[i]))
        .collect();
    (0..12)
        .map(|i| errors[i] / covariance[i][i].sqrt())
        .collect()
}

/// What a known sensor has to give back: every element within 4 standard
/// deviations.
fn assert_true(simulation: &Simulation, section: &GyroscopeSection) {
    let z = scores(simulation, section);
    assert!(z.iter().all(|v| v.abs() < 4.0), "{z:.1?}");
}

#[test]
fn unsigned_counts_of_unknown_scale() {
    let simulation = poses(3, 12, |_| {});
    let per_rad_s = 4778.0;
    let recording = recording(&simulation, |_, g| {
        g.map(|v| (32768.0 + per_rad_s * v).round())
    });
    let fit = fitted(&simulation, &recording);
    assert!(fit.scale_by_motions, "{:?}", fit.findings);
    let section = fit.section.unwrap();
    assert_eq!(section.input_unit, GyroUnit::Counts);
    assert!((section.bias[0] - 32768.0).abs() < 400.0);
}

#[test]
fn an_axis_that_is_turned_round_is_found() {
    let simulation = poses(4, 12, |_| {});
    let mirrored = fitted(
        &simulation,
        &recording(&simulation, |_, [x, y, z]| [x, y, -z]),
    );
    assert!(kinds(&mirrored).contains(&"gyro-left-handed"));
    let model = matrix3::inverse(&mirrored.section.unwrap().matrix).unwrap();
    assert!((model[2][2] + simulation.truth.gyroscope.matrix[2][2]).abs() < 2e-3);
}

/// Rows in the middle of the `n`th move.
fn middle_of_move(simulation: &Simulation, n: usize) -> usize {
    let piece = &simulation.truth.files[0].moves[n];
    (50.0 * (piece.start_s + piece.end_s)) as usize
}

#[test]
fn a_bad_motion_is_found_and_named() {
    let simulation = poses(5, 12, |_| {});
    let middle = middle_of_move(&simulation, 7);
    let recording = recording(&simulation, |row, g| {
        // Somebody knocked against it: 6° that the gyroscope made up.
        let knocked = (middle..middle + 10).contains(&row);
        g.map(|v| if knocked { v + 1.0 } else { v })
    });
    let fit = fitted(&simulation, &recording);
    let found = fit
        .findings
        .iter()
        .find(|f| f.kind.name() == "gyro-motion-outlier")
        .unwrap();
    let [from, to] = found.lines[0];
    assert_eq!(found.lines.len(), 1);
    assert!((from..to).contains(&(middle as u64 + 2)), "{found:?}");
    let section = fit.section.unwrap();
    let counts = section.motions.unwrap();
    assert_eq!((counts.used, counts.left_out), (16, 1));
    assert_true(&simulation, &section);
}

#[test]
fn gaps_and_clipped_motions_are_left_out() {
    let simulation = poses(6, 12, |_| {});
    let middle = middle_of_move(&simulation, 3);
    let recording_with_gap = recording(&simulation, |row, g| {
        if (middle..middle + 6).contains(&row) {
            [f64::NAN; 3]
        } else {
            g
        }
    });
    let fit = fitted(&simulation, &recording_with_gap);
    let found = fit
        .findings
        .iter()
        .find(|f| f.kind.name() == "gyro-motion-gap")
        .unwrap();
    assert!((found.lines[0][0]..found.lines[0][1]).contains(&(middle as u64 + 2)));
    let section = fit.section.unwrap();
    assert_eq!(section.motions.unwrap().left_out, 1);
    assert_true(&simulation, &section);

    let limit = 1.6;
    let clipped = recording(&simulation, |_, g| g.map(|v| v.clamp(-limit, limit)));
    let fit = fitted(&simulation, &clipped);
    let found = fit
        .findings
        .iter()
        .find(|f| f.kind.name() == "gyro-motion-clipped")
        .unwrap();
    assert!(found.count > 10, "{found:?}");
    let section = fit.section.unwrap();
    assert!(section.motions.unwrap().left_out > 1);
    assert_true(&simulation, &section);
}

#[test]
fn the_motions_of_all_recordings_count() {
    let simulation = poses(8, 6, |_| {});
    let rows = simulation.files[0].rows.len();
    let middle = middle_of_move(&simulation, 5);
    // The bias is another one when the board is switched on again.
    let shift = 0.3_f64.to_radians();
    let halves = [
        part_of(&simulation, 0..middle, |_, g| g),
        part_of(&simulation, middle..rows, |_, g| g.map(|v| v + shift)),
    ];
    let fit = fitted_to_all(&simulation, &halves);
    let section = fit.section.unwrap();
    assert_eq!(section.method, GyroMethod::Motion, "{:?}", fit.findings);
    assert_eq!(section.motions.unwrap().used, 10);
    let z = scores(&simulation, &section);
    assert!(z[..9].iter().all(|v| v.abs() < 4.0), "{z:.1?}");

    // What is missing is said of them together.
    let few = part_of(&simulation, 0..middle_of_move(&simulation, 2), |_, g| g);
    let fit = fitted_to_all(&simulation, &[few.clone(), few]);
    assert_eq!(fit.section.unwrap().method, GyroMethod::Bias);
    let found = fit
        .findings
        .iter()
        .find(|f| f.kind.name() == "gyro-undetermined");
    let found = found.unwrap();
    assert!(found.message.starts_with("4 usable motions"), "{found:?}");
    assert_eq!(found.file, None);
}

#[test]
fn too_few_motions_leave_the_bias() {
    let simulation = poses(7, 12, |_| {});
    let recording = [recording(&simulation, |_, g| g)];
    let mut session = segment(&recording, &SegmentOptions::default()).unwrap();
    let accelerometer = true_accelerometer(&simulation);
    session.poses.sort_by_key(|p| p.rows.start);
    session.poses.truncate(4);
    let fit = gyroscope(&recording, &session, &accelerometer);
    let section = fit.section.clone().unwrap();
    assert_eq!(section.method, GyroMethod::Bias);
    assert_eq!(kinds(&fit), ["gyro-undetermined"]);
    for i in 0..3 {
        // The reaction to gravity is in it: 0.1 °/s per g.
        assert!((section.bias[i] - simulation.truth.gyroscope.bias_rad_s[i]).abs() < 5e-3);
    }
    // Without a unit there is not even a matrix.
    session.poses.truncate(1);
    session.gyro_scale = None;
    let fit = gyroscope(&recording, &session, &accelerometer);
    assert!(fit.section.is_none());
    assert_eq!(kinds(&fit), ["gyro-scale-unknown"]);
}
