//! `gravical compare` and `gravical check`: what they print and how they end.

use crate::support::*;

pub fn narrow(text: &str) {
    for line in text.lines() {
        assert!(line.chars().count() <= 80, "{line}");
        assert_eq!(line, line.trim_end(), "{line:?}");
    }
}

/// A recording is known by its checksum.
#[test]
fn a_recording_of_the_calibration_does_not_count_beside_a_new_one() {
    let folder = six_files(&Sensor::default());
    let path = folder.path();
    let line = "calibrate . --gravity 9.81 --method ferraris -o cal.json --quiet";
    ends(path, line, 0);
    let file = Sensor::default().file([0.0, 0.0, 1.0], 300, 7);
    std::fs::create_dir(path.join("new")).unwrap();
    write(&path.join("new"), "z.csv", &file);
    let both = json(path, "check cal.json z_axis_pos.csv new/z.csv", 0);
    finding(&both, "same-recordings");
    assert_eq!(both["verdict"]["judgement"], "fits");
    let counts = both["static_intervals"].as_array().unwrap().iter();
    let counts: Vec<bool> = counts.map(|s| s["counts"].as_bool().unwrap()).collect();
    assert_eq!(counts, [false, true]);
    ends(path, "check cal.json new/z.csv --gravity 20", 2);
    ends(path, "compare cal.json missing.json", 3);
}
