//! `gravical export`: the list, files and notes. What the files contain is tested in the library.

use crate::support::*;

#[test]
fn the_list_explains_every_target_and_needs_no_calibration() {
    let list = run(words("export --to list")).out;
    for target in ["c", "arduino", "rust", "python", "ros", "gravical"] {
        let mut names = list.lines().filter_map(|l| l.split(' ').next());
        assert!(names.any(|name| name == target), "{list}");
    }
    assert!(list.lines().all(|l| l.len() > 30), "{list}");
    let nothing = run(words("export --to c"));
    assert_eq!(nothing.code, 2);
    assert!(nothing.err.contains("gravical export cal.json --to c"));
    let unknown = run(words("export cal.json --to cobol"));
    assert_eq!(unknown.code, 2);
    assert!(unknown.err.contains("arduino"), "{}", unknown.err);
}

/// What a target cannot hold is said on standard error, and in the file.
#[test]
fn what_is_lost_goes_to_standard_error() {
    let folder = demo();
    let line = "export d/calibration.json --to ros";
    let printed = ends(folder.path(), line, 0);
    assert!(printed.out.contains("Without the gyroscope"));
    let written = ends(folder.path(), &format!("{line} -o a.yaml"), 0);
    assert!(written.err.contains("note: Without the gyroscope"));
    assert!(written.out.is_empty() && read(folder.path(), "a.yaml") == printed.out);
    let refused = ends(folder.path(), "export d/calibration.json --to kalibr", 3).err;
    assert!(refused.contains("gravical noise"), "{refused}");
}
