//! Recordings of GENEActiv (`.bin`): a header of text, then pages of text with 300 samples in
//! hexadecimal each.
//!
//! The maker describes the format in the GENEActiv Instructions for Use, "Understanding .bin files".
//! It has no checksum.

use std::io::{self, BufRead, Read as _};

use super::order::{Block, Event, Order, Place};
use super::{OpenError, Sample};
use crate::recording::ledger::Aside;
use crate::recording::timing::parse_date;

/// First line of the header, and of a page.
const HEADER: &[u8] = b"Device Identity";
const PAGE: &[u8] = b"Recorded Data";
/// Samples of a page, and hexadecimal digits of a sample: 12 bits for each axis, 10 for light, one
/// for the button and one that is not used.
const PAGE_SAMPLES: usize = 300;
const DIGITS: usize = 12;
/// Seconds of a day: less since 1970 is a time of day.
const DAY_S: f64 = 86_400.0;
/// Longer lines are damage.
const MOST_LINE: usize = 1 << 14;
/// Usual headers have 59 lines.
const MOST_HEADER_LINES: usize = 1000;
/// Rates that the devices have, Hz, with room for others.
const RATES_HZ: std::ops::RangeInclusive<f64> = 1.0..=1000.0;

/// True if a file that begins with `head` is one of these.
pub(super) fn is_one(head: &[u8]) -> bool {
    let mut lines = head.split(|b| *b == b'\n').map(<[u8]>::trim_ascii);
    lines.next() == Some(HEADER)
        && lines
            .next()
            .is_some_and(|line| line.starts_with(b"Device Unique Serial Code:"))
}

/// What the header tells.
#[derive(Debug)]
pub(super) struct Info {
    pub rate_hz: f64,
    /// Counts of 12 bits are `(100 count − offset) / gain` in g, axis by axis.
    gain: [f64; 3],
    offset: [f64; 3],
    pub serial: String,
    /// In words.
    pub description: String,
}

impl Info {
    /// From the first bytes of a file.
    ///
    /// # Errors
    ///
    /// What they lack.
    pub fn of(head: &[u8]) -> Result<Self, OpenError> {
        let lines = head.split(|b| *b == b'\n').map(<[u8]>::trim_ascii);
        let header: Vec<_> = lines.take_while(|line| *line != PAGE).collect();
        let value = |key: &str| {
            let found = header.iter().find_map(|line| value_of(line, key));
            found.filter(|value| !value.is_empty())
        };
        let number = |key: &str| value(key).and_then(|text| number(&text));
        let axes = |what: &str| {
            let [x, y, z] = ["x", "y", "z"].map(|axis| number(&format!("{axis} {what}")));
            Some([x?, y?, z?])
        };
        let gain = axes("gain").filter(|gain| gain.iter().all(|g| *g > 0.0));
        let rate_hz = number("Measurement Frequency").filter(|rate| RATES_HZ.contains(rate));
        let rate_hz = rate_hz.ok_or(OpenError::Incomplete("the measurement frequency"))?;
        let mut parts = vec![
            value("Device Type").unwrap_or_else(|| "GENEActiv".to_owned()),
            format!("nominal {rate_hz} Hz"),
        ];
        // `-8 to 8`
        let range = value("Accelerometer Range");
        let range = range
            .as_deref()
            .and_then(|text| text.split(' ').next_back());
        parts.extend(range.map(|range| format!("±{range} g")));
        parts.extend(value("Device Location Code").map(|place| format!("worn: {place}")));
        Ok(Info {
            rate_hz,
            gain: gain.ok_or(OpenError::Incomplete("the gains of the accelerometer"))?,
            offset: axes("offset")
                .ok_or(OpenError::Incomplete("the offsets of the accelerometer"))?,
            serial: value("Device Unique Serial Code").unwrap_or_else(|| "unknown".to_owned()),
            description: parts.join(", "),
        })
    }
}

/// The value of a line `key:value`.
fn value_of(line: &[u8], key: &str) -> Option<String> {
    let value = line.strip_prefix(key.as_bytes())?.strip_prefix(b":")?;
    Some(String::from_utf8_lossy(value.trim_ascii()).into_owned())
}

/// A number, of which a unit may follow, with a decimal point or comma.
fn number(text: &str) -> Option<f64> {
    let number: f64 = text.split(' ').next()?.replace(',', ".").parse().ok()?;
    number.is_finite().then_some(number)
}

/// The pages of a file.
#[derive(Debug)]
pub(super) struct Pages<R> {
    reader: R,
    info: Info,
    /// Bytes read.
    taken: u64,
    /// The line read last, without white space around it, and where it begins.
    line: Vec<u8>,
    line_at: u64,
    /// That line ended with a line end.
    terminated: bool,
    /// That line begins a page, and belongs to what comes next.
    at_page: bool,
    /// Pages read.
    read: u64,
    /// Bytes up to the end of the last whole page.
    whole: u64,
    pub order: Order,
}

impl<R: BufRead> Pages<R> {
    /// `reader` is at the start of the file that begins with `head`.
    ///
    /// # Errors
    ///
    /// What the start lacks, and errors of reading.
    pub fn new(reader: R, head: &[u8]) -> Result<Self, OpenError> {
        let mut pages = Pages {
            reader,
            info: Info::of(head)?,
            taken: 0,
            line: Vec::new(),
            line_at: 0,
            terminated: true,
            at_page: false,
            read: 0,
            whole: 0,
            order: Order::new("page", "by the sequence numbers"),
        };
        for _ in 0..MOST_HEADER_LINES {
            pages.whole = pages.taken;
            if !pages.read_line()? || pages.at_page {
                break;
            }
        }
        Ok(pages)
    }

