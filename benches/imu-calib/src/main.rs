//! Reads accelerometer and gyroscope of one session from two files (seconds and
//! three counts a row, gzip), and calibrates it with the crate imu-calib.
//!
//!     bench-imu-calib ACC.txt.gz GYRO.txt.gz GRAVITY
//!
//! imu-calib takes m/s² and rad/s: the counts are converted with the scale and
//! offset that an Xsens MTi has by its data sheet, or nearly so.

use std::fs::File;
use std::io::{BufRead, BufReader};

use anyhow::{Context, Result};
use flate2::read::GzDecoder;
use imu_calib::estimate::{RecordingConfig, calibrate_recording};

const OFFSET: f64 = 32768.0;
const ACCEL_COUNTS_PER_MPS2: f64 = 414.0;
const GYRO_COUNTS_PER_RAD_S: f64 = 4778.0;

fn read(path: &str) -> Result<Vec<(f64, [f64; 3])>> {
    let file = BufReader::with_capacity(1 << 18, GzDecoder::new(File::open(path)?));
    let mut rows = Vec::new();
    for line in file.lines() {
        let line = line?;
        let fields: Vec<f64> = line
            .split([' ', '\t', ',', ';'])
            .filter(|f| !f.is_empty())
            .map(|f| f.parse().with_context(|| format!("{path}: {f}")))
            .collect::<Result<_>>()?;
        let [t, x, y, z] = fields[..] else {
            anyhow::bail!("{path}: four numbers a row are wanted: {line}");
        };
        rows.push((t, [x, y, z]));
    }
    Ok(rows)
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [accel, gyro, gravity] = &arguments[..] else {
        anyhow::bail!("bench-imu-calib ACC GYRO GRAVITY");
    };
    let samples: Vec<_> = read(accel)?
        .into_iter()
        .zip(read(gyro)?)
        .map(|((t, a), (_, w))| {
            (
                t,
                a.map(|v| (v - OFFSET) / ACCEL_COUNTS_PER_MPS2),
                w.map(|v| (v - OFFSET) / GYRO_COUNTS_PER_RAD_S),
            )
        })
        .collect();
    let config = RecordingConfig {
        gravity: gravity.parse()?,
        ..RecordingConfig::default()
    };
    let calibration = calibrate_recording(&samples, &config)?;
    println!("{}", calibration.report.summary());
    Ok(())
}
