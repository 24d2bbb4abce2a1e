//! Simulated sensors with known truth.

use std::fmt::Write as _;
use std::ops::Range;

use super::*;
use crate::poses::{SegmentOptions, segment};
use crate::recording::{ReadOptions, Recording, read_bytes};
use gravical_sim::{PosesOptions, Scenario, SimulateOptions, Simulation, simulate};

/// Six faces and `free` poses, without drift of the accelerometer's bias: that
/// is an error of the accelerometer's calibration.
fn poses(seed: u64, free: u32) -> Simulation {
    let mut options = SimulateOptions::new(Scenario::Poses(PosesOptions { hold_s: 3.0, free }));
    options.seed = seed;
    options.sensor.bias_drift_mg_per_c = 0.0;
    simulate(&options).unwrap()
}

/// Rows of the recording as if its file had been read; `gyro` makes the file's numbers of rates in rad/s.
fn part_of(
    simulation: &Simulation,
    rows: Range<usize>,
    gyro: impl Fn(usize, [f64; 3]) -> [f64; 3],
) -> Recording {
    let file = &simulation.files[0];
    let mut text = "t_ms,ax,ay,az,gx,gy,gz\n".to_owned();
    for i in rows {
        let row = &file.rows[i];
        let g = gyro(i, row.reading.gyro_rad_s);
        let values = row.reading.accel_mps2.iter().chain(&g);
        let cells: String = values.map(|v| format!(",{v:.6}")).collect();
        writeln!(text, "{}{cells}", row.stamp_ms).unwrap();
    }
    read_bytes(text.as_bytes(), &file.name, &ReadOptions::default()).unwrap()
}

fn true_accelerometer(simulation: &Simulation) -> LinearCalibration<f64> {
    let truth = &simulation.truth.accelerometer;
    LinearCalibration {
        matrix: matrix3::inverse(&truth.matrix).unwrap(),
        bias: truth.bias_mps2,
    }
}

/// The gyroscope of the whole recording, of which `gyro` makes the rates.
fn fitted(simulation: &Simulation, gyro: impl Fn(usize, [f64; 3]) -> [f64; 3]) -> FittedGyroscope {
    let rows = simulation.files[0].rows.len();
    fitted_to_all(simulation, &[part_of(simulation, 0..rows, gyro)])
}

fn fitted_to_all(simulation: &Simulation, recordings: &[Recording]) -> FittedGyroscope {
    let session = segment(recordings, &SegmentOptions::default()).unwrap();
    let readings = Readings::new(recordings, &session);
    gyroscope(readings, &true_accelerometer(simulation))
}

fn found<'a>(fit: &'a FittedGyroscope, kind: &str) -> &'a Finding {
    let found = fit.findings.iter().find(|f| f.kind == kind);
    found.unwrap_or_else(|| panic!("{kind} of {:?}", fit.findings))
}

/// The motions that are left out for a reason.
fn left_out<'a>(fit: &'a FittedGyroscope, why: &str) -> &'a Finding {
    let mut found = fit.findings.iter();
    let found = found.find(|f| f.kind == "gyro-motions-left-out" && f.message.contains(why));
    found.unwrap_or_else(|| panic!("{why} of {:?}", fit.findings))
}

/// The first of the elements of M and b are within 4 standard deviations.
fn assert_true(simulation: &Simulation, section: &Gyroscope, elements: usize) {
    let truth = &simulation.truth.gyroscope;
    let covariance = &section.covariance.as_ref().unwrap().values;
    let model = matrix3::inverse(&section.matrix).unwrap().concat();
    let truths = truth.matrix.concat().into_iter().chain(truth.bias_rad_s);
    let found = model.into_iter().chain(section.bias).zip(truths);
    for (i, (found, truth)) in found.take(elements).enumerate() {
        let z = (found - truth) / covariance[i][i].sqrt();
        assert!(z.abs() < 4.0, "element {i}: {z:.1}");
    }
}

