//! `gravical live` at a port: poses are safe when the cable is pulled, when the user interrupts,
//! and when the session is resumed.

use gravical::live::folder::{Journal, RECORDING};
use rustix::process::Signal;
use serde_json::json;

use super::board::Board;
use super::logger::{Logger, Terminal, program, until};
use super::recording;

#[test]
fn a_guided_session_survives_an_unplugged_cable_and_an_interruption() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("live --port {} --folder s --events -", board.port());
    let mut live = Logger::start(folder.path(), &line);
    live.wait_for("connecting");
    board.greet();
    board.rows(500);
    live.wait_for_one("session", json!({"source": "port"}));
    live.wait_for_one("identified", json!({"unit": "m/s^2", "gyro_unit": "deg/s"}));
    live.wait_for_one("pose_accepted", json!({"face": "+z", "pose": 1}));
    let journal = |n: usize| {
        let journal = Journal::read(&folder.path().join("s")).unwrap();
        assert_eq!(journal.poses.len(), n);
        journal
    };
    // It is in the journal when it is shown.
    journal(1);

    board.unplug();
    live.wait_for_one("lost", json!({"why": "unplugged", "poses": 1}));
    board.lose(300);
    board.plug_in();
    // The port is opened some time later.
    until(|| {
        board.rows(10);
        live.look();
        live.has_seen("resumed")
    });
    assert_eq!(live.seen("resumed")["poses"], 1);
    board.rows(100);
    live.signal(Signal::INT);
    let resume = "gravical live --resume s";
    live.wait_for_one("end", json!({"reason": "interrupted", "resume": resume}));
    assert_eq!(live.gone(), Some(130));

    let line = format!("live --port {} --resume s --events -", board.port());
    let mut live = Logger::start(folder.path(), &line);
    live.wait_for("connecting");
    board.reset();
    board.rows(600);
    live.wait_for_one("pose_accepted", json!({"pose": 1}));
    live.wait_for("resumed");
    live.wait_for("floor");
    live.signal(Signal::INT);
    live.wait_for_one("end", json!({"poses": 1}));
    assert_eq!(live.gone(), Some(130));
    let recording = recording(&folder.path().join("s").join(RECORDING));
    assert_eq!(journal(1).sections(&recording).unwrap().len(), 1);
    assert!(recording.breaks.len() >= 2, "{:?}", recording.breaks);
}

/// A port without rows is no end: the page says what arrives, and another source can be chosen.
#[test]
fn a_port_without_rows_is_no_end() {
    let garbage = b"\x00\xf8\x80\xfe\x1c\n".repeat(50);
    let words = "no row of a sensor: \"Hello, I blink!\"";
    for (sent, words) in [
        (&b""[..], "nothing arrives"),
        (b"Hello, I blink!\n", words),
        (&garbage, "is not text: the board uses another baud rate"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let mut board = Board::new(folder.path());
        let line = format!("live --port {} --folder s --plain --events -", board.port());
        let mut terminal = Terminal::new();
        let mut live = Logger::start_in(program(folder.path(), &line), &terminal);
        live.wait_for("connecting");
        if sent.is_empty() {
            // What is typed is done while a board is silent, too.
            terminal.press("stop\n");
            let warning = live.wait_for("warning");
            assert!(warning["text"].as_str().unwrap().contains("has not begun"));
        }
        board.send(sent);
        let asked = live.wait_for("ports");
        let message = asked["text"].as_str().unwrap();
        assert!(message.contains(words), "{message}");
        let flash = asked["flash"].as_array().unwrap();
        assert!(flash.len() == 3 && flash[2].as_str().unwrap().contains(&board.port()));
        // Neither an empty folder nor an empty file remains.
        assert!(!folder.path().join("s").exists());
        if sent.is_empty() {
            terminal.press("simulate\n");
            live.wait_for_one("session", json!({"source": "simulate"}));
        } else {
            // Now it has a sketch.
            terminal.press(&format!("port {}\n", board.port()));
            live.wait_for("connecting");
            board.greet();
            board.rows(500);
            live.wait_for_one("session", json!({"source": "port"}));
            live.wait_for_one("pose_accepted", json!({"face": "+z"}));
        }
        live.signal(Signal::INT);
        assert_eq!(live.gone(), Some(130));
    }
}
