//! Whatever the bytes, nothing panics, and rows and lines set aside are all lines.

use std::io::Cursor;

use gravical_recording::{Recording, bytes};
use proptest::prelude::*;

/// Reads and counts; the lines of the text are counted anew.
fn check(input: Vec<u8>) {
    let mut text = String::new();
    let mut utf8 = bytes::utf8(Cursor::new(input.clone())).unwrap();
    if std::io::Read::read_to_string(&mut utf8, &mut text).is_err() {
        return;
    }
    let utf8 = bytes::utf8(Cursor::new(input)).unwrap();
    if let Ok(recording) = Recording::read(utf8, "any.csv") {
        let end = if text.contains('\n') { '\n' } else { '\r' };
        let lines = text.matches(end).count() + usize::from(!text.ends_with(end));
        assert_eq!(recording.aside.lines, lines);
        assert_eq!(recording.rows() + recording.aside.total(), lines);
        assert!(recording.accel.iter().all(|c| c.len() == recording.rows()));
        assert!(recording.time_s.is_empty() || recording.time_s.len() == recording.rows());
        assert!(
            recording
                .breaks
                .iter()
                .all(|b| (1..recording.rows()).contains(b))
        );
    }
}

proptest! {
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
