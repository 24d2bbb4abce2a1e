//! The table of a recording whose story is known. How accurate it is, and what is a rest, is tested in
//! `gravical-motion`.

use gravical::motion::{MotionJudgement, MotionOptions, OrientationJudgement, motion};
use gravical::recording::Recording;

use crate::support::{Noise, read};

/// 18 s at 100 Hz with two rides along x, of which `keep` says which rows are written.
fn record(keep: fn(f64) -> bool) -> Recording {
    let ride = |t: f64| match t % 7.0 - 5.0 {
        0.0..0.5 => 1.0,
        1.0..1.5 => -1.0,
        _ => 0.0,
    };
    written(true, |t| [if keep(t) { ride(t) } else { f64::NAN }, 0.0])
}

/// 18 s at 100 Hz: acceleration along x and rate about z at each time; rows without a number are not there.
fn written(gyro: bool, at: impl Fn(f64) -> [f64; 2]) -> Recording {
    let mut noise = Noise::new(1);
    let rates = if gyro {
        ",gx (rad/s),gy (rad/s),gz (rad/s)"
    } else {
        ""
    };
    let mut text = format!("t_s,ax (m/s^2),ay (m/s^2),az (m/s^2){rates}\n");
    for i in 0..1800 {
        let t = 0.01 * f64::from(i);
        let [along, turn] = at(t);
        let [x, y, z] = [along, 0.0, 9.80665].map(|v| v + 0.02 * noise.normal());
        let [p, q, r] = [0.0, 0.0, turn].map(|v| v + 0.001 * noise.normal());
        if along.is_finite() {
            text += &format!("{t:.3},{x:.5},{y:.5},{z:.5}");
            text += &if gyro {
                format!(",{p:.6},{q:.6},{r:.6}\n")
            } else {
                "\n".to_owned()
            };
        }
    }
    read(text.as_bytes())
}

#[test]
fn the_table_has_a_line_for_every_sample_in_every_case() {
    let open = MotionOptions {
        rests: Some("0-4".parse().unwrap()),
        ..MotionOptions::default()
    };
    let usual = MotionOptions::default();
    for (options, columns, keep) in [
        (&usual, 29, (|_| true) as fn(f64) -> bool),
        (&usual, 29, |t| !(5.3..6.1).contains(&t)),
        (&usual, 29, |t| (5.25..13.0).contains(&t)),
        (&open, 29, |_| true),
        (&MotionOptions::report(), 21, |_| true),
    ] {
        let recording = record(keep);
        let whole = motion(&recording, None, options).unwrap();
        let mut table = Vec::new();
        whole.table().write(&mut table).unwrap();
        let table = String::from_utf8(table).unwrap();
        assert_eq!(table.lines().count(), 1 + recording.rows());
        for line in table.lines() {
            assert_eq!(line.split(',').count(), columns, "{line}");
        }
        assert!(!table.contains("NaN") && !table.contains("inf"));
    }
}

/// A smooth turn by 90° or ride of 2 s from 6 s on, of one unit in all.
fn bell(t: f64) -> f64 {
    let u = (t - 6.0) / 2.0;
    if (0.0..1.0).contains(&u) {
        15.0 * (u * (1.0 - u)).powi(2)
    } else {
        0.0
    }
}

/// The acceleration of a smooth move by 1 m in 2 s from 6 s on, m/s².
fn pull(t: f64) -> f64 {
    let u = (t - 6.0) / 2.0;
    if (0.0..1.0).contains(&u) {
        15.0 * u * (1.0 - u) * (1.0 - 2.0 * u)
    } else {
        0.0
    }
}

#[test]
fn a_motion_is_judged_by_its_size() {
    use MotionJudgement::{AtRest, Open, PositionNotKnown, Rough, Usable};
    for (expected, from_s, at) in [
        (Usable, 0.0, (|t| [pull(t), 0.0]) as fn(f64) -> [f64; 2]),
        (Rough, 0.0, |t| [0.02 * pull(t), 0.0]),
        (AtRest, 0.0, |_| [0.0, 0.0]),
        (AtRest, 0.0, |t| {
            [0.0, std::f64::consts::FRAC_PI_2 * bell(t)]
        }),
        (Open, 11.5, |t| [pull(t - 10.9), 0.0]),
        (PositionNotKnown, 0.0, |t| {
            [
                if (6.5..7.5).contains(&t) {
                    f64::NAN
                } else {
                    pull(t)
                },
                0.0,
            ]
        }),
    ] {
        let result = motion(&written(true, at), None, &MotionOptions::default())
            .unwrap()
            .result;
        let v = &result.verdict;
        assert_eq!(v.judgement, expected, "{v:?} {:?}", result.moves);
        assert!(from_s == 0.0 || result.moves[0].start_s > from_s);
        let turned = v.reasons.iter().any(|r| r.contains("it turned by 90."));
        assert_eq!(turned, at(7.0)[1] != 0.0, "{v:?}");
    }
}

#[test]
fn an_orientation_says_what_is_known_of_it() {
    use OrientationJudgement::{Known, PartlyKnown};
    let turn = |t: f64| [0.0, std::f64::consts::FRAC_PI_2 * bell(t)];
    let gap = |t: f64| {
        [
            if (9.5..12.0).contains(&t) {
                f64::NAN
            } else {
                pull(t - 3.0)
            },
            bell(t),
        ]
    };
    for (expected, recording) in [
        (Known, written(true, turn)),
        (PartlyKnown, written(true, gap)),
        (PartlyKnown, written(false, |t| [pull(t), 0.0])),
    ] {
        let motion = motion(&recording, None, &MotionOptions::default()).unwrap();
        let found = motion.orientation().unwrap();
        assert_eq!(found.verdict.judgement, expected, "{found:?}");
        let [start, end] = found.ends.unwrap();
        // What is not known is an empty field.
        let mut table = Vec::new();
        motion.orientation_table(false).write(&mut table).unwrap();
        let table = String::from_utf8(table).unwrap();
        let unknown = table
            .lines()
            .filter(|line| line.contains(",,,,,,,"))
            .count();
        let lost = motion.result.moves.iter().any(|m| m.unusable.is_some());
        assert_eq!(unknown > 0, lost, "{expected:?}");
        assert_eq!(end.sigma_heading_deg.is_some(), expected == Known);
        assert!(start.sigma_tilt_deg.unwrap() < 3.0);
        if expected == Known {
            let yaw = end.roll_pitch_yaw_deg[2] - start.roll_pitch_yaw_deg[2];
            assert!(
                (yaw - 90.0).abs() < 2.0 * end.sigma_heading_deg.unwrap(),
                "{end:?}"
            );
        }
    }
    let by_report = motion(&written(true, turn), None, &MotionOptions::report()).unwrap();
    assert_eq!(by_report.orientation().unwrap_err().code(), "option-range");
}
