//! Formats of loggers and apps: each of these headers must be read without options, or the error
//! must name an option that works.

use gravical::recording::source::Named;
use gravical::recording::{GyroUnit, ReadOptions, Recording, join_gyroscope, read_bytes};

use crate::support::*;

const ROWS: usize = 400;
const G: f64 = 9.80665;
const AT_REST_G: [f64; 3] = [0.02, -0.03, 1.0];

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
        a: std::array::from_fn(|k| AT_REST_G[k] + 0.01 * noise(k + 1)),
        w: std::array::from_fn(|k| [0.01, -0.02, 0.03][k] + 0.002 * noise(k + 4)),
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

fn read_as(text: &str, file: &str) -> Recording {
    let recording = read_bytes(text.as_bytes(), file, &ReadOptions::default())
        .unwrap_or_else(|e| panic!("{file}: {e}\n{}", &text[..text.len().min(300)]));
    assert_eq!(recording.ledger.rows(), recording.rows());
    recording
}

/// Checks the samples, in the recognised unit; the gyroscope's unit; the rate, 100 Hz; the findings.
fn is_the_session(r: &Recording, what: &str, gyro: Option<GyroUnit>, findings: &[&str]) {
    assert_eq!(r.rows(), ROWS, "{what}: {}", r.ledger.sum());
    let nominal = r.units.accel.nominal();
    let nominal = nominal.unwrap_or_else(|| panic!("{what}: {:?}", r.findings));
    // Tolerance for the rounding of the samples, in g.
    let coarse = 0.51 / (nominal * G).min(50.0);
    for (axis, at_rest_g) in AT_REST_G.into_iter().enumerate() {
        let mean = mean(&r.accel[axis]) / nominal / G;
        assert!((mean - at_rest_g).abs() < 0.5 * coarse, "{what}: {mean}");
    }
    let rate_hz = r.clock.rate_hz().unwrap_or(f64::NAN);
    assert!((rate_hz / 100.0 - 1.0).abs() < 0.01, "{what}: {rate_hz} Hz");
    let mut reported = kinds(r);
    reported.retain(|k| !["repeated-rows", "frozen-axis"].contains(k));
    assert_eq!(reported, findings, "{what}");
    if let Some(unit) = gyro {
        let scale = r.units.gyro.expect(what);
        assert_eq!(scale.unit, unit, "{what}");
        let z = mean(&r.gyro.as_ref().unwrap()[2]);
        close(z / scale.nominal().unwrap_or(1.0), 0.03, 0.002);
    }
}

/// Tables that neither the writings nor the shapes of `gravical-recording` have.
#[test]
fn tables_of_loggers() {
    let dated =
        "Date;Timestamp;DeviceOrientation;AccelerationX;AccelerationY;AccelerationZ;Mode;Label\n";
    let px4 = "timestamp,timestamp_sample,device_id,x,y,z,temperature,error_count,clip_counter[0],clip_counter[1],clip_counter[2],samples\n";
    let xsens =
        "// Update Rate: 100.0Hz\nPacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\tMat[1][1]\n";
    let packet = |s: &Sample, stamp: &str| {
        let row = format!("{},{stamp},{},0.5", 65_500 + s.i, csv(&mps2(s), 6));
        row.replace(',', "\t")
    };
    let ticks = |tick: usize| written(xsens, |s| packet(s, &(37_000 + tick * s.i).to_string()));
    let dated = written(dated, |s| {
        let (second, ms) = (s.i / 100, 10 * (s.i % 100));
        let cells = csv(&mps2(s), 5).replace(',', ";");
        format!("2021-03-04;11:41:{second:02}.{ms:03};Portrait;{cells};fast;walk")
    });
    let epoch = |s: &Sample| format!("{:.3},{}", 1_495_204_274.0 + s.t_s, csv(&s.a, 4));
    let sensor_accel = written(px4, |s| {
        let (us, cells) = (40_060_000 + 10_000 * s.i, csv(&mps2(s), 5));
        format!("{us},{},1310988,{cells},31.5,0,0,0,0,1", us - 300)
    });
    for (file, text) in [
        ("log.csv", dated),
        ("week.csv", written("time,x,y,z\n", epoch)),
        ("log_sensor_accel_0.csv", sensor_accel),
        ("MT.txt", ticks(100)),
        ("MT.txt", ticks(10_000)),
    ] {
        is_the_session(&read_as(&text, file), file, None, &[]);
    }
    // The ticks are often empty: then the metadata give the rate.
    let text = written(xsens, |s| packet(s, ""));
    assert_eq!(read_as(&text, "MT.txt").clock.rate_hz(), Some(100.0));
}

