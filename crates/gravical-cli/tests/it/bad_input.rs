//! Bad input: each case its exit code and its `code`, as JSON and in words, with
//! the next thing to do; and nothing is written when there is nothing to write.

use std::path::Path;

use crate::support::*;

/// The call has to fail with `exit` and `code`, and to name what is wrong with every one of `named`.
fn refused(folder: &Path, line: &str, exit: i32, code: &str, named: &[&str]) {
    let line = writing(line);
    let run = ends(folder, &format!("{line} --json"), exit);
    assert!(run.err.is_empty(), "{}", run.err);
    let error = run.json();
    assert_eq!(error["code"], code, "{line}\n{error}");
    let message = text(&error["message"]);
    for name in named {
        assert!(message.contains(name), "{name} in {message}");
    }
    assert!(error["hint"].is_string(), "{line}: no hint: {error}");
    assert!(!folder.join("refused.json").exists(), "{line} wrote a file");
}

/// A call of `calibrate` with a file to write.
fn writing(line: &str) -> String {
    match line.strip_prefix("calibrate") {
        Some(rest) => format!("calibrate -o refused.json{rest}"),
        None => line.to_owned(),
    }
}

/// The same in words, made alike for every error.
fn refused_in_words(folder: &Path, line: &str, exit: i32, code: &str, named: &[&str]) {
    let run = ends(folder, &writing(line), exit);
    let is_error = run.out.is_empty() && run.err.starts_with("error: ");
    assert!(is_error, "{line}: {}{}", run.out, run.err);
    let code = format!("code: {code}");
    for part in named.iter().chain(&[code.as_str(), "try: "]) {
        assert!(run.err.contains(part), "{}", run.err);
    }
}

/// Lines of a call, its exit code and code, and what is named, parted by ` | `.
pub fn all_refused(folder: &Path, table: &str) {
    for (i, row) in table.lines().enumerate() {
        let parts: Vec<&str> = row.split(" | ").collect();
        let (exit, code) = parts[1].split_once(' ').unwrap();
        let exit = exit.parse().unwrap();
        refused(folder, parts[0], exit, code, &parts[2..]);
        if i == 0 {
            refused_in_words(folder, parts[0], exit, code, &parts[2..]);
        }
    }
}

/// The call has to give a calibration of verdict `poor` for the reason `kind`,
/// which is written all the same.
fn poor(folder: &Path, line: &str, kind: &str) {
    let file = calibrate(folder, &format!("{line} -o poor.json --force"), 4);
    assert_eq!(file["verdict"]["grade"], "poor");
    assert_eq!(finding(&file, kind)["severity"], "warning");
    let reason = finding(&file, kind)["message"].clone();
    let mut reasons = list(&file["verdict"]["reasons"]);
    assert!(reasons.any(|r| *r == reason), "{}", file["verdict"]);
    assert!(folder.join("poor.json").exists(), "written anyway");
}

/// Calls in a folder with six sound files and odd ones, the exit code and the code of each, and
/// what is named.
const REFUSED: &str = "\
calibrate nothing | 3 no-recordings | nothing
calibrate LICENSE.txt | 3 no-rows | LICENSE
calibrate empty.csv | 3 empty-file | empty
calibrate other.csv | 3 no-accelerometer | other.csv
calibrate five.csv | 3 columns-unknown | five.csv
calibrate zeros.csv | 3 all-zero | 300
calibrate volts.csv | 3 unit-unknown | magnitude at rest
calibrate x_axis_pos.csv g.csv | 3 units-differ | m/s^2
calibrate six --columns ax=u,ay=v,az=w | 2 columns-missing | \"u\"
calibrate six --sensor right | 2 sensor-unknown | right
calibrate x_axis_pos.csv y_axis_pos.csv --sections list.csv | 2 several-files
calibrate x_axis_pos.csv y_axis_pos.csv --gyro g.csv | 2 gyro-inputs
calibrate x_axis_pos.csv | 3 underdetermined | axes covered: x
calibrate x_axis_pos.csv x_axis_neg.csv | 3 underdetermined | 2 poses
calibrate x_axis_pos.csv x_axis_neg.csv y_axis_pos.csv y_axis_neg.csv | 3 underdetermined | axes covered: x, y
calibrate five --method ferraris | 3 missing-face | missing: -y
calibrate twice --method ferraris | 3 missing-face | missing: -y
calibrate six --free-pose nothing | 2 no-such-pose | nothing";

