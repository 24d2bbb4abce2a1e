//! The table of a recording whose story is known. How accurate it is, and what is a rest, is tested in
//! `gravical-motion`.

use gravical::motion::{MotionOptions, motion, write_table};
use gravical::recording::Recording;

use crate::support::{Noise, read};

/// 18 s at 100 Hz with two rides along x, of which `keep` says which rows are written.
fn record(keep: fn(f64) -> bool) -> Recording {
    let mut noise = Noise::new(1);
    let names = "ax (m/s^2),ay (m/s^2),az (m/s^2),gx (rad/s),gy (rad/s),gz (rad/s)";
    let mut text = format!("t_s,{names}\n");
    for i in 0..1800 {
        let t = 0.01 * f64::from(i);
        let ride = match t % 7.0 - 5.0 {
            0.0..0.5 => 1.0,
            1.0..1.5 => -1.0,
            _ => 0.0,
        };
        let [x, y, z] = [ride, 0.0, 9.80665].map(|v| v + 0.02 * noise.normal());
        let [p, q, r] = [(); 3].map(|()| 0.001 * noise.normal());
        if keep(t) {
            text += &format!("{t:.3},{x:.5},{y:.5},{z:.5},{p:.6},{q:.6},{r:.6}\n");
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
        (&usual, 27, (|_| true) as fn(f64) -> bool),
        (&usual, 27, |t| !(5.3..6.1).contains(&t)),
        (&usual, 27, |t| (5.25..13.0).contains(&t)),
        (&open, 27, |_| true),
        (&MotionOptions::report(), 21, |_| true),
    ] {
        let recording = record(keep);
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
