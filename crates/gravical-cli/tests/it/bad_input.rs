//! Bad input: each case its exit code and its `code`, as JSON and in words, with
//! the next thing to do; and nothing is written when there is nothing to write.

use std::path::Path;

use crate::support::*;

/// The call has to fail with `exit` and `code`, in both forms, and to name what
/// is wrong with every one of `named`.
pub fn refused(folder: &Path, line: &str, exit: i32, code: &str, named: &[&str]) {
    let output = folder.join("refused.json");
    let line = if line.starts_with("calibrate") {
        format!("{line} -o refused.json")
    } else {
        line.to_owned()
    };
    let json = run_in(folder, words(&format!("{line} --json")));
    assert_eq!(json.code, exit, "{line}\n{}{}", json.out, json.err);
    assert_eq!(json.error_code(), code, "{line}\n{}", json.out);
    assert!(json.err.is_empty(), "{}", json.err);
    let error = json.json();
    let message = error["message"].as_str().unwrap();
    for name in named {
        assert!(message.contains(name), "{name} in {message}");
    }
    assert!(error["hint"].is_string(), "{line}: no hint: {error}");

    let text = run_in(folder, words(&line));
    assert_eq!(text.code, exit, "{line}");
    assert!(text.out.is_empty(), "{line}: {}", text.out);
    assert!(text.err.starts_with("error: "), "{}", text.err);
    assert!(text.err.contains(message), "{}", text.err);
    assert!(text.err.contains(&format!("code: {code}")), "{}", text.err);
    assert!(text.err.contains("try: "), "{}", text.err);
    assert!(!output.exists(), "{line} wrote a file");
}

/// The call has to give a calibration of verdict `poor` for the reason `kind`,
/// which is written all the same.
fn poor(folder: &Path, line: &str, kind: &str) {
    let file = calibrate(folder, &format!("{line} -o poor.json --force"), 4);
    assert_eq!(file["verdict"]["grade"], "poor");
    assert_eq!(finding(&file, kind)["severity"], "warning");
    let reason = finding(&file, kind)["message"].clone();
    let reasons = file["verdict"]["reasons"].as_array().unwrap();
    assert!(reasons.contains(&reason), "{reasons:?}");
    assert!(folder.join("poor.json").exists(), "written all the same");
    let text = run_in(folder, words(&format!("calibrate {line}")));
    assert_eq!(text.code, 4);
    assert!(text.out.contains("Verdict: poor"), "{}", text.out);
}

#[test]
fn missing_face() {
    let folder = six_files(&Sensor::default());
    std::fs::remove_file(folder.path().join("y_axis_neg.csv")).unwrap();
    refused(
        folder.path(),
        "calibrate . --gravity 9.81 --method ferraris",
        3,
        "missing-face",
        &["missing: -y", "5 of six"],
    );
    // The joint fit does without, and says what that costs.
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    let told = finding(&file, "missing-face")["message"].as_str().unwrap();
    assert!(told.contains("-y up"), "{told}");
    let sd = numbers(&file["accelerometer"]["deviations"]["bias"]);
    assert!(sd[1] > 10.0 * sd[0].max(sd[2]), "{sd:?}");
    assert_eq!(file["verdict"]["grade"], "not-verifiable");
}

#[test]
fn same_face_twice_among_six() {
    let folder = six_files(&Sensor::default());
    let again = Sensor::default().file([0.0, 1.0, 0.0], 500, 99);
    write(folder.path(), "y_axis_neg.csv", &again);
    refused(
        folder.path(),
        "calibrate . --gravity 9.81 --method ferraris",
        3,
        "same-face-twice",
        &["+y", "-y", "y_axis_pos.csv", "y_axis_neg.csv"],
    );
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    let told = finding(&file, "same-face-twice")["message"]
        .as_str()
        .unwrap();
    assert!(told.contains("no placement has -y up"), "{told}");
}

/// Renames the six files: what lay under the first name stands under the second.
fn swapped(pairs: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = six_files(&Sensor::default());
    for (a, b) in pairs {
        let path = |n: &str| folder.path().join(format!("{n}.csv"));
        let spare = folder.path().join("spare");
        std::fs::rename(path(a), &spare).unwrap();
        std::fs::rename(path(b), path(a)).unwrap();
        std::fs::rename(spare, path(b)).unwrap();
    }
    folder
}

#[test]
fn names_swapped_so_that_only_a_mirror_explains_them() {
    let folder = swapped(&[("x_axis_pos", "x_axis_neg")]);
    poor(folder.path(), ". --gravity 9.81", "names-mirrored");
    let file = calibrate(folder.path(), ". --gravity 9.81", 4);
    assert!(kinds(&file).contains(&"orientation-mismatch".to_owned()));
    close(
        file["accelerometer"]["bias"][0].as_f64().unwrap(),
        Sensor::default().bias[0],
        0.01,
    );
}

