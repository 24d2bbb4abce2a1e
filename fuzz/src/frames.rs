//! Frames of the board's binary format.

use gravical::recording::frame::{
    Frame, MOST_BYTES, SampleFrame, Unwrap, decode_frame, encode_frame,
};

/// What a board may send, cut at its zeros, and the whole as one frame: what is
/// accepted says the same when it is sent again. Any sample is read back as it was,
/// and stamps never run backwards.
pub fn frame(data: &[u8]) {
    same_again(data);
    for piece in data.split_inclusive(|b| *b == 0) {
        same_again(piece);
    }
    let mut clock = Unwrap::default();
    let mut last_us = 0;
    for bytes in data.chunks_exact(19) {
        let word = |at: usize| i16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let sample = SampleFrame {
            sequence: bytes[0],
            time_us: u32::from_le_bytes([bytes[1], bytes[2], bytes[3], bytes[4]]),
            accel: [word(5), word(7), word(9)],
            temperature: word(11),
            gyro: [word(13), word(15), word(17)],
        };
        let wire = encode_frame(&Frame::Sample(sample));
        let (end, stuffed) = match wire.split_last() {
            Some(parts) => parts,
            None => unreachable!("nothing is sent"),
        };
        assert!(*end == 0 && !stuffed.contains(&0), "{wire:?}");
        assert_eq!(wire.len(), 24);
        for bytes in [stuffed, &wire[..]] {
            match decode_frame(bytes) {
                Ok(again) => assert_eq!(again, Frame::Sample(sample)),
                Err(e) => unreachable!("{sample:?}: {e}"),
            }
        }
        let now_us = clock.time_us(sample.time_us);
        assert!(now_us >= last_us && now_us % (1 << 32) == u64::from(sample.time_us));
        last_us = now_us;
    }
}

fn same_again(bytes: &[u8]) {
    let Ok(frame) = decode_frame(bytes) else {
        return;
    };
    let wire = encode_frame(&frame);
    // Text that is no UTF-8 grows when its bytes are replaced.
    if wire.len() > MOST_BYTES {
        assert!(matches!(frame, Frame::Text(_)), "{frame:?}");
        return;
    }
    match decode_frame(&wire) {
        Ok(again) => assert_eq!(again, frame),
        Err(e) => unreachable!("{frame:?}: {e}"),
    }
}
