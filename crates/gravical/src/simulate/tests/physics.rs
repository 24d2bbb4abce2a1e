//! Gyroscope and accelerometer are consistent with the path.

use nalgebra::{UnitQuaternion, Vector3};

use super::*;

/// Change of attitude measured by the gyroscope over `rows`, midpoint rule.
fn turned(file: &SimulatedFile, rows: std::ops::Range<usize>) -> UnitQuaternion<f64> {
    let mut q = UnitQuaternion::identity();
    for row in rows {
        let dt = file.rows[row + 1].t_s - file.rows[row].t_s;
        let rate = 0.5 * (gyro(file, row) + gyro(file, row + 1));
        q *= UnitQuaternion::from_scaled_axis(rate * dt);
    }
    q
}

#[test]
fn gyroscope_and_accelerometer_agree_on_gravity() {
    let mut options = ideal(Scenario::Poses(PosesOptions::default()));
    options.rate_hz = 500.0;
    options.tilt_sd_deg = 2.0;
    let simulation = simulate(&options).unwrap();
    let (file, truth) = (&simulation.files[0], &simulation.truth.files[0]);
    assert_eq!(truth.poses.len(), 12);
    for pair in truth.poses.windows(2) {
        let between = rows(file, pair[0].end_s - 0.1, pair[1].start_s + 0.1);
        let before = accel(file, between.start).normalize();
        let after = accel(file, between.end).normalize();
        let predicted = turned(file, between).inverse() * before;
        let off = (predicted - after).norm();
        assert!(off < 1e-6, "{} to {}: {off}", pair[0].label, pair[1].label);
        assert!((after - Vector3::from(pair[1].up)).norm() < 1e-9);
    }
}

#[test]
fn a_turn_integrates_to_its_angle() {
    let simulation = simulate(&ideal(session())).unwrap();
    let (file, truth) = (&simulation.files[0], &simulation.truth.files[0]);
    assert_eq!(truth.turns.len(), 3);
    for (axis, turn) in truth.turns.iter().enumerate() {
        assert_eq!(turn.angle_deg, -360.0);
        let mut sum = Vector3::zeros();
        for row in rows(file, turn.start_s, turn.end_s) {
            sum += gyro(file, row) / 100.0;
        }
        let mut expected = Vector3::zeros();
        expected[axis] = -std::f64::consts::TAU;
        assert!((sum - expected).norm() < 1e-6, "{sum}");
    }
}

#[test]
fn strapdown_integration_gives_a_line() {
    let mut options = ideal(Scenario::Line(LineOptions::default()));
    options.rate_hz = 1000.0;
    options.tilt_sd_deg = 1.0;
    let simulation = simulate(&options).unwrap();
    let file = &simulation.files[0];
    let up = Vector3::from(simulation.truth.files[0].poses[0].up);
    let attitude = poses::attitude_of(up);
    let gravity = Vector3::z() * options.gravity_mps2;
    let (mut velocity, mut position) = (Vector3::zeros(), Vector3::zeros());
    let mut before = Vector3::zeros();
    for row in 1..file.rows.len() {
        let now = attitude * accel(file, row) - gravity;
        velocity += 0.5e-3 * (before + now);
        position += 1e-3 * velocity;
        before = now;
    }
    let error = (position - Vector3::new(0.02, 0.7, 0.0)).norm();
    assert!(error < 2e-4, "{error}");
}
