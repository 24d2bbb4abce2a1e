//! Folders with other things in them, files that are no placement, and hints
//! followed to the letter.

use crate::support::*;

const LICENCE: &str = "Permission is hereby granted, free of charge, to any person obtaining a copy\n\
    of this software, to deal in it without restriction, including 1, 2, 3, 4 and 5.\n\
    1 2 3 4 5\nTHE SOFTWARE IS PROVIDED AS IS, WITHOUT WARRANTY OF ANY KIND, EXPRESS OR\n\
    IMPLIED.\n";

fn gyroscope(rows: usize, from_ms: usize) -> String {
    let mut text = "t_ms,gx,gy,gz\n".to_owned();
    for i in 0..rows {
        text += &format!(
            "{},{},0.002,-0.001\n",
            from_ms + 10 * i,
            0.001 * (i % 3) as f64
        );
    }
    text
}

/// Findings of a kind: file and message of each.
fn reported<'a>(value: &'a serde_json::Value, kind: &str) -> Vec<(&'a str, &'a str)> {
    let all = value["findings"].as_array().unwrap().iter();
    all.filter(|f| f["kind"] == kind)
        .map(|f| {
            (
                f["file"].as_str().unwrap_or(""),
                f["message"].as_str().unwrap(),
            )
        })
        .collect()
}

#[test]
fn acceleration_without_gravity_is_left_out_beside_that_with_it() {
    let folder = six_files(&Sensor::default());
    let clean = calibrate(folder.path(), ". --gravity 9.81", 0);
    let mut text = "t_ms,ax,ay,az\n".to_owned();
    for i in 0..500 {
        text += &format!("{},{},0.02,-0.01\n", 10 * i, 0.01 * (i % 7) as f64);
    }
    write(folder.path(), "LinearAcceleration.csv", &text);
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    same_accelerometer(&file["accelerometer"], &clean["accelerometer"]);
    let [(what, why)] = reported(&file, "no-recording")[..] else {
        panic!("{file}")
    };
    assert!(
        what.ends_with("LinearAcceleration.csv") && why.contains("gravity"),
        "{why}"
    );
    // Alone it is refused.
    let run = run_in(
        folder.path(),
        words("calibrate LinearAcceleration.csv --json"),
    );
    assert_eq!(run.code, 3);
}

#[test]
fn serial_numbers_go_into_the_calibration_and_two_are_no_session() {
    let folder = six_files(&Sensor::default());
    let name = |file: &str, serial: &str| {
        let text = std::fs::read_to_string(folder.path().join(file)).unwrap();
        write(
            folder.path(),
            file,
            &format!("Serial Number: {serial}\n{text}"),
        );
    };
    name("x_axis_pos.csv", "MOS2D12345678");
    name("y_axis_pos.csv", "MOS2D12345678");
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    assert_eq!(file["sensor"]["id"], "MOS2D12345678");
    let seen = run_in(folder.path(), words("inspect x_axis_pos.csv --json")).json();
    assert_eq!(seen["recordings"][0]["serial"], "MOS2D12345678");

    name("z_axis_pos.csv", "MOS2D999");
    let run = run_in(folder.path(), words("calibrate . --gravity 9.81 --json"));
    assert_eq!(
        (run.code, run.error_code()),
        (3, "sensors-differ".to_owned())
    );
    let said = run.json().to_string();
    assert!(
        said.contains("MOS2D999") && said.contains("z_axis_pos.csv"),
        "{said}"
    );
    // The hint, followed.
    let file = calibrate(folder.path(), ". --gravity 9.81 --sensor-id 7", 0);
    assert_eq!(file["sensor"]["id"], "7");
}