#[test]
fn stamps_of_robots() {
    let ns = |s: &Sample| 1_403_636_579_758_555_392_u64 + 10_000_000 * s.i as u64;
    // EuRoC as saved by a spreadsheet: rounded to ten thousands of ns, or to tenths of a second.
    let euroc = "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
    let rounded = |digits: usize| {
        let text = written(euroc, |s| {
            let stamp = format!("{:.digits$e}", ns(s) as f64).replace('e', "E+0");
            format!("{stamp},{},{}", csv(&s.w, 8), csv(&mps2(s), 6))
        });
        read_as(&text, "data.csv")
    };
    is_the_session(&rounded(14), "EuRoC", Some(GyroUnit::RadianPerSecond), &[]);
    assert_eq!(kinds(&rounded(10)), ["burst-time"]);
    close(rounded(10).clock.rate_hz().unwrap(), 100.0, 3.0);
    // ROS: the stamp, not the arrival.
    let ros = "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.orientation.x,field.orientation.y,field.orientation_covariance0,field.angular_velocity.x,field.angular_velocity.y,field.angular_velocity.z,field.angular_velocity_covariance0,field.linear_acceleration.x,field.linear_acceleration.y,field.linear_acceleration.z,field.linear_acceleration_covariance0\n";
    let text = written(ros, |s| {
        let (ns, number) = (ns(s), 50 + s.i);
        let late = ns + 1_000_000 * (s.i as u64 * 7 % 5);
        let (w, a) = (csv(&s.w, 6), csv(&mps2(s), 6));
        format!("{late},{number},{ns},imu,0.0,0.0,-1.0,{w},0.0,{a},0.0")
    });
    let recording = read_as(&text, "imu.csv");
    is_the_session(&recording, "ROS", Some(GyroUnit::Unknown), &[]);
    assert!(recording.clock.jitter_s.unwrap() < 1e-6);
}

/// A phone writes each event when it comes, of the gyroscope half as often, and that one first.
#[test]
fn events_of_sensors_with_other_rates_are_told_apart() {
    let text = written("type,t,x,y,z,ok\n", |s| {
        let ok = s.i % 3 > 0;
        let event = |kind, xyz: &[f64; 3]| format!("{kind},{},{},{ok}", 10 * s.i, csv(xyz, 4));
        let accel = event("ACC", &mps2(s));
        if s.i % 2 > 0 {
            return accel;
        }
        format!("{}\n{accel}", event("GYR", &s.w))
    });
    let recording = read_as(&text, "log.csv");
    is_the_session(&recording, "events", None, &["several-sensors"]);
}

#[test]
fn wearables_say_when_and_which() {
    let is = |r: &Recording, start: &str, serial: &str, findings: &[&str]| {
        is_the_session(r, serial, None, findings);
        let own = r.recorded_at().map(gravical::utc::UtcTime::minute);
        assert_eq!(own.as_deref(), Some(start));
        assert_eq!(r.format.serial().as_deref(), Some(serial));
    };
    let actigraph = "MOS2D16114521";
    let metadata = "------------ Data File Created By ActiGraph GT3X+ ActiLife v6.11.9 Firmware v3.2.1 date format M/d/yyyy at 100 Hz  Filter Normal -----------\nSerial Number: MOS2D16114521\nStart Time 12:00:00\nStart Date 5/19/2017\nEpoch Period (hh:mm:ss) 00:00:00\nDownload Time 10:25:30\nDownload Date 5/22/2017\nCurrent Memory Address: 0\nCurrent Battery Voltage: 4.21     Mode = 12\n--------------------------------------------------\n";
    let recording = read_as(&written(metadata, |s| csv(&s.a, 3)), "a.csv");
    let guessed = ["columns-guessed"];
    is(&recording, "2017-05-19 12:00", actigraph, &guessed);
    // Over midnight, with the day first, semicolons and decimal commas.
    let head = metadata.replace("M/d/yyyy", "d/M/yyyy")
        + "Timestamp;Accelerometer X;Accelerometer Y;Accelerometer Z\n";
    let text = written(&head, |s| {
        let (day, time, second) = match s.i {
            ..200 => (5, "23:59", 58 + s.i / 100),
            _ => (6, "00:00", (s.i - 200) / 100),
        };
        let cells = csv(&s.a, 3).replace(',', ";").replace('.', ",");
        let ms = 10 * (s.i % 100);
        format!("0{day}/06/2017 {time}:{second:02}.{ms:03};{cells}")
    });
    is(&read_as(&text, "a.csv"), "2017-06-05 23:59", actigraph, &[]);
    let mut lines = vec![""; 100];
    for (line, text) in [
        (1, "Device Type,GENEActiv"),
        (3, "Device Unique Serial Code,012967"),
        (5, "Calibration Date,2011-03-11 09:43:24:000"),
        (11, "Measurement Frequency,100.0 Hz"),
        (12, "Start Time,2011-05-31 16:43:44:000"),
        (15, "Time Zone,GMT +01:00"),
        (21, "Subject Code,17"),
        (52, "Range,-8 to 8"),
        (54, "Units,g"),
        (78, "Units,deg. C"),
    ] {
        lines[line - 1] = text;
    }
    let text = written(&(lines.join("\n") + "\n"), |s| {
        let (second, ms) = (44 + s.i / 100, 10 * (s.i % 100));
        let light = format!("{},0,25.{}", s.i % 7, s.i / 100);
        format!("2011-05-31 16:43:{second}:{ms:03},{},{light}", csv(&s.a, 4))
    });
    let recording = read_as(&text, "left wrist.csv");
    is(&recording, "2011-05-31 16:43", "012967", &[]);
    assert!(recording.gyro.is_none());
    assert_eq!(recording.temperature_c.map(|t| t[0]), Some(25.0));
}

