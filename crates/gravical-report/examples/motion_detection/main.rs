//! Which moves are found, which are missed, and how often what is said is wrong:
//!
//!     cargo run --release -p gravical --example motion_detection -- [SEEDS] [--batch]
//!         [--figure=FILE] [--gyro=1] [--profile=0..3] [--rest=5] [--move=2] [--way=0.05]
//!
//! It prints the cells that docs/accuracy.md sums up, as CSV; with `--batch` without
//! `--causal`, with `--figure` it draws those of the smoothest move.

mod map;
mod moves;
#[path = "../../../gravical/examples/motion_accuracy/runs.rs"]
#[allow(dead_code)]
mod runs;

use std::sync::atomic::{AtomicUsize, Ordering};

use gravical::calibration_file::CalibrationFile;
use gravical::motion::{Calibrated, MotionOptions, MotionResult, motion, motion_stream};
use gravical::recording::{ReadOptions, open::from_reader};
use moves::{Cell, Profile};

type AnyError = Box<dyn std::error::Error>;

const WAYS_M: [f64; 8] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0];
const MOVES_S: [f64; 6] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0];
const RESTS_S: [f64; 4] = [0.3, 1.0, 5.0, 60.0];

/// What came of one way of computing, over the seeds of a cell.
#[derive(Default, Clone, Copy)]
struct Outcome {
    runs: u32,
    /// Without any move where there is one.
    missed: u32,
    /// More than one move.
    pieces: u32,
    /// End further from the truth than 4σ, in any direction; without bands: by more
    /// than half of the way and 4 times what noise and edges may do.
    wrong: u32,
    /// Said not to be usable, or that no position is known.
    unusable: u32,
    /// Sum of the squares of onset's error, s².
    onset: f64,
    onsets: u32,
    /// Largest error of the end, m.
    worst_m: f64,
}

impl Outcome {
    fn add(&mut self, cell: &Cell, result: &MotionResult, sigma_m: Option<f64>) {
        self.runs += 1;
        let (from, to) = (cell.rest_s, cell.rest_s + cell.move_s);
        let moves: Vec<_> = result
            .moves
            .iter()
            .filter(|m| m.end_s > from && m.start_s < to)
            .collect();
        self.missed += u32::from(moves.is_empty());
        self.pieces += u32::from(result.moves.len() > 1);
        if let Some(first) = moves.first() {
            self.onset += (first.start_s - from).powi(2);
            self.onsets += 1;
        }
        let end = result.r#final.position_m;
        let unusable = result.moves.iter().any(|m| !m.usable);
        let Some(p) = end.filter(|_| !unusable) else {
            self.unusable += 1;
            return;
        };
        let truth = [0.0, cell.way_m, 0.0];
        let sigma = result.r#final.sigma_m;
        let off = |i: usize| (p[i] - truth[i]).abs();
        let wrong = (0..3).any(|i| match (sigma_m, sigma) {
            (Some(s), _) => off(i) > 4.0 * s + 0.5 * cell.way_m,
            (None, Some(s)) => off(i) > 4.0 * s[i],
            (None, None) => true,
        });
        self.wrong += u32::from(wrong);
        self.worst_m = (0..3).fold(self.worst_m, |w, i| w.max(off(i)));
    }
}

