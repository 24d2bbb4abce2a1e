//! Real recordings of other people; skipped without GRAVICAL_DATA.

use std::path::PathBuf;

use gravical_recording::{ReadOptions, read};

use crate::support::has_rate;

/// Rows, unit, gyroscope and rate as the owners of the files state them; then the cases that are a
/// reader's.
const FILES: &str = "\
airbrakes-sixmoves/xplus.csv 1519 g gyro 1000
broad-translation/14_undisturbed_slow_translation_with_breaks_B.csv.gz 55402 m/s^2 gyro 285.714
gaitmap-example/imu_sample.csv.gz 7928 m/s^2 gyro -
imu_tk-xsens/xsens_acc.txt.gz 51175 counts - 100
imucal-ferraris/annotated_session.csv 9414 counts gyro -
mikoff-mpu9150/imu0.log 15969 m/s^2 gyro -
mjs513-handheld/acc_A.txt.gz 90400 counts - -
openshoe-square2/square2_u.csv 8687 m/s^2 gyro -
opensim-imu/apdm_imuData01.csv.gz 1024 m/s^2 gyro 128
skdh-axivity/ax6_decoded.csv.gz 10360 g gyro 98.4
tofupilot-thermal/part1_rows0-5249.tsv 5250 m/s^2 gyro -
tomisuarez-mpu6050/calibration.csv 10245 counts gyro 100
xio-gait/short_walk.csv 16539 g gyro 400
../cases/cloud-of-means/acceldata.txt 120 g - -
../cases/coarse-gyro-called-frozen/blackbox.csv 1135 counts gyro 25
../cases/date-stamps-lost/excel_de.csv 1135 g - 25
../cases/date-stamps-lost/matlab_mobile.csv 1135 m/s^2 - 25
../cases/decorated-lines/adafruit_mpu6050.txt 1135 m/s^2 gyro -
../cases/decorated-lines/jrowberg_raw.txt 1135 counts gyro -
../cases/decorated-lines/key_equals.txt 1135 g gyro -
../cases/decorated-lines/serial_monitor.txt 1135 m/s^2 gyro 25
../cases/header-in-another-language/phyphox_de.csv 1135 m/s^2 - 25
../cases/header-in-another-language/witmotion_cn.csv 1135 g gyro 25
../cases/hung-sensor/move_0m7.csv 1061 m/s^2 gyro 100
../cases/mg-called-counts/sensortile.csv 1135 mg gyro 25
../cases/step-column-named-t/trajectory.csv 1135 g - 25
../cases/time-10ms/blue_coin.csv 1135 mg gyro 25
../cases/unsigned-16bit/mpu6050_raw.csv 1135 counts gyro 25
../cases/zeros-over-half/idle_sleep.csv 1235 g - 25";

#[test]
fn real_recordings_are_read_as_their_owners_describe_them() {
    let Some(data) = std::env::var_os("GRAVICAL_DATA").map(PathBuf::from) else {
        println!("skipped: GRAVICAL_DATA is not set");
        return;
    };
    for line in FILES.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let [file, rows, unit, gyro, rate_hz] = words[..] else {
            panic!("{line}")
        };
        let own = read(data.join(file), &ReadOptions::default()).unwrap();
        assert_eq!(own.rows().to_string(), rows, "{file}");
        assert_eq!(own.rows() + own.ledger.total(), own.ledger.lines, "{file}");
        assert_eq!(own.units.accel.unit.name(), unit, "{file}");
        assert_eq!(own.gyro.is_some(), gyro == "gyro", "{file}");
        let rate_hz: Option<f64> = rate_hz.parse().ok();
        let is_it = rate_hz.is_none_or(|r| has_rate(&own, r));
        assert!(is_it, "{file}: {:?}", own.clock.rate_hz());
    }
}
