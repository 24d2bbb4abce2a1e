//! References made from a known track: turned, delayed, at other rates; as files: the recording itself, one of
//! its own, none.

use super::*;
use crate::recording::{ReadOptions, Recording, read};
use std::path::Path;

/// Position at t: rest until 3 s, then two goes with a rest between them.
fn place(t: f64) -> [f64; 3] {
    let go = |t: f64| {
        let s = (t / 2.0).clamp(0.0, 1.0);
        s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    };
    let bow = |t: f64| {
        (std::f64::consts::FRAC_PI_2 * t.clamp(0.0, 2.0))
            .sin()
            .powi(2)
    };
    let (one, two) = (t - 3.0, t - 8.0);
    let [x, y] = [
        0.7 * go(one) - 0.2 * go(two),
        0.3 * go(two) + 0.1 * bow(one),
    ];
    [x, y, 0.15 * bow(two)]
}

fn is_near(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() < tolerance, "{a} and {b}");
}

fn a_move(start_s: f64, end_s: f64) -> Move {
    let (a, b) = (place(start_s), place(end_s));
    Move {
        start_s,
        end_s,
        displacement_m: Some(std::array::from_fn(|k| b[k] - a[k])),
        sigma_m: Some([0.003; 3]),
        ..Move::default()
    }
}

/// A result: its track at `rate_hz`, without error, and its moves.
struct Known {
    t_s: Vec<f64>,
    position_m: Vec<[f64; 3]>,
    moves: Vec<Move>,
    findings: Vec<Finding>,
}

fn motion(rate_hz: f64) -> Known {
    let n = (14.0 * rate_hz) as usize;
    let t_s: Vec<f64> = (0..n).map(|i| i as f64 / rate_hz).collect();
    Known {
        position_m: t_s.iter().map(|t| place(*t)).collect(),
        t_s,
        moves: vec![a_move(3.0, 5.0), a_move(8.0, 10.0)],
        findings: Vec::new(),
    }
}

/// What a camera sees: at its own rate, from its own origin, turned about the vertical, and with a
/// clock that shows `ahead_s` more.
fn seen(rate_hz: f64, ahead_s: f64, yaw_rad: f64) -> Reference {
    let rows = 0..(13.0 * rate_hz) as usize;
    let t_s: Vec<f64> = rows.map(|i| 0.2 + i as f64 / rate_hz).collect();
    let (sine, cosine) = yaw_rad.sin_cos();
    let turned = |[x, y, z]: [f64; 3]| {
        let [u, v] = [cosine * x - sine * y, sine * x + cosine * y];
        [u + 5.0, v - 1.0, z + 0.3]
    };
    Reference {
        input: InputFile {
            path: "camera.csv".to_owned(),
            sha256: None,
            role: InputRole::Reference,
        },
        position_m: t_s.iter().map(|t| turned(place(*t))).collect(),
        t_s: t_s.iter().map(|t| t + ahead_s).collect(),
        same_file: false,
        findings: Vec::new(),
    }
}

fn try_compare(motion: &mut Known, reference: &Reference) -> Result<Comparison> {
    motion.findings.clone_from(&reference.findings);
    let own = Line::new(&motion.t_s, &motion.position_m);
    let compared = compare(&own, &motion.moves, reference, &mut motion.findings);
    compared.map(|(comparison, _)| comparison)
}

fn compared(motion: &mut Known, reference: &Reference) -> Comparison {
    try_compare(motion, reference).unwrap()
}

fn kinds(motion: &Known) -> Vec<&str> {
    motion.findings.iter().map(|f| &*f.kind).collect()
}

#[test]
fn a_yaw_and_an_offset_are_found_at_any_rate() {
    for (rate, other) in [(100.0, 285.7), (285.7, 30.0), (100.0, 100.0), (62.5, 10.0)] {
        for ahead in [0.0, 2.317, -4.123] {
            let mut motion = motion(rate);
            let c = compared(&mut motion, &seen(other, ahead, 0.9));
            is_near(c.time_offset_s, -ahead, 2e-3);
            is_near(c.yaw_deg, -0.9_f64.to_degrees(), 0.1);
            assert!(c.rmse_m < 2e-3 && c.end_error_m < 2e-3, "{c:?}");
            assert!(c.percent_of_path.unwrap() < 0.2, "{c:?}");
            assert_eq!(c.moves.len(), 2);
            for m in &c.moves {
                assert!(m.end_error_m.iter().all(|e| e.abs() < 2e-3), "{m:?}");
                assert_eq!(m.sigma_m, Some([0.003; 3]));
            }
            assert!(kinds(&motion).is_empty(), "{:?}", motion.findings);
        }
    }
}

