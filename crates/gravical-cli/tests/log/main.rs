//! `gravical log` against a pseudo-terminal that behaves like a board: every row that
//! is sent is in the file, among the rejected lines, or in a gap that the file names.
//!
//! No test depends on speed; every wait has a limit.
#![cfg(target_os = "linux")]
// The exemption of tests in clippy.toml does not reach helpers outside #[test].
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod any_board;
mod board;
mod closed;
mod content;
mod disk;
mod file_changes;
mod live;
mod logger;

use std::fs;

use gravical::recording::{Aside, ReadOptions, Recording, read};
use rustix::process::Signal;

use board::{Board, HEADER, SETTINGS};
use logger::{Logger, Terminal, words};

/// The recording as the other commands read it.
fn recording(path: &std::path::Path) -> Recording {
    let recording = read(path, &ReadOptions::default()).unwrap();
    assert!(recording.ledger.balances());
    recording
}

fn kinds(recording: &Recording) -> Vec<&str> {
    recording.findings.iter().map(|f| f.kind.name()).collect()
}

#[test]
fn every_row_sent_is_stored_or_rejected_or_in_a_named_gap() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = Logger::start(
        folder.path(),
        &format!("log x --json --port {}", board.port()),
    );
    board.greet();
    log.wait_for("started");
    board.rows(60);
    for hurt in [
        &b"9.81,25\n"[..],
        b"\x00\x01~~\n",
        b"\xff\xfe,1\n",
        b"nan,1,2,3,4,5,6,7\n",
    ] {
        board.hurt(hurt);
    }
    // A comment of the board is not a row.
    board.say("# overruns 1, i2c errors 0, restarts 0\n");
    board.rows(40);
    log.wait_for_rows(100);
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
    log.wait_for_rows(220);
    log.signal(Signal::INT);
    let (code, ended) = log.ended();
    assert_eq!(code, 130, "rows are missing");
    let count = |key: &str| ended[key].as_u64().unwrap();
    assert_eq!(
        count("stored") + count("rejected") + count("missing"),
        board.sent
    );
    assert_eq!((count("rejected"), count("missing")), (5, 50));
    assert_eq!(count("received"), count("stored"));
    let path = folder.path().join("x_axis.csv");
    let recording = recording(&path);
    assert_eq!(recording.rows() as u64, count("stored"));
    assert_eq!(recording.ledger.lines_aside(Aside::NamedGap), 3);
    assert_eq!(recording.breaks.len(), 3);
    let expected = ["named-gap", "restarted-time", "gap", "missing-samples"];
    let found = kinds(&recording);
    assert!(
        found.iter().all(|k| expected.contains(k)),
        "{:#?}",
        recording.findings
    );
    assert!(found.contains(&"named-gap") && found.contains(&"restarted-time"));
    let rejected = fs::read(folder.path().join("x_axis.csv.rejected.txt")).unwrap();
    assert!(rejected.starts_with(b"9.81,25\n\x00\x01~~\n\xff\xfe,1\nnan,1,2,3,4,5,6,7\n"));
    let text = fs::read_to_string(&path).unwrap();
    let gaps: Vec<&str> = text.lines().filter(|l| l.starts_with("# gap:")).collect();
    assert!(gaps[0].starts_with("# gap: unplugged: 30 rows"), "{gaps:?}");
    assert!(
        gaps[1].contains("lost on the way from the board: 20 rows"),
        "{gaps:?}"
    );
    assert!(gaps[2].contains("the board was reset"), "{gaps:?}");
}

