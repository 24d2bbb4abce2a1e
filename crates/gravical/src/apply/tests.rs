use std::io::{self, Read, Write};

use crate::Error;
use crate::recording::open::from_reader;
use crate::recording::{Origin, read_bytes};

use super::*;

/// imucal's form, the shortest there is; no gyroscope.
fn calibration(unit: Option<&str>, scale: f64, bias: [f64; 3]) -> CalibrationFile {
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let k = identity.map(|row: [f64; 3]| row.map(|v| v * scale));
    let value = serde_json::json!({
        "acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": unit, "cal_type": "Ferraris",
        "K_a": k, "b_a": bias,
        "R_a": [[1.0, 0.01, -0.02], [0.0, 1.0, 0.03], [0.01, 0.0, 1.0]],
        "K_g": identity, "b_g": [0, 0, 0], "R_g": identity, "K_ga": [[0, 0, 0], [0, 0, 0], [0, 0, 0]],
    });
    CalibrationFile::parse(value.to_string().as_bytes()).unwrap()
}

fn si() -> CalibrationFile {
    calibration(Some("m/s^2"), 1.02, [0.1, -0.2, 0.05])
}

fn with_gyro(unit: &str) -> CalibrationFile {
    let mut file = si();
    let value = serde_json::json!({
        "input_unit": unit, "output_unit": "rad/s", "bias": [0.5, -0.25, 0.125],
        "matrix": [[0.017, 0.001, 0.0], [0.0, 0.018, 0.0], [0.0, 0.0, 0.0175]],
        "scale": [58.0, 56.0, 57.0], "orientation": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        "g_sensitivity": [[0.01, 0.0, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.03]],
    });
    file.gyroscope = Some(serde_json::from_value(value).unwrap());
    file
}

fn options() -> ApplyOptions {
    ApplyOptions::default()
}

fn run_with(
    cal: &CalibrationFile,
    bytes: &[u8],
    options: &ApplyOptions,
) -> Result<(String, ApplySummary)> {
    let input = from_reader(Box::new(io::Cursor::new(bytes.to_vec())), false).unwrap();
    let mut out = Vec::new();
    let summary = apply(cal, input, "rec.csv", &mut out, options)?;
    Ok((String::from_utf8_lossy(&out).into_owned(), summary))
}

fn run(cal: &CalibrationFile, text: &str) -> (String, ApplySummary) {
    let (out, summary) = run_with(cal, text.as_bytes(), &options()).unwrap();
    assert_balances(&summary);
    (out, summary)
}

fn refused(cal: &CalibrationFile, text: &str, options: &ApplyOptions) -> Error {
    run_with(cal, text.as_bytes(), options).unwrap_err()
}

fn assert_balances(summary: &ApplySummary) {
    let aside: u64 = summary.set_aside.iter().map(|s| s.lines).sum();
    assert_eq!(summary.lines, summary.rows + aside);
}

fn finding<'a>(summary: &'a ApplySummary, kind: &str) -> &'a Finding {
    let found = summary.findings.iter().find(|f| f.kind == kind);
    found.unwrap_or_else(|| panic!("no {kind} in {:?}", summary.findings))
}

/// `n` rows of a sensor that lies still, behind `header`.
fn still(header: &str, n: usize, row: impl Fn(usize) -> String) -> String {
    let rows: String = (0..n).map(|i| row(i) + "\n").collect();
    format!("{header}\n{rows}")
}

fn cells(line: &str) -> Vec<f64> {
    line.split(',').map(|c| c.parse().unwrap()).collect()
}

