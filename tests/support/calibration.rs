//! A calibration made by hand.

use gravical::calibration_file::{Calibration, from_imucal};
use gravical::core::matrix3::{diagonal, unit};
use gravical::recording::{AccelUnit, GyroUnit};
use serde_json::json;

/// g₀ in m/s².
pub const G: f64 = 9.80665;

/// A sensor with every kind of error, in counts of a range.
pub fn in_counts(counts_per_g: f64, counts_per_deg_s: f64) -> Calibration {
    let mut file = made(counts_per_g / G, counts_per_deg_s);
    file.accelerometer.input_unit = AccelUnit::Counts;
    file.accelerometer.nominal_scale = Some(counts_per_g / G);
    file.gyroscope.as_mut().unwrap().input_unit = GyroUnit::Counts;
    file
}

/// A sensor with every kind of error; `per_mps2` and `per_deg_s` are its nominal scales.
pub fn made(per_mps2: f64, per_deg_s: f64) -> Calibration {
    let times = |v: [f64; 3], by: f64| v.map(|x| x * by);
    let k_ga = [
        [0.01, 0.002, -0.003],
        [0.0, -0.02, 0.004],
        [0.001, 0.0, 0.015],
    ];
    let r_a = [
        [0.9998, 0.02, -0.01],
        [0.013, 0.9999, 0.007],
        [-0.016, 0.004, 0.9998],
    ];
    let r_g = [
        [0.9999, -0.008, 0.011],
        [0.006, 0.9999, -0.012],
        [0.009, 0.003, 0.9999],
    ];
    let value = json!({
        "K_a": diagonal(times([1.012, 0.993, 1.021], per_mps2)),
        "R_a": (r_a.map(|row: [f64; 3]| unit(&row))),
        "b_a": times([0.31, -0.42, 0.55], per_mps2),
        "K_g": diagonal(times([0.991, 1.004, 1.013], per_deg_s)),
        "R_g": (r_g.map(|row: [f64; 3]| unit(&row))),
        "K_ga": k_ga.map(|row| times(row, per_deg_s)),
        "b_g": times([1.3, -2.4, 0.7], per_deg_s),
        "cal_type": "Ferraris",
        "_format_version": "2.0.0"
    });
    from_imucal(&value).unwrap()
}
