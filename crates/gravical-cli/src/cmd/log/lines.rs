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

/// The usual step is the median of this many, and is known by so many.
const STEPS: usize = 31;
const MIN_STEPS: usize = 3;
/// A jump of more usual steps than this is a gap, as for the reader of recordings.
const GAP_STEPS: f64 = 4.5;
/// Clocks begin again here: a 32-bit counter, as it is and of µs in ms or s, and the time of day, s.
const WRAPS: [f64; 4] = [4_294_967_296.0, 4_294_967.296, 4_294.967_296, 86_400.0];
/// Two long steps in a row that differ by less than this are another rate, not two gaps.
const SAME_STEP: f64 = 0.1;

/// Follows the stamps of the board.
#[derive(Default)]
pub struct Clock {
    last: Option<f64>,
    steps: VecDeque<f64>,
    /// The last step that was longer than a gap.
    long: Option<f64>,
    /// Rows, and those at which the stamp changed: a stamp may stand for several rows.
    rows: u64,
    stamps: u64,
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
        let wraps = |wrap: &f64| {
            (0.95 * wrap..*wrap).contains(&last) && (0.0..0.05 * wrap).contains(&stamp)
        };
        let wrap = WRAPS.into_iter().find(wraps).filter(|_| stamp < last);
        let step = stamp - last + wrap.unwrap_or(0.0);
        if step < 0.0 {
            self.steps.clear();
            return Step::Restart;
        }
        self.rows += 1;
        if step == 0.0 {
            return Step::Missing(0);
        }
        self.stamps += 1;
        let mut sorted: Vec<f64> = self.steps.iter().copied().collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let usual = sorted
            .get(sorted.len() / 2)
            .filter(|_| sorted.len() >= MIN_STEPS);
        let is_long = usual.is_some_and(|usual| step > GAP_STEPS * usual);
        let long = std::mem::replace(&mut self.long, is_long.then_some(step));
        let is_same = |long: f64| (step / long - 1.0).abs() < SAME_STEP;
        if is_long && long.is_some_and(is_same) {
            self.steps.clear();
            (self.rows, self.stamps) = (1, 1);
        }
        self.steps.push_back(step);
        self.steps.drain(..self.steps.len().saturating_sub(STEPS));
        match usual {
            Some(usual) if is_long && self.steps.len() > 1 => {
                let rows_a_stamp = (self.rows as f64 / self.stamps as f64).round().max(1.0);
                Step::Missing(((step / usual).round() - 1.0).max(0.0) as u64 * rows_a_stamp as u64)
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
        next(WRAPS[0] - 5.0);
        assert_eq!(next(5.0), Step::Missing(0));
        // Over midnight; ten rows a stamp; another rate.
        let mut clock = Clock::default();
        let mut all =
            |stamps: &[f64]| -> Vec<Step> { stamps.iter().map(|s| clock.next(*s)).collect() };
        assert_eq!(
            all(&[86_399.5, 86_399.75, 0.0, 0.25]),
            [Step::Missing(0); 4]
        );
        let mut clock = Clock::default();
        let ten = |stamp: f64| [stamp; 10];
        let stamps = [0.0, 0.1, 0.2, 0.3, 0.4, 1.5].map(ten).concat();
        let steps: Vec<Step> = stamps.iter().map(|s| clock.next(*s)).collect();
        let gaps: Vec<&Step> = steps.iter().filter(|s| **s != Step::Missing(0)).collect();
        assert_eq!(gaps, [&Step::Missing(100)]);
        let mut clock = Clock::default();
        let fast = (0..40).map(|i| 10.0 * f64::from(i));
        let slow = (1..20).map(|i| 390.0 + 60.0 * f64::from(i));
        let gaps = fast
            .chain(slow)
            .filter(|s| clock.next(*s) != Step::Missing(0))
            .count();
        assert_eq!(gaps, 1);
    }
}
