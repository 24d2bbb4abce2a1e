//! The program: a port that is opened like that of a board.
#![cfg(feature = "emulator")]
#![allow(clippy::unwrap_used)] // helpers of a test may panic as it does

mod board;

use std::fs::File;
use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Child, Command, Stdio};

struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn start(arguments: &[&str]) -> Option<(Running, String)> {
    let Some(elf) = board::firmware() else {
        eprintln!("skipped: neither GRAVICAL_FIRMWARE nor avr-gcc");
        return None;
    };
    let mut child = Command::new(env!("CARGO_BIN_EXE_virtual-board"))
        .args(["--speed", "max", "--duration", "600", "--firmware"])
        .arg(elf)
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut port = String::new();
    let out = child.stdout.take().unwrap();
    BufReader::new(out).read_line(&mut port).unwrap();
    Some((Running(child), port.trim().to_owned()))
}

fn open(port: &str) -> (File, impl Iterator<Item = String> + use<>) {
    let file = File::options().read(true).write(true).open(port).unwrap();
    let lines = BufReader::new(file.try_clone().unwrap())
        .lines()
        .map(Result::unwrap);
    (file, lines)
}

#[test]
fn each_opening_starts_anew() {
    let Some((_running, port)) = start(&["--simulate", "line", "--seed", "3"]) else {
        return;
    };
    let mut rows = Vec::new();
    for _ in 0..2 {
        let (_file, mut lines) = open(&port);
        // What was on its way when the port was opened may come first.
        let first = lines.find(|l| l.starts_with("# gravical mpu6050_logger"));
        assert!(first.is_some());
        assert!(lines.next().unwrap().starts_with("Timestamp (ms),aX"));
        rows.push(lines.take(50).collect::<Vec<_>>());
    }
    // The same motion from its start; the stamps are those of the board.
    for (a, b) in rows[0].iter().zip(&rows[1]) {
        assert_eq!(a.split_once(',').unwrap().1, b.split_once(',').unwrap().1);
    }
}

#[test]
fn commands_come_through_and_a_link_leads_there() {
    let link = std::env::temp_dir().join(format!("ttyBOARD{}", std::process::id()));
    let Some((_running, port)) = start(&["--link", link.to_str().unwrap()]) else {
        return;
    };
    assert_eq!(port, link.to_str().unwrap());
    let (mut file, mut lines) = open(&port);
    lines.next().unwrap();
    file.write_all(b"r50\n").unwrap();
    assert!(lines.take(3000).any(|l| l.contains("rate 50.00 Hz")));
    std::fs::remove_file(link).unwrap();
}

#[test]
fn what_cannot_be_meant() {
    for arguments in [
        &["--speed", "0"][..],
        &["--faults", "x@1"],
        &["--simulate", "circle"],
        &["--recording", "/nowhere.csv"],
        &["--firmware", "/nowhere.elf"],
        &["--bootloader", "-1"],
        &["--clock-error", "nan"],
    ] {
        let done = Command::new(env!("CARGO_BIN_EXE_virtual-board"))
            .args(arguments)
            .output()
            .unwrap();
        assert_eq!(done.status.code(), Some(2), "{arguments:?}");
        assert!(done.stdout.is_empty());
    }
}
