use super::super::{Axis, Panel, Role, Series};
use super::*;

fn figure(name: &str) -> Figure {
    let line = Series::line("a", Role::Raw, vec![0.0, 1.0], vec![0.0, 1.0]);
    let panel = Panel::new(Axis::new("time", "s"), Axis::new("way", "m")).with(line);
    Figure::new(name, "A figure", "").with(panel)
}

fn draw(names: &[&str], folder: &Path, force: bool) -> Result<()> {
    let figures: Vec<Figure> = names.iter().map(|n| figure(n)).collect();
    write_figures(&figures, folder, force)
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
