//! Recordings of a board whose sketch calibrates: no command calibrates them again without a word.

use crate::motion::line;
use crate::support::*;

/// What the sketch says of itself (docs/firmware.md).
const BOARD: &str = "# gravical mpu6050_logger 1.1, MPU6050, accelerometer +-2 g, gyroscope +-500 deg/s, low-pass 44 Hz, rate 100.00 Hz, format 3, calibrated 2026-01-01T00:00:00Z\n";

#[test]
fn every_command_that_calibrates_says_that_the_board_did() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    // Recordings as a board with `cal.json` would have sent them. The line alone says it, too, where a
    // program in between has changed the names.
    for (name, columns) in [("poses", "ax_mps2,ay_mps2,az_mps2"), ("line", "ax,ay,az")] {
        let apply = format!("apply cal.json {name}/{name}.csv -o {name}.si --quiet");
        ends(path, &apply, 0);
        let rows = read(path, &format!("{name}.si"));
        let rows = rows.replacen("ax_mps2,ay_mps2,az_mps2", columns, 1);
        write(path, &format!("{name}.csv"), &format!("{BOARD}{rows}"));
    }
    for command in [
        "calibrate poses.csv --gravity 9.80665 -o again.json",
        "check cal.json poses.csv",
        "apply cal.json line.csv -o twice.csv",
        "motion line.csv -c cal.json",
    ] {
        let run = run_in(path, words(&format!("{command} --json")));
        assert!(run.code == 0 || run.code == 4, "{command}\n{}", run.err);
        let json = run.json();
        let said = finding(&json, "already-calibrated")["message"].to_string();
        let is_said = said.contains("the board calibrated it");
        assert!(is_said, "{command}: {said}");
    }
    // Where nothing calibrates it again there is nothing to say.
    let once = crate::motion::motion(path, "line.csv", 0);
    assert!(!kinds(&once).contains(&"already-calibrated"));
}
