//! Where results go: nothing is replaced by another result, or by what is made of
//! it, and what cannot be written is said before the work.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::*;

/// A folder with a line and what it was calibrated with.
fn folder() -> tempfile::TempDir {
    let folder = demo();
    for (from, to) in [
        ("d/line/line.csv", "line.csv"),
        ("d/calibration.json", "cal.json"),
    ] {
        fs::copy(folder.path().join(from), folder.path().join(to)).unwrap();
    }
    folder
}

/// Every file below the folder with its content.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let content = |path: PathBuf| (path.clone(), fs::read(path).unwrap());
    below(folder).into_iter().map(content).collect()
}

/// Refused with this code, and every file is as it was.
fn refused(folder: &Path, line: &str, code: &str) {
    let before = files(folder);
    let run = run_in(folder, words(line));
    let said = run.err.contains(&format!("code: {code}\n"));
    assert!(run.code == 2 && said, "{line}: {}", run.err);
    assert!(files(folder) == before, "{line}");
}

/// Calls whose outputs cannot be, each with its code.
const REFUSED: &str = "\
motion line.csv -o a.html --report a.html --force: same-target
motion line.csv -o a.html --report ./a.html: same-target
motion line.csv -o f_figures --figures f_figures: same-target
calibrate d/poses/poses.csv -o c.html --report c.html: same-target
motion line.csv -o t.csv --report nope/x.html: no-folder
calibrate d/poses/poses.csv -o no/such/c.json: no-folder
calibrate d/poses/poses.csv -o c.json --report nope/x.html: no-folder
motion line.csv -o t.csv --report d.html --force: is-folder
motion line.csv -o t.csv --report -: report-target
calibrate d/poses/poses.csv --report page.pdf: report-target
motion line.csv -o t.csv --report page.html.gz: report-target
motion line.csv -o t.csv --report there.html: exists
motion line.csv -o t.csv --figures drawn_figures: exists";

#[test]
fn what_cannot_be_written_is_said_before_the_work() {
    let folder = folder();
    let at = folder.path();
    for name in ["figs", "d.html", "drawn_figures"] {
        fs::create_dir(at.join(name)).unwrap();
    }
    write(at, "there.html", "mine");
    let figure = "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"gravical\" width=\"9\"/>";
    write(at, "drawn_figures/position.svg", figure);
    for row in REFUSED.lines() {
        let (line, code) = row.split_once(": ").unwrap();
        refused(at, line, code);
    }
}

/// Commands that end in the option of an output, each with what it reads.
const READ: &str = "\
calibrate line.csv -o: line.csv
calibrate s -o: s/x_up.csv s/notes.txt s/converted.csv
calibrate live -o: live/recording.csv live/session.ndjson
calibrate line.csv --gyro o.csv -o: o.csv
calibrate line.csv --sections o.csv -o: o.csv
calibrate line.csv --thermal o.csv -o: o.csv
calibrate o.html --report: o.html
calibrate --each s --summary: s/x_up.csv s/notes.txt
calibrate --each live line.csv --summary: live/recording.csv line.csv
calibrate --each @list --summary: list s/x_up.csv
calibrate --each s --sections sections.csv --summary: sections.csv
calibrate --each s --thermal line.csv --summary: line.csv
check o.html line.csv --report: o.html
check cals o.html --report: o.html
check cal.json line.csv --gyro o.html --report: o.html
inspect o.html --report: o.html
inspect line.csv --gyro o.html --report: o.html
compare o.html cal.json --report: o.html
compare cal.json o.html --report: o.html
apply cal.json line.csv -o: cal.json line.csv
apply cals line.csv -o: cals/cal.json
apply cal.json line.csv --gyro o.csv -o: o.csv
apply cal.json line.csv o.csv -o out --summary: cal.json o.csv
apply cal.json --each s -o out --summary: s/x_up.csv
convert line.csv -o: line.csv
denoise line.csv --filter savgol:5,2 -o: line.csv
denoise o.html --filter savgol:5,2 --report: o.html
noise line.csv -o: line.csv
noise o.html --report: o.html
export cal.json --to imucal -o: cal.json
motion line.csv -c cal.json -o: line.csv cal.json
motion line.csv -c cals -o: cals/cal.json
motion line.csv --gyro o.csv -o: o.csv
motion line.csv -c o.html --report: o.html
live --replay line.csv -o: line.csv
live --replay line.csv --events: line.csv
live --resume live --events: live/recording.csv
live --resume live -o: live/recording.csv live/session.ndjson";

