//! The shapes in which a session is given to the program.

use std::io::Write;

use crate::support::*;

fn fits(file: &serde_json::Value, sensor: &Sensor) {
    let a = &file["accelerometer"];
    for i in 0..3 {
        close(a["bias"][i].as_f64().unwrap(), sensor.bias[i], 0.01);
        let norm = sensor.matrix[i].iter().map(|v| v * v).sum::<f64>().sqrt();
        close(a["scale"][i].as_f64().unwrap(), norm, 0.001);
    }
}

#[test]
fn a_folder_and_its_files_in_any_order_are_the_same() {
    let sensor = Sensor::default();
    let folder = six_files(&sensor);
    let whole = calibrate(folder.path(), ". --gravity 9.81", 0);
    fits(&whole, &sensor);
    let names: Vec<String> = FACES.iter().rev().map(|f| format!("{}.csv", f.0)).collect();
    let listed = calibrate(
        folder.path(),
        &format!("{} --gravity 9.81", names.join(" ")),
        0,
    );
    same_accelerometer(&listed["accelerometer"], &whole["accelerometer"]);
}

#[test]
fn packed_files_are_read() {
    let sensor = Sensor::default();
    let folder = six_files(&sensor);
    for (name, _) in FACES {
        let plain = folder.path().join(format!("{name}.csv"));
        let packed = std::fs::File::create(folder.path().join(format!("{name}.csv.gz"))).unwrap();
        let mut gz = flate2::write::GzEncoder::new(packed, flate2::Compression::fast());
        gz.write_all(&std::fs::read(&plain).unwrap()).unwrap();
        gz.finish().unwrap();
        std::fs::remove_file(plain).unwrap();
    }
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    fits(&file, &sensor);
    assert_eq!(faces(&file).len(), 6);
}

#[test]
fn a_name_that_says_plus_z_while_it_lay_on_minus_z_is_overruled() {
    let sensor = Sensor::default();
    let folder = six_files(&sensor);
    let path = |n: &str| folder.path().join(n);
    std::fs::rename(path("z_axis_pos.csv"), path("flat.csv")).unwrap();
    std::fs::rename(path("z_axis_neg.csv"), path("z_axis_pos.csv")).unwrap();
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    fits(&file, &sensor);
    let reported = finding(&file, "orientation-mismatch");
    assert!(
        reported["file"]
            .as_str()
            .unwrap()
            .ends_with("z_axis_pos.csv")
    );
    let message = reported["message"].as_str().unwrap();
    assert!(message.contains("claims +z, but -z points up"), "{message}");
}

#[test]
fn six_files_with_a_wrong_header_are_a_session() {
    // The header of the student report's logger is wrong about both units.
    let folder = tempfile::tempdir().unwrap();
    let made = run_in(
        folder.path(),
        words(
            "simulate six-position --hold 4 --tilt 0.2 -o six --quiet --seed 3 --temperature-drift 0 --wrong-header",
        ),
    );
    assert_eq!(made.code, 0, "{}", made.err);
    let file = calibrate(folder.path(), "six", 0);
    let truth = std::fs::read_to_string(folder.path().join("six/truth.json")).unwrap();
    let truth: serde_json::Value = serde_json::from_str(&truth).unwrap();
    let bias = numbers(&truth["accelerometer"]["bias_mps2"]);
    for (got, want) in numbers(&file["accelerometer"]["bias"]).iter().zip(bias) {
        close(*got, want, 0.01);
    }
    assert!(
        finding(&file, "unit-mismatch")["message"]
            .as_str()
            .unwrap()
            .contains("the header gives g")
    );
    close(file["temperature_c"]["mean"].as_f64().unwrap(), 25.7, 1.0);
}

#[test]
fn counts_about_a_zero_offset_keep_the_files_own_numbers() {
    let sensor = Sensor {
        unit: 16384.0 / 9.80665,
        decimals: 0,
        ..Sensor::default()
    };
    let shifted = Sensor {
        bias: sensor.bias.map(|b| b + 1000.0 / sensor.unit),
        ..sensor.clone()
    };
    let one = calibrate(six_files(&sensor).path(), ". --gravity 9.81", 0);
    let line = ". --gravity 9.81 --zero-offset 1000";
    let other = calibrate(six_files(&shifted).path(), line, 0);
    let (a, b) = (&one["accelerometer"], &other["accelerometer"]);
    for (plain, moved) in numbers(&a["bias"]).iter().zip(numbers(&b["bias"])) {
        close(moved, plain + 1000.0, 1e-9);
    }
    assert_eq!(a["scale"], b["scale"]);
}
