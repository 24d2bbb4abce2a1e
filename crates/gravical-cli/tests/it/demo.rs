//! `gravical demo`: what a stranger runs first.

use std::fs;
use std::path::Path;

use crate::support::*;

#[test]
fn it_calibrates_moves_and_reports_and_nothing_of_an_earlier_run_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let run = ends(at, "demo", 0);
    // Everything is there, and the recordings are those of the examples. README.md has the numbers.
    let said = format!("{}{}", run.out, run.err);
    for name in [
        "calibration.json",
        "calibration.html",
        "track.csv",
        "motion.html",
    ] {
        let name = format!("gravical-demo/{name}");
        assert!(
            read(at, &name).len() > 1000 && said.contains(&name),
            "{said}"
        );
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for name in ["poses/poses.csv", "line/line.csv"] {
        let made = fs::read(at.join("gravical-demo").join(name)).unwrap();
        assert!(made == fs::read(root.join("examples/demo").join(name)).unwrap());
    }
    let page = read(at, "gravical-demo/motion.html");
    assert!(page.len() < 2_000_000 && page.contains("<svg"));

    // Without a name it takes the next number.
    ends(at, "demo", 0);
    assert!(at.join("gravical-demo-2/motion.html").is_file());
    let made = at.join("gravical-demo/poses/poses.csv");
    fs::remove_file(&made).unwrap();
    fails(at, "demo -o gravical-demo", 2, "exists");
    assert!(!made.exists(), "refused before it writes");
    assert!(read(at, "gravical-demo/motion.html") == page);
    ends(at, "demo -o gravical-demo --force", 0);

    // The README shows a figure of the demo. `GRAVICAL_BLESS=1` writes it anew.
    let line = "motion gravical-demo/line/line.csv -c gravical-demo/calibration.json --figures figures -q --json";
    ends(at, line, 0);
    let drawn = read(at, "figures/position.svg");
    let shown = root.join("docs/images/position.svg");
    if std::env::var_os("GRAVICAL_BLESS").is_some() {
        fs::write(&shown, &drawn).unwrap();
    }
    assert!(
        drawn == fs::read_to_string(&shown).unwrap(),
        "docs/images/position.svg is stale; GRAVICAL_BLESS=1 rewrites it"
    );
}
