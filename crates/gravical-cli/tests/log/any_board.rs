//! Boards with other sketches than the project's: any separator, numbers with names, no time. What
//! they send is read by the other commands.

use std::fs;

use gravical::recording::Recording;
use serde_json::Value;

use crate::board::Board;
use crate::logger::Logger;
use crate::recording;

const ROWS: u32 = 120;

struct Outcome {
    text: String,
    recording: Recording,
    ended: Value,
}

/// Noise of the sample `i`, up to 0.03.
fn noise(i: u32, channel: u32) -> f64 {
    f64::from((i * 7919 + channel * 131) % 61) * 5e-4
}

/// The sample `i` of a sensor at rest with z up, m/s².
fn at_rest(i: u32) -> [f64; 3] {
    [noise(i, 1), noise(i, 2), 9.81 + noise(i, 3)]
}

/// Records what `line` prints for each sample, and what comes before the first.
fn record(before: &str, options: &str, line: impl Fn(u32) -> String) -> Outcome {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let port = board.port();
    let command = format!("log -o x.csv --rows {ROWS} --json {options} --port {port}");
    let mut log = Logger::start(folder.path(), &command);
    log.wait_for("opened");
    // The first line may lack its beginning.
    board.say(&format!("\n{before}"));
    for i in 0.. {
        board.say(&line(i));
        std::thread::sleep(std::time::Duration::from_millis(10));
        log.look();
        if log.has_seen("ended") {
            break;
        }
    }
    let (code, ended) = log.ended();
    let path = folder.path().join("x.csv");
    let text = fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(code, 0, "{ended}\n{text}");
    Outcome {
        recording: recording(&path),
        text,
        ended,
    }
}

impl Outcome {
    /// The file has this header and unit, and times that are those of arrival.
    fn has(&self, header: &str, unit: &str, gyro: bool) {
        assert!(self.text.contains(header), "{}", self.text);
        assert_eq!(self.recording.rows(), ROWS as usize, "{}", self.text);
        assert_eq!(self.recording.accel_scale.unit.name(), unit);
        assert_eq!(self.recording.gyro.is_some(), gyro);
        assert_eq!(self.ended["rows"], ROWS, "{}", self.ended);
        let rejected = self.text.matches("\n# rejected: ").count();
        assert_eq!(self.ended["rejected"], rejected, "{}", self.text);
        let time_s = self.recording.time_s.as_ref().unwrap();
        let last_s = time_s[time_s.len() - 1];
        assert!((1.0..20.0).contains(&last_s), "{last_s} s\n{}", self.text);
    }
}

#[test]
fn columns_without_a_stamp() {
    let outcome = record("", "", |i| {
        let [x, y, z] = at_rest(i);
        format!("{x:.3},{y:.3},{z:.3}\r\n")
    });
    outcome.has("\nt_host_ms,ax,ay,az\n", "m/s^2", false);
    let header = "AccX (g)\tAccY (g)\tAccZ (g)\tGyrX\tGyrY\tGyrZ\n";
    let outcome = record(header, "", |i| {
        let [x, y, z] = at_rest(i).map(|v| v / 9.81);
        format!("{x:.4}\t{y:.4}\t{z:.4}\t{:.3}\t0.1\t0.2\n", noise(i, 4))
    });
    outcome.has(&format!("\nt_host_ms\t{header}"), "g", true);
    let outcome = record("", "", |i| {
        let ([x, y, z], rate) = (at_rest(i), noise(i, 4) * 0.1);
        format!("{x:.3} {y:.3} {z:.3}  {rate:.3} 0.01 0.02  20.1 -3.2 44.0\n")
    });
    outcome.has("\nt_host_ms ax ay az gx gy gz c7 c8 c9\n", "m/s^2", true);
}

#[test]
fn columns_that_the_user_names() {
    let options = "--columns gx,gy,gz,ax,ay,az";
    let outcome = record("Sensor 1\n", options, |i| {
        let ([x, y, z], rate) = (at_rest(i), noise(i, 4));
        format!("0.1,0.2,{rate:.3},{x:.3},{y:.3},{z:.3},20.1,-3.2,44\n")
    });
    let header = "\nt_host_ms,gx,gy,gz,ax,ay,az,c7,c8,c9\n";
    outcome.has(header, "m/s^2", true);
}

