//! Files of a worn device (Axivity, `.cwa`) as a source of rows: blocks of samples, each with one
//! time stamp.
//!
//! [`axivity`] decodes; [`order`] tells which blocks follow one another, [`clock`] gives each sample
//! its time. A "line" of such a file is a sample, or a block that is skipped,
//! counted from 1 in the order of the file.

mod axivity;
mod clock;
mod order;

use std::collections::VecDeque;
use std::io::{self, BufReader, Read};
use std::path::Path;

use crate::finding::{Finding, LineSpans};
use crate::scan::{write_fixed, write_trimmed};
use crate::{Error, Result};

use super::dialect::{Dialect, Header as Names};
use super::row::{ACCEL, Delimiter, GYRO, SLOTS, TEMPERATURE, TIME, Values};
use super::rows::{Item, Source, Text};

use clock::RunClock;
use order::{Event, Placed};

/// Bytes that tell the files of devices from others.
pub(super) const MAGIC: usize = axivity::MAGIC;

/// Largest number of skipped blocks across which the next block is looked for.
const MOST_AHEAD: usize = 64;

/// Specific force, g, and angular rate, °/s (NaN without a gyroscope).
type Sample = [f64; 6];

/// Number of rows by which columns are recognised, as of a text.
const SAMPLE: usize = 200;

/// Columns of the samples as text, by slot.
const COLUMNS: [&str; SLOTS] = [
    "time_s",
    "ax_g",
    "ay_g",
    "az_g",
    "gx_deg_s",
    "gy_deg_s",
    "gz_deg_s",
    "temperature_c",
];

/// Decimals of the time in a text, s, and of the samples: of Axivity, a 2048th of a g, a 32768th of
/// a range and a 256th of a °C are exact.
const TIME_DECIMALS: u32 = 6;
const DECIMALS: u32 = 12;

/// True if a file that begins with `head`, of [`MAGIC`] bytes or more, is a `.cwa` file.
pub(super) fn is_one(head: &[u8]) -> bool {
    axivity::is_one(head)
}

/// True if the file at `path`, plain or packed, is a `.cwa` file.
///
/// # Errors
///
/// As [`open`](super::open::open).
pub(crate) fn is_file(path: &Path) -> Result<bool> {
    let input = super::open::open(path, &super::ReadOptions::default())?;
    let head = super::open::peek(input.reader, MAGIC);
    let (head, _) = head.map_err(|e| Error::io(path, e))?;
    Ok(is_one(&head))
}

/// Length of the complete blocks of `head`, the beginning of a file.
pub(super) fn complete_blocks(head: &[u8]) -> usize {
    let Ok(mut blocks) = axivity::Blocks::new(head) else {
        return head.len();
    };
    while let Ok(Some(_)) = blocks.next(true) {}
    usize::try_from(blocks.bytes()).map_or(head.len(), |n| n.min(head.len()))
}

/// What the first bytes of a file tell.
#[derive(Debug)]
pub(super) struct Opened {
    /// Device and settings in words.
    pub description: String,
    /// The samples as a table.
    pub dialect: Dialect,
    /// Slots of its columns.
    columns: Vec<usize>,
}

impl Opened {
    fn new(
        description: String,
        serial: &str,
        rate_hz: f64,
        with_gyro: bool,
        with_temperature: bool,
    ) -> Self {
        let is_there = |slot: &usize| match *slot {
            TEMPERATURE => with_temperature,
            slot => with_gyro || !(GYRO..GYRO + 3).contains(&slot),
        };
        let columns: Vec<usize> = (0..SLOTS).filter(is_there).collect();
        Opened {
            description,
            dialect: Dialect {
                delimiter: Delimiter::Byte(b','),
                decimal_comma: false,
                fields: columns.len(),
                header: Some(Names {
                    lines: [0, 0],
                    names: columns
                        .iter()
                        .map(|slot| COLUMNS[*slot].to_owned())
                        .collect(),
                    units: Vec::new(),
                    texts: Vec::new(),
                }),
                first_data_line: 1,
                metadata: vec![
                    format!("Serial number: {serial}"),
                    format!("Sampling rate: {rate_hz} Hz"),
                ],
                regular_blanks: 0,
                misfit: None,
                sample: Vec::new(),
            },
            columns,
        }
    }

