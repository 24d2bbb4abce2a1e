//! How accurate position is, by experiment:
//!
//!     cargo run --release -p gravical --example motion_accuracy -- [SEEDS]
//!
//! It prints the tables of docs/accuracy.md; with `--closures` only that of disturbances, with
//! `--walks` only that of walks.

mod closures;
mod recording;
mod runs;
mod walks;

use gravical::motion::MotionOptions;
use runs::{Cell, Gyro, line, run};

type AnyError = Box<dyn std::error::Error>;

fn main() -> Result<(), AnyError> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let seeds: u64 = args.iter().find_map(|a| a.parse().ok()).unwrap_or(1000);
    if args.iter().any(|a| a == "--closures") {
        return closures::print(seeds);
    }
    if args.iter().any(|a| a == "--walks") {
        return walks::print(seeds);
    }
    println!("| move | found once | along, mm | across, mm | up, mm |");
    println!("|---|---|---|---|---|");
    for cell in &errors() {
        let out = run(cell, 1..seeds + 1)?;
        println!(
            "| {} | {} of {} | {:.2} | {:.2} | {:.2} |",
            cell.name,
            out.found,
            out.runs,
            out.rms_mm(0),
            out.rms_mm(1),
            out.rms_mm(2),
        );
    }
    println!();
    println!("| move | within 1σ, % | within 2σ, % | along | across | up |");
    println!("|---|---|---|---|---|---|");
    for cell in &coverage() {
        let out = run(cell, 1..seeds + 1)?;
        let share = |k: f64, axes: std::ops::Range<usize>| 100.0 * out.covered(k, axes);
        println!(
            "| {} | {:.1} | {:.1} | {:.1}, {:.1} | {:.1}, {:.1} | {:.1}, {:.1} |",
            cell.name,
            share(1.0, 0..3),
            share(2.0, 0..3),
            share(1.0, 0..1),
            share(2.0, 0..1),
            share(1.0, 1..2),
            share(2.0, 1..2),
            share(1.0, 2..3),
            share(2.0, 2..3),
        );
    }
    println!();
    closures::print(seeds)?;
    println!();
    walks::print(seeds)
}

/// Cells whose errors are reported.
fn errors() -> Vec<Cell> {
    let by_hand = MotionOptions {
        rests_s: Some(vec![(0.0, 5.0), (7.01, 13.0)]),
        ..MotionOptions::default()
    };
    let wobble = Cell {
        tilt_change_deg: 3.0,
        ..line()
    };
    let smoothed = |name: &'static str, filter: &str| Cell {
        name,
        options: MotionOptions {
            smooth: filter.parse().into_iter().collect(),
            ..MotionOptions::default()
        },
        ..line()
    };
    let plain = MotionOptions {
        smooth: Vec::new(),
        ..MotionOptions::report()
    };
    let report = |name: &'static str, options: MotionOptions, at_end_of_move: bool| Cell {
        name,
        options,
        at_end_of_move,
        ..line()
    };
    vec![
        line(),
        Cell {
            name: "rests known to the sample",
            options: by_hand,
            ..line()
        },
        Cell {
            name: "2 % of the rows lost, stamps ±1 ms",
            dropped: 0.02,
            jitter_ms: 1.0,
            ..line()
        },
        smoothed("smoothed by savgol:5,2", "savgol:5,2"),
        smoothed("smoothed by savgol:21,2", "savgol:21,2"),
        smoothed("smoothed by butter:4,5Hz", "butter:4,5Hz"),
        Cell {
            name: "tilt change of 3°, gyroscope exact",
            ..wobble.clone()
        },
        Cell {
            name: "tilt change of 3°, gyroscope calibrated to 0.3 %",
            gyro: Gyro::Calibrated,
            ..wobble.clone()
        },
        Cell {
            name: "tilt change of 3°, gyroscope uncalibrated, within ±3 %",
            gyro: Gyro::Uniform,
            ..wobble.clone()
        },
        Cell {
            name: "in 4 s",
            move_s: 4.0,
            ..line()
        },
        Cell {
            name: "in 8 s",
            move_s: 8.0,
            ..line()
        },
        Cell {
            name: "in 12 s",
            move_s: 12.0,
            ..line()
        },
        Cell {
            name: "in 16 s",
            move_s: 16.0,
            ..line()
        },
        report(
            "the report's procedure, read at the end of the move",
            MotionOptions::report(),
            true,
        ),
        report(
            "… read 5 s later, at the end of the file",
            MotionOptions::report(),
            false,
        ),
        report("… without smoothing", plain, false),
        Cell {
            name: "the report's procedure, tilt change of 3°",
            options: MotionOptions::report(),
            ..wobble
        },
    ]
}

/// Cells whose bands are judged: the parameters are off by draws from their
/// covariance.
fn coverage() -> Vec<Cell> {
    let drawn = Cell {
        exact: false,
        gyro: Gyro::Calibrated,
        ..line()
    };
    vec![
        Cell {
            name: "parameters exact",
            ..line()
        },
        Cell {
            name: "parameters drawn",
            ..drawn.clone()
        },
        Cell {
            name: "tilt change of 3°, parameters drawn",
            tilt_change_deg: 3.0,
            ..drawn.clone()
        },
        Cell {
            name: "tilt change of 3°, gyroscope uncalibrated, by its data sheet",
            tilt_change_deg: 3.0,
            gyro: Gyro::DataSheet,
            ..drawn.clone()
        },
        Cell {
            name: "in 4 s, tilt change of 3°",
            move_s: 4.0,
            tilt_change_deg: 3.0,
            ..drawn
        },
    ]
}
