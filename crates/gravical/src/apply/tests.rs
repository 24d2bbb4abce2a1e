mod drift;
mod lines;
mod units;

use super::*;
use crate::Error;
use crate::finding::Advice;
use crate::recording::{AccelUnit, Origin, read_bytes};
use gravical_recording::bytes::from_reader;
use std::io;

/// A calibration in imucal's format, which is the shortest; no gyroscope.
fn calibration(unit: Option<&str>, scale: f64, bias: [f64; 3]) -> Calibration {
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let k = identity.map(|row: [f64; 3]| row.map(|v| v * scale));
    let value = serde_json::json!({
        "acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": unit, "cal_type": "Ferraris",
        "K_a": k, "b_a": bias,
        "R_a": [[1.0, 0.01, -0.02], [0.0, 1.0, 0.03], [0.01, 0.0, 1.0]],
        "K_g": identity, "b_g": [0, 0, 0], "R_g": identity, "K_ga": [[0, 0, 0], [0, 0, 0], [0, 0, 0]],
    });
    Calibration::parse(value.to_string().as_bytes()).unwrap()
}

fn si() -> Calibration {
    calibration(Some("m/s^2"), 1.02, [0.1, -0.2, 0.05])
}

fn with_gyro(unit: &str) -> Calibration {
    let mut file = si();
    let value = serde_json::json!({
        "input_unit": unit, "output_unit": "rad/s", "bias": [0.5, -0.25, 0.125],
        "matrix": [[0.017, 0.001, 0.0], [0.0, 0.018, 0.0], [0.0, 0.0, 0.0175]],
        "scale": [58.0, 56.0, 57.0], "orientation": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        "g_sensitivity": [[0.01, 0.0, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.03]],
    });
    file.gyroscope = Some(serde_json::from_value(value).unwrap());
    file
}

fn options() -> ApplyOptions {
    ApplyOptions::default()
}

fn run_with(
    cal: &Calibration,
    bytes: &[u8],
    options: &ApplyOptions,
) -> Result<(String, ApplySummary)> {
    let input = from_reader(Box::new(io::Cursor::new(bytes.to_vec())), false).unwrap();
    let mut out = Vec::new();
    let summary = apply(cal, input, "rec.csv", &mut out, options)?;
    Ok((String::from_utf8_lossy(&out).into_owned(), summary))
}

fn run(cal: &Calibration, text: &str) -> (String, ApplySummary) {
    let (out, summary) = run_with(cal, text.as_bytes(), &options()).unwrap();
    assert_balances(&summary);
    (out, summary)
}

fn refused(cal: &Calibration, text: &str, options: &ApplyOptions) -> Error {
    run_with(cal, text.as_bytes(), options).unwrap_err()
}

fn assert_balances(summary: &ApplySummary) {
    let aside: u64 = summary.set_aside.iter().map(|s| s.lines).sum();
    assert_eq!(summary.lines, summary.rows + aside);
}

fn finding<'a>(summary: &'a ApplySummary, kind: &str) -> &'a Finding {
    let found = summary.findings.iter().find(|f| f.kind == kind);
    found.unwrap_or_else(|| panic!("no {kind} in {:?}", summary.findings))
}

/// `n` rows of a sensor at rest, after `header`.
fn still(header: &str, n: usize, row: impl Fn(usize) -> String) -> String {
    let rows: String = (0..n).map(|i| row(i) + "\n").collect();
    format!("{header}\n{rows}")
}

fn cells(line: &str) -> Vec<f64> {
    line.split(',').map(|c| c.parse().unwrap()).collect()
}

#[test]
fn values_equal_direct_computation() {
    let row = |i: usize| {
        let (sine, cosine) = (i as f64).sin_cos();
        let [x, y, z] = [0.1 + 0.01 * sine, -0.2 + 0.01 * cosine, 9.8 + 0.02 * sine];
        let (t_ms, u, w) = (10 * i, 20.0 * sine, -3.0 * sine);
        format!("{t_ms},{x:.4},{y:.4},{z:.4},{u:.3},{cosine:.3},{w:.3}")
    };
    let text = still("t_ms,ax,ay,az,gx (deg/s),gy (deg/s),gz (deg/s)", 50, row);
    let cal = with_gyro("deg/s");
    let (out, summary) = run(&cal, &text);
    let header = "t_ms,ax_mps2,ay_mps2,az_mps2,gx_rad_s,gy_rad_s,gz_rad_s";
    assert_eq!(out.lines().next(), Some(header));
    let accel = cal.accelerometer_calibration();
    let gyro = cal.gyroscope_calibration().unwrap();
    for (got, from) in out.lines().zip(text.lines()).skip(1) {
        let (got, from) = (cells(got), cells(from));
        assert_eq!(got[0], from[0]);
        let a = accel.apply([from[1], from[2], from[3]]);
        let w = gyro.apply([from[4], from[5], from[6]], a);
        for (got, expected) in got[1..].iter().zip(a.iter().chain(&w)) {
            // Rounding to six decimals.
            assert!((got - expected).abs() <= 0.500_001e-6, "{got} {expected}");
        }
    }
    let calibrated = GyroscopeOutcome::Calibrated(GyroUnit::DegreePerSecond);
    assert_eq!(summary.gyroscope, calibrated);
}

#[test]
fn axes_are_rotated_after_calibrating() {
    let text = still("ax,ay,az,gx (deg/s),gy (deg/s),gz (deg/s)", 3, |i| {
        format!("0.1,{}.2,9.8,1.5,-2.5,{i}.25", i % 2)
    });
    let (board, _) = run(&with_gyro("deg/s"), &text);
    let turned = ApplyOptions {
        axes: "x,-z,y".parse().unwrap(),
        ..options()
    };
    let (case, _) = run_with(&with_gyro("deg/s"), text.as_bytes(), &turned).unwrap();
    for (board, case) in board.lines().zip(case.lines()).skip(1) {
        let (b, c) = (cells(board), cells(case));
        assert_eq!(c, [b[0], -b[2], b[1], b[3], -b[5], b[4]]);
    }
}

#[test]
fn columns_without_a_header_are_named_by_channel() {
    let row = |i: usize| {
        let (t_ms, y) = (10 * i + i % 2, i % 3);
        format!("{t_ms},0.1,0.{y},9.8,25.{i},0.5,0.{i},0.2\n")
    };
    let text: String = (0..40).map(row).collect();
    let (out, summary) = run(&si(), &text);
    let header = "t,ax_mps2,ay_mps2,az_mps2,temperature,gx,gy,gz";
    assert_eq!(out.lines().next(), Some(header));
    assert_eq!((summary.lines, summary.rows), (40, 40));
}
