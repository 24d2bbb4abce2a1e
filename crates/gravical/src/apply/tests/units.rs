//! Units that differ from those of the calibration.

use super::*;

#[test]
fn another_unit_is_refused_unless_given() {
    let rows = |g: f64| still("t,ax,ay,az", 40, |i| format!("{i},0.0,0.0{},{g}", i % 3));
    let error = refused(&si(), &rows(1.001), &options());
    assert!(error.is_input());
    assert_eq!(error.options(), [Advice::new("accel_unit", "m/s^2")]);
    let si_unit = given(Some(AccelUnit::MetrePerSecondSquared), None);
    let (_, summary) = run_with(&si(), rows(1.001).as_bytes(), &si_unit).unwrap();
    finding(&summary, "unit-mismatch");
    assert_eq!(summary.accelerometer.origin, Origin::Given);

    let counts = |lsb: i32| still("ax,ay,az", 40, |i| format!("10,{},{lsb}", i % 5));
    let in_counts = calibration(Some("a.u."), 16384.0 / 9.80665, [20.0, 0.0, -30.0]);
    let (_, summary) = run(&in_counts, &counts(16300));
    assert_eq!(summary.accelerometer.lsb_per_g, Some(16384.0));
    assert!((summary.quiet_norm_mps2.unwrap() - 9.80665).abs() < 0.3);

    // A unit that is not known is checked by gravity.
    let unknown = calibration(None, 3300.0 / 9.80665, [33000.0, 33100.0, 32900.0]);
    let unsigned = still("ax,ay,az", 60, |i| format!("33000,{},36200", 33100 + i % 4));
    let (_, summary) = run(&unknown, &unsigned);
    finding(&summary, "unit-unverified");
    assert_eq!(summary.accelerometer.unit, AccelUnit::Counts);
    // 985 can be mg or cm/s²; the calibration decides.
    let mg = calibration(Some("mg"), 1000.0 / 9.80665, [0.0; 3]);
    let ambiguous = still("x,ax,ay,az", 60, |i| format!("7,1.5,{}.5,985.2", i % 4));
    let (_, summary) = run(&mg, &ambiguous);
    assert_eq!(summary.accelerometer.unit, AccelUnit::MilliGravity);

    let rates = |unit: &str, accel: &str| {
        let accel = ["ax", "ay", "az"].map(|axis| format!("{axis} ({accel})"));
        let rates = ["gx", "gy", "gz"].map(|axis| format!("{axis} ({unit})"));
        let header = [accel, rates].concat().join(",");
        still(&header, 40, |i| {
            format!("0.1,0.{},9.8,1.5,2.5,{i}.5", i % 3)
        })
    };
    let turning = with_gyro("rad/s");
    // A header that is wrong about the accelerometer is not evidence.
    let (_, summary) = run(&turning, &rates("deg/s", "g"));
    let mut messages = summary.findings.iter().map(|f| &f.message);
    assert!(messages.any(|m| m.contains("although the header says °/s")));
    let rad_s = given(None, Some(GyroUnit::RadianPerSecond));
    assert!(run_with(&turning, rates("deg/s", "m/s^2").as_bytes(), &rad_s).is_ok());

    let in_g = given(Some(AccelUnit::StandardGravity), None);
    for (cal, text, options, words) in [
        (&si(), rows(1.001), &options(), "in g "),
        (&si(), rows(9.8), &in_g, ""),
        (&in_counts, counts(8200), &options(), "8192 counts per g"),
        (&unknown, rows(9.8), &options(), ""),
        (&turning, rates("deg/s", "m/s^2"), &options(), "gyroscope"),
        (&with_gyro("counts"), rates("", "m/s^2"), &options(), ""),
    ] {
        let error = refused(cal, &text, options);
        assert_eq!(error.code(), "unit-mismatch", "{error}");
        assert!(error.message().contains(words), "{error}");
    }
}

/// Longer than the head in m/s², then twice as long in g: two concatenated files.
fn two_units(i: usize) -> String {
    let unit = if i < 12_000 { 1.0 } else { 1.0 / 9.80665 };
    let noise = |k: usize| 0.02 * ((i * k) as f64 * 0.37).sin();
    format!(
        "{},{:.5},{:.5},{:.5}",
        10 * i,
        unit * (0.1 + noise(1)),
        unit * (0.2 + noise(3)),
        unit * (9.8 + noise(7))
    )
}

#[test]
fn a_change_of_unit_is_refused_with_its_line() {
    let text = still("t_ms,ax,ay,az", 36_000, two_units);
    let error = refused(&si(), &text, &options());
    assert_eq!(error.code(), "unit-changed");
    assert_eq!(error.location().and_then(|l| l.line), Some(12_002));
    let with_unit = given(Some(AccelUnit::MetrePerSecondSquared), None);
    let (_, summary) = run_with(&si(), text.as_bytes(), &with_unit).unwrap();
    finding(&summary, "unit-changed");
    // Before the change there are no findings.
    let (_, summary) = run(&si(), &still("t_ms,ax,ay,az", 12_000, two_units));
    assert!(summary.findings.is_empty(), "{:?}", summary.findings);
}

#[test]
fn calibrated_in_g_is_recognised_as_calibrated() {
    let text = still("t_ms,ax,ay,az", 300, |i| {
        format!("{},0.1,-0.2,9.81", 10 * i)
    });
    let mut in_g = options();
    in_g.output_unit = OutputUnit::StandardGravity;
    let (si_text, _) = run(&si(), &text);
    let (out, summary) = run_with(&si(), text.as_bytes(), &in_g).unwrap();
    assert_eq!(summary.output_unit.name(), "g");
    assert!(out.starts_with("t_ms,ax_calibrated_g,ay_calibrated_g,az_calibrated_g\n"));
    let z = |text: &str| cells(text.lines().nth(1).unwrap())[3];
    assert!((z(&out) * 9.80665 - z(&si_text)).abs() < 1e-5);
    // Again: recognised, in its unit.
    let read = read_bytes(out.as_bytes(), "g.csv", &ReadOptions::default()).unwrap();
    assert!(read.is_result() && read.is_calibrated);
    assert_eq!(read.accel_scale.unit, AccelUnit::StandardGravity);
    let for_g = calibration(Some("g"), 0.101972, [0.0; 3]);
    let (_, again) = run_with(&for_g, out.as_bytes(), &in_g).unwrap();
    finding(&again, "already-calibrated");
    // What loggers call ax_g is no result.
    let raw = out.replace("_calibrated_g", "_g");
    let read = read_bytes(raw.as_bytes(), "raw.csv", &ReadOptions::default()).unwrap();
    assert!(!read.is_result() && !read.is_calibrated);
}
