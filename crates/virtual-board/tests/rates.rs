//! What gets through at which rate, and that the rest is counted.
#![cfg(feature = "emulator")]
#![allow(clippy::unwrap_used)] // helpers of a test may panic as it does

mod board;

use board::{board, line, notices, report, rows, text};
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
    let text = text(&board.run(5.0));
    let lines = notices(&text);
    let reported: Vec<u64> = lines
        .iter()
        .filter_map(|l| {
            l.strip_prefix("# overruns ")?
                .split(',')
                .next()?
                .parse()
                .ok()
        })
        .collect();
    let (all, lost) = board.uno.sensor().samples();
    let (all, lost) = (all - samples, lost - unread);
    let (first, last) = (reported[0], reported[reported.len() - 1]);
    eprintln!("{lost} of {all} lost, reported {first} to {last}");
    // Reported once a second: the first and the last are up to a second apart from
    // the ends.
    let share = (last - first) as f64 / lost as f64;
    assert!((0.5..1.05).contains(&share), "{share}");
}

#[test]
#[ignore = "prints the figures of docs/firmware.md"]
fn figures() {
    for (format, rate) in [
        (0, 100),
        (0, 125),
        (0, 166),
        (0, 200),
        (0, 250),
        (1, 200),
        (1, 250),
    ] {
        // As far off as the data sheet allows, so that stamps meet every phase.
        let Some(mut board) = board(SensorOptions {
            clock_error_ppm: 3100.0,
            ..SensorOptions::default()
        }) else {
            return;
        };
        board.run(0.5);
        board.uno.send(format!("r{rate}\nf{format}\n").as_bytes());
        board.run(0.5);
        board.uno.take_bus();
        let (all, lost) = board.uno.sensor().samples();
        let sent = board.run(4.0);
        let (all_now, lost_now) = board.uno.sensor().samples();
        let text = text(&sent);
        let rows = rows(text.split_once('\n').unwrap().1);
        let stamps: Vec<f64> = rows.iter().map(|r| r[0] * 1e3).collect();
        let (rate_hz, sd_us) = line(&stamps);
        let what = format!(
            "format {format} rate {rate}: {} of {} lost",
            lost_now - lost,
            all_now - all
        );
        report(&mut board, &what, rate_hz, sd_us, sent.len(), 4.0);
    }
}
