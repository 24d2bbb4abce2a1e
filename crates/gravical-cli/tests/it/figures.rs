//! `--figures`: each figure as a file.

use std::path::Path;

use crate::motion::line;
use crate::support::*;

/// Every file of a folder is a drawing, XML with something in it.
fn drawings(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for name in listed(folder) {
        let text = std::fs::read_to_string(folder.join(&name)).unwrap();
        let stem = name.strip_suffix(".svg").unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        let mut nodes = document.descendants();
        let is_drawn = nodes.any(|n| n.has_tag_name("path"));
        let is_whole = !text.contains("NaN") && !text.contains("inf");
        assert!(is_drawn && is_whole, "{name}");
        names.push(stem.to_owned());
    }
    names
}

#[test]
fn a_calibration_is_drawn() {
    let folder = six_files(&Sensor::default());
    let path = folder.path();
    ends(path, "calibrate . --figures plots --json", 0);
    let drawn = drawings(&path.join("plots"));
    assert_eq!(drawn, ["errors", "more-poses", "recording", "sphere"]);
    let forced = ends(path, "calibrate . --figures plots --force --quiet", 0);
    assert_eq!(forced.err, "");
}

/// A figure that this run does not draw would pass for one of its own.
#[test]
fn a_forced_run_takes_away_what_the_earlier_one_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let plots = path.join("plots");
    line(path);
    let rows = (0..1200).map(|i| format!("{},0.1,0.2,9.8{}\n", 10 * i, i % 3));
    let rest = format!("t_ms,ax,ay,az\n{}", rows.collect::<String>());
    write(path, "rest.csv", &rest);
    let draw = |what: &str, code: i32| {
        json(path, &format!("motion {what} --figures plots"), code);
    };
    draw("line/line.csv -c cal.json", 0);
    assert!(drawings(&plots).contains(&"path".to_owned()));
    let before = listed(&plots);
    draw("rest.csv", 2);
    assert_eq!(listed(&plots), before);
    draw("rest.csv --force", 0);
    let now = drawings(&plots);
    assert!(now.contains(&"acceleration".to_owned()), "{now:?}");
    assert!(!now.contains(&"path".to_owned()), "{now:?}");
    // Files of somebody else stay, whatever they are called.
    for name in ["notes.txt", "errors.svg"] {
        write(&plots, name, "mine");
    }
    draw("line/line.csv --force", 0);
    for name in ["errors.svg", "path.svg", "notes.txt"] {
        assert!(plots.join(name).is_file(), "{name}");
    }
    write(&plots, "position.svg", "mine");
    draw("line/line.csv --force", 2);
    assert_eq!(read(&plots, "position.svg"), "mine");
}

#[test]
fn recordings_with_hardly_anything_in_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (name, count, z) in [
        ("one", 1, "9.81"),
        ("nan", 600, ""),
        ("constant", 600, "9.81"),
        ("huge", 600, "9.8e60"),
    ] {
        let rows = (0..count).map(|i| format!("{},0.1,0.2,{z}\n", 10 * i));
        let text = format!("t_ms,ax,ay,az\n{}", rows.collect::<String>());
        write(path, &format!("{name}.csv"), &text);
        let line = format!("motion {name}.csv --figures {name} --json --quiet");
        let run = run_in(path, words(&line));
        let plots = path.join(name);
        if plots.exists() {
            drawings(&plots);
        } else {
            assert!([2, 3].contains(&run.code), "{name}: {}{}", run.out, run.err);
        }
    }
    assert!(path.join("constant/acceleration.svg").is_file());
}
