//! Real recordings of other people; skipped without GRAVICAL_DATA.

use std::path::PathBuf;

use gravical_recording::{AccelUnit, Recording};

use crate::support::has_rate;

/// Rows, unit, gyroscope and rate as the owners of the files state them.
const FILES: [(&str, usize, AccelUnit, bool, Option<f64>); 13] = [
    (
        "airbrakes-sixmoves/xplus.csv",
        1519,
        AccelUnit::G,
        true,
        Some(1000.0),
    ),
    (
        "broad-translation/14_undisturbed_slow_translation_with_breaks_B.csv.gz",
        55_402,
        AccelUnit::Mps2,
        true,
        Some(285.714),
    ),
    (
        "gaitmap-example/imu_sample.csv.gz",
        7928,
        AccelUnit::Mps2,
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
        AccelUnit::Mps2,
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
        AccelUnit::Mps2,
        true,
        None,
    ),
    (
        "opensim-imu/apdm_imuData01.csv.gz",
        1024,
        AccelUnit::Mps2,
        true,
        Some(128.0),
    ),
    (
        "skdh-axivity/ax6_decoded.csv.gz",
        10_360,
        AccelUnit::G,
        true,
        Some(98.4),
    ),
    (
        "tofupilot-thermal/part1_rows0-5249.tsv",
        5250,
        AccelUnit::Mps2,
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
        AccelUnit::G,
        true,
        Some(400.0),
    ),
];

#[test]
fn real_recordings_are_read_as_their_owners_describe_them() {
    let Some(data) = std::env::var_os("GRAVICAL_DATA").map(PathBuf::from) else {
        println!("skipped: GRAVICAL_DATA is not set");
        return;
    };
    for (file, rows, unit, has_gyro, rate_hz) in FILES {
        let recording = Recording::open(&data.join(file)).unwrap();
        assert_eq!(recording.rows(), rows, "{file}");
        assert_eq!(
            recording.rows() + recording.aside.total(),
            recording.aside.lines,
            "{file}"
        );
        assert_eq!(recording.accel_scale.unit, Some(unit), "{file}");
        assert_eq!(recording.gyro.is_some(), has_gyro, "{file}");
        assert!(
            rate_hz.is_none_or(|r| has_rate(&recording, r)),
            "{file}: {:?}",
            recording.rate_hz
        );
    }
}