#[test]
fn a_clean_recording_has_no_finding_but_the_overflow_of_its_clock() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log y --rows 300 --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    // Across the wrap of a 32-bit clock.
    board.stamp = (1 << 32) - 1000;
    board.rows(300);
    let (code, err) = log.ended_text();
    assert_eq!(code, 0, "{err}");
    assert!(err.contains("y_axis.csv: 300 rows in"), "{err}");
    assert!(err.contains("Next: gravical inspect y_axis.csv"), "{err}");
    let recording = recording(&folder.path().join("y_axis.csv"));
    assert_eq!(recording.rows(), 300);
    assert!(kinds(&recording).is_empty(), "{:?}", kinds(&recording));
    assert_eq!(recording.timing.nominal_rate_hz, Some(100.0));
}

#[test]
fn rows_survive_kill_9_and_the_file_is_continued() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let path = folder.path().join("z_axis.csv");
    let line = format!("log z --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    log.wait_for("started");
    board.rows(100);
    logger::until(|| fs::read_to_string(&path).is_ok_and(|text| text.lines().count() >= 100 + 4));
    log.signal(Signal::KILL);
    log.gone();
    let whole = fs::read_to_string(&path).unwrap();
    assert!(whole.ends_with('\n'));
    assert_eq!(recording(&path).rows(), 100);
    // As if the power had failed in the middle of a line.
    fs::write(&path, &whole[..whole.len() - 9]).unwrap();
    let refused = Logger::start(folder.path(), &line).ended();
    assert_eq!((refused.0, refused.1["code"].as_str()), (2, Some("exists")));
    let line = format!("log z --append --rows 50 --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.stamp = 40;
    board.greet();
    board.rows(50);
    let (code, ended) = log.ended();
    assert_eq!(code, 0, "{ended}");
    let recording = recording(&path);
    assert_eq!(recording.rows(), 99 + 50);
    let kinds = kinds(&recording);
    for kind in ["named-gap", "restarted-time"] {
        assert!(kinds.contains(&kind), "{kind}: {kinds:?}");
    }
    // The part of the last row is not a row, and is not lost.
    assert!(!kinds.contains(&"torn-line"), "{kinds:?}");
    let (kept, torn) = whole[..whole.len() - 9].rsplit_once('\n').unwrap();
    assert!(fs::read_to_string(&path).unwrap().starts_with(kept));
    let rejected = folder.path().join("z_axis.csv.rejected.txt");
    assert_eq!(fs::read_to_string(&rejected).unwrap(), format!("{torn}\n"));
    let warning = log.seen("warning")["text"].as_str().unwrap();
    assert!(warning.contains("z_axis.csv.rejected.txt"), "{warning}");
    assert!(ended["rejected_file"].is_string(), "{ended}");
}

#[test]
fn a_full_disk_is_reported_while_recording() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    // A link, so that the rejected lines do not go to /dev.
    std::os::unix::fs::symlink("/dev/full", folder.path().join("full.csv")).unwrap();
    let line = format!("log -o full.csv --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    board.rows(30);
    let failed = log.wait_for("disk-failed");
    assert!(
        failed["text"].as_str().unwrap().contains("No space left"),
        "{failed}"
    );
    board.rows(30);
    // A last line shows when all have been read.
    board.hurt(b"the end\n");
    log.wait_for("rejected");
    log.signal(Signal::INT);
    let (code, last) = log.ended();
    assert_eq!((code, last["code"].as_str()), (1, Some("io")));
    let ended = log.seen("ended");
    assert_eq!(
        (ended["stored"].as_u64(), ended["unstored"].as_u64()),
        (Some(0), Some(60))
    );
}

#[test]
fn space_pauses_and_the_terminal_is_restored() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut terminal = Terminal::new();
    let line = format!("log x --port {}", board.port());
    let mut log = Logger::start_in(folder.path(), &line, &terminal);
    assert!(terminal.is_cooked());
    board.greet();
    terminal.wait_for("recording; space pauses");
    assert!(!terminal.is_cooked());
    for _ in 0..50 {
        board.rows(1);
        std::thread::sleep(std::time::Duration::from_millis(30));
    }
    terminal.wait_for(" 50 rows");
    terminal.press(" ");
    terminal.wait_for("paused");
    board.rows(50);
    terminal.wait_for("PAUSED");
    terminal.press(" ");
    terminal.wait_for("recording\r\n");
    board.rows(50);
    terminal.wait_for(" 100 rows");
    assert!(terminal.text().contains("‖a‖ 9.8"), "{}", terminal.text());
    // After a long silence rows would be missing.
    board.rows(1);
    std::thread::sleep(std::time::Duration::from_millis(100));
    terminal.press("q");
    let code = log.gone();
    assert_eq!(code, Some(0), "{}", terminal.text());
    assert!(terminal.is_cooked());
    let text = fs::read_to_string(folder.path().join("x_axis.csv")).unwrap();
    assert_eq!(text.matches("\n\n\n\n").count(), 1);
    let recording = recording(&folder.path().join("x_axis.csv"));
    assert_eq!(recording.rows(), 101);
    assert_eq!(recording.breaks, [50]);
}

