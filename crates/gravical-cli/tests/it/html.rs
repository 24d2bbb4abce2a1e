//! `--report`: where it goes, and what it leaves alone. What is in the page is held
//! against the JSON by the library's tests and by `tests/browser`.

use crate::support::*;

fn session(path: &std::path::Path) {
    let made = run_in(path, words("simulate six-position -o six --hold 2 -q"));
    assert_eq!(made.code, 0, "{}", made.err);
    let made = run_in(path, words("simulate line -o line -q"));
    assert_eq!(made.code, 0, "{}", made.err);
}

#[test]
fn it_stands_beside_the_other_output() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    session(path);
    for line in ["calibrate six", "motion line/line.csv"] {
        let page = path.join("page.html");
        let plain = run_in(path, words(&format!("{line} --json")));
        let with = run_in(
            path,
            words(&format!("{line} --json --report page.html --force")),
        );
        assert_eq!(with.code, plain.code, "{}", with.err);
        assert!(with.err.contains("Report: page.html"), "{}", with.err);
        let text = std::fs::read_to_string(&page).unwrap();
        assert!(text.starts_with("<!DOCTYPE html>") && text.ends_with("</html>"));
        assert!(text.contains(&format!("gravical {line} --json --report page.html")));
        // 64 hexadecimal digits: the file that it is of.
        assert!(text.contains("SHA-256") && !text.contains("<td class=\"hash\">–"));
        let keys: Vec<String> = with.json().as_object().unwrap().keys().cloned().collect();
        assert!(plain.json().as_object().unwrap().keys().eq(keys.iter()));
    }
}

#[test]
fn targets_are_judged_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    session(path);
    std::fs::write(path.join("page.html"), "mine").unwrap();
    for line in [
        "calibrate six -o new.json",
        "motion line/line.csv -o new.csv",
    ] {
        let run = run_in(path, words(&format!("{line} --report page.html --json")));
        assert_eq!(
            (run.code, run.error_code().as_str()),
            (2, "exists"),
            "{line}"
        );
        let run = run_in(path, words(&format!("{line} --report - --json")));
        assert_eq!((run.code, run.error_code().as_str()), (2, "report-target"));
    }
    assert_eq!(
        std::fs::read_to_string(path.join("page.html")).unwrap(),
        "mine"
    );
    assert!(!path.join("new.json").exists() && !path.join("new.csv").exists());
    let quiet = run_in(path, words("calibrate six -q --report page.html --force"));
    assert_eq!((quiet.out.as_str(), quiet.err.as_str()), ("", ""));
    assert!(std::fs::metadata(path.join("page.html")).unwrap().len() > 50_000);
}
