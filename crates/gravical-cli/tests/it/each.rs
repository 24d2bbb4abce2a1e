//! Many sessions in one run: each result is that of the command alone, and nothing that fails stops
//! the others.

use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, SystemTime};

use serde_json::Value;

use crate::support::*;

/// Sessions of `count` sensors: `fleet/unit-1.csv` …, a few kilobytes each.
fn fleet(count: u64) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("fleet")).unwrap();
    for seed in 1..=count {
        let simulate = "simulate poses -o one --free 2 --hold 3 --rate 25 --force -q";
        ends(at, &format!("{simulate} --seed {seed}"), 0);
        let to = at.join(format!("fleet/unit-{seed}.csv"));
        fs::rename(at.join("one/poses.csv"), to).unwrap();
    }
    folder
}

fn written_json(folder: &Path, name: &str) -> Value {
    serde_json::from_str(&read(folder, name)).unwrap()
}

/// The rows of a summary, by column.
fn rows(path: &Path) -> Vec<HashMap<String, String>> {
    let mut table = csv::Reader::from_path(path).unwrap();
    table.deserialize().map(|row| row.unwrap()).collect()
}

#[test]
fn each_result_is_that_of_the_command_alone() {
    let folder = fleet(2);
    let at = folder.path();
    fs::create_dir(at.join("fleet/folder")).unwrap();
    write_six_files(&at.join("fleet/folder"), &Sensor::default());
    write(at, "fleet/broken.csv", "t,ax,ay,az\n1,2\n");
    write(at, "fleet/notes.md", "not a recording");
    // A spreadsheet would run it.
    write(at, "=cmd.csv", "");
    let line = "calibrate --each fleet gone.csv =cmd.csv --gravity 9.81 -o out --summary out/all.csv --threads 3";
    let run = ends(at, line, 4);
    assert!(run.err.starts_with("6 sessions: "), "{}", run.err);
    assert!(run.err.contains("3 failed"), "{}", run.err);
    let rows = rows(&at.join("out/all.csv"));
    let column = |name: &str| -> Vec<&str> { rows.iter().map(|r| r[name].as_str()).collect() };
    let [broken, units @ ..] = ["broken.csv", "folder", "unit-1.csv", "unit-2.csv"]
        .map(|name| native(&format!("fleet/{name}")));
    assert_eq!(column("path")[0], broken);
    assert_eq!(column("path")[1..4], units);
    assert_eq!(column("path")[4..], ["gone.csv", "'=cmd.csv"]);
    let codes = ["no-rows", "", "", "", "not-found", "empty-file"];
    assert_eq!(column("error_code"), codes);
    assert!(column("hint")[0].len() > 10 && column("result")[0].is_empty());
    let written = ["all.csv", "folder.json", "unit-1.json", "unit-2.json"];
    assert_eq!(listed(&at.join("out")), written);
    for (row, input) in [(&rows[1], "folder"), (&rows[2], "unit-1.csv")] {
        let path = native(&format!("fleet/{input}"));
        let line = format!("calibrate {path} --gravity 9.81 -o {input}.json");
        ends(at, &line, 0);
        let alone = format!("{input}.json");
        let [mut own, mut alone] = [&row["result"], &alone].map(|path| written_json(at, path));
        assert_eq!(row["bias_x"], own["accelerometer"]["bias"][0].to_string());
        for result in [&mut own, &mut alone] {
            result["command"] = Value::Null;
            result["created"] = Value::Null;
        }
        assert!(own == alone, "{input}");
    }
}

