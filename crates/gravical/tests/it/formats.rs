//! Formats of loggers and apps: each of these headers must be read without options, or the error
//! must name an option that works.

use gravical::apply::{ApplyOptions, apply};
use gravical::calibration_file::CalibrationFile;
use gravical::recording::open::from_reader;
use gravical::recording::{
    AccelUnit, GyroUnit, ReadOptions, Recording, TimeUnit, join_gyroscope_bytes, parse_columns,
    read_bytes,
};

use crate::support::*;

const ROWS: usize = 400;
const G: f64 = 9.80665;

/// Values of one row, from which a line is formatted.
struct Sample {
    i: usize,
    /// Seconds since the first row, 100 Hz.
    t_s: f64,
    /// g.
    a: [f64; 3],
    /// rad/s.
    w: [f64; 3],
}

/// A sensor at rest with z nearly up, 100 Hz, with a little noise.
fn sample(i: usize) -> Sample {
    let noise = |k: usize| ((i * (7 + 2 * k) + 13 * k) % 23) as f64 / 23.0 - 0.5;
    Sample {
        i,
        t_s: 0.01 * i as f64,
        a: [
            0.02 + 0.01 * noise(1),
            -0.03 + 0.01 * noise(2),
            1.0 + 0.01 * noise(3),
        ],
        w: [
            0.01 + 0.002 * noise(4),
            -0.02 + 0.002 * noise(5),
            0.03 + 0.002 * noise(6),
        ],
    }
}

/// `head`, followed by a line for every sample.
fn written(head: &str, row: impl Fn(&Sample) -> String) -> String {
    let rows = (0..ROWS).map(|i| row(&sample(i)) + "\n");
    head.to_owned() + &rows.collect::<String>()
}

fn csv(values: &[f64], decimals: usize) -> String {
    let cells = values.iter().map(|v| format!("{v:.decimals$}"));
    cells.collect::<Vec<_>>().join(",")
}

fn mps2(s: &Sample) -> [f64; 3] {
    s.a.map(|v| v * G)
}

fn deg(s: &Sample) -> [f64; 3] {
    s.w.map(f64::to_degrees)
}

fn counts(values: [f64; 3], per_unit: f64) -> [f64; 3] {
    values.map(|v| (v * per_unit).round())
}

fn read_as(text: &str, file: &str) -> Recording {
    let recording = read_bytes(text.as_bytes(), file, &ReadOptions::default())
        .unwrap_or_else(|e| panic!("{file}: {e}\n{}", &text[..text.len().min(300)]));
    assert!(recording.ledger.balances());
    recording
}

/// Checks the samples, in the recognised unit; the rate, Hz; the findings other than lines before
/// the header.
fn is_the_session(r: &Recording, what: &str, rate_hz: Option<f64>, findings: &[&str]) {
    assert_eq!(r.rows(), ROWS, "{what}: {}", r.ledger.sum());
    let nominal = r.accel_scale.nominal().unwrap_or_else(|| {
        panic!("{what}: {:?} {:?}", r.accel_scale, r.findings);
    });
    // Tolerance for the rounding of the samples, in g.
    let coarse = 0.51 / (nominal * G).min(50.0);
    for axis in 0..3 {
        let mean = mean(&r.accel[axis]) / nominal / G;
        assert!(
            (mean - [0.02, -0.03, 1.0][axis]).abs() < 0.5 * coarse,
            "{what}: {mean}"
        );
    }
    match rate_hz {
        Some(rate) => {
            let read = r.timing.rate_hz().unwrap_or(f64::NAN);
            assert!((read / rate - 1.0).abs() < 0.01, "{what}: {read} Hz");
        }
        None => assert_eq!(r.timing.rate_hz(), None, "{what}"),
    }
    let reported: Vec<&str> = kinds(r)
        .into_iter()
        .filter(|k| !["repeated-rows", "frozen-axis"].contains(k))
        .filter(|k| rate_hz.is_some() || *k != "rate-unknown")
        .collect();
    assert_eq!(reported, findings, "{what}");
}

fn has_gyro(r: &Recording, what: &str, unit: GyroUnit) {
    let scale = r
        .gyro_scale
        .unwrap_or_else(|| panic!("{what}: no gyroscope"));
    assert_eq!(scale.unit, unit, "{what}");
    let gyro = r.gyro.as_ref().unwrap();
    let per = scale.nominal().unwrap_or(1.0);
    close(mean(&gyro[2]) / per, 0.03, 0.002);
}

