//! Passes over a long recording that store blocks of it.

use super::plan::{Quiet, find_quiet};
use crate::Result;
use crate::recording::Recording;
use crate::recording::collect::{Columns, Sink};
use crate::recording::monitor::Facts;
use crate::recording::row::{ACCEL, GYRO, TEMPERATURE, Values};
use crate::recording::rows::{Mark, Rows, Source};
use crate::stats::Thinned;
use crate::stills::{Block, Levels, block_rows};

/// The first pass: stores all rows of a short recording, and blocks of a long one.
pub(super) struct Survey {
    pub columns: Columns,
    pub long: Option<Long>,
    whole: usize,
    blocks: usize,
    rate: Option<f64>,
    marks: Thinned<(usize, Option<Mark>), MOST_MARKS>,
}

/// Interval of the marks at which the last pass can continue, in rows.
const MARKED: usize = 512;
const MOST_MARKS: usize = 1 << 12;

/// Results of the first pass over a long recording.
pub(super) struct Long {
    /// Rows of a block.
    pub width: usize,
    pub blocks: Blocks,
    /// Number of rows.
    pub rows: usize,
    /// Rows that do not continue the row before.
    pub breaks: Vec<usize>,
    /// True with a gyroscope.
    pub gyro: bool,
    /// The clock restarted at least once.
    pub restarted: bool,
    /// Lowest and highest temperature, °C.
    temperature_c: [f64; 2],
    cutter: Cutter,
    /// Positions where reading can be continued, with the number of the next row.
    pub marks: Vec<(usize, Mark)>,
}

impl Survey {
    /// Stores up to `whole` rows, then up to `blocks` blocks at the `rate`, Hz, if it is known.
    pub fn new(columns: Columns, whole: usize, blocks: usize, rate: Option<f64>) -> Self {
        Survey {
            whole,
            columns,
            long: None,
            blocks,
            rate,
            marks: Thinned::default(),
        }
    }

    /// Stores a mark after `returned` rows.
    #[inline]
    fn mark<S: Source>(&mut self, rows: &Rows<S>, returned: usize) {
        if returned.is_multiple_of(MARKED) {
            self.marks.push_with(|| (returned, rows.mark()));
        }
    }
}

impl Sink for Survey {
    fn collect<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()> {
        match self.whole {
            usize::MAX => rows.hold_at_most(usize::MAX),
            _ => rows.hold_default(),
        }
        while self.columns.rows() <= self.whole {
            let Some(row) = rows.next_row()? else {
                return Ok(());
            };
            self.columns.push(&row, row.is_break())?;
            self.mark(rows, self.columns.rows());
        }
        let so_far = || rows.monitor().finish().timing.rate_hz();
        let rate = self.rate.or_else(so_far);
        let width = block_rows(rate.unwrap_or(Recording::ASSUMED_RATE_HZ));
        let zero_offset = rows.facts().zero_offset;
        let mut long = Long::of(std::mem::take(&mut self.columns), width, self.blocks);
        while let Some(row) = rows.next_row()? {
            long.restarted |= row.restarted;
            let (accel, rate) = sample(row.values, zero_offset);
            long.push(accel, rate, row.values[TEMPERATURE], row.is_break());
            self.mark(rows, long.rows);
        }
        let marks = self.marks.items().iter();
        long.marks = marks
            .filter_map(|(row, mark)| Some((*row, mark.clone()?)))
            .collect();
        long.blocks.extend(long.cutter.end());
        self.long = Some(long);
        Ok(())
    }
}

/// Values of accelerometer and gyroscope of a row.
pub(super) fn sample(values: &Values, zero_offset: f64) -> ([f64; 3], [f64; 3]) {
    (
        std::array::from_fn(|i| values[ACCEL + i] - zero_offset),
        std::array::from_fn(|i| values[GYRO + i]),
    )
}