/// A list of sections, the code that it is refused with, and what is named.
const LISTS: &str = "\
x_p,0,400;z_a,400,3001 sections-range 3001
label,start,end;x_p,500,0 sections-order list.csv:2
x_p,0 sections-syntax list.csv:1
{\"x_p\":{\"start\":0}} sections-syntax end
{;\"x_p\":; sections-syntax list.csv:3";

#[test]
fn what_cannot_be_calibrated() {
    let folder = six_files(&Sensor::default());
    let at = folder.path();
    for name in ["six", "five", "twice", "nothing"] {
        std::fs::create_dir(at.join(name)).unwrap();
        if name != "nothing" {
            write_six_files(&at.join(name), &Sensor::default());
        }
    }
    std::fs::remove_file(at.join("five/y_axis_neg.csv")).unwrap();
    let again = Sensor::default().file([0.0, 1.0, 0.0], 500, 99);
    write(at, "twice/y_axis_neg.csv", &again);
    write(at, "list.csv", "x_p,0,400\n");
    write(at, "LICENSE.txt", "Permission is hereby granted\n");
    write(at, "empty.csv", "");
    let other = format!("p,q,r\n{}", "4,1,2\n".repeat(50));
    write(at, "other.csv", &other);
    write(at, "five.csv", &"1,2,3,4,5\n".repeat(50));
    let zeros: String = (0..300).map(|i| format!("{},0,0,0\n", 10 * i)).collect();
    write(at, "zeros.csv", &format!("t_ms,ax,ay,az\n{zeros}"));
    for (name, unit) in [("volts.csv", 3.3), ("g.csv", 1.0 / 9.80665)] {
        write(at, name, &in_unit(unit).file([0.0, 0.0, -1.0], 500, 3));
    }
    all_refused(at, REFUSED);
    let one = "calibrate x_axis_pos.csv --sections list.csv";
    for row in LISTS.lines() {
        let [list, code, named] = row.split(' ').collect::<Vec<_>>()[..] else {
            panic!("{row}")
        };
        write(at, "list.csv", &list.replace(';', "\n"));
        refused(at, one, 3, code, &[named]);
    }
    for option in ["--gravity 1", "--latitude 91", "--pose-tilt 40", "--rate 0"] {
        fails(at, &format!("calibrate six {option}"), 2, "option-range");
    }
    for line in [
        "calibrate",
        "calibrate six --axes x,y,-z",
        "calibrate six --gravity 9.81 --latitude 30",
        "calibrate six --method newton",
        "conjure six",
        "",
    ] {
        ends(at, line, 2);
    }
}

/// The joint fit does without a face, and says what that costs.
#[test]
fn a_face_that_is_missing_or_there_twice() {
    let folder = six_files(&Sensor::default());
    let at = folder.path();
    let again = Sensor::default().file([0.0, 1.0, 0.0], 500, 99);
    write(at, "y_axis_neg.csv", &again);
    let file = calibrate(at, ". --gravity 9.81", 4);
    let said = finding(&file, "same-face-twice")["message"].to_string();
    assert!(said.contains("no pose has -y up"), "{said}");
    std::fs::remove_file(at.join("y_axis_neg.csv")).unwrap();
    let file = calibrate(at, ". --gravity 9.81", 4);
    assert_eq!(file["verdict"]["grade"], "poor");
    finding(&file, "missing-face");
    let sd = numbers(&file["accelerometer"]["deviations"]["bias"]);
    // The others are as uncertain as a nonlinear response may be.
    assert!(sd[1] > 1.5 * sd[0].max(sd[2]), "{sd:?}");
}

#[test]
fn names_swapped_so_that_only_a_mirror_explains_them() {
    let folder = six_files(&Sensor::default());
    let at = folder.path();
    for (name, up) in FACES[..2].iter().map(|(name, up)| (name, up.map(|v| -v))) {
        write(
            at,
            &format!("{name}.csv"),
            &Sensor::default().file(up, 500, 100),
        );
    }
    poor(at, ". --gravity 9.81", "names-mirrored");
    let file = calibrate(at, ". --gravity 9.81", 4);
    finding(&file, "orientation-mismatch");
    let bias = number(&file["accelerometer"]["bias"][0]);
    close(bias, Sensor::default().bias[0], 0.01);
}

/// Readings that no sound sensor in the claimed unit gives.
#[test]
fn sensors_that_are_not_sound_are_poor() {
    let mut biased = Sensor::default();
    biased.bias[1] = 3.9;
    for (sensor, options, kind) in [
        (in_unit(1.12), "", "scale-off"),
        // With −y up it reads 0.6 g: the unit has to be said.
        (biased, "--accel-unit m/s^2", "large-bias"),
        // A unit that gravity contradicts is taken as told.
        (Sensor::default(), "--accel-unit g", "scale-off"),
    ] {
        let folder = six_files(&sensor);
        poor(folder.path(), &format!(". --gravity 9.81 {options}"), kind);
    }
}

#[test]
fn clipped_holds() {
    // An MPU6050 at ±2 g.
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

fn in_unit(unit: f64) -> Sensor {
    Sensor {
        unit,
        ..Sensor::default()
    }
}

/// A sensor in counts, 16384 per g.
pub fn in_counts() -> Sensor {
    Sensor {
        decimals: 0,
        ..in_unit(16384.0 / 9.80665)
    }
}
