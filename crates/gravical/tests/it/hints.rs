//! Options that a refusal or a finding of the reader names do what it says.

use gravical::finding::Advice;
use gravical::inspect::inspect;
use gravical::poses::face::AxisMap;
use gravical::recording::source::Named;
use gravical::recording::{
    AccelUnit, GyroUnit, ReadOptions, Recording, TimeUnit, join_gyroscope, read_bytes,
};

use crate::support::{data, files, read_options};

/// What is refused or found: kind, and options.
fn said(bytes: &[u8], name: &str, options: &ReadOptions) -> Vec<(String, Vec<Advice>)> {
    let recording: Recording = match read_bytes(bytes, name, options) {
        Ok(recording) => recording,
        Err(e) => return vec![(e.code().to_owned(), e.options().to_vec())],
    };
    let findings = inspect(&recording, &AxisMap::default())
        .findings
        .into_iter();
    findings.map(|f| (f.kind.to_string(), f.options)).collect()
}

/// Gives the options that are named, with the value that is named or that of the truth; false if
/// none of the reader is named.
fn follow(advised: &[Advice], truth: &ReadOptions, options: &mut ReadOptions) -> bool {
    let mut is_named = false;
    for Advice { name, value } in advised {
        let value = Some(value).filter(|value| !value.is_empty());
        match name.as_str() {
            "columns" => {
                let named = value.map(|value| value.parse().unwrap());
                options.columns = truth.columns.clone().or(named);
                assert!(options.columns.is_some(), "{advised:?}");
            }
            "sensor" => {
                options.sensor = value.cloned();
                assert!(options.sensor.is_some(), "{advised:?}");
            }
            "rate" => options.rate_hz = truth.rate_hz.or(Some(25.0)),
            "time_unit" => options.time_unit = truth.time_unit.or(Some(TimeUnit::Second)),
            "accel_unit" => options.accel_unit = truth.accel_unit.or(Some(AccelUnit::Counts)),
            "gyro_unit" => {
                options.gyro_unit = truth.gyro_unit.or(Some(GyroUnit::DegreePerSecond));
            }
            "gyro_range" => {
                options.gyro_range_deg_s = Some(250.0);
                options.gyro_unit = Some(GyroUnit::Counts);
            }
            _ => continue,
        }
        is_named = true;
    }
    is_named
}

/// Follows what names an option; with it, that is not said again. Returns the kinds of what it followed.
fn assert_helps(bytes: &[u8], name: &str, truth: &ReadOptions) -> Vec<String> {
    let mut followed = Vec::new();
    for (kind, advised) in said(bytes, name, &ReadOptions::default()) {
        let mut options = ReadOptions::default();
        if follow(&advised, truth, &mut options) {
            let again = said(bytes, name, &options);
            let repeats = again.contains(&(kind.clone(), advised.clone()));
            let reads = read_bytes(bytes, name, &options);
            assert!(!repeats, "{name}: {advised:?}\n{options:?}\n{again:?}");
            assert!(reads.is_ok(), "{name}: {advised:?}\n{options:?}\n{again:?}");
            followed.push(kind);
        }
    }
    followed
}

/// Rows of a sensor that lies on one side and then on another, from their number and values.
fn rows(write: impl Fn(usize, [f64; 3]) -> String) -> String {
    let row = |k: usize| {
        let noise = |i: usize| ((k + i) * 7919 % 101) as f64 / 5000.0 - 0.01;
        let up = [0.02, -0.01, 9.81];
        let side = [9.79, 0.03, -0.02];
        let a = if k < 100 { up } else { side };
        write(k, [a[0] + noise(0), a[1] + noise(37), a[2] + noise(71)]) + "\n"
    };
    (0..200).map(row).collect()
}

fn cells(values: [f64; 3], delimiter: &str) -> String {
    values.map(|v| format!("{v:.3}")).join(delimiter)
}

