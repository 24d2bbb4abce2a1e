//! Whatever the bytes, nothing panics, and rows and lines set aside are all lines.

use std::io::{Cursor, Read};

use gravical_recording::{ReadOptions, encoding, read_bytes};
use proptest::prelude::*;

use crate::support::six_faces;

/// Reads and counts; the lines of the text are counted anew.
fn check(input: Vec<u8>) {
    let mut text = String::new();
    let reader = encoding::utf8(Cursor::new(input.clone()));
    if !reader.is_ok_and(|mut reader| reader.read_to_string(&mut text).is_ok()) {
        return;
    }
    if let Ok(recording) = read_bytes(&input, "any.csv", &ReadOptions::default()) {
        let end = if text.contains('\n') { '\n' } else { '\r' };
        let lines = text.matches(end).count() + usize::from(!text.ends_with(end));
        assert_eq!(recording.ledger.lines, lines);
        assert_eq!(recording.rows() + recording.ledger.total(), lines);
        assert!(recording.accel.iter().all(|c| c.len() == recording.rows()));
        let times = recording.time_s.as_ref();
        assert!(times.is_none_or(|t| t.len() == recording.rows()));
        let mut breaks = recording.breaks.iter();
        assert!(breaks.all(|b| (1..recording.rows()).contains(b)));
    }
}

/// Lines of a recording.
fn lines() -> String {
    let rows = six_faces(5).into_iter().enumerate().map(|(k, row)| {
        let ([x, y, z], [gx, gy, gz]) = (row.accel_g, row.gyro_deg_s);
        format!("{},{x:.4},{y:.4},{z:.4},{gx:.2},{gy:.2},{gz:.2}\n", 40 * k)
    });
    "ms,ax (g),ay (g),az (g),gx,gy,gz\n".to_owned() + &rows.collect::<String>()
}

#[test]
fn lines_without_end_take_no_longer_for_it() {
    for piece in ["1:", "1x-", "1-", "a1.", "\"1", "1,", "\u{2212}"] {
        check(piece.repeat(100_000).into_bytes());
    }
}

proptest! {
    #[test]
    fn torn_recordings(cuts in proptest::collection::vec((0.0..1.0, 0..200_usize, any::<u8>()), 1..12)) {
        let mut input = lines().into_bytes();
        for (at, length, byte) in cuts {
            let from = (at * input.len() as f64) as usize;
            let to = (from + length).min(input.len());
            input.splice(from..to, [byte]);
        }
        check(input);
    }

    #[test]
    fn any_bytes(input in proptest::collection::vec(any::<u8>(), 0..600)) {
        check(input);
    }

    #[test]
    fn pieces_of_recordings(pieces in proptest::collection::vec(prop_oneof![
        Just("1,2,3\n"), Just("0.1 0.2 9.8\r\n"), Just("ax,ay,az\n"), Just("t;ax;ay;az\n"),
        Just("\n"), Just("# gap: 1\n"), Just("2024-01-01 10:00:00.0,0.1,0.2,1.0\n"),
        Just("ax = 0.1, ay = 0.2, az = 0.9\n"), Just("acc X: 1.0\n"), Just("acc Y: 1.0\n"),
        Just("1e999,-inf,nan\n"), Just("\"a,b\",1,2\n"), Just("\u{2212}1,5;2;3\n"), Just("°\r"),
        Just("0,0,0,0\n"), Just("5,0.1,0.2,1.0\n"), Just("6,0.1,0.2,1.0\n"), Just(","),
        Just("1617000000,1617000000,1617000000\n"), Just("1,1,1\n"), Just("\0\0"), Just("*4A\n"),
    ], 0..40)) {
        check(pieces.concat().into_bytes());
    }
}
