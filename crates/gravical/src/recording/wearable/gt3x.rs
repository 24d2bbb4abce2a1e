//! Recordings of ActiGraph GT3X+, wGT3X+, wGT3X-BT, ActiSleep and GT9X Link (`.gt3x`): records of one
//! second each.
//!
//! The file is a ZIP archive; here it is one stream of its members `info.txt` and `log.bin`
//! ([`start_of_stream`]), so that its beginning is read as that of any file. The maker describes
//! the format at <https://github.com/actigraph/GT3X-File-Format>.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::ops::Range;

use memchr::memchr;

use super::order::{Block, Event, Order, Place};
use super::{OpenError, Sample};
use crate::finding::{Finding, FindingKind};
use crate::recording::ledger::Aside;

/// Beginning of the stream; no text begins so.
const MARK: &[u8] = b"\x1egt3x\n";
/// Largest `info.txt` that is read, bytes; usual are 1000.
pub(in crate::recording) const MOST_INFO: usize = 1 << 16;

/// First byte of a record.
const SEPARATOR: u8 = 0x1e;
/// Separator, kind, stamp of 4 bytes and size of 2.
const RECORD_HEADER: usize = 8;
/// With the checksum behind the payload.
const RECORD_FRAME: usize = RECORD_HEADER + 1;

/// Kinds of records.
const ACTIVITY: u8 = 0x00;
const BATTERY: u8 = 0x02;
const PARAMETERS: u8 = 0x15;
const ACTIVITY_2: u8 = 0x1a;
/// Described kinds without samples of the accelerometer: events, pulse, light, settings, epochs,
/// proximity, and the maker's own diagnosis.
const WITHOUT_SAMPLES: [u8; 14] = [3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16];
const DIAGNOSIS: [u8; 3] = [0x13, 0x14, 0x18];

/// The parameter with the counts per g of the accelerometer.
const ACCEL_SCALE: u32 = 55 << 16;
/// Counts per g of devices whose files say none, by the begin of their serial number.
const SCALES: [(&str, f64); 3] = [("NEO", 341.0), ("CLE", 341.0), ("MOS", 256.0)];

/// Rates that the devices have, Hz, with room for others.
const RATES_HZ: std::ops::RangeInclusive<f64> = 1.0..=1000.0;
/// Scales that the devices have, with room for others.
const SCALES_PER_G: std::ops::RangeInclusive<f64> = 1.0..=100_000.0;

/// The start of the stream of an archive with this `info.txt`; `log.bin` follows.
pub(in crate::recording) fn start_of_stream(info: &[u8]) -> Vec<u8> {
    let info = &info[..info.len().min(MOST_INFO)];
    let length = (info.len() as u32).to_le_bytes();
    [MARK, &length, info].concat()
}

/// True if a stream that begins with `head` is that of a `.gt3x` file.
pub(super) fn is_one(head: &[u8]) -> bool {
    info_of(head, true).is_some()
}

/// Where `info.txt` is in the stream; with `begun`, as far as it is in `head`.
fn info_of(head: &[u8], begun: bool) -> Option<Range<usize>> {
    let length = head.strip_prefix(MARK)?.first_chunk()?;
    let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
    let from = MARK.len() + 4;
    let to = from + Some(length).filter(|length| *length <= MOST_INFO)?;
    (to <= head.len() || begun).then_some(from..to.min(head.len()))
}

