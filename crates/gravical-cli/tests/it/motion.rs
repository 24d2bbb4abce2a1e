//! `gravical motion`: its table, its summary, its flags, its comparison with a
//! reference.

use std::path::Path;

use serde_json::Value;

use crate::bad_input::refused;
use crate::compare_check::narrow;
use crate::support::*;

/// A line of 0.7 m and a calibration of the same sensor.
pub fn line(folder: &Path) {
    for line in [
        "simulate line -o line --seed 1 --quiet",
        "simulate poses -o poses --seed 1 --quiet",
        "calibrate poses/poses.csv -o cal.json --gravity 9.80665 --quiet",
    ] {
        let run = run_in(folder, words(line));
        assert_eq!(run.code, 0, "{line}\n{}{}", run.out, run.err);
    }
}

pub fn motion(folder: &Path, line: &str, code: i32) -> Value {
    let run = run_in(folder, words(&format!("motion {line} --json --quiet")));
    assert_eq!(run.code, code, "{line}\n{}{}", run.out, run.err);
    assert!(run.err.is_empty(), "{}", run.err);
    run.json()
}

/// Columns of a table by name; an empty field is NaN.
pub fn column(table: &str, name: &str) -> Vec<f64> {
    let mut lines = table.lines();
    let at = lines
        .next()
        .unwrap()
        .split(',')
        .position(|n| n == name)
        .unwrap_or_else(|| panic!("no column {name}"));
    lines
        .map(|l| l.split(',').nth(at).unwrap().parse().unwrap_or(f64::NAN))
        .collect()
}

#[test]
fn the_table_goes_out_and_the_summary_aside() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let run = run_in(path, words("motion line/line.csv -c cal.json"));
    assert_eq!(run.code, 0, "{}", run.err);
    let header = run.out.lines().next().unwrap();
    assert!(header.starts_with("t_s,raw_ax_mps2,"), "{header}");
    assert!(header.ends_with(",sigma_pz_m"), "{header}");
    assert_eq!(run.out.lines().count(), 1201);
    let (p, v) = (column(&run.out, "py_m"), column(&run.out, "vy_mps"));
    assert!((p.last().unwrap() - 0.7).abs() < 0.015, "{:?}", p.last());
    assert_eq!(v.last(), Some(&0.0));
    let still = column(&run.out, "still");
    assert_eq!((still[0], still[600], still[1199]), (1.0, 0.0, 1.0));
    // 5 s along the attitude, 1200 rows: no column but one has another length.
    assert!(column(&run.out, "qw").iter().all(|q| q.is_finite()));
    narrow(&run.err);
    for part in [
        "line/line.csv: 1200 rows → stdout",
        "displacement ± 1σ, m",
        "uncalibrated",
        "Uncertainty of the displacement",
    ] {
        assert!(run.err.contains(part), "{part} in\n{}", run.err);
    }

    // The same into a file, with nothing on stdout.
    let args = "motion line/line.csv -c cal.json -o moved.csv";
    let saved = run_in(path, words(args));
    assert_eq!((saved.code, saved.out.as_str()), (0, ""));
    let text = std::fs::read_to_string(path.join("moved.csv")).unwrap();
    assert!(text == run.out);
    refused(path, args, 2, "exists", &[]);
    assert_eq!(
        run_in(path, words(&format!("{args} --force --quiet"))).code,
        0
    );

    // Without bands.
    let plain = run_in(path, words("motion line/line.csv --no-bands --quiet"));
    assert!(plain.err.is_empty());
    assert!(plain.out.lines().next().unwrap().ends_with(",pz_m"));
    // From a pipe's end, read back by our own reader.
    let again = run_in(
        path,
        words("inspect moved.csv --columns t=t_s,ax=ax_mps2,ay=ay_mps2,az=az_mps2 --json"),
    );
    assert_eq!(again.code, 0, "{}", again.err);
    assert_eq!(again.json()["recordings"][0]["row_counts"]["rows"], 1200);
}

