//! Units that differ from those of the calibration.

use super::*;

/// Options with the unit of the accelerometer.
fn given(unit: AccelUnit) -> ApplyOptions {
    let mut options = options();
    options.read.accel_unit = Some(unit);
    options
}

#[test]
fn another_unit_is_refused_unless_given() {
    let rows = |g: f64| still("t,ax,ay,az", 40, |i| format!("{i},0.0,0.0{},{g}", i % 3));
    let in_g = rows(1.001);
    let error = refused(&si(), &in_g, &options());
    assert_eq!(error.code(), "unit-mismatch");
    let message = error.message();
    assert!(message.contains("in g ") && message.contains("m/s²"));
    assert_eq!(error.options(), [Advice::new("accel_unit", "m/s^2")]);

    let with_unit = given(AccelUnit::MetrePerSecondSquared);
    let (_, summary) = run_with(&si(), in_g.as_bytes(), &with_unit).unwrap();
    finding(&summary, "unit-mismatch");
    assert_eq!(summary.accelerometer.origin, Origin::Given);
    let error = refused(&si(), &rows(9.8), &given(AccelUnit::StandardGravity));
    assert_eq!(error.code(), "unit-mismatch");
}

#[test]
fn counts_at_another_range_are_refused() {
    let rows = |lsb: i32| still("ax,ay,az", 40, |i| format!("10,{},{lsb}", i % 5));
    let cal = calibration(Some("a.u."), 16384.0 / 9.80665, [20.0, 0.0, -30.0]);
    let (_, summary) = run(&cal, &rows(16300));
    assert_eq!(summary.accelerometer.lsb_per_g, Some(16384.0));
    assert!((summary.quiet_norm_mps2.unwrap() - 9.80665).abs() < 0.3);
    let error = refused(&cal, &rows(8200), &options());
    assert_eq!(error.code(), "unit-mismatch");
    assert!(error.message().contains("8192 counts per g"), "{error}");
}

#[test]
fn unknown_units_are_checked_by_gravity() {
    let unknown = calibration(None, 3300.0 / 9.80665, [33000.0, 33100.0, 32900.0]);
    let unsigned = still("ax,ay,az", 60, |i| format!("33000,{},36200", 33100 + i % 4));
    let (_, summary) = run(&unknown, &unsigned);
    finding(&summary, "unit-unverified");
    assert_eq!(summary.accelerometer.unit, AccelUnit::Counts);
    let in_si = still("ax,ay,az", 60, |i| format!("0.1,0.{},9.8", i % 4));
    let error = refused(&unknown, &in_si, &options());
    assert_eq!(error.code(), "unit-mismatch");
    // 985 can be mg or cm/s²; the calibration decides.
    let mg = calibration(Some("mg"), 1000.0 / 9.80665, [0.0; 3]);
    let rows = still("x,ax,ay,az", 60, |i| format!("7,1.5,{}.5,985.2", i % 4));
    let (_, summary) = run(&mg, &rows);
    assert_eq!(summary.accelerometer.unit, AccelUnit::MilliGravity);
}

#[test]
fn the_unit_of_the_gyroscope_is_checked() {
    let rows = |unit: &str, accel: &str| {
        let header =
            format!("ax ({accel}),ay ({accel}),az ({accel}),gx ({unit}),gy ({unit}),gz ({unit})");
        still(&header, 40, |i| {
            format!("0.1,0.{},9.8,1.5,2.5,{i}.5", i % 3)
        })
    };
    let cal = with_gyro("rad/s");
    let error = refused(&cal, &rows("deg/s", "m/s^2"), &options());
    assert_eq!(error.code(), "unit-mismatch");
    assert!(error.message().contains("gyroscope"), "{error}");
    // A header that is wrong about the accelerometer is not evidence.
    let (_, summary) = run(&cal, &rows("deg/s", "g"));
    let mut findings = summary.findings.iter();
    assert!(findings.any(|f| f.message.contains("although the header says °/s")));
    let mut with_unit = options();
    with_unit.read.gyro_unit = Some(GyroUnit::RadianPerSecond);
    assert!(run_with(&cal, rows("deg/s", "m/s^2").as_bytes(), &with_unit).is_ok());
    let counts = with_gyro("counts");
    let error = refused(&counts, &rows("", "m/s^2"), &options());
    assert_eq!(error.code(), "unit-mismatch");
}

/// Longer than the head in m/s², then twice as long in g: two concatenated files.
fn two_units(i: usize) -> String {
    let unit = if i < 12_000 { 1.0 } else { 1.0 / 9.80665 };
    let with_noise = |v: f64, k: usize| unit * (v + 0.02 * ((i * k) as f64 * 0.37).sin());
    let [x, y, z] = [(0.1, 1), (0.2, 3), (9.8, 7)].map(|(v, k)| with_noise(v, k));
    format!("{},{x:.5},{y:.5},{z:.5}", 10 * i)
}

#[test]
fn a_change_of_unit_is_refused_with_its_line() {
    let text = still("t_ms,ax,ay,az", 36_000, two_units);
    let error = refused(&si(), &text, &options());
    assert_eq!(error.code(), "unit-changed");
    assert_eq!(error.location().and_then(|l| l.line), Some(12_002));
    let with_unit = given(AccelUnit::MetrePerSecondSquared);
    let (_, summary) = run_with(&si(), text.as_bytes(), &with_unit).unwrap();
    finding(&summary, "unit-mismatch");
    // Before the change there are no findings.
    let (_, summary) = run(&si(), &still("t_ms,ax,ay,az", 12_000, two_units));
    assert!(summary.findings.is_empty(), "{:?}", summary.findings);
}

#[test]
fn calibrated_in_g_is_recognised_as_calibrated() {
    let text = still("t_ms,ax,ay,az", 300, |i| {
        format!("{},0.1,-0.2,9.81", 10 * i)
    });
    let in_g = ApplyOptions {
        output_unit: OutputUnit::StandardGravity,
        ..options()
    };
    let (si_text, _) = run(&si(), &text);
    let (out, summary) = run_with(&si(), text.as_bytes(), &in_g).unwrap();
    assert_eq!(summary.output_unit.name(), "g");
    assert!(out.starts_with("t_ms,ax_calibrated_g,ay_calibrated_g,az_calibrated_g\n"));
    let z = |text: &str| cells(text.lines().nth(1).unwrap())[3];
    assert!((z(&out) * 9.80665 - z(&si_text)).abs() < 1e-5);
    // Again: recognised, in its unit.
    let read = read_bytes(out.as_bytes(), "g.csv", &ReadOptions::default()).unwrap();
    assert!(read.format.is_result() && read.format.is_calibrated());
    assert_eq!(read.units.accel.unit, AccelUnit::StandardGravity);
    let in_unit = calibration(Some("g"), 0.101972, [0.0; 3]);
    let again = run_with(&in_unit, out.as_bytes(), &in_g);
    finding(&again.unwrap().1, "already-calibrated");
    // With the raw columns: the way to the calibrated ones is named.
    let both = ApplyOptions {
        keep_raw: true,
        ..in_g
    };
    let (out, _) = run_with(&si(), text.as_bytes(), &both).unwrap();
    let read = read_bytes(out.as_bytes(), "both.csv", &ReadOptions::default()).unwrap();
    let mut options = read.findings.iter().flat_map(|f| &f.options);
    let is_named = options.any(|o| o.value.starts_with("ax=ax_calibrated_g"));
    assert!(read.format.is_result() && is_named, "{:?}", read.findings);
}
