//! Headers between rows, as in two concatenated recordings.

use super::*;

/// The clean recording with its second half under `header`; `row` converts the fields of each
/// row.
fn halves(header: &[&str], row: impl Fn(Vec<&str>) -> String) -> Vec<u8> {
    let mut lines = lines();
    for line in &mut lines[301..] {
        *line = row(line.split(',').collect());
    }
    for (i, text) in header.iter().enumerate() {
        lines.insert(301 + i, (*text).to_owned());
    }
    joined(&lines)
}

fn times(text: &str, factor: f64) -> String {
    (text.parse::<f64>().unwrap() * factor).to_string()
}

#[test]
fn rows_under_a_different_header_are_converted() {
    let in_order = |f: Vec<&str>| f.join(",");
    for (header, row) in [
        (
            "Timestamp (ms),aY (m/s^2),aX (m/s^2),aZ (m/s^2),Temp (C),gX (rad/s),gY (rad/s),gZ (rad/s)",
            (|f: Vec<&str>| [f[0], f[2], f[1], f[3], f[4], f[5], f[6], f[7]].join(","))
                as fn(Vec<&str>) -> String,
        ),
        // Other names for the same columns, and an additional column.
        (
            "t (s),battery,temp,wx (rad/s),wy (rad/s),wz (rad/s),acc_x (mg),acc_y (mg),acc_z (mg)",
            |f| {
                let t = times(f[0], 1e-3);
                let a = |i: usize| times(f[i], 1000.0 / 9.80665);
                format!(
                    "{t},3.3,{},{},{},{},{},{},{}",
                    f[4],
                    f[5],
                    f[6],
                    f[7],
                    a(1),
                    a(2),
                    a(3)
                )
            },
        ),
    ] {
        let recording = read(&halves(&[header], row));
        let found = finding(&recording, "header-changed");
        assert_eq!(
            (found.severity, &found.lines[..]),
            (Severity::Warning, &[[302, 302]][..])
        );
        assert!(recording.breaks.is_empty());
        let clean = clean();
        for (got, want) in recording.accel.iter().zip(&clean.accel) {
            assert!(got.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-9));
        }
        assert_eq!(recording.gyro, clean.gyro);
    }
    // The first header repeated, after a reset of the board.
    let whole = HEADER.len();
    for torn in [&HEADER[..whole - 9], &HEADER[..whole - 12], &HEADER[18..]] {
        for header in [&[torn, HEADER][..], &[torn][..]] {
            let recording = read(&halves(header, in_order));
            assert!(!kinds(&recording).contains(&"header-changed"));
            unharmed(&recording);
        }
    }
}

#[test]
fn headers_that_cannot_be_converted_are_errors_with_their_line() {
    for (header, what) in [
        (
            HEADER.replace("m/s^2", "counts"),
            "unit of the accelerometer",
        ),
        (HEADER.replace(" (rad/s)", ""), "unit of the gyroscope"),
        (HEADER.replace("gX (rad/s)", "light"), "names no column for"),
    ] {
        let bytes = halves(&[&header], |f| f.join(","));
        let error = read_bytes(&bytes, "test.csv", &ReadOptions::default()).unwrap_err();
        assert_eq!(error.code(), "header-differs");
        assert_eq!(error.location().and_then(|l| l.line), Some(302));
        assert!(error.message().contains(what), "{error}");
    }
    // Fewer columns, and other delimiters.
    let fewer = |f: Vec<&str>| f[..6].join(",");
    let semicolons = |f: Vec<&str>| f.join(";");
    for (bytes, what) in [
        (
            halves(&[HEADER.rsplitn(3, ',').last().unwrap()], fewer),
            "names no column for",
        ),
        (
            halves(&[&HEADER.replace(',', ";")], semicolons),
            "separated by semicolon",
        ),
    ] {
        let error = read_bytes(&bytes, "test.csv", &ReadOptions::default()).unwrap_err();
        assert_eq!(error.code(), "header-differs");
        assert_eq!(error.location().and_then(|l| l.line), Some(302));
        assert!(error.message().contains(what), "{error}");
    }
}

#[test]
fn counts_at_another_range_of_the_board_are_converted() {
    let board = |range: u16| {
        format!(
            "# gravical mpu6050_logger 1.0, MPU6050, accelerometer +-{range} g, gyroscope +-250 deg/s, low-pass 44 Hz, rate 100.00 Hz, format 1"
        )
    };
    let names = "t,ax,ay,az,T,gx,gy,gz";
    let row = |i: usize, lsb: usize| format!("{},{},{},{},0,1,2,3", 10 * i, i % 5, 7, lsb + i % 3);
    let mut lines = vec![board(2), names.to_owned()];
    lines.extend((0..300).map(|i| row(i, 16384)));
    lines.extend([board(4), names.to_owned()]);
    lines.extend((300..600).map(|i| row(i, 8192)));
    let recording = read(&joined(&lines));
    assert_eq!(finding(&recording, "header-changed").lines, [[304, 304]]);
    assert!(recording.accel[2].iter().all(|z| (z - 16384.0).abs() < 5.0));
}

#[test]
fn a_short_recording_before_a_wider_one_is_read() {
    let mut lines = lines();
    lines.truncate(101);
    let narrow = "Timestamp (ms),aX (m/s^2),aY (m/s^2),aZ (m/s^2)";
    for line in &mut lines {
        *line = line.splitn(5, ',').take(4).collect::<Vec<_>>().join(",");
    }
    assert_eq!(lines[0], narrow);
    lines.extend(report_lines(HEADER, ROWS));
    let recording = read(&joined(&lines));
    assert_eq!(recording.rows(), 100 + ROWS);
    finding(&recording, "header-changed");
}

#[test]
fn raw_and_calibrated_rows_are_not_mixed() {
    let part = |format: u8, header: &str| {
        let rows = |i: i64| format!("{},0.1,0.2,9.8,25,0,0,0\n", 10 * i);
        let rows: String = (0..300).map(rows).collect();
        format!(
            "# gravical mpu6050_logger 1.1, MPU6050, accelerometer +-2 g, gyroscope +-500 deg/s, low-pass 44 Hz, rate 100.00 Hz, format {format}\nTimestamp (ms),{header}\n{rows}"
        )
    };
    let raw = "aX (m/s^2),aY (m/s^2),aZ (m/s^2),Temp (C),gX (deg/s),gY (deg/s),gZ (deg/s)";
    let own = "ax_mps2,ay_mps2,az_mps2,Temp (C),gx_rad_s,gy_rad_s,gz_rad_s";
    let read = |parts: [String; 2]| {
        let text = parts.concat();
        read_bytes(text.as_bytes(), "board.csv", &ReadOptions::default())
    };
    for parts in [[part(0, raw), part(3, own)], [part(3, own), part(0, raw)]] {
        let error = read(parts).unwrap_err();
        assert_eq!(error.code(), "header-differs");
        assert!(error.to_string().contains("calibrated"), "{error}");
    }
    assert!(!read([part(0, raw), part(0, raw)]).unwrap().is_calibrated);
    assert!(read([part(3, own), part(3, own)]).unwrap().is_calibrated);
}