#[test]
fn apps_of_phones() {
    let name = "phyphox";
    let head = "\"Time (s)\",\"Acceleration x (m/s^2)\",\"Acceleration y (m/s^2)\",\"Acceleration z (m/s^2)\",\"Absolute acceleration (m/s^2)\"\n";
    let row = |s: &Sample| format!("{:.9E},{},{:.9E}", s.t_s, csv(&mps2(s), 9), G);
    let text = written(head, row);
    is_the_session(&read_as(&text, "Raw Data.csv"), name, Some(100.0), &[]);
    for delimiter in [";", "\t"] {
        let comma = written(head, row).replace(',', delimiter).replace('.', ",");
        is_the_session(&read_as(&comma, "Raw Data.csv"), name, Some(100.0), &[]);
    }
    let bare = "\"Time (s)\",\"X (m/s^2)\",\"Y (m/s^2)\",\"Z (m/s^2)\"\n";
    let accel = written(bare, |s| format!("{:.6},{}", s.t_s, csv(&mps2(s), 5)));
    let mut recording = read_as(&accel, "Accelerometer.csv");
    is_the_session(&recording, name, Some(100.0), &[]);
    // The gyroscope's file alone is refused, with a hint that works.
    let gyro = bare.replace("m/s^2", "rad/s");
    let gyro = written(&gyro, |s| format!("{:.6},{}", s.t_s, csv(&s.w, 5)));
    for file in ["Gyroscope.csv", "x.csv"] {
        let error = read_bytes(gyro.as_bytes(), file, &ReadOptions::default()).unwrap_err();
        assert_eq!(error.code(), "no-accelerometer");
        assert!(
            error.hint().unwrap_or_default().contains("--gyro"),
            "{error}"
        );
    }
    let options = ReadOptions::default();
    join_gyroscope_bytes(&mut recording, gyro.as_bytes(), "Gyroscope.csv", &options).unwrap();
    has_gyro(&recording, name, GyroUnit::RadianPerSecond);

    let name = "Sensor Logger";
    let total = |scale: f64| {
        written("time,seconds_elapsed,z,y,x\n", |s| {
            let [x, y, z] = s.a.map(|v| v * G * scale);
            let ns = 1_760_565_906_248_623_000_u64 + 10_000_000 * s.i as u64;
            format!("{ns},{:.9},{z:.8},{y:.8},{x:.8}", 0.1 + s.t_s)
        })
    };
    let recording = read_as(&total(1.0), "TotalAcceleration.csv");
    is_the_session(&recording, name, Some(100.0), &[]);
    let linear = read_as(&total(0.002), "Accelerometer.csv");
    assert_eq!(kinds(&linear), ["without-gravity"]);
    let error = read_bytes(
        total(1.0).as_bytes(),
        "Magnetometer.csv",
        &ReadOptions::default(),
    );
    assert_eq!(error.unwrap_err().code(), "no-accelerometer");

    let name = "label and texts";
    let head =
        "Date;Timestamp;DeviceOrientation;AccelerationX;AccelerationY;AccelerationZ;Mode;Label\n";
    let text = written(head, |s| {
        let ms = 41_000 + 10 * s.i;
        let stamp = format!("2021-03-04;11:41:{:02}.{:03}", ms / 1000 - 41, ms % 1000);
        format!(
            "{stamp};Portrait;{};fast;walk",
            csv(&mps2(s), 5).replace(',', ";")
        )
    });
    is_the_session(&read_as(&text, "log.csv"), name, Some(100.0), &[]);

    let name = "Physics Toolbox";
    let text = written("time;gFx;gFy;gFz;TgF\n", |s| {
        let stamp = format!("11:41:{:02}:{:04}", 20 + s.i / 100, 100 * (s.i % 100));
        let cells = csv(&[s.a[0], s.a[1], s.a[2], 1.0], 4).replace(',', ";");
        format!("{stamp};{}", cells.replace('.', ","))
    });
    let recording = read_as(&text, "g-force.csv");
    is_the_session(&recording, name, Some(100.0), &[]);
    assert_eq!(recording.accel_scale.unit, AccelUnit::StandardGravity);
}

#[test]
fn robots_and_drones() {
    let name = "EuRoC";
    let head = "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
    let row = |stamp: String, s: &Sample| format!("{stamp},{},{}", csv(&s.w, 8), csv(&mps2(s), 6));
    let ns = |s: &Sample| 1_403_636_579_758_555_392_u64 + 10_000_000 * s.i as u64;
    let text = written(head, |s| row(ns(s).to_string(), s));
    let recording = read_as(&text, "data.csv");
    is_the_session(&recording, name, Some(100.0), &[]);
    has_gyro(&recording, name, GyroUnit::RadianPerSecond);
    // As saved by a spreadsheet: rounded to ten thousands of ns …
    let rounded = |digits: usize| {
        written(head, |s| {
            let text = format!("{:.digits$e}", ns(s) as f64);
            row(text.replace('e', "E+0"), s)
        })
    };
    is_the_session(&read_as(&rounded(14), "data.csv"), name, Some(100.0), &[]);
    // … or to tenths of a second.
    let coarse = read_as(&rounded(10), "data.csv");
    assert_eq!(kinds(&coarse), ["burst-time"]);
    close(coarse.timing.rate_hz().unwrap(), 100.0, 3.0);

    let name = "ROS";
    let head = "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.orientation.x,field.orientation.y,field.orientation_covariance0,field.angular_velocity.x,field.angular_velocity.y,field.angular_velocity.z,field.angular_velocity_covariance0,field.linear_acceleration.x,field.linear_acceleration.y,field.linear_acceleration.z,field.linear_acceleration_covariance0\n";
    let text = written(head, |s| {
        let late = ns(s) + 1_000_000 * (s.i as u64 * 7 % 5);
        let (w, a) = (csv(&s.w, 6), csv(&mps2(s), 6));
        format!(
            "{late},{},{},imu,0.0,0.0,-1.0,{w},0.0,{a},0.0",
            50 + s.i,
            ns(s)
        )
    });
    let recording = read_as(&text, "imu.csv");
    is_the_session(&recording, name, Some(100.0), &[]);
    has_gyro(&recording, name, GyroUnit::Unknown);
    assert!(
        recording.timing.jitter_s.unwrap() < 1e-6,
        "the stamp, not the arrival"
    );

    let name = "PX4 sensor_combined";
    let head = "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,accelerometer_timestamp_relative,accelerometer_m_s2[0],accelerometer_m_s2[1],accelerometer_m_s2[2],accelerometer_integral_dt\n";
    let us = |s: &Sample| 40_060_000 + 10_000 * s.i;
    let text = written(head, |s| {
        format!(
            "{},{},10000,0,{},10000",
            us(s),
            csv(&s.w, 6),
            csv(&mps2(s), 5)
        )
    });
    let recording = read_as(&text, "log_sensor_combined_0.csv");
    is_the_session(&recording, name, Some(100.0), &[]);
    has_gyro(&recording, name, GyroUnit::RadianPerSecond);
    let name = "PX4 sensor_accel";
    let head = "timestamp,timestamp_sample,device_id,x,y,z,temperature,error_count,clip_counter[0],clip_counter[1],clip_counter[2],samples\n";
    let text = written(head, |s| {
        format!(
            "{},{},1310988,{},31.5,0,0,0,0,1",
            us(s),
            us(s) - 300,
            csv(&mps2(s), 5)
        )
    });
    let recording = read_as(&text, "log_sensor_accel_0.csv");
    is_the_session(&recording, name, Some(100.0), &[]);
    assert!(recording.temperature_c.is_some());

    let name = "ArduPilot";
    let head = "timestamp,TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz\n";
    let row = |s: &Sample, instance: usize| {
        let a = mps2(s).map(|v| v + 0.1 * instance as f64);
        let stamp = 1_582_318_080.0 + s.t_s;
        format!(
            "{stamp:.6},{},{instance},{},{},0,0,35.25,1,1,1000,1000",
            us(s),
            csv(&s.w, 6),
            csv(&a, 5)
        )
    };
    let text = written(head, |s| format!("{}\n{}", row(s, 0), row(s, 1)));
    let recording = read_as(&text, "imu.csv");
    is_the_session(
        &recording,
        name,
        Some(100.0),
        &["several-sensors", "other-sensor"],
    );
    has_gyro(&recording, name, GyroUnit::Unknown);
    assert!(
        finding(&recording, "several-sensors")
            .message
            .contains("--sensor 1")
    );
    let options = ReadOptions {
        sensor: Some("1".to_owned()),
        ..ReadOptions::default()
    };
    let other = read_with(text.as_bytes(), &options);
    close(mean(&other.accel[2]), G + 0.1, 0.01);

    let name = "Betaflight";
    let head = "loopIteration, time (us), axisP[0], gyroADC[0], gyroADC[1], gyroADC[2], accSmooth[0], accSmooth[1], accSmooth[2], motor[0], flightModeFlags (flags), stateFlags (flags), failsafePhase (flags)\n";
    let text = written(head, |s| {
        let cells = csv(&counts(s.w.map(f64::to_degrees), 16.4), 0);
        let a = csv(&counts(s.a, 2048.0), 0);
        format!(
            "{},{},3,{cells},{a},1150,ANGLE_MODE,SMALL_ANGLE,IDLE",
            4 * s.i,
            us(s)
        )
        .replace(',', ", ")
    });
    let recording = read_as(&text, "LOG00001.01.csv");
    is_the_session(&recording, name, Some(100.0), &[]);
    assert_eq!(recording.accel_scale.lsb_per_g, Some(2048.0));
    assert!(recording.gyro.is_some());
}