#[test]
fn a_second_run_does_what_is_not_done() {
    let folder = fleet(3);
    let at = folder.path();
    let line = "calibrate --each fleet -o out --summary all.csv";
    ends(at, line, 0);
    let first = fs::read_to_string(at.join("all.csv")).unwrap();
    ends(at, line, 2);
    let written = |name: &str| fs::metadata(at.join(name)).unwrap().modified().unwrap();
    let before = ["out/unit-1.json", "out/unit-2.json"].map(written);
    let mut session = fs::File::options();
    let session = session.append(true).open(at.join("fleet/unit-2.csv"));
    let later = SystemTime::now() + Duration::from_secs(60);
    session.unwrap().set_modified(later).unwrap();
    ends(at, &format!("{line} --resume"), 0);
    assert_eq!(fs::read_to_string(at.join("all.csv")).unwrap(), first);
    assert_eq!(written("out/unit-1.json"), before[0]);
    assert_ne!(written("out/unit-2.json"), before[1]);
    for i in 1..=2 {
        let line = format!("calibrate --each fleet -o part --shard {i}/2");
        ends(at, &line, 0);
    }
    let all = ["unit-1.json", "unit-2.json", "unit-3.json"];
    assert_eq!(listed(&at.join("part")), all);
}

#[test]
fn a_page_of_all_leads_to_that_of_each() {
    let folder = fleet(2);
    let at = folder.path();
    fs::rename(at.join("fleet/unit-2.csv"), at.join("fleet/50 % #2&.csv")).unwrap();
    write(at, "fleet/&broken.csv", "t,ax,ay,az\n1,2\n");
    let line = "calibrate --each fleet -o out --report all.html";
    ends(at, line, 4);
    let page = read(at, "all.html");
    let linked = page
        .split("href=\"all/")
        .skip(1)
        .map(|s| s.split('"').next().unwrap());
    assert_eq!(
        linked.collect::<Vec<_>>(),
        ["50%20%25%20%232%26.html", "unit-1.html"]
    );
    assert_eq!(listed(&at.join("all")), ["50 % #2&.html", "unit-1.html"]);
    assert!(page.contains("&amp;broken.csv") && page.contains("<table data-sort"));
    // A page that is missing is made again, one that is there is not.
    let written = || {
        fs::metadata(at.join("all/unit-1.html"))
            .unwrap()
            .modified()
            .unwrap()
    };
    let before = written();
    fs::remove_file(at.join("all/50 % #2&.html")).unwrap();
    ends(at, line, 2);
    ends(at, &format!("{line} --resume"), 4);
    assert!(listed(&at.join("all")).len() == 2 && written() == before);
}

#[test]
fn names_that_several_share_are_told_apart() {
    let folder = fleet(1);
    let at = folder.path();
    for copy in ["a/s.csv", "b/S.csv", "b/s.txt"] {
        fs::create_dir_all(at.join(copy).parent().unwrap()).unwrap();
        fs::copy(at.join("fleet/unit-1.csv"), at.join(copy)).unwrap();
    }
    let list = "\u{feff}# of today\n\na/s.csv\nb/S.csv\na/s.csv\n";
    write(at, "list", list);
    ends(at, "calibrate --each @list -o out", 0);
    assert_eq!(listed(&at.join("out")), ["a-s.json", "b-S.json"]);
    let err = ends(at, "calibrate --each b -o both", 2).err;
    assert!(err.contains("code: same-target"), "{err}");
}

#[test]
fn a_second_run_keeps_nothing_that_is_not_of_the_session() {
    let folder = fleet(2);
    let at = folder.path();
    // The result of another session, one that cannot be read, and one that fails now.
    let line = "calibrate --each fleet -o out --summary fleet/all.csv";
    ends(at, line, 0);
    fs::copy(at.join("out/unit-2.json"), at.join("out/unit-1.json")).unwrap();
    write(at, "out/unit-2.json", "{");
    write(at, "out/unit-3.json", "{}");
    write(at, "fleet/unit-3.csv", "t,ax,ay,az\n1,2\n");
    ends(at, &format!("{line} --resume"), 4);
    let rows = rows(&at.join("fleet/all.csv"));
    // The summary of the first run is no session.
    assert_eq!(rows.len(), 3);
    assert_eq!(rows[2]["result"], "");
    for (row, name) in rows.iter().zip(["unit-1", "unit-2"]) {
        let file = written_json(at, &format!("out/{name}.json"));
        let path = native(&format!("fleet/{name}.csv"));
        assert_eq!(file["inputs"][0]["path"], path);
        assert_eq!(row["bias_x"], file["accelerometer"]["bias"][0].to_string());
    }
}

