//! Folders with other things in them, files that are no placement, and hints
//! followed to the letter.

use std::path::Path;

use crate::support::*;
use serde_json::Value;

const LICENCE: &str = "Permission is hereby granted, free of charge, to any person obtaining a copy\n\
    of this software, to deal in it without restriction, including 1, 2, 3, 4 and 5.\n\
    1 2 3 4 5\nTHE SOFTWARE IS PROVIDED AS IS, WITHOUT WARRANTY OF ANY KIND, EXPRESS OR\n\
    IMPLIED.\n";

fn gyroscope(rows: usize, from_ms: usize) -> String {
    let row = |i| format!("{},0.00{},0.002,-0.001\n", from_ms + 10 * i, i % 3);
    "t_ms,gx,gy,gz\n".to_owned() + &(0..rows).map(row).collect::<String>()
}

/// The one finding of a kind: its file and its message.
fn only<'a>(value: &'a Value, kind: &str) -> (&'a str, &'a str) {
    let of_kind = kinds(value).into_iter().filter(|k| *k == kind);
    assert_eq!(of_kind.count(), 1, "{kind}: {value}");
    let found = finding(value, kind);
    (
        found["file"].as_str().unwrap_or(""),
        text(&found["message"]),
    )
}

/// The call is refused with this code; the message.
fn refused(folder: &Path, line: &str, code: &str) -> String {
    text(&fails(folder, line, 3, code)["message"]).to_owned()
}

#[test]
fn serial_numbers_go_into_the_calibration_and_two_are_no_session() {
    let folder = six_files(&Sensor::default());
    let at = folder.path();
    let name = |file: &str, serial: &str| {
        let text = format!("Serial Number: {serial}\n{}", read(at, file));
        write(at, file, &text);
    };
    name("x_axis_pos.csv", "MOS2D12345678");
    name("y_axis_pos.csv", "MOS2D12345678");
    let file = calibrate(at, ". --gravity 9.81", 0);
    assert_eq!(file["sensor"]["id"], "MOS2D12345678");
    name("z_axis_pos.csv", "MOS2D999");
    let said = refused(at, "calibrate . --gravity 9.81", "sensors-differ");
    assert!(said.contains("MOS2D999") && said.contains("z_axis_pos.csv"));
    // The hint, followed.
    let file = calibrate(at, ". --gravity 9.81 --sensor-id 7", 0);
    assert_eq!(file["sensor"]["id"], "7");
}

#[test]
fn what_else_is_in_a_folder_costs_nothing() {
    let sensor = Sensor::default();
    let folder = six_files(&sensor);
    let at = folder.path();
    let clean = calibrate(at, ". --gravity 9.81 -o cal.json", 0);
    write(at, "LICENSE.txt", LICENCE);
    write(at, "README.txt", "Six poses, 1 Hz\n");
    let seen = json(at, "inspect .", 0);
    assert_eq!(list(&seen["recordings"]).len(), 6);
    let row = |i| format!("{},{},0.02,-0.01\n", 10 * i, 0.01 * f64::from(i % 7));
    let rows = "t_ms,ax,ay,az\n".to_owned() + &(0..500).map(row).collect::<String>();
    write(at, "LinearAcceleration.csv", &rows);
    write(at, "gyro.csv", &gyroscope(500, 0));
    std::fs::create_dir(at.join("older")).unwrap();
    write_six_files(&at.join("older"), &sensor);
    let file = calibrate(at, ". --gravity 9.81", 0);
    // But for rounding: the order of the placements is another.
    for key in ["bias", "scale", "matrix"] {
        let [found, wanted] = [&file, &clean].map(|f| numbers(&f["accelerometer"][key]));
        agree(&found, &wanted, 1e-9, key);
    }
    let left_out = kinds(&file).into_iter().filter(|k| *k == "no-recording");
    assert_eq!(left_out.count(), 3);
    assert!(file["findings"].to_string().contains("gravity"));
    only(&file, "gyro-left-out");
    assert!(only(&file, "folder-left-out").0.ends_with("older"));
}

#[test]
fn the_gyroscope_of_the_only_recording_is_joined() {
    let folder = six_files(&Sensor::default());
    let at = folder.path();
    calibrate(at, ". --gravity 9.81 -o cal.json", 0);
    std::fs::create_dir(at.join("one")).unwrap();
    let session = Sensor::default().file(FACES[4].1, 500, 3);
    write(at, "one/session.csv", &session);
    write(at, "one/gyro.csv", &gyroscope(500, 0));
    // One placement is too few, whatever the gyroscope is.
    refused(at, "calibrate one", "underdetermined");
    let checked = || run_in(at, words("check cal.json one --json")).json();
    only(&checked(), "gyro-joined");
    write(at, "one/gyro.csv", &gyroscope(500, 900_000));
    let apart = checked();
    let (file, why) = only(&apart, "gyro-left-out");
    assert!(file.ends_with("gyro.csv") && why.contains("session.csv"));
    // A recording of the calibration, known by its checksum, does not count beside a new one.
    let both = json(at, "check cal.json z_axis_pos.csv one/session.csv", 0);
    finding(&both, "same-recordings");
    assert_eq!(both["verdict"]["judgement"], "agrees");
    let counts = list(&both["static_intervals"]).map(|s| s["counts"] == true);
    assert_eq!(counts.collect::<Vec<_>>(), [false, true]);
    ends(at, "check cal.json one/session.csv --gravity 20", 2);
    ends(at, "compare cal.json missing.json", 3);
}