#[test]
fn values_are_those_of_direct_computation() {
    let row = |i: usize| {
        let x = i as f64;
        format!(
            "{},{:.4},{:.4},{:.4},{:.3},{:.3},{:.3}",
            10 * i,
            0.1 + 0.01 * x.sin(),
            -0.2 + 0.01 * x.cos(),
            9.8 + 0.02 * x.sin(),
            20.0 * x.sin(),
            x.cos(),
            -3.0 * x.sin()
        )
    };
    let text = still("t_ms,ax,ay,az,gx (deg/s),gy (deg/s),gz (deg/s)", 50, row);
    let cal = with_gyro("deg/s");
    let (out, summary) = run(&cal, &text);
    assert_eq!(
        out.lines().next().unwrap(),
        "t_ms,ax_mps2,ay_mps2,az_mps2,gx_rad_s,gy_rad_s,gz_rad_s"
    );
    let (accel, gyro) = (
        cal.accelerometer_calibration(),
        cal.gyroscope_calibration().unwrap(),
    );
    for (got, from) in out.lines().zip(text.lines()).skip(1) {
        let (got, from) = (cells(got), cells(from));
        assert_eq!(got[0], from[0]);
        let a = accel.apply([from[1], from[2], from[3]]);
        let w = gyro.apply([from[4], from[5], from[6]], a);
        for (got, expected) in got[1..].iter().zip(a.iter().chain(&w)) {
            // Half of the last of six decimals.
            assert!((got - expected).abs() <= 0.500_001e-6, "{got} {expected}");
        }
    }
    assert_eq!(
        summary.gyroscope,
        GyroscopeOutcome::Calibrated(GyroUnit::DegreePerSecond)
    );
}

#[test]
fn the_case_is_turned_after_calibrating() {
    let text = still("ax,ay,az,gx (deg/s),gy (deg/s),gz (deg/s)", 3, |i| {
        format!("0.1,{}.2,9.8,1.5,-2.5,{i}.25", i % 2)
    });
    let (board, _) = run(&with_gyro("deg/s"), &text);
    let turned = ApplyOptions {
        axes: "x,-z,y".parse().unwrap(),
        ..options()
    };
    let (case, _) = run_with(&with_gyro("deg/s"), text.as_bytes(), &turned).unwrap();
    for (board, case) in board.lines().zip(case.lines()).skip(1) {
        let (b, c) = (cells(board), cells(case));
        assert_eq!(c, [b[0], -b[2], b[1], b[3], -b[5], b[4]]);
    }
}

#[test]
fn other_columns_stay_byte_for_byte() {
    let text = "\"note, of mine\",aX (g),t, aZ (g),aY (g),flag\n\
                \"a,b\",0.1, 007,9.80,0.1,+1e0\n\
                \"c\"\"d\",0.1,8 ,9.81,0.2, x\n";
    let (out, summary) = run(&si(), text);
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines[0], "\"note, of mine\",ax_mps2,t,az_mps2,ay_mps2,flag");
    let kept = |line: &str, from: &str, middle: &str, to: &str| {
        assert!(line.starts_with(from) && line.ends_with(to), "{line}");
        assert!(line.contains(middle), "{line}");
    };
    kept(lines[1], "\"a,b\",", ", 007,9.", ",+1e0");
    kept(lines[2], "\"c\"\"d\",", ",8 ,9.", ", x");
    assert_eq!(
        summary.columns,
        [
            "note, of mine",
            "ax_mps2",
            "t",
            "az_mps2",
            "ay_mps2",
            "flag"
        ]
    );
}

#[test]
fn raw_columns_are_kept_when_wanted() {
    let keep = ApplyOptions {
        keep_raw: true,
        ..options()
    };
    let text = "t,ax,ay,az,gx,gy,gz\n0,0.1,0.2,9.80,1,2,3\n1,0.1,0.2,9.81,1,2,4\n";
    let (out, _) = run_with(&si(), text.as_bytes(), &keep).unwrap();
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines[0], "t,ax,ay,az,gx,gy,gz,ax_mps2,ay_mps2,az_mps2");
    assert!(
        lines[1].starts_with("0,0.1,0.2,9.80,1,2,3,"),
        "{}",
        lines[1]
    );
    let (replaced, _) = run(&si(), text);
    let last: Vec<&str> = lines[2].split(',').skip(7).collect();
    assert_eq!(
        replaced
            .lines()
            .nth(2)
            .unwrap()
            .split(',')
            .collect::<Vec<_>>()[1..4],
        last
    );

    // A second pass over what was written once has both under one name.
    let again = "t,ax_mps2,ay_mps2,az_mps2\n0,0.1,0.2,9.80\n1,0.1,0.2,9.81\n";
    let (out, summary) = run_with(&si(), again.as_bytes(), &keep).unwrap();
    assert!(
        out.starts_with("t,input_ax_mps2,input_ay_mps2,input_az_mps2,ax_mps2,ay_mps2,az_mps2\n")
    );
    finding(&summary, "renamed-column");
}

