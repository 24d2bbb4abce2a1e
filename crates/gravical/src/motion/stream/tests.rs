//! The stream against the batch, where both apply, and faults.

use gravical_core::matrix3::{norm, sub};

use super::*;
use crate::motion::{Motion, motion};
use crate::recording::open::from_reader;
use crate::simulate::{LineOptions, Scenario, SimulateOptions, simulate, write};

/// A line of 0.7 m in 2 s after 5 s at rest, as a file.
fn line(seed: u64) -> Vec<u8> {
    line_of(seed, LineOptions::default())
}

fn line_of(seed: u64, line: LineOptions) -> Vec<u8> {
    let mut options = SimulateOptions::new(Scenario::Line(line));
    options.seed = seed;
    let folder = tempfile::tempdir().unwrap();
    write(&simulate(&options).unwrap(), folder.path(), false).unwrap();
    std::fs::read(folder.path().join("line.csv")).unwrap()
}

fn stream(bytes: &[u8], options: &MotionOptions) -> Result<(Streamed, String)> {
    let reader = Box::new(std::io::Cursor::new(bytes.to_vec()));
    let input = from_reader(reader, false).unwrap();
    let mut out: Vec<u8> = Vec::new();
    let read = ReadOptions::default();
    let done = motion_stream(input, "line.csv", &read, None, options, Some(&mut out))?;
    Ok((done, String::from_utf8(out).unwrap()))
}

fn batch(bytes: &[u8], options: &MotionOptions) -> Motion {
    let recording = read_bytes(bytes, "line.csv", &ReadOptions::default()).unwrap();
    motion(&recording, None, options).unwrap()
}

/// The columns of a table from `first` on, three of them; NaN where empty.
fn columns(table: &str, first: &str) -> Vec<[f64; 3]> {
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = names.iter().position(|n| *n == first).unwrap();
    lines
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            assert_eq!(fields.len(), names.len());
            std::array::from_fn(|i| fields[at + i].parse().unwrap_or(f64::NAN))
        })
        .collect()
}

fn close(a: [f64; 3], b: [f64; 3], relative: f64) {
    assert!(norm(&sub(&a, &b)) <= relative * norm(&b), "{a:?} {b:?}");
}