/// Signs of a phone, and a board that lies turned in its case, where what is called x lies along the
/// board's y, and y along its −x: the axes that are printed mend both.
#[test]
fn names_that_do_not_fit_are_mended_by_the_axes_that_are_printed() {
    let reversed = "x_axis_neg x_axis_pos y_axis_neg y_axis_pos z_axis_neg z_axis_pos";
    let turned = "y_axis_neg y_axis_pos x_axis_pos x_axis_neg z_axis_pos z_axis_neg";
    for (called, kind) in [(reversed, "names-reversed"), (turned, "names-turned")] {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        for (name, (i, (_, up))) in called.split(' ').zip(FACES.iter().enumerate()) {
            let text = Sensor::default().file(*up, 500, 100 + i as u64);
            write(at, &format!("{name}.csv"), &text);
        }
        let file = calibrate(at, ". --gravity 9.81", 0);
        let map = text(&finding(&file, kind)["options"][0]["value"]);
        assert!(kind != "names-reversed" || map == "-x,-y,-z", "{map}");
        let mended = calibrate(at, &format!(". --gravity 9.81 --axes {map}"), 0);
        let of_names = |k: &&str| k.starts_with("names-") || *k == "orientation-mismatch";
        assert!(!kinds(&mended).iter().any(of_names), "{mended}");
    }
}

#[test]
fn a_name_that_says_plus_z_while_it_lay_on_minus_z_is_overruled() {
    let sensor = Sensor::default();
    let folder = six_files(&sensor);
    let path = |name: &str| folder.path().join(name);
    std::fs::rename(path("z_axis_pos.csv"), path("flat.csv")).unwrap();
    std::fs::rename(path("z_axis_neg.csv"), path("z_axis_pos.csv")).unwrap();
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    let bias = numbers(&file["accelerometer"]["bias"]);
    for (found, put) in bias.iter().zip(sensor.bias) {
        close(*found, put, 0.01);
    }
    let (file, said) = only(&file, "orientation-mismatch");
    assert!(file.ends_with("z_axis_pos.csv"), "{file}");
    assert!(said.contains("claims +z, but -z points up"), "{said}");
}

#[test]
fn counts_about_a_zero_offset_keep_the_files_own_numbers() {
    let sensor = crate::bad_input::in_counts();
    let mut shifted = sensor.clone();
    shifted.bias = sensor.bias.map(|b| b + 1000.0 / sensor.unit);
    let one = calibrate(six_files(&sensor).path(), ". --gravity 9.81", 0);
    let line = ". --gravity 9.81 --zero-offset 1000";
    let other = calibrate(six_files(&shifted).path(), line, 0);
    let (a, b) = (&one["accelerometer"], &other["accelerometer"]);
    for (plain, moved) in numbers(&a["bias"]).iter().zip(numbers(&b["bias"])) {
        close(moved, plain + 1000.0, 1e-9);
    }
    assert_eq!(a["scale"], b["scale"]);
}

#[test]
fn names_with_a_dash_and_paths_with_a_space_do_as_they_are_printed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for ((_, up), name) in FACES.iter().zip(["+x", "-x", "+y", "-y", "+z", "-z"]) {
        let text = Sensor::default().file(*up, 500, 8);
        write(at, &format!("{name}.csv"), &text);
    }
    for option in ["--face-pose", "--free-pose"] {
        calibrate(at, &format!(". --gravity 9.81 {option} -x"), 0);
    }
    let said = run_in(at, ["calibrate", ".", "-o", "my cal.json"]).out;
    assert!(said.contains("gravical apply \"my cal.json\" "), "{said}");
}

/// What shakes throughout has no rest, however quiet its quietest part is beside the others.
#[test]
fn what_is_never_at_rest_is_told_why() {
    let folder = six_files(&Sensor::default());
    // Put down for 0.4 s, and then turned over and over.
    let mut swung = "t_ms,ax,ay,az\n".to_owned();
    for i in 0..500 {
        let (sine, cosine) = (0.05 * f64::from((i - 40).max(0))).sin_cos();
        swung += &format!("{},{:.3},{:.3},0.4\n", 10 * i, 9.81 * sine, 9.81 * cosine);
    }
    write(folder.path(), "y_axis_pos.csv", &swung);
    let at = folder.path();
    let said = refused(at, "calibrate . --method ferraris", "missing-face");
    let cause = "y_axis_pos.csv: y_axis_pos is never at rest in lines 2 to 501";
    assert!(said.contains(cause), "{said}");

    let mut walk = "t_ms,ax,ay,az\n".to_owned();
    for i in 0..1000 {
        let step = 2.0 * (0.7 * f64::from(i)).sin();
        walk += &format!("{},{:.3},0.1,{:.3}\n", 10 * i, 0.5 * step, 9.81 + step);
    }
    write(at, "walk.csv", &walk);
    let why = "where it is quietest each axis moves by 0.9 m/s² rms, at rest by less than 0.3";
    let said = refused(at, "calibrate walk.csv", "never-static");
    assert!(said.contains(why), "{said}");
}

#[test]
fn the_recording_of_another_sensor_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (seed, name) in [(1, "a"), (2, "b"), (1, "c")] {
        let line = format!("simulate poses -o {name} --seed {seed} --hold 2 --free 4 -q");
        ends(at, &line, 0);
    }
    let said = refused(at, "calibrate a/poses.csv b/poses.csv", "sensors-differ");
    assert!(said.contains("b/poses.csv"), "{said}");
    // One sensor twice.
    run_in(at, words("calibrate a/poses.csv c/poses.csv --json")).calibration();
}
