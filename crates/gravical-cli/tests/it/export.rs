//! `gravical export`: the list, files and notes. What the files contain is tested in the library.

use crate::support::*;

#[test]
fn a_file_is_written_once_and_what_is_lost_goes_to_standard_error() {
    let folder = six_files(&Sensor::default());
    let path = folder.path();
    calibrate(path, ". --gravity 9.81 -o cal.json", 0);
    let line = "export cal.json --to ros";
    let first = ends(path, &format!("{line} -o a.yaml"), 0);
    assert!(first.out.is_empty() && first.err.contains("note: Without the gyroscope"));
    let text = read(path, "a.yaml");
    // What stderr says is in the file, too; it is the same on standard output.
    assert!(text.contains("Without the gyroscope"), "{text}");
    assert_eq!(ends(path, line, 0).out, text);
    for (line, exit, said) in [
        ("export cal.json --to ros -o a.yaml", 2, "exists"),
        ("export cal.json --to kalibr", 3, "gravical noise"),
        ("export cal.json --to cobol", 2, "arduino"),
        ("export cal.json --to c --upper-limit", 2, "error: "),
        ("export --to c", 2, "gravical export cal.json --to c"),
    ] {
        let err = ends(path, line, exit).err;
        assert!(err.contains(said), "{line}: {err}");
    }
    // The list needs no calibration.
    let list = ends(path, "export --to list", 0).out;
    for target in ["c", "arduino", "rust", "python", "ros", "gravical"] {
        assert!(list.lines().any(|l| l.split(' ').next() == Some(target)));
    }
}