fn run(
    cell: &Cell,
    seeds: u64,
    file: &CalibrationFile,
    causal: bool,
) -> Result<[Outcome; 2], AnyError> {
    let calibrated = Some(Calibrated {
        file,
        name: "truth",
    });
    let options = MotionOptions {
        clock_error: 0.0,
        ..MotionOptions::default()
    };
    let mut out = [Outcome::default(); 2];
    for seed in 1..=seeds {
        let recording = cell.recording(seed)?;
        let batch = motion(&recording, calibrated, &options)?.result;
        out[0].add(cell, &batch, None);
        if !causal {
            continue;
        }
        let text = cell.text(seed)?;
        let input = from_reader(Box::new(std::io::Cursor::new(text)), false)?;
        let causal = motion_stream(
            input,
            "simulated.csv",
            &ReadOptions::default(),
            calibrated,
            &options,
            None,
        )?;
        // Open from the rest before, as noise walks.
        let t = cell.move_s + 1.0;
        let noise = moves::ACCEL_NOISE
            * (t.powi(3) / 3.0 + t.powi(4) / (4.0 * cell.rest_s.min(5.0))).sqrt();
        let tilt =
            9.8 * 8.7e-5 * (t.powi(5) / 20.0 + t.powi(6) / (36.0 * cell.rest_s.min(5.0))).sqrt();
        out[1].add(cell, &causal.result, Some(noise.hypot(tilt)));
    }
    Ok(out)
}

fn main() -> Result<(), AnyError> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let seeds: u64 = args.iter().find_map(|a| a.parse().ok()).unwrap_or(40);
    let only = |name: &str, value: f64| {
        args.iter()
            .find_map(|a| a.strip_prefix(name)?.parse::<f64>().ok())
            .is_none_or(|v| v == value)
    };
    let causal = !args.iter().any(|a| a == "--batch");
    let mut cells = Vec::new();
    for gyro in [true, false] {
        for profile in Profile::ALL {
            for rest_s in RESTS_S {
                for move_s in MOVES_S {
                    for way_m in WAYS_M {
                        let keep = only("--way=", way_m)
                            && only("--move=", move_s)
                            && only("--rest=", rest_s)
                            && only("--gyro=", f64::from(u8::from(gyro)))
                            && only("--profile=", profile as u8 as f64);
                        let cell = Cell {
                            way_m,
                            move_s,
                            rest_s,
                            profile,
                            gyro,
                        };
                        if keep && cell.is_in_range() {
                            cells.push(cell);
                        }
                    }
                }
            }
        }
    }
    let file = runs::calibration([1e-6; 3], Some([1e-6; 2]))?;
    let next = AtomicUsize::new(0);
    let work = || -> Result<Vec<(usize, [Outcome; 2])>, String> {
        let mut done = Vec::new();
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            let Some(cell) = cells.get(k) else {
                return Ok(done);
            };
            done.push((
                k,
                run(cell, seeds, &file, causal).map_err(|e| format!("{cell:?}: {e}"))?,
            ));
        }
    };
    let mut all = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..2).map(|_| scope.spawn(work)).collect();
        let mut all = Vec::new();
        for thread in threads {
            all.extend(thread.join().map_err(|_| "a thread panicked")??);
        }
        Ok::<_, AnyError>(all)
    })?;
    all.sort_by_key(|(k, _)| *k);
    if let Some(path) = args.iter().find_map(|a| a.strip_prefix("--figure=")) {
        let drawn = all.iter().map(|(k, [batch, _])| (&cells[*k], batch));
        std::fs::write(path, map::figure(&drawn.collect::<Vec<_>>()))?;
    }
    println!(
        "gyro,profile,rest,move,way,snr,runs,missed,pieces,wrong,unusable,onset_ms,worst_m,c_missed,c_pieces,c_wrong,c_onset_ms,c_worst_m"
    );
    for (k, [batch, causal]) in &all {
        let c = &cells[*k];
        let onset = |o: &Outcome| 1e3 * (o.onset / f64::from(o.onsets.max(1))).sqrt();
        println!(
            "{},{},{},{},{},{:.1},{},{},{},{},{},{:.0},{:.3},{},{},{},{:.0},{:.3}",
            u8::from(c.gyro),
            c.profile.name(),
            c.rest_s,
            c.move_s,
            c.way_m,
            c.sigmas(),
            batch.runs,
            batch.missed,
            batch.pieces,
            batch.wrong,
            batch.unusable,
            onset(batch),
            batch.worst_m,
            causal.missed,
            causal.pieces,
            causal.wrong,
            onset(causal),
            causal.worst_m,
        );
    }
    Ok(())
}
