//! Frames of the board's binary format, each with one sample or one line of text.
//!
//! # The frame
//!
//! | bytes | sample | text |
//! |---|---|---|
//! | 0 | 1 | 2 |
//! | 1 | sequence, 0 after 255 | the line, ASCII, without its end |
//! | 2–5 | stamp of data-ready, µs, 0 after 2³² − 1 | … |
//! | 6–19 | seven counts, 16 bits: acceleration x, y, z; temperature; angular rate x, y, z | … |
//! | last 2 | CRC-16 of all before it | the same |
//!
//! Numbers are little-endian. The CRC is CRC-16/IBM-3740 (polynomial 0x1021, start 0xFFFF; also
//! known as CCITT-FALSE). Zeros are removed by consistent overhead byte stuffing (S. Cheshire and
//! M. Baker, IEEE/ACM Trans. Networking 7(2), 1999), and one zero ends the frame: a receiver
//! synchronises at the next zero. An encoded sample has 24 bytes.
//!
//! Lines that begin with `#` in the text formats (settings, counters) are sent as text frames.
//!
//! # Example
//!
//! ```
//! use gravical::recording::frame::{Frame, decode_frame, encode_frame};
//!
//! let line = Frame::Text("# overruns 1".to_owned());
//! let wire = encode_frame(&line);
//! let (end, stuffed) = wire.split_last().ok_or("empty")?;
//! assert_eq!(*end, 0);
//! assert_eq!(decode_frame(stuffed)?, line);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crc::{CRC_16_IBM_3740, Crc};

use crate::{Error, Result};

const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

const SAMPLE: u8 = 1;
const TEXT: u8 = 2;

/// Largest number of bytes between two zeros; the longest line of the board has 160.
pub const MOST_BYTES: usize = 1024;

/// Content of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Frame {
    /// One sample.
    Sample(SampleFrame),
    /// One line of text, without its end.
    Text(String),
}

/// One sample as the sensor measured it, in counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleFrame {
    /// Counter of the frames, modulo 256: a step other than 1 shows lost frames.
    pub sequence: u8,
    /// Time of data-ready on the board's clock, µs, modulo 2³² (71.6 min); [`Unwrap`] makes it
    /// continuous.
    pub time_us: u32,
    /// Specific force along x, y, z, counts of the range in the board's settings line.
    pub accel: [i16; 3],
    /// Temperature, counts; the conversion to °C is that of the sensor in the board's settings
    /// line ([`BoardSettings::celsius`](super::board::BoardSettings::celsius)).
    pub temperature: i16,
    /// Angular rate about x, y, z, counts of the range in the board's settings line.
    pub gyro: [i16; 3],
}

/// Decodes the bytes between two zeros, optionally with the second zero.
///
/// # Errors
///
/// `bad-frame` (input) for invalid byte stuffing, a wrong checksum, an unknown kind and a length
/// that does not match the kind. Decoding can continue at the next zero.
pub fn decode_frame(bytes: &[u8]) -> Result<Frame> {
    if bytes.len() > MOST_BYTES {
        return Err(bad(format!(
            "{} bytes without a zero, {MOST_BYTES} at most",
            bytes.len()
        )));
    }
    let mut plain = vec![0; bytes.len()];
    let length = match cobs::decode(bytes, &mut plain) {
        Ok(decoded) if decoded.parsed_size() >= bytes.len() => decoded.frame_size(),
        Ok(_) => return Err(bad("a zero in the middle".to_owned())),
        Err(_) if bytes.is_empty() => 0,
        Err(_) => return Err(bad(format!("{} bytes are not stuffed", bytes.len()))),
    };
    plain.truncate(length);
    let Some((body, &crc)) = plain.split_last_chunk::<2>() else {
        return Err(bad(format!("{length} bytes are not a frame")));
    };
    let (sent, computed) = (u16::from_le_bytes(crc), CRC.checksum(body));
    if sent != computed {
        return Err(bad(format!(
            "checksum 0x{sent:04x}, but 0x{computed:04x} fits its {} bytes",
            body.len()
        )));
    }
    match body {
        [SAMPLE, rest @ ..] => sample(rest)
            .map(Frame::Sample)
            .ok_or_else(|| bad(format!("a sample of {} bytes", body.len()))),
        [TEXT, line @ ..] => Ok(Frame::Text(String::from_utf8_lossy(line).into_owned())),
        [kind, ..] => Err(bad(format!("kind {kind}"))),
        [] => Err(bad("it is empty".to_owned())),
    }
}

/// Encodes a frame as the board does, including the zero at its end.
#[must_use]
pub fn encode_frame(frame: &Frame) -> Vec<u8> {
    let mut plain = Vec::with_capacity(24);
    match frame {
        Frame::Sample(sample) => {
            plain.extend([SAMPLE, sample.sequence]);
            plain.extend(sample.time_us.to_le_bytes());
            let temperature = [sample.temperature];
            for count in sample.accel.iter().chain(&temperature).chain(&sample.gyro) {
                plain.extend(count.to_le_bytes());
            }
        }
        Frame::Text(line) => {
            plain.push(TEXT);
            plain.extend(line.as_bytes());
        }
    }
    plain.extend(CRC.checksum(&plain).to_le_bytes());
    let mut wire = cobs::encode_vec(&plain);
    wire.push(0);
    wire
}