#[test]
fn the_fraction_of_a_second_may_be_in_another_column() {
    for (names, per_s) in [("seconds,millis", 1e3), ("Time,Micros", 1e6)] {
        let text = written(&format!("{names},ax,ay,az\n"), |s| {
            let t = s.t_s + 0.37;
            let below = (per_s * (t - t.floor() + 1e-6)).floor();
            let whole = if names.starts_with("Time") {
                format!("14:00:{:02}", t as u64)
            } else {
                (t as u64).to_string()
            };
            format!("{whole},{below},{}", csv(&mps2(s), 5))
        });
        let recording = read_as(&text, "x.csv");
        is_the_session(&recording, names, None, &[]);
        close(recording.time_s.as_ref().unwrap()[250], 2.5, 1e-5);
        assert!(recording.breaks.is_empty(), "{names}");
    }
}

#[test]
fn restarting_clocks_are_made_continuous() {
    let wraps: [(&str, f64, f64); 7] = [
        ("Time (s)", 86_400.0, 1.0),
        ("ms", 65_536.0, 1e3),
        ("ms", 4_294_967_296.0, 1e3),
        ("us", 4_294_967_296.0, 1e6),
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
        is_the_session(&recording, name, None, &[]);
        assert!(recording.breaks.is_empty(), "{name}");
        close(recording.time_s.as_ref().unwrap()[ROWS - 1], 3.99, 2e-3);
    }
}

#[test]
fn zero_may_be_a_reading() {
    // Without gravity zero is the reading at rest.
    let head = "ms,Linear Acceleration x (g),Linear Acceleration y (g),Linear Acceleration z (g)\n";
    let linear = written(head, |s| {
        format!("{},0.0{},0.00,0.00", 10 * s.i, s.i % 3 / 2)
    });
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
            is_the_session(&read_as(&text, "x.csv"), &head, Some(GyroUnit::Counts), &[]);
        }
    }
    // Without a unit; 9807 is not 8192.
    let text = written("ms,ax,ay,az\n", |s| {
        format!("{},{}", 10 * s.i, csv(&s.a.map(|v| v * 9806.65), 1))
    });
    assert_eq!(read_as(&text, "x.csv").units.accel.lsb_per_g, Some(9806.65));
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
        is_the_session(&recording, head, None, &[]);
        assert!(recording.gyro.is_some(), "{head}");
    }
}

#[test]
fn columns_that_cannot_be_assigned_are_errors() {
    // A line of names that does not fit is reported.
    let text = written("t,ax,ay,az,more\n", |s| {
        format!("{},{},1,2,3", s.t_s, csv(&mps2(s), 4))
    });
    let message = match read_bytes(text.as_bytes(), "x.csv", &ReadOptions::default()) {
        Err(error) => error.to_string(),
        Ok(recording) => finding(&recording, "columns-guessed").message.clone(),
    };
    let names = "line 1 has 5 names for 7 columns";
    assert!(message.contains(names), "{message}");
}

#[test]
fn columns_of_the_gyroscopes_file() {
    let accel = written("t_ms,p,q,r\n", |s| {
        format!("{},{}", 10 * s.i, csv(&mps2(s), 4))
    });
    let gyro = written("t_ms,u,v,w_\n", |s| {
        format!("{},{}", 10 * s.i, csv(&s.w, 4))
    });
    let options =
        read_options(|o| o.columns = Some("ax=p,ay=q,az=r,gx=u,gy=v,gz=w_".parse().unwrap()));
    let mut recording = read_with(accel.as_bytes(), &options.beside_gyroscope_file());
    join_gyroscope(
        &mut recording,
        Named::Bytes("g.csv".as_ref(), gyro.as_bytes()),
        &options,
    )
    .unwrap();
    close(mean(&recording.gyro.as_ref().unwrap()[2]), 0.03, 0.001);
    // A recording with its own gyroscope, as in the hint of `gyro-twice`.
    let both = written("t_ms,ax,ay,az,gx,gy,gz\n", |s| {
        format!("{},{},{}", 10 * s.i, csv(&mps2(s), 4), csv(&s.w, 4))
    });
    let options = read_options(|o| o.columns = Some("gx=-,gy=-,gz=-".parse().unwrap()));
    let mut recording = read_with(both.as_bytes(), &options.beside_gyroscope_file());
    let gyro = gyro.replace("u,v,w_", "gx,gy,gz");
    join_gyroscope(
        &mut recording,
        Named::Bytes("g.csv".as_ref(), gyro.as_bytes()),
        &options,
    )
    .unwrap();
    assert!(recording.gyro_file.is_some());
}
