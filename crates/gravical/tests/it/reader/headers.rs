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
    let hint = format!("split the file before line {line}");
    assert!(error.hint().unwrap().starts_with(&hint), "{error}");
    error.message().to_owned()
}

#[test]
fn another_header_is_an_error_with_its_line() {
    let in_order: fn(Vec<&str>) -> String = |f| f.join(",");
    let fewer = HEADER.rsplitn(3, ',').last().unwrap().to_owned();
    for (header, row) in [
        (
            HEADER
                .replace("aX", "a")
                .replace("aY", "aX")
                .replace("a (", "aY ("),
            in_order,
        ),
        (HEADER.replace("m/s^2", "counts"), in_order),
        (HEADER.replace(" (rad/s)", ""), in_order),
        (HEADER.replace("gX (rad/s)", "light"), in_order),
        (fewer, |f| f[..6].join(",")),
        (format!("{HEADER},battery"), |f| f.join(",") + ",3.3"),
    ] {
        differs(&halves(&[&header], row), 302);
    }
    let semicolons = |f: Vec<&str>| f.join(";");
    let said = differs(&halves(&[&HEADER.replace(',', ";")], semicolons), 302);
    assert!(said.contains("separated by semicolon"), "{said}");
}

#[test]
fn counts_at_another_range_of_the_board_are_an_error() {
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
    let said = differs(&joined(&lines), 303);
    assert!(said.contains("another range"), "{said}");
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
        assert!(
            error.to_string().contains("another range or format"),
            "{error}"
        );
    }
    assert!(!read([part(0, raw), part(0, raw)]).unwrap().is_calibrated);
    assert!(read([part(3, own), part(3, own)]).unwrap().is_calibrated);
}

/// The clean recording without stamps below a line of metadata.
fn below(metadata: &str) -> Recording {
    let head = ["Exported by an app".to_owned(), metadata.to_owned()];
    let rows = lines()
        .into_iter()
        .map(|l| l.split_once(',').unwrap().1.to_owned());
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
        assert_eq!(below(line).timing.nominal_rate_hz, rate_hz, "{line}");
    }
    for (line, serial) in [
        ("Serial Number: MOS2D12345678", Some("MOS2D12345678")),
        ("// DeviceId: 00B41234", Some("00B41234")),
        ("\"Serial no.\",1234", Some("1234")),
        ("Serial number: unknown", None),
        ("Serial port: COM3", None),
    ] {
        assert_eq!(below(line).serial.as_deref(), serial, "{line}");
    }
}
