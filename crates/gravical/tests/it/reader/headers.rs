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

#[test]
fn a_repeated_header_changes_nothing() {
    let in_order = |f: Vec<&str>| f.join(",");
    // The first header repeated, after a reset of the board.
    let whole = HEADER.len();
    for torn in [&HEADER[..whole - 9], &HEADER[..whole - 12], &HEADER[18..]] {
        for header in [&[torn, HEADER][..], &[torn][..]] {
            unharmed(&read(&halves(header, in_order)));
        }
    }
}

/// The error of these bytes, about a header in `line`.
fn differs(bytes: &[u8], line: u64) -> String {
    let error = read_bytes(bytes, "test.csv", &ReadOptions::default()).unwrap_err();
    assert_eq!(error.code(), "header-differs");
    assert_eq!(error.location().and_then(|l| l.line), Some(line));
    let hint = format!("`tail -n +{line} FILE > after.csv`");
    assert!(error.hint().unwrap().contains(&hint), "{error}");
    error.message().to_owned()
}

#[test]
fn another_header_is_an_error_with_its_line() {
    let in_order: fn(Vec<&str>) -> String = |f| f.join(",");
    for (header, row) in [
        (HEADER.replace("aX (m/s^2),aY", "aY (m/s^2),aX"), in_order),
        (HEADER.replace("m/s^2", "counts"), in_order),
        (HEADER.replace(" (rad/s)", ""), in_order),
        (HEADER.replace("gX (rad/s)", "light"), in_order),
        (format!("{HEADER},battery"), |f| f.join(",") + ",3.3"),
    ] {
        differs(&halves(&[&header], row), 302);
    }
    let semicolons = |f: Vec<&str>| f.join(";");
    differs(&halves(&[&HEADER.replace(',', ";")], semicolons), 302);
}

#[test]
fn parts_of_a_board_with_other_ranges_or_formats_are_not_mixed() {
    let part = |range: u8, format: u8, header: &str, values: &str| {
        let rows: String = (0..300).map(|i| format!("{},{values}\n", 10 * i)).collect();
        format!(
            "# gravical mpu6050_logger 1.1, MPU6050, accelerometer +-{range} g, gyroscope +-500 deg/s, low-pass 44 Hz, rate 100.00 Hz, format {format}\n{header}\n{rows}"
        )
    };
    let counts = |range, z: &str| {
        let values = format!("1,7,{z},0,1,2,3");
        part(range, 1, "t,ax,ay,az,T,gx,gy,gz", &values)
    };
    let values = "0.1,0.2,9.8,25,0,0,0";
    let names =
        "Timestamp (ms),aX (m/s^2),aY (m/s^2),aZ (m/s^2),Temp (C),gX (deg/s),gY (deg/s),gZ (deg/s)";
    let raw = part(2, 0, names, values);
    let names = "Timestamp (ms),ax_mps2,ay_mps2,az_mps2,Temp (C),gx_rad_s,gy_rad_s,gz_rad_s";
    let own = part(2, 3, names, values);
    for parts in [
        [counts(2, "16384"), counts(4, "8192")],
        [raw.clone(), own.clone()],
        [own.clone(), raw.clone()],
    ] {
        let said = differs(parts.concat().as_bytes(), 303);
        assert!(said.contains("another range or format"), "{said}");
    }
    for (part, is_calibrated) in [(raw, false), (own, true)] {
        let whole = read(part.repeat(2).as_bytes());
        assert_eq!(whole.format.is_calibrated(), is_calibrated);
    }
}

/// The clean recording without stamps below a line of metadata.
fn below(metadata: &str) -> Recording {
    let head = ["Exported by an app".to_owned(), metadata.to_owned()];
    let mut rows = lines();
    rows.iter_mut()
        .for_each(|l| *l = l.split_once(',').unwrap().1.to_owned());
    read(&joined(&head.into_iter().chain(rows).collect::<Vec<_>>()))
}

#[test]
fn spellings_of_rates_and_serial_numbers() {
    for (line, rate_hz) in [
        ("Fs,100", Some(100.0)),
        ("# rate: 62.5 Hz", Some(62.5)),
        ("Sample Rate:,128,Hz", Some(128.0)),
        ("// Update Rate: 40.0Hz", Some(40.0)),
        ("# output data rate: 104 Hz", Some(104.0)),
        ("# Sampling frequency (Hz): 100", Some(100.0)),
        ("# rate 100 Hz, low-pass corner 44 Hz", Some(100.0)),
        ("# low-pass cutoff frequency: 44 Hz", None),
        ("# bandwidth: frequency 44 Hz", None),
        ("# sampling interval: 10 ms", None),
        ("Baud rate: 115", None),
        ("Data rate: 115200", None),
        ("Look at 5 trees", None),
    ] {
        assert_eq!(below(line).clock.nominal_rate_hz, rate_hz, "{line}");
    }
    for (line, serial) in [
        ("Serial Number: MOS2D12345678", Some("MOS2D12345678")),
        ("// DeviceId: 00B41234", Some("00B41234")),
        ("\"Serial no.\",1234", Some("1234")),
        ("Serial number: unknown", None),
        ("Serial port: COM3", None),
    ] {
        assert_eq!(below(line).format.serial().as_deref(), serial, "{line}");
    }
}