#[test]
fn wearables() {
    let date = |s: &Sample| format!("{:02}.{:03}", 14 + s.i / 100, 10 * (s.i % 100));
    let name = "Axivity";
    let text = written("", |s| {
        format!("2017-05-19 14:31:{},{}", date(s), csv(&s.a, 4))
    });
    is_the_session(
        &read_as(&text, "week.csv"),
        name,
        Some(100.0),
        &["columns-guessed"],
    );
    let text = written("time,x,y,z\n", |s| {
        format!("{:.3},{}", 1_495_204_274.0 + s.t_s, csv(&s.a, 4))
    });
    is_the_session(&read_as(&text, "week.csv"), name, Some(100.0), &[]);

    let name = "ActiGraph";
    let metadata = "------------ Data File Created By ActiGraph GT3X+ ActiLife v6.11.9 Firmware v3.2.1 date format M/d/yyyy at 100 Hz  Filter Normal -----------\nSerial Number: MOS2D16114521\nStart Time 12:00:00\nStart Date 5/19/2017\nEpoch Period (hh:mm:ss) 00:00:00\nDownload Time 10:25:30\nDownload Date 5/22/2017\nCurrent Memory Address: 0\nCurrent Battery Voltage: 4.21     Mode = 12\n--------------------------------------------------\n";
    let head = "Accelerometer X,Accelerometer Y,Accelerometer Z\n";
    let rows = |head: &str| written(&(metadata.to_owned() + head), |s| csv(&s.a, 3));
    is_the_session(&read_as(&rows(head), "a.csv"), name, Some(100.0), &[]);
    is_the_session(
        &read_as(&rows(""), "a.csv"),
        name,
        Some(100.0),
        &["columns-guessed"],
    );
    let text = written(&format!("{metadata}Timestamp,{head}"), |s| {
        format!("5/19/2017 12:00:{},{}", date(s), csv(&s.a, 3))
    });
    is_the_session(&read_as(&text, "a.csv"), name, Some(100.0), &[]);

    let start = |r: &Recording| r.recorded_at().map(gravical::utc::UtcTime::minute);
    let bare = read_as(&rows(""), "a.csv");
    assert_eq!(start(&bare).as_deref(), Some("2017-05-19 12:00"));
    assert_eq!(bare.serial.as_deref(), Some("MOS2D16114521"));
    // Over midnight, with the day first, semicolons and decimal commas.
    let metadata = metadata.replace("M/d/yyyy", "d/M/yyyy");
    let text = written(
        &format!("{metadata}Timestamp;{}", head.replace(',', ";")),
        |s| {
            let (day, second) = match s.i {
                ..200 => (5, 58 + s.i / 100),
                _ => (6, (s.i - 200) / 100),
            };
            let time = if day == 5 { "23:59" } else { "00:00" };
            let stamp = format!("0{day}/06/2017 {time}:{second:02}.{:03}", 10 * (s.i % 100));
            format!(
                "{stamp};{}",
                csv(&s.a, 3).replace(',', ";").replace('.', ",")
            )
        },
    );
    let recording = read_as(&text, "a.csv");
    is_the_session(&recording, name, Some(100.0), &[]);
    assert_eq!(start(&recording).as_deref(), Some("2017-06-05 23:59"));

    let name = "GENEActiv";
    let mut lines = vec![String::new(); 100];
    for (line, text) in [
        (1, "Device Type,GENEActiv"),
        (2, "Device Model,1.1"),
        (3, "Device Unique Serial Code,012967"),
        (4, "Device Firmware Version,Ver2.06 date24Mar11"),
        (5, "Calibration Date,2011-03-11 09:43:24:000"),
        (11, "Measurement Frequency,100.0 Hz"),
        (12, "Start Time,2011-05-31 16:43:44:000"),
        (15, "Time Zone,GMT +01:00"),
        (21, "Subject Code,17"),
        (51, "Sensor type,MEMS accelerometer x-axis"),
        (52, "Range,-8 to 8"),
        (53, "Resolution,0.0039"),
        (54, "Units,g"),
        (76, "Sensor type,Temperature"),
        (78, "Units,deg. C"),
    ] {
        lines[line - 1] = text.to_owned();
    }
    let text = written(&(lines.join("\n") + "\n"), |s| {
        let stamp = format!(
            "2011-05-31 16:43:{}:{:03}",
            44 + s.i / 100,
            10 * (s.i % 100)
        );
        format!("{stamp},{},{},0,25.{}", csv(&s.a, 4), s.i % 7, s.i / 100)
    });
    let recording = read_as(&text, "left wrist.csv");
    is_the_session(&recording, name, Some(100.0), &[]);
    assert_eq!(start(&recording).as_deref(), Some("2011-05-31 16:43"));
    assert_eq!(recording.serial.as_deref(), Some("012967"));
    assert!(recording.gyro.is_none());
    assert_eq!(recording.temperature_c.map(|t| t[0]), Some(25.0));

    let name = "Empatica";
    let head = "1552572614.000000, 1552572614.000000, 1552572614.000000\n32.000000, 32.000000, 32.000000\n";
    let recording = read_as(&written(head, |s| csv(&counts(s.a, 64.0), 0)), "ACC.csv");
    is_the_session(&recording, name, Some(32.0), &["columns-guessed"]);
    assert_eq!(recording.accel_scale.lsb_per_g, Some(64.0));

    let name = "Shimmer";
    let names = "DEVICE_Timestamp_Unix_CAL,DEVICE_Accel_LN_X_CAL,DEVICE_Accel_LN_Y_CAL,DEVICE_Accel_LN_Z_CAL,DEVICE_Accel_WR_X_CAL,DEVICE_Accel_WR_Y_CAL,DEVICE_Accel_WR_Z_CAL,DEVICE_Gyro_X_CAL,DEVICE_Gyro_Y_CAL,DEVICE_Gyro_Z_CAL,DEVICE_Battery_CAL,\n";
    let units = "ms,m/(s^2),m/(s^2),m/(s^2),m/(s^2),m/(s^2),m/(s^2),deg/s,deg/s,deg/s,mV,\n";
    let cal = "CAL,CAL,CAL,CAL,CAL,CAL,CAL,CAL,CAL,CAL,CAL,\n";
    let row = |s: &Sample| {
        let wide = mps2(s).map(|v| 1.01 * v);
        let stamp = 1_552_572_614_000.0 + 1e3 * s.t_s;
        format!(
            "{stamp:.3},{},{},{},3990.1,",
            csv(&mps2(s), 6),
            csv(&wide, 6),
            csv(&deg(s), 5)
        )
    };
    for (sep, below) in [
        ("\"sep=,\"\n", units.to_owned()),
        ("sep=,\n", cal.to_owned() + units),
    ] {
        let text = written(&format!("{sep}{names}{below}"), row);
        let recording = read_as(&text, "shimmer.csv");
        is_the_session(&recording, name, Some(100.0), &["several-sensors"]);
        has_gyro(&recording, name, GyroUnit::DegreePerSecond);
        assert!(
            finding(&recording, "several-sensors")
                .message
                .contains("--sensor wr")
        );
        let options = ReadOptions {
            sensor: Some("wr".to_owned()),
            ..ReadOptions::default()
        };
        let wide = read_with(text.as_bytes(), &options);
        close(mean(&wide.accel[2]), 1.01 * G, 0.01);
        let tabs = text.replace(',', "\t");
        is_the_session(
            &read_as(&tabs, "shimmer.csv"),
            name,
            Some(100.0),
            &["several-sensors"],
        );
    }

    let name = "MbientLab";
    let head = "epoc (ms),timestamp (+0200),elapsed (s),x-axis (g),y-axis (g),z-axis (g)\n";
    let text = written(head, |s| {
        let stamp = format!(
            "{},2019-05-08T11.41.{}",
            1_557_308_474_000 + 10 * s.i,
            date(s)
        );
        format!("{stamp},{:.3},{}", s.t_s, csv(&s.a, 3))
    });
    is_the_session(&read_as(&text, "Accelerometer.csv"), name, Some(100.0), &[]);

    let name = "x-io";
    let head = "Time (s),Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),Accelerometer X (g),Accelerometer Y (g),Accelerometer Z (g)\n";
    let text = written(head, |s| {
        format!("{:.5},{},{}", s.t_s, csv(&deg(s), 4), csv(&s.a, 5))
    });
    let recording = read_as(&text, "log.csv");
    is_the_session(&recording, name, Some(100.0), &[]);
    has_gyro(&recording, name, GyroUnit::DegreePerSecond);

    let name = "Xsens";
    let head =
        "// Update Rate: 100.0Hz\nPacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\tMat[1][1]\n";
    for (tick, unit) in [
        (100, TimeUnit::HundredMicroseconds),
        (10_000, TimeUnit::Microsecond),
    ] {
        let text = written(head, |s| {
            format!(
                "{},{},{},0.5",
                65_500 + s.i,
                37_000 + tick * s.i,
                csv(&mps2(s), 6)
            )
            .replace(',', "\t")
        });
        let recording = read_as(&text, "MT.txt");
        is_the_session(&recording, name, Some(100.0), &[]);
        assert_eq!(recording.timing.unit, Some(unit));
    }
    // Its ticks are often empty: then the metadata give the rate.
    let text = written(head, |s| {
        format!("{},,{},0.5", 500 + s.i, csv(&mps2(s), 6)).replace(',', "\t")
    });
    let recording = read_as(&text, "MT.txt");
    assert_eq!(recording.timing.rate_hz(), Some(100.0));
}

