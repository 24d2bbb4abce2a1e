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
    let mut text = "ax,ay,az,gx,gy,gz\n".to_owned();
    let mut list = "label,start,end\nx_rot,0,100\ny_rot,500,600\nz_rot,1000,1100\n".to_owned();
    for (i, (name, up)) in FACES.iter().enumerate() {
        for (k, [x, y, z]) in Sensor::default()
            .hold(*up, 500, i as u64)
            .iter()
            .enumerate()
        {
            text += &format!("{x:.4},{y:.4},{z:.4},{},0.2,0.3\n", k % 7);
        }
        list += &format!("{name},{},{}\n", 500 * i, 500 * (i + 1));
    }
    write(folder.path(), "session.csv", &text);
    write(folder.path(), "list.csv", &list);
    let line = "calibrate session.csv --sections list.csv";
    refused(folder.path(), line, 3, "rate-unknown", &["time"]);
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
