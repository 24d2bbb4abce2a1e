//! Readings that no sound sensor in the claimed unit gives.

use super::*;

#[test]
fn a_scale_15_percent_off() {
    let folder = six_files(&Sensor::default().scaled(1.15));
    poor(folder.path(), ". --gravity 9.81", "scale-off");
}

#[test]
fn a_bias_that_no_sensor_has() {
    let mut sensor = Sensor::default();
    sensor.bias[1] = 3.9;
    let folder = six_files(&sensor);
    // With −y up it reads 0.6 g: the unit has to be said.
    let line = ". --gravity 9.81 --accel-unit m/s^2";
    poor(folder.path(), line, "large-bias");
}

/// An MPU6050 in counts at ±2 g.
fn in_counts() -> Sensor {
    Sensor {
        unit: 16384.0 / 9.80665,
        decimals: 0,
        ..Sensor::default()
    }
}

#[test]
fn clipped_holds() {
    let folder = six_files(&in_counts());
    let mut labelled = "ax,ay,az,label\n".to_owned();
    for (name, _) in FACES {
        let text = read(folder.path(), &format!("{name}.csv"));
        for (i, line) in text.lines().enumerate().skip(1) {
            let (_, values) = line.split_once(',').unwrap();
            labelled += &match values.rsplit_once(',') {
                Some((before, _)) if name == "z_axis_pos" && (200..240).contains(&i) => {
                    format!("{before},32767,{name}\n")
                }
                _ => format!("{values},{name}\n"),
            };
        }
    }
    write(folder.path(), "labelled.csv", &labelled);
    poor(folder.path(), "labelled.csv --gravity 9.81", "clipped-pose");
}

#[test]
fn a_unit_that_nothing_tells() {
    let folder = six_files(&Sensor {
        unit: 3.3,
        ..Sensor::default()
    });
    let named = &["magnitude at rest"];
    refused(folder.path(), "calibrate .", 3, "unit-unknown", named);
}

#[test]
fn a_unit_that_gravity_contradicts_is_taken_as_told_and_poor() {
    let folder = six_files(&Sensor::default());
    let file = calibrate(folder.path(), ". --accel-unit g", 4);
    finding(&file, "unit-mismatch");
    finding(&file, "scale-off");
}

#[test]
fn files_in_different_units() {
    let folder = six_files(&Sensor::default());
    let other = Sensor {
        unit: 1.0 / 9.80665,
        ..Sensor::default()
    };
    let text = other.file([0.0, 0.0, -1.0], 500, 3);
    write(folder.path(), "z_axis_neg.csv", &text);
    let named = ["z_axis_neg.csv", "m/s^2"];
    refused(folder.path(), "calibrate .", 3, "units-differ", &named);
}
