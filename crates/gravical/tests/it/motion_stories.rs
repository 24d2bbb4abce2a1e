//! Motion of recordings whose story is known: what is missing, replaced, given or asked for. How
//! accurate it is, and what is a rest, is tested in `gravical-motion`.

use gravical::motion::{MotionJudgement, MotionOptions, motion, write_table};
use gravical::recording::{ReadOptions, Recording, read_bytes};

/// Noise without a generator: the same every time, about ±1.7.
fn noise(i: usize, channel: usize) -> f64 {
    let x = ((i * 12 + channel + 1) as f64 * 12.9898).sin() * 43758.5453;
    3.46 * (x - x.floor() - 0.5)
}

/// A recording at 100 Hz of `seconds`: acceleration along x and rate about y as
/// functions of time; `keep` says which rows are written.
fn record(
    seconds: f64,
    acceleration: impl Fn(f64) -> f64,
    with_gyro: bool,
    keep: impl Fn(f64) -> bool,
) -> Recording {
    let channels = if with_gyro { 6 } else { 3 };
    let names = "ax (m/s^2),ay (m/s^2),az (m/s^2),gx (rad/s),gy (rad/s),gz (rad/s)";
    let names: Vec<&str> = names.split(',').take(channels).collect();
    let mut text = format!("t_s,{}\n", names.join(","));
    for i in 0..(100.0 * seconds) as usize {
        let t = 0.01 * i as f64;
        if keep(t) {
            let truth = [acceleration(t), 0.0, 9.80665, 0.0, 0.0, 0.0];
            let cells = (0..channels).map(|c| {
                let (sd, digits) = if c < 3 { (0.02, 5) } else { (0.001, 6) };
                format!(",{:.digits$}", truth[c] + sd * noise(i, c))
            });
            text += &format!("{t:.3}{}\n", cells.collect::<String>());
        }
    }
    read_bytes(text.as_bytes(), "story.csv", &ReadOptions::default()).unwrap()
}

/// From 5 s on 1 m/s² for half a second, then `cruise` seconds at 0.5 m/s, then
/// back to rest.
fn ride(cruise: f64) -> impl Fn(f64) -> f64 {
    move |t: f64| {
        if (5.0..5.5).contains(&t) {
            1.0
        } else if (5.5 + cruise..6.0 + cruise).contains(&t) {
            -1.0
        } else {
            0.0
        }
    }
}

#[test]
fn without_a_rest_nothing_is_computed_and_that_is_said() {
    for with_gyro in [true, false] {
        let shaken = record(10.0, |t| 2.0 * (9.0 * t).sin(), with_gyro, |_| true);
        let whole = motion(&shaken, None, &MotionOptions::default()).unwrap();
        let result = &whole.result;
        assert_eq!(result.verdict.judgement, MotionJudgement::NotUsable);
        assert!(result.moves.is_empty() && result.r#final.position_m.is_none());
        assert!(whole.samples().all(|s| s.state.position_m[0].is_nan()));
        assert_eq!(whole.samples().count(), shaken.rows());
    }
}

#[test]
fn the_table_has_a_line_for_every_sample_in_every_case() {
    let two = |t: f64| ride(0.5)(t) + ride(0.5)(t - 7.0);
    let open = MotionOptions {
        rests: Some("0-4".parse().unwrap()),
        ..MotionOptions::default()
    };
    let usual = MotionOptions::default();
    for (options, columns, keep) in [
        (&usual, 27, (|_| true) as fn(f64) -> bool),
        (&usual, 27, |t| !(5.3..6.1).contains(&t)),
        (&usual, 27, |t| (5.25..13.0).contains(&t)),
        (&open, 27, |_| true),
        (&MotionOptions::report(), 21, |_| true),
    ] {
        let recording = record(20.0, two, true, keep);
        let whole = motion(&recording, None, options).unwrap();
        let mut table = Vec::new();
        write_table(&whole, &mut table).unwrap();
        let table = String::from_utf8(table).unwrap();
        assert_eq!(table.lines().count(), 1 + recording.rows());
        for line in table.lines() {
            assert_eq!(line.split(',').count(), columns, "{line}");
        }
        assert!(!table.contains("NaN") && !table.contains("inf"));
    }
}