#[test]
fn what_is_read_is_never_replaced() {
    let folder = folder();
    let at = folder.path();
    fs::remove_dir_all(at.join("d")).unwrap();
    for name in ["s", "cals", "live", "out"] {
        fs::create_dir(at.join(name)).unwrap();
    }
    for name in ["s/x_up.csv", "live/recording.csv", "o.csv", "o.html"] {
        fs::copy(at.join("line.csv"), at.join(name)).unwrap();
    }
    fs::copy(at.join("cal.json"), at.join("cals/cal.json")).unwrap();
    write(at, "s/notes.txt", "+x first");
    write(at, "live/session.ndjson", "");
    write(at, "list", "s/x_up.csv\n");
    write(at, "sections.csv", "label,start,end\nx_up,0,100\n");
    ends(at, "convert line.csv -o s/converted.csv", 0);
    for row in READ.lines() {
        let (line, targets) = row.split_once(": ").unwrap();
        // `live` replaces nothing.
        let force = [" --force", ""][usize::from(line.starts_with("live"))];
        for target in targets.split(' ') {
            refused(at, &format!("{line} {target}{force}"), "target-is-input");
        }
    }
    for path in names_of(at, "s/x_up.csv") {
        let line = format!("apply cal.json s/x_up.csv -o {path} --force");
        refused(at, &line, "target-is-input");
    }
    let line = "apply cal.json --each s -o s --force";
    refused(at, line, "target-is-input");
}

/// Paths of a file of the folder, with links to it.
fn names_of(folder: &Path, file: &str) -> Vec<String> {
    let path = folder.join(file);
    let mut names = vec![format!("s/../out/.././{file}"), path.display().to_string()];
    #[cfg(unix)]
    {
        let links = ["hard", "symbolic"].map(|kind| folder.join(kind));
        fs::hard_link(&path, &links[0]).unwrap();
        std::os::unix::fs::symlink(&path, &links[1]).unwrap();
        names.extend(links.map(|link| link.display().to_string()));
    }
    names
}

#[test]
#[cfg(unix)]
fn a_file_at_standard_input_is_not_replaced() {
    let folder = folder();
    let line = words("apply cal.json - -o line.csv --force");
    let input = fs::File::open(folder.path().join("line.csv")).unwrap();
    let run = run_with(folder.path(), |c| c.args(line).stdin(input));
    assert!(run.err.contains("code: target-is-input"), "{}", run.err);
}

#[test]
fn results_in_an_input_folder_are_replaced_with_force() {
    let folder = folder();
    let at = folder.path();
    for line in [
        "calibrate s -o s/cal.json --report s/cal.html",
        "calibrate --each s -o s --summary s/all.csv",
        "inspect s --report s/poses.html",
        "apply s line.csv -o s/line.csv.gz",
        "motion line.csv -c s -o s/track.csv",
        "convert line.csv -o s/si.csv",
    ] {
        fs::create_dir(at.join("s")).unwrap();
        fs::copy(at.join("cal.json"), at.join("s/sensor.json")).unwrap();
        fs::copy(at.join("d/poses/poses.csv"), at.join("s/poses.csv")).unwrap();
        for (force, code) in [("", 0), ("", 2), (" --force", 0)] {
            let run = ends(at, &format!("{line}{force}"), code);
            assert_eq!(run.err.contains("code: exists"), code == 2, "{}", run.err);
        }
        fs::remove_dir_all(at.join("s")).unwrap();
    }
}

#[test]
#[cfg(unix)]
fn a_pipe_and_a_device_take_what_a_file_takes() {
    let folder = folder();
    let at = folder.path();
    let pipe = at.join("pipe");
    let mode = rustix::fs::Mode::from_raw_mode(0o600);
    rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, mode).unwrap();
    for line in [
        "calibrate d/poses/poses.csv",
        "apply cal.json line.csv",
        "denoise line.csv --filter savgol:5,2",
        "motion line.csv",
        "export cal.json --to imucal",
    ] {
        let own = pipe.clone();
        let reader = std::thread::spawn(move || fs::read_to_string(own).unwrap());
        ends(at, &format!("{line} -o pipe"), 0);
        let through = reader.join().unwrap();
        let run = ends(at, &format!("{line} -o /dev/stdout"), 0);
        let first = |text: &str| text.lines().next().unwrap().to_owned();
        assert!(run.out.starts_with(&first(&through)), "{line}: {}", run.out);
        ends(at, &format!("{line} -o /dev/null"), 0);
    }
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
        let run = run_with(folder.path(), |c| c.args(words(line)).stdout(full));
        let is_error = matches!(run.code, 1 | 3) && run.err.starts_with("error: ");
        assert!(is_error, "{line}: {}", run.err);
    }
}