#[test]
fn clocks_of_any_name() {
    let clocks: [(&str, f64, &[&str]); 12] = [
        ("ustime", 1e6, &[]),
        ("TimeUS", 1e6, &[]),
        ("micros", 1e6, &[]),
        ("us", 1e6, &[]),
        ("ms", 1e3, &[]),
        ("millis", 1e3, &[]),
        ("GPST", 1.0, &[]),
        ("seconds_elapsed", 1.0, &[]),
        ("epoc (ms)", 1e3, &[]),
        ("elapsed (s)", 1.0, &[]),
        ("t_ns", 1e9, &[]),
        ("when (unknown)", 1.0, &["unnamed-clock"]),
    ];
    for (name, per_s, findings) in clocks {
        let decimals = if per_s == 1.0 { 3 } else { 0 };
        let text = written(&format!("n,{name},ax,ay,az,note,place,who\n"), |s| {
            let t = per_s * (5.0 + s.t_s);
            format!("{},{t:.decimals$},{},on,desk,me", s.i, csv(&mps2(s), 5))
        });
        let recording = read_as(&text, "x.csv");
        is_the_session(&recording, name, Some(100.0), findings);
    }
    // Differences from row to row, and a time that cannot be parsed.
    for (name, per_s) in [("dt", 1.0), ("dt_us", 1e6), ("delta_t (ms)", 1e3)] {
        let text = written(&format!("{name},ax,ay,az\n"), |s| {
            format!("{},{}", 0.01 * per_s, csv(&mps2(s), 5))
        });
        let recording = read_as(&text, "x.csv");
        let reported = kinds(&recording);
        assert!(
            reported.is_empty() || reported == ["time-unit-assumed"],
            "{reported:?}"
        );
        close(recording.timing.rate_hz().unwrap(), 100.0, 0.01);
        close(recording.time_s.as_ref().unwrap()[100], 1.0, 1e-9);
    }
    let text = written("time,ax,ay,az\n", |s| format!("soon,{}", csv(&mps2(s), 5)));
    assert_eq!(read_as(&text, "x.csv").rows(), ROWS);
}

