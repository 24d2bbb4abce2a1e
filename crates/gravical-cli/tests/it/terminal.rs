//! What people see in a terminal: 80 columns, and colour only where it is seen.

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use rustix::fs::{Mode, OFlags, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

use crate::support::*;

#[test]
fn eighty_columns_and_no_colour_in_a_pipe() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    for path in recordings(&folder) {
        for verb in ["inspect", "calibrate", "motion"] {
            let run = run([verb.as_ref(), path.as_os_str()]);
            // `motion` prints its table on stdout.
            let out = if verb == "motion" { "" } else { &run.out };
            let name = path.display().to_string();
            for line in out.lines().chain(run.err.lines()) {
                assert!(!line.contains('\u{1b}'), "{verb} {name}: colour in a pipe");
                // Errors are wrapped in a terminal only.
                let is_free = ["error: ", "  try: "].iter().any(|s| line.starts_with(s));
                let fits = line.chars().count() <= 80 || line.contains(&name) || is_free;
                assert!(fits, "{verb} {name}: {line}");
            }
        }
    }
}

/// What a terminal gets of a run in `folder` to whose input `feed` writes.
fn on_screen(
    folder: &Path,
    line: &str,
    feed: impl FnOnce(&mut std::process::ChildStdin),
) -> String {
    let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&ours).unwrap();
    unlockpt(&ours).unwrap();
    let name = ptsname(&ours, Vec::new()).unwrap();
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
    let theirs = open(name.as_c_str(), flags, Mode::empty()).unwrap();
    let mut run = Command::new(program())
        .args(words(line))
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(theirs.try_clone().unwrap())
        .stderr(theirs)
        .spawn()
        .unwrap();
    let reader = std::thread::spawn(move || {
        let (mut screen, mut text) = (File::from(ours), Vec::new());
        let mut some = [0; 4096];
        // Its end is an error: nobody writes to it any more.
        while let Ok(n @ 1..) = screen.read(&mut some) {
            text.extend(&some[..n]);
        }
        String::from_utf8(text).unwrap()
    });
    feed(&mut run.stdin.take().unwrap());
    assert!(run.wait().unwrap().success());
    reader.join().unwrap()
}

#[test]
fn a_terminal_gets_a_table_only_when_it_is_asked_for() {
    let folder = demo();
    for (verb, column) in [
        ("apply d/calibration.json d/line/line.csv", "ax_mps2"),
        ("motion d/line/line.csv", "px_m"),
    ] {
        let text = on_screen(folder.path(), verb, |_| {});
        let said = text.contains("rows") && text.contains("No table was written: -o FILE");
        assert!(said && text.lines().count() < 80, "{verb}: {text}");
        let text = on_screen(folder.path(), &format!("{verb} -o -"), |_| {});
        let is_table = text.contains(column) && text.lines().count() > 500;
        assert!(is_table, "{verb}");
        let json = on_screen(folder.path(), &format!("{verb} --json -q"), |_| {});
        let parsed: Result<serde_json::Value, _> = serde_json::from_str(&json);
        assert!(parsed.is_ok(), "{verb}: {json}");
    }
}

#[test]
fn what_takes_longer_than_a_second_has_a_progress_bar() {
    let folder = demo();
    let recording = std::fs::read(folder.path().join("d/line/line.csv")).unwrap();
    let slow = |input: &mut std::process::ChildStdin| {
        let (early, late) = recording.split_at(recording.len() / 2);
        input.write_all(early).unwrap();
        std::thread::sleep(Duration::from_millis(1500));
        input.write_all(late).unwrap();
    };
    let text = on_screen(folder.path(), "inspect -", slow);
    assert!(text.contains("reading -"), "{text}");
    // It is gone before the result comes.
    let after = text.rsplit("reading -").next().unwrap();
    assert!(
        after.contains("\u{1b}[2K") && after.contains("100.0"),
        "{after}"
    );
    let at_once = on_screen(folder.path(), "inspect d/line/line.csv", |_| {});
    assert!(!at_once.contains("reading d"), "{at_once}");
}
