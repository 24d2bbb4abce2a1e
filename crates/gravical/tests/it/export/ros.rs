//! ROS and ROS 2: the YAML, read and used as the nodes do.

use super::*;

/// The list behind `key:`, read on its own: every number has a point and a signed exponent, as YAML
/// 1.1 wants it.
fn list(text: &str, key: &str) -> Vec<f64> {
    let number = |n: &str| {
        let (digits, exponent) = n.split_once('e').unwrap();
        let is_yaml = digits.contains('.') && exponent.starts_with(['+', '-']);
        assert!(is_yaml, "{n}");
        n.parse().unwrap()
    };
    let behind = |line| str::strip_prefix(str::trim_start(line), &format!("{key}: ["));
    let list = text.lines().find_map(behind).unwrap();
    let numbers = list.strip_suffix(']').unwrap().split(", ");
    numbers.map(number).collect()
}

#[test]
fn imu_calib_calibrates_alike() {
    for (file, per_mps2, size) in [(in_counts(), 16384.0 / G, 32000.0), (in_g(), 1.0 / G, 4.0)] {
        let text = written(&file, "ros").text;
        let (sm, bias) = (list(&text, "SM"), list(&text, "bias"));
        let calibration = file.accelerometer_calibration();
        let most = size / per_mps2;
        for raw in vectors(11, size) {
            // The driver converts by the nominal scale; the node calibrates what it sends.
            let sent = raw.map(|v| v / per_mps2);
            let out = less(times(&sm, sent), &bias);
            let wanted = calibration.apply(raw);
            for i in 0..3 {
                close(out[i], wanted[i], 1e-6 * most);
            }
        }
    }
}

#[test]
fn the_parameters_of_ros2_calibrate_alike() {
    let file = in_g();
    let text = written(&file, "ros2").text;
    assert!(text.contains("\nimu_apply:\n  ros__parameters:\n    accel:\n"));
    let (accel, gyro) = text.split_once("    gyro:\n").unwrap();
    let (raw_a, raw_g) = (vectors(12, 4.0), vectors(13, 500.0));
    let own = raw_a.iter().zip(&raw_g).map(|(a, w)| {
        let a = less(a.map(|v| v * G), &list(accel, "offset"));
        let a = times(&list(accel, "matrix"), a);
        let w = less(w.map(f64::to_radians), &list(gyro, "offset"));
        let w = less(w, &times(&list(gyro, "g_sensitivity"), a));
        [a, times(&list(gyro, "matrix"), w)]
    });
    agree_rows(&own.collect::<Vec<_>>(), &calibrated(&file, &raw_a, &raw_g));
    // Counts of a gyroscope have no scale in the file: left out, and said.
    let counts = written(&in_counts(), "ros2");
    assert!(!counts.text.contains("gyro:\n") && counts.notes.len() == 1);
}