#[test]
fn what_else_is_in_a_folder_costs_nothing() {
    let sensor = Sensor::default();
    let folder = six_files(&sensor);
    let clean = calibrate(folder.path(), ". --gravity 9.81 -o cal.json", 0);
    write(folder.path(), "LICENSE.txt", LICENCE);
    write(folder.path(), "README.txt", "Six poses, 1 Hz\n");
    write(folder.path(), "gyro.csv", &gyroscope(500, 0));
    std::fs::create_dir(folder.path().join("older")).unwrap();
    write_six_files(&folder.path().join("older"), &sensor);
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    same_accelerometer(&file["accelerometer"], &clean["accelerometer"]);
    assert_eq!(reported(&file, "no-recording").len(), 2);
    let [(_, why)] = reported(&file, "gyro-left-out")[..] else {
        panic!("{file}")
    };
    assert!(why.contains("--gyro"), "{why}");
    let [(what, _)] = reported(&file, "folder-left-out")[..] else {
        panic!("{file}")
    };
    assert!(what.ends_with("older"), "{what}");
    // The files by name, as a shell expands them.
    let names = FACES.map(|(name, _)| format!("{name}.csv")).join(" ");
    let listed = calibrate(
        folder.path(),
        &format!("{names} gyro.csv --gravity 9.81"),
        0,
    );
    assert_eq!(reported(&listed, "gyro-left-out").len(), 1);
    let seen = run_in(folder.path(), words("inspect . --json")).json();
    assert_eq!(seen["recordings"].as_array().unwrap().len(), 6);
}

#[test]
fn the_gyroscope_of_the_only_recording_is_joined() {
    let folder = tempfile::tempdir().unwrap();
    let hold = Sensor::default().file(FACES[4].1, 500, 3);
    write(folder.path(), "session.csv", &hold);
    write(folder.path(), "gyro.csv", &gyroscope(500, 0));
    let at = |line: &str| run_in(folder.path(), words(line));
    let error = at("calibrate . --json");
    // One placement is too few, whatever the gyroscope is.
    assert_eq!(error.error_code(), "underdetermined");
    let cal = six_files(&Sensor::default());
    calibrate(cal.path(), ". --gravity 9.81 -o cal.json", 0);
    let line = format!("check {} . --json", cal.path().join("cal.json").display());
    let joined = at(&line).json();
    assert_eq!(reported(&joined, "gyro-joined").len(), 1, "{joined}");
    write(folder.path(), "gyro.csv", &gyroscope(500, 900_000));
    let apart = at(&line).json();
    let [(file, why)] = reported(&apart, "gyro-left-out")[..] else {
        panic!("{apart}")
    };
    assert!(
        file.ends_with("gyro.csv") && why.contains("session.csv"),
        "{why}"
    );
}

#[test]
fn a_file_per_axis_may_hold_its_two_poses() {
    let sensor = Sensor::default();
    let folder = tempfile::tempdir().unwrap();
    let names = ["accel_x.csv", "accel_y.csv", "accel_z.csv"];
    write(folder.path(), "gyro.csv", &gyroscope(500, 0));
    for (axis, name) in names.iter().enumerate() {
        let hold = |up: usize| sensor.file(FACES[2 * axis + up].1, 500, (7 * axis + up) as u64);
        let second = hold(1);
        let second = second.split_once('\n').unwrap().1;
        write(folder.path(), name, &format!("{}\n\n{second}", hold(0)));
    }
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    assert_eq!(faces(&file).len(), 6);
}

