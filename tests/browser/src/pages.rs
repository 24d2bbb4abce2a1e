//! The reports that are looked at: of simulated sessions, and of real ones where
//! `GRAVICAL_DATA` is set.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A report.
pub struct Page {
    pub name: String,
    pub path: PathBuf,
}

fn run(program: &Path, folder: &Path, line: &str) {
    let output = Command::new(program)
        .args(line.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap();
    let code = output.status.code().unwrap_or(1);
    let err = String::from_utf8_lossy(&output.stderr);
    // A poor verdict is no failure of the program.
    assert!(code == 0 || code == 4, "{line}: {code}\n{err}");
}

/// Every report, written into `folder`.
pub fn write(program: &Path, folder: &Path) -> Vec<Page> {
    let run = |folder: &Path, line: &str| run(program, folder, line);
    run(folder, "simulate six-position --output six --seed 3");
    run(folder, "simulate poses --output poses --seed 4");
    run(folder, "simulate line --output line --seed 5");
    run(folder, "simulate static --output static --seed 6");
    let mut lines = vec![
        ("six", "calibrate six -o six.json".to_owned()),
        ("ferraris", "calibrate six --method ferraris".to_owned()),
        (
            "poses",
            "calibrate poses/poses.csv -o poses.json".to_owned(),
        ),
        ("line", "motion line/line.csv".to_owned()),
        (
            "line-calibrated",
            "motion line/line.csv -c poses.json".to_owned(),
        ),
        (
            "static",
            "motion static/static.csv -c poses.json".to_owned(),
        ),
        ("check", "check poses.json six".to_owned()),
        ("compare", "compare poses.json six.json".to_owned()),
        ("inspect", "inspect poses/poses.csv".to_owned()),
        (
            "denoise",
            "denoise line/line.csv -o smooth.csv --filter hampel:7,3 --filter butter:4,5Hz"
                .to_owned(),
        ),
    ];
    match std::env::var("GRAVICAL_DATA") {
        Ok(data) => lines.extend([
            (
                "mpu6050",
                format!("calibrate {data}/tomisuarez-mpu6050/calibration.csv -o mpu.json"),
            ),
            (
                "mpu6050-motion",
                format!("motion {data}/tomisuarez-mpu6050/calibration.csv -c mpu.json"),
            ),
            (
                "xsens",
                format!("calibrate {data}/imu_tk-xsens/xsens_acc.txt.gz --gravity 9.81744"),
            ),
            (
                "chamber",
                format!("inspect {data}/tofupilot-thermal/part1_rows0-5249.tsv"),
            ),
            (
                "elevator",
                format!("motion {data}/pabrod-elevator/skyscrapper_up.csv"),
            ),
            ("walk", format!("motion {data}/xio-gait/short_walk.csv")),
        ]),
        Err(_) => println!("skipped: reports of real recordings, GRAVICAL_DATA is not set"),
    }
    lines
        .into_iter()
        .map(|(name, line)| {
            let file = format!("{name}.html");
            run(folder, &format!("{line} --json --report {file} --force"));
            Page {
                name: name.to_owned(),
                path: folder.join(file),
            }
        })
        .collect()
}
