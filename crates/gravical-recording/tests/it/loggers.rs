//! Loggers that print words around their numbers.

use gravical_recording::AccelUnit;

use crate::support::{FACE_ROWS, RATE_HZ, Row, has_rate, is_near, read, six_faces};

/// A print: what one row looks like, the unit, and whether it has a gyroscope and a clock.
struct Print {
    name: &'static str,
    write: fn(usize, &Row) -> String,
    unit: AccelUnit,
    has_gyro: bool,
    has_clock: bool,
}

fn mps2(row: &Row) -> [f64; 3] {
    row.accel_g.map(|g| g * 9.80665)
}

fn counts(row: &Row) -> [i64; 3] {
    row.accel_g.map(|g| (g * 16_384.0).round() as i64)
}

const PRINTS: [Print; 10] = [
    Print {
        name: "Adafruit",
        write: |_, r| {
            let ([x, y, z], [gx, gy, gz]) = (mps2(r), r.gyro_deg_s.map(f64::to_radians));
            format!(
                "Acceleration X: {x:.4}, Y: {y:.4}, Z: {z:.4} m/s^2\nRotation X: {gx:.4}, Y: \
                 {gy:.4}, Z: {gz:.4} rad/s\nTemperature: {:.2} degC\n\n",
                r.temperature_c
            )
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: true,
        has_clock: false,
    },
    Print {
        name: "i2cdevlib",
        write: |_, r| {
            let ([x, y, z], [gx, gy, gz]) = (counts(r), r.gyro_deg_s.map(|w| (w * 131.0) as i64));
            format!("a/g:\t{x}\t{y}\t{z}\t{gx}\t{gy}\t{gz}\n")
        },
        unit: AccelUnit::Counts,
        has_gyro: true,
        has_clock: false,
    },
    Print {
        name: "key equals value",
        write: |_, r| {
            let ([x, y, z], [gx, gy, gz]) = (r.accel_g, r.gyro_deg_s);
            format!(
                "aX = {x:.5} | aY = {y:.5} | aZ = {z:.5} | tmp = 27.31 | gX = {gx:.3} | gY = \
                 {gy:.3} | gZ = {gz:.3}\n"
            )
        },
        unit: AccelUnit::StandardGravity,
        has_gyro: true,
        has_clock: false,
    },
    Print {
        name: "Serial Monitor",
        write: |k, r| {
            let [x, y, z] = mps2(r);
            format!(
                "14:03:{:06.3} -> {x:.4},{y:.4},{z:.4}\n",
                k as f64 / RATE_HZ
            )
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: false,
        has_clock: true,
    },
    Print {
        name: "SparkFun",
        write: |_, r| {
            let ([x, y, z], [gx, gy, gz]) = (r.accel_g.map(|g| g * 1000.0), r.gyro_deg_s);
            format!(
                "Scaled. Acc (mg) [ {x:08.2}, {y:08.2}, {z:08.2} ], Gyr (DPS) [ {gx:06.2}, \
                 {gy:06.2}, {gz:06.2} ]\n"
            )
        },
        unit: AccelUnit::MilliGravity,
        has_gyro: true,
        has_clock: false,
    },
    Print {
        name: "esp-idf",
        write: |k, r| {
            let [x, y, z] = r.accel_g;
            format!(
                "I ({}) mpu6050: acc_x:{x:.5}, acc_y:{y:.5}, acc_z:{z:.5}\n",
                320 + 40 * k
            )
        },
        unit: AccelUnit::StandardGravity,
        has_gyro: false,
        has_clock: true,
    },
    Print {
        name: "tuples",
        write: |k, r| {
            let ([x, y, z], [gx, gy, gz]) = (mps2(r), r.gyro_deg_s);
            let t = k as f64 / RATE_HZ;
            format!("{t:.3}: acc=({x:.4}, {y:.4}, {z:.4}) gyro=({gx:.3}, {gy:.3}, {gz:.3})\n")
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: true,
        has_clock: true,
    },
    Print {
        name: "JSON lines",
        write: |k, r| {
            let [x, y, z] = r.accel_g;
            format!(
                "{{\"ms\": {}, \"ax\": {x:.5}, \"ay\": {y:.5}, \"az\": {z:.5}}}\n",
                40 * k
            )
        },
        unit: AccelUnit::StandardGravity,
        has_gyro: false,
        has_clock: true,
    },
    Print {
        name: "decimal commas",
        write: |_, r| {
            let [x, y, z] = r.accel_g;
            format!("ax={x:.5}; ay={y:.5}; az={z:.5}\n").replace('.', ",")
        },
        unit: AccelUnit::StandardGravity,
        has_gyro: false,
        has_clock: false,
    },
    Print {
        name: "one value a line",
        write: |_, r| {
            let [x, y, z] = r.accel_g;
            format!("accX: {x:.5}\naccY: {y:.5}\naccZ: {z:.5}\n---\n")
        },
        unit: AccelUnit::StandardGravity,
        has_gyro: false,
        has_clock: false,
    },
];

#[test]
fn numbers_wrapped_in_words_become_columns() {
    let rows = six_faces(2);
    for print in &PRINTS {
        let text: String = rows
            .iter()
            .enumerate()
            .map(|(k, r)| (print.write)(k, r))
            .collect();
        let text = format!("Starting sensor...\nFound it!\n{text}");
        let recording = read(&text, "log.txt");
        let name = print.name;
        assert_eq!(recording.rows(), rows.len(), "{name}");
        assert_eq!(recording.accel_scale.unit, print.unit, "{name}");
        assert_eq!(recording.gyro.is_some(), print.has_gyro, "{name}");
        assert_eq!(
            recording.timing.rate_hz().is_some(),
            print.has_clock,
            "{name}"
        );
        assert!(!print.has_clock || has_rate(&recording, RATE_HZ), "{name}");
        let scale = recording.accel_scale.nominal().unwrap().recip() / 9.80665;
        for (k, row) in rows.iter().enumerate() {
            for axis in 0..3 {
                let value_g = recording.accel[axis][k] * scale;
                assert!(
                    is_near(value_g, row.accel_g[axis], 1e-4),
                    "{name}, row {k}: {value_g}"
                );
            }
        }
    }
}

/// A comment with as many parts as there are columns is no header if it names no sensor.
#[test]
fn a_comment_above_the_rows_is_no_header() {
    let rows = six_faces(4);
    let lines = rows.iter().enumerate().map(|(k, r)| {
        let [x, y, z] = r.accel_g;
        format!("{},{x:.4},{y:.4},{z:.4}\n", 40 * k)
    });
    let rows: String = lines.collect();
    for comment in [
        "# the lab, 2026-01-01, Anna",
        "# Uno, at 25 Hz, on the table, Anna",
    ] {
        let recording = read(&format!("{comment}\n{rows}"), "desk.csv");
        assert!(has_rate(&recording, RATE_HZ), "{:?}", recording.timing);
        assert_eq!(recording.accel_scale.unit, AccelUnit::StandardGravity);
    }
}

/// A table that another tool writes: its header, its rows, and the unit of the accelerometer.
type Table = (
    &'static str,
    fn(usize, [f64; 3], [f64; 3]) -> String,
    AccelUnit,
);

const COVARIANCE: &str = "0,0,0,0,0,0,0,0,0";

/// What the hints about bags and logs name.
const TABLES: [Table; 4] = [
    // ros2 topic echo --csv
    (
        "",
        |k, [x, y, z], [u, v, w]| {
            let ms = 40 * k;
            format!(
                "{},{},imu,0,0,0,1,{COVARIANCE},{u},{v},{w},{COVARIANCE},{x},{y},{z},{COVARIANCE}",
                1_700_000_000 + ms / 1000,
                ms % 1000 * 1_000_000
            )
        },
        AccelUnit::MetrePerSecondSquared,
    ),
    // rostopic echo -p
    (
        "%time,field.angular_velocity.x,field.angular_velocity.y,field.angular_velocity.z,field.linear_acceleration.x,field.linear_acceleration.y,field.linear_acceleration.z",
        |k, [x, y, z], [u, v, w]| {
            format!(
                "{},{u},{v},{w},{x},{y},{z}",
                1_700_000_000_000_000_000 + 40_000_000 * k as u64
            )
        },
        AccelUnit::MetrePerSecondSquared,
    ),
    // ulog2csv
    (
        "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,accelerometer_timestamp_relative,accelerometer_m_s2[0],accelerometer_m_s2[1],accelerometer_m_s2[2],accelerometer_integral_dt",
        |k, [x, y, z], [u, v, w]| {
            format!(
                "{},{u},{v},{w},40000,0,{x},{y},{z},40000",
                112_233 + 40_000 * k
            )
        },
        AccelUnit::MetrePerSecondSquared,
    ),
    // blackbox_decode: counts, 2048 per g
    (
        "loopIteration, time (us), axisP[0], axisP[1], axisP[2], gyroADC[0], gyroADC[1], gyroADC[2], accSmooth[0], accSmooth[1], accSmooth[2], motor[0]",
        |k, a, g| {
            let [x, y, z] = a.map(|v| (2048.0 / 9.80665 * v).round());
            let [u, v, w] = g.map(|v| v.to_degrees().round());
            format!(
                "{k}, {}, 0, 0, 0, {u}, {v}, {w}, {x}, {y}, {z}, 1000",
                40_000 * k
            )
        },
        AccelUnit::Counts,
    ),
];

#[test]
fn tables_of_converters_are_read() {
    let rows = six_faces(3);
    for (header, row, unit) in &TABLES {
        let lines = rows.iter().enumerate().map(|(k, r)| {
            let accel = r.accel_g.map(|v| 9.80665 * v);
            row(k, accel, r.gyro_deg_s.map(f64::to_radians)) + "\n"
        });
        let header = if header.is_empty() {
            String::new()
        } else {
            format!("{header}\n")
        };
        let recording = read(&(header + &lines.collect::<String>()), "imu.csv");
        assert_eq!(recording.rows(), rows.len());
        assert_eq!(recording.accel_scale.unit, *unit);
        assert!(has_rate(&recording, RATE_HZ), "{:?}", recording.timing);
        let scale = recording.accel_scale.nominal().unwrap();
        let up = recording.accel[2][4 * FACE_ROWS + 5] / scale / 9.80665;
        assert!(is_near(up, 1.05, 0.01), "{up}");
        assert!(recording.gyro.is_some());
    }
}
