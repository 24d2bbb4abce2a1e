//! Bytes to lines.

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
}
