//! The firmware on the emulated board.
#![allow(clippy::unwrap_used)] // helpers of a test may panic as it does

mod board;

use board::{board, line, notices, rows};
use gravical::recording::{ReadOptions, read_bytes};
use virtual_board::sensor::Reading;

const G: f64 = 9.80665;

/// A reading in counts of the default ranges.
fn counts(reading: &Reading, lsb_per_g: f64, lsb_per_deg_s: f64) -> [i32; 7] {
    let round = |v: f64| v.round() as i32;
    let [ax, ay, az] = reading.accel_mps2.map(|v| round(v / G * lsb_per_g));
    let [gx, gy, gz] = reading.gyro_deg_s.map(|v| round(v * lsb_per_deg_s));
    let temperature = round((reading.temperature_c - 36.53) * 340.0);
    [ax, ay, az, temperature, gx, gy, gz]
}

/// From the reading that fits the first row on each fits its own.
fn are_fed(rows: &[Vec<f64>], fed: &[Reading], fits: impl Fn(&[f64], &Reading) -> bool) {
    let at = fed.iter().position(|r| fits(&rows[0], r)).unwrap();
    for (row, reading) in rows.iter().zip(&fed[at..]) {
        assert!(fits(row, reading), "{row:?} {reading:?}");
    }
}

#[test]
fn it_says_what_it_is_and_the_reader_reads_it() {
    let Some(mut board) = board(&[]) else {
        return;
    };
    let text = board.text(6.0);
    let mut lines = text.lines();
    // The end of what a reset may have torn off.
    assert_eq!(lines.next(), Some(""));
    let settings = "# gravical mpu6050_logger 1.1, MPU6050, accelerometer +-2 g, gyroscope +-500 deg/s, \
                    low-pass 44 Hz, rate 100.00 Hz, format 0";
    let header = "Timestamp (ms),aX (m/s^2),aY (m/s^2),aZ (m/s^2),Temp (C),\
                  gX (deg/s),gY (deg/s),gZ (deg/s)";
    assert_eq!([lines.next(), lines.next()], [Some(settings), Some(header)]);
    // The last line may be cut.
    let whole = &text[..=text.rfind('\n').unwrap()];
    assert_eq!(notices(whole).len(), 1, "{:?}", notices(whole));
    let recording = read_bytes(whole.as_bytes(), "board.csv", &ReadOptions::default()).unwrap();
    assert!(recording.rows() > 575);
    assert_eq!(recording.units.accel.unit.name(), "m/s^2");
    assert_eq!(recording.units.gyro.unwrap().unit.name(), "deg/s");
    assert!(recording.temperature_c.is_some());
    assert!(recording.findings.is_empty(), "{:?}", recording.findings);
    assert!((recording.clock.rate_hz().unwrap() - 100.0).abs() < 0.1);

    // Every row is what the sensor was fed, within its rounding.
    let rows = rows(whole);
    let fits = |row: &[f64], reading: &Reading| {
        let counts = counts(reading, 16384.0, 65.5).map(f64::from);
        (0..7).all(|i| {
            let (exact, last_digit) = match i {
                0..3 => (counts[i] * G / 16384.0, 1e-4),
                3 => (counts[i] / 340.0 + 36.53, 1e-2),
                _ => (counts[i] / 65.5, 1e-3),
            };
            (row[i + 1] - exact).abs() < 0.51 * last_digit + 1e-5 * exact.abs()
        })
    };
    let fed = board.fed.borrow();
    assert!(fed.iter().take(5).any(|r| fits(&rows[0], r)));
    are_fed(&rows, &fed, fits);
}

#[test]
fn stamps_show_the_clock_of_the_sensor() {
    for ppm in [8000.0, -8000.0] {
        let Some(mut board) = board(&[]) else {
            return;
        };
        board.uno.sensor().clock_error_ppm = ppm;
        board.text(0.5);
        let before = board.uno.sensor().samples().1;
        let text = board.text(8.0);
        let rows = rows(text.split_once('\n').unwrap().1);
        let (rate_hz, sd_us) = line(&rows[..rows.len() - 1]);
        let off_hz = rate_hz - 100.0 * (1.0 + ppm * 1e-6);
        assert!(off_hz.abs() < 0.01 && sd_us < 400.0, "{rate_hz} {sd_us}");
        assert_eq!(board.uno.sensor().samples().1, before, "none was missed");
    }
}

