//! `gravical demo`: what a stranger runs first.

use std::fs;
use std::path::Path;

use crate::support::*;

fn example(name: &str) -> Vec<u8> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/demo");
    fs::read(root.join(name)).unwrap()
}

#[test]
fn it_calibrates_moves_and_reports_and_loses_nothing_of_an_earlier_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let run = ends(at, "demo", 0);

    // Everything is there, and the recordings are those of the examples. README.md has the numbers.
    let said = format!("{}{}", run.out, run.err);
    for name in words("calibration.json calibration.html track.csv motion.html") {
        let name = format!("gravical-demo/{name}");
        let is_there = read(at, &name).len() > 1000 && said.contains(&native(&name));
        assert!(is_there, "{said}");
    }
    for name in ["poses/poses.csv", "line/line.csv"] {
        let made = fs::read(at.join("gravical-demo").join(name)).unwrap();
        assert!(made == example(name), "{name}");
    }
    let page = read(at, "gravical-demo/motion.html");
    assert!(page.len() < 2_000_000 && page.contains("<svg"));

    fs::remove_file(at.join("gravical-demo/poses/poses.csv")).unwrap();
    let again = ends(at, "demo -o gravical-demo", 2).err;
    assert!(again.contains("code: exists"), "{again}");
    let made = at.join("gravical-demo/poses/poses.csv").exists();
    assert!(!made, "refused before it writes");
    assert!(read(at, "gravical-demo/motion.html") == page);
    ends(at, "demo -o gravical-demo --force", 0);
    // Without a name it takes the next number.
    ends(at, "demo", 0);
    assert!(at.join("gravical-demo-2/motion.html").is_file());
}