impl Long {
    /// Converts the rows stored so far.
    fn of(columns: Columns, width: usize, blocks: usize) -> Self {
        let gyro = columns.gyro.is_some();
        let mut long = Long {
            width,
            blocks: Blocks::new(blocks),
            rows: 0,
            breaks: Vec::new(),
            gyro,
            restarted: columns.restarted,
            temperature_c: [f64::INFINITY, f64::NEG_INFINITY],
            cutter: Cutter::new(width, gyro),
            marks: Vec::new(),
        };
        let mut breaks = columns.breaks.iter().peekable();
        for row in 0..columns.rows() {
            let accel = columns.accel.each_ref().map(|c| c[row]);
            let rate = columns.gyro.as_ref();
            let rate = rate.map_or([f64::NAN; 3], |g| g.each_ref().map(|c| c[row]));
            let t_c = columns.temperature.as_ref().map_or(f64::NAN, |t| t[row]);
            let is_break = breaks.next_if_eq(&&row).is_some();
            long.push(accel, rate, t_c, is_break);
        }
        long
    }

    #[inline]
    fn push(&mut self, accel: [f64; 3], rate: [f64; 3], t_c: f64, is_break: bool) {
        if is_break {
            self.breaks.push(self.rows);
            self.blocks.extend(self.cutter.end());
        }
        if t_c.is_finite() {
            let [low, high] = &mut self.temperature_c;
            (*low, *high) = (low.min(t_c), high.max(t_c));
        }
        self.blocks.extend(self.cutter.push(accel, rate));
        self.rows += 1;
    }

    /// Lowest and highest temperature, °C; `None` without any.
    pub fn temperature_c(&self) -> Option<[f64; 2]> {
        let [low, high] = self.temperature_c;
        (low <= high).then_some([low, high])
    }
}

/// Blocks of a recording, grouped by segment. Of very many blocks only every second, fourth …
/// group of [`GROUP`] blocks is stored.
pub(super) struct Blocks {
    pub groups: Vec<Vec<Block>>,
    most: usize,
    count: usize,
    stride: usize,
    /// Number of groups so far, and of blocks in the last one.
    group_number: usize,
    in_last: usize,
}

/// Number of neighbouring blocks that are stored or dropped together.
const GROUP: usize = 64;

impl Blocks {
    fn new(most: usize) -> Self {
        Blocks {
            groups: Vec::new(),
            most,
            count: 0,
            stride: 1,
            group_number: 0,
            in_last: 0,
        }
    }

    /// True if blocks were dropped.
    pub fn is_thinned(&self) -> bool {
        self.stride > 1
    }

    /// Adds a block; the flag is true for the first block of a segment.
    fn extend(&mut self, block: Option<(Block, bool)>) {
        let Some((block, is_first)) = block else {
            return;
        };
        let full = self.is_thinned() && self.in_last == GROUP;
        let new = is_first || full || self.groups.is_empty();
        if new {
            self.group_number += 1;
            self.in_last = 0;
        }
        self.in_last += 1;
        if !(self.group_number - 1).is_multiple_of(self.stride) {
            return;
        }
        match self.groups.last_mut() {
            Some(last) if !new => last.push(block),
            _ => self.groups.push(vec![block]),
        }
        self.count += 1;
        if self.count > self.most {
            self.thin();
        }
    }

    #[cold]
    fn thin(&mut self) {
        let groups = std::mem::take(&mut self.groups);
        let group_number = groups.iter().flat_map(|group| group.chunks(GROUP));
        self.groups = group_number.step_by(2).map(<[Block]>::to_vec).collect();
        self.count = self.groups.iter().map(Vec::len).sum();
        self.stride *= 2;
        // The next block begins a group that is stored.
        (self.group_number, self.in_last) = (0, GROUP);
    }
}

/// Divides rows into blocks.
struct Cutter {
    width: usize,
    accel: [Vec<f64>; 3],
    gyro: Option<[Vec<f64>; 3]>,
    /// Number of the first buffered row.
    from: usize,
    is_first: bool,
}