#[test]
fn counts_at_200_hz_are_those_of_the_sensor_and_known_to_the_reader() {
    let Some(mut board) = board(&[]) else {
        return;
    };
    board.text(0.5);
    let text = board.say("r200\nf1\n", 5.0);
    let from = text.rfind("# gravical").unwrap();
    let text = &text[from..=text.rfind('\n').unwrap()];
    assert!(text.contains("rate 200.00 Hz, format 1\nTimestamp (ms),ax,ay,az,temp,gx,gy,gz\n"));
    let recording = read_bytes(text.as_bytes(), "counts.csv", &ReadOptions::default()).unwrap();
    assert_eq!(recording.units.accel.unit.name(), "counts", "{text}");
    assert_eq!(recording.units.accel.lsb_per_g, Some(16384.0));
    // To say the settings takes longer than two samples.
    let rows = &rows(text)[20..];
    let (rate_hz, _) = line(rows);
    assert!((rate_hz - 200.0).abs() < 0.05, "{rate_hz}");
    let fits = |row: &[f64], r: &Reading| row[1..] == counts(r, 16384.0, 65.5).map(f64::from);
    are_fed(rows, &board.fed.borrow(), fits);
}

#[test]
fn commands() {
    let Some(mut board) = board(&[]) else {
        return;
    };
    board.text(0.5);
    let all = "accelerometer +-8 g, gyroscope +-250 deg/s, low-pass 5 Hz, rate 100.00 Hz";
    for (command, says) in [
        ("a4\n", "accelerometer +-4 g"),
        ("a5\r\n", "accelerometer +-8 g"),
        ("g 250\n", "gyroscope +-250 deg/s"),
        ("d260\n", "low-pass 184 Hz"),
        ("d5\n", "low-pass 5 Hz"),
        ("r0\n", "rate 4.00 Hz"),
        ("r100\n", "rate 100.00 Hz"),
        ("f7\n", "format 0"),
        ("?\n", all),
    ] {
        let text = board.say(command, 0.8);
        // To say all of it takes longer than two samples.
        let mut said = notices(&text);
        said.retain(|l| !l.starts_with("# overruns"));
        assert_eq!(said.len(), 1, "{command:?} {said:?}");
        assert!(said[0].contains(says), "{command:?} {said:?}");
        let rows = rows(text.rsplit_once("(deg/s)\n").unwrap().1);
        let norm = |r: &Vec<f64>| r[1..4].iter().map(|v| v * v).sum::<f64>().sqrt();
        let is_g = rows.first().is_none_or(|r| (norm(r) - G).abs() < 1.0);
        assert!(is_g, "{command:?} {:?}", rows.first());
    }
    let text = board.say("x\nhello\n\n\n99\n", 0.5);
    let said = notices(&text);
    assert!(!said.is_empty() && said.iter().all(|l| l.starts_with("# not a command")));
    board.say("p\n", 0.1);
    assert!(rows(&board.text(1.0)).is_empty());
    board.say("s\n", 0.1);
    let text = board.text(1.0);
    assert!(notices(&text).is_empty(), "a pause is no overrun: {text}");
    assert!(rows(text.split_once('\n').unwrap().1).len() > 95);
}

/// What gets through at which rate, and that the rest is counted.
#[test]
fn too_fast_is_said() {
    let Some(mut board) = board(&[]) else {
        return;
    };
    board.text(0.5);
    board.say("r250\n", 0.3);
    let (samples, unread) = board.uno.sensor().samples();
    let text = board.text(5.0);
    let lines = notices(&text).into_iter();
    let overruns = lines.filter_map(|l| l.strip_prefix("# overruns ")?.split(',').next());
    let reported: Vec<u64> = overruns.map(|count| count.parse().unwrap()).collect();
    let (all, lost) = board.uno.sensor().samples();
    let lost = lost - unread;
    assert!(lost < all - samples, "{lost}");
    let (first, last) = (reported[0], reported[reported.len() - 1]);
    // Reported once a second: the first and the last are up to a second apart from
    // the ends.
    let share = (last - first) as f64 / lost as f64;
    assert!((0.5..1.05).contains(&share), "{share}");
}