/// What the stream tells besides the samples.
#[derive(Debug)]
pub(super) struct Info {
    /// Where `log.bin` begins.
    log: usize,
    pub rate_hz: f64,
    counts_per_g: f64,
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
        let at = info_of(head, false).ok_or(OpenError::Incomplete("info.txt"))?;
        let text = String::from_utf8_lossy(&head[at.clone()]);
        let value = |key: &str| {
            let mut lines = text.lines().filter_map(|line| line.split_once(':'));
            let found = lines.find(|(k, _)| k.trim_start_matches('\u{feff}').trim() == key);
            found
                .map(|(_, value)| value.trim())
                .filter(|v| !v.is_empty())
        };
        let number = |key| value(key)?.replace(',', ".").parse::<f64>().ok();
        let rate_hz = number("Sample Rate").filter(|rate| RATES_HZ.contains(rate));
        let rate_hz = rate_hz.ok_or(OpenError::Incomplete("the sample rate in info.txt"))?;
        let serial = value("Serial Number").unwrap_or("unknown").to_owned();
        let by_serial = || {
            let known = SCALES.iter().find(|(begin, _)| serial.starts_with(begin));
            known.map(|(_, scale)| *scale)
        };
        let is_scale = |scale: &f64| SCALES_PER_G.contains(scale);
        let counts_per_g = parameter_scale(&head[at.end..])
            .filter(is_scale)
            .or_else(|| number("Acceleration Scale").filter(is_scale))
            .or_else(by_serial)
            .ok_or(OpenError::Incomplete("the scale of the accelerometer"))?;
        let mut parts = vec![
            value("Device Type").map_or("ActiGraph".to_owned(), |d| format!("ActiGraph {d}")),
            format!("nominal {rate_hz} Hz"),
        ];
        parts.extend(number("Acceleration Max").map(|range| format!("±{range} g")));
        parts.extend(value("Firmware").map(|version| format!("firmware {version}")));
        Ok(Info {
            log: at.end,
            rate_hz,
            counts_per_g,
            serial,
            description: parts.join(", "),
        })
    }
}

/// The scale in the parameters, which are among the first records.
fn parameter_scale(log: &[u8]) -> Option<f64> {
    let mut window = Window::new(log);
    let mut last = None;
    while window.has(1).ok()? {
        match window.record().ok()? {
            Ok(record) => {
                let pairs = window.payload(&record).as_chunks::<8>().0;
                let pair = pairs.iter().find(|pair| u32_at(*pair, 0) == ACCEL_SCALE);
                if let Some(pair) = pair.filter(|_| record.kind == PARAMETERS) {
                    return Some(float(u32_at(pair, 4)));
                }
                last = Some(record.stamp);
                window.consume(record.length);
            }
            Err(_) => window.resynchronise(last).ok()?,
        }
        window.skip_zeros().ok()?;
    }
    None
}

/// A number of the parameters: a fraction of 24 bits, ±2²³ for ±1, and a binary exponent of 8.
fn float(bits: u32) -> f64 {
    let fraction = f64::from((bits << 8).cast_signed() >> 8) / f64::from(1 << 23);
    fraction * f64::from(bits.cast_signed() >> 24).exp2()
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

/// Behind damage, a record is known by a stamp of at most this after the one before, s.
const NEAR_S: u32 = 86_400;
/// A clock that steps back by more than this, s, was set; records are late by seconds.
const SET_BACK_S: u32 = 60;
/// Zeros are looked behind up to here, bytes from the start of a record.
const MOST_ZEROS: usize = 1 << 17;

/// A whole record at the start of the window.
#[derive(Debug, Clone, Copy)]
struct Record {
    kind: u8,
    /// On the clock of the device, s since 1970.
    stamp: u32,
    /// With header and checksum, bytes.
    length: usize,
}

/// Why there is no record at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Defect {
    NotARecord,
    Checksum,
    /// The file ends within it.
    Truncated,
}

impl Defect {
    fn text(self) -> &'static str {
        match self {
            Defect::NotARecord => "not a record",
            Defect::Checksum => "wrong checksum",
            Defect::Truncated => "cut off, or its size is wrong",
        }
    }
}

/// Bytes of which a record can be looked at before it is taken.
#[derive(Debug)]
struct Window<R> {
    reader: R,
    buffer: Vec<u8>,
    start: usize,
    /// Bytes taken.
    taken: u64,
}

impl<R: Read> Window<R> {
    fn new(reader: R) -> Self {
        Window {
            reader,
            buffer: Vec::new(),
            start: 0,
            taken: 0,
        }
    }

