//! `--figures DIR` of calibrate and motion.

use std::path::Path;

use crate::motion::line;
use crate::support::*;

/// Every file of a folder is a drawing, XML with something in it.
fn drawings(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for name in listed(folder) {
        let text = read(folder, &name);
        let document = roxmltree::Document::parse(&text).unwrap();
        let series = document
            .descendants()
            .filter(|n| n.attribute("data-mark").is_some());
        assert!(series.count() > 0, "{name}");
        assert!(!text.contains("NaN") && !text.contains("no values"));
        names.push(name.strip_suffix(".svg").unwrap().to_owned());
    }
    names
}

/// A figure that this run does not draw would pass for one of its own.
#[test]
fn a_forced_run_takes_away_what_the_earlier_one_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let plots = path.join("plots");
    line(path);
    let rows = |count: usize, z: &str| -> String {
        let rows = (0..count).map(|i| format!("{},0.1,0.2,{z}\n", 10 * i));
        format!("t_ms,ax,ay,az\n{}", rows.collect::<String>())
    };
    let rest = (0..1200).map(|i| format!("{},0.1,0.2,9.8{}\n", 10 * i, i % 3));
    let rest = format!("t_ms,ax,ay,az\n{}", rest.collect::<String>());
    write(path, "rest.csv", &rest);
    let draw = |what: &str, code: i32| {
        json(path, &format!("{what} --figures plots"), code);
    };
    draw("calibrate poses/poses.csv --gravity 9.80665", 0);
    assert_eq!(drawings(&plots), ["captures", "norm", "sphere"]);
    draw("motion line/line.csv -c cal.json", 2);
    assert_eq!(listed(&plots).len(), 3);
    draw("motion line/line.csv -c cal.json --force", 0);
    let now = drawings(&plots);
    assert!(now.contains(&"trajectory".to_owned()) && !now.contains(&"norm".to_owned()));
    draw("motion rest.csv --force", 0);
    let now = drawings(&plots);
    assert!(now.contains(&"acceleration".to_owned()), "{now:?}");
    assert!(!now.contains(&"trajectory".to_owned()), "{now:?}");
    // Files of somebody else stay, whatever they are called.
    for name in ["notes.txt", "norm.svg"] {
        write(&plots, name, "mine");
    }
    draw("motion line/line.csv --force", 0);
    let now = listed(&plots);
    for name in ["norm.svg", "notes.txt", "trajectory.svg"] {
        assert!(now.contains(&name.to_owned()), "{now:?}");
    }
    write(&plots, "position.svg", "mine");
    draw("motion line/line.csv --force", 2);
    assert_eq!(read(&plots, "position.svg"), "mine");

    // Recordings with hardly anything in them.
    for (name, text) in [
        ("one", rows(1, "9.81")),
        ("nan", rows(600, "")),
        ("constant", rows(600, "9.81")),
        ("huge", rows(600, "9.8e60")),
    ] {
        write(path, &format!("{name}.csv"), &text);
        let line = format!("motion {name}.csv --figures {name} --json --quiet");
        let run = run_in(path, words(&line));
        if path.join(name).exists() {
            drawings(&path.join(name));
        } else {
            assert!([2, 3].contains(&run.code), "{name}: {}{}", run.out, run.err);
        }
    }
}
