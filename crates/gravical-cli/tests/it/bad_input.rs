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
    assert!(folder.join("poor.json").exists(), "written anyway");
    let text = run_in(folder, words(&format!("calibrate {line}")));
    assert_eq!(text.code, 4);
    assert!(text.out.contains("Verdict: poor"), "{}", text.out);
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
        "never-static",
        &["shaken.csv"],
    );
}
