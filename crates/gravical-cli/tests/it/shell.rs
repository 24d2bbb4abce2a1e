//! The program in a shell: help, completions, pipes.

use crate::support::*;

#[test]
fn help_and_completions_of_every_verb() {
    let all = run(["--help"]).out;
    let verbs =
        "inspect calibrate apply denoise convert motion check compare export simulate completions";
    for verb in verbs.split(' ') {
        assert!(all.contains(verb), "{verb} in\n{all}");
        let help = run([verb, "--help"]).out;
        assert!(help.contains("Usage: gravical"), "{verb}: {help}");
        // A line for each option.
        assert!(help.lines().count() <= 60, "{verb}: {help}");
        let options = help.lines().filter(|line| line.starts_with("      --"));
        let wrapped = options.filter(|line| line.split("  ").filter(|s| !s.is_empty()).count() < 2);
        assert_eq!(wrapped.collect::<Vec<_>>(), [""; 0], "{verb}");
    }
    assert!(run(["--version"]).out.starts_with("gravical "));
    // Called without anything it shows what there is, as a usage error.
    let nothing = run::<&str>([]);
    assert!(nothing.code == 2 && nothing.err.contains("calibrate"));
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let run = run(["completions", shell]);
        assert!(run.code == 0 && run.out.contains("pose-tilt"), "{shell}");
    }
    assert_eq!(run(["completions", "tcsh"]).code, 2);
}

#[test]
fn a_pipe_that_is_closed_is_no_error() {
    let folder = six_files(&Sensor::default());
    // Far more text than a pipe holds.
    let files: String = FACES.iter().map(|f| format!(" {}.csv", f.0)).collect();
    let mut child = start(folder.path(), &format!("inspect{}", files.repeat(40)));
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty(), "{:?}", output.stderr);
}

#[test]
fn quiet_is_quiet_and_of_several_files_one_may_be_broken() {
    let folder = six_files(&Sensor::default());
    let at = folder.path();
    let run = ends(at, "calibrate . --gravity 9.81 --quiet -o cal.json", 0);
    assert_eq!((run.out.as_str(), run.err.as_str()), ("", ""));
    write(at, "broken.csv", "");
    let line = "inspect x_axis_pos.csv broken.csv z_axis_neg.csv";
    let text = ends(at, line, 3);
    assert!(text.out.contains("x_axis_pos.csv") && text.out.contains("z_axis_neg.csv"));
    assert!(text.err.contains("empty-file"), "{}", text.err);
    let json = json(at, line, 3);
    assert_eq!(list(&json["recordings"]).len(), 2);
    assert_eq!(json["errors"][0]["code"], "empty-file");
}
