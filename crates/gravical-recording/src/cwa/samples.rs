//! Blocks of a file as rows, each block with its stamp.

use std::io::{self, BufReader, Read};

use gravical_judge::{Error, ReadOptions};

use crate::bytes::read_head;
use crate::text::{CopiedText, Format, Reason, Rows};
use crate::write::{write_fixed, write_trimmed};

use super::block::{BLOCK_BYTES, Block, Defect, HEADER_BYTES, Header, u16_at};

/// Bytes by which [`is_one`] decides.
pub const MAGIC_BYTES: usize = HEADER_BYTES + 2;

/// Blocks among which the first one that can be used is looked for.
const MAX_FIRST_BLOCKS: usize = 512;
/// What the stamps of successive blocks may deviate from the nominal rate before a piece is
/// missing between them: sensors are off by some percent, and a stamp belongs to a sample only
/// within a few samples.
const RATE_TOLERANCE: f64 = 0.1;
const STAMP_TOLERANCE_S: f64 = 0.1;
/// Samples that are given at once, or a few more: their columns fit a cache.
const MIN_SAMPLES: usize = 1 << 14;
/// Bytes that are read at once.
const READ_BYTES: usize = 1 << 18;

/// Names of the columns; without a gyroscope there are no rates.
const COLUMNS: &str = "time_s,ax_g,ay_g,az_g,gx_deg_s,gy_deg_s,gz_deg_s,temperature_c";

/// Decimals of the time as text, s, and of the samples: a 2048th of a g, a 32768th of a range and
/// a 256th of a °C are exact.
const TIME_DECIMALS: u32 = 6;
const DECIMALS: u32 = 12;

/// Whether a file that begins with `head`, of [`MAGIC_BYTES`] or more, is a `.cwa` file.
pub fn is_one(head: &[u8]) -> bool {
    // By the length of the header or by the first block: one of them may be damaged.
    let is_long = || usize::from(u16_at(head, 2)) == HEADER_BYTES - 4;
    head.len() >= MAGIC_BYTES
        && head.starts_with(b"MD")
        && (is_long() || head[HEADER_BYTES..].starts_with(b"AX"))
}

/// Length of the whole blocks of `head`, the beginning of a file.
pub fn whole_blocks(head: &[u8]) -> usize {
    head.len() - head.len().saturating_sub(HEADER_BYTES) % BLOCK_BYTES
}

/// Opens a `.cwa` file from its first byte on: its format as that of a table, and its samples.
///
/// # Errors
///
/// Reading fails, or the options ask for columns that it does not have.
pub fn open<R: Read>(reader: R, options: &ReadOptions) -> Result<(Format, Samples<R>), Error> {
    let mut reader = BufReader::with_capacity(READ_BYTES, reader);
    let mut header = Header([0; HEADER_BYTES]);
    reader.read_exact(&mut header.0)?;
    let mut samples = Samples {
        reader,
        blocks: 0,
        last: None,
        stamp_before: None,
        line: 0,
        rows: Rows::default(),
        copied: Vec::new(),
    };
    for _ in 0..MAX_FIRST_BLOCKS {
        if !samples.read_block()? || samples.last.is_some() {
            break;
        }
    }
    // The blocks say what was measured, the header what was wanted.
    let first = samples.last.as_ref().map(|placed| &placed.block);
    let has_gyro = first.map_or(header.gyro_range_deg_s().is_some(), Block::has_gyro);
    let rate_hz = first.map_or(header.rate_hz(), |block| block.rate_hz);
    let names = COLUMNS.split(',').map(str::to_owned);
    let names: Vec<String> = names.filter(|c| has_gyro || !c.starts_with('g')).collect();
    samples.rows = Rows {
        ledger: std::mem::take(&mut samples.rows.ledger),
        ..Rows::new(names.len())
    };
    // The names tell the columns without rows.
    let mut format = Format::of_table(&names, names.len(), &samples.rows, options)?;
    format.device = Some(header.describe(rate_hz, has_gyro));
    format.metadata = vec![
        format!("Serial number: {}", header.device()),
        format!("Sampling rate: {rate_hz} Hz"),
    ];
    format.rate_hz = Some(rate_hz);
    Ok((format, samples))
}

/// A block within its run: a piece of the recording without a gap.
struct Placed {
    block: Block,
    /// Samples of the run before it.
    first: i64,
    /// Lines before it.
    line: usize,
    /// It does not continue the block before.
    is_after_gap: bool,
    /// When the numbers of the blocks began, s, at the earliest.
    began_s: f64,
}

impl Placed {
    /// The sample of the run to which the stamp belongs, and its time, s.
    fn stamp(&self) -> (i64, f64) {
        (self.first + self.block.stamp_sample, self.block.stamp_s)
    }

    /// The number and the stamp leave no room for missing samples.
    fn is_followed_by(&self, block: &Block) -> bool {
        let samples = self.block.samples as i64 + block.stamp_sample - self.block.stamp_sample;
        let expected_s = samples as f64 / block.rate_hz;
        let elapsed_s = block.stamp_s - self.block.stamp_s;
        let off_s = (elapsed_s - expected_s).abs();
        self.block.session == block.session
            && self.block.sequence.checked_add(1) == Some(block.sequence)
            && self.block.rate_hz == block.rate_hz
            && samples > 0
            && elapsed_s > 0.0
            && off_s <= RATE_TOLERANCE * expected_s + STAMP_TOLERANCE_S
    }
}

