//! The binary format over a terminal that must have its baud rate.

use std::fs;

use gravical::recording::{AccelUnit, Aside, GyroUnit, TimeUnit};
use rustix::process::Signal;

use crate::board::Board;
use crate::fast::FastBoard;
use crate::logger::Logger;
use crate::{kinds, recording};

const COLUMNS: &str = "Timestamp (us),ax,ay,az,temp,gx,gy,gz";

fn started(folder: &std::path::Path, more: &str) -> (FastBoard, Logger) {
    let mut board = FastBoard::new(Board::new(folder));
    let line = format!(
        "log -o fast.csv --format binary --rate 500 --json {more} --port {}",
        board.board.port()
    );
    let mut log = Logger::start(folder, &line);
    log.wait_for("opened");
    board.greet();
    board.obey();
    assert_eq!(log.wait_for("started")["columns"], COLUMNS);
    (board, log)
}

#[test]
fn every_frame_sent_is_stored_or_rejected_or_missing() {
    let folder = tempfile::tempdir().unwrap();
    let (mut board, mut log) = started(folder.path(), "");
    board.rows(40);
    for round in 0..200_usize {
        board.rows(9);
        board.hurt(round, round as u32 / 24);
        if round % 4 == 0 {
            board.rows(6);
            board.lose(round as u32 % 3);
        }
    }
    board.say("# overruns 1, i2c errors 0, restarts 0");
    board.rows(300);
    board.lose(600);
    board.rows(100);
    let gap = log.wait_for("gap");
    assert_eq!((&gap["cause"], &gap["rows"]), (&"lost".into(), &600.into()));
    log.wait_for_rows(2000);
    // A last message shows when all have been read.
    board.rows(20);
    board.say("# overruns 2, i2c errors 0, restarts 0");
    loop {
        let message = log.wait_for("board");
        if message["text"]
            .as_str()
            .unwrap()
            .starts_with("# overruns 2")
        {
            break;
        }
    }
    log.signal(Signal::INT);
    let (code, ended) = log.ended();
    assert_eq!(code, 130, "rows are missing");
    let count = |key: &str| ended[key].as_u64().unwrap();
    assert_eq!(
        count("stored") + count("rejected") - count("fragments") + count("missing") + count("lost"),
        board.sent
    );
    // Rows of text arrived before the first frame.
    assert_eq!(count("received"), count("stored") + count("before_start"));
    assert_eq!(count("missing"), 600);
    assert!(count("rejected") >= 180 && count("lost") > 10, "{ended}");
    let path = folder.path().join("fast.csv");
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("format 2\n") && text.contains(COLUMNS));
    assert!(text.contains("# gap: rows were lost on the way from the board: 600 rows"));
    let rejected = fs::read_to_string(folder.path().join("fast.csv.rejected.txt")).unwrap();
    assert_eq!(rejected.lines().count() as u64, count("rejected"));
    let hex = |line: &str| line.bytes().take_while(u8::is_ascii_hexdigit).count() >= 2;
    assert!(
        rejected
            .lines()
            .all(|line| hex(line) && line.contains("  # "))
    );
    // The other commands count single missing rows.
    let recording = recording(&path);
    assert_eq!(recording.rows() as u64, count("stored"));
    assert_eq!(recording.ledger.lines_aside(Aside::NamedGap).count(), 1);
    assert_eq!(recording.breaks.len(), 1);
    let missing = recording
        .findings
        .iter()
        .find(|f| f.kind == "missing-samples")
        .unwrap();
    assert_eq!(missing.count, board.sent - count("stored"));
}

#[test]
fn a_fast_recording_is_read_with_its_units() {
    let folder = tempfile::tempdir().unwrap();
    let (mut board, mut log) = started(folder.path(), "--rows 1000");
    board.stamp_us = (1 << 32) - 1_000_000;
    board.rows(1000);
    let (code, ended) = log.ended();
    assert_eq!((code, ended["reason"].as_str()), (0, Some("rows")));
    let recording = recording(&folder.path().join("fast.csv"));
    // The stamp continues in the file.
    assert_eq!(kinds(&recording), [""; 0]);
    assert_eq!(recording.rows(), 1000);
    assert_eq!(recording.timing.unit, Some(TimeUnit::Microsecond));
    assert!((recording.timing.rate_hz().unwrap() - 500.0).abs() < 1e-3);
    assert_eq!(recording.accel_scale.unit, AccelUnit::Counts);
    assert_eq!(recording.accel_scale.lsb_per_g, Some(16384.0));
    let gyro = recording.gyro_scale.unwrap();
    assert_eq!(
        (gyro.unit, gyro.lsb_per_deg_s),
        (GyroUnit::Counts, Some(65.5))
    );
    let celsius = recording.temperature_c.unwrap();
    assert!(celsius.iter().all(|t| (24.9..25.1).contains(t)));
}

#[test]
fn a_reset_in_the_middle_is_back_in_text_and_is_set_again() {
    let folder = tempfile::tempdir().unwrap();
    let (mut board, mut log) = started(folder.path(), "");
    // The board had run for an hour.
    board.stamp_us += 3_600_000_000;
    board.rows(200);
    board.reset();
    board.obey();
    board.rows(200);
    let gap = log.wait_for("gap");
    assert_eq!(gap["cause"], "reset");
    assert_eq!(gap["clock_anew"], true);
    log.wait_for_rows(400);
    log.signal(Signal::INT);
    let (_, ended) = log.ended();
    assert_eq!(ended["stored"], 400);
    let recording = recording(&folder.path().join("fast.csv"));
    assert_eq!(recording.breaks, [200]);
    assert!(kinds(&recording).contains(&"restarted-time"));
}

#[test]
fn a_board_that_was_left_in_binary_is_found_and_continued() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = FastBoard::left_in_binary(Board::new(folder.path()));
    let line = format!("log -o fast.csv --rows 50 --port {}", board.board.port());
    let mut log = Logger::start(folder.path(), &format!("{line} --json"));
    log.wait_for("opened");
    send_until_asked(&mut board);
    assert_eq!(log.wait_for("started")["columns"], COLUMNS);
    board.rows(60);
    let (code, ended) = log.ended();
    assert_eq!((code, &ended["stored"]), (0, &50.into()));
    // Bytes received at the wrong rate are not stored.
    assert_eq!(ended["rejected"], 0, "{ended}");
    // A file of counts is not continued with another range.
    let other = format!("{line} --append --range 4 --json");
    let (code, error) = Logger::start(folder.path(), &other).ended();
    assert_eq!((code, error["code"].as_str()), (2, Some("settings-differ")));
    // With its own settings it is continued.
    let mut log = Logger::start(folder.path(), &format!("{line} --append --json"));
    log.wait_for("opened");
    send_until_asked(&mut board);
    log.wait_for("started");
    board.rows(60);
    assert_eq!(log.ended().0, 0);
    let recording = recording(&folder.path().join("fast.csv"));
    assert_eq!(recording.rows(), 100);
    assert_eq!(recording.breaks, [50]);
}

fn send_until_asked(board: &mut FastBoard) {
    crate::logger::until(|| {
        board.rows(5);
        board.board.has_received("?\n") && board.board.baud() == 250_000
    });
    board.greet();
}
