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

const SHAPES: &[Shape] = &[
    Shape {
        name: "phyphox, one sensor a file",
        file_name: "Accelerometer.csv",
        header: "\"Time (s)\",\"X (m/s^2)\",\"Y (m/s^2)\",\"Z (m/s^2)\"\n",
        write: |k, [x, y, z], _| {
            format!(
                "{:E},{:E},{:E},{:E}",
                k as f64 / RATE_HZ,
                x * G,
                y * G,
                z * G
            )
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: false,
        has_clock: true,
    },
    Shape {
        name: "Sensor Logger",
        file_name: "TotalAcceleration.csv",
        header: "time,seconds_elapsed,z,y,x\n",
        write: |k, [x, y, z], _| {
            let (t, elapsed) = (
                1_700_000_000_000_000_000 + 40_000_000 * k,
                k as f64 / RATE_HZ,
            );
            format!("{t},{elapsed:.3},{:.5},{:.5},{:.5}", z * G, y * G, x * G)
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: false,
        has_clock: true,
    },
    Shape {
        name: "Physics Toolbox",
        file_name: "",
        header: "time;gFx;gFy;gFz;TgF\n",
        write: |k, [x, y, z], _| {
            let tenths_ms = 400 * k;
            let (s, f) = (tenths_ms / 10_000, tenths_ms % 10_000);
            format!("11:41:{s:02}:{f:04};{x:.4};{y:.4};{z:.4};1,000").replace('.', ",")
        },
        unit: AccelUnit::StandardGravity,
        has_gyro: false,
        has_clock: true,
    },
    Shape {
        name: "EuRoC",
        file_name: "data.csv",
        header: "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad \
                 s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n",
        write: |k, a, w| {
            let ([x, y, z], [gx, gy, gz]) = (a.map(|v| v * G), w.map(f64::to_radians));
            format!(
                "{},{gx},{gy},{gz},{x},{y},{z}",
                1_403_636_579_758_555_392 + 40_000_000 * k as u64
            )
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: true,
        has_clock: true,
    },
    Shape {
        name: "rostopic echo -p",
        file_name: "",
        header: "%time,field.header.seq,field.header.stamp,field.angular_velocity.x,field.\
                 angular_velocity.y,field.angular_velocity.z,field.linear_acceleration.x,field.\
                 linear_acceleration.y,field.linear_acceleration.z\n",
        write: |k, a, w| {
            let ([x, y, z], [gx, gy, gz]) = (a.map(|v| v * G), w.map(f64::to_radians));
            let t = 1_600_000_000_000_000_000 + 40_000_000 * k as u64;
            format!("{t},{k},{t},{gx},{gy},{gz},{x},{y},{z}")
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: true,
        has_clock: true,
    },
    Shape {
        name: "PX4 sensor_combined",
        file_name: "",
        header: "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,\
                 accelerometer_timestamp_relative,accelerometer_m_s2[0],accelerometer_m_s2[1],\
                 accelerometer_m_s2[2],accelerometer_integral_dt\n",
        write: |k, a, w| {
            let ([x, y, z], [gx, gy, gz]) = (a.map(|v| v * G), w.map(f64::to_radians));
            format!(
                "{},{gx},{gy},{gz},40000,0,{x},{y},{z},40000",
                3_000_000 + 40_000 * k
            )
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: true,
        has_clock: true,
    },
    Shape {
        name: "Betaflight",
        file_name: "",
        header: "loopIteration, time (us), gyroADC[0], gyroADC[1], gyroADC[2], accSmooth[0], \
                 accSmooth[1], accSmooth[2]\n",
        write: |k, a, [gx, gy, gz]| {
            let [x, y, z] = a.map(|v| v * 2048.0);
            format!(
                "{k}, {}, {gx:.0}, {gy:.0}, {gz:.0}, {x:.0}, {y:.0}, {z:.0}",
                40_000 * k
            )
        },
        unit: AccelUnit::Counts,
        has_gyro: true,
        has_clock: true,
    },
    Shape {
        name: "Axivity",
        file_name: "",
        header: "",
        write: |k, [x, y, z], _| {
            format!(
                "2017-05-19 14:31:{:06.3},{x:.5},{y:.5},{z:.5}",
                k as f64 / RATE_HZ
            )
        },
        unit: AccelUnit::StandardGravity,
        has_gyro: false,
        has_clock: true,
    },
    Shape {
        name: "Shimmer",
        file_name: "",
        header: "\"sep=\\t\"\nS_Timestamp_CAL\tS_Accel_LN_X_CAL\tS_Accel_LN_Y_CAL\tS_Accel_LN_Z_CAL\t\
                 S_Accel_WR_X_CAL\tS_Accel_WR_Y_CAL\tS_Accel_WR_Z_CAL\t\nms\tm/(s^2)\tm/(s^2)\t\
                 m/(s^2)\tm/(s^2)\tm/(s^2)\tm/(s^2)\t\n",
        write: |k, a, _| {
            let [x, y, z] = a.map(|v| v * G);
            format!(
                "{}\t{x:.5}\t{y:.5}\t{z:.5}\t{:.5}\t{y:.5}\t{z:.5}\t",
                1e12 + 40.0 * k as f64,
                x + 0.5
            )
        },
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: false,
        has_clock: true,
    },
    Shape {
        name: "MbientLab",
        file_name: "MetaWear_Accelerometer.csv",
        header: "epoc (ms),timestamp (+0200),elapsed (s),x-axis (g),y-axis (g),z-axis (g)\n",
        write: |k, [x, y, z], _| {
            let (ms, s) = (1_600_000_000_000_u64 + 40 * k as u64, k as f64 / RATE_HZ);
            format!(
                "{ms},2020-09-13T14:26:{:06.3},{s:.3},{x:.4},{y:.4},{z:.4}",
                s + 40.0
            )
        },
        unit: AccelUnit::StandardGravity,
        has_gyro: false,
        has_clock: true,
    },
    Shape {
        name: "x-io",
        file_name: "",
        header: "Time (s),Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),\
                 Accelerometer X (g),Accelerometer Y (g),Accelerometer Z (g)\n",
        write: |k, [x, y, z], [gx, gy, gz]| {
            format!("{:.6},{gx},{gy},{gz},{x},{y},{z}", k as f64 / RATE_HZ)
        },
        unit: AccelUnit::StandardGravity,
        has_gyro: true,
        has_clock: true,
    },
    Shape {
        name: "fixed width",
        file_name: "",
        header: "",
        write: |_, [x, y, z], _| format!("{:10.4}{:10.4}{:10.4}", x * G, y * G, z * G),
        unit: AccelUnit::MetrePerSecondSquared,
        has_gyro: false,
        has_clock: false,
    },
];

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
        assert_eq!(
            has_rate(&recording, RATE_HZ),
            shape.has_clock,
            "{name}: {:?}",
            recording.timing.rate_hz()
        );
        let scale = recording.accel_scale.nominal().unwrap().recip() / G;
        for (k, row) in rows.iter().enumerate() {
            for axis in 0..3 {
                let value_g = recording.accel[axis][k] * scale;
                assert!(
                    is_near(value_g, row.accel_g[axis], 5e-4),
                    "{name}, row {k}: {value_g}"
                );
            }
        }
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
        assert_eq!(recording.accel.map(|axis| axis[0]), [2.2, 3.3, 4.4]);
    }
}
