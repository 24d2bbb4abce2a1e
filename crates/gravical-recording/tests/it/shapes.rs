//! The first lines of loggers and apps as they write them.

use gravical_recording::{AccelUnit, ReadOptions, Recording};

use crate::support::{RATE_HZ, has_rate, is_near, read, six_faces};

/// A logger: its file name and header, how a row is written, and what it holds.
struct Shape {
    name: &'static str,
    file_name: &'static str,
    header: &'static str,
    /// Of the row, specific force in g and angular rate in °/s.
    write: fn(usize, [f64; 3], [f64; 3]) -> String,
    unit: AccelUnit,
    has_gyro: bool,
    has_clock: bool,
}

const G: f64 = 9.80665;
const COVARIANCE: &str = "0,0,0,0,0,0,0,0,0";

/// What most of them have in common.
const SHAPE: Shape = Shape {
    name: "fixed width",
    file_name: "",
    header: "",
    write: |_, [x, y, z], _| format!("{:10.4}{:10.4}{:10.4}", x * G, y * G, z * G),
    unit: AccelUnit::StandardGravity,
    has_gyro: false,
    has_clock: false,
};

/// Words around the numbers.
const PRINT: Shape = Shape {
    file_name: "log.txt",
    header: "Starting sensor...\nFound it!\n",
    ..SHAPE
};

