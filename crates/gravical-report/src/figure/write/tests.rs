use super::super::{Axis, Panel, Role, Series};
use super::*;

const BOTH: Formats = Formats {
    csv: true,
    png: false,
};

fn figure(name: &str) -> Figure {
    let line = Series::line("a", Role::Raw, vec![0.0, 1.0], vec![0.0, 1.0]);
    let panel = Panel::new(Axis::new("time", "s"), Axis::new("way", "m")).with(line);
    Figure::new(name, "A figure", "").with(panel)
}

fn draw(names: &[&str], folder: &Path, force: bool) -> Result<usize> {
    let figures: Vec<Figure> = names.iter().map(|n| figure(n)).collect();
    write_figures(&figures, folder, BOTH, force)
}

fn listed(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut all: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    all.sort();
    all
}

#[test]
fn a_folder_holds_the_figures_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("plots");
    assert_eq!(draw(&["norm", "budget"], &inner, false).unwrap(), 4);
    let all = ["budget.csv", "budget.svg", "norm.csv", "norm.svg"];
    assert_eq!(listed(&inner), all);
    let csv = std::fs::read_to_string(inner.join("norm.csv")).unwrap();
    assert_eq!(csv.lines().nth(1), Some("panel,series,x,y,low,high,label"));
    assert_eq!(csv.lines().nth(3), Some("1,a,1,1,,,"));
    // Whatever the next ones are called.
    assert_eq!(draw(&["tilt"], &inner, false).unwrap_err().code(), "exists");
    assert_eq!(draw(&["velocity"], &inner, true).unwrap(), 2);
    assert_eq!(listed(&inner), ["velocity.csv", "velocity.svg"]);
}

#[test]
fn nothing_foreign_is_touched() {
    for name in ["notes.txt", "mine.svg", "norm.svg.bak", "norm.SVG", "norm"] {
        let folder = tempfile::tempdir().unwrap();
        draw(&["norm"], folder.path(), false).unwrap();
        std::fs::write(folder.path().join(name), "mine").unwrap();
        let before = listed(folder.path());
        let error = draw(&["tilt"], folder.path(), true).unwrap_err();
        assert_eq!(error.code(), "foreign-files", "{name}");
        assert!(error.to_string().contains(name), "{error}");
        assert_eq!(listed(folder.path()), before);
    }
    // A folder or a link that is called like a figure is none.
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("norm.svg")).unwrap();
    assert_eq!(
        draw(&["tilt"], folder.path(), true).unwrap_err().code(),
        "foreign-files"
    );
    #[cfg(unix)]
    {
        let folder = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink("/nowhere", folder.path().join("norm.svg")).unwrap();
        assert_eq!(
            draw(&["norm"], folder.path(), true).unwrap_err().code(),
            "foreign-files"
        );
    }
}

#[test]
fn folders_that_cannot_be() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "x").unwrap();
    for path in [folder.path().join("a/b"), file] {
        let error = check_figures(&path, BOTH, true).unwrap_err();
        assert_eq!(error.code(), "no-folder");
    }
}

#[test]
fn png_is_a_picture_or_says_how_to_have_it() {
    let folder = tempfile::tempdir().unwrap();
    let png = Formats { png: true, ..BOTH };
    let done = write_figures(&[figure("norm")], folder.path(), png, false);
    if cfg!(feature = "png") {
        let bytes = std::fs::read(folder.path().join("norm.png")).unwrap();
        assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 4000);
        assert_eq!(done.unwrap(), 3);
    } else {
        let error = done.unwrap_err();
        assert_eq!(error.code(), "no-png");
        assert!(error.hint().unwrap().contains("--features png"));
    }
}