#[test]
fn errors_are_errors_of_the_result() {
    let mut motion = motion(100.0);
    // 1 cm too far up in the second move, kept from then on.
    for (t, p) in motion.t_s.iter().zip(&mut motion.position_m) {
        p[2] += 0.01 * ((t - 8.0) / 2.0).clamp(0.0, 1.0);
    }
    motion.moves[1].displacement_m.as_mut().unwrap()[2] += 0.01;
    let reference = Reference {
        same_file: true,
        ..seen(50.0, 0.0, 0.0)
    };
    let c = compared(&mut motion, &reference);
    is_near(c.end_error_m, 0.01, 1e-5);
    // Half of the time not yet off, then off by a centimetre.
    is_near(c.rmse_m, 0.01 * (4.0_f64 / 13.0).sqrt(), 1e-3);
    is_near(c.moves[0].end_error_m[2], 0.0, 1e-5);
    is_near(c.moves[1].end_error_m[2], 0.01, 1e-5);
    is_near(c.moves[1].rmse_m, 0.01 / 3.0_f64.sqrt(), 1e-3);
    is_near(c.path_m, 1.25, 0.15);
}

#[test]
fn gaps_of_the_reference_are_not_compared() {
    let mut motion = motion(100.0);
    let mut reference = seen(50.0, 0.0, 0.0);
    let rows = reference.t_s.into_iter().zip(reference.position_m);
    (reference.t_s, reference.position_m) = rows.filter(|(t, _)| !(2.5..4.0).contains(t)).unzip();
    let c = compared(&mut motion, &reference);
    assert_eq!(c.moves.len(), 1);
    assert_eq!((c.moves[0].number, c.moves[0].start_s), (2, 8.0));
    assert!(c.rmse_m < 2e-3, "{c:?}");
}

#[test]
fn at_rest_nothing_aligns_and_that_is_said() {
    let mut motion = motion(100.0);
    motion.position_m.fill([0.0; 3]);
    let mut reference = seen(50.0, 0.0, 0.0);
    reference.position_m.fill([1.0, 2.0, 3.0]);
    let c = compared(&mut motion, &reference);
    assert_eq!(c.percent_of_path, None);
    assert_eq!([c.time_offset_s, c.rmse_m], [0.0; 2]);
    assert_eq!(kinds(&motion), ["truth-offset"]);
    // No time in common is refused.
    motion.position_m.fill([f64::NAN; 3]);
    let error = try_compare(&mut motion, &seen(50.0, 0.0, 0.0)).unwrap_err();
    assert_eq!(error.code(), "truth-overlap");
}

/// A recording of a line with its file.
fn recorded(folder: &Path, extra: &str) -> (Recording, std::path::PathBuf) {
    let path = folder.join("own.csv");
    let mut text = format!("# made for a test\nTimestamp (ms),ax,ay,az{extra}\n");
    for i in 0..1400 {
        let t = 0.01 * f64::from(i);
        let p = place(t);
        // Every fifth row has no position.
        let cells = match i % 5 {
            _ if extra.is_empty() => String::new(),
            0 => ",,,".to_owned(),
            _ => p.map(|v| format!(",{:.5}", 1e3 * v)).concat(),
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
    let truth = folder.path().join("truth.csv");
    let mixed = "t_s,px_mm,py_m,pz_m\n0,1,2,3\n1,1,2,3\n";
    for (text, code) in [
        ("", "no-rows"),
        ("a,b\nx,y\n", "no-rows"),
        ("t_s,a,b,c\n0,1,2,3\n1,1,2,3\n", "truth-columns-missing"),
        (mixed, "truth-columns-missing"),
        ("t_s,px_m,py_m,pz_m\n0,1,2,3\n", "truth-time"),
        ("t_s,px_m,py_m,pz_m\n0,1,2,3\n0,1,2,3\n", "truth-time"),
        ("t_s,px_m,py_m,pz_m\n0,1,2,3\n1,1,2,\n2,,,\n", "truth-empty"),
        ("n,px_m,py_m,pz_m\n0,1,2,3\n1,1,2,3\n", "truth-time"),
    ] {
        std::fs::write(&truth, text).unwrap();
        let refused = read_reference(&truth, &recording, &path).unwrap_err();
        assert_eq!(refused.code(), code, "{text}");
    }
    let none = read_reference(&folder.path().join("none"), &recording, &path);
    assert_eq!(none.unwrap_err().code(), "not-found");
}
