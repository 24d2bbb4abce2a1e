//! Loggers that print words around their numbers.

use gravical_recording::AccelUnit;

use crate::support::{RATE_HZ, Row, has_rate, is_near, read, six_faces};

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
        assert_eq!(recording.rate_hz().is_some(), print.has_clock, "{name}");
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
