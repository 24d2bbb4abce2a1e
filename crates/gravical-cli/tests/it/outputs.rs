//! Where results go: nothing is replaced by another result, or by what is made of
//! it, and what cannot be written is said before the work.

use std::fs;
use std::path::Path;

use crate::support::*;

/// A folder with a line and what it was calibrated with.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let run = run_in(folder.path(), ["demo", "d", "--json"]);
    assert_eq!(run.code, 0, "{}", run.err);
    for (from, to) in [
        ("line/line.csv", "line.csv"),
        ("calibration.json", "cal.json"),
    ] {
        fs::copy(folder.path().join("d").join(from), folder.path().join(to)).unwrap();
    }
    folder
}

/// Refused with this code, and nothing new in the folder.
fn refused(folder: &Path, line: &str, code: &str) {
    let names = || {
        let mut all: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name())
            .collect();
        all.sort();
        all
    };
    let (before, line_csv) = (names(), fs::read(folder.join("line.csv")).unwrap());
    let run = run_in(folder, words(line).into_iter().chain(["--json".to_owned()]));
    assert_eq!(
        (run.code, run.error_code().as_str()),
        (2, code),
        "{line}: {}",
        run.out
    );
    assert_eq!(names(), before, "{line}");
    assert!(
        fs::read(folder.join("line.csv")).unwrap() == line_csv,
        "{line}"
    );
}

#[test]
fn two_results_never_share_a_file() {
    let folder = folder();
    let at = folder.path();
    refused(
        at,
        "motion line.csv -o a.html --report a.html --force",
        "same-target",
    );
    refused(
        at,
        "motion line.csv -o a.html --report ./a.html",
        "same-target",
    );
    refused(
        at,
        "motion line.csv --report f.html --figures f.html",
        "same-target",
    );
    refused(
        at,
        "calibrate d/poses/poses.csv -o c.html --report c.html",
        "same-target",
    );
    fs::create_dir(at.join("figs")).unwrap();
    refused(
        at,
        "motion line.csv -o figs/position.csv --figures figs --force",
        "foreign-files",
    );
}

#[test]
fn what_is_read_is_never_replaced() {
    let folder = folder();
    let at = folder.path();
    refused(at, "motion line.csv -o line.csv --force", "target-is-input");
    fs::copy(at.join("cal.json"), at.join("cal.md")).unwrap();
    for report in ["cal.md", "d/../cal.md"] {
        let line = format!("motion line.csv -c cal.md --report {report} --force");
        refused(at, &line, "target-is-input");
    }
    refused(
        at,
        "apply cal.json line.csv -o line.csv --force",
        "target-is-input",
    );
    refused(
        at,
        "denoise line.csv --filter mean:5 -o line.csv --force",
        "target-is-input",
    );
    refused(
        at,
        "calibrate line.csv -o line.csv --force",
        "target-is-input",
    );
}

#[test]
fn what_cannot_be_written_is_said_before_the_work() {
    let folder = folder();
    let at = folder.path();
    refused(
        at,
        "motion line.csv -o t.csv --report nope/x.html",
        "no-folder",
    );
    fs::create_dir(at.join("d.html")).unwrap();
    refused(
        at,
        "motion line.csv -o t.csv --report d.html --force",
        "is-folder",
    );
    refused(at, "motion line.csv -o t.csv --figures -", "figures-target");
    refused(at, "motion line.csv -o t.csv --report -", "report-target");
    refused(
        at,
        "calibrate d/poses/poses.csv -o c.json --report nope/x.html",
        "no-folder",
    );
    fs::create_dir(at.join("figs")).unwrap();
    fs::write(at.join("figs/position.svg"), "mine").unwrap();
    refused(at, "motion line.csv -o t.csv --figures figs", "exists");
    refused(
        at,
        "motion line.csv -o t.csv --figures figs --causal",
        "not-causal",
    );
}