fn sample(bytes: &[u8]) -> Option<SampleFrame> {
    let (&[sequence], rest) = bytes.split_first_chunk::<1>()?;
    let (&time_us, rest) = rest.split_first_chunk::<4>()?;
    let &[ax, bx, ay, by, az, bz, t, u, gx, hx, gy, hy, gz, hz] =
        <&[u8; 14]>::try_from(rest).ok()?;
    let count = |low, high| i16::from_le_bytes([low, high]);
    Some(SampleFrame {
        sequence,
        time_us: u32::from_le_bytes(time_us),
        accel: [count(ax, bx), count(ay, by), count(az, bz)],
        temperature: count(t, u),
        gyro: [count(gx, hx), count(gy, hy), count(gz, hz)],
    })
}

fn bad(what: String) -> Error {
    Error::input("bad-frame", format!("not a frame of the board: {what}")).with_hint(
        "decoding continues at the next zero; if this repeats, check the baud rate and the cable",
    )
}

/// Makes 32-bit stamps continuous across their wrap.
///
/// Stamps must be in order and less than 71 minutes apart; a step back is interpreted as a wrap.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwrap {
    last: Option<u64>,
}

impl Unwrap {
    /// The stamp, µs, continuous from the first one.
    pub fn time_us(&mut self, stamp_us: u32) -> u64 {
        let now = match self.last {
            None => u64::from(stamp_us),
            Some(last) => {
                // Increment modulo 2³².
                #[allow(clippy::cast_possible_truncation)]
                let step = stamp_us.wrapping_sub(last as u32);
                last + u64::from(step)
            }
        };
        self.last = Some(now);
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXAMPLE: SampleFrame = SampleFrame {
        sequence: 7,
        time_us: 0x0001_0200,
        accel: [0, -1, 16384],
        temperature: -3920,
        gyro: [i16::MIN, i16::MAX, 131],
    };

    /// The stuffed bytes were computed with a few lines of Python from the definition; the CRC of
    /// `123456789` is the check value of its catalogue.
    #[test]
    fn encoding_matches_the_definition() {
        assert_eq!(CRC.checksum(b"123456789"), 0x29b1);
        let wire = encode_frame(&Frame::Sample(EXAMPLE));
        assert_eq!(wire.len(), 24);
        assert_eq!(
            wire,
            [
                3, 1, 7, 3, 2, 1, 1, 1, 3, 255, 255, 4, 64, 176, 240, 5, 128, 255, 127, 131, 3,
                144, 236, 0
            ]
        );
        assert_eq!(wire.iter().filter(|b| **b == 0).count(), 1);
        assert_eq!(decode_frame(&wire[..23]).unwrap(), Frame::Sample(EXAMPLE));
    }

    #[test]
    fn text_round_trips() {
        for text in [
            "",
            "#",
            "# overruns 3, i2c errors 0, restarts 1",
            &"x".repeat(600),
        ] {
            let frame = Frame::Text(text.to_owned());
            let wire = encode_frame(&frame);
            assert_eq!(decode_frame(&wire[..wire.len() - 1]).unwrap(), frame);
        }
    }

    #[test]
    fn every_flipped_bit_is_detected() {
        let wire = encode_frame(&Frame::Sample(EXAMPLE));
        for at in 0..wire.len() - 1 {
            for bit in 0..8 {
                let mut corrupted = wire[..wire.len() - 1].to_vec();
                corrupted[at] ^= 1 << bit;
                assert!(decode_frame(&corrupted).is_err(), "byte {at} bit {bit}");
            }
        }
    }

    #[test]
    fn invalid_frames_are_refused() {
        let good = |plain: &[u8]| {
            let mut plain = plain.to_vec();
            plain.extend(CRC.checksum(&plain).to_le_bytes());
            cobs::encode_vec(&plain)
        };
        for (bytes, expected) in [
            (vec![], "0 bytes"),
            (vec![1], "0 bytes"),
            (vec![9, 1, 1], "not stuffed"),
            (b"0.12,9.81\r\n".to_vec(), "not stuffed"),
            (vec![1, 0, 1], "a zero in the middle"),
            (vec![1; 2000], "2000 bytes"),
            (good(&[]), "empty"),
            (good(&[9]), "kind 9"),
            (good(&[1, 2, 3]), "a sample of 3"),
            (good(&[1; 30]), "a sample of 30"),
        ] {
            let error = decode_frame(&bytes).unwrap_err();
            assert_eq!(error.code(), "bad-frame");
            assert!(error.to_string().contains(expected), "{error}");
        }
    }

    #[test]
    fn stamps_are_continuous_across_the_wrap() {
        let mut unwrap = Unwrap::default();
        assert_eq!(unwrap.time_us(u32::MAX - 4), 4_294_967_291);
        assert_eq!(unwrap.time_us(5), 4_294_967_301);
        assert_eq!(unwrap.time_us(5), 4_294_967_301);
        assert_eq!(unwrap.time_us(4), 2 * (1 << 32) + 4);
    }

    proptest::proptest! {
        #[test]
        fn any_bytes_give_a_frame_or_an_error(
            bytes in proptest::collection::vec(0_u8.., 0..300)
        ) {
            if let Ok(frame) = decode_frame(&bytes) {
                let wire = encode_frame(&frame);
                assert_eq!(decode_frame(&wire).unwrap(), frame);
            }
        }

        #[test]
        fn samples_round_trip(
            sequence: u8,
            time_us: u32,
            accel: [i16; 3],
            temperature: i16,
            gyro: [i16; 3],
        ) {
            let frame = Frame::Sample(SampleFrame {
                sequence,
                time_us,
                accel,
                temperature,
                gyro,
            });
            let wire = encode_frame(&frame);
            assert_eq!(wire.len(), 24);
            assert_eq!(decode_frame(&wire[..23]).unwrap(), frame);
            assert_eq!(decode_frame(&wire).unwrap(), frame, "with its zero");
        }
    }
}