#[test]
fn without_a_header_columns_are_named_by_role() {
    let text: String = (0..40)
        .map(|i| {
            format!(
                "{},0.1,0.{},9.8,25.{i},0.5,0.{i},0.2\n",
                10 * i + i % 2,
                i % 3
            )
        })
        .collect();
    let (out, summary) = run(&si(), &text);
    assert_eq!(
        out.lines().next().unwrap(),
        "t,ax_mps2,ay_mps2,az_mps2,temperature,gx,gy,gz"
    );
    assert_eq!((summary.lines, summary.rows), (40, 40));
    let spec = ApplyOptions {
        read: ReadOptions {
            columns: Some("_,ax,ay,az,_,label".parse().unwrap()),
            ..ReadOptions::default()
        },
        ..options()
    };
    let (out, _) = run_with(&si(), text.as_bytes(), &spec).unwrap();
    assert!(out.starts_with("column_1,ax_mps2,ay_mps2,az_mps2,column_5,label,column_7,column_8\n"));
}

#[test]
fn two_header_rows_become_one() {
    let text = "sensor,left,left,left,right,right,right\naxis,acc_x,acc_y,acc_z,acc_x,acc_y,acc_z\n\
                0,0.1,0.2,9.8,1,2,3\n1,0.1,0.2,9.8,1,2,4\n";
    let (out, _) = run(&si(), text);
    assert!(
        out.starts_with(
            "sensor.axis,ax_mps2,ay_mps2,az_mps2,right.acc_x,right.acc_y,right.acc_z\n0,"
        ),
        "{out}"
    );
}

#[test]
fn semicolons_decimal_commas_tabs_and_spaces() {
    let cal = si();
    let (plain, _) = run(
        &cal,
        "t,ax,ay,az,T\n0.5,0.1,0.2,9.8,25.5\n0.6,0.1,0.2,9.7,25.5\n",
    );
    let (out, _) = run(
        &cal,
        "t;ax;ay;az;T\n0,5;0,1;0,2;9,8;25,5\n0,6;0,1;0,2;9,7;25,5\n",
    );
    let same = plain.replace(',', ";").replace('.', ",");
    assert_eq!(out, same);
    let (out, _) = run(
        &cal,
        " t  ax ay az   T\n 0.5 0.1   0.2 9.8 25.5 \n0.6\t0.1 0.2 9.7  25.5\n",
    );
    assert_eq!(out, plain.replace(',', "\t"));
    let (out, _) = run(
        &cal,
        "t\tax\tay\taz\tT\r\n0.5\t0.1\t0.2\t9.8\t25.5\r\n0.6\t0.1\t0.2\t9.7\t25.5\r\n",
    );
    assert_eq!(out, plain.replace(',', "\t"));
    let (out, _) = run(
        &cal,
        "t ax ay az T\n0,5 0,1 0,2 9,8 25,5\n0,6 0,1 0,2 9,7 25,5\n",
    );
    assert_eq!(out, plain.replace(',', "\t").replace('.', ","));
}

