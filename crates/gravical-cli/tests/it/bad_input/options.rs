//! Options that do not fit the recording, or nothing at all.

use super::*;

#[test]
fn options_that_cannot_be_meant() {
    let folder = six_files(&Sensor::default());
    for option in ["--gravity 1", "--latitude 91", "--pose-tilt 40", "--rate 0"] {
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