#[test]
fn a_rest_in_the_braking_is_taken_back() {
    for (distance_m, move_time_s, seed) in [(0.7, 4.0, 2), (0.2, 3.0, 2), (0.2, 3.0, 5)] {
        let options = LineOptions {
            distance_m,
            offset_m: 0.0,
            move_time_s,
            rest_s: 20.0,
            ..LineOptions::default()
        };
        let bytes = line_of(seed, options);
        let result = stream(&bytes, &MotionOptions::default()).unwrap().0.result;
        let end = result.r#final.position_m.unwrap();
        assert!((end[1] - distance_m).abs() < 0.1, "{distance_m} m: {end:?}");
        assert_eq!(result.r#final.velocity_mps, Some([0.0; 3]));
        // A move is one; what is left after it is small.
        let most = result.moves.iter().filter_map(|m| m.displacement_m);
        assert!(most.map(|d| norm(&d)).fold(0.0, f64::max) > 0.8 * distance_m);
    }
}

/// 5 s of rest, 1 m/s² for half a second, `cruise_s` at 0.5 m/s, and back to rest.
fn ride(cruise_s: f64) -> Vec<u8> {
    let mut text = "t_s,ax_mps2,ay_mps2,az_mps2,gx_rad_s,gy_rad_s,gz_rad_s\n".to_owned();
    for i in 0..(100.0 * (cruise_s + 12.0)) as usize {
        let t = 0.01 * i as f64;
        let noise = |c: usize| {
            let x = ((i * 6 + c + 1) as f64 * 12.9898).sin() * 43758.5453;
            3.46 * (x - x.floor() - 0.5)
        };
        let a = match t - 5.0 {
            s if (0.0..0.5).contains(&s) => 1.0,
            s if (0.5 + cruise_s..1.0 + cruise_s).contains(&s) => -1.0,
            _ => 0.0,
        };
        let [x, y, z] = [a, 0.0, 9.80665];
        text += &format!(
            "{t:.2},{:.5},{:.5}",
            x + 0.02 * noise(0),
            y + 0.02 * noise(1)
        );
        text += &format!(",{:.5}", z + 0.02 * noise(2));
        for c in 3..6 {
            text += &format!(",{:.6}", 1e-3 * noise(c));
        }
        text += "\n";
    }
    text.into_bytes()
}

#[test]
fn above_two_kilohertz_it_says_that_no_rest_is_found() {
    let mut text = "t_s,ax_mps2,ay_mps2,az_mps2\n".to_owned();
    for i in 0..12_000 {
        let noise = 0.02 * f64::from(i * 7919 % 61) / 61.0;
        text += &format!(
            "{:.5},{noise:.5},{:.5},{:.5}\n",
            f64::from(i) / 4000.0,
            -noise,
            9.8 + noise
        );
    }
    let result = stream(text.as_bytes(), &MotionOptions::default())
        .unwrap()
        .0
        .result;
    let mut said = result.findings.iter().map(|f| &f.message);
    assert!(
        said.any(|m| m.contains("--causal finds no rests at 4000 Hz") && m.contains("--rests")),
        "{:?}",
        result.findings
    );
}

#[test]
fn a_ride_at_constant_speed_is_none_for_long() {
    let options = MotionOptions::default();
    let said = |result: &MotionResult| {
        let mut kinds = result.findings.iter().map(|f| f.kind);
        kinds.any(|kind| kind == FindingKind::RestAtSpeed)
    };
    // Quiet for 4 s at 0.5 m/s: 2 m, and two halves of half a second.
    let short = stream(&ride(4.0), &options).unwrap().0.result;
    let end = short.r#final.position_m.unwrap();
    assert!((end[0] - 2.25).abs() < 0.1 && !said(&short), "{end:?}");
    // For 20 s it is taken for a rest, and that is said.
    let long = stream(&ride(20.0), &options).unwrap().0.result;
    assert!(said(&long) && long.moves[0].reason.is_some());
}

#[test]
fn mean_off_and_no_correction_is_the_batch() {
    let bytes = line(1);
    let options = MotionOptions {
        smooth: Vec::new(),
        ..MotionOptions::report()
    };
    let batch = batch(&bytes, &options);
    let (done, table) = stream(&bytes, &options).unwrap();
    let end = done.result.r#final;
    close(
        end.position_m.unwrap(),
        batch.result.r#final.position_m.unwrap(),
        1e-9,
    );
    close(
        end.velocity_mps.unwrap(),
        batch.result.r#final.velocity_mps.unwrap(),
        1e-9,
    );
    let [a, b] = [&done.result.moves[0], &batch.result.moves[0]];
    close(a.displacement_m.unwrap(), b.displacement_m.unwrap(), 1e-9);
    assert_eq!((a.start_s, a.end_s, a.ends), (b.start_s, b.end_s, b.ends));
    // In the table to the last digit; before its mean is known there is nothing.
    let p = columns(&table, "px_m");
    assert_eq!(p.len(), batch.track.position_m.len());
    for (i, (a, b)) in p.iter().zip(&batch.track.position_m).enumerate() {
        assert_eq!(a[0].is_nan(), i < 499, "{i}");
        assert!(i < 499 || norm(&sub(a, b)) < 1e-6, "{i}: {a:?} {b:?}");
    }
    let f = columns(&table, "ax_mps2");
    assert!((f[700][2] - batch.track.force_mps2[2][700]).abs() < 1e-6);
}

#[test]
fn found_on_the_way_the_move_is_about_as_long() {
    // Not the same: the tilt that is missing at the second rest, and what the velocity
    // there tells of it, put the batch's move right and not this one.
    for seed in 0..10 {
        let bytes = line(seed);
        let batch = batch(&bytes, &MotionOptions::default());
        let (done, table) = stream(&bytes, &MotionOptions::default()).unwrap();
        let result = &done.result;
        assert_eq!(result.moves.len(), 1, "{:?}", result.moves);
        assert_eq!(result.rests.len(), 2);
        let a = result.moves[0].displacement_m.unwrap();
        let b = batch.result.moves[0].displacement_m.unwrap();
        let sigma = norm(&batch.result.moves[0].sigma_m.unwrap());
        assert!(
            norm(&sub(&a, &b)) < 4.0 * sigma.max(0.01),
            "{a:?} {b:?} {sigma}"
        );
        assert_eq!(result.r#final.velocity_mps, Some([0.0; 3]));
        let still = table.lines().filter(|l| l.split(',').nth(4) == Some("1"));
        assert!(still.count() > 800);
    }
}

#[test]
fn causal_filters_and_those_that_are_not() {
    let bytes = line(4);
    let smooth = |text: &str| MotionOptions {
        smooth: vec![text.parse().unwrap()],
        ..MotionOptions::default()
    };
    let plain = stream(&bytes, &MotionOptions::default()).unwrap().0;
    for filter in ["savgol:5,2", "mean:5", "butter1:2,20Hz"] {
        let done = stream(&bytes, &smooth(filter)).unwrap().0;
        let a = done.result.moves[0].displacement_m.unwrap();
        let b = plain.result.moves[0].displacement_m.unwrap();
        assert!(norm(&sub(&a, &b)) < 0.02, "{filter}: {a:?} {b:?}");
    }
    for filter in ["butter:2,20Hz", "hampel:5,3"] {
        assert_eq!(
            stream(&bytes, &smooth(filter)).unwrap_err().code(),
            "not-causal"
        );
    }
}

#[test]
fn a_gap_in_the_move_loses_the_place_and_nothing_else() {
    let bytes = line(5);
    let text = String::from_utf8(bytes).unwrap();
    let kept: Vec<&str> = text
        .lines()
        .enumerate()
        .filter(|(i, _)| !(600..660).contains(i))
        .map(|(_, line)| line)
        .collect();
    let holed = kept.join("\n");
    let (done, _) = stream(holed.as_bytes(), &MotionOptions::default()).unwrap();
    assert!(done.result.moves.iter().all(|m| !m.usable));
    assert_eq!(done.result.r#final.position_m, None);
    assert_eq!(done.result.r#final.velocity_mps, Some([0.0; 3]));
    let kinds: Vec<&str> = done.result.findings.iter().map(|f| f.kind.name()).collect();
    assert!(kinds.contains(&"move-unusable") && kinds.contains(&"gap"));
}

#[test]
fn what_is_no_sample_is_stepped_over_and_a_tail_of_zeros_is_none() {
    let bytes = line(6);
    let text = String::from_utf8(bytes.clone()).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let last_t: f64 = lines
        .last()
        .unwrap()
        .split(',')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    let fields = lines[1].split(',').count();
    // A cell that is empty, a stamp that runs backwards, a board that stopped.
    let mut cells: Vec<&str> = lines[300].split(',').collect();
    cells[1] = "";
    lines[300] = cells.join(",");
    for k in 1..40 {
        let zeros = vec!["0"; fields - 1].join(",");
        lines.push(format!("{},{zeros}", last_t + 10.0 * f64::from(k)));
    }
    let (plain, _) = stream(&bytes, &MotionOptions::default()).unwrap();
    let (done, table) = stream(lines.join("\n").as_bytes(), &MotionOptions::default()).unwrap();
    assert_eq!(done.result.rows_left_out, 1);
    assert_eq!(table.lines().count() as u64, done.result.rows);
    let a = done.result.r#final.position_m.unwrap();
    let b = plain.result.r#final.position_m.unwrap();
    assert!(norm(&sub(&a, &b)) < 1e-3, "{a:?} {b:?}");
    assert_eq!(done.result.rests.len(), plain.result.rests.len());
}