#[test]
fn every_line_is_accounted_for() {
    let text = "Fs,100\n\nt,ax,ay,az\n\
                0,0.1,0.2,9.8\n\n,,,\n1,0.1,0.2,9.8\n# a remark\nt,ax,ay,az\n2,0.1,0.2\n\
                3,0.1,0.2,9.8,4,0.1\n4,0.1,abc,9.8\n5,,0.2,9.8\n\u{0}6,0.1,0.2,9.8\n";
    let (out, summary) = run(&si(), text);
    let starts: Vec<&str> = out.lines().map(|l| l.split(',').next().unwrap()).collect();
    assert_eq!(starts, ["t", "0", "", "", "1", "5", "6"]);
    assert_eq!(out.lines().nth(5).unwrap(), "5,,,");
    let aside = |reason: Aside| {
        let entry = summary.set_aside.iter().find(|s| s.reason == reason);
        entry.map_or(0, |s| s.lines)
    };
    assert_eq!((summary.lines, summary.rows), (14, 4));
    for (reason, lines) in [
        (Aside::Header, 1),
        (Aside::Metadata, 1),
        (Aside::Blank, 3),
        (Aside::Comment, 1),
        (Aside::RepeatedHeader, 1),
        (Aside::TornLine, 1),
        (Aside::TooManyFields, 1),
        (Aside::NotANumber, 1),
    ] {
        assert_eq!(aside(reason), lines, "{reason:?}");
    }
    assert_eq!(finding(&summary, "torn-line").lines, [[10, 10]]);
    assert_eq!(finding(&summary, "empty-cells").lines, [[13, 13]]);
    assert_eq!(finding(&summary, "nul-bytes").lines, [[14, 14]]);
    assert_eq!(summary.rows_without_acceleration, 1);
}

#[test]
fn a_named_gap_stays_a_break_and_its_clock_may_start_anew() {
    let row = |i: usize| match i {
        50 => "# gap: the board was reset, the clock of the board starts anew".to_owned(),
        ..50 => format!("{},0.1,0.{},9.8,7", 9000 + 10 * i, i % 3),
        _ => format!("{},0.1,0.{},9.8,7", 6000 + 10 * i, i % 3),
    };
    let text = still("t_ms,ax,ay,az,n", 100, row);
    let (out, summary) = run(&si(), &text);
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!((lines.len(), lines[51], summary.rows), (101, "", 99));
    assert_eq!(finding(&summary, "named-gap").lines, [[52, 52]]);
    assert_eq!(finding(&summary, "restarted-time").lines, [[53, 53]]);
}

#[test]
fn a_tail_of_zeros_is_set_aside_and_zeros_within_are_not() {
    let row = |i: usize| match i {
        20..30 | 50.. => format!("{i},0,0,0,7"),
        _ => format!("{i},0.1,0.{},9.8,7", i % 3),
    };
    let text = still("t,ax,ay,az,n", 60, row);
    let (out, summary) = run(&si(), &text);
    assert_eq!((out.lines().count(), summary.rows), (51, 50));
    assert!(out.lines().nth(25).unwrap().starts_with("24,"));
    assert_eq!(finding(&summary, "zero-tail").lines, [[52, 61]]);
    // One row alone can be a measurement.
    let (_, summary) = run(&si(), &still("t,ax,ay,az,n", 51, row));
    assert_eq!(summary.rows, 51);
    assert_eq!(
        refused(&si(), "ax,ay,az\n0,0,0\n0,0,0\n", &options()).code(),
        "all-zero"
    );
}

#[test]
fn a_tail_too_long_to_hold_back_is_written_with_a_finding() {
    let row = |i: usize| match i {
        50.. => format!("{i},0,0,0"),
        _ => format!("{i},0.1,0.{},9.8", i % 3),
    };
    let text = still("t,ax,ay,az", 60, row);
    let (cal, options) = (si(), options());
    let mut input = from_reader(Box::new(io::Cursor::new(text.into_bytes())), false).unwrap();
    let reader = std::mem::replace(&mut input.reader, Box::new(io::empty()));
    let prepared = prepare(reader, "rec.csv", &options.read).unwrap();
    let (dialect, layout) = (prepared.dialect, prepared.layout);
    let head = Head::read(&prepared.head, true, &dialect, &layout);
    let plan = Plan::new(&dialect, &layout, false, false);
    let mut findings = Vec::new();
    let judged =
        judge::judge(&cal, &head, &layout, &options.read, "", None, &mut findings).unwrap();
    let mut stream = Stream::new(
        Rewrite(&plan),
        Sensor::new(&cal, false, options.axes),
        Watch::new(judged.accel, 0.0, false),
        None,
        [false; 2],
        &dialect,
        layout.scanner(&dialect),
    );
    stream.tail.set_limit(100);
    let mut out = Vec::new();
    let done = stream
        .run(prepared.lines, &input, "rec.csv", &mut out)
        .unwrap();
    findings.extend(done.told.all());
    assert_eq!((done.ledger.rows, done.ledger.lines), (60, 61));
    assert_eq!(out.iter().filter(|b| **b == b'\n').count(), 61);
    let zero = findings.iter().find(|f| f.kind == "zero-tail").unwrap();
    assert_eq!((zero.count, &zero.lines[..]), (10, &[[52, 61]][..]));
}

