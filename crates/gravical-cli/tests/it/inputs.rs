//! The shapes in which a session is given to the program.

use std::io::Write;
use std::process::{Command, Stdio};

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
fn standard_input_is_a_recording() {
    let text = Sensor::default().file([0.0, 1.0, 0.0], 400, 2);
    let mut child = Command::new(program())
        .args(["inspect", "-", "--json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child
        .stdin
        .take()
        .unwrap()
        .write_all(text.as_bytes())
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let looked = &value["recordings"][0];
    assert_eq!(looked["file"], "-");
    assert_eq!(looked["row_counts"]["rows"], 400);
    assert_eq!(looked["static_intervals"][0]["face"], "+y");
}

#[test]
fn a_label_column_is_a_session() {
    let sensor = Sensor::default();
    let labels = ["x_p", "x_a", "y_p", "y_a", "z_p", "z_a"];
    let mut text = "part,acc_x,acc_y,acc_z\n".to_owned();
    for (i, ((_, up), label)) in FACES.iter().zip(labels).enumerate() {
        for row in sensor.hold(*up, 300, i as u64) {
            text += &format!("{label},{:.4},{:.4},{:.4}\n", row[0], row[1], row[2]);
        }
    }
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "labelled.csv", &text);
    fits(
        &calibrate(folder.path(), "labelled.csv --gravity 9.81", 0),
        &sensor,
    );
    let looked = run_in(folder.path(), words("inspect labelled.csv --json")).json();
    assert_eq!(looked["recordings"][0]["labels"][3][0], "y_a");
    assert_eq!(looked["recordings"][0]["labels"][3][1], 300);
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
fn gravity_from_latitude_and_by_default() {
    let folder = six_files(&Sensor::default());
    let file = calibrate(folder.path(), ". --latitude 30.0444 --altitude 23", 0);
    close(file["gravity_mps2"].as_f64().unwrap(), 9.793211, 1e-6);
    assert_eq!(file["gravity_source"], "latitude");
    let file = calibrate(folder.path(), ".", 0);
    assert_eq!(file["gravity_source"], "standard");
    finding(&file, "gravity-assumed");
}

#[test]
fn counts_about_a_zero_offset_keep_the_files_own_numbers() {
    let sensor = Sensor {
        unit: 16384.0 / 9.80665,
        decimals: 0,
        ..Sensor::default()
    };
    let plain = six_files(&sensor);
    let shifted = tempfile::tempdir().unwrap();
    for (name, _) in FACES {
        let text = std::fs::read_to_string(plain.path().join(format!("{name}.csv"))).unwrap();
        let moved: String = text
            .lines()
            .enumerate()
            .map(|(i, l)| {
                if i == 0 {
                    return format!("{l}\n");
                }
                let (t, rest) = l.split_once(',').unwrap();
                let counts: Vec<String> = rest
                    .split(',')
                    .map(|c| (c.parse::<i64>().unwrap() + 1000).to_string())
                    .collect();
                format!("{t},{}\n", counts.join(","))
            })
            .collect();
        write(shifted.path(), &format!("{name}.csv"), &moved);
    }
    let one = calibrate(plain.path(), ". --gravity 9.81", 0);
    let other = calibrate(shifted.path(), ". --gravity 9.81 --zero-offset 1000", 0);
    let (a, b) = (&one["accelerometer"], &other["accelerometer"]);
    for i in 0..3 {
        let (plain, moved) = (&a["bias"][i], &b["bias"][i]);
        close(
            moved.as_f64().unwrap(),
            plain.as_f64().unwrap() + 1000.0,
            1e-9,
        );
    }
    assert_eq!(a["scale"], b["scale"]);
}