#[test]
fn a_line_breaks_where_samples_are_missing() {
    let folder = folder();
    let at = folder.path();
    let text = fs::read_to_string(at.join("line.csv")).unwrap();
    // A second at rest is gone.
    let kept: Vec<&str> = text
        .lines()
        .enumerate()
        .filter(|(i, _)| !(200..300).contains(i))
        .map(|(_, l)| l)
        .collect();
    fs::write(at.join("gap.csv"), kept.join("\n")).unwrap();
    let run = run_in(
        at,
        words("motion gap.csv -c cal.json --figures f --report r.html --json --quiet"),
    );
    assert_eq!(run.code, 0, "{}", run.err);
    for name in ["acceleration", "velocity", "position"] {
        let svg = fs::read_to_string(at.join(format!("f/{name}.svg"))).unwrap();
        let (_, own) = svg
            .split_once("data-name=\"calibrated\" data-samples")
            .unwrap();
        let (_, path) = own.split_once(" d=\"").unwrap();
        let (path, _) = path.split_once('"').unwrap();
        assert_eq!(path.matches('M').count(), 2, "{name}: one break");
    }
}

#[test]
#[cfg(unix)]
fn a_pipe_and_a_device_take_what_a_file_takes() {
    use std::io::Read as _;
    let folder = folder();
    let at = folder.path();
    let pipe = at.join("pipe");
    let mode = rustix::fs::Mode::from_raw_mode(0o600);
    rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, mode).unwrap();
    for line in [
        "calibrate d/poses/poses.csv",
        "apply cal.json line.csv",
        "denoise line.csv --filter mean:5",
        "motion line.csv",
        "export cal.json --to imucal",
    ] {
        let own = pipe.clone();
        let reader = std::thread::spawn(move || {
            let mut text = String::new();
            fs::File::open(own)
                .unwrap()
                .read_to_string(&mut text)
                .unwrap();
            text
        });
        let run = run_in(at, words(&format!("{line} -o pipe")));
        assert_eq!(run.code, 0, "{line}: {}", run.err);
        let through = reader.join().unwrap();
        let run = run_in(at, words(&format!("{line} -o /dev/stdout")));
        assert_eq!(run.code, 0, "{line}: {}", run.err);
        let first = |text: &str| text.lines().next().unwrap().to_owned();
        assert!(run.out.starts_with(&first(&through)), "{line}: {}", run.out);
        let run = run_in(at, words(&format!("{line} -o /dev/null")));
        assert_eq!(run.code, 0, "{line}: {}", run.err);
    }
    assert!(Path::new("/dev/null").exists());
}

#[test]
#[cfg(target_os = "linux")]
fn what_cannot_be_printed_is_said_on_stderr() {
    let folder = folder();
    for line in [
        "inspect line.csv --json",
        "compare cal.json cal.json --json",
        "inspect nothing.csv --json",
        "motion line.csv",
    ] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let output = std::process::Command::new(program())
            .args(words(line))
            .current_dir(folder.path())
            .stdout(full)
            .output()
            .unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert!(matches!(output.status.code(), Some(1 | 3)), "{line}: {err}");
        assert!(err.starts_with("error: "), "{line}: {err}");
    }
}

#[test]
#[cfg(unix)]
fn whatever_ends_a_run_leaves_no_piece_of_a_file() {
    use std::io::Write as _;
    use std::process::{Command, Stdio};
    let folder = folder();
    let at = folder.path();
    let names = || fs::read_dir(at).unwrap().count();
    let before = names();
    let head = fs::read(at.join("line.csv")).unwrap();
    for signal in ["INT", "TERM", "HUP", "KILL"] {
        let mut run = Command::new(program())
            .args(words("apply cal.json - -o out.csv"))
            .current_dir(at)
            .stdin(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut input = run.stdin.take().unwrap();
        // More than the head: it writes by now.
        for _ in 0..8 {
            input.write_all(&head).unwrap();
        }
        let kill = ["-s", signal, &run.id().to_string()];
        assert!(Command::new("kill").args(kill).status().unwrap().success());
        run.wait().unwrap();
        assert_eq!(names(), before, "{signal}");
    }
}