const SHAPES: &[Shape] = &[
    Shape {
        unit: AccelUnit::MetrePerSecondSquared,
        ..SHAPE
    },
    Shape {
        name: "Sensor Logger",
        file_name: "TotalAcceleration.csv",
        header: "time,seconds_elapsed,z,y,x\n",
        write: |k, a, _| {
            let [x, y, z] = a.map(|v| v * G);
            let (t, s) = (1_700_000_000_000_000_000 + 40_000_000 * k, seconds(k));
            format!("{t},{s:.3},{z:.5},{y:.5},{x:.5}")
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_clock: true,
        ..SHAPE
    },
    Shape {
        name: "Physics Toolbox",
        header: "time;gFx;gFy;gFz;TgF\n",
        write: |k, [x, y, z], _| {
            let (s, tenths_ms) = (k / 25, 400 * k % 10_000);
            format!("11:41:{s:02}:{tenths_ms:04};{x:.4};{y:.4};{z:.4};1,000").replace('.', ",")
        },
        has_clock: true,
        ..SHAPE
    },
    Shape {
        name: "ros2 topic echo --csv",
        write: |k, a, w| {
            let ([x, y, z], [u, v, w]) = (a.map(|v| v * G), w.map(f64::to_radians));
            let (s, ns) = (1_700_000_000 + k / 25, k % 25 * 40_000_000);
            format!(
                "{s},{ns},imu,0,0,0,1,{COVARIANCE},{u},{v},{w},{COVARIANCE},{x},{y},{z},{COVARIANCE}"
            )
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: true,
        has_clock: true,
        ..SHAPE
    },
    Shape {
        name: "rostopic echo -p",
        header: "%time,field.header.seq,field.header.stamp,field.angular_velocity.x,field.\
                 angular_velocity.y,field.angular_velocity.z,field.linear_acceleration.x,field.\
                 linear_acceleration.y,field.linear_acceleration.z\n",
        write: |k, a, w| {
            let ([x, y, z], [u, v, w]) = (a.map(|v| v * G), w.map(f64::to_radians));
            let t = 1_600_000_000_000_000_000 + 40_000_000 * k as u64;
            format!("{t},{k},{t},{u},{v},{w},{x},{y},{z}")
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: true,
        has_clock: true,
        ..SHAPE
    },
    Shape {
        name: "ulog2csv",
        header: "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,\
                 accelerometer_timestamp_relative,accelerometer_m_s2[0],accelerometer_m_s2[1],\
                 accelerometer_m_s2[2],accelerometer_integral_dt\n",
        write: |k, a, w| {
            let ([x, y, z], [u, v, w]) = (a.map(|v| v * G), w.map(f64::to_radians));
            let us = 112_233 + 40_000 * k;
            format!("{us},{u},{v},{w},40000,0,{x},{y},{z},40000")
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: true,
        has_clock: true,
        ..SHAPE
    },
    Shape {
        name: "blackbox_decode",
        header: "loopIteration, time (us), axisP[0], axisP[1], axisP[2], gyroADC[0], gyroADC[1], \
                 gyroADC[2], accSmooth[0], accSmooth[1], accSmooth[2], motor[0]\n",
        write: |k, a, [u, v, w]| {
            let ([x, y, z], us) = (a.map(|v| v * 2048.0), 40_000 * k);
            format!("{k}, {us}, 0, 0, 0, {u:.0}, {v:.0}, {w:.0}, {x:.0}, {y:.0}, {z:.0}, 1000")
        },
        unit: AccelUnit::Counts,
        has_gyro: true,
        has_clock: true,
        ..SHAPE
    },
    Shape {
        name: "Axivity",
        write: |k, [x, y, z], _| {
            let s = seconds(k);
            format!("2017-05-19 14:31:{s:06.3},{x:.5},{y:.5},{z:.5}")
        },
        has_clock: true,
        ..SHAPE
    },
    Shape {
        name: "Shimmer",
        header: "\"sep=\\t\"\nS_Timestamp_CAL\tS_Accel_LN_X_CAL\tS_Accel_LN_Y_CAL\tS_Accel_LN_Z_CAL\t\
                 S_Accel_WR_X_CAL\tS_Accel_WR_Y_CAL\tS_Accel_WR_Z_CAL\t\nms\tm/(s^2)\tm/(s^2)\t\
                 m/(s^2)\tm/(s^2)\tm/(s^2)\tm/(s^2)\t\n",
        write: |k, a, _| {
            let ([x, y, z], ms) = (a.map(|v| v * G), 1e12 + 40.0 * k as f64);
            let other = x + 0.5;
            format!("{ms}\t{x:.5}\t{y:.5}\t{z:.5}\t{other:.5}\t{y:.5}\t{z:.5}\t")
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_clock: true,
        ..SHAPE
    },
    Shape {
        name: "MbientLab",
        file_name: "MetaWear_Accelerometer.csv",
        header: "epoc (ms),timestamp (+0200),elapsed (s),x-axis (g),y-axis (g),z-axis (g)\n",
        write: |k, [x, y, z], _| {
            let (ms, s) = (1_600_000_000_000_u64 + 40 * k as u64, seconds(k));
            let second = s + 40.0;
            format!("{ms},2020-09-13T14:26:{second:06.3},{s:.3},{x:.4},{y:.4},{z:.4}")
        },
        has_clock: true,
        ..SHAPE
    },
    Shape {
        name: "Adafruit",
        write: |_, a, w| {
            let ([x, y, z], [u, v, w]) = (a.map(|v| v * G), w.map(f64::to_radians));
            format!(
                "Acceleration X: {x:.4}, Y: {y:.4}, Z: {z:.4} m/s^2\nRotation X: {u:.4}, Y: {v:.4}, \
                 Z: {w:.4} rad/s\nTemperature: 27.31 degC\n"
            )
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: true,
        ..PRINT
    },
    Shape {
        name: "i2cdevlib",
        write: |_, a, w| {
            let [x, y, z] = a.map(|v| (v * 16_384.0).round());
            let [u, v, w] = w.map(|w| (w * 131.0).trunc());
            format!("a/g:\t{x}\t{y}\t{z}\t{u}\t{v}\t{w}")
        },
        unit: AccelUnit::Counts,
        has_gyro: true,
        ..PRINT
    },
    Shape {
        name: "key equals value",
        write: |_, [x, y, z], [u, v, w]| {
            format!(
                "aX = {x:.5} | aY = {y:.5} | aZ = {z:.5} | tmp = 27.31 | gX = {u:.3} | gY = \
                 {v:.3} | gZ = {w:.3}"
            )
        },
        has_gyro: true,
        ..PRINT
    },
    Shape {
        name: "Serial Monitor",
        write: |k, a, _| {
            let ([x, y, z], s) = (a.map(|v| v * G), seconds(k));
            format!("14:03:{s:06.3} -> {x:.4},{y:.4},{z:.4}")
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_clock: true,
        ..PRINT
    },
    Shape {
        name: "SparkFun",
        write: |_, a, [u, v, w]| {
            let [x, y, z] = a.map(|v| v * 1000.0);
            format!(
                "Scaled. Acc (mg) [ {x:08.2}, {y:08.2}, {z:08.2} ], Gyr (DPS) [ {u:06.2}, \
                 {v:06.2}, {w:06.2} ]"
            )
        },
        unit: AccelUnit::MilliGravity,
        has_gyro: true,
        ..PRINT
    },
    Shape {
        name: "esp-idf",
        write: |k, [x, y, z], _| {
            let ms = 320 + 40 * k;
            format!("I ({ms}) mpu6050: acc_x:{x:.5}, acc_y:{y:.5}, acc_z:{z:.5}")
        },
        has_clock: true,
        ..PRINT
    },
    Shape {
        name: "tuples",
        write: |k, a, [u, v, w]| {
            let ([x, y, z], s) = (a.map(|v| v * G), seconds(k));
            format!("{s:.3}: acc=({x:.4}, {y:.4}, {z:.4}) gyro=({u:.3}, {v:.3}, {w:.3})")
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: true,
        has_clock: true,
        ..PRINT
    },
    Shape {
        name: "JSON lines",
        write: |k, [x, y, z], _| {
            let ms = 40 * k;
            format!("{{\"ms\": {ms}, \"ax\": {x:.5}, \"ay\": {y:.5}, \"az\": {z:.5}}}")
        },
        has_clock: true,
        ..PRINT
    },
    Shape {
        name: "decimal commas",
        write: |_, [x, y, z], _| format!("ax={x:.5}; ay={y:.5}; az={z:.5}").replace('.', ","),
        ..PRINT
    },
    Shape {
        name: "one value a line",
        write: |_, [x, y, z], _| format!("accX: {x:.5}\naccY: {y:.5}\naccZ: {z:.5}\n---"),
        ..PRINT
    },
];

fn seconds(k: usize) -> f64 {
    k as f64 / RATE_HZ
}

#[test]
fn loggers_and_apps_are_read_without_options() {
    let rows = six_faces(4);
    for shape in SHAPES {
        let lines = rows.iter().enumerate();
        let lines = lines.map(|(k, r)| (shape.write)(k, r.accel_g, r.gyro_deg_s) + "\n");
        let text = format!("{}{}", shape.header, lines.collect::<String>());
        let recording = read(&text, shape.file_name);
        let name = shape.name;
        assert_eq!(recording.rows(), rows.len(), "{name}");
        assert_eq!(recording.accel_scale.unit, shape.unit, "{name}");
        assert_eq!(recording.gyro.is_some(), shape.has_gyro, "{name}");
        let rate_hz = recording.rate_hz();
        assert_eq!(rate_hz.is_some(), shape.has_clock, "{name}: {rate_hz:?}");
        assert!(
            !shape.has_clock || has_rate(&recording, RATE_HZ),
            "{name}: {rate_hz:?}"
        );
        let scale = recording.accel_scale.nominal().unwrap().recip() / G;
        let tolerance = if name == "blackbox_decode" {
            5e-4
        } else {
            1e-4
        };
        for (k, row) in rows.iter().enumerate() {
            for axis in 0..3 {
                let value_g = recording.accel[axis][k] * scale;
                assert!(
                    is_near(value_g, row.accel_g[axis], tolerance),
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

/// A pair of columns compared with each other one is 25 million comparisons a row.
#[test]
fn thousands_of_columns_are_read() {
    const SENSORS: usize = 1667;
    let names = |of: fn(usize, char) -> String| -> String {
        let sensor = |k: usize| ['x', 'y', 'z'].map(|axis| of(k, axis)).join(",");
        (0..SENSORS).map(sensor).collect::<Vec<_>>().join(",")
    };
    let rows: String = (0..20)
        .map(|row| {
            let values = (0..3 * SENSORS).map(|c| format!("{}.{}", c % 10, (row * 7 + c) % 10));
            values.collect::<Vec<_>>().join(",") + "\n"
        })
        .collect();
    for header in [
        names(|k, axis| format!("node{k}.acc.{axis}")),
        names(|k, _| format!("node{k}.acc")) + "\n" + &names(|_, axis| axis.to_string()),
    ] {
        let text = format!("{header}\n{rows}");
        let options = ReadOptions {
            sensor: Some("node1234".to_owned()),
            ..ReadOptions::default()
        };
        let recording = Recording::read(text.as_bytes(), "", &options).unwrap();
        assert_eq!(recording.accel_columns, [3702, 3703, 3704]);
    }
}