#[test]
fn a_file_per_channel_is_one_recording_of_three() {
    let sensor = Sensor::default();
    let rows: Vec<[f64; 3]> = (FACES.iter().enumerate())
        .flat_map(|(i, face)| {
            // Taken up by hand before.
            let hand = (0..150).map(|k| [3.0, 5.0, 7.0].map(|f| 6.0 * (f * f64::from(k)).sin()));
            let mut rows = sensor.hold(face.1, 500, i as u64);
            rows.extend(hand);
            rows
        })
        .collect();
    let channel = |axis: usize| rows.iter().map(move |row| row[axis]);
    let stamped = |values: &mut dyn Iterator<Item = f64>| -> String {
        let lines = values.enumerate();
        lines.map(|(i, v)| format!("{},{v:.4}\n", 10 * i)).collect()
    };
    let plain = tempfile::tempdir().unwrap();
    let with_gyro = tempfile::tempdir().unwrap();
    for (axis, letter) in ["X", "Y", "Z"].iter().enumerate() {
        let text: String = channel(axis).map(|v| format!("{v:.4}\n")).collect();
        write(plain.path(), &format!("accel_{letter}.txt"), &text);
        let text = stamped(&mut channel(axis));
        write(with_gyro.path(), &format!("acc_{letter}.csv"), &text);
        let mut rates = (0..rows.len()).map(|i| 0.001 * ((i + axis) % 3) as f64);
        let text = stamped(&mut rates);
        write(with_gyro.path(), &format!("gyr_{letter}.csv"), &text);
    }
    let named = "accel_X.txt accel_Y.txt accel_Z.txt";
    let mut files = vec![
        calibrate(
            plain.path(),
            &format!("{named} --rate 100 --gravity 9.81"),
            0,
        ),
        calibrate(plain.path(), ". --rate 100 --gravity 9.81", 0),
        calibrate(plain.path(), "accel_[XYZ].txt --rate 100 --gravity 9.81", 0),
        calibrate(with_gyro.path(), ". --gravity 9.81 -o cal.json", 0),
    ];
    let joined = files.pop().unwrap();
    assert_eq!(reported(&joined, "gyro-joined").len(), 1, "{joined}");
    assert!(joined["gyroscope"].is_object(), "{joined}");
    for file in files {
        assert_eq!(faces(&file).len(), 6, "{file}");
        for i in 0..3 {
            let bias = numbers(&file["accelerometer"]["bias"])[i];
            close(bias, sensor.bias[i], 0.02);
            close(numbers(&joined["accelerometer"]["bias"])[i], bias, 1e-3);
        }
    }
    let seen = run_in(plain.path(), words(&format!("inspect {named} --json"))).json();
    assert_eq!(seen["recordings"].as_array().unwrap().len(), 1, "{seen}");

    // A verb of one recording refuses one channel with a hint that works.
    let refused = run_in(
        with_gyro.path(),
        words("apply cal.json acc_X.csv --json -o out.csv"),
    );
    assert_eq!(
        (refused.code, refused.error_code().as_str()),
        (3, "no-rows")
    );
    let hint = refused.json()["hint"].as_str().unwrap().to_owned();
    assert!(hint.contains("\"acc_[XYZ].csv\""), "{hint}");
    let run = run_in(
        with_gyro.path(),
        words("apply cal.json acc_[XYZ].csv -o out.csv"),
    );
    assert_eq!(run.code, 0, "{}", run.err);

    write(plain.path(), "accel_Y.txt", "0.1\n0.2\n0.1\n");
    let error = run_in(plain.path(), words(&format!("calibrate {named} --json")));
    assert_eq!(
        (error.code, error.error_code().as_str()),
        (3, "axes-differ")
    );
    let message = error.json()["message"].as_str().unwrap().to_owned();
    assert!(message.contains("accel_Y.txt has 3 rows"), "{message}");
}

#[test]
fn a_session_with_the_signs_of_a_phone_is_mended_by_the_axes_that_it_names() {
    let sensor = Sensor::default();
    let phone = Sensor {
        matrix: sensor.matrix.map(|row| row.map(|v| -v)),
        ..Sensor::default()
    };
    let folder = six_files(&phone);
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    let [(_, note)] = reported(&file, "names-reversed")[..] else {
        panic!("{file}")
    };
    assert!(note.contains("--axes -x,-y,-z"), "{note}");
    let mended = calibrate(
        folder.path(),
        ". --gravity 9.81 --axes -x,-y,-z -o cal.json",
        0,
    );
    assert!(
        !kinds(&mended)
            .iter()
            .any(|k| k.starts_with("names-") || k == "orientation-mismatch")
    );
    // What points up reads +g now.
    let run = run_in(
        folder.path(),
        words("apply cal.json z_axis_pos.csv -o up.csv"),
    );
    assert_eq!(run.code, 0, "{}", run.err);
    let up = std::fs::read_to_string(folder.path().join("up.csv")).unwrap();
    let row: Vec<f64> = (up.lines().nth(1).unwrap().split(','))
        .map(|v| v.parse().unwrap())
        .collect();
    close(row[3], 9.81, 0.2);
    for i in 0..3 {
        close(
            numbers(&mended["accelerometer"]["bias"])[i],
            phone.bias[i],
            0.01,
        );
    }
}

#[test]
fn names_of_a_turned_board_are_explained_by_the_axes_that_are_printed() {
    // What is called x lies along the board's y, and y along its −x.
    let folder = six_files(&Sensor::default());
    let at = |name: &str| folder.path().join(name);
    for (from, to) in [
        ("x_axis_pos.csv", "1"),
        ("x_axis_neg.csv", "2"),
        ("y_axis_pos.csv", "x_axis_pos.csv"),
        ("y_axis_neg.csv", "x_axis_neg.csv"),
        ("1", "y_axis_neg.csv"),
        ("2", "y_axis_pos.csv"),
    ] {
        std::fs::rename(at(from), at(to)).unwrap();
    }
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    let [(_, note)] = reported(&file, "names-turned")[..] else {
        panic!("{file}")
    };
    let map = note
        .split("--axes ")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap();
    let mended = calibrate(folder.path(), &format!(". --gravity 9.81 --axes {map}"), 0);
    assert!(
        !kinds(&mended)
            .iter()
            .any(|k| k.starts_with("names-") || k == "orientation-mismatch")
    );
}

