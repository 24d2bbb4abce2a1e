//! Recordings of Axivity AX3 and AX6 (`.cwa`) as a source of rows.
//!
//! [`block`] decodes, [`blocks`] tells which blocks follow one another, [`clock`] gives each sample
//! its time. A "line" of such a file is a sample, or a block that is skipped, counted from 1 in the
//! order of the file.

mod block;
mod blocks;
mod clock;

use std::collections::VecDeque;
use std::io::{self, BufReader, Read};
use std::path::Path;

use crate::finding::{Finding, LineSpans};
use crate::scan::{write_fixed, write_trimmed};
use crate::{Error, Result};

use super::dialect::{Dialect, Header as Names};
use super::row::{ACCEL, Delimiter, GYRO, Span, TEMPERATURE, TIME, Values};
use super::rows::{Item, Source, Text};

use block::{BLOCK, Block, HEADER, Header};
use blocks::{Blocks, Event, Placed};
use clock::RunClock;

/// Bytes that tell a `.cwa` file from others.
pub(super) const MAGIC: usize = HEADER + 2;

/// Largest number of skipped blocks across which the next block is looked for.
const MOST_AHEAD: usize = 64;

/// Number of rows by which columns are recognised, as of a text.
const SAMPLE: usize = 200;

/// Columns of the samples as text.
const COLUMNS: [&str; 8] = [
    "time_s",
    "ax_g",
    "ay_g",
    "az_g",
    "gx_deg_s",
    "gy_deg_s",
    "gz_deg_s",
    "temperature_c",
];
/// Slots of these columns.
const SLOTS: [usize; 8] = [
    TIME,
    ACCEL,
    ACCEL + 1,
    ACCEL + 2,
    GYRO,
    GYRO + 1,
    GYRO + 2,
    TEMPERATURE,
];

/// Decimals of the time in a text, s, and of the samples: a 2048th of a g, a 32768th of a range
/// and a 256th of a °C are exact.
const TIME_DECIMALS: u32 = 6;
const DECIMALS: u32 = 12;

/// True if a file that begins with `head` is a `.cwa` file.
pub(super) fn is_axivity(head: &[u8]) -> bool {
    Header::parse(head).is_some()
}

/// Length of the complete blocks of `head`, the beginning of a file.
pub(super) fn complete_blocks(head: &[u8]) -> usize {
    head.len() - head.len().saturating_sub(HEADER) % BLOCK
}

/// What the first bytes of a file tell.
#[derive(Debug)]
pub(super) struct Opened {
    /// Device and settings in words.
    pub description: String,
    /// The samples as a table.
    pub dialect: Dialect,
    with_gyro: bool,
}

impl Opened {
    /// `head` are the first bytes of a file; `None` if it is not a `.cwa` file.
    pub fn of(head: &[u8]) -> Option<Self> {
        let header = Header::parse(head)?;
        // The blocks say what was measured, the header what was wanted.
        let first = first_block(&head[HEADER..]);
        let with_gyro = match &first {
            Some(block) => block.has_gyro(),
            None => header.gyro_range_deg_s.is_some(),
        };
        let rate_hz = first.as_ref().map_or(header.rate_hz, |b| b.rate_hz);
        let mut opened = Opened {
            description: describe(&header, rate_hz, with_gyro),
            dialect: Dialect {
                delimiter: Delimiter::Byte(b','),
                decimal_comma: false,
                fields: 0,
                header: None,
                first_data_line: 1,
                metadata: vec![
                    format!("Serial number: {}", header.device),
                    format!("Sampling rate: {rate_hz} Hz"),
                ],
                regular_blanks: 0,
                misfit: None,
                sample: Vec::new(),
            },
            with_gyro,
        };
        let columns: Vec<usize> = columns(with_gyro).collect();
        opened.dialect.fields = columns.len();
        opened.dialect.header = Some(Names {
            lines: [0, 0],
            names: columns.iter().map(|c| COLUMNS[*c].to_owned()).collect(),
            units: Vec::new(),
            texts: Vec::new(),
        });
        let mut rows = AxivityRows::behind_header(&head[HEADER..], "", with_gyro);
        let mut values = [f64::NAN; super::row::SLOTS];
        while let Ok(Some(item)) = rows.next(&mut values)
            && opened.dialect.sample.len() < SAMPLE
        {
            if item == Item::Row {
                let row = columns.iter().map(|c| values[SLOTS[*c]]);
                opened.dialect.sample.push(row.collect());
            }
        }
        Some(opened)
    }
}

