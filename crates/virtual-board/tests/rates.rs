//! What gets through at which rate, and that the rest is counted.
#![cfg(feature = "emulator")]
#![allow(clippy::unwrap_used)] // helpers of a test may panic as it does

mod board;

use board::{board, notices, print_rate};
use virtual_board::sensor::SensorOptions;

#[test]
fn too_fast_is_said() {
    let Some(mut board) = board(SensorOptions::default()) else {
        return;
    };
    board.run(0.5);
    board.uno.send(b"r250\n");
    board.run(0.3);
    let (samples, unread) = board.uno.sensor().samples();
    let text = board.text(5.0);
    let lines = notices(&text);
    let overruns = |l: &&str| {
        l.strip_prefix("# overruns ")?
            .split(',')
            .next()?
            .parse()
            .ok()
    };
    let reported: Vec<u64> = lines.iter().filter_map(overruns).collect();
    let (all, lost) = board.uno.sensor().samples();
    let lost = lost - unread;
    assert!(lost < all - samples, "{lost}");
    let (first, last) = (reported[0], reported[reported.len() - 1]);
    // Reported once a second: the first and the last are up to a second apart from
    // the ends.
    let share = (last - first) as f64 / lost as f64;
    assert!((0.5..1.05).contains(&share), "{share}");
}

#[test]
#[ignore = "prints the figures of docs/firmware.md"]
fn figures() {
    for (format, rates) in [(0, &[100, 125, 166, 200, 250][..]), (1, &[200, 250])] {
        for rate in rates {
            // As far off as the data sheet allows, so that stamps meet every phase.
            let Some(mut board) = board(SensorOptions {
                clock_error_ppm: 3100.0,
                ..SensorOptions::default()
            }) else {
                return;
            };
            print_rate(&mut board, format, *rate);
        }
    }
}
