//! A signal ends the program at any moment, and leaves no file that is half written.

use std::fs;
use std::os::unix::process::ExitStatusExt as _;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use crate::support::*;

/// The recording of the demo's move, over and over: a second of work and more.
fn long_recording() -> tempfile::TempDir {
    let folder = demo();
    let line = read(folder.path(), "d/line/line.csv");
    let is_row = |l: &&str| l.starts_with(|c: char| c.is_ascii_digit());
    let head: String = line
        .lines()
        .filter(|l| !is_row(l))
        .map(|l| format!("{l}\n"))
        .collect();
    let rows: Vec<&str> = line.lines().filter(is_row).collect();
    let mut long = head;
    for i in 0..200_000 {
        let values = rows[i % rows.len()].split_once(',').unwrap().1;
        long += &format!("{:.2},{values}\n", i as f64 / 100.0);
    }
    write(folder.path(), "long.csv", &long);
    folder
}

#[test]
fn no_file_is_left_behind() {
    let folder = long_recording();
    let at = folder.path();
    for verb in [
        "apply d/calibration.json long.csv -o out/a.csv",
        "convert long.csv -o out/c.csv.gz",
    ] {
        fs::create_dir_all(at.join("out")).unwrap();
        let began = Instant::now();
        ends(at, verb, 0);
        let whole = began.elapsed();
        fs::remove_dir_all(at.join("out")).unwrap();
        let mut ended_early = 0;
        // Spread over the run, at moments that are never the same.
        for i in 0..24 {
            fs::create_dir_all(at.join("out")).unwrap();
            let mut child = Command::new(program())
                .args(words(verb))
                .current_dir(at)
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            sleep(whole * (i + 1) / 32);
            let signal = [Signal::INT, Signal::TERM, Signal::HUP][i as usize % 3];
            let _ = kill_process(Pid::from_child(&child), signal);
            let status = child.wait().unwrap();
            ended_early += usize::from(status.signal() == Some(signal.as_raw()));
            let left = below(&at.join("out"));
            let is_hidden = |p: &std::path::PathBuf| p.to_string_lossy().contains(".gravical-");
            assert!(!left.iter().any(is_hidden), "{verb}: {status}: {left:?}");
            fs::remove_dir_all(at.join("out")).unwrap();
        }
        // However long the others took: some were in the middle.
        assert!(ended_early > 0, "{verb}");
    }
}

#[test]
fn a_signal_that_is_ignored_stays_ignored() {
    let folder = long_recording();
    let script = format!(
        "trap '' HUP; exec {} convert long.csv -o out.csv -q",
        program().display()
    );
    let mut child = Command::new("sh")
        .args(["-c", &script])
        .current_dir(folder.path())
        .spawn()
        .unwrap();
    sleep(Duration::from_millis(100));
    let _ = kill_process(Pid::from_child(&child), Signal::HUP);
    assert!(child.wait().unwrap().success());
}