impl Cutter {
    fn new(width: usize, gyro: bool) -> Self {
        let empty = || std::array::from_fn(|_| Vec::with_capacity(2 * width));
        Cutter {
            width,
            accel: empty(),
            gyro: gyro.then(empty),
            from: 0,
            is_first: true,
        }
    }

    /// Adds a row; returns the block that is then complete, and whether it is the first of its
    /// segment.
    #[inline]
    fn push(&mut self, accel: [f64; 3], rate: [f64; 3]) -> Option<(Block, bool)> {
        for (channel, v) in self.accel.iter_mut().zip(accel) {
            channel.push(v);
        }
        for (channel, v) in self.gyro.iter_mut().flatten().zip(rate) {
            channel.push(v);
        }
        // The remainder at the end of a segment joins the last block, so a block is only complete
        // when the next one is.
        (self.accel[0].len() == 2 * self.width).then(|| self.take_block(self.width))
    }

    /// Returns the last block of a segment.
    fn end(&mut self) -> Option<(Block, bool)> {
        let rows = self.accel[0].len();
        let last = (rows >= self.width).then(|| self.take_block(rows));
        if last.is_none() {
            self.clear(rows);
        }
        self.is_first = true;
        last
    }

    fn take_block(&mut self, rows: usize) -> (Block, bool) {
        let all = self.from..self.from + rows;
        let block = Block::of(&self.accel, self.gyro.as_ref(), 0..rows, all);
        let is_first = std::mem::replace(&mut self.is_first, false);
        self.clear(rows);
        (block, is_first)
    }

    fn clear(&mut self, rows: usize) {
        self.from += rows;
        let all = self.accel.iter_mut().chain(self.gyro.iter_mut().flatten());
        all.for_each(|channel| {
            channel.drain(..rows);
        });
    }
}

/// The pass over a very long recording that finds its quiet runs.
pub(super) struct QuietRows {
    pub found: Vec<Quiet>,
    levels: Option<Levels>,
    cutter: Cutter,
    zero_offset: f64,
    /// Blocks of the segment that were not searched yet, and their largest number.
    pending: Vec<Block>,
    at_once: usize,
}

impl QuietRows {
    pub fn new(
        levels: Option<Levels>,
        width: usize,
        gyro: bool,
        facts: &Facts,
        at_once: usize,
    ) -> Self {
        QuietRows {
            found: Vec::new(),
            levels,
            cutter: Cutter::new(width, gyro),
            zero_offset: facts.zero_offset,
            pending: Vec::new(),
            at_once,
        }
    }

    fn extend(&mut self, block: Option<(Block, bool)>) {
        let Some((block, is_first)) = block else {
            return;
        };
        if is_first {
            self.search(self.pending.len(), 0);
        } else if self.pending.len() >= self.at_once {
            // Prefer a split in a motion; that block borders on the runs before and after it.
            let quiet = |b: &Block| self.levels.as_ref().is_some_and(|l| l.is_quiet(b));
            let last = self.pending.iter().rposition(|b| !quiet(b));
            match last.filter(|at| *at > self.at_once / 2) {
                Some(at) => self.search(at + 1, 1),
                None => self.search(self.pending.len(), 0),
            }
        }
        self.pending.push(block);
    }

    /// Searches the first `blocks` of the pending blocks, and removes them except for the last
    /// `keep`.
    fn search(&mut self, blocks: usize, keep: usize) {
        find_quiet(
            self.levels.as_ref(),
            &self.pending[..blocks],
            &mut self.found,
        );
        self.pending.drain(..blocks.saturating_sub(keep));
    }
}

impl Sink for QuietRows {
    fn collect<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()> {
        rows.hold_default();
        while let Some(row) = rows.next_row()? {
            if row.is_break() {
                let last = self.cutter.end();
                self.extend(last);
            }
            let (accel, rate) = sample(row.values, self.zero_offset);
            let block = self.cutter.push(accel, rate);
            self.extend(block);
        }
        let last = self.cutter.end();
        self.extend(last);
        self.search(self.pending.len(), 0);
        Ok(())
    }
}