    fn bytes(&self) -> &[u8] {
        &self.buffer[self.start..]
    }

    /// True if there are `n` bytes.
    fn has(&mut self, n: usize) -> io::Result<bool> {
        if self.bytes().len() < n {
            self.buffer.drain(..self.start);
            self.start = 0;
            let missing = n.max(1 << 16) - self.buffer.len();
            let more = (&mut self.reader).take(missing as u64);
            { more }.read_to_end(&mut self.buffer)?;
        }
        Ok(self.bytes().len() >= n)
    }

    fn consume(&mut self, n: usize) {
        self.start += n;
        self.taken += n as u64;
    }

    /// Skips the zeros that may stand between records.
    fn skip_zeros(&mut self) -> io::Result<()> {
        while self.has(1)? {
            let zeros = self.bytes().iter().take_while(|b| **b == 0).count();
            if zeros == 0 {
                break;
            }
            self.consume(zeros);
        }
        Ok(())
    }

    /// The record at the start of the window.
    fn record(&mut self) -> io::Result<Result<Record, Defect>> {
        self.record_at(0)
    }

    /// The record `at` bytes from the start of the window.
    fn record_at(&mut self, at: usize) -> io::Result<Result<Record, Defect>> {
        if !self.has(at + RECORD_FRAME)? {
            return Ok(Err(Defect::Truncated));
        }
        let bytes = &self.bytes()[at..];
        if bytes[0] != SEPARATOR {
            return Ok(Err(Defect::NotARecord));
        }
        let (kind, stamp) = (bytes[1], u32_at(bytes, 2));
        let length = RECORD_FRAME + usize::from(u16::from_le_bytes([bytes[6], bytes[7]]));
        if !self.has(at + length)? {
            return Ok(Err(Defect::Truncated));
        }
        let all = self.bytes()[at..at + length].iter();
        // The complement of the others' exclusive or.
        if all.fold(0, |sum, byte| sum ^ byte) != 0xff {
            return Ok(Err(Defect::Checksum));
        }
        Ok(Ok(Record {
            kind,
            stamp,
            length,
        }))
    }

    fn payload(&self, record: &Record) -> &[u8] {
        &self.bytes()[RECORD_HEADER..record.length - 1]
    }

    /// Skips what is no record, up to one that fits: its stamp is near `last`, that of the record
    /// before, or it is followed by another.
    fn resynchronise(&mut self, last: Option<u32>) -> io::Result<()> {
        // A payload was changed: the next record is where its size says.
        if self.has(RECORD_FRAME)? && self.bytes()[0] == SEPARATOR {
            let size = u16::from_le_bytes([self.bytes()[6], self.bytes()[7]]);
            let length = RECORD_FRAME + usize::from(size);
            if self.has(length)? && self.is_followed(length)? {
                self.consume(length);
                return Ok(());
            }
        }
        // Eight bits of checksum are right by chance too often to stand alone.
        let is_near = |stamp: u32| {
            let ahead_s = last.and_then(|last| stamp.checked_sub(last));
            ahead_s.is_some_and(|ahead_s| ahead_s <= NEAR_S)
        };
        while self.has(2)? {
            self.consume(1);
            match memchr(SEPARATOR, self.bytes()) {
                Some(at) => self.consume(at),
                None => self.consume(self.bytes().len() - 1),
            }
            if let Ok(record) = self.record()?
                && (is_near(record.stamp) || self.is_followed(record.length)?)
            {
                return Ok(());
            }
        }
        self.consume(self.bytes().len());
        Ok(())
    }

    /// A record or the end of the file is `at` bytes from the start of the window, or behind zeros
    /// there.
    fn is_followed(&mut self, mut at: usize) -> io::Result<bool> {
        while self.has(at + 1)? && self.bytes()[at] == 0 && at < MOST_ZEROS {
            at += 1;
        }
        if !self.has(at + 1)? {
            return Ok(true);
        }
        Ok(match self.record_at(at)? {
            Ok(_) => true,
            Err(Defect::Truncated) => self.bytes()[at] == SEPARATOR,
            Err(_) => false,
        })
    }
}

