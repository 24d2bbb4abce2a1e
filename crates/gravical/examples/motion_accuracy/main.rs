//! How accurate position is, by experiment:
//!
//!     cargo run --release -p gravical --example motion_accuracy -- [SEEDS]

mod runs;

use gravical::motion::MotionOptions;
use runs::{Cell, Gyro, run};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seeds: u64 = std::env::args().nth(1).map_or(Ok(1000), |s| s.parse())?;
    let line = Cell {
        name: "0.7 m in 2 s",
        move_s: 2.0,
        wobble_deg: 0.0,
        gyro: Gyro::Calibrated,
        dropped: 0.0,
        jitter_ms: 0.0,
        options: MotionOptions::default(),
        at_end_of_move: false,
    };
    let mut by_hand = MotionOptions::default();
    by_hand.rests.given_s = Some(vec![(0.0, 5.0), (7.01, 13.0)]);
    let cells = [
        line.clone(),
        Cell {
            name: "rests by the truth",
            options: by_hand,
            ..line.clone()
        },
        Cell {
            name: "wobble of 3°, gyroscope calibrated",
            wobble_deg: 3.0,
            ..line.clone()
        },
        Cell {
            name: "wobble of 3°, gyroscope within ±3 %",
            wobble_deg: 3.0,
            gyro: Gyro::Uniform,
            ..line.clone()
        },
        Cell {
            name: "wobble of 3°, gyroscope by data sheet",
            wobble_deg: 3.0,
            gyro: Gyro::DataSheet,
            ..line.clone()
        },
        Cell {
            name: "in 4 s",
            move_s: 4.0,
            ..line.clone()
        },
        Cell {
            name: "in 12 s",
            move_s: 12.0,
            ..line.clone()
        },
        Cell {
            name: "in 16 s",
            move_s: 16.0,
            ..line.clone()
        },
        Cell {
            name: "2 % of the rows lost, ±1 ms",
            dropped: 0.02,
            jitter_ms: 1.0,
            ..line.clone()
        },
        Cell {
            name: "the report's procedure, at the end of the file",
            options: MotionOptions::report(),
            ..line.clone()
        },
        Cell {
            name: "the report's procedure, at the end of the move",
            options: MotionOptions::report(),
            at_end_of_move: true,
            ..line.clone()
        },
    ];
    println!("| cell | found | along mm | across mm | up mm | within 1σ % | within 2σ % |");
    println!("|---|---|---|---|---|---|---|");
    for cell in &cells {
        let out = run(cell, 1..seeds + 1)?;
        println!(
            "| {} | {}/{} | {:.2} | {:.2} | {:.2} | {:.1} | {:.1} |",
            cell.name,
            out.found,
            out.runs,
            out.rms_mm(0),
            out.rms_mm(1),
            out.rms_mm(2),
            100.0 * out.covered(1.0, 0..3),
            100.0 * out.covered(2.0, 0..3),
        );
    }
    Ok(())
}