#[test]
fn names_that_are_believed_and_left_handed() {
    let line = "calibrate . --gravity 9.81 --faces names";
    let two = swapped(&[("x_axis_pos", "x_axis_neg")]);
    refused(two.path(), line, 3, "left-handed", &["swapped"]);
    let axes = swapped(&[("x_axis_pos", "y_axis_pos"), ("x_axis_neg", "y_axis_neg")]);
    refused(axes.path(), line, 3, "left-handed", &["det R"]);
}

#[test]
fn names_that_are_believed_speak_of_the_case() {
    // Half a turn about z, and the names say so.
    let half = swapped(&[("x_axis_pos", "x_axis_neg"), ("y_axis_pos", "y_axis_neg")]);
    let line = ". --gravity 9.81 --faces names --axes=-x,-y,z";
    let file = calibrate(half.path(), line, 0);
    let data = calibrate(half.path(), ". --gravity 9.81 --axes=-x,-y,z", 0);
    same_accelerometer(&file["accelerometer"], &data["accelerometer"]);
    refused(
        six_files(&Sensor::default()).path(),
        &format!("calibrate {line}"),
        3,
        "left-handed",
        &["+x up"],
    );
}

#[test]
fn names_of_a_turned_board_are_no_mistake() {
    // x → y, y → −x: a quarter turn about z, and every sign the other way round.
    let quarter = swapped(&[
        ("x_axis_pos", "y_axis_pos"),
        ("x_axis_neg", "y_axis_neg"),
        ("x_axis_pos", "x_axis_neg"),
    ]);
    let file = calibrate(quarter.path(), ". --gravity 9.81", 0);
    finding(&file, "names-turned");
    let reversed = swapped(&[
        ("x_axis_pos", "x_axis_neg"),
        ("y_axis_pos", "y_axis_neg"),
        ("z_axis_pos", "z_axis_neg"),
    ]);
    let file = calibrate(reversed.path(), ". --gravity 9.81", 0);
    assert_eq!(finding(&file, "names-reversed")["severity"], "note");
}

#[test]
fn empty_file_and_file_without_numbers() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "empty.csv", "");
    write(folder.path(), "blank.csv", "\n \n\n");
    write(
        folder.path(),
        "prose.txt",
        "Dear reader,\nthis is no recording\n",
    );
    write(folder.path(), "header.csv", "t,ax,ay,az\n");
    for (name, code) in [
        ("empty.csv", "empty-file"),
        ("blank.csv", "empty-file"),
        ("prose.txt", "no-rows"),
        ("header.csv", "no-rows"),
    ] {
        refused(
            folder.path(),
            &format!("calibrate {name}"),
            3,
            code,
            &[name],
        );
        let run = run_in(folder.path(), words(&format!("inspect {name} --json")));
        assert_eq!(run.code, 3);
        assert_eq!(run.json()["errors"][0]["code"], code);
    }
}

#[test]
fn what_is_not_there() {
    let folder = tempfile::tempdir().unwrap();
    refused(
        folder.path(),
        "calibrate gone.csv",
        3,
        "not-found",
        &["gone.csv"],
    );
}

#[test]
fn directory_without_recordings() {
    let folder = tempfile::tempdir().unwrap();
    refused(folder.path(), "calibrate .", 3, "no-recordings", &["."]);
    write(folder.path(), "readme.md", "# nothing");
    write(
        folder.path(),
        "LICENSE.txt",
        "Permission is hereby granted\n",
    );
    refused(folder.path(), "calibrate .", 3, "no-recordings", &["."]);
}

#[test]
fn a_file_of_zeros() {
    let folder = tempfile::tempdir().unwrap();
    let zeros: String = (0..300).map(|i| format!("{},0,0,0\n", 10 * i)).collect();
    write(
        folder.path(),
        "zeros.csv",
        &format!("t_ms,ax,ay,az\n{zeros}"),
    );
    refused(
        folder.path(),
        "calibrate zeros.csv",
        3,
        "all-zero",
        &["zeros.csv", "300 rows"],
    );
}

