//! Nothing in a recording, a file name or a calibration steers the terminal of whoever looks
//! at it: every verb, as text, as JSON, as a page.

use std::fs;
use std::path::Path;

use crate::support::*;

/// A colour, a title, a bell, a cleared line, C1, text turned around.
const HOSTILE: &str = "\u{1b}[31m\u{1b}]0;title\u{7}\r\u{9b}2K\u{85}\u{202e}\u{2066}\u{7f}";

fn steers(c: char) -> bool {
    (c.is_control() && c != '\n' && c != '\t')
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

fn harmless(text: &str, what: &str) {
    let line = text.lines().find(|l| l.contains(steers));
    assert!(line.is_none(), "{what}: {line:?}");
}

/// Two recordings, one with a header that is torn and one that is not understood, a
/// calibration, a section list and a list of means; in all names and texts what is hostile.
fn folder() -> tempfile::TempDir {
    let folder = demo();
    let at = folder.path();
    let line = read(at, "d/line/line.csv");
    let mut lines: Vec<String> = line.lines().map(str::to_owned).collect();
    let header = lines.iter().position(|l| !l.starts_with('#')).unwrap();
    for (i, l) in lines.iter_mut().enumerate().skip(header) {
        l.push_str(&if i == header {
            format!(",part,{HOSTILE}")
        } else {
            format!(",{HOSTILE},1")
        });
    }
    lines.insert(header + 40, format!("# gap: {HOSTILE}"));
    lines.insert(header + 60, format!("1,2,{HOSTILE}x"));
    lines.insert(header + 80, format!("{HOSTILE},t,ax"));
    lines.insert(header, format!("# Serial Number: A1{HOSTILE}"));
    let mut cal: serde_json::Value = serde_json::from_str(&read(at, "d/calibration.json")).unwrap();
    hostile(&mut cal);
    let unknown = format!("t,{HOSTILE}x,foo,bar\n1,2,3,4\n2,2,3,4\n3,2,3,4\n");
    let sections = format!("{{\"{}\": {{\"start\": 9, \"end\": 1}}}}", escaped());
    for (file, text) in [
        ("line.csv", lines.join("\n") + "\n"),
        ("no.csv", format!("a{HOSTILE},b\nx,{HOSTILE}\n")),
        ("unknown.csv", unknown),
        ("bad.json", format!("{{\"format\": \"{}\"}}", escaped())),
        ("cal.json", cal.to_string()),
        ("sections.json", sections),
    ] {
        write(at, &name(file), &text);
    }
    folder
}

fn name(end: &str) -> String {
    format!("{HOSTILE}\nVerdict: good{end}")
}

fn escaped() -> String {
    let quoted = serde_json::to_string(HOSTILE).unwrap();
    quoted.trim_matches('"').to_owned()
}

/// Every text of a calibration that is free.
fn hostile(value: &mut serde_json::Value) {
    match value {
        serde_json::Value::Array(list) => list.iter_mut().for_each(hostile),
        serde_json::Value::Object(map) => {
            for (key, value) in map {
                let free = [
                    "message", "file", "path", "source", "label", "reasons", "command", "tool",
                    "id", "model", "reason", "name", "face",
                ];
                match value {
                    serde_json::Value::String(text) if free.contains(&&key[..]) => {
                        text.push_str(HOSTILE);
                        text.push_str("\nVerdict: good");
                    }
                    serde_json::Value::Array(list) if key == "reasons" => {
                        list.push(format!("{HOSTILE}\nVerdict: good").into());
                    }
                    _ => hostile(value),
                }
            }
        }
        _ => {}
    }
}

/// L, N, U: recordings; C, B: calibrations; S: sections; R: a report; O: an output; H: hostile.
const RUNS: &str = "\
inspect L
inspect N
inspect U
inspect O
inspect .
calibrate L --sensor-id H --report R --force
calibrate L -o O --force --method ferraris
calibrate L --sections S
calibrate L --free-pose H --columns H
apply C L -o O --force
apply B L
apply L L
denoise L --filter savgol:5,2 -o O --force
denoise L --filter H
motion L --calibration C -o O --force --report R
motion L -o O
check C L
compare C C
compare C B
export C --to gravical
export B --to imucal
log --port H -o O
simulate line -o O H
demo -o O
ports H
H";

#[test]
fn no_verb_passes_on_what_steers_a_terminal() {
    let folder = folder();
    let at = folder.path();
    let word = |short: &str| match short {
        "L" => name("line.csv"),
        "N" => name("no.csv"),
        "U" => name("unknown.csv"),
        "C" => name("cal.json"),
        "B" => name("bad.json"),
        "S" => name("sections.json"),
        "R" => name("page.html"),
        "O" => name("out"),
        "H" => HOSTILE.to_owned(),
        plain => plain.to_owned(),
    };
    for line in RUNS.lines() {
        let words: Vec<String> = line.split(' ').map(word).collect();
        for json in [None, Some("--json".to_owned())] {
            let run = run_in(at, words.iter().chain(&json));
            let what = format!("{line} {json:?}");
            harmless(&run.err, &what);
            harmless(&run.out, &what);
            // Nobody says in a line of its own that all is well.
            let mut said = run.err.lines();
            assert!(!said.any(|l| l.starts_with("Verdict: goodline")), "{what}");
        }
        for page in ["R", "O"].map(word) {
            check_page(&at.join(page), line);
        }
    }
}

fn check_page(path: &Path, what: &str) {
    let Ok(text) = fs::read_to_string(path) else {
        return;
    };
    // A table keeps its other columns byte for byte.
    if text.starts_with("<!DOCTYPE") || text.starts_with('{') {
        harmless(&text, &format!("{what} wrote {}", path.display()));
    }
}
