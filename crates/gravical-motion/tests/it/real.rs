//! Real recordings whose truth is known; skipped without GRAVICAL_DATA.

use std::io::Read;
use std::path::Path;

use gravical_motion::{Motion, MotionOptions, Samples, estimate_motion};

const G: f64 = 9.80665;
const DEG: f64 = std::f64::consts::PI / 180.0;

/// Rows of numbers, NaN for an empty cell; none without the data.
fn rows(file: &str) -> Option<Vec<Vec<f64>>> {
    let Some(data) = std::env::var_os("GRAVICAL_DATA") else {
        println!("skipped: GRAVICAL_DATA is not set");
        return None;
    };
    let bytes = std::fs::read(Path::new(&data).join(file)).unwrap();
    let mut text = String::new();
    if file.ends_with(".gz") {
        flate2::read::GzDecoder::new(&bytes[..])
            .read_to_string(&mut text)
            .unwrap();
    } else {
        text = String::from_utf8(bytes).unwrap();
    }
    let cells = |line: &str| {
        line.split(',')
            .map(|c| c.parse().unwrap_or(f64::NAN))
            .collect()
    };
    Some(text.lines().skip(1).map(cells).collect())
}

fn three(row: &[f64], first: usize, unit: f64) -> [f64; 3] {
    [0, 1, 2].map(|c| row[first + c] * unit)
}

fn columns(rows: &[Vec<f64>], first: usize, unit: f64) -> Vec<[f64; 3]> {
    rows.iter().map(|r| three(r, first, unit)).collect()
}

/// Distance between start and end of the path, m, and its standard deviation.
fn closing_error(motion: &Motion) -> (f64, f64) {
    let (first, last) = (&motion.path[0], motion.path.last().unwrap());
    let norm = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let d = [0, 1, 2].map(|c| last.position_m[c] - first.position_m[c]);
    (norm(d), norm(last.position_sd_m))
}

#[test]
fn a_walk_round_a_square_closes() {
    let Some(rows) = rows("openshoe-square2/square2_u.csv") else {
        return;
    };
    let time_s: Vec<f64> = (0..rows.len()).map(|i| i as f64 * 0.01).collect();
    let samples = Samples::new(
        &time_s,
        &columns(&rows, 0, 1.0),
        &columns(&rows, 3, 1.0),
        Vec::new(),
    );
    let motion = estimate_motion(&samples, &MotionOptions::default());
    println!(
        "{:?} {} stances {:?}",
        motion.rests,
        motion.stances.len(),
        closing_error(&motion)
    );
    assert!(
        closing_error(&motion).0 < 0.2,
        "{:?}",
        closing_error(&motion)
    );
}

#[test]
fn a_short_walk_closes() {
    let Some(rows) = rows("xio-gait/short_walk.csv") else {
        return;
    };
    let time_s: Vec<f64> = rows.iter().map(|r| r[0]).collect();
    for from in [0.0, 20.0] {
        let cut = time_s.partition_point(|t| *t < from);
        let part = &rows[cut..];
        let samples = Samples::new(
            &time_s[cut..],
            &columns(part, 4, G),
            &columns(part, 1, DEG),
            Vec::new(),
        );
        let motion = estimate_motion(&samples, &MotionOptions::default());
        let s: Vec<_> = motion
            .rests
            .iter()
            .map(|r| {
                (
                    samples.time_s()[r.start] - from,
                    samples.time_s()[r.end - 1] - from,
                )
            })
            .collect();
        println!(
            "{s:.2?} {} stances {:.3?}",
            motion.stances.len(),
            closing_error(&motion)
        );
    }
}

#[test]
fn bouts_of_a_hand_end_where_they_began() {
    let Some(rows) = rows("broad-translation/14_undisturbed_slow_translation_with_breaks_B.csv.gz")
    else {
        return;
    };
    let time_s: Vec<f64> = rows.iter().map(|r| r[0]).collect();
    let samples = Samples::new(
        &time_s,
        &columns(&rows, 1, 1.0),
        &columns(&rows, 4, 1.0),
        Vec::new(),
    );
    let motion = estimate_motion(&samples, &MotionOptions::default());
    for m in &motion.moves {
        let t = |i: usize| samples.time_s()[i];
        println!(
            "{:.2}..{:.2} {:.3?} ± {:.3?} {:?}",
            t(m.samples.start),
            t(m.samples.end),
            m.displacement_m,
            m.sd_m(),
            m.closure
        );
    }
}

#[test]
fn a_lift_rises_by_74_m() {
    let Some(rows) = rows("pabrod-elevator/skyscrapper_up.csv") else {
        return;
    };
    // Channels are written as they come: a row has the latest value of each, where z is new.
    let mut latest = [f64::NAN; 3];
    let (mut time_s, mut force) = (Vec::new(), Vec::new());
    for row in &rows {
        (0..3)
            .filter(|c| row[2 + c].is_finite())
            .for_each(|c| latest[c] = row[2 + c]);
        if row[4].is_finite() && latest.iter().all(|v| v.is_finite()) {
            time_s.push(row[0] * 1e-3);
            force.push(latest);
        }
    }
    let samples = Samples::new(&time_s, &force, &[], Vec::new());
    let motion = estimate_motion(&samples, &MotionOptions::default());
    for m in &motion.moves {
        let t = |i: usize| samples.time_s()[i];
        println!(
            "{:.2}..{:.2} {:.3?} ± {:.3?} {:?}",
            t(m.samples.start),
            t(m.samples.end),
            m.displacement_m,
            m.sd_m(),
            m.closure
        );
    }
}
