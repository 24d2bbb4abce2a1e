//! Bytes to lines, and the clock of the board.

use std::collections::VecDeque;

/// A longer line is no row of a board: it is passed on in pieces.
const MAX_LINE: usize = 4096;
/// Beginning of the line with which our firmware reports its settings.
const OWN_LINE: &[u8] = b"# gravical mpu6050_logger";

/// Splits bytes into lines: `\n`, `\r\n` and `\r` end one.
#[derive(Default)]
pub struct Splitter {
    partial: Vec<u8>,
    /// The last byte was `\r`.
    after_return: bool,
    /// `partial` begins behind the end of a line.
    is_synced: bool,
}

impl Splitter {
    /// The lines that these bytes complete, without their ends, and whether their beginning was
    /// received.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<(Vec<u8>, bool)> {
        let mut lines = Vec::new();
        for &byte in bytes {
            let is_pair = std::mem::replace(&mut self.after_return, byte == b'\r');
            if is_pair && byte == b'\n' {
                continue;
            }
            let is_end = matches!(byte, b'\n' | b'\r');
            if !is_end {
                self.partial.push(byte);
            }
            if !is_end && self.partial.len() < MAX_LINE {
                continue;
            }
            let mut line = std::mem::take(&mut self.partial);
            let is_whole = std::mem::replace(&mut self.is_synced, is_end);
            // A board that is reset in a row continues the line with its settings.
            let own = line.windows(OWN_LINE.len()).position(|w| w == OWN_LINE);
            if let Some(at) = own.filter(|at| *at > 0) {
                let settings = line.split_off(at);
                lines.extend([(line, false), (settings, true)]);
            } else {
                lines.push((line, is_whole));
            }
        }
        lines
    }

    /// The port was closed: the line that has begun stays incomplete.
    pub fn cut(&mut self) -> Vec<u8> {
        std::mem::take(self).partial
    }
}

/// The usual step is the median of this many.
const STEPS: usize = 31;
/// A jump of more usual steps than this is a gap, as for the reader of recordings.
const GAP_STEPS: f64 = 4.5;
/// 2³²: a 32-bit counter restarts from zero here.
const WRAP: f64 = 4_294_967_296.0;

/// Follows the stamps of the board.
#[derive(Default)]
pub struct Clock {
    last: Option<f64>,
    steps: VecDeque<f64>,
}

/// The way from one stamp to the next.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Step {
    /// There is no stamp.
    Unknown,
    /// The clock began again.
    Restart,
    /// So many rows are missing; 0 up to four usual steps.
    Missing(u64),
}

impl Clock {
    /// Takes the stamp of the next row, in any unit; NaN: it has none.
    pub fn next(&mut self, stamp: f64) -> Step {
        if stamp.is_nan() {
            return Step::Unknown;
        }
        let Some(last) = self.last.replace(stamp) else {
            return Step::Missing(0);
        };
        let wraps = (0.95 * WRAP..WRAP).contains(&last) && (0.0..0.05 * WRAP).contains(&stamp);
        let step = stamp - last + if wraps { WRAP } else { 0.0 };
        if step < 0.0 {
            self.steps.clear();
            return Step::Restart;
        }
        let mut sorted: Vec<f64> = self.steps.iter().copied().collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let usual = sorted.get(sorted.len() / 2).copied();
        if step > 0.0 {
            self.steps.push_back(step);
            self.steps.drain(..self.steps.len().saturating_sub(STEPS));
        }
        match usual {
            Some(usual) if step > GAP_STEPS * usual => {
                Step::Missing((step / usual).round() as u64 - 1)
            }
            _ => Step::Missing(0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_end_of_line_in_any_pieces() {
        let text = b"9,1\r\n2,3\n4,5\r6,7\r\n\r\n1,0# gravical mpu6050_logger 1.2\n8";
        let expected: [(&[u8], bool); 7] = [
            (b"9,1", false),
            (b"2,3", true),
            (b"4,5", true),
            (b"6,7", true),
            (b"", true),
            (b"1,0", false),
            (b"# gravical mpu6050_logger 1.2", true),
        ];
        for piece in [1, 5, 1000] {
            let mut splitter = Splitter::default();
            let lines = text.chunks(piece).flat_map(|bytes| splitter.push(bytes));
            let lines: Vec<_> = lines.collect();
            let lines: Vec<_> = lines.iter().map(|(l, whole)| (&l[..], *whole)).collect();
            assert_eq!(lines, expected);
            assert_eq!(splitter.cut(), b"8");
        }
        let pieces = Splitter::default().push(&[b'x'; 10_000]);
        assert_eq!(pieces.len(), 2);
    }

    #[test]
    fn jumps_restarts_and_wraps() {
        let mut clock = Clock::default();
        let mut next = |stamp: f64| clock.next(stamp);
        assert_eq!(next(f64::NAN), Step::Unknown);
        for i in 0..20 {
            assert_eq!(next(10.0 * f64::from(i)), Step::Missing(0));
        }
        assert_eq!(next(230.0), Step::Missing(0));
        assert_eq!(next(330.0), Step::Missing(9));
        assert_eq!(next(10.0), Step::Restart);
        next(WRAP - 5.0);
        assert_eq!(next(5.0), Step::Missing(0));
    }
}