/// The records of a file with samples.
#[derive(Debug)]
pub(super) struct Records<R> {
    window: Window<R>,
    rate_hz: f64,
    counts_per_g: f64,
    /// Where `log.bin` begins in the stream.
    log: u64,
    /// Records read, whatever their kind.
    read: u64,
    /// Bytes up to the end of the last whole record.
    whole: u64,
    /// The stamp of the last record, whatever its kind.
    last: Option<u32>,
    battery_v: f64,
    /// The stamp of the last second of samples, and how often the clock was set back.
    second: Option<u32>,
    sessions: u32,
    /// Records of samples without samples, at the connection of a cable.
    empty: u64,
    /// Numbers of records of kinds that are not described, or whose samples are not read.
    others: BTreeMap<u8, u64>,
    pub order: Order,
}

impl<R: Read> Records<R> {
    /// `reader` is at the start of the stream that begins with `head`.
    ///
    /// # Errors
    ///
    /// What the start lacks, and errors of reading.
    pub fn new(mut reader: R, head: &[u8]) -> Result<Self, OpenError> {
        let info = Info::of(head)?;
        io::copy(&mut (&mut reader).take(info.log as u64), &mut io::sink())?;
        Ok(Records {
            window: Window::new(reader),
            rate_hz: info.rate_hz,
            counts_per_g: info.counts_per_g,
            log: info.log as u64,
            read: 0,
            whole: 0,
            last: None,
            battery_v: f64::NAN,
            second: None,
            sessions: 0,
            empty: 0,
            others: BTreeMap::new(),
            order: Order::new(
                "second",
                "(a device that lies still may sleep, or records were lost)",
            ),
        })
    }

    /// The next second of samples, after a gap if there is one before it; `None` at the end of the
    /// file, and with `cut` before a record that is not whole.
    ///
    /// # Errors
    ///
    /// Errors of reading.
    pub fn next(&mut self, cut: bool) -> io::Result<Option<(Option<Event>, Event)>> {
        loop {
            self.window.skip_zeros()?;
            self.whole = self.window.taken;
            if !self.window.has(1)? {
                return Ok(None);
            }
            let place = Place {
                noun: "record",
                number: self.read + 1,
                byte: self.window.taken,
            };
            let record = match self.window.record()? {
                Ok(record) => record,
                Err(Defect::Truncated) if cut => return Ok(None),
                Err(defect) => {
                    self.window.resynchronise(self.last)?;
                    self.read += 1;
                    let skipped = self.order.skip(place, Aside::CorruptBlock, defect.text());
                    let at_end = !self.window.has(1)?;
                    if !(cut && at_end) {
                        self.whole = self.window.taken;
                    }
                    return Ok((!(cut && at_end)).then_some((None, skipped)));
                }
            };
            self.read += 1;
            self.last = Some(record.stamp);
            let payload = self.window.payload(&record);
            let samples = match record.kind {
                ACTIVITY if payload.len() > 1 => packed(payload),
                ACTIVITY_2 if payload.len() > 1 => plain(payload),
                ACTIVITY | ACTIVITY_2 => Vec::new(),
                BATTERY => {
                    if let [low, high] = payload {
                        self.battery_v = f64::from(u16::from_le_bytes([*low, *high])) / 1000.0;
                    }
                    Vec::new()
                }
                PARAMETERS => Vec::new(),
                kind if WITHOUT_SAMPLES.contains(&kind) || DIAGNOSIS.contains(&kind) => Vec::new(),
                kind => {
                    *self.others.entry(kind).or_default() += 1;
                    Vec::new()
                }
            };
            self.window.consume(record.length);
            self.whole = self.window.taken;
            if samples.is_empty() {
                self.empty += u64::from(matches!(record.kind, ACTIVITY | ACTIVITY_2));
                continue;
            }
            // Seconds are their own numbers, which begin anew where the clock was set back.
            let is_set_back = |before: u32| record.stamp.saturating_add(SET_BACK_S) < before;
            self.sessions += u32::from(self.second.replace(record.stamp).is_some_and(is_set_back));
            let in_g = |counts: [i16; 3]| -> Sample {
                let [x, y, z] = counts.map(|count| f64::from(count) / self.counts_per_g);
                [x, y, z, f64::NAN, f64::NAN, f64::NAN]
            };
            let block = Block {
                session: self.sessions,
                sequence: record.stamp,
                stamp_s: f64::from(record.stamp),
                stamp_sample: 0,
                rate_hz: self.rate_hz,
                temperature_c: f64::NAN,
                battery_v: self.battery_v,
                samples: samples.into_iter().map(in_g).collect(),
            };
            return Ok(Some(self.order.place(place, block)));
        }
    }

