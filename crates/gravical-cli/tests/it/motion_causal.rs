//! `gravical motion --causal`: one pass, beside the batch where both apply.

use crate::bad_input::refused;
use crate::motion::{column, line, motion};
use crate::support::*;

#[test]
fn the_pass_ends_where_the_batch_does_without_zero_velocity() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let flags = "line/line.csv -c cal.json --gravity-removal initial-mean --zero-velocity off";
    let batch = motion(path, flags, 0);
    let pass = motion(path, &format!("{flags} --causal"), 0);
    agree(
        &numbers(&pass["final"]["position_m"]),
        &numbers(&batch["final"]["position_m"]),
        1e-8,
        "position",
    );
    assert!(pass["final"]["sigma_m"].is_null());
}

#[test]
fn a_rest_stops_it_and_the_table_follows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let run = run_in(path, words("motion line/line.csv -c cal.json --causal"));
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.out.starts_with("t_s,ax_mps2,"), "{}", &run.out[..60]);
    let (p, v) = (column(&run.out, "py_m"), column(&run.out, "vy_mps"));
    assert_eq!(p.len(), 1200);
    assert!((p.last().unwrap() - 0.7).abs() < 0.03, "{:?}", p.last());
    assert_eq!(v.last(), Some(&0.0));
}

#[test]
fn what_needs_the_future_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    for flags in [
        "--report motion.html",
        "--smooth butter:4,5Hz",
        "--smooth hampel:7,3",
    ] {
        let call = format!("motion line/line.csv --causal {flags}");
        refused(path, &call, 2, "not-causal", &["--causal"]);
    }
}
