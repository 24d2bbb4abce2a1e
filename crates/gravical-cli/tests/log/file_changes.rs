//! Changes of the file during the recording, and unusual lines.

use std::fs;

use rustix::process::Signal;

use crate::board::Board;
use crate::logger::{Logger, until};
use crate::recording;

#[test]
fn a_file_that_is_deleted_continues_beside_it_with_all_rows() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log -o x.csv --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    board.rows(40);
    log.wait_for_rows(40);
    fs::remove_file(folder.path().join("x.csv")).unwrap();
    let warning = log.wait_for("warning");
    assert!(
        warning["text"].as_str().unwrap().contains("x.kept.csv"),
        "{warning}"
    );
    board.rows(40);
    log.wait_for_rows(80);
    log.signal(Signal::INT);
    let (code, last) = log.ended();
    assert_eq!((code, last["code"].as_str()), (1, Some("io")));
    let file = log.seen("ended")["file"].as_str().unwrap().to_owned();
    assert!(!folder.path().join("x.csv").exists());
    assert_eq!(recording(&folder.path().join(file)).rows(), 80);
}

#[test]
fn rejected_lines_that_arrive_fast_are_all_stored() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log -o x.csv --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    board.rows(10);
    log.wait_for("started");
    // Many times the room in memory, faster than usual writes.
    let garbage = "what a loose wire makes of a row, again and again and again\n".repeat(10_000);
    board.send(garbage.as_bytes());
    board.rows(10);
    log.wait_for_rows(20);
    log.signal(Signal::INT);
    log.ended();
    let ended = log.seen("ended");
    assert_eq!(ended["rejected_unstored"], 0, "{ended}");
    let kept = fs::metadata(folder.path().join("x.csv.rejected.txt")).unwrap();
    assert_eq!(kept.len(), garbage.len() as u64);
}

#[test]
fn the_duration_counts_from_the_first_row_and_lines_may_end_with_a_carriage_return() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log -o x.csv --json --duration 1 --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    let greeting = format!("{}{}", crate::SETTINGS, crate::HEADER);
    board.say(&greeting.replace('\n', "\r"));
    log.wait_for("started");
    std::thread::sleep(std::time::Duration::from_millis(700));
    for i in 0.. {
        board.say(&format!("{},0.1,0.2,9.81,25.5,0.1,0.2,0.3\r", 10 * i));
        log.look();
        if log.has_seen("ended") {
            break;
        }
    }
    until(|| log.has_seen("ended"));
    assert_eq!(log.gone(), Some(0));
    let ended = log.seen("ended");
    assert_eq!(
        (&ended["reason"], &ended["rejected"]),
        (&"duration".into(), &0.into())
    );
    let recording = recording(&folder.path().join("x.csv"));
    assert!(recording.rows() > 60, "{} rows", recording.rows());
}

#[test]
fn a_file_with_other_columns_is_not_continued() {
    let folder = tempfile::tempdir().unwrap();
    let before = "t,ax,ay,az,T,gx,gy,gz\n1,0,0,9.8,25,0,0,0\n";
    fs::write(folder.path().join("x.csv"), before).unwrap();
    let mut board = Board::new(folder.path());
    let line = format!("log -o x.csv --append --json --port {}", board.port());
    let mut log = Logger::start(folder.path(), &line);
    board.greet();
    board.rows(10);
    let (_, error) = log.ended();
    assert_eq!(error["code"].as_str(), Some("columns-changed"), "{error}");
    let text = fs::read_to_string(folder.path().join("x.csv")).unwrap();
    assert!(text.starts_with(before) && !text.contains("9.81"), "{text}");
}