/// Iterates over the samples of a file, 16,384 or a few more at once: whole blocks.
pub struct Samples<R> {
    reader: BufReader<R>,
    /// Blocks read.
    blocks: usize,
    /// The last block that is used: its times wait for the stamp of the next one.
    last: Option<Placed>,
    /// The stamp of the block before that.
    stamp_before: Option<(i64, f64)>,
    /// Lines so far.
    line: usize,
    rows: Rows,
    copied: Vec<(usize, usize)>,
}

impl<R: Read> Samples<R> {
    /// Keeps the text of columns in [`Rows::text`], in pieces from one column to another.
    pub fn with_text(mut self, pieces: &[(usize, usize)]) -> Self {
        self.copied = pieces.to_vec();
        self
    }

    fn read_rows(&mut self) -> io::Result<Option<Rows>> {
        while self.rows.rows() < MIN_SAMPLES && self.read_block()? {}
        if self.rows.rows() == 0 && self.rows.ledger.total() == 0 {
            return Ok(None);
        }
        let waiting = self.last.as_ref().map_or(0, |placed| placed.block.samples);
        let next = Rows::new(self.rows.columns.len());
        let mut rows = std::mem::replace(&mut self.rows, next);
        rows.ledger.lines = self.line - waiting;
        rows.text = self.text(&rows);
        Ok(Some(rows))
    }

    /// Reads the next block, and adds the samples of the one before; false at the end.
    fn read_block(&mut self) -> io::Result<bool> {
        let bytes = read_head(&mut self.reader, BLOCK_BYTES)?;
        if bytes.is_empty() {
            if let Some(last) = self.last.take() {
                self.add_samples(&last, None);
            }
            return Ok(false);
        }
        let placed = match <&[u8; BLOCK_BYTES]>::try_from(&bytes[..]) {
            Ok(bytes) => Block::parse(bytes).and_then(|block| self.place(block)),
            Err(_) => Err((Reason::CorruptBlock, "cut off")),
        };
        self.blocks += 1;
        match placed {
            Ok(placed) => {
                self.line += placed.block.samples;
                let next = (!placed.is_after_gap).then(|| placed.stamp());
                if let Some(last) = self.last.replace(placed) {
                    self.add_samples(&last, next);
                }
            }
            Err((reason, why)) => {
                self.line += 1;
                let byte = HEADER_BYTES + (self.blocks - 1) * BLOCK_BYTES;
                let text = format!("block {} at byte {byte}: {why}", self.blocks);
                self.rows.ledger.add(reason, self.line, &text);
            }
        }
        Ok(true)
    }

    /// Where a block belongs.
    fn place(&self, block: Block) -> Result<Placed, Defect> {
        let samples = (f64::from(block.sequence) + 1.0) * block.samples as f64;
        let duration_s = (1.0 + RATE_TOLERANCE) * samples / block.rate_hz + STAMP_TOLERANCE_S;
        let mut placed = Placed {
            first: 0,
            line: self.line,
            is_after_gap: self.last.is_some(),
            began_s: block.stamp_s - duration_s,
            block,
        };
        let Some(last) = &self.last else {
            return Ok(placed);
        };
        let (block, before) = (&placed.block, &last.block);
        if block.session == before.session {
            // Numbers that begin anew: at a time of its own, also by a clock that was set back.
            let is_of_its_own = block.stamp_s > before.stamp_s || block.stamp_s < last.began_s;
            if block.sequence > before.sequence {
                placed.began_s = last.began_s;
            } else if block.sequence == before.sequence || !is_of_its_own {
                return Err((Reason::LateBlock, "not later than the one before"));
            }
        }
        if last.is_followed_by(&placed.block) {
            placed.first = last.first + last.block.samples as i64;
            placed.is_after_gap = false;
        }
        Ok(placed)
    }

    /// Adds the samples of a block. Between the samples to which two successive stamps belong they are spaced
    /// evenly: the true rate differs from the nominal one by some percent, and changes with temperature.
    /// Before the first stamp of a run and after its last the nearest spacing continues.
    fn add_samples(&mut self, placed: &Placed, next: Option<(i64, f64)>) {
        let block = &placed.block;
        let (stamped, stamp_s) = placed.stamp();
        let period_s =
            |(sample, time_s): (i64, f64)| (time_s - stamp_s) / (sample - stamped) as f64;
        let before = self.stamp_before.replace((stamped, stamp_s));
        let before = before.filter(|_| !placed.is_after_gap).map(period_s);
        let after = next.map(period_s);
        let [before_s, after_s] =
            [before.or(after), after.or(before)].map(|s| s.unwrap_or(1.0 / block.rate_hz));
        if placed.is_after_gap {
            self.rows.breaks.push(self.rows.rows());
        }
        let [time, channels @ .., temperature] = &mut self.rows.columns[..] else {
            return;
        };
        block.append_to(channels);
        time.extend((0..block.samples as i64).map(|sample| {
            let past = placed.first + sample - stamped;
            let step_s = if past < 0 { before_s } else { after_s };
            stamp_s + past as f64 * step_s
        }));
        temperature.resize(time.len(), block.temperature_c);
        let lines = placed.line + 1..=placed.line + block.samples;
        let lines = lines.map(|line| u32::try_from(line).unwrap_or(u32::MAX));
        self.rows.lines.extend(lines);
    }

    fn text(&self, rows: &Rows) -> CopiedText {
        let mut text = CopiedText::new(self.copied.len());
        let mut piece = Vec::new();
        for row in 0..rows.rows() {
            for (first, last) in &self.copied {
                piece.clear();
                for column in *first..=*last {
                    let value = rows.columns[column][row];
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
    type Item = io::Result<Rows>;

    fn next(&mut self) -> Option<Self::Item> {
        self.read_rows().transpose()
    }
}