#[test]
fn json_stands_alone_and_beside_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let result = motion(path, "line/line.csv -c cal.json", 0);
    assert_eq!(result["rows"], 1200);
    close(result["rate_hz"]["true"].as_f64().unwrap(), 100.0, 0.1);
    let moved = &result["moves"][0];
    let (way, sigma) = (
        numbers(&moved["displacement_m"]),
        numbers(&moved["sigma_m"]),
    );
    for (k, truth) in [0.02, 0.7, 0.0].into_iter().enumerate() {
        assert!((way[k] - truth).abs() < 3.0 * sigma[k], "{way:?} {sigma:?}");
        assert!(sigma[k] < 0.02, "{sigma:?}");
    }
    assert_eq!(moved["ends"], "rest-to-rest");
    let parts = ["noise", "calibration", "attitude"].map(|k| numbers(&moved["budget_m"][k]));
    for k in 0..3 {
        let sum = parts.iter().map(|p| p[k] * p[k]).sum::<f64>().sqrt();
        assert!((sum / sigma[k] - 1.0).abs() < 0.01, "{parts:?} {sigma:?}");
    }
    assert!(result["uncalibrated"]["position_m"].is_array());
    assert!(result["truth"].is_null() && moved["unusable"].is_null());
    let both = run_in(
        path,
        words("motion line/line.csv -c cal.json --json -o m.csv"),
    );
    assert_eq!(both.json(), result);
    assert!(both.err.contains("→ m.csv"), "{}", both.err);
    assert!(path.join("m.csv").is_file());
}

#[test]
fn the_procedure_of_the_student_report() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let initial_mean = "line/line.csv -c cal.json --gravity-removal initial-mean";
    let report = motion(path, "line/line.csv -c cal.json --procedure report", 0);
    assert!(
        report["procedure"]
            .as_str()
            .unwrap()
            .starts_with("smoothed by savgol:5,2; ")
    );
    assert_eq!(report["frame"], "the sensor's own axes");
    for more in [
        "--zero-velocity on",
        "--rests 0-4",
        "--causal",
        "--v0 1,0,0",
    ] {
        let call = format!("motion {initial_mean} {more}");
        refused(path, &call, 2, "option-range", &["mean of the first rows"]);
    }
    let followed = motion(
        path,
        "line/line.csv -c cal.json --gravity-removal constant-tilt",
        0,
    );
    assert_eq!(numbers(&followed["final"]["velocity_mps"]), [0.0; 3]);

    // Smoothing changes the noise, not the end.
    let rough = motion(path, initial_mean, 0);
    assert_eq!(rough["procedure"].as_str().unwrap().find("smoothed"), None);
    let (a, b) = (
        &report["final"]["position_m"],
        &rough["final"]["position_m"],
    );
    for (a, b) in numbers(a).into_iter().zip(numbers(b)) {
        assert!(a != b && (a - b).abs() < 0.01, "{a} {b}");
    }

    // Rests by hand, and where it starts.
    let given = motion(path, "line/line.csv --rests 0-4.8,7.2- --p0 1,-2,0.5", 0);
    assert_eq!(given["rests"].as_array().unwrap().len(), 2);
    close(given["rests"][0]["end_s"].as_f64().unwrap(), 4.8, 0.011);
    let end = numbers(&given["final"]["position_m"]);
    close(end[0], 1.02, 0.1);
    close(end[1], -1.3, 0.1);
    let thrown = motion(path, "line/line.csv --zero-velocity off --v0 -1,0,0.5", 0);
    let velocity = numbers(&thrown["final"]["velocity_mps"]);
    close(velocity[0], -1.0, 0.1);
    close(velocity[2], 0.5, 0.1);
}

#[test]
fn at_rest_it_says_what_could_hide() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let make = "simulate static -o static --seed 4 --quiet";
    assert_eq!(run_in(path, words(make)).code, 0);
    let run = run_in(path, words("motion static/static.csv -o m.csv"));
    assert_eq!(run.code, 0, "{}", run.err);
    narrow(&run.err);
    assert!(run.err.contains("Verdict: at rest"), "{}", run.err);
    assert!(run.err.contains("could hide in it"), "{}", run.err);
    let visible = &motion(path, "static/static.csv", 0)["visible_moves"];
    assert!(visible[0]["distance_m"].as_f64().unwrap() > 1e-4);
}