#[test]
fn words_without_a_stamp() {
    let outcome = record("Adafruit MPU6050 test!\n", "", |i| match (i, at_rest(i)) {
        (50, _) => "I2C error\n".to_owned(),
        (_, [x, y, z]) => format!("Acceleration X: {x:.2}, Y: {y:.2}, Z: {z:.2} m/s^2\n"),
    });
    outcome.has(" -> Acceleration X: ", "m/s^2", false);
    assert!(outcome.text.contains("\n# rejected: I2C error\n"));
    // A row in two lines, and rows of JSON.
    let outcome = record("", "", |i| {
        let [x, y, z] = at_rest(i);
        format!(
            "Accel X: {x:.2}, Y: {y:.2}, Z: {z:.2} m/s^2\nGyro X: 0.01, Y: 0.02, Z: {:.3} rad/s\n",
            noise(i, 5)
        )
    });
    outcome.has(" -> Gyro X: ", "m/s^2", true);
    let outcome = record("", "", |i| {
        let [x, y, z] = at_rest(i);
        format!("{{\"ax\":{x:.3},\"ay\":{y:.3},\"az\":{z:.3}}}\n")
    });
    outcome.has(" -> {\"ax\":", "m/s^2", false);
}

#[test]
fn serial_plotter_with_a_stamp_and_torn_lines() {
    let outcome = record("", "", |i| {
        let [x, y, z] = at_rest(i);
        let row = format!("ms:{} ax:{x:.3} ay:{y:.3} az:{z:.3}\n", 10 * i);
        match i {
            // Bytes are lost.
            20 => row.replace(" ay:", ""),
            30 => "ax:1 ay:2 az:3\n".to_owned(),
            _ => row,
        }
    });
    outcome.has("\nms:0 ax:", "m/s^2", false);
    assert_eq!(outcome.ended["rejected"], 2, "{}", outcome.ended);
}

#[test]
fn semicolons_with_a_stamp() {
    let outcome = record("time;a_x;a_y;a_z;temp\n", "", |i| {
        let [x, y, z] = at_rest(i).map(|v| v * 1670.0);
        format!("{};{x:.0};{y:.0};{z:.0};25.5\n", 10 * i)
    });
    outcome.has("\ntime;a_x;a_y;a_z;temp\n0;", "counts", false);
}

/// Rows are few, slow, or none.
#[test]
fn few_rows_and_none() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let command = format!("log -o x.csv --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &command);
    log.wait_for("opened");
    board.greet();
    board.rows(10);
    log.wait_for("board");
    std::thread::sleep(std::time::Duration::from_millis(300));
    log.signal(rustix::process::Signal::INT);
    let (code, ended) = log.ended();
    assert_eq!((code, &ended["rows"]), (0, &10.into()), "{ended}");
    assert_eq!(recording(&folder.path().join("x.csv")).rows(), 10);

    let command = format!("log -o y.csv --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &command);
    log.wait_for("opened");
    let words = "what a loose wire makes of a row\n".repeat(1000);
    board.say(&words);
    let (code, error) = log.ended();
    assert_eq!(
        (code, error["code"].as_str()),
        (5, Some("no-samples-from-board"))
    );
    let message = error["message"].as_str().unwrap();
    assert!(message.contains("a loose wire"), "{message}");
    assert!(!folder.path().join("y.csv").exists());
}

/// Below the comments of the logger a table needs a header.
#[test]
fn a_stamp_and_no_header() {
    let outcome = record("", "", |i| {
        let [x, y, z] = at_rest(i);
        format!("{},{x:+.3},{y:+.3},{z:+.3}\n", 10 * i)
    });
    assert_eq!(outcome.recording.rows(), ROWS as usize, "{}", outcome.text);
    assert!(outcome.recording.time_s.is_some());
    assert_eq!(outcome.ended["rejected"], 0, "{}", outcome.text);
}

#[test]
fn numbers_with_their_sign() {
    let outcome = record("", "", |i| {
        let [x, y, z] = at_rest(i);
        format!("{x:+.3},{y:+.3},{z:+.3}\n")
    });
    outcome.has("\nt_host_ms,ax,ay,az\n", "m/s^2", false);
}