#[test]
fn clocks_of_whole_seconds_and_in_two_columns() {
    let second = |s: &Sample| 50_400 + (s.t_s + 0.37) as u64;
    let of_day = |s: &Sample| {
        let at = second(s);
        format!("{:02}:{:02}:{:02}", at / 3600, at / 60 % 60, at % 60)
    };
    let coarse: &[&str] = &["burst-time"];
    for (name, stamp) in [
        ("Time", &of_day as &dyn Fn(&Sample) -> String),
        ("Time (s)", &|s| second(s).to_string()),
        ("timestamp", &|s| (1_617_883_000 + second(s)).to_string()),
    ] {
        let text = written(&format!("{name},ax,ay,az\n"), |s| {
            format!("{},{}", stamp(s), csv(&mps2(s), 5))
        });
        let recording = read_as(&text, "x.csv");
        is_the_session(&recording, name, Some(100.0), coarse);
        close(recording.timing.rate_hz().unwrap(), 100.0, 1e-9);
    }
    let text = written("", |s| format!("{},{}", second(s), csv(&mps2(s), 5)));
    let recording = read_as(&text, "x.csv");
    close(recording.timing.rate_hz().unwrap(), 100.0, 1e-9);
    // The fraction of a second is in another column.
    for (names, per_s) in [
        ("header.stamp.sec,header.stamp.nanosec", 1e9),
        ("seconds,millis", 1e3),
        ("Time,Micros", 1e6),
    ] {
        let text = written(&format!("{names},ax,ay,az\n"), |s| {
            let t = s.t_s + 0.37;
            let below = (per_s * (t - t.floor() + 1e-6)).floor();
            let whole = match names.starts_with("Time") {
                true => of_day(s),
                false => (t as u64).to_string(),
            };
            format!("{whole},{below},{}", csv(&mps2(s), 5))
        });
        let recording = read_as(&text, "x.csv");
        is_the_session(&recording, names, Some(100.0), &[]);
        close(recording.time_s.as_ref().unwrap()[250], 2.5, 1e-5);
        assert!(recording.breaks.is_empty(), "{names}");
    }
}

#[test]
fn the_duration_of_a_loop_is_not_part_of_the_stamp() {
    let text = written("time,ax,ay,az,loop_time_us\n", |s| {
        format!("{},{},{}", 10 * s.i, csv(&mps2(s), 5), 850 + s.i * 37 % 200)
    });
    let recording = read_as(&text, "x.csv");
    is_the_session(&recording, "loop time", Some(100.0), &[]);
    close(recording.time_s.as_ref().unwrap()[250], 2.5, 1e-9);
}

