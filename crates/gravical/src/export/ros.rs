//! ROS: the file of imu_calib, and parameters of a ROS 2 node.

use super::header::{about, marked, without_drift, without_gyroscope};
use super::nominal::Matrix;
use super::{Export, Target, nominal};
use crate::Result;
use crate::calibration_file::CalibrationFile;

/// A number as C prints it with `%.12e`: YAML 1.1 takes an exponent without a sign for text.
fn number(value: f64) -> String {
    let text = format!("{value:.12e}");
    match text.split_once('e') {
        Some((digits, exponent)) => match exponent.strip_prefix('-') {
            Some(size) => format!("{digits}e-{size:0>2}"),
            None => format!("{digits}e+{exponent:0>2}"),
        },
        None => text,
    }
}

fn list<'a>(values: impl IntoIterator<Item = &'a f64>) -> String {
    let numbers: Vec<String> = values.into_iter().map(|v| number(*v)).collect();
    format!("[{}]", numbers.join(", "))
}

/// imu_calib: `SM · raw − bias`, raw in m/s².
///
/// # Errors
///
/// `export-unit` (input).
pub(super) fn ros(file: &CalibrationFile) -> Result<Export> {
    let a = nominal::accelerometer(file)?;
    let bias = gravical_core::matrix3::mul_vec(&a.matrix, &a.bias);
    let notes = without_gyroscope(
        file,
        "imu_calib measures its bias at rest when it starts (parameter calibrate_gyros)",
    );
    let text = format!(
        "{}# calibrated = SM raw - bias, all in m/s^2\nSM: {}\nbias: {}\n",
        marked("#", &about(file, Target::Ros, &notes)),
        list(a.matrix.iter().flatten()),
        list(&bias)
    );
    Ok(Export { text, notes })
}

/// Parameters of a node `name` that computes `matrix (raw − offset)` in SI units.
///
/// # Errors
///
/// `export-unit` (input).
pub(super) fn ros2(file: &CalibrationFile, name: &str) -> Result<Export> {
    let a = nominal::accelerometer(file)?;
    let mut notes = without_drift(file);
    let sensor = |of: &str, matrix: &Matrix, offset: &[f64; 3]| {
        format!(
            "    {of}:\n      offset: {}\n      matrix: {}\n",
            list(offset),
            list(matrix.iter().flatten())
        )
    };
    let mut body = sensor("accel", &a.matrix, &a.bias);
    match nominal::gyroscope(file) {
        Some((g, g_sensitivity)) => {
            body += &sensor("gyro", &g.matrix, &g.bias);
            body += &format!(
                "      g_sensitivity: {}\n",
                list(g_sensitivity.iter().flatten())
            );
        }
        None if file.gyroscope.is_some() => notes.push(
            "Without the gyroscope: the nominal scale of its counts is not known.".to_owned(),
        ),
        None => {}
    }
    let text = format!(
        "{}# accel: calibrated = matrix (raw - offset), m/s^2 as in sensor_msgs/Imu\n# gyro: calibrated = matrix (raw - offset - g_sensitivity accel), rad/s\n{name}:\n  ros__parameters:\n{body}",
        marked("#", &about(file, Target::Ros2, &notes))
    );
    Ok(Export { text, notes })
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_are_numbers_in_yaml_1_1() {
        assert_eq!(number(1.0), "1.000000000000e+00");
        assert_eq!(number(-2.5e-13), "-2.500000000000e-13");
        assert_eq!(number(0.0), "0.000000000000e+00");
        assert_eq!(number(1e120), "1.000000000000e+120");
    }
}
