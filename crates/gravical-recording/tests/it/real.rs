//! Real recordings of other people; skipped without GRAVICAL_DATA.

use std::path::PathBuf;

use gravical_recording::{AccelUnit, ReadOptions, Recording};

use crate::support::has_rate;

/// Rows, unit, gyroscope and rate as the owners of the files state them.
const FILES: [(&str, usize, AccelUnit, bool, Option<f64>); 13] = [
    (
        "airbrakes-sixmoves/xplus.csv",
        1519,
        AccelUnit::StandardGravity,
        true,
        Some(1000.0),
    ),
    (
        "broad-translation/14_undisturbed_slow_translation_with_breaks_B.csv.gz",
        55_402,
        AccelUnit::MetrePerSecondSquared,
        true,
        Some(285.714),
    ),
    (
        "gaitmap-example/imu_sample.csv.gz",
        7928,
        AccelUnit::MetrePerSecondSquared,
        true,
        None,
    ),
    (
        "imu_tk-xsens/xsens_acc.txt.gz",
        51_175,
        AccelUnit::Counts,
        false,
        Some(100.0),
    ),
    (
        "imucal-ferraris/annotated_session.csv",
        9414,
        AccelUnit::Counts,
        true,
        None,
    ),
    (
        "mikoff-mpu9150/imu0.log",
        15_969,
        AccelUnit::MetrePerSecondSquared,
        true,
        None,
    ),
    (
        "mjs513-handheld/acc_A.txt.gz",
        90_400,
        AccelUnit::Counts,
        false,
        None,
    ),
    (
        "openshoe-square2/square2_u.csv",
        8687,
        AccelUnit::MetrePerSecondSquared,
        true,
        None,
    ),
    (
        "opensim-imu/apdm_imuData01.csv.gz",
        1024,
        AccelUnit::MetrePerSecondSquared,
        true,
        Some(128.0),
    ),
    (
        "skdh-axivity/ax6_decoded.csv.gz",
        10_360,
        AccelUnit::StandardGravity,
        true,
        Some(98.4),
    ),
    (
        "tofupilot-thermal/part1_rows0-5249.tsv",
        5250,
        AccelUnit::MetrePerSecondSquared,
        true,
        None,
    ),
    (
        "tomisuarez-mpu6050/calibration.csv",
        10_245,
        AccelUnit::Counts,
        true,
        Some(100.0),
    ),
    (
        "xio-gait/short_walk.csv",
        16_539,
        AccelUnit::StandardGravity,
        true,
        Some(400.0),
    ),
];

/// The cases that are a reader's.
const CASES: [(&str, usize, AccelUnit, bool, Option<f64>); 16] = [
    (
        "cloud-of-means/acceldata.txt",
        120,
        AccelUnit::StandardGravity,
        false,
        None,
    ),
    (
        "coarse-gyro-called-frozen/blackbox.csv",
        1135,
        AccelUnit::Counts,
        true,
        Some(25.0),
    ),
    (
        "date-stamps-lost/excel_de.csv",
        1135,
        AccelUnit::StandardGravity,
        false,
        Some(25.0),
    ),
    (
        "date-stamps-lost/matlab_mobile.csv",
        1135,
        AccelUnit::MetrePerSecondSquared,
        false,
        Some(25.0),
    ),
    (
        "decorated-lines/adafruit_mpu6050.txt",
        1135,
        AccelUnit::MetrePerSecondSquared,
        true,
        None,
    ),
    (
        "decorated-lines/jrowberg_raw.txt",
        1135,
        AccelUnit::Counts,
        true,
        None,
    ),
    (
        "decorated-lines/key_equals.txt",
        1135,
        AccelUnit::StandardGravity,
        true,
        None,
    ),
    (
        "decorated-lines/serial_monitor.txt",
        1135,
        AccelUnit::MetrePerSecondSquared,
        true,
        Some(25.0),
    ),
    (
        "header-in-another-language/phyphox_de.csv",
        1135,
        AccelUnit::MetrePerSecondSquared,
        false,
        Some(25.0),
    ),
    (
        "header-in-another-language/witmotion_cn.csv",
        1135,
        AccelUnit::StandardGravity,
        true,
        Some(25.0),
    ),
    (
        "hung-sensor/move_0m7.csv",
        1061,
        AccelUnit::MetrePerSecondSquared,
        true,
        Some(100.0),
    ),
    (
        "mg-called-counts/sensortile.csv",
        1135,
        AccelUnit::MilliGravity,
        true,
        Some(25.0),
    ),
    (
        "step-column-named-t/trajectory.csv",
        1135,
        AccelUnit::StandardGravity,
        false,
        Some(25.0),
    ),
    (
        "time-10ms/blue_coin.csv",
        1135,
        AccelUnit::MilliGravity,
        true,
        Some(25.0),
    ),
    (
        "unsigned-16bit/mpu6050_raw.csv",
        1135,
        AccelUnit::Counts,
        true,
        Some(25.0),
    ),
    (
        "zeros-over-half/idle_sleep.csv",
        1235,
        AccelUnit::StandardGravity,
        false,
        Some(25.0),
    ),
];

#[test]
fn real_recordings_are_read_as_their_owners_describe_them() {
    let Some(data) = std::env::var_os("GRAVICAL_DATA").map(PathBuf::from) else {
        println!("skipped: GRAVICAL_DATA is not set");
        return;
    };
    let cases = CASES.map(|(file, rows, unit, gyro, rate)| {
        (PathBuf::from("../cases").join(file), rows, unit, gyro, rate)
    });
    let files = FILES.map(|(file, rows, unit, gyro, rate)| (file.into(), rows, unit, gyro, rate));
    for (file, rows, unit, has_gyro, rate_hz) in files.into_iter().chain(cases) {
        let path = data.join(&file);
        let file = file.display();
        let recording = Recording::open(&path, &ReadOptions::default()).unwrap();
        assert_eq!(recording.rows(), rows, "{file}");
        assert_eq!(
            recording.rows() + recording.aside.total(),
            recording.aside.lines,
            "{file}"
        );
        assert_eq!(recording.accel_scale.unit, unit, "{file}");
        assert_eq!(recording.gyro.is_some(), has_gyro, "{file}");
        assert!(
            rate_hz.is_none_or(|r| has_rate(&recording, r)),
            "{file}: {:?}",
            recording.rate_hz()
        );
    }
}
