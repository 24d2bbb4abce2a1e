//! References as files: the recording itself, one of its own, none.

use super::*;

/// A recording of a line with its file.
fn recorded(folder: &Path, extra: &str) -> (Recording, std::path::PathBuf) {
    let path = folder.join("own.csv");
    let mut text = format!("# made for a test\nTimestamp (ms),ax,ay,az{extra}\n");
    for i in 0..1400 {
        let t = 0.01 * f64::from(i);
        let p = place(t);
        // Every fifth row has no position.
        let cells = if extra.is_empty() {
            String::new()
        } else if i % 5 == 0 {
            ",,,".to_owned()
        } else {
            format!(",{:.5},{:.5},{:.5}", 1e3 * p[0], 1e3 * p[1], 1e3 * p[2])
        };
        text.push_str(&format!("{},0.0{},0.0,9.8{cells}\n", 5000 + 10 * i, i % 3));
    }
    std::fs::write(&path, text).unwrap();
    (read(&path, &ReadOptions::default()).unwrap(), path)
}

#[test]
fn columns_of_the_recording_itself_keep_its_clock() {
    let folder = tempfile::tempdir().unwrap();
    let (recording, path) = recorded(folder.path(), ",pos_x_mm,pos_y_mm,pos_z_mm");
    let reference = read_reference(&path, &recording, &path).unwrap();
    assert!(reference.same_file);
    assert_eq!(reference.t_s.len(), 1120);
    assert!((reference.t_s[0] - 0.01).abs() < 1e-12);
    assert_eq!(reference.findings[0].kind, "truth-gaps");
    let mut motion = motion(100.0);
    let c = compared(&mut motion, &reference);
    assert_eq!(c.time_offset_s, 0.0);
    assert!(c.rmse_m < 1e-5, "{c:?}");
}

#[test]
fn a_file_of_its_own_with_other_names_and_stamps() {
    let folder = tempfile::tempdir().unwrap();
    let (recording, path) = recorded(folder.path(), "");
    let mut text = String::from("camera;time [ms];X [mm];Y [mm];Z [mm]\n");
    for i in 0..280 {
        let t = 0.05 * f64::from(i);
        let p = place(t).map(|v| 1e3 * v);
        // Stamps of the recorder itself.
        text.push_str(&format!("1;{};{};{};{}\n", 5000 + 50 * i, p[0], p[1], p[2]));
    }
    text.push_str("1;19000;half");
    let truth = folder.path().join("truth.csv");
    std::fs::write(&truth, text).unwrap();
    let reference = read_reference(&truth, &recording, &path).unwrap();
    assert!(!reference.same_file);
    let mut motion = motion(100.0);
    let c = compared(&mut motion, &reference);
    assert!(c.rmse_m < 2e-3, "{c:?}");
    // The stamps of the recorder begin at 5 s.
    assert!((c.time_offset_s + 5.0).abs() < 2e-3, "{c:?}");
    assert_eq!(kinds(&motion), ["truth-gaps"]);
}

#[test]
fn what_is_no_reference_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (recording, path) = recorded(folder.path(), "");
    let read = |text: &str| {
        let truth = folder.path().join("truth.csv");
        std::fs::write(&truth, text).unwrap();
        let refused = read_reference(&truth, &recording, &path).unwrap_err();
        refused.code()
    };
    for (text, code) in [
        ("", "no-rows"),
        ("a,b\nx,y\n", "no-rows"),
        ("t_s,a,b,c\n0,1,2,3\n1,1,2,3\n", "truth-columns-missing"),
        (
            "t_s,px_mm,py_m,pz_m\n0,1,2,3\n1,1,2,3\n",
            "truth-columns-missing",
        ),
        ("t_s,px_m,py_m,pz_m\n0,1,2,3\n", "truth-time"),
        ("t_s,px_m,py_m,pz_m\n0,1,2,3\n0,1,2,3\n", "truth-time"),
        ("t_s,px_m,py_m,pz_m\n0,1,2,3\n1,1,2,\n2,,,\n", "truth-empty"),
        ("n,px_m,py_m,pz_m\n0,1,2,3\n1,1,2,3\n", "truth-time"),
    ] {
        assert_eq!(read(text), code, "{text}");
    }
    let none = read_reference(&folder.path().join("none"), &recording, &path);
    assert_eq!(none.unwrap_err().code(), "not-found");
}