    /// Bytes of the stream up to the end of the last whole record.
    pub fn bytes(&self) -> u64 {
        self.log + self.whole
    }

    /// What records were not read.
    pub fn finding(&self) -> Option<Finding> {
        let records = |n: u64| match n {
            1 => "1 record".to_owned(),
            n => format!("{n} records"),
        };
        let mut what = Vec::new();
        if self.empty > 0 {
            what.push(format!("{} without samples (a cable)", records(self.empty)));
        }
        for (kind, n) in &self.others {
            what.push(format!("{} of kind {kind}", records(*n)));
        }
        let count = self.empty + self.others.values().sum::<u64>();
        (count > 0).then(|| {
            let message = format!("{}; not read", what.join(", "));
            Finding::new(FindingKind::OtherRecords, message).counting(count)
        })
    }
}

/// Samples of 12 bits for each axis, in the order y, x, z; bits that are left over are padding.
fn packed(payload: &[u8]) -> Vec<[i16; 3]> {
    let number = |at: usize| {
        let (byte, odd) = (3 * at / 2, at % 2 == 1);
        let pair = u16::from_be_bytes([payload[byte], payload[byte + 1]]);
        // To the top, so that the shift back extends the sign.
        (if odd { pair << 4 } else { pair }).cast_signed() >> 4
    };
    let samples = 0..payload.len() * 8 / 36;
    samples
        .map(|i| {
            let [y, x, z] = [0, 1, 2].map(|axis| number(3 * i + axis));
            [x, y, z]
        })
        .collect()
}

/// Samples of 16 bits for each axis, in the order x, y, z.
fn plain(payload: &[u8]) -> Vec<[i16; 3]> {
    let samples = payload.as_chunks::<6>().0.iter();
    samples
        .map(|[a, b, c, d, e, f]| [[*a, *b], [*c, *d], [*e, *f]].map(i16::from_le_bytes))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_examples_of_the_makers_description_are_decoded() {
        // Three samples of a GT3X+, in counts.
        let bytes = [
            0x00, 0x60, 0x08, 0xeb, 0xd0, 0x07, 0x00, 0x9e, 0xbf, 0x00, 0x70, 0x08, 0xeb, 0xf0,
        ];
        assert_eq!(packed(&bytes), [[8, 6, -323], [9, 7, -321], [8, 7, -321]]);
        let bytes = [0, 0, 0, 0, 0, 0, 0x30, 0, 0xcc, 0xff, 0x42, 0x01];
        assert_eq!(plain(&bytes), [[0, 0, 0], [48, -52, 322]]);
        // Scales of the accelerometer, of another's rate and temperature, and a temperature.
        for (bits, value) in [
            (0x0940_0000, 256.0),
            (0x0541_8937, 16.384),
            (0x0953_77ae, 333.87),
            (0x0554_0000, 21.0),
            (0, 0.0),
        ] {
            assert!(
                (float(bits) - value).abs() < 1e-4,
                "{bits:x}: {}",
                float(bits)
            );
        }
    }
}