#[test]
fn apply_takes_many() {
    let folder = fleet(2);
    let at = folder.path();
    ends(at, "calibrate fleet/unit-1.csv -o cal.json", 0);
    let line = "apply cal.json fleet/unit-1.csv fleet/unit-2.csv";
    ends(at, &format!("{line} gone.csv -o out"), 4);
    assert_eq!(listed(&at.join("out")), ["unit-1.csv", "unit-2.csv"]);
    ends(at, "apply cal.json fleet/unit-2.csv -o alone.csv", 0);
    let read = |name: &str| fs::read(at.join(name)).unwrap();
    assert!(read("out/unit-2.csv") == read("alone.csv"));
    // With another calibration nothing is done before.
    ends(at, "calibrate fleet/unit-2.csv -o cal.json --force", 0);
    ends(at, &format!("{line} -o out --resume"), 0);
    assert!(read("out/unit-2.csv") != read("alone.csv"));
}

/// Calls that are refused before any session is read, each with what is said.
const REFUSED: &str = "\
calibrate fleet/unit-1.csv --summary s.csv: each-option
calibrate --each fleet --sensor-id x: each-option
apply cal.json --each fleet -o out --sensor-id x: origin-unused
apply . --each fleet -o out: origin-unused
calibrate --each fleet --figures f: each-option
calibrate --each fleet --report r.txt: report-target
apply cal.json fleet/unit-1.csv fleet/unit-1.csv: each-option
calibrate --each -: each-input
calibrate --each fleet --summary cal.json: exists
calibrate --each fleet --summary nowhere/s.csv: no-folder
calibrate --each fleet -o cal.json: no-folder
calibrate --each fleet --pose-tilt 50: option-range
apply cal.json --each fleet -o fleet --force: target-is-input
calibrate --each fleet --shard 3/2: the eight parts of a run";

#[test]
fn what_cannot_be_done_is_said_before_the_work() {
    let folder = fleet(1);
    let at = folder.path();
    ends(at, "calibrate fleet/unit-1.csv -o cal.json", 0);
    for row in REFUSED.lines() {
        let (line, code) = row.split_once(": ").unwrap();
        let run = run_in(at, words(line));
        assert!(run.err.contains(code), "{line}\n{}", run.err);
        assert!([2, 3].contains(&run.code), "{line}");
    }
}

#[test]
#[cfg(unix)]
fn lines_are_in_the_order_of_names_and_no_link_is_lost_without_a_word() {
    let folder = fleet(3);
    let at = folder.path();
    fs::create_dir(at.join("fleet/left")).unwrap();
    write_six_files(&at.join("fleet/left"), &Sensor::default());
    std::os::unix::fs::symlink("left", at.join("fleet/right")).unwrap();
    fs::rename(at.join("fleet/unit-3.csv"), at.join("fleet/u\u{1b}[2J.csv")).unwrap();
    let line = "calibrate --each fleet --sensor-id folder --summary all.csv --gravity 9.81";
    let run = ends(at, line, 0);
    let note = "note: fleet/right is fleet/left, which is read once\n";
    assert!(run.err.contains(note), "{}", run.err);
    let names = run
        .out
        .lines()
        .map(|l| l.split_whitespace().nth(1).unwrap());
    let names: Vec<&str> = names.collect();
    let u = "fleet/u\\u{1b}[2J.csv";
    assert_eq!(
        names,
        ["fleet/left", u, "fleet/unit-1.csv", "fleet/unit-2.csv"]
    );
    let rows = rows(&at.join("all.csv"));
    assert_eq!((&*rows[0]["sensor_id"], &*rows[1]["path"]), ("left", u));
    assert!(!rows[0]["reason"].contains(" / "));
    let alone = calibrate(at, "fleet/left --sensor-id folder --gravity 9.81", 0);
    assert_eq!(alone["sensor"]["id"], "left");
    fails(
        at,
        "calibrate fleet/unit-1.csv fleet/unit-2.csv --sensor-id folder",
        2,
        "sensor-of-several",
    );
}
