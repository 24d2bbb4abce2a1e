//! What `gravical log` says of the rows is what `gravical inspect` says of the file.

use rustix::process::Signal;

use crate::board::Board;
use crate::logger::run;

/// A sensor with a dead axis, at the end of its range.
fn faulty(board: &mut Board, rows: u64) {
    for i in 0..rows {
        let noise = (i * 7919 % 61) as f64 * 1e-3;
        let x = if i % 50 < 10 { 19.61 } else { 0.1 + noise };
        let (stamp, z) = (board.stamp, 9.8 - noise);
        board.stamp += 10;
        board.say(&format!(
            "{stamp},{x:.2},0.25,{z:.3},25.5,{noise:.2},0.2,-{noise:.3}\n"
        ));
    }
}

#[test]
fn findings_are_those_of_inspect_and_the_bad_ones_are_said_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let mut log = board.log("-o x.csv --json");
    board.greet();
    faulty(&mut board, 300);
    let live = log.wait_for("finding");
    board.lose(40);
    faulty(&mut board, 300);
    log.wait_for("gap");
    log.wait_for_rows(600);
    log.signal(Signal::INT);
    let (_, ended) = log.ended();
    let inspected = run(folder.path(), "inspect x.csv --json").1["recordings"][0].take();
    for key in ["accelerometer", "gyroscope", "timing", "findings"] {
        assert_eq!(ended["inspection"][key], inspected[key], "{key}");
    }
    let found = inspected["findings"].as_array().unwrap();
    for kind in [&"frozen-axis".into(), &"named-gap".into(), &live["kind"]] {
        let is_found = found.iter().any(|f| f["kind"] == *kind);
        assert!(is_found, "{kind}: {found:?}");
    }
    // Each is said once, although the rows that it concerns become more.
    assert_eq!(log.count(&live), 1);

    // A part that is added is in the findings of the whole file, and the summary is for people.
    let mut log = board.log("-o x.csv --append --rows 200");
    board.greet();
    faulty(&mut board, 200);
    let (code, text) = log.ended_text();
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("frozen-axis: ay keeps exactly"), "{text}");
}
