use super::super::{Axis, Panel, Role, Series};
use super::*;

const SVG: Formats = Formats { png: false };
const MOTION: Run<'static> = Run {
    verb: "motion",
    command: Some("gravical motion a.csv --figures plots"),
};
const CALIBRATE: Run<'static> = Run {
    verb: "calibrate",
    command: None,
};

fn figure(name: &str) -> Figure {
    let line = Series::line("a", Role::Raw, vec![0.0, 1.0], vec![0.0, 1.0]);
    let panel = Panel::new(Axis::new("time", "s"), Axis::new("way", "m")).with(line);
    Figure::new(name, "A figure", "").with(panel)
}

fn draw(names: &[&str], folder: &Path, run: Run<'_>, force: bool) -> Result<Written> {
    let figures: Vec<Figure> = names.iter().map(|n| figure(n)).collect();
    write_figures(&figures, folder, run, SVG, force)
}

fn names(paths: &[PathBuf]) -> Vec<String> {
    let name = |p: &PathBuf| p.file_name().unwrap().to_str().unwrap().to_owned();
    paths.iter().map(name).collect()
}

fn listed(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut all = names(&entries.map(|e| e.unwrap().path()).collect::<Vec<_>>());
    all.sort();
    all
}

fn manifest(folder: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(folder.join(MANIFEST)).unwrap()).unwrap()
}

#[test]
fn files_are_written_once() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("plots");
    let done = draw(&["a", "b"], &inner, MOTION, false).unwrap();
    assert_eq!(names(&done.files), ["a.svg", "a.csv", "b.svg", "b.csv"]);
    assert!(done.files.iter().all(|f| f.is_file()));
    let again = draw(&["b"], &inner, MOTION, false).unwrap_err();
    assert_eq!(again.code(), "exists");
    assert!(check_figures(&inner, &["c"], SVG, false).is_ok());
    let csv = std::fs::read_to_string(inner.join("b.csv")).unwrap();
    assert_eq!(csv.lines().nth(1), Some("panel,series,x,y,low,high,label"));
    assert_eq!(csv.lines().nth(3), Some("1,a,1,1,,,"));
}

#[test]
fn what_an_earlier_run_left_is_taken_away_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    draw(&["a", "b", "c"], at, MOTION, false).unwrap();
    // Somebody's own, under a name that a figure could have, and an edited figure.
    std::fs::write(at.join("mine.svg"), "mine").unwrap();
    std::fs::write(at.join("c.svg"), "drawn over").unwrap();
    let done = draw(&["a"], at, MOTION, true).unwrap();
    assert_eq!(names(&done.removed), ["b.svg", "b.csv", "c.csv"]);
    assert_eq!(names(&done.kept), ["c.svg"]);
    let left = ["a.csv", "a.svg", "c.svg", MANIFEST, "mine.svg"];
    assert_eq!(listed(at), left);
    // It is said again, and never removed.
    let again = draw(&["a"], at, MOTION, true).unwrap();
    assert_eq!(
        (again.removed.len(), names(&again.kept)),
        (0, vec!["c.svg".to_owned()])
    );
    assert_eq!(listed(at), left);
}

#[test]
fn runs_of_another_kind_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    draw(&["norm", "budget"], at, CALIBRATE, false).unwrap();
    // Replaces `budget`, which is this run's from now on.
    draw(&["velocity", "budget"], at, MOTION, true).unwrap();
    let runs = manifest(at);
    let files = |run: usize| runs["runs"][run]["files"].as_array().unwrap().len();
    assert_eq!((files(0), files(1)), (2, 4));
    assert_eq!(
        runs["runs"][1]["command"],
        "gravical motion a.csv --figures plots"
    );
    let done = draw(&["sphere"], at, CALIBRATE, true).unwrap();
    assert_eq!(names(&done.removed), ["norm.svg", "norm.csv"]);
    assert!(at.join("budget.svg").is_file() && at.join("velocity.csv").is_file());
}