fn columns(with_gyro: bool) -> impl Iterator<Item = usize> + Clone {
    (0..COLUMNS.len()).filter(move |c| with_gyro || !(GYRO..GYRO + 3).contains(&SLOTS[*c]))
}

/// The first block of these that can be used.
fn first_block(mut bytes: &[u8]) -> Option<Block> {
    while let Some((block, rest)) = bytes.split_first_chunk() {
        if let Ok(block) = Block::parse(block) {
            return Some(block);
        }
        bytes = rest;
    }
    None
}

fn describe(header: &Header, rate_hz: f64, with_gyro: bool) -> String {
    let mut parts = vec![
        format!("Axivity {}", header.model),
        format!("session {}", header.session),
        format!("nominal {rate_hz} Hz"),
        format!("±{} g", header.range_g),
    ];
    if let Some(range) = header.gyro_range_deg_s.filter(|_| with_gyro) {
        parts.push(format!("±{range} °/s"));
    }
    parts.join(", ")
}

/// Samples of a file as rows.
pub(crate) struct AxivityRows<R> {
    blocks: Blocks<BufReader<R>>,
    name: String,
    with_gyro: bool,
    /// Blocks, read ahead for the stamp of the next one.
    ahead: VecDeque<Event>,
    ended: bool,
    current: Option<Box<Placed>>,
    /// The next sample of the current block.
    next: usize,
    clock: RunClock,
    number: u64,
    /// Lines after gaps.
    breaks: LineSpans,
    /// Rows as text are requested.
    with_text: bool,
    text: Vec<u8>,
    spans: Vec<Span>,
}

impl<R: Read> AxivityRows<R> {
    /// `reader` is at the start of the file.
    ///
    /// # Errors
    ///
    /// Errors of reading.
    pub(super) fn new(mut reader: R, name: &str, opened: &Opened) -> io::Result<Self> {
        reader.read_exact(&mut [0; HEADER])?;
        Ok(Self::behind_header(reader, name, opened.with_gyro))
    }