    /// Reads a line; `false` at the end. Of a longer one a part.
    fn read_line(&mut self) -> io::Result<bool> {
        self.line.clear();
        self.line_at = self.taken;
        let mut part = (&mut self.reader).take(MOST_LINE as u64);
        let length = part.read_until(b'\n', &mut self.line)?;
        self.taken += length as u64;
        self.terminated = self.line.ends_with(b"\n");
        let text = self.line.trim_ascii_end().len();
        self.line.truncate(text);
        self.at_page = self.line == PAGE;
        Ok(length > 0)
    }

    /// The next page, after a gap if there is one before it; `None` at the end of the file, and
    /// with `cut` before a page that is not whole.
    ///
    /// # Errors
    ///
    /// Errors of reading.
    pub fn next(&mut self, cut: bool) -> io::Result<Option<(Option<Event>, Event)>> {
        while !self.at_page && self.line.is_empty() {
            self.whole = self.taken;
            if !self.read_line()? {
                return Ok(None);
            }
        }
        let place = Place {
            noun: "page",
            number: self.read + 1,
            byte: self.line_at,
        };
        let page = self.page()?;
        while page.is_err() && !self.at_page && self.read_line()? {}
        if cut && !self.at_page && !self.terminated {
            return Ok(None);
        }
        if !self.at_page {
            self.line.clear();
        }
        self.read += 1;
        self.whole = if self.at_page {
            self.line_at
        } else {
            self.taken
        };
        Ok(Some(match page {
            Ok(block) => self.order.place(place, block),
            Err(defect) => (None, self.order.skip(place, Aside::CorruptBlock, defect)),
        }))
    }

    fn is_at_end(&mut self) -> io::Result<bool> {
        Ok(self.reader.fill_buf()?.is_empty())
    }

    /// The page that begins with the line read last, or why it cannot be used.
    fn page(&mut self) -> io::Result<Result<Block, &'static str>> {
        if !std::mem::take(&mut self.at_page) {
            return Ok(Err("not a page"));
        }
        let (mut sequence, mut stamp_s) = (None, None);
        let mut block = Block {
            rate_hz: self.info.rate_hz,
            temperature_c: f64::NAN,
            battery_v: f64::NAN,
            ..Block::default()
        };
        loop {
            if !self.read_line()? || self.at_page {
                return Ok(Err("cut off"));
            }
            let Some(colon) = self.line.iter().position(|b| *b == b':') else {
                break;
            };
            let (key, value) = (&self.line[..colon], self.line[colon + 1..].trim_ascii());
            let number = || number(&String::from_utf8_lossy(value));
            match key {
                b"Sequence Number" => sequence = number().map(|n| n as u32),
                // A time of day alone is no date.
                b"Page Time" => stamp_s = parse_date(value).filter(|s| *s >= DAY_S),
                b"Temperature" => block.temperature_c = number().unwrap_or(f64::NAN),
                b"Battery voltage" => block.battery_v = number().unwrap_or(f64::NAN),
                b"Measurement Frequency" => {
                    let rate_hz = number().filter(|rate| RATES_HZ.contains(rate));
                    block.rate_hz = rate_hz.unwrap_or(self.info.rate_hz);
                }
                _ => {}
            }
        }
        let (Some(sequence), Some(stamp_s)) = (sequence, stamp_s) else {
            return Ok(Err("no number or no date"));
        };
        let Some(samples) = self.info.samples(&self.line) else {
            return Ok(Err("not the digits of samples"));
        };
        // Only the last page may be shorter; elsewhere digits are lost.
        if samples.len() < PAGE_SAMPLES && !self.is_at_end()? {
            return Ok(Err("fewer samples than a page has"));
        }
        Ok(Ok(Block {
            sequence,
            stamp_s,
            samples,
            ..block
        }))
    }

    /// Bytes of the file up to the end of the last whole page.
    pub fn bytes(&self) -> u64 {
        self.whole
    }
}

impl Info {
    /// The samples of the digits of a page.
    fn samples(&self, digits: &[u8]) -> Option<Vec<Sample>> {
        let (samples, rest) = digits.as_chunks::<DIGITS>();
        if !rest.is_empty() || !(1..=PAGE_SAMPLES).contains(&samples.len()) {
            return None;
        }
        let digits = samples.iter().map(|sample| {
            let digit = |sum: u64, c: &u8| Some(sum << 4 | u64::from(char::from(*c).to_digit(16)?));
            sample.iter().try_fold(0, digit)
        });
        let in_g = |bits: u64| {
            // To the top, so that the shift back extends the sign.
            let axis = |i: usize| {
                let count = (bits << (16 + 12 * i)).cast_signed() >> 52;
                (100.0 * count as f64 - self.offset[i]) / self.gain[i]
            };
            [axis(0), axis(1), axis(2), f64::NAN, f64::NAN, f64::NAN]
        };
        digits.map(|bits| bits.map(in_g)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_calibrated_as_the_maker_says() {
        let info = Info {
            rate_hz: 100.0,
            gain: [25_600.0, 25_000.0, 25_600.0],
            offset: [0.0, 1000.0, -2560.0],
            serial: String::new(),
            description: String::new(),
        };
        // 256, −246 and −1; light 512 and the button, which are not read.
        let samples = info.samples(b"100F0AFFF802").unwrap();
        assert_eq!(samples[0][..3], [1.0, -1.024, 2460.0 / 25_600.0]);
        for digits in [&b""[..], b"100F0AFFF80", b"100F0AFFF80G", &[b'0'; 12 * 301]] {
            assert!(info.samples(digits).is_none());
        }
    }
}
