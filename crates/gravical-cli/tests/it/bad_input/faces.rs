//! Faces that are missing, there twice, or called by the wrong name.

use super::*;

#[test]
fn missing_face() {
    let folder = six_files(&Sensor::default());
    std::fs::remove_file(folder.path().join("y_axis_neg.csv")).unwrap();
    let line = "calibrate . --gravity 9.81 --method ferraris";
    refused(
        folder.path(),
        line,
        3,
        "missing-face",
        &["missing: -y", "5 of six"],
    );
    // The joint fit does without, and says what that costs.
    let file = calibrate(folder.path(), ". --gravity 9.81", 4);
    let reported = finding(&file, "missing-face")["message"].to_string();
    assert!(reported.contains("-y up"), "{reported}");
    let sd = numbers(&file["accelerometer"]["deviations"]["bias"]);
    // The others are as uncertain as a nonlinear response may be.
    assert!(sd[1] > 1.5 * sd[0].max(sd[2]), "{sd:?}");
    assert_eq!(file["verdict"]["grade"], "poor");
}

#[test]
fn same_face_twice_among_six() {
    let folder = six_files(&Sensor::default());
    let at = folder.path();
    let again = Sensor::default().file([0.0, 1.0, 0.0], 500, 99);
    write(at, "y_axis_neg.csv", &again);
    let line = "calibrate . --gravity 9.81 --method ferraris";
    refused(at, line, 3, "missing-face", &["missing: -y", "5 of six"]);
    let file = calibrate(at, ". --gravity 9.81", 4);
    let said = finding(&file, "same-face-twice")["message"].to_string();
    assert!(said.contains("no pose has -y up"), "{said}");
    assert!(said.contains("y_axis_neg\\\" with -y up"), "{said}");
}

/// Renames the six files: what lay under the first name stands under the second.
fn swapped(pairs: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = six_files(&Sensor::default());
    for (a, b) in pairs {
        let path = |n: &str| folder.path().join(format!("{n}.csv"));
        let spare = folder.path().join("spare");
        std::fs::rename(path(a), &spare).unwrap();
        std::fs::rename(path(b), path(a)).unwrap();
        std::fs::rename(spare, path(b)).unwrap();
    }
    folder
}

#[test]
fn names_swapped_so_that_only_a_mirror_explains_them() {
    let folder = swapped(&[("x_axis_pos", "x_axis_neg")]);
    poor(folder.path(), ". --gravity 9.81", "names-mirrored");
    let file = calibrate(folder.path(), ". --gravity 9.81", 4);
    finding(&file, "orientation-mismatch");
    let bias = number(&file["accelerometer"]["bias"][0]);
    close(bias, Sensor::default().bias[0], 0.01);
}
