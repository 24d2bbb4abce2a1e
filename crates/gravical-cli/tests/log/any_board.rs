//! Boards with other sketches than the project's: any number of columns, any separator,
//! numbers with names. What they send is read by the other commands.

use std::fs;
use std::path::Path;

use gravical::recording::Recording;
use serde_json::Value;

use crate::board::Board;
use crate::logger::{Logger, words};
use crate::recording;

/// What the tests look at.
struct Outcome {
    text: String,
    recording: Recording,
    /// Of `gravical inspect --json`.
    inspected: Value,
    ended: Value,
}

fn inspect(folder: &Path, file: &str) -> Value {
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_gravical"))
        .args(words(&format!("inspect {file} --json")))
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(run.status.success(), "{run:?}");
    serde_json::from_slice(&run.stdout).unwrap()
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
    let command = format!(
        "log -o x.csv --rows 80 --json {options} --port {}",
        board.port()
    );
    let mut log = Logger::start(folder.path(), &command);
    log.wait_for("opened");
    // The first line may lack its beginning.
    board.say("\n");
    board.say(before);
    for i in 0.. {
        board.say(&line(i));
        std::thread::sleep(std::time::Duration::from_millis(10));
        log.look();
        if log.has_seen("ended") {
            break;
        }
    }
    let (code, ended) = log.ended();
    assert_eq!(code, 0, "{ended}");
    let path = folder.path().join("x.csv");
    Outcome {
        text: fs::read_to_string(&path).unwrap(),
        recording: recording(&path),
        inspected: inspect(folder.path(), "x.csv"),
        ended,
    }
}

impl Outcome {
    /// Columns and unit as the library and `inspect` have them.
    fn has(&self, header: &str, unit: &str, gyro: bool) {
        assert!(
            self.text.contains(&format!("\n{header}\n")),
            "{}",
            self.text
        );
        assert_eq!(self.recording.rows(), 80);
        assert_eq!(self.recording.accel_scale.unit.name(), unit);
        assert_eq!(self.recording.gyro.is_some(), gyro);
        assert_eq!(self.ended["stored"], 80, "{}", self.ended);
        let inspected = self.inspected.to_string();
        assert!(inspected.contains(&format!("\"{unit}\"")), "{inspected}");
    }

    /// The file has arrival times.
    fn has_host_time(&self) {
        assert!(
            self.text.contains("\n# t_host_ms: the board sends no time"),
            "{}",
            self.text
        );
        let time_s = self.recording.time_s.as_ref().unwrap();
        let last_s = time_s[time_s.len() - 1];
        assert!((0.7..20.0).contains(&last_s), "{last_s}");
    }
}

#[test]
fn three_columns_without_a_stamp() {
    let outcome = record("", "", |i| {
        let [x, y, z] = at_rest(i);
        format!("{x:.3},{y:.3},{z:.3}\r\n")
    });
    outcome.has("t_host_ms,ax,ay,az", "m/s^2", false);
    outcome.has_host_time();
}

#[test]
fn six_columns_with_tabs_below_another_header() {
    let outcome = record(
        "AccX (g)\tAccY (g)\tAccZ (g)\tGyrX\tGyrY\tGyrZ\n",
        "",
        |i| {
            format!(
                "{:.4}\t{:.4}\t{:.4}\t{:.3}\t0.1\t0.2\n",
                noise(i, 1) * 0.1,
                noise(i, 2) * 0.1,
                1.0 + noise(i, 3) * 0.1,
                noise(i, 4)
            )
        },
    );
    outcome.has(
        "t_host_ms\tAccX (g)\tAccY (g)\tAccZ (g)\tGyrX\tGyrY\tGyrZ",
        "g",
        true,
    );
    outcome.has_host_time();
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
    outcome.has("ms,ax,ay,az", "m/s^2", false);
    assert_eq!(outcome.ended["rejected"], 2, "{}", outcome.ended);
    assert!(!outcome.text.contains("t_host_ms"));
}

