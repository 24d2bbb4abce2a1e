//! `gravical log` against a pseudo-terminal that behaves like a board: every row that
//! is sent is in the file, among the rejected lines, or in a gap that the file names.
//!
//! No test depends on speed; every wait has a limit.
#![cfg(target_os = "linux")]
// The exemption of tests in clippy.toml does not reach helpers outside #[test].
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod any_board;
mod board;
mod content;
mod faults;
mod live;
mod logger;

use std::fs;

use gravical::recording::{ReadOptions, Reason, Recording, read};
use rustix::process::Signal;
use serde_json::json;

use board::{Board, HEADER, SETTINGS};
use logger::{Logger, Terminal, program, run};

/// The recording as the other commands read it.
fn recording(path: &std::path::Path) -> Recording {
    let recording = read(path, &ReadOptions::default()).unwrap();
    assert_eq!(recording.ledger.rows(), recording.rows());
    recording
}

fn kinds(recording: &Recording) -> Vec<&str> {
    recording.findings.iter().map(|f| &*f.kind).collect()
}

#[test]
fn every_row_sent_is_stored_or_rejected_or_in_a_named_gap() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("x --json");
    board.greet();
    board.rows(60);
    let torn = ["9.81,25", "1,2,3,4,5,6,7,8,9", "\u{1b}~~x", "I2C error 3"];
    for hurt in torn {
        board.hurt(format!("{hurt}\n").as_bytes());
    }
    // A comment of the board is not a row.
    board.say("# overruns 1, i2c errors 0, restarts 0\n");
    board.rows(80);
    // The first, the second and the fourth are reported.
    for (count, line) in [(1, torn[0]), (2, torn[1]), (4, torn[3])] {
        log.wait_for_one("rejected", json!({"count": count, "line": line}));
    }
    log.wait_for_rows(140);
    // The cable is pulled; thirty rows are lost; the clock of the board continues.
    board.unplug();
    log.wait_for("lost");
    board.lose(30);
    board.plug_in();
    log.wait_for("opened");
    // The first line lacks its beginning.
    board.rest_of_a_row();
    board.rows(40);
    log.wait_for("gap");
    // Twenty rows are lost on the line; then the board is reset, and has lost none.
    board.lose(20);
    board.rows(40);
    log.wait_for("gap");
    board.reset();
    board.rows(40);
    log.wait_for("gap");
    log.wait_for_rows(260);
    board.one_more();
    log.signal(Signal::INT);
    let (code, ended) = log.ended();
    assert_eq!(code, 130, "rows are missing");
    let count = |key: &str| ended[key].as_u64().unwrap();
    assert_eq!((count("rejected"), count("missing")), (5, 50));
    assert_eq!(count("rows") + 5 + 50, board.sent);
    let path = folder.path().join("x_axis.csv");
    let recording = recording(&path);
    assert_eq!(recording.rows() as u64, count("rows"));
    assert_eq!(recording.ledger.count(Reason::NamedGap), 3);
    assert_eq!(recording.breaks.len(), 3);
    let expected = "named-gap restarted-time gap missing-samples repeated-header";
    let expected: Vec<&str> = expected.split(' ').collect();
    let found = kinds(&recording);
    assert!(found.iter().all(|k| expected.contains(k)), "{found:?}");
    assert!(found.contains(&"restarted-time"));
    let text = fs::read_to_string(&path).unwrap();
    let marks = |mark: &str| -> Vec<String> {
        let lines = text.lines().filter_map(|line| line.strip_prefix(mark));
        lines.map(str::to_owned).collect()
    };
    let rejected = torn.map(|t| t.replace('\u{1b}', "\\u{1b}"));
    assert_eq!(marks("# rejected: ")[..4], rejected);
    let gaps = marks("# gap: ");
    assert_eq!(gaps[0], "unplugged: 30 rows are missing, 0.3 s");
    let lost = "rows were lost on the way from the board: 20 rows are missing, 0.2 s";
    assert_eq!(gaps[1], lost);
    let reset = gaps[2].starts_with("the board was reset: an unknown number");
    let restarts = gaps[2].ends_with(", the clock of the board restarts");
    assert!(reset && restarts, "{gaps:?}");
}

