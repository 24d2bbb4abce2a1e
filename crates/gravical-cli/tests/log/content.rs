//! What `gravical log` says of the rows is what `gravical inspect` says of the file.

use std::fs;

use rustix::process::Signal;
use serde_json::Value;

use crate::board::{Board, HEADER, SETTINGS};
use crate::logger::{Logger, words};

fn inspected(folder: &std::path::Path, file: &str) -> Value {
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_gravical"))
        .args(words(&format!("inspect {file} --json")))
        .current_dir(folder)
        .output()
        .unwrap();
    let mut all: Value = serde_json::from_slice(&run.stdout).unwrap();
    all["recordings"][0].take()
}

/// Unit, rate and findings of the event `ended` are those of `inspect`.
fn agrees(ended: &Value, inspected: &Value) {
    for key in ["accelerometer", "gyroscope", "timing", "findings"] {
        assert_eq!(ended[key], inspected[key], "{key}");
    }
}

fn kinds(ended: &Value) -> Vec<&str> {
    let findings = ended["findings"].as_array().unwrap();
    findings
        .iter()
        .map(|f| f["kind"].as_str().unwrap())
        .collect()
}

/// A sensor with a dead axis, at the end of its range.
fn faulty(board: &mut Board, rows: u64) {
    for i in 0..rows {
        let noise = (i * 7919 % 61) as f64 * 1e-3;
        let x = if i % 50 < 10 { 19.61 } else { 0.1 + noise };
        let stamp = board.stamp;
        board.stamp += 10;
        board.sent += 1;
        board.say(&format!(
            "{stamp},{x:.2},0.25,{:.3},25.5,{noise:.2},0.2,-{noise:.3}\n",
            9.8 - noise
        ));
    }
}

#[test]
fn findings_are_those_of_inspect_and_the_bad_ones_are_said_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log -o x.csv --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    log.wait_for("started");
    faulty(&mut board, 300);
    let live = log.wait_for("finding");
    board.lose(40);
    faulty(&mut board, 300);
    log.wait_for("gap");
    log.wait_for_rows(600);
    log.signal(Signal::INT);
    let (_, ended) = log.ended();
    agrees(&ended, &inspected(folder.path(), "x.csv"));
    let found = kinds(&ended);
    for kind in ["frozen-axis", "named-gap"] {
        assert!(found.contains(&kind), "{kind}: {found:?}");
    }
    assert!(found.contains(&live["kind"].as_str().unwrap()), "{live}");
    // Each is said once, although the rows that it concerns become more.
    assert_eq!(log.count(&live), 1);

    // A part that is added is in the findings of the whole file, and the summary is for people.
    let line = format!("log -o x.csv --append --rows 200 --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    faulty(&mut board, 200);
    let (code, text) = log.ended_text();
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("accelerometer in m/s², 100.00 Hz"), "{text}");
    assert!(
        text.contains("! frozen-axis: ay keeps exactly one value"),
        "{text}"
    );
}

#[test]
fn counts_and_their_range() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log -o x.csv --json --rows 400 --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    let settings = SETTINGS.replace("format 0", "format 1");
    board.say(&format!(
        "{settings}Timestamp (ms),ax,ay,az,temp,gx,gy,gz\n"
    ));
    for i in 0..400_u64 {
        let noise = i * 7919 % 61;
        board.say(&format!(
            "{},{noise},{},{},-3740,{noise},7,{}\n",
            10 * i,
            70 - noise,
            16384 - noise,
            noise * 2
        ));
    }
    let (code, ended) = log.ended();
    assert_eq!(
        (code, &ended["accelerometer"]["lsb_per_g"]),
        (0, &16384.0.into())
    );
    agrees(&ended, &inspected(folder.path(), "x.csv"));
}

/// A file that is no recording of an accelerometer is recorded all the same, and that is said.
#[test]
fn a_file_that_inspect_cannot_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log -o x.csv --json --rows 900 --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    log.wait_for("opened");
    board.say("\n");
    let header = HEADER.replace(",a", ",u").replace("m/s^2", "V");
    board.say(&header);
    let begun = std::time::Instant::now();
    for i in 0.. {
        board.say(&format!("{},1.{i},2,3.5,4,5,6,7\n", 10 * i));
        if i % 20 == 0 {
            log.look();
        }
        if log.has_seen("ended") || begun.elapsed().as_secs() > 20 {
            break;
        }
    }
    let (code, ended) = log.ended();
    assert_eq!((code, &ended["stored"]), (0, &900.into()), "{ended}");
    assert!(ended.get("findings").is_none(), "{ended}");
    let warning = log.seen_last("warning")["text"].as_str().unwrap();
    assert!(
        warning.starts_with("gravical inspect cannot read"),
        "{warning}"
    );
}

/// Reading a long file for the summary does not hold the user up.
#[test]
fn a_second_interrupt_skips_the_findings() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let path = folder.path().join("x.csv");
    let mut text = format!("{SETTINGS}{HEADER}");
    for i in 0..4_000_000_u64 {
        text += &format!(
            "{},0.{:02},-0.02,9.81,25.50,0.1,0.2,0.3\n",
            10 * i,
            i * 7919 % 61
        );
    }
    fs::write(&path, text).unwrap();
    let line = format!("log -o x.csv --append --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    log.wait_for("started");
    board.rows(50);
    log.wait_for_rows(50);
    log.signal(Signal::INT);
    for _ in 0..4 {
        log.signal(Signal::INT);
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let (_, ended) = log.ended();
    assert_eq!(ended["stored"], 50, "{ended}");
    assert!(
        ended.get("findings").is_none(),
        "200 MB were read within 0.2 s"
    );
}
