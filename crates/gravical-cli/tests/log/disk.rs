//! A disk that is full and then has room again: a real one of 256 KiB, in a namespace of
//! its own. Where the system does not allow that, the test is skipped; the tests of
//! `device/recorder` simulate the disk in memory.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use crate::board::Board;
use crate::logger::{Logger, until};

const MOUNT: &str = "mkdir small && mount -t tmpfs -o size=256k none small";

fn is_allowed() -> bool {
    let folder = tempfile::tempdir().unwrap();
    Command::new("unshare")
        .args(["-rm", "sh", "-c", MOUNT])
        .current_dir(folder.path())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

#[test]
fn a_disk_that_was_full_has_room_again() {
    if !is_allowed() {
        eprintln!("skipped: no small disk can be mounted here");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut board = Board::new(folder.path());
    let ballast = "head -c 200000 /dev/zero > small/ballast";
    let program = env!("CARGO_BIN_EXE_gravical");
    let log = format!(
        "exec {program} log -o small/x.csv --json --port {}",
        board.port()
    );
    let mut command = Command::new("unshare");
    command
        .args(["-rm", "sh", "-c"])
        .arg(format!("{MOUNT} && {ballast} && {log}"))
        .current_dir(folder.path());
    let mut log = Logger::start_command(command);
    log.wait_for("opened");
    board.greet();
    log.wait_for("started");
    // The namespace of the program.
    let small = PathBuf::from(format!("/proc/{}/root", log.id()))
        .join(folder.path().strip_prefix("/").unwrap())
        .join("small");
    board.rows(200);
    log.wait_for_rows(200);
    while !log.has_seen("disk-failed") {
        board.rows(100);
        log.look();
    }
    // More than are held in memory.
    board.rows(5000);
    log.wait_for("status");
    fs::remove_file(small.join("ballast")).unwrap();
    log.wait_for("disk-recovered");
    board.rows(100);
    let mut text = String::new();
    let last = format!("{},", board.stamp - 10);
    until(|| {
        text = fs::read_to_string(small.join("x.csv")).unwrap();
        text.lines().any(|line| line.starts_with(&last))
    });
    log.signal(rustix::process::Signal::INT);
    // Rows are missing.
    assert_eq!(log.ended().0, 130);
    let ended = log.seen("ended").clone();
    let count = |key: &str| ended[key].as_u64().unwrap();
    assert_eq!(count("stored") + count("unstored"), board.sent);
    assert!(count("unstored") > 1000 && count("gaps") == 1, "{ended}");
    let rows = text
        .lines()
        .filter(|l| l.starts_with(|c: char| c.is_ascii_digit()));
    assert_eq!(rows.count() as u64, count("stored"));
    let named = format!(
        "# gap: the disk was full: {} rows are missing",
        count("unstored")
    );
    assert!(text.contains(&named), "{ended}");
    // A batch that was written in part was removed: no line is incomplete.
    let recording = gravical::recording::read_bytes(
        text.as_bytes(),
        "x.csv",
        &gravical::recording::ReadOptions::default(),
    )
    .unwrap();
    assert_eq!(recording.rows() as u64, count("stored"));
    assert_eq!(recording.breaks.len(), 1);
}
