//! Files of worn devices (Axivity, `.cwa`) to batches: blocks of samples, each with one time stamp.
//!
//! A "line" of such a file is a sample or a block that is skipped, counted from 1.

mod block;
mod means;
mod order;

use std::collections::VecDeque;
use std::io::{self, BufReader, Read};

use crate::bytes::read_head;
use crate::error::Error;
use crate::metadata;
use crate::options::ReadOptions;
use crate::text::{BATCH_ROWS, Batch, CopiedText, Format, Reason};
use crate::write::{write_fixed, write_trimmed};

use block::{BLOCK_BYTES, Block, HEADER_BYTES, Header};
use order::{Event, Order, Placed};

pub use means::read;

/// Bytes by which [`is_one`] decides.
pub const MAGIC_BYTES: usize = HEADER_BYTES + 2;

/// Blocks among which the first one that can be used is looked for.
const MAX_FIRST_BLOCKS: usize = 512;
/// Skipped blocks across which the stamp of the next block is looked for.
const MAX_SKIPPED: usize = 64;
/// Bytes that are read at once.
const READ_BYTES: usize = 1 << 18;

/// Names of the columns; without a gyroscope there are no rates.
const COLUMNS: &str = "time_s,ax_g,ay_g,az_g,gx_deg_s,gy_deg_s,gz_deg_s,temperature_c";

/// Decimals of the time as text, s, and of the samples: a 2048th of a g, a 32768th of a range and
/// a 256th of a °C are exact.
const TIME_DECIMALS: u32 = 6;
const DECIMALS: u32 = 12;

/// Whether a file that begins with `head`, of [`MAGIC_BYTES`] or more, is a `.cwa` file.
#[must_use]
pub fn is_one(head: &[u8]) -> bool {
    Header::parse(head).is_some()
}

/// Length of the whole blocks of `head`, the beginning of a file.
#[must_use]
pub fn whole_blocks(head: &[u8]) -> usize {
    head.len() - head.len().saturating_sub(HEADER_BYTES) % BLOCK_BYTES
}

/// Opens a file from its first byte on: its format as that of a table, and its samples.
///
/// # Errors
///
/// Reading fails, it is no `.cwa` file, or the options ask for columns that it does not have.
pub fn open<R: Read>(reader: R, options: &ReadOptions) -> Result<(Format, Samples<R>), Error> {
    let mut reader = BufReader::with_capacity(READ_BYTES, reader);
    let head = read_head(&mut reader, MAGIC_BYTES)?;
    let header = Header::parse(&head).ok_or_else(|| {
        let what = "the header of a .cwa file is missing";
        io::Error::new(io::ErrorKind::InvalidData, what)
    })?;
    let mut samples = Samples {
        reader,
        begun: head[HEADER_BYTES..].to_vec(),
        read: 0,
        order: Order::default(),
        ahead: VecDeque::new(),
        is_at_end: false,
        last_stamp: None,
        line: 0,
        batch: Batch::default(),
        copied: Vec::new(),
        error: None,
    };
    // The blocks say what was measured, the header what was wanted.
    let first = samples.find_first_block()?;
    let has_gyro = first.map_or(header.gyro_range_deg_s.is_some(), |b| b.0);
    let rate_hz = first.map_or(header.rate_hz, |b| b.1);
    let names = COLUMNS
        .split(',')
        .filter(|c| has_gyro || !c.starts_with('g'));
    let names: Vec<String> = names.map(str::to_owned).collect();
    samples.batch = Batch::new(names.len());
    // The names tell the columns without rows.
    let mut format = Format::of_table(&names, names.len(), &samples.batch, options)?;
    format.device = Some(header.describe(rate_hz, has_gyro));
    format.metadata = vec![
        format!("Serial number: {}", header.device),
        format!("Sampling rate: {rate_hz} Hz"),
    ];
    format.rate_hz = metadata::rate_hz(&format.metadata);
    Ok((format, samples))
}

/// Iterates over the samples of a file in batches of 65,536 or a few more: whole blocks.
pub struct Samples<R> {
    reader: BufReader<R>,
    /// Bytes of the first block that were read with the header.
    begun: Vec<u8>,
    /// Blocks read.
    read: u64,
    order: Order,
    /// Blocks that were read for the stamp of the next one.
    ahead: VecDeque<Event>,
    is_at_end: bool,
    /// Sample of the run and time, s, of the last stamp since a gap.
    last_stamp: Option<(i64, f64)>,
    /// Lines so far.
    line: usize,
    batch: Batch,
    copied: Vec<(usize, usize)>,
    error: Option<io::Error>,
}

impl<R: Read> Samples<R> {
    /// Keeps the text of columns in [`Batch::text`], in pieces from one column to another.
    #[must_use]
    pub fn with_text(mut self, pieces: &[(usize, usize)]) -> Self {
        self.copied = pieces.to_vec();
        self
    }

    /// Whether the first block that can be used has a gyroscope, and its rate, Hz.
    fn find_first_block(&mut self) -> io::Result<Option<(bool, f64)>> {
        while self.ahead.len() < MAX_FIRST_BLOCKS && !self.is_at_end {
            self.read_ahead()?;
            if let Some(Event::Block(placed)) = self.ahead.back() {
                return Ok(Some((placed.block.has_gyro(), placed.block.rate_hz)));
            }
        }
        Ok(None)
    }