#[test]
fn another_unit_is_refused_unless_insisted_on() {
    let rows = |g: f64| still("t,ax,ay,az", 40, |i| format!("{i},0.0,0.0{},{g}", i % 3));
    let in_g = rows(1.001);
    let error = refused(&si(), &in_g, &options());
    assert_eq!(error.code(), "unit-mismatch");
    assert!(error.is_input());
    let (message, hint) = (error.message(), error.hint().unwrap());
    assert!(
        message.contains("in g ") && message.contains("m/s^2"),
        "{message}"
    );
    assert!(hint.contains("--accel-unit m/s^2"), "{hint}");

    let told = |unit: AccelUnit| ApplyOptions {
        read: ReadOptions {
            accel_unit: Some(unit),
            ..ReadOptions::default()
        },
        ..options()
    };
    let insisted = told(AccelUnit::MetrePerSecondSquared);
    let (_, summary) = run_with(&si(), in_g.as_bytes(), &insisted).unwrap();
    finding(&summary, "unit-mismatch");
    assert_eq!(summary.accelerometer.origin, Origin::Given);
    let error = refused(&si(), &rows(9.8), &told(AccelUnit::StandardGravity));
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
fn calibrations_and_recordings_without_a_unit_are_judged_by_gravity() {
    let unknown = calibration(None, 3300.0 / 9.80665, [33000.0, 33100.0, 32900.0]);
    let unsigned = still("ax,ay,az", 60, |i| format!("33000,{},36200", 33100 + i % 4));
    let (_, summary) = run(&unknown, &unsigned);
    finding(&summary, "unit-unverified");
    assert_eq!(summary.accelerometer.unit, AccelUnit::Counts);
    assert_eq!(
        refused(
            &unknown,
            &still("ax,ay,az", 60, |i| format!("0.1,0.{},9.8", i % 4)),
            &options()
        )
        .code(),
        "unit-mismatch"
    );
    // Neither mg nor cm/s² can be told from 985; the calibration knows.
    let mg = calibration(Some("mg"), 1000.0 / 9.80665, [0.0; 3]);
    let (_, summary) = run(
        &mg,
        &still("x,ax,ay,az", 60, |i| format!("7,1.5,{}.5,985.2", i % 4)),
    );
    assert_eq!(summary.accelerometer.unit, AccelUnit::MilliGravity);
}

#[test]
fn of_a_moving_sensor_the_header_says_the_unit() {
    let moving = |unit: &str, size: f64| {
        still(&format!("ax ({unit}),ay ({unit}),az ({unit})"), 400, |i| {
            let x = i as f64;
            let swing = [1.9 * x, 2.3 * x, 3.1 * x].map(|p| size * p.sin());
            format!(
                "{:.3},{:.3},{:.3}",
                swing[0],
                swing[1],
                1.5 * size + swing[2]
            )
        })
    };
    let (_, summary) = run(&si(), &moving("m/s^2", 9.8));
    finding(&summary, "unit-unverified");
    assert_eq!(summary.accelerometer.origin, Origin::Header);
    assert_eq!(
        refused(&si(), &moving("g", 1.0), &options()).code(),
        "unit-mismatch"
    );
    // The header is wrong, and the size is that of no movement.
    assert_eq!(
        refused(&si(), &moving("m/s^2", 500.0), &options()).code(),
        "unit-mismatch"
    );
}

#[test]
fn the_unit_of_the_gyroscope_is_checked_too() {
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
    // A header that is wrong about the accelerometer proves nothing.
    let (_, summary) = run(&cal, &rows("deg/s", "g"));
    assert!(
        summary
            .findings
            .iter()
            .any(|f| f.message.contains("gyroscope is in deg/s"))
    );
    let insisted = ApplyOptions {
        read: ReadOptions {
            gyro_unit: Some(GyroUnit::RadianPerSecond),
            ..ReadOptions::default()
        },
        ..options()
    };
    assert!(run_with(&cal, rows("deg/s", "m/s^2").as_bytes(), &insisted).is_ok());
    let counts = with_gyro("counts");
    assert_eq!(
        refused(&counts, &rows("", "m/s^2"), &options()).code(),
        "unit-mismatch"
    );
}

#[test]
fn a_labelled_recording_in_counts_with_imucals_calibration() {
    let cal = CalibrationFile::parse(
        serde_json::json!({
            "acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": "a.u.", "from_gyr_unit": "a.u.",
            "K_a": [[208.5, 0.0, 0.0], [0.0, 208.0, 0.0], [0.0, 0.0, 214.7]],
            "R_a": [[0.99, 0.01, -0.01], [-0.01, 0.99, 0.02], [0.02, -0.01, 0.99]],
            "b_a": [-6.0, -48.2, -28.9],
            "K_g": [[16.6, 0.0, 0.0], [0.0, 16.1, 0.0], [0.0, 0.0, 16.2]],
            "R_g": [[-0.99, 0.01, 0.01], [0.01, -0.99, -0.03], [-0.01, 0.03, -0.99]],
            "K_ga": [[0.002, -0.016, 0.018], [0.013, 0.005, -0.008], [-0.009, 0.008, -0.003]],
            "b_g": [1.9, -4.4, -3.6], "cal_type": "Ferraris", "_format_version": "2.0",
        })
        .to_string()
        .as_bytes(),
    )
    .unwrap();
    let text = still(
        "n_samples,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,part",
        60,
        |i| format!("{i},-10,-50,{},2,-4,{},x_p", 2078 + i % 5, i % 3),
    );
    let (out, summary) = run(&cal, &text);
    assert!(
        out.starts_with("n_samples,ax_mps2,ay_mps2,az_mps2,gx_rad_s,gy_rad_s,gz_rad_s,part\n"),
        "{out}"
    );
    assert!(out.lines().skip(1).all(|l| l.ends_with(",x_p")));
    let line: Vec<&str> = out.lines().nth(1).unwrap().split(',').collect();
    let got: Vec<f64> = line[1..7].iter().map(|v| v.parse().unwrap()).collect();
    let a = cal
        .accelerometer_calibration()
        .apply([-10.0, -50.0, 2078.0]);
    let w = cal
        .gyroscope_calibration()
        .unwrap()
        .apply([2.0, -4.0, 0.0], a);
    for (got, expected) in got.iter().zip(a.iter().chain(&w)) {
        assert!((got - expected).abs() < 0.6e-6);
    }
    assert_eq!(
        summary.gyroscope,
        GyroscopeOutcome::Calibrated(GyroUnit::Counts)
    );
}

#[test]
fn channels_that_are_written_when_they_arrive_hold() {
    let row = |i: usize| match i % 3 {
        0 => format!("{i},0.{},,", i % 7),
        1 => format!("{i},,0.2,"),
        _ => format!("{i},,,9.8"),
    };
    let (out, summary) = run(&si(), &still("t,ax,ay,az", 60, row));
    assert_eq!(summary.rows_without_acceleration, 2);
    assert_eq!(out.lines().nth(1).unwrap(), "0,,,");
    assert!(!out.lines().nth(4).unwrap().contains(",,"));
}

/// Gives few bytes at a time, as a pipe does.
struct Drips<'a>(&'a [u8], usize);

