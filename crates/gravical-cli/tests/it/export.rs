//! `gravical export`: the list, files and notes. What the files contain is tested in the library.

use crate::support::*;

#[test]
fn the_list_explains_every_target_and_needs_no_calibration() {
    let list = run(words("export --to list"));
    assert_eq!(list.code, 0, "{}", list.err);
    let names: Vec<&str> = list
        .out
        .lines()
        .filter_map(|l| l.split(' ').next())
        .collect();
    for target in ["c", "arduino", "rust", "python", "ros", "gravical"] {
        assert!(names.contains(&target), "{}", list.out);
    }
    assert!(list.out.lines().all(|l| l.len() > 30), "{}", list.out);
    let nothing = run(words("export --to c"));
    assert_eq!(nothing.code, 2);
    assert!(nothing.err.contains("gravical export cal.json --to c"));
    let unknown = run(words("export cal.json --to cobol"));
    assert_eq!(unknown.code, 2);
    assert!(unknown.err.contains("arduino"), "{}", unknown.err);
}

#[test]
fn a_file_is_written_once_and_what_is_lost_goes_to_standard_error() {
    let folder = demo();
    let path = folder.path();
    std::fs::rename(path.join("d/calibration.json"), path.join("cal.json")).unwrap();
    let line = "export cal.json --to ros -o a.yaml";
    let first = ends(path, line, 0);
    assert!(first.out.is_empty() && first.err.contains("note: Without the gyroscope"));
    let text = std::fs::read_to_string(path.join("a.yaml")).unwrap();
    // What stderr says is in the file, too; it is the same on standard output.
    assert!(text.contains("Without the gyroscope"), "{text}");
    let printed = run_in(path, words(line.strip_suffix(" -o a.yaml").unwrap()));
    assert_eq!(printed.out, text);
    ends(path, line, 2);
    ends(path, &format!("{line} --force"), 0);
    // Nothing replaces the calibration that it is made from.
    let own = run_in(path, words("export cal.json --to c -o cal.json --force"));
    assert!(
        own.code == 2 && own.err.contains("target-is-input"),
        "{}",
        own.err
    );
    let refused = run_in(path, words("export cal.json --to kalibr"));
    assert_eq!(refused.code, 3);
    assert!(refused.err.contains("gravical noise"), "{}", refused.err);
}
