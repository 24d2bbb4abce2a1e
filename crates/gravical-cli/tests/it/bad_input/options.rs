//! Options that do not fit the recording, or nothing at all.

use super::*;

#[test]
fn turns_without_a_gyroscope_or_the_time() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    one_file(at, true);
    let line = "calibrate session.csv --sections list.csv";
    let rated = format!("{line} --rate 100");
    refused(at, &rated, 3, "missing-gyro", &["x_rot"]);
    // With a gyroscope beside it.
    let text = read(at, "session.csv");
    let row = |(k, row): (usize, &str)| match k {
        0 => format!("{row},gx,gy,gz\n"),
        _ => format!("{row},{},0.2,0.3\n", k % 7),
    };
    let text: String = text.lines().enumerate().map(row).collect();
    write(at, "session.csv", &text);
    refused(at, line, 3, "rate-unknown", &["time"]);
}

#[test]
fn options_that_cannot_be_meant() {
    let folder = six_files(&Sensor::default());
    for option in [
        "--gravity 1",
        "--latitude 91",
        "--turn-angle 5",
        "--pose-tilt 40",
        "--rate 0",
    ] {
        fails(
            folder.path(),
            &format!("calibrate . {option}"),
            2,
            "option-range",
        );
    }
    for line in [
        "calibrate",
        "calibrate . --axes x,y,-z",
        "calibrate . --gravity 9.81 --latitude 30",
        "calibrate . --method newton",
        "conjure .",
        "",
    ] {
        ends(folder.path(), line, 2);
    }
}
