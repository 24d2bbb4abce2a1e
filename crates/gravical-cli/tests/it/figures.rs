//! `--figures DIR` of calibrate and motion.

use std::path::Path;

use crate::motion::line;
use crate::support::*;

const CALIBRATION: [&str; 6] = ["norm", "residuals", "sphere", "tilt", "captures", "noise"];

/// Every file of a folder by name.
fn listed(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Every file of a folder is a drawing, XML with something in it.
fn drawings(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for name in listed(folder) {
        let text = std::fs::read_to_string(folder.join(&name)).unwrap();
        let stem = name.strip_suffix(".svg").unwrap();

        let document = roxmltree::Document::parse(&text).unwrap();
        let series = document
            .descendants()
            .filter(|n| n.attribute("data-mark").is_some());
        assert!(series.count() > 0, "{name}");
        assert!(
            !text.contains("NaN") && !text.contains("no values"),
            "{name}"
        );
        names.push(stem.to_owned());
    }
    names
}

#[test]
fn a_calibration_is_drawn_once_and_not_over_what_is_there() {
    let folder = six_files(&Sensor::default());
    let path = folder.path();
    let run = run_in(path, words("calibrate . --figures plots --json"));
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(
        run.err.contains("6 figures in plots: norm, residuals"),
        "{}",
        run.err
    );
    let names = drawings(&path.join("plots"));
    for name in CALIBRATION {
        assert!(
            names.iter().any(|n| n == name),
            "{name} is not among {names:?}"
        );
    }

    // Two results in one place.
    let line = "calibrate . --report plots.md -o plots --figures plots --force --json";
    let run = run_in(path, words(line));
    let codes = ["same-target", "is-folder"];
    assert!(
        run.code == 2 && codes.contains(&run.error_code().as_str()),
        "{}",
        run.out
    );
    // Before the work: nothing but the refusal.
    let again = run_in(path, words("calibrate absent.csv --figures plots"));
    assert_eq!(again.code, 2);
    assert!(again.err.contains("exists"), "{}", again.err);
    let forced = run_in(path, words("calibrate . --figures plots --force --quiet"));
    assert_eq!((forced.code, forced.err.as_str()), (0, ""));
}

/// A figure that this run does not draw would pass for one of its own.
#[test]
fn a_forced_run_takes_away_what_the_earlier_one_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    write(path, "rest.csv", &{
        let rows = (0..1200).map(|i| format!("{},0.1,0.2,9.8{}\n", 10 * i, i % 3));
        format!("t_ms,ax,ay,az\n{}", rows.collect::<String>())
    });
    let draw = |what: &str, code: i32| {
        let run = run_in(path, words(&format!("{what} --figures plots --json")));
        assert_eq!(run.code, code, "{}{}", run.out, run.err);
    };
    draw("motion line/line.csv -c cal.json", 0);
    let before = listed(&path.join("plots"));
    assert!(before.contains(&"trajectory.svg".to_owned()));
    draw("motion rest.csv", 2);
    assert_eq!(listed(&path.join("plots")), before);
    draw("motion rest.csv --force", 0);
    let now = listed(&path.join("plots"));
    assert!(now.contains(&"acceleration.svg".to_owned()), "{now:?}");
    assert!(!now.contains(&"trajectory.svg".to_owned()), "{now:?}");
    write(&path.join("plots"), "notes.txt", "mine");
    draw("motion line/line.csv --force", 0);
    let now = listed(&path.join("plots"));
    assert!(now.contains(&"trajectory.svg".to_owned()), "{now:?}");
    assert!(now.contains(&"notes.txt".to_owned()), "{now:?}");
}

#[test]
fn folders_that_cannot_be_written() {
    let folder = six_files(&Sensor::default());
    let path = folder.path();
    write(path, "file", "x");
    for (to, code) in [("file", "no-folder"), ("a/b", "no-folder")] {
        let run = run_in(path, words(&format!("calibrate . --figures {to} --json")));
        assert_eq!((run.code, run.error_code().as_str()), (2, code));
    }
    assert!(!path.join("a").exists());
}

#[test]
fn a_motion_is_drawn_with_the_uncalibrated_one_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let run = run_in(
        path,
        words("motion line/line.csv -c cal.json --figures plots --json"),
    );
    assert_eq!(run.code, 0, "{}", run.err);
    let names = drawings(&path.join("plots"));
    let wanted = [
        "acceleration",
        "motion-acceleration",
        "position-3d",
        "position",
        "trajectory",
        "velocity",
    ];
    assert_eq!(names, wanted, "by their file names");
}

#[test]
fn recordings_with_hardly_anything_in_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write(path, "one.csv", "t_ms,ax,ay,az\n0,0,0,9.81\n");
    let rows = |z: &str| -> String {
        let rows = (0..600).map(|i| format!("{},0.1,0.2,{z}\n", 10 * i));
        format!("t_ms,ax,ay,az\n{}", rows.collect::<String>())
    };
    write(path, "nan.csv", &rows(""));
    write(path, "constant.csv", &rows("9.81"));
    for name in ["one", "nan", "constant"] {
        let run = run_in(
            path,
            words(&format!(
                "motion {name}.csv --figures {name} --json --quiet"
            )),
        );
        let plots = path.join(name);
        if plots.exists() {
            drawings(&plots);
        } else {
            assert!(
                run.code == 3 || run.code == 2,
                "{name}: {}{}",
                run.out,
                run.err
            );
        }
    }
    assert!(path.join("constant/acceleration.svg").is_file());
}

#[test]
fn real_recordings_are_drawn() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let d = data.display();
    for (line, count) in [
        (format!("calibrate {d}/imu_tk-xsens/xsens_acc.txt.gz"), 6),
        (format!("calibrate {d}/airbrakes-sixmoves"), 6),
        (format!("motion {d}/pabrod-elevator/skyscrapper_up.csv"), 6),
        (format!("motion {d}/xio-gait/short_walk.csv"), 6),
    ] {
        let run = run_in(
            path,
            words(&format!("{line} --figures plots --force --json --quiet")),
        );
        assert!(
            run.code == 0 || run.code == 4,
            "{line}\n{}{}",
            run.out,
            run.err
        );
        let names = drawings(&path.join("plots"));
        assert!(names.len() >= count, "{line}: {names:?}");
        std::fs::remove_dir_all(path.join("plots")).unwrap();
    }
}
