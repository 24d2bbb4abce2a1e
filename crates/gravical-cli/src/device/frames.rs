//! Bytes of the board's binary format ([`gravical::recording::frame`]) to messages.

use gravical::recording::frame::{Frame, MOST_BYTES, SampleFrame, Unwrap, decode_frame};

use super::item::{Item, Kind, Reason, Row};

/// The header of a recording of frames: counts, and a stamp without wraps.
pub const COLUMNS: &str = "Timestamp (us),ax,ay,az,temp,gx,gy,gz";

/// Bits a second of the binary format.
pub const BAUD: u32 = 250_000;

/// A 32-bit counter that falls from the last to the first twentieth of its range has
/// wrapped; after any other fall the board has restarted. [`Stamps`](super::stamps) and
/// the reader of recordings have the same rule.
const EDGE: u32 = u32::MAX / 20;

/// Splits bytes into frames. The beginning of the first one may not have been received.
#[derive(Debug, Clone, Default)]
pub struct Frames {
    partial: Vec<u8>,
    clock: Clock,
}

impl Frames {
    /// Takes bytes as they arrive; returns the messages that they complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Item> {
        let mut items = Vec::new();
        for &byte in bytes {
            if byte != 0 {
                self.partial.push(byte);
            }
            // Two successive zeros are an idle line.
            if (byte == 0 && !self.partial.is_empty()) || self.partial.len() >= MOST_BYTES {
                let stuffed = std::mem::take(&mut self.partial);
                items.extend(self.item(&stuffed));
            }
        }
        items
    }

    /// The frame that has begun is incomplete.
    pub fn cut(&mut self) -> Option<Item> {
        let bytes = std::mem::take(&mut self.partial);
        let half = Reason::Half;
        (!bytes.is_empty()).then(|| Item::rejected(hex(&bytes, half.text()), half))
    }

    /// The board restarted: the next stamp is of another clock.
    pub fn restart_clock(&mut self) {
        self.clock = Clock::default();
    }

    fn item(&mut self, stuffed: &[u8]) -> Option<Item> {
        match decode_frame(stuffed) {
            Ok(Frame::Sample(sample)) => Some(self.row(&sample)),
            Ok(Frame::Text(text)) => comment(&text),
            Err(error) => {
                let text = error.to_string();
                let why = text
                    .split_once("not a frame of the board: ")
                    .map_or(text.as_str(), |(_, why)| why);
                Some(Item::rejected(hex(stuffed, why), Reason::BadFrame))
            }
        }
    }

    fn row(&mut self, sample: &SampleFrame) -> Item {
        let time_us = self.clock.time_us(sample.time_us);
        let [ax, ay, az] = sample.accel;
        let [gx, gy, gz] = sample.gyro;
        let counts = [ax, ay, az, sample.temperature, gx, gy, gz];
        let mut bytes = time_us.to_string();
        for count in counts {
            bytes.push(',');
            bytes.push_str(&count.to_string());
        }
        Item {
            bytes: bytes.into_bytes(),
            kind: Kind::Row(Row {
                stamp: Some(time_us as f64),
                accel: Some(sample.accel.map(f64::from)),
                temperature: Some(f64::from(sample.temperature)),
                sequence: Some(sample.sequence),
            }),
        }
    }
}

/// A message of the board as one line that begins with `#`.
fn comment(text: &str) -> Option<Item> {
    let text: String = text
        .trim()
        .chars()
        .map(|c| if c.is_control() { '?' } else { c })
        .collect();
    let hash = if text.starts_with('#') { "" } else { "# " };
    (!text.is_empty()).then(|| Item {
        bytes: format!("{hash}{text}").into_bytes(),
        kind: Kind::Comment,
    })
}

/// Bytes of an invalid frame as a line of text: hexadecimal digits, and the reason.
fn hex(bytes: &[u8], why: &str) -> Vec<u8> {
    let mut line: String = bytes.iter().map(|b| format!("{b:02x}")).collect();
    line.push_str("  # ");
    line.push_str(why);
    line.into_bytes()
}

/// The board's 32-bit clock, without its wraps; it restarts with the board.
#[derive(Debug, Clone, Default)]
struct Clock {
    last: Option<u32>,
    unwrap: Unwrap,
}

impl Clock {
    fn time_us(&mut self, stamp_us: u32) -> u64 {
        if let Some(last) = self.last.replace(stamp_us)
            && stamp_us < last
            && !(last > u32::MAX - EDGE && stamp_us < EDGE)
        {
            self.unwrap = Unwrap::default();
        }
        self.unwrap.time_us(stamp_us)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gravical::recording::frame::encode_frame;

    fn sample(sequence: u8, time_us: u32) -> Frame {
        Frame::Sample(SampleFrame {
            sequence,
            time_us,
            accel: [1, -2, 16384],
            temperature: -3920,
            gyro: [0, 5, -6],
        })
    }

    fn texts(items: &[Item]) -> Vec<String> {
        items
            .iter()
            .map(|item| String::from_utf8(item.bytes.clone()).unwrap())
            .collect()
    }

    #[test]
    fn frames_arrive_in_pieces() {
        let mut wire = encode_frame(&sample(1, 2000));
        wire.extend(encode_frame(&Frame::Text("# overruns 1".to_owned())));
        wire.extend([0, 0]);
        wire.extend(encode_frame(&sample(2, 4000)));
        wire.extend([5, 6, 0]);
        for piece in 1..wire.len() {
            let mut frames = Frames::default();
            let items: Vec<Item> = wire.chunks(piece).flat_map(|c| frames.push(c)).collect();
            assert_eq!(
                texts(&items),
                [
                    "2000,1,-2,16384,-3920,0,5,-6",
                    "# overruns 1",
                    "4000,1,-2,16384,-3920,0,5,-6",
                    "0506  # 2 bytes are not stuffed",
                ]
            );
            assert_eq!(frames.cut(), None);
            frames.push(&[7]);
            let half = frames.cut().into_iter().collect::<Vec<_>>();
            assert_eq!(
                texts(&half),
                ["07  # its beginning or end was not received"]
            );
        }
    }

    #[test]
    fn noise_without_a_zero_is_bounded_and_text_is_one_line() {
        let mut frames = Frames::default();
        assert_eq!(frames.push(&[b'x'; 3 * MOST_BYTES]).len(), 3);
        let odd = Frame::Text("not #\na row\r".to_owned());
        assert_eq!(texts(&frames.push(&encode_frame(&odd))), ["# not #?a row"]);
        assert!(
            frames
                .push(&encode_frame(&Frame::Text(" ".to_owned())))
                .is_empty()
        );
    }

    #[test]
    fn the_clock_continues_over_a_wrap_and_restarts_after_a_reset() {
        let mut clock = Clock::default();
        assert_eq!(clock.time_us(u32::MAX - 999), 4_294_966_296);
        assert_eq!(clock.time_us(1000), 4_294_968_296);
        assert_eq!(clock.time_us(900_000_000), 5_194_967_296);
        assert_eq!(clock.time_us(1_200_000), 1_200_000);
    }
}