    /// `head` are the first bytes of a file.
    ///
    /// # Errors
    ///
    /// `header-incomplete` about the file `name`.
    pub fn of(head: &[u8], name: &Path) -> Result<Self> {
        let mut opened = axivity::open(head).ok_or_else(|| {
            Error::input(
                "header-incomplete",
                "the header of the file lacks its start",
            )
            .at(name, None)
            .with_hint("export the recording as CSV with the program of its maker, and read that")
        })?;
        let mut rows = opened
            .rows(head, "", true)
            .map_err(|e| Error::io(name, e))?;
        let mut values = [f64::NAN; SLOTS];
        while let Ok(Some(item)) = rows.next(&mut values)
            && opened.dialect.sample.len() < SAMPLE
        {
            if item == Item::Row {
                let row = opened.columns.iter().map(|slot| values[*slot]);
                opened.dialect.sample.push(row.collect());
            }
        }
        Ok(opened)
    }

    /// The rows of `reader`, which is at the start of the file; with `cut` it is the beginning of a
    /// longer file.
    ///
    /// # Errors
    ///
    /// Errors of reading.
    pub fn rows<R: Read>(&self, reader: R, name: &str, cut: bool) -> io::Result<DeviceRows<R>> {
        let reader = BufReader::with_capacity(1 << 18, reader);
        Ok(DeviceRows {
            blocks: axivity::Blocks::new(reader)?,
            cut,
            name: name.to_owned(),
            with_gyro: self.columns.contains(&GYRO),
            columns: self.columns.clone(),
            ahead: VecDeque::new(),
            ended: false,
            current: None,
            next: 0,
            clock: RunClock::default(),
            number: 0,
            breaks: LineSpans::default(),
            with_text: false,
            text: Vec::new(),
        })
    }
}

/// Samples of a file as rows.
pub(crate) struct DeviceRows<R> {
    blocks: axivity::Blocks<BufReader<R>>,
    /// The input is the beginning of a longer file.
    cut: bool,
    name: String,
    /// Slots of the columns of the text.
    columns: Vec<usize>,
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
}

impl<R: Read> DeviceRows<R> {
    /// Provides the text of every row, as a table.
    pub fn provide_text(&mut self) {
        self.with_text = true;
    }

    /// Findings about blocks.
    pub fn findings(&self) -> Vec<Finding> {
        self.blocks.order.findings(&self.breaks)
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
        let next = self.blocks.next(self.cut);
        match next.map_err(|e| Error::io(Path::new(&self.name), e))? {
            Some((gap, event)) => {
                self.ahead.extend(gap);
                self.ahead.push_back(event);
            }
            None => self.ended = true,
        }
        Ok(())
    }

    /// Writes the next row, or a comment for a block that is skipped, as a line of text; false at
    /// the end.
    ///
    /// # Errors
    ///
    /// Errors of reading.
    pub fn next_line(&mut self, out: &mut Vec<u8>) -> Result<bool> {
        let mut values = [f64::NAN; SLOTS];
        match self.next(&mut values)? {
            None => return Ok(false),
            Some(Item::Row) => out.extend_from_slice(&self.text),
            Some(Item::Gap) => out.extend_from_slice(b"# gap: blocks are missing"),
            Some(_) => {
                out.extend_from_slice(b"# ");
                out.extend_from_slice(&self.text);
            }
        }
        out.push(b'\n');
        Ok(true)
    }

    fn write_text(&mut self, values: &Values) {
        self.text.clear();
        for &slot in &self.columns {
            match slot {
                TIME => write_fixed(&mut self.text, values[slot], TIME_DECIMALS),
                _ => write_trimmed(&mut self.text, values[slot], DECIMALS),
            }
            self.text.push(b',');
        }
        self.text.pop();
    }
}

impl<R: Read> Source for DeviceRows<R> {
    #[inline]
    fn next(&mut self, values: &mut Values) -> Result<Option<Item>> {
        loop {
            if let Some(placed) = &self.current
                && let Some([ax, ay, az, gx, gy, gz]) = placed.block.samples.get(self.next)
            {
                values[TIME] = self.clock.time_s(placed.first + self.next as i64);
                values[ACCEL..ACCEL + 3].copy_from_slice(&[*ax, *ay, *az]);
                if self.with_gyro {
                    values[GYRO..GYRO + 3].copy_from_slice(&[*gx, *gy, *gz]);
                }
                values[TEMPERATURE] = placed.block.temperature_c;
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
                .map_or(0, |placed| placed.block.samples.len() - self.next);
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
            label: &[],
        }
    }
}
