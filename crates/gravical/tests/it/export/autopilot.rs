//! PX4, ArduPilot: parameter files read by their own rules, values used by the firmware's own formula.

use std::collections::HashMap;

use gravical::core::matrix3::{diagonal, inverse, mul, mul_vec, norm};

use super::*;

/// `(raw − offset) · scale`, raw in nominal m/s².
type Parameters = [Vector; 2];

/// Five columns separated by tabs, `#` before a comment.
fn px4(text: &str) -> HashMap<String, f64> {
    let row = |line: &str| {
        let columns: Vec<&str> = line.split('\t').collect();
        let ["1", "1", name, value, kind] = columns[..] else {
            panic!("{line}")
        };
        assert!(name.len() <= 16, "MAVLink cuts {name}");
        // 9: float, 6: int32.
        let is_kind = match kind {
            "6" => value.parse::<i32>().is_ok(),
            kind => kind == "9" && value.contains('.'),
        };
        assert!(is_kind, "{line}");
        (name.to_owned(), value.parse().unwrap())
    };
    text.lines()
        .filter(|l| !l.starts_with('#'))
        .map(row)
        .collect()
}

/// Name and value, separated by a comma.
fn ardupilot(text: &str) -> HashMap<String, f64> {
    let row = |line: &str| {
        let (name, value) = line.split_once(',').unwrap();
        (name.to_owned(), value.parse().unwrap())
    };
    text.lines()
        .filter(|l| !l.starts_with('#'))
        .map(row)
        .collect()
}

fn parameters(values: &HashMap<String, f64>, names: [&str; 2]) -> Parameters {
    names.map(|name| ["X", "Y", "Z"].map(|axis| values[&name.replace('*', axis)]))
}

fn of_px4(text: &str) -> Parameters {
    parameters(&px4(text), ["CAL_ACC0_*OFF", "CAL_ACC0_*SCALE"])
}

/// Directions on a spiral over the sphere.
fn sphere(count: usize) -> Vec<Vector> {
    let direction = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (sin, cos) = (2.399_963 * i as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        [across * cos, across * sin, z]
    };
    (0..count).map(direction).collect()
}

/// Raw values in nominal m/s² of forces.
fn measured(file: &Calibration, per_mps2: f64, force: Vector) -> Vector {
    let a = file.accelerometer_calibration();
    let raw = mul_vec(&inverse(&a.matrix).unwrap(), &force);
    std::array::from_fn(|i| (raw[i] + a.bias[i]) / per_mps2)
}

/// The mean square error over directions at 1 g, and the largest of the norm, m/s².
fn errors(file: &Calibration, per_mps2: f64, [offset, scale]: Parameters) -> [f64; 2] {
    let (mut square, mut worst) = (0.0, 0.0_f64);
    let directions = sphere(4000);
    for direction in &directions {
        let force = direction.map(|v| G * v);
        let raw = measured(file, per_mps2, force);
        let found: Vector = std::array::from_fn(|i| (raw[i] - offset[i]) * scale[i]);
        let error = std::array::from_fn(|i| found[i] - force[i]);
        square += norm::<f64>(&error).powi(2) / directions.len() as f64;
        worst = worst.max((norm(&found) - G).abs());
    }
    [square, worst]
}

#[test]
fn the_diagonal_is_the_best_one_and_its_loss_is_what_directions_show() {
    for (file, per_mps2) in [(in_counts(), 16384.0 / G), (in_g(), 1.0 / G)] {
        let result = written(&file, "px4");
        let best = of_px4(&result.text);
        let [square, worst] = errors(&file, per_mps2, best);
        for (which, axis) in [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)] {
            for step in [-1e-4, 1e-4] {
                let mut other = best;
                other[which][axis] += step * [10.0, 1.0][which];
                assert!(errors(&file, per_mps2, other)[0] > square, "{which} {axis}");
            }
        }
        let loss = result.notes.iter().find(|n| n.contains("mg rms")).unwrap();
        let numbers = loss.split(' ').filter_map(|w| w.parse::<f64>().ok());
        let said: Vec<f64> = numbers.skip(1).collect();
        for (said, shown) in said.iter().zip([square.sqrt(), worst]) {
            close(*said, 1e3 * shown / G, 0.02 * said);
        }
        assert_eq!(said.len(), 2, "{loss}");
        let values = ardupilot(&written(&file, "ardupilot").text);
        let same = parameters(&values, ["INS_ACCOFFS_*", "INS_ACCSCAL_*"]);
        assert_eq!(same, best);
    }
}

#[test]
fn without_its_id_a_calibration_has_no_effect_which_is_said() {
    let asks = |target, id| {
        let options = options_with(|o| o.device_id = id);
        let result = export_to(&in_g(), target, &options).unwrap();
        let asks = result
            .notes
            .iter()
            .any(|n| n.contains("Give this device id"));
        (asks, result.text)
    };
    assert!(asks("px4", None).0 && asks("ardupilot", None).0);
    let (asked, text) = asks("px4", Some(3_000_000_000));
    // A signed parameter with the same bits.
    assert_eq!(px4(&text)["CAL_ACC0_ID"], -1_294_967_296.0);
    assert!(!asked);
    let (asked, text) = asks("ardupilot", Some(2_753_028));
    assert_eq!(ardupilot(&text)["INS_ACC_ID"], 2_753_028.0);
    assert!(!asked);
}

#[test]
fn axes_in_another_order_are_the_same_sensor() {
    let straight = of_px4(&written(&in_g(), "px4").text);
    let turned_by = |turn: [Vector; 3]| {
        let mut file = in_g();
        file.accelerometer.matrix = mul(&turn, &file.accelerometer.matrix);
        export_to(&file, "px4", &ExportOptions::default())
    };
    let turned = turned_by([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]).unwrap();
    let mut notes = turned.notes.iter();
    assert!(notes.any(|n| n.contains("turns the sensor's axes")));
    for (a, b) in of_px4(&turned.text).iter().zip(straight) {
        (0..3).for_each(|i| close(a[i], b[i], 1e-8));
    }
    for none in [
        diagonal([-1.0; 3]),
        [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]],
    ] {
        assert_eq!(turned_by(none).unwrap_err().code(), "export-target");
    }
}