#[test]
fn restarting_clocks_are_made_continuous() {
    let wraps: [(&str, f64, f64); 5] = [
        ("Time (s)", 86_400.0, 1.0),
        ("ms", 65_536.0, 1e3),
        ("millis", 1000.0, 1e3),
        ("us", 16_777_216.0, 1e6),
        ("seconds", 60.0, 1.0),
    ];
    for (name, period, per_s) in wraps {
        let decimals = if per_s == 1.0 { 3 } else { 0 };
        let text = written(&format!("{name},ax,ay,az\n"), |s| {
            let t = (period - 2.0 * per_s.min(period / 4.0) + per_s * s.t_s) % period;
            format!("{t:.decimals$},{}", csv(&mps2(s), 5))
        });
        let recording = read_as(&text, "x.csv");
        is_the_session(&recording, name, Some(100.0), &[]);
        assert!(recording.breaks.is_empty(), "{name}");
        close(recording.time_s.as_ref().unwrap()[ROWS - 1], 3.99, 2e-3);
    }
}

#[test]
fn rows_of_a_sensor_that_was_not_read_are_reported() {
    for gone in [0..100, 150..160, 390..400] {
        let text = written("ms,ax,ay,az,gx,gy,gz\n", |s| match gone.contains(&s.i) {
            true => format!("{},0.00,0.00,0.00,0,0,0", 10 * s.i),
            false => format!("{},{},{}", 10 * s.i, csv(&mps2(s), 5), csv(&s.w, 5)),
        });
        let recording = read_as(&text, "x.csv");
        assert_eq!(recording.accel_scale.unit, AccelUnit::MetrePerSecondSquared);
        assert_eq!(finding(&recording, "zero-rows").count, gone.len() as u64);
        let zero = |row: usize| recording.accel_at(row) == [0.0; 3];
        assert!((0..recording.rows()).all(|row| !zero(row)), "{gone:?}");
    }
    // Without gravity zero is the reading at rest.
    let linear = written(
        "ms,Linear Acceleration x (g),Linear Acceleration y (g),Linear Acceleration z (g)\n",
        |s| {
            let a = if s.i % 3 == 0 {
                "0.01,0.00,0.00"
            } else {
                "0.00,0.00,0.00"
            };
            format!("{},{a}", 10 * s.i)
        },
    );
    finding(&read_as(&linear, "x.csv"), "without-gravity");
    // In free fall a cheap sensor may read zero for a moment, while its gyroscope does not.
    let text = written("ms,ax,ay,az,gx,gy,gz\n", |s| match s.i {
        200 => format!("{},0.00,0.00,0.00,{}", 10 * s.i, csv(&s.w, 5)),
        _ => format!("{},{},{}", 10 * s.i, csv(&mps2(s), 5), csv(&s.w, 5)),
    });
    assert_eq!(read_as(&text, "x.csv").accel_at(200), [0.0; 3]);
}

#[test]
fn units_that_are_multiples_of_others() {
    let wanted = |r: &Recording, what: &str| {
        is_the_session(r, what, Some(100.0), &[]);
        has_gyro(r, what, GyroUnit::Counts);
    };
    for (unit, per_g, decimals) in [
        ("cm/s^2", 980.665, 2),
        ("mm/s²", 9806.65, 1),
        ("µg", 1e6, 0),
    ] {
        for (rate, per_deg_s) in [("mdps", 1e3), ("mrad/s", 17.453_292_5), ("deg/h", 3600.0)] {
            let head = format!(
                "ms,ax ({unit}),ay ({unit}),az ({unit}),gx [{rate}],gy [{rate}],gz [{rate}]\n"
            );
            let text = written(&head, |s| {
                let (a, w) = (s.a.map(|v| v * per_g), deg(s).map(|v| v * per_deg_s));
                format!("{},{},{}", 10 * s.i, csv(&a, decimals), csv(&w, 3))
            });
            wanted(&read_as(&text, "x.csv"), &format!("{unit}, {rate}"));
        }
    }
    // Without a unit; 9807 is not 8192.
    let text = written("ms,ax,ay,az\n", |s| {
        format!("{},{}", 10 * s.i, csv(&s.a.map(|v| v * 9806.65), 1))
    });
    assert_eq!(read_as(&text, "x.csv").accel_scale.lsb_per_g, Some(9806.65));
}

#[test]
fn headers_with_merged_cells_and_units_that_name_the_sensor() {
    for head in [
        ",Accelerometer (m/s²),,,Gyroscope (rad/s),,\nTime (ms),X,Y,Z,X,Y,Z\n",
        "Time (ms),AccX (m/s²),AccY (m/s²),AccZ (m/s²),AsX (rad/s),AsY (rad/s),AsZ (rad/s)\n",
        "Time (ms),ax,ay,az,Rotation X (rad/s),Rotation Y (rad/s),Rotation Z (rad/s)\n",
        "timestamp_ms,alpha_x,alpha_y,alpha_z,omega_x,omega_y,omega_z\n",
    ] {
        let text = written(head, |s| {
            format!("{},{},{}", 10 * s.i, csv(&mps2(s), 5), csv(&s.w, 5))
        });
        let recording = read_as(&text, "x.csv");
        is_the_session(&recording, head, Some(100.0), &[]);
        assert!(recording.gyro.is_some(), "{head}");
    }
}