#[test]
fn names_with_a_dash_and_paths_with_a_space_do_as_they_are_printed() {
    let folder = tempfile::tempdir().unwrap();
    for ((_, up), name) in FACES.iter().zip(["+x", "-x", "+y", "-y", "+z", "-z"]) {
        write(
            folder.path(),
            &format!("{name}.csv"),
            &Sensor::default().file(*up, 500, 8),
        );
    }
    for option in ["--face-pose", "--free-pose"] {
        calibrate(folder.path(), &format!(". --gravity 9.81 {option} -x"), 0);
    }
    let run = run_in(folder.path(), ["calibrate", ".", "-o", "my cal.json"]);
    assert!(
        run.out.contains("gravical apply \"my cal.json\" "),
        "{}",
        run.out
    );
}

#[test]
fn what_is_missing_is_named_with_its_cause() {
    let folder = six_files(&Sensor::default());
    // Put down for 0.4 s, and then turned over and over.
    let mut swung = "t_ms,ax,ay,az\n".to_owned();
    for i in 0..500 {
        let angle = 0.05 * f64::from((i - 40).max(0));
        let (sine, cosine) = angle.sin_cos();
        swung += &format!("{},{:.3},{:.3},0.4\n", 10 * i, 9.81 * sine, 9.81 * cosine);
    }
    write(folder.path(), "y_axis_pos.csv", &swung);
    let run = run_in(folder.path(), words("calibrate . --method ferraris --json"));
    assert_eq!((run.code, run.error_code().as_str()), (3, "missing-face"));
    let message = run.json()["message"].as_str().unwrap().to_owned();
    assert!(
        message.contains("y_axis_pos.csv: y_axis_pos is never at rest in lines 2 to 501"),
        "{message}"
    );
}

/// What shakes throughout has no rest, however quiet its quietest part is beside the others.
#[test]
fn a_walk_is_never_at_rest_and_is_told_why() {
    let folder = tempfile::tempdir().unwrap();
    let mut walk = "t_ms,ax,ay,az\n".to_owned();
    for i in 0..1000 {
        let step = 2.0 * (0.7 * f64::from(i)).sin();
        walk += &format!("{},{:.3},0.1,{:.3}\n", 10 * i, 0.5 * step, 9.81 + step);
    }
    write(folder.path(), "walk.csv", &walk);
    let why = "where it is quietest each axis moves by 0.9 m/s² rms, at rest by less than 0.3";
    let run = run_in(folder.path(), words("calibrate walk.csv --json"));
    assert_eq!(run.error_code(), "never-static");
    let message = run.json()["message"].as_str().unwrap().to_owned();
    assert!(message.contains(why), "{message}");
    let looked = run_in(folder.path(), words("inspect walk.csv --json")).json();
    let mut findings = looked["recordings"][0]["findings"]
        .as_array()
        .unwrap()
        .iter();
    let said = findings.find(|f| f["kind"] == "never-static").unwrap();
    assert!(said["message"].as_str().unwrap().contains(why), "{said}");
}

#[test]
fn the_recording_of_another_sensor_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for (seed, name) in [(1, "a"), (2, "b"), (1, "c")] {
        let line = format!("simulate poses -o {name} --seed {seed} --hold 2 --free 4 -q");
        assert_eq!(run_in(folder.path(), words(&line)).code, 0);
    }
    let run = run_in(
        folder.path(),
        words("calibrate a/poses.csv b/poses.csv --json"),
    );
    assert_eq!((run.code, run.error_code().as_str()), (3, "sensors-differ"));
    let said = run.json().to_string();
    assert!(said.contains("b/poses.csv"), "{said}");
    // One sensor twice.
    run_in(
        folder.path(),
        words("calibrate a/poses.csv c/poses.csv --json"),
    )
    .calibration();
}
