//! The file cannot be written, the terminal is closed, a reader stops reading: what was received is
//! somewhere, and that is said.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use rustix::process::Signal;

use crate::board::Board;
use crate::logger::{Logger, Terminal, program, run, signal, until};
use crate::recording;

fn rows_of(path: &Path) -> usize {
    let text = fs::read_to_string(path).unwrap_or_default();
    let digits = |line: &&str| line.starts_with(|c: char| c.is_ascii_digit());
    text.lines().filter(digits).count()
}

/// The error names a file with all rows that were sent.
fn is_rescued(folder: &Path, board: &Board, log: &mut Logger, why: &str) {
    let error = log.refused(1, "io");
    let message = error["message"].as_str().unwrap();
    let named = message.contains(why) && message.contains("rescued.csv");
    assert!(named, "{message}");
    let rescued = folder.join("x.rescued.csv");
    assert_eq!(recording(&rescued).rows() as u64, board.sent);
    if !folder.join("x.csv").is_file() {
        // The recording may be beside it: a folder that is calibrated leaves it out, and says so.
        let (code, error) = run(folder, "calibrate . --json");
        let message = error["message"].as_str().unwrap();
        let says = "x.rescued.csv: what `gravical log` rescued";
        assert!(code == 3 && message.contains(says), "{message}");
    }
    fs::remove_file(rescued).unwrap();
}

#[test]
fn a_file_that_is_deleted_replaced_or_cut_and_a_full_disk_are_rescued() {
    for why in ["deleted", "replaced", "cut", "No space left"] {
        let folder = tempfile::tempdir().unwrap();
        let mut board = Board::new(folder.path());
        let path = folder.path().join("x.csv");
        let is_full = why == "No space left";
        if is_full {
            std::os::unix::fs::symlink("/dev/full", &path).unwrap();
        }
        let mut log = board.log("-o x.csv --json");
        board.greet();
        board.rows(140);
        if !is_full {
            log.wait_for_rows(140);
        }
        match why {
            _ if is_full => {}
            "deleted" => fs::remove_file(path).unwrap(),
            "cut" => fs::write(path, "").unwrap(),
            _ => {
                fs::write(folder.path().join("y.csv"), "other").unwrap();
                fs::rename(folder.path().join("y.csv"), path).unwrap();
            }
        }
        // It is said without another row.
        is_rescued(folder.path(), &board, &mut log, why);
    }
}

#[test]
fn closing_the_terminal_ends_the_recording_cleanly() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut terminal = Terminal::new();
    // With a controlling terminal, whose end sends SIGHUP.
    let mut command = Command::new("setsid");
    let line = format!("log x --json --port {}", board.port());
    let program = ["--ctty", env!("CARGO_BIN_EXE_gravical")];
    command.args(program.into_iter().chain(line.split(' ')));
    command.current_dir(folder.path());
    let mut log = Logger::start_in(command, &terminal);
    board.greet();
    board.rows(140);
    log.wait_for_rows(140);
    terminal.wait_for(" 140 rows");
    board.one_more();
    drop(terminal);
    assert_eq!(log.ended().0, 0);
    assert_eq!(rows_of(&folder.path().join("x_axis.csv")), 141);
}

#[test]
fn a_reader_who_stops_reading_stops_nothing() {
    let folder = tempfile::tempdir().unwrap();
    // More than a pipe of 64 KiB holds, so that a writer blocks.
    let chatter = format!("# {}\n", "x".repeat(300)).repeat(300);
    for (name, json) in [("x", " --json"), ("y", "")] {
        let mut board = Board::new(folder.path());
        let line = format!("log {name}{json} --port {}", board.port());
        let mut silent = program(folder.path(), &line);
        silent.stdin(Stdio::null()).stdout(Stdio::piped());
        let mut silent = silent.stderr(Stdio::piped()).spawn().unwrap();
        let path = folder.path().join(format!("{name}_axis.csv"));
        board.greet();
        board.rows(150);
        until(|| rows_of(&path) == 150);
        board.say(&chatter);
        board.rows(100);
        until(|| rows_of(&path) == 250);
        signal(&silent, Signal::INT);
        until(|| silent.try_wait().unwrap().is_some());
        assert_eq!(silent.wait().unwrap().code(), Some(0));
        let text = fs::read_to_string(path).unwrap();
        assert_eq!(text.lines().filter(|l| l.starts_with("# xxx")).count(), 300);
    }
}

#[test]
fn the_recording_ends_while_bytes_arrive() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("x --json");
    board.greet();
    let (over, ended) = std::sync::mpsc::channel::<()>();
    let sending = std::thread::spawn(move || {
        while ended.try_recv().is_err() {
            board.try_row();
        }
    });
    log.wait_for_rows(500);
    log.signal(Signal::INT);
    let code = log.gone();
    over.send(()).unwrap();
    sending.join().unwrap();
    assert_eq!(code, Some(0));
    let (_, ended) = log.ended();
    let rows = rows_of(&folder.path().join("x_axis.csv"));
    assert_eq!(ended["rows"], rows);
}

#[test]
fn one_program_writes_to_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("x --append --json");
    log.wait_for("opened");
    // Refused before a port is opened, which would reset the other board.
    let other = "log x --append --json --port /dev/null";
    let error = Logger::start(folder.path(), other).refused(2, "in-use");
    assert!(error["hint"].is_string());
    board.greet();
    board.rows(130);
    log.wait_for_rows(130);
    board.one_more();
    log.signal(Signal::INT);
    assert_eq!(log.ended().0, 0);
    assert_eq!(rows_of(&folder.path().join("x_axis.csv")), 131);
}

/// What is no recording is not continued, and stays as it is.
#[test]
fn another_file_is_not_continued() {
    let folder = tempfile::tempdir().unwrap();
    let board = Board::new(folder.path());
    let path = folder.path().join("x_axis.csv");
    let text = "words\nmore words\nhalf a li";
    fs::write(&path, text).unwrap();
    board.log("x --append --json").refused(3, "no-rows");
    assert_eq!(fs::read_to_string(path).unwrap(), text);
}