#[test]
fn blank_lines_between_rows() {
    let head = "t_ms,ax,ay,az\n";
    let row = |s: &Sample| format!("{},{}", 10 * s.i, csv(&mps2(s), 5));
    let plain = read_as(&written(head, row), "x.csv");
    for ends in ["\r\n\r\n", "\r\r\n", "\n\n\n", "\n,,,\n"] {
        let text = written(head, row).replace('\n', ends);
        let recording = read_as(&text, "x.csv");
        assert_eq!(recording.accel, plain.accel, "{ends:?}");
        assert!(recording.breaks.is_empty(), "{ends:?}");
        let reported = kinds(&recording);
        // Delimiters alone below the header are a line before the data.
        assert!(reported.is_empty(), "{ends:?} {reported:?}");
    }
    // After every nth row, with continuous stamps and with restarting ones.
    for (every, parts) in [(2, false), (20, false), (50, false), (100, false)] {
        let text = written(head, |s| {
            let blank = if s.i > 0 && s.i % every == 0 {
                "\n"
            } else {
                ""
            };
            format!("{blank}{}", row(s))
        });
        let recording = read_as(&text, "x.csv");
        assert_eq!(!recording.breaks.is_empty(), parts, "every {every}");
    }
    let placements = written("ax,ay,az\n", |s| {
        let blank = if s.i > 0 && s.i % 50 == 0 { "\n" } else { "" };
        format!("{blank}{}", csv(&mps2(s), 5))
    });
    assert_eq!(read_as(&placements, "x.csv").breaks.len(), ROWS / 50 - 1);
    // A pause, where every line is followed by a blank one.
    let text = written(head, |s| {
        let pause = if s.i == 200 { "\n\n" } else { "" };
        format!("{pause}{}\n", row(s))
    });
    let recording = read_as(&text, "x.csv");
    assert_eq!(recording.breaks, [200]);
    finding(&recording, "blank-rows");
}

#[test]
fn counts_of_other_parts_and_ranges() {
    for (lsb, found) in [
        (64.0, 64.0),
        (256.0, 256.0),
        (1024.0, 1024.0),
        (2048.0, 2048.0),
        (16384.0, 16384.0),
    ] {
        let text = written("ax,ay,az\n", |s| csv(&counts(s.a, lsb), 0));
        let recording = read_as(&text, "x.csv");
        assert_eq!(recording.accel_scale.unit, AccelUnit::Counts, "{lsb}");
        assert_eq!(recording.accel_scale.lsb_per_g, Some(found));
        // With decimals these are not counts.
        if lsb < 1000.0 {
            let text = written("ax,ay,az\n", |s| csv(&s.a.map(|v| v * lsb), 3));
            finding(&read_as(&text, "x.csv"), "unit-unknown");
        }
    }
    // The options named in the hint solve the problem.
    let mg = written("ax,ay,az\n", |s| csv(&counts(s.a, 980.0), 0));
    let asked = read_as(&mg, "x.csv");
    let hint = &finding(&asked, "unit-unknown").message;
    for (option, unit) in [
        ("mg", AccelUnit::MilliGravity),
        ("counts", AccelUnit::Counts),
    ] {
        assert!(hint.contains(&format!("--accel-unit {option}")), "{hint}");
        let options = ReadOptions {
            accel_unit: Some(unit),
            ..ReadOptions::default()
        };
        let given = read_with(mg.as_bytes(), &options);
        assert_eq!(kinds(&given), ["rate-unknown"]);
    }
}

#[test]
fn the_end_of_a_range() {
    let clipped = |unit: &str, end: f64, decimals: usize, range: Option<f64>| {
        let head = format!("t_ms,ax_mps2,ay_mps2,az_mps2,gx{unit},gy{unit},gz{unit}\n");
        let text = written(&head, |s| {
            let wave = 1.4 * end * (0.05 * s.i as f64).sin();
            let top = if wave >= end {
                end
            } else {
                wave.max(-0.9 * end)
            };
            let rates = csv(&[top, s.w[1], s.w[2]], decimals);
            format!("{},{},{rates}", 10 * s.i, csv(&mps2(s), 5))
        });
        let options = ReadOptions {
            gyro_range_deg_s: range,
            ..ReadOptions::default()
        };
        let recording = read_with(text.as_bytes(), &options);
        let of = recording.findings.iter().find(|f| f.kind == "clipped");
        of.map(|f| f.message.split(' ').next().unwrap().to_owned())
    };
    let radian = std::f64::consts::PI / 180.0;
    let gx = Some("gx".to_owned());
    assert_eq!(clipped(" (deg/s)", 250.0, 2, None), gx);
    assert_eq!(clipped(" (deg/s)", 1997.99, 2, None), gx);
    assert_eq!(clipped(" (deg/s)", 286.72, 3, None), gx);
    assert_eq!(clipped(" (rad/s)", 500.0 * radian, 2, None), gx);
    assert_eq!(clipped("", 500.0 * radian, 4, None), gx);
    assert_eq!(clipped("", 32764.0, 0, None), gx);
    assert_eq!(clipped(" (deg/s)", 300.0, 2, Some(300.0)), gx);
    assert_eq!(clipped(" (deg/s)", 300.0, 2, None), None);
    let counts_of = written("ax,ay,az\n", |s| {
        let x = if s.i % 100 == 5 {
            32764.0
        } else {
            16384.0 * s.a[0]
        };
        csv(
            &[
                x.round(),
                (16384.0 * s.a[1]).round(),
                (16384.0 * s.a[2]).round(),
            ],
            0,
        )
    });
    finding(&read_as(&counts_of, "x.csv"), "clipped");
}