#[test]
fn columns_of_nothing() {
    let folder = six_files(&Sensor::default());
    let path = folder.path().join("z_axis_pos.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let without: String = text
        .lines()
        .enumerate()
        .map(|(i, l)| {
            let mut cells: Vec<&str> = l.split(',').collect();
            if i > 0 {
                cells[2] = "NaN";
            }
            cells.join(",") + "\n"
        })
        .collect();
    std::fs::write(&path, without).unwrap();
    refused(
        folder.path(),
        "calibrate .",
        3,
        "no-values",
        &["z_axis_pos.csv", "ay"],
    );
}

/// All six holds one after the other, 500 rows each, and a section list.
fn one_file(folder: &Path, turns: bool) {
    let sensor = Sensor::default();
    let mut text = "ax,ay,az\n".to_owned();
    let mut list = "label,start,end\n".to_owned();
    for (i, (name, up)) in FACES.iter().enumerate() {
        for row in sensor.hold(*up, 500, i as u64) {
            text += &format!("{:.4},{:.4},{:.4}\n", row[0], row[1], row[2]);
        }
        list += &format!("{name},{},{}\n", 500 * i, 500 * (i + 1));
    }
    if turns {
        for (i, axis) in ["x", "y", "z"].iter().enumerate() {
            list += &format!("{axis}_rot,{},{}\n", 500 * i, 500 * i + 100);
        }
    }
    write(folder, "session.csv", &text);
    write(folder, "list.csv", &list);
}

#[test]
fn turns_without_a_gyroscope() {
    let folder = tempfile::tempdir().unwrap();
    one_file(folder.path(), true);
    refused(
        folder.path(),
        "calibrate session.csv --sections list.csv --rate 100",
        3,
        "missing-gyro",
        &["x_rot"],
    );
}

#[test]
fn turns_without_the_time() {
    let folder = tempfile::tempdir().unwrap();
    one_file(folder.path(), true);
    let text = std::fs::read_to_string(folder.path().join("session.csv")).unwrap();
    let with_gyro: String = text
        .lines()
        .enumerate()
        .map(|(i, l)| match i {
            0 => format!("{l},gx,gy,gz\n"),
            _ => format!("{l},{},0.2,0.3\n", i % 7),
        })
        .collect();
    write(folder.path(), "session.csv", &with_gyro);
    refused(
        folder.path(),
        "calibrate session.csv --sections list.csv",
        3,
        "rate-unknown",
        &["time"],
    );
}

#[test]
fn sections_that_cannot_be_meant() {
    let folder = tempfile::tempdir().unwrap();
    one_file(folder.path(), false);
    let sections = |text: &str, code: &str, named: &[&str]| {
        write(folder.path(), "list.csv", text);
        let line = "calibrate session.csv --sections list.csv";
        refused(folder.path(), line, 3, code, named);
    };
    sections(
        "label,start,end\nx_p,0,500\nz_a,2500,3001\n",
        "sections-range",
        &["z_a", "3001", "3000 rows"],
    );
    sections(
        "label,start,end\nx_p,500,0\n",
        "sections-order",
        &["list.csv:2", "x_p"],
    );
    sections("x_p,0\n", "sections-syntax", &["list.csv:1"]);
    sections(
        "{\"x_p\": {\"start\": 0}}",
        "sections-syntax",
        &["x_p", "end"],
    );
    sections("{\n\"x_p\": \n", "sections-syntax", &["list.csv:3"]);
    let run = run_in(
        folder.path(),
        words("calibrate session.csv session.csv --sections list.csv --json"),
    );
    assert_eq!(run.code, 3, "the list is broken, whatever the files");
    write(folder.path(), "list.csv", "x_p,0,500\n");
    let run = run_in(
        folder.path(),
        words("calibrate session.csv session.csv --sections list.csv --json"),
    );
    assert_eq!((run.code, run.error_code().as_str()), (2, "several-files"));
}

#[test]
fn a_scale_15_percent_off() {
    let folder = six_files(&Sensor::default().scaled(1.15));
    poor(folder.path(), ". --gravity 9.81", "scale-off");
    let folder = six_files(&Sensor::default().scaled(1.06));
    let file = calibrate(folder.path(), ". --gravity 9.81", 0);
    finding(&file, "scale-high");
}

#[test]
fn a_bias_that_no_sensor_has() {
    let mut sensor = Sensor::default();
    sensor.bias[1] = 3.9;
    let folder = six_files(&sensor);
    // With −y up it reads 0.6 g: the unit has to be said.
    poor(
        folder.path(),
        ". --gravity 9.81 --accel-unit m/s^2",
        "large-bias",
    );
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
    let path = folder.path().join("z_axis_pos.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let clipped: String = text
        .lines()
        .enumerate()
        .map(|(i, l)| match l.rsplit_once(',') {
            Some((before, _)) if (200..240).contains(&i) => format!("{before},32767\n"),
            _ => format!("{l}\n"),
        })
        .collect();
    std::fs::write(&path, clipped).unwrap();
    poor(folder.path(), ". --gravity 9.81 --rows 400", "clipped-hold");
}

#[test]
fn a_full_scale_that_is_not_the_one_claimed() {
    let folder = six_files(&Sensor {
        unit: 8192.0 / 9.80665,
        ..in_counts()
    });
    let right = calibrate(folder.path(), ". --gravity 9.81", 0);
    assert_eq!(right["accelerometer"]["input_unit"], "counts");
    poor(
        folder.path(),
        ". --gravity 9.81 --accel-range 2",
        "scale-off",
    );
}

#[test]
fn turns_the_other_way() {
    let folder = tempfile::tempdir().unwrap();
    let made = run_in(
        folder.path(),
        words("simulate six-position --continuous --hold 4 --rest 2 --turn-angle 360 -o . --quiet"),
    );
    assert_eq!(made.code, 0, "{}", made.err);
    poor(folder.path(), "session.csv", "turned-other-way");
    let told = calibrate(folder.path(), "session.csv --turn-angle 360", 0);
    assert!(!kinds(&told).contains(&"turned-other-way".to_owned()));
}

#[test]
fn a_unit_that_nothing_tells() {
    let folder = six_files(&Sensor {
        unit: 3.3,
        ..Sensor::default()
    });
    refused(
        folder.path(),
        "calibrate .",
        3,
        "unit-unknown",
        &["magnitude at rest"],
    );
    // mg without a word of it could be counts at 1024 per g or cm/s², too.
    let folder = six_files(&Sensor {
        unit: 1000.0 / 9.80665,
        decimals: 2,
        ..Sensor::default()
    });
    refused(folder.path(), "calibrate .", 3, "unit-unknown", &["mg"]);
    let told = calibrate(folder.path(), ". --accel-unit mg --gravity 9.81", 0);
    assert_eq!(told["accelerometer"]["input_unit"], "mg");
    close(
        told["accelerometer"]["bias"][0].as_f64().unwrap() * 9.80665 / 1000.0,
        Sensor::default().bias[0],
        0.01,
    );
    assert_eq!(
        run_in(folder.path(), words("calibrate . --accel-unit parsec")).code,
        2
    );
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
    write(
        folder.path(),
        "z_axis_neg.csv",
        &other.file([0.0, 0.0, -1.0], 500, 3),
    );
    refused(
        folder.path(),
        "calibrate .",
        3,
        "units-differ",
        &["z_axis_neg.csv", "m/s^2"],
    );
}

#[test]
fn columns_that_are_not_there() {
    let folder = six_files(&Sensor::default());
    let with = |spec: &str| format!("calibrate . --columns {spec}");
    let path = folder.path();
    refused(
        path,
        &with("ax=u,ay=v,az=w"),
        2,
        "columns-missing",
        &["\"u\""],
    );
    let run = run_in(path, words("calibrate . --columns ax,by,az --json"));
    assert_eq!(run.code, 2);
    let run = run_in(path, words("calibrate . --columns t,ax,ay --json"));
    assert_eq!(
        (run.code, run.error_code().as_str()),
        (2, "columns-missing")
    );
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..50).map(|i| format!("{i},1,2\n")).collect();
    write(folder.path(), "other.csv", &format!("p,q,r\n{rows}"));
    refused(
        folder.path(),
        "calibrate other.csv",
        3,
        "no-accelerometer",
        &["other.csv"],
    );
    write(folder.path(), "five.csv", &"1,2,3,4,5\n".repeat(50));
    refused(
        folder.path(),
        "calibrate five.csv",
        3,
        "columns-unknown",
        &["five.csv"],
    );
}

#[test]
fn options_that_cannot_be_meant() {
    let folder = six_files(&Sensor::default());
    for (line, code) in [
        ("--gravity 1", "option-range"),
        ("--latitude 91", "option-range"),
        ("--turn-angle 5", "option-range"),
        ("--placement-tilt 40", "option-range"),
        ("--rows 0", "option-range"),
        ("--rate 0", "option-range"),
    ] {
        let run = run_in(folder.path(), words(&format!("calibrate . {line} --json")));
        assert_eq!(run.code, 2, "{line}: {}", run.out);
        assert_eq!(run.error_code(), code, "{line}");
    }
    for line in [
        "calibrate",
        "calibrate . --axes x,y,-z",
        "calibrate . --gravity 9.81 --latitude 30",
        "calibrate . --method newton",
        "conjure .",
        "",
    ] {
        assert_eq!(run_in(folder.path(), words(line)).code, 2, "{line}");
    }
}

#[test]
fn a_recording_that_never_lies_still() {
    let folder = tempfile::tempdir().unwrap();
    let mut noise = Noise::new(4);
    let mut text = "t_ms,ax,ay,az\n".to_owned();
    for i in 0..3000 {
        let angle = f64::from(i) * 0.013;
        text += &format!(
            "{},{:.4},{:.4},{:.4}\n",
            10 * i,
            9.8 * angle.sin() + noise.normal(),
            9.8 * angle.cos() + noise.normal(),
            noise.normal()
        );
    }
    write(folder.path(), "shaken.csv", &text);
    refused(
        folder.path(),
        "calibrate shaken.csv",
        3,
        "never-still",
        &["shaken.csv"],
    );
}
