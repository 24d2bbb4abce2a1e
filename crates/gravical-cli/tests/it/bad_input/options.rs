//! Options that do not fit the recording, or nothing at all.

use super::*;

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
    let long = "t,ax,ay,az,_,_,_,_,_,_,_,_,gx";
    let run = run_in(path, words(&format!("calibrate . --columns {long} --json")));
    assert_eq!(
        (run.code, run.error_code().as_str()),
        (2, "columns-missing")
    );
    refused(
        path,
        "calibrate . --sensor right",
        2,
        "sensor-unknown",
        &["right"],
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
        ("--pose-tilt 40", "option-range"),
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