#[test]
fn columns_that_cannot_be_assigned_are_errors() {
    // A line of names that does not fit is reported.
    let text = written("t,ax,ay,az,more\n", |s| {
        format!("{},{},1,2,3", s.t_s, csv(&mps2(s), 4))
    });
    let error = read_bytes(text.as_bytes(), "x.csv", &ReadOptions::default());
    let message = match error {
        Err(error) => error.to_string(),
        Ok(recording) => finding(&recording, "columns-guessed").message.clone(),
    };
    assert!(
        message.contains("line 1 has 5 names for 7 columns"),
        "{message}"
    );
    let text = written("p,q,r\n", |s| csv(&mps2(s), 4));
    let error = read_bytes(text.as_bytes(), "x.csv", &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("header in line 1"), "{error}");
    let options = ReadOptions {
        columns: Some(parse_columns("ax=p,ay=q,az=r").unwrap()),
        ..ReadOptions::default()
    };
    is_the_session(&read_with(text.as_bytes(), &options), "named", None, &[]);
    // The printed option gives the same result.
    let text = written("", |s| {
        format!("{},{},25.1,{}", s.t_s, csv(&mps2(s), 4), csv(&s.w, 4))
    });
    let guessed = read_as(&text, "x.csv");
    let message = &finding(&guessed, "columns-guessed").message;
    let option = message.split("--columns ").nth(1).unwrap();
    let option = option.split(' ').next().unwrap();
    let options = ReadOptions {
        columns: Some(parse_columns(option).unwrap()),
        ..ReadOptions::default()
    };
    let given = read_with(text.as_bytes(), &options);
    assert!(given.findings.is_empty(), "{:?}", given.findings);
    assert_eq!((&given.accel, &given.gyro), (&guessed.accel, &guessed.gyro));
    assert_eq!(given.time_s, guessed.time_s);
}

#[test]
fn utf_16_without_a_mark() {
    let text = written("t_ms,ax (m/s²),ay (m/s²),az (m/s²)\n", |s| {
        format!("{},{}", 10 * s.i, csv(&mps2(s), 4))
    });
    for big in [false, true] {
        let wide: Vec<u8> = text
            .encode_utf16()
            .flat_map(|u| {
                if big {
                    u.to_be_bytes()
                } else {
                    u.to_le_bytes()
                }
            })
            .collect();
        let recording = read(&wide);
        is_the_session(&recording, "UTF-16", Some(100.0), &[]);
    }
}

#[test]
fn columns_of_the_gyroscopes_file() {
    let accel = written("t_ms,p,q,r\n", |s| {
        format!("{},{}", 10 * s.i, csv(&mps2(s), 4))
    });
    let gyro = written("t_ms,u,v,w_\n", |s| {
        format!("{},{}", 10 * s.i, csv(&s.w, 4))
    });
    let options = ReadOptions {
        columns: Some(parse_columns("ax=p,ay=q,az=r,gx=u,gy=v,gz=w_").unwrap()),
        ..ReadOptions::default()
    };
    let mut recording = read_with(accel.as_bytes(), &options.beside_gyroscope_file());
    join_gyroscope_bytes(&mut recording, gyro.as_bytes(), "g.csv", &options).unwrap();
    close(mean(&recording.gyro.as_ref().unwrap()[2]), 0.03, 0.001);
    // A recording with its own gyroscope, as in the hint of `gyro-twice`.
    let both = written("t_ms,ax,ay,az,gx,gy,gz\n", |s| {
        format!("{},{},{}", 10 * s.i, csv(&mps2(s), 4), csv(&s.w, 4))
    });
    let options = ReadOptions {
        columns: Some(parse_columns("gx=-,gy=-,gz=-").unwrap()),
        ..ReadOptions::default()
    };
    let mut recording = read_with(both.as_bytes(), &options.beside_gyroscope_file());
    let gyro = gyro.replace("u,v,w_", "gx,gy,gz");
    join_gyroscope_bytes(&mut recording, gyro.as_bytes(), "g.csv", &options).unwrap();
    assert!(recording.gyro_file.is_some());
}

/// Output of `apply` for `text`, with a calibration that changes nothing.
fn applied(text: &str) -> (String, Vec<String>) {
    let calibration = CalibrationFile::parse(
        br#"{"acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": "m/s^2", "cal_type": "Ferraris",
        "K_a": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "b_a": [0, 0, 0],
        "R_a": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "K_g": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "b_g": [0, 0, 0],
        "R_g": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "K_ga": [[0, 0, 0], [0, 0, 0], [0, 0, 0]]}"#,
    )
    .unwrap();
    let input = from_reader(Box::new(std::io::Cursor::new(text.to_owned())), false).unwrap();
    let mut out = Vec::new();
    let options = ApplyOptions::default();
    let summary = apply(&calibration, input, "x.csv", &mut out, &options).unwrap();
    let kinds = summary
        .findings
        .iter()
        .map(|f| f.kind.to_string())
        .collect();
    (String::from_utf8(out).unwrap(), kinds)
}

#[test]
fn apply_and_read_interpret_files_equally() {
    let head = "dt_ms,I,ax,ay,az,gx (deg/s),gy (deg/s),gz (deg/s)\n";
    let row = |s: &Sample, i: usize| {
        let wave = 1.4 * 250.0 * (0.05 * s.i as f64).sin();
        let rates = csv(&[wave.clamp(-225.0, 250.0), s.w[1], s.w[2]], 2);
        format!("10,{i},{},{rates}", csv(&mps2(s), 6))
    };
    for text in [
        written(head, |s| format!("{}\n{}", row(s, 0), row(s, 1))),
        written(head, |s| row(s, 0)).replace('\n', "\r\n\r\n"),
        written(head, |s| {
            format!("{}{}", row(s, 0), if s.i == 250 { "\n" } else { "" })
        }),
    ] {
        let batch = read_as(&text, "x.csv");
        let (out, mut reported) = applied(&text);
        let again = read_as(&out, "x.csv");
        assert_eq!(again.accel, batch.accel);
        assert_eq!(again.breaks, batch.breaks);
        assert_eq!(
            out.lines().filter(|l| l.is_empty()).count(),
            batch.breaks.len()
        );
        let mut expected: Vec<String> = kinds(&batch).iter().map(|k| (*k).to_owned()).collect();
        reported.sort();
        expected.sort();
        assert_eq!(reported, expected);
        assert!(reported.iter().any(|k| k == "clipped"), "{reported:?}");
    }
}
