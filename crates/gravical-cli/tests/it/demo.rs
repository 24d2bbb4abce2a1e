//! `gravical demo`: what a stranger runs first.

use std::fs;
use std::path::Path;

use crate::support::*;

fn example(name: &str) -> Vec<u8> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/demo");
    fs::read(root.join(name)).unwrap()
}

#[test]
fn it_calibrates_moves_and_reports() {
    let folder = tempfile::tempdir().unwrap();
    let run = ends(folder.path(), "demo", 0);

    // Everything is there, and the recordings are those of the examples. README.md has the numbers.
    let said = format!("{}{}", run.out, run.err);
    let at = folder.path().join("gravical-demo");
    for name in [
        "calibration.json",
        "calibration.html",
        "track.csv",
        "motion.html",
    ] {
        assert!(fs::metadata(at.join(name)).unwrap().len() > 1000, "{name}");
        assert!(said.contains(&format!("gravical-demo/{name}")), "{said}");
    }
    for name in ["poses/poses.csv", "line/line.csv"] {
        let made = fs::read(at.join(name)).unwrap();
        assert!(made == example(name), "{name}");
    }
    let page = fs::read_to_string(at.join("motion.html")).unwrap();
    assert!(page.len() < 2_000_000 && page.contains("<svg"));
}

#[test]
fn nothing_of_an_earlier_run_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let first = ends(at, "demo -o here", 0).out;
    assert!(first.contains("Verdict: good") && first.contains("here/motion.html"));
    let before = read(at, "here/motion.html");
    fs::remove_file(at.join("here/poses/poses.csv")).unwrap();

    fails(at, "demo -o here", 2, "exists");
    let made = at.join("here/poses/poses.csv").exists();
    assert!(!made, "refused before it writes");
    assert!(read(at, "here/motion.html") == before);
    ends(at, "demo -o here --force", 0);
    // Without a name it takes the next number.
    for written in ["gravical-demo/motion.html", "gravical-demo-2/motion.html"] {
        ends(at, "demo", 0);
        assert!(at.join(written).is_file());
    }
}

/// The README shows a figure of the demo. `GRAVICAL_BLESS=1` writes it anew.
#[test]
fn the_figure_of_the_readme_is_what_the_demo_draws() {
    let folder = tempfile::tempdir().unwrap();
    for line in [
        "demo -o here",
        "motion here/line/line.csv -c here/calibration.json --report r.md --json --quiet",
    ] {
        ends(folder.path(), line, 0);
    }
    let drawn = fs::read_to_string(folder.path().join("r_figures/position.svg")).unwrap();
    let shown = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/images/position.svg");
    if std::env::var_os("GRAVICAL_BLESS").is_some() {
        fs::write(&shown, &drawn).unwrap();
    }
    assert!(
        drawn == fs::read_to_string(&shown).unwrap(),
        "docs/images/position.svg is stale; GRAVICAL_BLESS=1 rewrites it"
    );
}
