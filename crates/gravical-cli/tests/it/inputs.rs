//! The shapes in which a session is given to the program.

use crate::support::*;

#[test]
fn a_name_that_says_plus_z_while_it_lay_on_minus_z_is_overruled() {
    let sensor = Sensor::default();
    let folder = six_files(&sensor);
    let path = |n: &str| folder.path().join(n);
    std::fs::rename(path("z_axis_pos.csv"), path("flat.csv")).unwrap();
    std::fs::rename(path("z_axis_neg.csv"), path("z_axis_pos.csv")).unwrap();
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    for (found, put) in numbers(&file["accelerometer"]["bias"])
        .iter()
        .zip(sensor.bias)
    {
        close(*found, put, 0.01);
    }
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