#[test]
fn settings_are_sent_and_confirmed_before_rows_are_stored() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!(
        "log -o four.csv --range 4 --low-pass 21 --rows 20 --json --port {}",
        board.port()
    );
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    board.rows(10);
    board.wait_for_command("a4\nd21\n");
    let set = SETTINGS.replace("+-2 g", "+-4 g").replace("44 Hz", "21 Hz");
    board.say(&format!("{set}{HEADER}"));
    board.rows(20);
    let (code, ended) = log.ended();
    assert_eq!(code, 0);
    assert_eq!(ended["before_start"].as_u64(), Some(10));
    let text = fs::read_to_string(folder.path().join("four.csv")).unwrap();
    assert!(text.contains(&set) && !text.contains(SETTINGS), "{text}");
}

#[test]
fn a_port_that_appears_later_and_one_that_is_busy() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("ttyACM0").display().to_string();
    let absent = Logger::start(folder.path(), &format!("log x --json --port {port}")).ended();
    assert_eq!(
        (absent.0, absent.1["code"].as_str()),
        (5, Some("no-such-port"))
    );
    assert!(!folder.path().join("x_axis.csv").exists());
    let line = format!("log x --wait --rows 30 --json --port {port}");
    let mut log = Logger::start(folder.path(), &line);
    log.wait_for("waiting");
    let mut board = Board::new(folder.path());
    log.wait_for("opened");
    let busy = Logger::start(folder.path(), &format!("log y --json --port {port}")).ended();
    assert_eq!((busy.0, busy.1["code"].as_str()), (5, Some("port-busy")));
    assert!(
        busy.1["message"].as_str().unwrap().contains("gravical ("),
        "{}",
        busy.1
    );
    board.greet();
    board.rows(30);
    assert_eq!(log.ended().0, 0);
}

#[test]
fn usage_errors() {
    let folder = tempfile::tempdir().unwrap();
    for (line, code, name) in [
        ("log x --range 3 --json", 2, "option-range"),
        ("log x --rate 500 --json", 2, "option-range"),
        ("log x --rows 0 --json", 2, "option-range"),
        ("log x --duration nan --json", 2, "option-range"),
        ("log x --baud 1 --json", 2, "option-range"),
        ("log w --json", 2, "usage"),
        ("log x --columns ax,by --json", 2, "columns-syntax"),
        ("log -o - --port /dev/null --json", 2, "stdout-target"),
        ("log -o no/x.csv --port /dev/null --json", 2, "no-folder"),
        ("log -o . --json", 2, "is-folder"),
        ("log -o . --append --json", 2, "is-folder"),
        ("log x --port /dev/null --json", 5, "port-failed"),
    ] {
        let (got, error) = Logger::start(folder.path(), line).ended();
        assert_eq!((got, error["code"].as_str()), (code, Some(name)), "{line}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_gravical"))
        .args(words("ports --json"))
        .output()
        .unwrap();
    assert!(run.status.success());
    let ports: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    assert!(ports["ports"].is_array());
}