#[test]
fn counts_of_unknown_scale_and_an_axis_that_is_turned_round() {
    let simulation = poses(3, 12);
    let counts = fitted(&simulation, |_, g| {
        g.map(|v| (32768.0 + 4778.0 * v).round())
    });
    let section = counts.section.unwrap();
    assert_eq!(section.input_unit, GyroUnit::Counts);
    assert!((section.bias[0] - 32768.0).abs() < 400.0);

    let simulation = poses(4, 12);
    let mirrored = fitted(&simulation, |_, [x, y, z]| [x, y, -z]);
    found(&mirrored, "gyro-left-handed");
    let model = matrix3::inverse(&mirrored.section.unwrap().matrix).unwrap();
    assert!((model[2][2] + simulation.truth.gyroscope.matrix[2][2]).abs() < 2e-3);
}

/// Rows in the middle of the `n`th move.
fn middle_of_move(simulation: &Simulation, n: usize) -> usize {
    let piece = &simulation.truth.files[0].moves[n];
    (50.0 * (piece.start_s + piece.end_s)) as usize
}

#[test]
fn motions_that_cannot_be_right_are_left_out() {
    // Somebody knocked against it, 6° that the gyroscope made up; a gap of readings.
    let knocked: fn(f64) -> f64 = |v| v + 1.0;
    let lost: fn(f64) -> f64 = |_| f64::NAN;
    for (seed, n, rows, change, why) in [
        (5, 7, 10, knocked, "contradict the others"),
        (6, 3, 6, lost, "have a break"),
    ] {
        let simulation = poses(seed, 12);
        let middle = middle_of_move(&simulation, n);
        let hit = middle..middle + rows;
        let changed = |row, g: [f64; 3]| if hit.contains(&row) { g.map(change) } else { g };
        let fit = fitted(&simulation, changed);
        let [from, to] = left_out(&fit, why).lines[0];
        assert!((from..to).contains(&(middle as u64 + 2)), "{why}");
        let section = fit.section.unwrap();
        assert_eq!(section.motions.unwrap().left_out, 1);
        assert_true(&simulation, &section, 12);
    }
    let simulation = poses(6, 12);
    let fit = fitted(&simulation, |_, g| g.map(|v| v.clamp(-1.6, 1.6)));
    assert!(left_out(&fit, "end of its range").count > 10);
    let section = fit.section.unwrap();
    assert!(section.motions.unwrap().left_out > 1);
    assert_true(&simulation, &section, 12);
}

#[test]
fn the_motions_of_all_recordings_count() {
    let simulation = poses(8, 6);
    let rows = simulation.files[0].rows.len();
    let middle = middle_of_move(&simulation, 5);
    // The bias is another one when the board is switched on again.
    let shift = 0.3_f64.to_radians();
    let halves = [
        part_of(&simulation, 0..middle, |_, g| g),
        part_of(&simulation, middle..rows, |_, g| g.map(|v| v + shift)),
    ];
    let section = fitted_to_all(&simulation, &halves).section.unwrap();
    assert_eq!(section.method, GyroMethod::Motion);
    assert_eq!(section.motions.unwrap().used, 10);
    assert_true(&simulation, &section, 9);

    // What is missing is said of them together; the bias is what is left.
    let few = part_of(&simulation, 0..middle_of_move(&simulation, 2), |_, g| g);
    let fit = fitted_to_all(&simulation, &[few.clone(), few.clone()]);
    let open = found(&fit, "gyro-undetermined");
    assert!(open.message.starts_with("4 usable motions"), "{open:?}");
    assert_eq!(open.file, None);
    let section = fit.section.unwrap();
    assert_eq!(section.method, GyroMethod::Bias);
    for i in 0..3 {
        // The reaction to gravity is in it: 0.1 °/s per g.
        assert!((section.bias[i] - simulation.truth.gyroscope.bias_rad_s[i]).abs() < 5e-3);
    }
    // Without a unit there is not even a matrix.
    let few = [few];
    let mut session = segment(&few, &SegmentOptions::default()).unwrap();
    session.poses.truncate(1);
    session.gyro_scale = None;
    let readings = Readings::new(&few, &session);
    let fit = gyroscope(readings, &true_accelerometer(&simulation));
    assert!(fit.section.is_none());
    found(&fit, "gyro-scale-unknown");
}
