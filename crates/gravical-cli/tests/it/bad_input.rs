//! Bad input: each case its exit code and its `code`, as JSON and in words, with
//! the next thing to do; and nothing is written when there is nothing to write.

mod faces;
mod options;
mod sensor;

use crate::support::*;
use std::path::Path;

/// The call has to fail with `exit` and `code`, in both forms, and to name what
/// is wrong with every one of `named`.
pub fn refused(folder: &Path, line: &str, exit: i32, code: &str, named: &[&str]) {
    let output = folder.join("refused.json");
    let line = if line.starts_with("calibrate") {
        format!("{line} -o refused.json")
    } else {
        line.to_owned()
    };
    let run = ends(folder, &format!("{line} --json"), exit);
    assert!(run.err.is_empty(), "{}", run.err);
    let error = run.json();
    assert_eq!(error["code"], code, "{line}\n{error}");
    let message = error["message"].as_str().unwrap();
    for name in named {
        assert!(message.contains(name), "{name} in {message}");
    }
    assert!(error["hint"].is_string(), "{line}: no hint: {error}");

    let text = ends(folder, &line, exit);
    assert!(text.out.is_empty(), "{line}: {}", text.out);
    assert!(text.err.starts_with("error: "), "{}", text.err);
    for part in [message, format!("code: {code}").as_str(), "try: "] {
        assert!(text.err.contains(part), "{}", text.err);
    }
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
    assert!(folder.join("poor.json").exists(), "written anyway");
    let text = ends(folder, &format!("calibrate {line}"), 4);
    assert!(text.out.contains("Verdict: poor"), "{}", text.out);
}

/// A file, the code that it is refused with, and what is named.
const ODD: &str = "\
LICENSE.txt no-rows LICENSE
empty.csv empty-file empty
other.csv no-accelerometer other.csv
five.csv columns-unknown five.csv
zeros.csv all-zero 300";

#[test]
fn what_cannot_be_calibrated() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    refused(at, "calibrate .", 3, "no-recordings", &["."]);
    write(at, "LICENSE.txt", "Permission is hereby granted\n");
    write(at, "empty.csv", "");
    let other = format!("p,q,r\n{}", "4,1,2\n".repeat(50));
    write(at, "other.csv", &other);
    write(at, "five.csv", &"1,2,3,4,5\n".repeat(50));
    let zeros: String = (0..300).map(|i| format!("{},0,0,0\n", 10 * i)).collect();
    write(at, "zeros.csv", &format!("t_ms,ax,ay,az\n{zeros}"));
    for row in ODD.lines() {
        let [file, code, named] = row.split(' ').collect::<Vec<_>>()[..] else {
            panic!("{row}")
        };
        refused(at, &format!("calibrate {file}"), 3, code, &[named]);
    }
}

/// A list of sections, the code that it is refused with, and what is named.
const LISTS: &str = "\
x_p,0,400;z_a,400,3001 sections-range 3001
label,start,end;x_p,500,0 sections-order list.csv:2
x_p,0 sections-syntax list.csv:1
{\"x_p\":{\"start\":0}} sections-syntax end
{;\"x_p\":; sections-syntax list.csv:3";

#[test]
fn options_that_name_what_is_not_there() {
    let folder = six_files(&Sensor::default());
    let at = folder.path();
    let columns = "calibrate . --columns ax=u,ay=v,az=w";
    refused(at, columns, 2, "columns-missing", &["\"u\""]);
    let sensor = "calibrate . --sensor right";
    refused(at, sensor, 2, "sensor-unknown", &["right"]);
    let one = "calibrate x_axis_pos.csv --sections list.csv";
    for row in LISTS.lines() {
        let [list, code, named] = row.split(' ').collect::<Vec<_>>()[..] else {
            panic!("{row}")
        };
        write(at, "list.csv", &list.replace(';', "\n"));
        refused(at, one, 3, code, &[named]);
    }
    write(at, "list.csv", "x_p,0,400\n");
    let two = format!("{one} y_axis_pos.csv");
    refused(at, &two, 2, "several-files", &[]);
}

/// All six holds one after the other, 500 rows each, and a section list.
pub fn one_file(folder: &Path) {
    let sensor = Sensor::default();
    let mut text = "ax,ay,az\n".to_owned();
    let mut list = "label,start,end\n".to_owned();
    for (i, (name, up)) in FACES.iter().enumerate() {
        for row in sensor.hold(*up, 500, i as u64) {
            text += &format!("{:.4},{:.4},{:.4}\n", row[0], row[1], row[2]);
        }
        list += &format!("{name},{},{}\n", 500 * i, 500 * (i + 1));
    }
    write(folder, "session.csv", &text);
    write(folder, "list.csv", &list);
}