#[test]
fn a_clean_recording_has_no_finding_but_the_overflow_of_its_clock() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("y --rows 300");
    board.greet();
    // Across the wrap of a 32-bit clock.
    board.stamp = (1 << 32) - 1000;
    board.rows(400);
    let (code, err) = log.ended_text();
    assert_eq!(code, 0, "{err}");
    assert!(err.contains("y_axis.csv: 300 rows in"), "{err}");
    let recording = recording(&folder.path().join("y_axis.csv"));
    assert_eq!(recording.rows(), 300);
    assert!(kinds(&recording).is_empty(), "{:?}", kinds(&recording));
    assert_eq!(recording.clock.nominal_rate_hz, Some(100.0));
}

#[test]
fn rows_survive_kill_9_and_the_file_is_continued() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let path = folder.path().join("z_axis.csv");
    let mut log = board.log("z --json");
    board.greet();
    board.rows(150);
    logger::until(|| fs::read_to_string(&path).is_ok_and(|text| text.lines().count() >= 153));
    log.signal(Signal::KILL);
    log.gone();
    let whole = fs::read_to_string(&path).unwrap();
    assert!(whole.ends_with('\n'));
    assert_eq!(recording(&path).rows(), 150);
    // As if the power had failed in the middle of a line.
    fs::write(&path, &whole[..whole.len() - 9]).unwrap();
    let refused = board.log("z --json").refused(2, "exists");
    assert!(refused["hint"].as_str().unwrap().contains("--force"));
    let mut log = board.log("z --append --rows 50 --json");
    board.stamp = 40;
    board.greet();
    board.rows(50);
    let (code, ended) = log.ended();
    assert_eq!(code, 0, "{ended}");
    let continued = recording(&path);
    assert_eq!(continued.rows(), 149 + 50);
    let kinds = kinds(&continued);
    for kind in ["named-gap", "restarted-time"] {
        assert!(kinds.contains(&kind), "{kind}: {kinds:?}");
    }
    let (kept, torn) = whole[..whole.len() - 9].rsplit_once('\n').unwrap();
    let text = fs::read_to_string(&path).unwrap();
    let joined = format!("{kept}\n# rejected: {torn}\n# gravical");
    assert!(text.starts_with(&joined), "{text}");

    // Other columns, if rows fit them, or counts of another range, do not fit the file.
    let columns = "t_ms,ax,ay,az\n1,0.1,0.2,9.8\n2,0.1,0.2,9.8\n3,0.1,0.2,9.8\n";
    for other in [columns, &SETTINGS.replace("+-2 g", "+-4 g")] {
        // Without rows of the session before.
        board.plug_in();
        let mut log = board.log("z --append --rows 50 --json");
        log.wait_for("opened");
        board.say(other);
        board.rows(10);
        log.refused(5, "columns-changed");
        assert_eq!(recording(&path).rows(), 149 + 50);
    }
    board.plug_in();
    // Without a row the file stays as it is.
    let mut log = board.log("z --force --rows 50 --json");
    log.wait_for("opened");
    log.signal(Signal::INT);
    assert_eq!(log.ended().0, 130);
    assert_eq!(recording(&path).rows(), 149 + 50);
    board.plug_in();
    let mut log = board.log("z --force --rows 50 --json");
    board.greet();
    board.rows(60);
    assert_eq!(log.ended().0, 0);
    assert_eq!(recording(&path).rows(), 50);
}