impl Read for Drips<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.1 = self.1 * 5 % 97 + 1;
        let n = self.1.min(out.len()).min(self.0.len());
        let (now, later) = self.0.split_at(n);
        out[..n].copy_from_slice(now);
        self.0 = later;
        Ok(n)
    }
}

/// A recording with defects, longer than the head.
fn defective() -> String {
    let row = |i: usize| {
        let x = i as f64;
        let stamp = match i {
            5000 => 10 * i - 60,
            5001..5003 => 50010,
            _ => 10 * i,
        };
        let ay = if (6000..6300).contains(&i) {
            0.25
        } else {
            0.2 + 0.01 * (1.7 * x).sin()
        };
        let az = if i % 500 < 4 && i > 4000 {
            19.6127
        } else {
            9.8 + 0.01 * x.cos()
        };
        let zero = if i >= 9990 { 0.0 } else { 1.0 };
        let line = format!(
            "{stamp},{:.4},{:.4},{:.4},{:.3},0.01,{:.3}",
            zero * 0.01 * x.sin(),
            zero * ay,
            zero * az,
            zero * (0.3 * x).sin(),
            zero * 0.5
        );
        let zeros = "0.0000,0.0000,0.0000,0.000,0.000,0.000";
        match i {
            7000 => format!("{line}\n\nt_ms,ax,ay,az,gx,gy,gz"),
            7100 => line[..12].to_owned(),
            7200 => format!("{stamp},,0.2,9.8,1,2,3"),
            9990.. => format!("{stamp},{zeros}"),
            _ => line,
        }
    };
    still("t_ms,ax,ay,az,gx,gy,gz", 10_000, row)
}