#[test]
fn without_force_nothing_is_removed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    draw(&["a", "b"], at, MOTION, false).unwrap();
    for ending in ["svg", "csv"] {
        std::fs::remove_file(at.join(format!("a.{ending}"))).unwrap();
    }
    let done = draw(&["a"], at, MOTION, false).unwrap();
    assert_eq!((done.removed.len(), done.kept.len()), (0, 2));
    // It is still known whose they are.
    let done = draw(&["a"], at, MOTION, true).unwrap();
    assert_eq!(names(&done.removed), ["b.svg", "b.csv"]);
    assert_eq!(manifest(at)["runs"].as_array().unwrap().len(), 1);
}

#[test]
fn a_list_of_somebody_else_leads_nowhere() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("plots");
    let outside = folder.path().join("cal.csv");
    std::fs::write(&outside, "x").unwrap();
    draw(&["a", "b"], &at, MOTION, false).unwrap();
    // Names of files elsewhere, with the right sum; a link to one of them.
    let text = std::fs::read_to_string(at.join(MANIFEST)).unwrap();
    let sum = "2d711642b726b04401627ca9fbac32f5c8530fb1903cc4db02258717921a4881";
    let first = text.split("\"sha256\": \"").nth(1).unwrap();
    let text = text
        .replace("a.svg", "../cal.csv")
        .replace(first.split('"').next().unwrap(), sum);
    std::fs::write(at.join(MANIFEST), text).unwrap();
    #[cfg(unix)]
    {
        std::fs::remove_file(at.join("b.csv")).unwrap();
        std::os::unix::fs::symlink(&outside, at.join("b.csv")).unwrap();
    }
    draw(&["c"], &at, MOTION, true).unwrap();
    assert!(outside.is_file());
    #[cfg(unix)]
    assert!(at.join("b.csv").is_symlink());
}

#[test]
fn a_list_that_is_none_is_not_replaced_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for text in ["", "{", "[]", "{\"format\":\"other/1\",\"runs\":[]}"] {
        std::fs::write(at.join(MANIFEST), text).unwrap();
        let error = check_figures(at, &["a"], SVG, false).unwrap_err();
        assert_eq!(error.code(), "exists", "{text}");
        let _ = std::fs::remove_file(at.join("a.svg"));
        let _ = std::fs::remove_file(at.join("a.csv"));
        assert!(draw(&["a"], at, MOTION, false).is_err());
        draw(&["a"], at, MOTION, true).unwrap();
        assert_eq!(manifest(at)["format"], "gravical-figures/1");
    }
    std::fs::remove_file(at.join(MANIFEST)).unwrap();
    std::fs::create_dir(at.join(MANIFEST)).unwrap();
    assert!(draw(&["a"], at, MOTION, true).is_err());
}

#[test]
fn folders_that_cannot_be() {
    let folder = tempfile::tempdir().unwrap();
    let deep = folder.path().join("a/b");
    assert_eq!(
        check_figures(&deep, &[], SVG, true).unwrap_err().code(),
        "no-folder"
    );
    let file = folder.path().join("file");
    std::fs::write(&file, "x").unwrap();
    assert_eq!(
        check_figures(&file, &[], SVG, true).unwrap_err().code(),
        "no-folder"
    );
}

#[test]
fn png_is_a_picture_or_says_how_to_have_it() {
    let folder = tempfile::tempdir().unwrap();
    let png = Formats { png: true };
    let done = write_figures(&[figure("a")], folder.path(), MOTION, png, false);
    if cfg!(feature = "png") {
        let bytes = std::fs::read(folder.path().join("a.png")).unwrap();
        assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 4000);
        assert_eq!(done.unwrap().files.len(), 3);
        // Not asked for any more: it would show what was drawn before.
        let done = draw(&["a"], folder.path(), MOTION, true).unwrap();
        assert_eq!(names(&done.removed), ["a.png"]);
    } else {
        let error = done.unwrap_err();
        assert_eq!(error.code(), "no-png");
        assert!(error.hint().unwrap().contains("--features png"));
    }
}