#[test]
fn space_pauses_and_the_terminal_is_restored() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut terminal = Terminal::new();
    let line = format!("log x --port {}", board.port());
    let mut log = Logger::start_in(program(folder.path(), &line), &terminal);
    assert!(terminal.is_cooked());
    board.greet();
    board.rows(150);
    terminal.wait_for("recording; space pauses");
    assert!(!terminal.is_cooked());
    terminal.wait_for(" 150 rows");
    terminal.press(" ");
    terminal.wait_for("paused");
    board.rows(50);
    terminal.wait_for("PAUSED");
    terminal.press(" ");
    terminal.wait_for("recording\r\n");
    board.rows(50);
    terminal.wait_for(" 200 rows");
    assert!(terminal.text().contains("‖a‖ 9.8"), "{}", terminal.text());
    board.one_more();
    terminal.press("q");
    let code = log.gone();
    assert_eq!(code, Some(0), "{}", terminal.text());
    assert!(terminal.is_cooked());
    let text = fs::read_to_string(folder.path().join("x_axis.csv")).unwrap();
    assert_eq!(text.matches("\n\n\n\n").count(), 1);
    let recording = recording(&folder.path().join("x_axis.csv"));
    assert_eq!(recording.rows(), 201);
    assert_eq!(recording.breaks, [150]);
}

#[test]
fn settings_are_confirmed_before_rows_are_stored_and_other_units_end_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("-o four.csv --range 4 --low-pass 21 --json");
    board.greet();
    board.rows(10);
    board.wait_for_command("a4\nd21\n");
    let set = SETTINGS.replace("+-2 g", "+-4 g").replace("44 Hz", "21 Hz");
    board.say(&format!("{set}{HEADER}"));
    board.rows(150);
    log.wait_for_rows(150);
    // After a reset the board has its own range again.
    board.reset();
    board.rows(10);
    log.refused(5, "columns-changed");
    assert_eq!(recording(&folder.path().join("four.csv")).rows(), 150);
    let text = fs::read_to_string(folder.path().join("four.csv")).unwrap();
    assert!(text.contains(&set) && !text.contains(SETTINGS), "{text}");
}

#[test]
fn a_port_that_appears_later_and_one_that_is_busy() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("ttyACM0").display().to_string();
    let line = format!("log x --json --port {port}");
    Logger::start(folder.path(), &line).refused(5, "no-such-port");
    assert!(!folder.path().join("x_axis.csv").exists());
    let line = format!("log x --wait --rows 30 --json --port {port}");
    let mut log = Logger::start(folder.path(), &line);
    log.wait_for("waiting");
    // An error is reported once, however often it is tried.
    std::os::unix::fs::symlink("/dev/null", &port).unwrap();
    let waiting = log.wait_for("waiting");
    let text = waiting["text"].as_str().unwrap();
    assert!(text.contains("is it a serial port?"), "{text}");
    std::thread::sleep(std::time::Duration::from_millis(2500));
    let mut board = Board::new(folder.path());
    log.wait_for("opened");
    board.log("y --json").refused(5, "port-busy");
    board.greet();
    board.rows(30);
    assert_eq!(log.ended().0, 0);
    assert_eq!(log.count(&waiting), 1);
}

#[test]
fn usage_errors() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    let mode = rustix::fs::Mode::RWXU;
    rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, mode).unwrap();
    let fast = "log x --rate 250 --format counts --port /dev/null --json";
    for (line, code, name) in [
        ("log x --range 3 --json", 2, "usage"),
        ("log x --rate 151 --json", 2, "option-range"),
        ("log x --rate 3 --format counts --json", 2, "option-range"),
        (fast, 5, "port-failed"),
        ("log x --rows 0 --json", 2, "usage"),
        ("log x --duration nan --json", 2, "option-range"),
        ("log x --baud 1 --json", 2, "usage"),
        ("log w --json", 2, "usage"),
        ("log x --append --force --json", 2, "usage"),
        ("log x --columns ax,by --json", 2, "columns-syntax"),
        ("log x --columns ax,ax --json", 2, "columns-syntax"),
        ("log -o - --port /dev/null --json", 2, "stdout-target"),
        ("log -o no/x.csv --port /dev/null --json", 2, "no-folder"),
        ("log -o . --json", 2, "is-folder"),
        ("log -o . --append --json", 2, "is-folder"),
        ("log -o pipe --append --json", 2, "is-pipe"),
    ] {
        Logger::start(folder.path(), line).refused(code, name);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let (code, ports) = run(folder.path(), "ports --json");
    assert!(code == 0 && ports["ports"].is_array());
}