/// The past only: bands, a table with the same columns, and what needs the future is refused.
#[test]
fn a_causal_run_has_all_that_the_whole_has() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let call = "motion line/line.csv -c cal.json --causal";
    let run = run_in(path, words(call));
    assert_eq!(run.code, 0, "{}", run.err);
    let (p, sigma) = (column(&run.out, "py_m"), column(&run.out, "sigma_py_m"));
    assert_eq!(p.len(), 1200);
    let (p, sigma) = (p.last().unwrap(), sigma.last().unwrap());
    assert!(
        (p - 0.7).abs() < 3.0 * sigma && *sigma < 0.03,
        "{p} ± {sigma}"
    );
    let report = run_in(path, words(&format!("{call} -o m.csv --report m.html")));
    assert_eq!(report.code, 0, "{}", report.err);
    let smoothed = format!("{call} --smooth butter:4,5Hz");
    refused(path, &smoothed, 2, "option-range", &["filters use"]);
}

#[test]
fn a_reference_with_its_own_clock_rate_and_heading() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let args = "motion line/line.csv -c cal.json";
    let table = run_in(path, words(args)).out;
    let (t, x, y, z) = (
        column(&table, "t_s"),
        column(&table, "px_m"),
        column(&table, "py_m"),
        column(&table, "pz_m"),
    );
    // What a camera would have seen: every third sample, 2.5 s later by its clock,
    // turned by 90°, in mm, and 10 mm too long.
    let mut truth = String::from("frame;t_s;X (mm);Y (mm);Z (mm)\n");
    for i in (0..t.len()).step_by(3) {
        let longer = y[i] * (1.0 + 0.01 / 0.7);
        truth.push_str(&format!(
            "{i};{:.4};{:.3};{:.3};{:.3}\n",
            t[i] + 2.5,
            1e3 * -longer + 80.0,
            1e3 * x[i],
            1e3 * z[i]
        ));
    }
    write(path, "truth.csv", &truth);
    let result = motion(path, "line/line.csv -c cal.json --truth truth.csv", 0);
    let c = &result["truth"];
    close(c["time_offset_s"].as_f64().unwrap(), -2.5, 5e-3);
    close(c["yaw_deg"].as_f64().unwrap(), -90.0, 0.2);
    close(c["end_error_m"].as_f64().unwrap(), 0.01, 1e-3);
    close(c["percent_of_path"].as_f64().unwrap(), 1.41, 0.15);
    close(
        c["moves"][0]["end_error_m"][1].as_f64().unwrap(),
        -0.01,
        1e-3,
    );
    let run = run_in(path, words(&format!("{args} -o m.csv --truth truth.csv")));
    assert_eq!(run.code, 0, "{}", run.err);
    narrow(&run.err);
    assert!(
        run.err
            .contains("Comparison with the reference\n  truth.csv"),
        "{}",
        run.err
    );
}

#[test]
fn a_table_of_motion_says_which_of_its_columns_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let make = "motion line/line.csv -c cal.json -o track.csv --quiet";
    assert_eq!(run_in(path, words(make)).code, 0);
    let again = motion(path, "track.csv -c cal.json", 0);
    let raw = finding(&again, "several-sensors")["message"].clone();
    let raw = raw.as_str().unwrap();
    assert!(raw.contains("raw ones (raw_ax_mps2 …) are read"), "{raw}");
    assert!(!kinds(&again).contains(&"already-calibrated".to_owned()));
}

/// A board whose clock is set in the middle; the search for slow moves once went through all the
/// years.
#[test]
fn a_clock_that_is_set_by_thirty_years_is_a_gap() {
    let folder = tempfile::tempdir().unwrap();
    line(folder.path());
    let text = std::fs::read_to_string(folder.path().join("line/line.csv")).unwrap();
    let later = |(i, row): (usize, &str)| match row.split_once(',') {
        Some((stamp, rest)) if i > 900 => {
            format!(
                "{},{rest}\n",
                stamp.parse::<u64>().unwrap() + 1_000_000_000_000
            )
        }
        _ => format!("{row}\n"),
    };
    let text: String = text.lines().enumerate().map(later).collect();
    std::fs::write(folder.path().join("set.csv"), text).unwrap();
    let result = motion(folder.path(), "set.csv -c cal.json", 0);
    finding(&result, "gap");
}