#[test]
fn drops_give_the_same_as_the_whole() {
    let text: &'static str = Box::leak(defective().into_boxed_str());
    let (whole, by_whole) = run(&si(), text);
    let input = from_reader(Box::new(Drips(text.as_bytes(), 7)), false).unwrap();
    let mut out = Vec::new();
    let by_drops = apply(&si(), input, "rec.csv", &mut out, &options()).unwrap();
    assert!(whole.as_bytes() == out);
    assert_eq!(by_whole, by_drops);
}

#[test]
fn the_findings_of_the_stream_are_those_of_the_batch() {
    let text = defective();
    let (_, streamed) = run(&si(), &text);
    let batch = read_bytes(text.as_bytes(), "rec.csv", &ReadOptions::default()).unwrap();
    assert_eq!(streamed.lines, batch.ledger.lines);
    assert_eq!(streamed.rows, batch.ledger.rows);
    for kind in [
        "frozen-axis",
        "clipped",
        "backward-time",
        "duplicate-time",
        "gap",
        "zero-tail",
        "torn-line",
        "repeated-header",
        "blank-rows",
    ] {
        // Of a frozen axis only the ends are compared: a long run is kept as
        // one range, lines that are no rows within.
        let of = |findings: &[Finding]| -> Vec<_> {
            let of_kind = findings.iter().filter(|f| f.kind == kind);
            of_kind
                .map(|f| {
                    let ends = (f.lines.first().map(|l| l[0]), f.lines.last().map(|l| l[1]));
                    let lines = (kind != "frozen-axis").then(|| f.lines.clone());
                    (f.message.clone(), f.count, ends, lines)
                })
                .collect()
        };
        let expected = of(&batch.findings);
        assert!(!expected.is_empty() || kind == "gap", "{kind}");
        assert_eq!(of(&streamed.findings), expected, "{kind}");
    }
}

#[test]
fn a_packed_file_that_was_cut_off_gives_what_is_there() {
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gz.write_all(defective().as_bytes()).unwrap();
    let packed = gz.finish().unwrap();
    let (_, summary) = run_with(&si(), &packed[..packed.len() / 2], &options()).unwrap();
    assert!(summary.rows > 1000);
    finding(&summary, "truncated-file");
}

#[test]
fn what_holds_no_rows_is_refused_before_anything_is_written() {
    let input = from_reader(Box::new(&b"ax,ay,az\n,0.1,9.8\n,0.2,9.8\n"[..]), false).unwrap();
    let mut out = Vec::new();
    let error = apply(&si(), input, "rec.csv", &mut out, &options()).unwrap_err();
    assert_eq!((error.code(), out.len()), ("no-values", 0));
    assert_eq!(refused(&si(), "", &options()).code(), "empty-file");
}
