//! PX4, ArduPilot: parameter files read by their own rules, values used by the
//! firmware's own formula.

use std::collections::HashMap;

use super::*;
use crate::truth::sphere;

/// The diagonal model by normal equations over a dense sphere, worked out here on its own.
fn diagonal_fit(file: &CalibrationFile, per_mps2: f64) -> (Vector, Vector) {
    let (matrix, bias) = nominal(file, per_mps2);
    let model = inverse(&matrix).unwrap();
    // Per axis: least squares of scale · r + shift against f, r and f over directions.
    let mut sums = [[0.0_f64; 5]; 3];
    for f in sphere(20_000).into_iter().map(|n| n.map(|v| G * v)) {
        for i in 0..3 {
            let r = bias[i] + (0..3).map(|j| model[i][j] * f[j]).sum::<f64>();
            let terms = [1.0, r, r * r, f[i], r * f[i]];
            for (sum, term) in sums[i].iter_mut().zip(terms) {
                *sum += term;
            }
        }
    }
    let scale = sums.map(|[n, r, rr, f, rf]| (n * rf - r * f) / (n * rr - r * r));
    let offset = std::array::from_fn(|i| {
        let [n, r, _, f, _] = sums[i];
        (r - f / scale[i]) / n
    });
    (offset, scale)
}

/// `(raw − offset) · scale` of the file against the fit of this test, to 1e-6 of full scale (and
/// what the sphere of the test differs from a sphere by).
fn corrects_alike(offset: Vector, scale: Vector, fit: (Vector, Vector)) {
    let size = 40.0;
    for raw in vectors(14, size) {
        for i in 0..3 {
            let wanted = (raw[i] - fit.0[i]) * fit.1[i];
            close((raw[i] - offset[i]) * scale[i], wanted, 1e-6 * size);
        }
    }
}

fn three(values: &HashMap<String, f64>, name: impl Fn(&str) -> String) -> Vector {
    ["X", "Y", "Z"].map(|axis| values[&name(axis)])
}

/// QGroundControl: five columns separated by tabs, `#` before a comment.
fn params(text: &str) -> HashMap<String, f64> {
    text.lines()
        .filter(|l| !l.starts_with('#'))
        .map(|l| {
            let columns: Vec<&str> = l.split('\t').collect();
            let [vehicle, component, name, value, kind] = columns[..] else {
                panic!("{l}");
            };
            assert_eq!((vehicle, component), ("1", "1"));
            assert!(name.len() <= 16, "MAVLink cuts {name}");
            // 9: float, 6: int32.
            match kind {
                "6" => assert!(value.parse::<i32>().is_ok(), "{l}"),
                "9" => assert!(value.contains('.'), "{l}"),
                _ => panic!("{l}"),
            }
            (name.to_owned(), value.parse().unwrap())
        })
        .collect()
}

#[test]
fn px4_corrects_like_the_diagonal_fit() {
    for (file, per_mps2) in [(in_counts(), 16384.0 / G), (in_g(), 1.0 / G)] {
        let result = written(&file, "px4");
        let values = params(&result.text);
        assert_eq!(values.len(), 6);
        assert!(result.notes.iter().any(|n| n.contains("CAL_ACC0_ID")));
        corrects_alike(
            three(&values, |a| format!("CAL_ACC0_{a}OFF")),
            three(&values, |a| format!("CAL_ACC0_{a}SCALE")),
            diagonal_fit(&file, per_mps2),
        );
    }
    let options = options_with(|o| o.device_id = Some(3_000_000_000));
    let result = export_to(&in_g(), "px4", &options).unwrap();
    // A signed parameter with the same bits.
    assert_eq!(params(&result.text)["CAL_ACC0_ID"], -1_294_967_296.0);
    assert!(!result.text.contains("Give this device id"));
}

/// Mission Planner and MAVProxy: name and value, separated by a comma.
fn param(text: &str) -> HashMap<String, f64> {
    text.lines()
        .filter(|l| !l.starts_with('#'))
        .map(|l| {
            let (name, value) = l.split_once(',').unwrap();
            (name.to_owned(), value.parse().unwrap())
        })
        .collect()
}

#[test]
fn ardupilot_corrects_like_the_diagonal_fit() {
    let file = in_counts();
    let options = options_with(|o| o.device_id = Some(2_753_028));
    let values = param(&export_to(&file, "ardupilot", &options).unwrap().text);
    assert_eq!(values.len(), 7);
    assert_eq!(values["INS_ACC_ID"], 2_753_028.0);
    let offset = three(&values, |a| format!("INS_ACCOFFS_{a}"));
    let scale = three(&values, |a| format!("INS_ACCSCAL_{a}"));
    corrects_alike(offset, scale, diagonal_fit(&file, 16384.0 / G));
    // The vehicle's x is the sensor's y, its y the sensor's −x.
    let options = options_with(|o| o.rotation = Some("y,-x,z".parse().unwrap()));
    let turned = param(&export_to(&file, "ardupilot", &options).unwrap().text);
    let sign = |v: Vector| [v[1], -v[0], v[2]];
    assert_eq!(three(&turned, |a| format!("INS_ACCOFFS_{a}")), sign(offset));
    assert_eq!(
        three(&turned, |a| format!("INS_ACCSCAL_{a}")),
        [scale[1], scale[0], scale[2]]
    );
}

#[test]
fn the_loss_is_what_directions_show() {
    let file = in_g();
    let result = written(&file, "px4");
    let values = params(&result.text);
    let offset = three(&values, |a| format!("CAL_ACC0_{a}OFF"));
    let scale = three(&values, |a| format!("CAL_ACC0_{a}SCALE"));
    let (matrix, bias) = nominal(&file, 1.0 / G);
    let model = inverse(&matrix).unwrap();
    let (mut sum, mut worst, mut norm) = (0.0, 0.0_f64, 0.0_f64);
    let directions = sphere(4000);
    for u in &directions {
        let out: Vector = std::array::from_fn(|i| {
            let raw = bias[i] + (0..3).map(|j| model[i][j] * G * u[j]).sum::<f64>();
            (raw - offset[i]) * scale[i] / G
        });
        let error: f64 = (0..3).map(|i| (out[i] - u[i]).powi(2)).sum();
        sum += error;
        worst = worst.max(error.sqrt());
        norm = norm.max((out.iter().map(|v| v * v).sum::<f64>().sqrt() - 1.0).abs());
    }
    let numbers = result.notes[0].split(' ').filter_map(|w| w.parse().ok());
    let said: Vec<f64> = numbers.skip(1).collect();
    let shown = [(sum / directions.len() as f64).sqrt(), worst, norm];
    for (said, shown) in said.iter().zip(shown) {
        close(*said, 1e3 * shown, 50.0 * shown);
    }
    assert_eq!(said.len(), 3);
}

#[test]
fn axes_in_another_order_are_the_same_sensor() {
    let straight = params(&written(&in_g(), "px4").text);
    let turned_by = |turn: Matrix| {
        let mut file = in_g();
        file.accelerometer.matrix = mul(&turn, &file.accelerometer.matrix);
        export_to(&file, "px4", &ExportOptions::default())
    };
    let turned = turned_by([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]).unwrap();
    assert!(turned.notes[1].contains("turns the sensor's axes"));
    assert_eq!(params(&turned.text), straight);
    for none in [
        diagonal([-1.0; 3]),
        [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]],
    ] {
        assert_eq!(turned_by(none).unwrap_err().code(), "export-target");
    }
}