    /// The next batch; what was read before an error is one of its own.
    fn read_batch(&mut self) -> Option<Batch> {
        while self.batch.rows() < BATCH_ROWS && self.error.is_none() {
            match self.add_block() {
                Ok(true) => {}
                Ok(false) => break,
                Err(e) => self.error = Some(e),
            }
        }
        if self.is_at_end && self.ahead.is_empty() {
            self.batch.findings = std::mem::take(&mut self.order).findings();
        }
        if self.batch.rows() == 0
            && self.batch.ledger.total() == 0
            && self.batch.findings.is_empty()
        {
            return None;
        }
        self.batch.ledger.lines = self.line;
        let next = Batch::new(self.batch.columns.len());
        Some(std::mem::replace(&mut self.batch, next))
    }

    /// Adds the next block; false at the end.
    fn add_block(&mut self) -> io::Result<bool> {
        if self.ahead.is_empty() {
            self.read_ahead()?;
        }
        match self.ahead.pop_front() {
            None => return Ok(false),
            Some(Event::Skipped(reason, what)) => {
                self.line += 1;
                self.batch.ledger.add(reason, self.line, &what);
            }
            Some(Event::Block(placed)) => {
                if placed.is_after_gap {
                    self.last_stamp = None;
                    self.batch.breaks.push(self.batch.rows());
                    self.order.breaks.push(self.line as u64 + 1);
                }
                self.add_samples(&placed)?;
            }
        }
        Ok(true)
    }

    /// Adds the samples of a block. Between the samples to which two successive stamps belong they are spaced
    /// evenly: the true rate differs from the nominal one by some percent, and changes with temperature.
    /// Before the first stamp of a run and after its last the nearest spacing continues.
    fn add_samples(&mut self, placed: &Placed) -> io::Result<()> {
        let block = &placed.block;
        let (stamped, stamp_s) = (placed.stamp_sample(), block.stamp_s);
        let period_s =
            |(sample, time_s): (i64, f64)| (time_s - stamp_s) / (sample - stamped) as f64;
        let before = self.last_stamp.replace((stamped, stamp_s)).map(period_s);
        let after = self.next_stamp()?.map(period_s);
        let nominal = 1.0 / block.rate_hz;
        let before_s = before.or(after).unwrap_or(nominal);
        let after_s = after.or(before).unwrap_or(nominal);
        let [time, channels @ .., temperature] = &mut self.batch.columns[..] else {
            return Ok(());
        };
        block.append_to(channels);
        time.extend((0..block.samples as i64).map(|sample| {
            let past = placed.first + sample - stamped;
            let step_s = if past < 0 { before_s } else { after_s };
            stamp_s + past as f64 * step_s
        }));
        temperature.resize(time.len(), block.temperature_c);
        let lines = self.line + 1..=self.line + block.samples;
        let lines = lines.map(|line| u32::try_from(line).unwrap_or(u32::MAX));
        self.batch.lines.extend(lines);
        self.line += block.samples;
        Ok(())
    }

    /// Sample and time of the stamp of the next block, if no gap lies before it.
    fn next_stamp(&mut self) -> io::Result<Option<(i64, f64)>> {
        for seen in 0..=MAX_SKIPPED {
            if seen == self.ahead.len() && !self.is_at_end {
                self.read_ahead()?;
            }
            match self.ahead.get(seen) {
                Some(Event::Skipped(..)) => {}
                Some(Event::Block(next)) if !next.is_after_gap => {
                    return Ok(Some((next.stamp_sample(), next.block.stamp_s)));
                }
                _ => break,
            }
        }
        Ok(None)
    }

    fn read_ahead(&mut self) -> io::Result<()> {
        let mut bytes = std::mem::take(&mut self.begun);
        let missing = BLOCK_BYTES - bytes.len();
        bytes.append(&mut read_head(&mut self.reader, missing)?);
        self.is_at_end = bytes.is_empty();
        if self.is_at_end {
            return Ok(());
        }
        self.read += 1;
        let block = match <&[u8; BLOCK_BYTES]>::try_from(&bytes[..]) {
            Ok(bytes) => Block::parse(bytes),
            Err(_) => Err((Reason::CorruptBlock, "cut off")),
        };
        self.ahead.push_back(match block {
            Ok(block) => self.order.place(self.read, block),
            Err(defect) => self.order.skip(self.read, defect),
        });
        Ok(())
    }

    fn text(&self, batch: &Batch) -> CopiedText {
        let mut text = CopiedText::new(self.copied.len(), 0, batch.rows());
        let mut piece = Vec::new();
        for row in 0..batch.rows() {
            for (first, last) in &self.copied {
                piece.clear();
                for column in *first..=*last {
                    let value = batch.columns[column][row];
                    match column {
                        0 => write_fixed(&mut piece, value, TIME_DECIMALS),
                        _ => write_trimmed(&mut piece, value, DECIMALS),
                    }
                    piece.push(b',');
                }
                piece.pop();
                text.push(&piece);
            }
        }
        text
    }
}

impl<R: Read> Iterator for Samples<R> {
    type Item = io::Result<Batch>;

    fn next(&mut self) -> Option<Self::Item> {
        let Some(mut batch) = self.read_batch() else {
            return self.error.take().map(Err);
        };
        batch.text = self.text(&batch);
        Some(Ok(batch))
    }
}
