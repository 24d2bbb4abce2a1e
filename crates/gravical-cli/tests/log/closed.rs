//! The user closes the terminal, or a reader stops reading: the recording is complete.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use rustix::process::{Pid, Signal, kill_process};

use crate::board::Board;
use crate::logger::{Logger, Terminal, until, words};

fn rows_of(path: &Path) -> usize {
    let text = fs::read_to_string(path).unwrap_or_default();
    let digits = |line: &&str| line.starts_with(|c: char| c.is_ascii_digit());
    text.lines().filter(digits).count()
}

/// After a long silence rows would be missing: one more row at the very end.
fn one_more(board: &mut Board) {
    board.rows(1);
    std::thread::sleep(std::time::Duration::from_millis(100));
}

#[test]
fn closing_the_terminal_ends_the_recording_cleanly() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut terminal = Terminal::new();
    // With a controlling terminal, whose end sends SIGHUP.
    let mut command = Command::new("setsid");
    command
        .arg("--ctty")
        .arg(env!("CARGO_BIN_EXE_gravical"))
        .args(words(&format!("log x --json --port {}", board.port())))
        .current_dir(folder.path());
    let mut log = Logger::start_command_in(command, &terminal);
    board.greet();
    log.wait_for("started");
    board.rows(60);
    log.wait_for_rows(60);
    terminal.wait_for(" 60 rows");
    one_more(&mut board);
    drop(terminal);
    assert_eq!(log.ended().0, 0);
    assert_eq!(log.seen("ended")["stored"].as_u64(), Some(61));
    assert_eq!(rows_of(&folder.path().join("x_axis.csv")), 61);
}

#[test]
fn without_the_signal_the_recording_continues_without_keys() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let terminal = Terminal::new();
    let line = format!("log x --json --port {}", board.port());
    let mut log = Logger::start_in(folder.path(), &line, &terminal);
    board.greet();
    log.wait_for("started");
    board.rows(40);
    log.wait_for_rows(40);
    drop(terminal);
    board.rows(100);
    log.wait_for_rows(140);
    one_more(&mut board);
    log.signal(Signal::INT);
    assert_eq!(log.ended().0, 0);
    assert_eq!(rows_of(&folder.path().join("x_axis.csv")), 141);
}

/// More than a pipe of 64 KiB holds, so that a writer blocks.
fn chatter(board: &mut Board) {
    for _ in 0..300 {
        board.say(&format!("# {}\n", "x".repeat(300)));
    }
}

#[test]
fn a_reader_who_stops_reading_stops_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for (name, json) in [("x", " --json"), ("y", "")] {
        let mut board = Board::new(folder.path());
        let line = format!("log {name}{json} --port {}", board.port());
        let mut silent = Command::new(env!("CARGO_BIN_EXE_gravical"))
            .args(words(&line))
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let path = folder.path().join(format!("{name}_axis.csv"));
        board.greet();
        board.rows(50);
        until(|| rows_of(&path) == 50);
        chatter(&mut board);
        board.rows(100);
        chatter(&mut board);
        board.rows(100);
        until(|| rows_of(&path) == 250);
        let pid = Pid::from_raw(i32::try_from(silent.id()).unwrap()).unwrap();
        kill_process(pid, Signal::INT).unwrap();
        let mut status = None;
        until(|| {
            status = silent.try_wait().unwrap();
            status.is_some()
        });
        assert_eq!(status.unwrap().code(), Some(0));
        let text = fs::read_to_string(path).unwrap();
        assert_eq!(text.lines().filter(|l| l.starts_with("# xxx")).count(), 600);
    }
}

#[test]
fn the_recording_ends_while_bytes_arrive() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log x --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    log.wait_for("started");
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
    assert_eq!(log.ended().0, 0);
    let stored = usize::try_from(log.seen("ended")["stored"].as_u64().unwrap()).unwrap();
    assert_eq!(rows_of(&folder.path().join("x_axis.csv")), stored);
}

#[test]
fn one_program_writes_to_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log x --append --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    log.wait_for("started");
    board.rows(30);
    log.wait_for_rows(30);
    // Refused before a port is opened, which would reset the other board.
    let other = "log x --append --json --port /dev/null";
    let (code, error) = Logger::start(folder.path(), other).ended();
    assert_eq!((code, error["code"].as_str()), (2, Some("in-use")));
    assert!(error["hint"].is_string());
    board.rows(30);
    log.wait_for_rows(60);
    one_more(&mut board);
    log.signal(Signal::INT);
    assert_eq!(log.ended().0, 0);
    assert_eq!(rows_of(&folder.path().join("x_axis.csv")), 61);
}

#[test]
fn rejected_lines_that_cannot_be_written_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    fs::create_dir(folder.path().join("x_axis.csv.rejected.txt")).unwrap();
    let line = format!("log x --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    log.wait_for("started");
    board.rows(20);
    board.hurt(b"no row\n");
    let failed = log.wait_for("disk-failed");
    let text = failed["text"].as_str().unwrap();
    assert!(text.starts_with("x_axis.csv.rejected.txt: "), "{text}");
    board.rows(20);
    log.wait_for_rows(40);
    log.signal(Signal::INT);
    let (code, error) = log.ended();
    assert_eq!((code, error["code"].as_str()), (1, Some("io")));
    let message = error["message"].as_str().unwrap();
    assert_eq!(message.matches("rejected.txt").count(), 1, "{message}");
    assert!(
        message.ends_with("; 1 rejected lines are lost"),
        "{message}"
    );
    assert_eq!(log.seen("ended")["rejected_unstored"].as_u64(), Some(1));
    assert_eq!(rows_of(&folder.path().join("x_axis.csv")), 40);
}

#[test]
fn a_pipe_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let made = Command::new("mkfifo")
        .arg(folder.path().join("pipe"))
        .status();
    assert!(made.unwrap().success());
    for append in ["", " --append"] {
        let line = format!("log -o pipe{append} --json --port /dev/null");
        let (code, error) = Logger::start(folder.path(), &line).ended();
        assert_eq!((code, error["code"].as_str()), (2, Some("is-pipe")));
    }
}

#[test]
fn the_error_of_a_port_is_reported_once() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("ttyACM0");
    let line = format!("log x --wait --rows 20 --json --port {}", port.display());
    let mut log = Logger::start(folder.path(), &line);
    log.wait_for("waiting");
    std::os::unix::fs::symlink("/dev/null", &port).unwrap();
    let warning = log.wait_for("warning");
    let text = warning["text"].as_str().unwrap();
    assert!(text.contains("it is retried"), "{text}");
    // Some more attempts.
    std::thread::sleep(std::time::Duration::from_millis(1000));
    let mut board = Board::new(folder.path());
    log.wait_for("opened");
    board.greet();
    board.rows(20);
    assert_eq!(log.ended().0, 0);
    assert_eq!(log.count(&warning), 1);
}
