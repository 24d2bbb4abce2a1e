//! A file that gravical writes loads in the real imucal and calibrates to the
//! same values.

use std::path::Path;
use std::process::Command;

use gravical::calibration_file::CalibrationFile;

use crate::support::*;

/// The python that has imucal; says that a test is skipped without it.
fn python() -> Option<String> {
    let python = std::env::var("GRAVICAL_IMUCAL_PYTHON");
    python
        .inspect_err(|_| println!("skipped: GRAVICAL_IMUCAL_PYTHON is not set"))
        .ok()
}

/// Calibrates a thousand random vectors with imucal and prints raw and result.
const SCRIPT: &str = r#"
import json, sys
import numpy as np
from imucal import CalibrationInfo

info = CalibrationInfo.from_json_file(sys.argv[1])
rng = np.random.default_rng(20250501)
acc = rng.normal(size=(1000, 3)) * float(sys.argv[2])
gyr = rng.normal(size=(1000, 3)) * float(sys.argv[3])
acc_c, gyr_c = info.calibrate(acc, gyr, info.from_acc_unit, info.from_gyr_unit)
print(json.dumps([acc.tolist(), gyr.tolist(), acc_c.tolist(), gyr_c.tolist()]))
"#;

/// Exports `cal.json` of `folder` and compares with imucal to 1e-9 of the size
/// of the values.
fn agrees(python: &str, folder: &Path, accel_size: f64, gyro_size: f64) {
    ends(folder, "export cal.json --to imucal -o imucal.json", 0);
    let output = Command::new(python)
        .args(["-c", SCRIPT, "imucal.json"])
        .args([accel_size.to_string(), gyro_size.to_string()])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let [acc, gyr, acc_c, gyr_c]: [Vec<[f64; 3]>; 4] =
        serde_json::from_slice(&output.stdout).unwrap();
    let file = CalibrationFile::read(&folder.join("cal.json")).unwrap();
    let accelerometer = file.accelerometer_calibration();
    let gyroscope = file.gyroscope_calibration();
    let largest = |list: &[[f64; 3]]| list.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
    let (accel_limit, gyro_limit) = (1e-9 * largest(&acc_c), 1e-9 * largest(&gyr_c));
    for i in 0..1000 {
        let accel = accelerometer.apply(acc[i]);
        let rate = match &gyroscope {
            // imucal gives °/s.
            Some(g) => g.apply(gyr[i], accel).map(f64::to_degrees),
            None => gyr[i],
        };
        for k in 0..3 {
            close(accel[k], acc_c[i][k], accel_limit);
            close(rate[k], gyr_c[i][k], gyro_limit);
        }
    }
}

#[test]
fn imucal_calibrates_alike_with_a_gyroscope() {
    let Some(python) = python() else { return };
    for (raw, accel_size, gyro_size) in [("", 10.0, 2.0), ("--raw", 16_384.0, 8_000.0)] {
        let folder = tempfile::tempdir().unwrap();
        let line = "simulate six-position --continuous --hold 4 --rest 2 --seed 11 -o . --quiet";
        ends(folder.path(), &format!("{line} {raw}"), 0);
        let file = calibrate(folder.path(), "session.csv -o cal.json", 0);
        assert!(file["gyroscope"].is_object(), "{raw}");
        agrees(&python, folder.path(), accel_size, gyro_size);
    }
}