    /// The rows of `head`, the first bytes of this file.
    pub fn of_head<'a>(&self, head: &'a [u8], name: &str) -> AxivityRows<&'a [u8]> {
        let blocks = head.get(HEADER..complete_blocks(head)).unwrap_or_default();
        AxivityRows::behind_header(blocks, name, self.with_gyro)
    }

    fn behind_header(reader: R, name: &str, with_gyro: bool) -> Self {
        AxivityRows {
            blocks: Blocks::new(BufReader::with_capacity(1 << 18, reader)),
            name: name.to_owned(),
            with_gyro,
            ahead: VecDeque::new(),
            ended: false,
            current: None,
            next: 0,
            clock: RunClock::default(),
            number: 0,
            breaks: LineSpans::default(),
            with_text: false,
            text: Vec::new(),
            spans: Vec::new(),
        }
    }

    /// Provides the text of every row, as a table.
    pub fn provide_text(&mut self) {
        self.with_text = true;
    }

    /// Findings about blocks.
    pub fn findings(&self) -> Vec<Finding> {
        self.blocks.findings(&self.breaks)
    }

    /// The battery in words.
    pub fn battery(&self) -> Option<String> {
        let [from, to] = self.blocks.battery_v()?;
        Some(format!("battery {from:.2} to {to:.2} V"))
    }

    /// Continues with what follows the current block: a block, whose samples are rows, or what is
    /// returned. `None` at the end.
    #[cold]
    fn advance(&mut self) -> Result<Option<Option<Item>>> {
        self.current = None;
        if self.ahead.is_empty() {
            self.read_ahead()?;
        }
        let Some(event) = self.ahead.pop_front() else {
            return Ok(None);
        };
        Ok(Some(match event {
            Event::Gap => {
                self.clock = RunClock::default();
                self.breaks.push(self.number + 1);
                Some(Item::Gap)
            }
            Event::Skipped(skipped) => {
                self.number += 1;
                self.text = skipped.text().into_bytes();
                self.spans.clear();
                Some(Item::Aside(skipped.reason))
            }
            Event::Block(placed) => {
                self.text.clear();
                if self.clock.is_empty() {
                    self.clock.begin(1.0 / placed.block.rate_hz);
                    self.clock
                        .stamp(placed.stamp_sample(), placed.block.stamp_s);
                }
                self.stamp_of_next()?;
                self.next = 0;
                self.current = Some(placed);
                None
            }
        }))
    }

    /// Adds the stamp of the next block of the run to the clock.
    fn stamp_of_next(&mut self) -> Result<()> {
        let mut seen = 0;
        loop {
            while seen == self.ahead.len() && !self.ended {
                self.read_ahead()?;
            }
            match self.ahead.get(seen) {
                Some(Event::Block(next)) => {
                    self.clock.stamp(next.stamp_sample(), next.block.stamp_s);
                    return Ok(());
                }
                Some(Event::Skipped(_)) if seen < MOST_AHEAD => seen += 1,
                _ => return Ok(()),
            }
        }
    }

    fn read_ahead(&mut self) -> Result<()> {
        let next = self.blocks.next();
        match next.map_err(|e| Error::io(Path::new(&self.name), e))? {
            Some((gap, event)) => {
                self.ahead.extend(gap);
                self.ahead.push_back(event);
            }
            None => self.ended = true,
        }
        Ok(())
    }

    fn write_text(&mut self, values: &Values) {
        self.text.clear();
        self.spans.clear();
        for column in columns(self.with_gyro) {
            let from = self.text.len() as u32;
            let value = values[SLOTS[column]];
            match SLOTS[column] {
                TIME => write_fixed(&mut self.text, value, TIME_DECIMALS),
                _ => write_trimmed(&mut self.text, value, DECIMALS),
            }
            self.spans.push((from, self.text.len() as u32));
            self.text.push(b',');
        }
        self.text.pop();
    }
}

impl Placed {
    /// The sample of the run to which the stamp belongs.
    fn stamp_sample(&self) -> i64 {
        self.first + self.block.stamp_sample
    }
}

impl<R: Read> Source for AxivityRows<R> {
    #[inline]
    fn next(&mut self, values: &mut Values) -> Result<Option<Item>> {
        loop {
            if let Some(placed) = &self.current
                && self.next < placed.block.samples
            {
                let (block, i) = (&placed.block, self.next);
                values[TIME] = self.clock.time_s(placed.first + i as i64);
                values[ACCEL..ACCEL + 3].copy_from_slice(&block.accel(i));
                if self.with_gyro {
                    values[GYRO..GYRO + 3].copy_from_slice(&block.gyro(i));
                }
                values[TEMPERATURE] = block.temperature_c;
                self.next += 1;
                self.number += 1;
                if self.with_text {
                    self.write_text(values);
                }
                return Ok(Some(Item::Row));
            }
            match self.advance()? {
                None => return Ok(None),
                Some(Some(item)) => return Ok(Some(item)),
                Some(None) => {}
            }
        }
    }

    #[inline]
    fn number(&self) -> u64 {
        self.number
    }

    fn can_skip(&self) -> bool {
        true
    }

    fn skip_to(&mut self, line: u64) -> Result<()> {
        while self.number < line {
            let left = self
                .current
                .as_ref()
                .map_or(0, |placed| placed.block.samples - self.next);
            if left == 0 {
                if self.advance()?.is_none() {
                    break;
                }
                continue;
            }
            let skipped = left.min(usize::try_from(line - self.number).unwrap_or(left));
            self.next += skipped;
            self.number += skipped as u64;
        }
        Ok(())
    }

    #[inline]
    fn text(&self) -> Text<'_> {
        Text {
            bytes: &self.text,
            spans: &self.spans,
            label: &[],
        }
    }
}