#[test]
fn numbers_with_names_and_a_unit_behind_the_last() {
    let outcome = record("Adafruit MPU6050 test!\n", "", |i| {
        let [x, y, z] = at_rest(i);
        format!("Acceleration X: {x:.2}, Y: {y:.2}, Z: {z:.2} m/s^2\n")
    });
    outcome.has(
        "t_host_ms,Acceleration X (m/s^2),Acceleration Y (m/s^2),Acceleration Z (m/s^2)",
        "m/s^2",
        false,
    );
    outcome.has_host_time();
    // The greeting is no row.
    assert_eq!(outcome.ended["rejected"], 1, "{}", outcome.ended);
}

#[test]
fn semicolons_with_a_stamp() {
    let outcome = record("time;a_x;a_y;a_z;temp\n", "", |i| {
        format!(
            "{};{:.0};{:.0};{:.0};25.5\n",
            10 * i,
            2000.0 * noise(i, 1),
            2000.0 * noise(i, 2),
            16384.0 + 2000.0 * noise(i, 3)
        )
    });
    outcome.has("time;a_x;a_y;a_z;temp", "counts", false);
    assert!(outcome.recording.temperature_c.is_some());
}

#[test]
fn nine_columns_with_a_magnetometer() {
    let line = |i: u32| {
        let ([x, y, z], rate) = (at_rest(i), noise(i, 4) * 0.1);
        format!("{x:.3} {y:.3} {z:.3}  {rate:.3} 0.01 0.02  20.1 -3.2 44.0\n")
    };
    let outcome = record("", "", line);
    outcome.has("t_host_ms ax ay az gx gy gz c7 c8 c9", "m/s^2", true);
    // In another order, as the option says.
    let outcome = record("", "--columns gx,gy,gz,ax,ay,az", |i| {
        let ([x, y, z], rate) = (at_rest(i), noise(i, 4));
        format!("0.1,0.2,{rate:.3},{x:.3},{y:.3},{z:.3},20.1,-3.2,44\n")
    });
    outcome.has("t_host_ms,gx,gy,gz,ax,ay,az,c7,c8,c9", "m/s^2", true);
}

#[test]
fn rows_that_never_fit_their_header_are_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log -o x.csv --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    log.wait_for("opened");
    board.say("\nax,ay,az\n");
    log.wait_for("started");
    board.say(&"1,2,3,4\n".repeat(60));
    let (code, error) = log.ended();
    assert_eq!((code, error["code"].as_str()), (5, Some("rows-differ")));
}

#[test]
fn an_existing_file_is_replaced_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.csv");
    fs::write(&path, "an old recording\n").unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log -o x.csv --rows 5 --json --port {}", board.port());
    let (code, error) = Logger::start(folder.path(), &line).ended();
    assert_eq!((code, error["code"].as_str()), (2, Some("exists")));
    assert!(
        error["hint"].as_str().unwrap().contains("--force"),
        "{error}"
    );
    let both = Logger::start(folder.path(), &format!("{line} --append --force")).ended();
    assert_eq!(both.0, 2);
    assert_eq!(fs::read_to_string(&path).unwrap(), "an old recording\n");
    let mut log = Logger::start(folder.path(), &format!("{line} --force"));
    board.greet();
    board.rows(5);
    assert_eq!(log.ended().0, 0);
    assert!(!fs::read_to_string(&path).unwrap().contains("old"));
    assert_eq!(recording(&path).rows(), 5);
}

#[test]
fn poses_are_in_the_events_and_the_summary() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log -o x.csv --rows 360 --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    for _ in 0..360 {
        board.rows(1);
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let (code, ended) = log.ended();
    assert_eq!(code, 0);
    assert_eq!(ended["poses"][0]["face"], "+z", "{ended}");
    let duration_s = ended["poses"][0]["duration_s"].as_f64().unwrap();
    assert!((2.0..6.0).contains(&duration_s), "{ended}");
    assert_eq!(ended["free_poses"], 0);
    let status = log.seen_last("status");
    assert_eq!(
        (&status["up"], &status["still"]),
        (&"+z".into(), &true.into())
    );
}
