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
    let reference = read_reference(&path, None, &recording, &path).unwrap();
    assert!(reference.same_file);
    assert_eq!(reference.unit, Some(LengthUnit::Millimetre));
    assert_eq!(reference.t_s.len(), 1120);
    assert!((reference.t_s[0] - 0.01).abs() < 1e-12);
    assert_eq!(reference.findings[0].kind, "truth-gaps");
    let mut motion = motion(100.0);
    let c = compared(&mut motion, &reference, &TruthOptions::default());
    assert_eq!(c.time_offset_s, 0.0);
    assert!(c.rmse_m < 1e-5, "{c:?}");
}

#[test]
fn a_file_of_its_own_with_other_names_and_stamps() {
    let folder = tempfile::tempdir().unwrap();
    let (recording, path) = recorded(folder.path(), "");
    let mut text = String::from("camera;when [ms];X;Y;Z\n");
    for i in 0..280 {
        let t = 0.05 * f64::from(i);
        let p = place(t).map(|v| 1e3 * v);
        // Stamps of the recorder itself.
        text.push_str(&format!("1;{};{};{};{}\n", 5000 + 50 * i, p[0], p[1], p[2]));
    }
    text.push_str("1;19000;half");
    let truth = folder.path().join("truth.csv");
    std::fs::write(&truth, text).unwrap();
    let columns: TruthColumns = "t=when [ms],px=x,py=Y,pz=Z".parse().unwrap();
    let reference = read_reference(&truth, Some(&columns), &recording, &path).unwrap();
    assert!(!reference.same_file);
    let mut motion = motion(100.0);
    let c = compared(&mut motion, &reference, &TruthOptions::default());
    assert!(c.rmse_m < 2e-3, "{c:?}");
    // The stamps of the recorder begin at 5 s.
    assert!((c.time_offset_s + 5.0).abs() < 2e-3, "{c:?}");
    assert!(
        kinds(&motion).contains(&"truth-unit"),
        "{:?}",
        kinds(&motion)
    );
    assert!(
        kinds(&motion).contains(&"truth-lines"),
        "{:?}",
        kinds(&motion)
    );
    let given = TruthOptions {
        offset_s: Some(-5.0),
        ..TruthOptions::default()
    };
    let c = compared(&mut motion, &reference, &given);
    assert_eq!(c.time_offset_s, -5.0);
    assert!(c.rmse_m < 1e-4, "{c:?}");
}

#[test]
fn what_is_no_reference_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (recording, path) = recorded(folder.path(), "");
    let read = |text: &str, columns: Option<&str>| {
        let truth = folder.path().join("truth.csv");
        std::fs::write(&truth, text).unwrap();
        let columns: Option<TruthColumns> = columns.map(|c| c.parse().unwrap());
        read_reference(&truth, columns.as_ref(), &recording, &path)
            .unwrap_err()
            .code()
    };
    assert_eq!(read("", None), "no-rows");
    assert_eq!(read("a,b\nx,y\n", None), "no-rows");
    assert_eq!(
        read("t_s,a,b,c\n0,1,2,3\n1,1,2,3\n", None),
        "truth-columns-missing"
    );
    assert_eq!(read("t_s,px_m,py_m,pz_m\n0,1,2,3\n", None), "truth-time");
    assert_eq!(
        read("t_s,px_m,py_m,pz_m\n0,1,2,3\n0,1,2,3\n", None),
        "truth-time"
    );
    assert_eq!(
        read("t_s,px_m,py_m,pz_m\n0,1,2,3\n1,1,2,\n2,,,\n", None),
        "truth-empty"
    );
    assert_eq!(
        read("n,px_m,py_m,pz_m\n0,1,2,3\n1,1,2,3\n", None),
        "truth-time"
    );
    assert_eq!(
        read(
            "t_s,px,py,pz\n0,1,2,3\n1,1,2,3\n",
            Some("px=px,py=py,pz=nope")
        ),
        "truth-columns-missing"
    );
    assert_eq!(
        read_reference(&folder.path().join("none"), None, &recording, &path)
            .unwrap_err()
            .code(),
        "not-found"
    );
    for wrong in ["", "px=a", "px=a,py=b,pq=c", "a,b,c", "px=a,py=b,pz"] {
        let error = wrong.parse::<TruthColumns>().unwrap_err();
        assert_eq!(error.code(), "truth-columns", "{wrong}");
    }
}