#[test]
fn an_option_that_is_named_helps() {
    let columns = |spec: &str| read_options(|o| o.columns = Some(spec.parse().unwrap()));
    let none = ReadOptions::default;
    let seconds = |unit| read_options(|o| o.time_unit = Some(unit));
    let milligravity = || read_options(|o| o.accel_unit = Some(AccelUnit::MilliGravity));
    let commas = |a| cells(a, ",");
    let plain = |k: usize, a| format!("{},{}", 40 * k, commas(a));
    let semicolons = |k: usize, a| format!("{};{}", 40 * k, cells(a, ";"));
    let odd = |k: usize| (k * 31 % 17) as f64 / 10.0;
    let named = |names: &str, rows: String| format!("{names}\n{rows}");
    let accel = |rows: String| named("ms,ax,ay,az", rows);
    let unknown = rows(|k, a| format!("{},{},{}", odd(k), commas(a), odd(k + 5)));
    let foreign = named("ms,one,two,three", rows(plain));
    let quoted = named("ms;one, raw;two, raw;three, raw", rows(semicolons));
    let empty = rows(|k, a| format!("{},,,,{}", 40 * k, commas(a)));
    let empty = named("ms,ax,ay,az,bx,by,bz", empty);
    let labelled = |from: usize| rows(|k, a| format!("{},n{}", plain(k + from, a), k + from));
    let labelled = named("ms,ax,ay,az,label", labelled(0) + &labelled(200));
    let two = "ms,acc one_x,acc one_y,acc one_z,acc two_x,acc two_y,acc two_z";
    let beside = named(two, rows(|k, a| format!("{},{}", plain(k, a), commas(a))));
    let in_turn = rows(|k, a| {
        let row = |name: &str| format!("{},{name},{}", 40 * k, commas(a));
        format!("{}\n{}", row("left hand"), row("right hand"))
    });
    let in_turn = named("ms,sensor,ax,ay,az", in_turn);
    let clock = named("Uhr (lokal),ax,ay,az", rows(plain));
    let quoted_clock = named("Uhr, lokal;ax;ay;az", rows(semicolons));
    let slower = |factor: u64| rows(|k, a| format!("{},{}", factor * k as u64, commas(a)));
    let slow = named("t,ax,ay,az", slower(400));
    let slowest = named("t,ax,ay,az", slower(40_000_000_000));
    let seconds_of = |k: usize| k as f64 / 25.0;
    let unread = rows(|k, a| format!("01-Mai-2024 10:00:{:06.3},{}", seconds_of(k), commas(a)));
    let unread = named("time,ax,ay,az", unread);
    let odd_unit = accel(rows(|k, a| plain(k, a.map(|v| 37.0 * v))));
    let counts = accel(rows(|k, a| {
        let counts = a.map(|v| (v * 101.97).round().to_string()).join(",");
        format!("{},{counts}", 40 * k)
    }));
    let thousandths = accel(rows(|k, a| plain(k, a.map(|v| v * 101.97))));
    let names = "ax=one,ay=two,az=three";
    let quoted_names = "ax=one, raw,ay=two, raw,az=three, raw";
    for (kind, text, truth) in [
        ("columns-unknown", unknown, columns("-,ax,ay,az,-")),
        ("no-accelerometer", foreign, columns(names)),
        ("no-accelerometer", quoted, columns(quoted_names)),
        ("no-values", empty, columns("ax=bx,ay=by,az=bz")),
        ("too-many-labels", labelled, none()),
        ("several-sensors", beside, none()),
        ("several-sensors", in_turn, none()),
        ("columns-guessed", rows(plain), none()),
        ("rate-unknown", rows(|_, a| commas(a)), none()),
        ("unnamed-clock", clock, none()),
        ("unnamed-clock", quoted_clock, none()),
        ("time-unit-assumed", slow, seconds(TimeUnit::Millisecond)),
        ("time-unit-unknown", slowest, seconds(TimeUnit::Nanosecond)),
        ("stamps-unread", unread, none()),
        ("unit-unknown", odd_unit, none()),
        ("unit-unknown", counts, milligravity()),
        ("unit-assumed", thousandths, milligravity()),
    ] {
        let followed = assert_helps(text.as_bytes(), "file.csv", &truth);
        assert!(followed.iter().any(|f| f == kind), "{kind}: {followed:?}");
    }
}

#[test]
fn a_gyroscope_alone_is_read_with_the_option_that_is_named() {
    let values = rows(|k, a| format!("{},{}", 40 * k, cells(a, ",")));
    let [rates, accel] = ["ms,gx,gy,gz", "ms,ax,ay,az"].map(|names| format!("{names}\n{values}"));
    let (kind, advised) = &said(rates.as_bytes(), "gyro.csv", &ReadOptions::default())[0];
    assert_eq!(kind, "gyroscope-alone");
    assert_eq!(advised[..], [Advice::new("gyro", "")]);
    let options = ReadOptions::default();
    let mut recording = read_bytes(accel.as_bytes(), "accel.csv", &options).unwrap();
    join_gyroscope(
        &mut recording,
        Named::Bytes("gyro.csv".as_ref(), rates.as_bytes()),
        &options,
    )
    .unwrap();
    assert!(recording.gyro.is_some());
}

/// Recordings that were read wrongly once.
#[test]
fn options_that_are_named_for_the_cases_help() {
    let Some(data) = data() else { return };
    let mut paths = Vec::new();
    files(&data.join("../cases"), &mut paths);
    let mut followed = 0;
    for path in paths {
        let name = path.file_name().unwrap().to_string_lossy();
        let bytes = std::fs::read(&path).unwrap();
        followed += assert_helps(&bytes, &name, &ReadOptions::default()).len();
    }
    assert!(followed > 0);
}
