//! Readings of a long recording that keep blocks of it.

use super::plan::{Quiet, find_quiet};
use crate::Result;
use crate::recording::Recording;
use crate::recording::collect::{Columns, Sink};
use crate::recording::monitor::Facts;
use crate::recording::row::{ACCEL, GYRO, TEMPERATURE, Values};
use crate::recording::rows::{Mark, Rows, Source};
use crate::recording::timing::Treatment;
use crate::stats::Thinned;
use crate::still::{Block, Levels, StillOptions, block_rows};

/// The first reading: all rows of a short recording, blocks of a long one.
pub(super) struct Survey {
    pub columns: Columns,
    pub long: Option<Long>,
    whole: usize,
    blocks: usize,
    still: StillOptions,
    rate: Option<f64>,
    marks: Thinned<(usize, Option<Mark>), MOST_MARKS>,
}

/// Where the last reading may go on: after every so many rows.
const MARKED: usize = 512;
const MOST_MARKS: usize = 1 << 12;

/// What is known of a long recording.
pub(super) struct Long {
    /// Rows of a block.
    pub width: usize,
    pub blocks: Blocks,
    /// Number of rows.
    pub rows: usize,
    /// Rows that do not follow the one before.
    pub breaks: Vec<usize>,
    /// It has a gyroscope.
    pub gyro: bool,
    /// The clock started anew somewhere.
    pub restarted: bool,
    /// Lowest and highest temperature, °C.
    temperature_c: [f64; 2],
    cutter: Cutter,
    /// What reading may go on by, and the row that comes next.
    pub marks: Vec<(usize, Mark)>,
}

impl Survey {
    /// Up to `whole` rows are kept, then up to `blocks` blocks, as `still` has them at the
    /// `rate`, Hz, where that is known.
    pub fn new(
        columns: Columns,
        whole: usize,
        blocks: usize,
        still: &StillOptions,
        rate: Option<f64>,
    ) -> Self {
        Survey {
            // Labels are claims about rows.
            whole: if columns.has_labels() {
                usize::MAX
            } else {
                whole
            },
            columns,
            long: None,
            blocks,
            still: still.clone(),
            rate,
            marks: Thinned::default(),
        }
    }

    /// `rows` have given so many.
    #[inline]
    fn mark<S: Source>(&mut self, rows: &Rows<S>, given: usize) {
        if given.is_multiple_of(MARKED) {
            self.marks.push_with(|| (given, rows.mark()));
        }
    }
}

impl Sink for Survey {
    fn collect<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()> {
        match self.whole {
            usize::MAX => rows.hold_at_most(usize::MAX),
            _ => rows.hold_few(),
        }
        while self.columns.rows() <= self.whole {
            let Some(row) = rows.next_row()? else {
                return Ok(());
            };
            self.columns.push(&row, row.parts())?;
            self.mark(rows, self.columns.rows());
        }
        let so_far = || rows.monitor().finish(Treatment::Repaired).timing.rate_hz();
        let rate = self.rate.or_else(so_far);
        let width = block_rows(rate.unwrap_or(Recording::ASSUMED_RATE_HZ), &self.still);
        let zero_offset = rows.facts().zero_offset;
        let mut long = Long::of(std::mem::take(&mut self.columns), width, self.blocks);
        while let Some(row) = rows.next_row()? {
            long.restarted |= row.restarted;
            let (accel, rate) = sample(row.values, zero_offset);
            long.push(accel, rate, row.values[TEMPERATURE], row.parts());
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

/// What a row reads: the accelerometer and the gyroscope.
pub(super) fn sample(values: &Values, zero_offset: f64) -> ([f64; 3], [f64; 3]) {
    (
        std::array::from_fn(|i| values[ACCEL + i] - zero_offset),
        std::array::from_fn(|i| values[GYRO + i]),
    )
}

impl Long {
    /// What a recording begins with.
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
            let parts = breaks.next_if_eq(&&row).is_some();
            long.push(accel, rate, t_c, parts);
        }
        long
    }

    #[inline]
    fn push(&mut self, accel: [f64; 3], rate: [f64; 3], t_c: f64, parts: bool) {
        if parts {
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

    /// Lowest and highest temperature, °C; none without any.
    pub fn temperature_c(&self) -> Option<[f64; 2]> {
        let [low, high] = self.temperature_c;
        (low <= high).then_some([low, high])
    }
}

/// Blocks of a recording, those of each segment together; of very many every second,
/// fourth … stretch of them.
pub(super) struct Blocks {
    pub groups: Vec<Vec<Block>>,
    most: usize,
    count: usize,
    stride: usize,
    /// Stretches so far, and blocks of the last one.
    stretches: usize,
    in_last: usize,
}

/// Neighbouring blocks that are kept or dropped together.
const STRETCH: usize = 64;

impl Blocks {
    fn new(most: usize) -> Self {
        Blocks {
            groups: Vec::new(),
            most,
            count: 0,
            stride: 1,
            stretches: 0,
            in_last: 0,
        }
    }

    /// Not all of them are here.
    pub fn is_thinned(&self) -> bool {
        self.stride > 1
    }

    /// The next block, and whether a segment begins with it.
    fn extend(&mut self, block: Option<(Block, bool)>) {
        let Some((block, begins)) = block else { return };
        let full = self.is_thinned() && self.in_last == STRETCH;
        let new = begins || full || self.groups.is_empty();
        if new {
            self.stretches += 1;
            self.in_last = 0;
        }
        self.in_last += 1;
        if !(self.stretches - 1).is_multiple_of(self.stride) {
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
        let stretches = groups.iter().flat_map(|group| group.chunks(STRETCH));
        self.groups = stretches.step_by(2).map(<[Block]>::to_vec).collect();
        self.count = self.groups.iter().map(Vec::len).sum();
        self.stride *= 2;
        // The next block begins a stretch that is kept.
        (self.stretches, self.in_last) = (0, STRETCH);
    }
}

/// Cuts rows into blocks as they come.
struct Cutter {
    width: usize,
    accel: [Vec<f64>; 3],
    gyro: Option<[Vec<f64>; 3]>,
    /// Row of the first of them.
    from: usize,
    begins: bool,
}

impl Cutter {
    fn new(width: usize, gyro: bool) -> Self {
        let empty = || std::array::from_fn(|_| Vec::with_capacity(2 * width));
        Cutter {
            width,
            accel: empty(),
            gyro: gyro.then(empty),
            from: 0,
            begins: true,
        }
    }

    /// The next row; the block that it shows to be complete, and whether a segment begins
    /// with that.
    #[inline]
    fn push(&mut self, accel: [f64; 3], rate: [f64; 3]) -> Option<(Block, bool)> {
        for (channel, v) in self.accel.iter_mut().zip(accel) {
            channel.push(v);
        }
        for (channel, v) in self.gyro.iter_mut().flatten().zip(rate) {
            channel.push(v);
        }
        // What is left at the end of a segment joins the last block.
        (self.accel[0].len() == 2 * self.width).then(|| self.give(self.width))
    }

    /// The last block of a segment.
    fn end(&mut self) -> Option<(Block, bool)> {
        let rows = self.accel[0].len();
        let last = (rows >= self.width).then(|| self.give(rows));
        if last.is_none() {
            self.clear(rows);
        }
        self.begins = true;
        last
    }

    fn give(&mut self, rows: usize) -> (Block, bool) {
        let all = self.from..self.from + rows;
        let block = Block::of(&self.accel, self.gyro.as_ref(), 0..rows, all);
        let begins = std::mem::replace(&mut self.begins, false);
        self.clear(rows);
        (block, begins)
    }

    fn clear(&mut self, rows: usize) {
        self.from += rows;
        let all = self.accel.iter_mut().chain(self.gyro.iter_mut().flatten());
        all.for_each(|channel| {
            channel.drain(..rows);
        });
    }
}

/// The reading of a very long recording that finds its quiet runs.
pub(super) struct QuietRows {
    /// By each of the levels.
    pub found: [Vec<Quiet>; 2],
    levels: [Option<Levels>; 2],
    cutter: Cutter,
    zero_offset: f64,
    /// Blocks of the segment that were not looked at yet, and how many there may be.
    pending: Vec<Block>,
    at_once: usize,
}

impl QuietRows {
    pub fn new(
        levels: [Option<Levels>; 2],
        width: usize,
        gyro: bool,
        facts: &Facts,
        at_once: usize,
    ) -> Self {
        QuietRows {
            found: Default::default(),
            levels,
            cutter: Cutter::new(width, gyro),
            zero_offset: facts.zero_offset,
            pending: Vec::new(),
            at_once,
        }
    }

    fn extend(&mut self, block: Option<(Block, bool)>) {
        let Some((block, begins)) = block else { return };
        if begins {
            self.look_at(self.pending.len(), 0);
        } else if self.pending.len() >= self.at_once {
            // Best where it moves: that block borders on what is before and after it.
            let quiet = |b: &Block| self.levels.iter().flatten().any(|l| l.is_quiet(b));
            let last = self.pending.iter().rposition(|b| !quiet(b));
            match last.filter(|at| *at > self.at_once / 2) {
                Some(at) => self.look_at(at + 1, 1),
                None => self.look_at(self.pending.len(), 0),
            }
        }
        self.pending.push(block);
    }

    /// Looks at the first `blocks` of those pending, and forgets them but for the last
    /// `keep`.
    fn look_at(&mut self, blocks: usize, keep: usize) {
        find_quiet(&self.levels, &self.pending[..blocks], &mut self.found);
        self.pending.drain(..blocks.saturating_sub(keep));
    }
}

impl Sink for QuietRows {
    fn collect<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()> {
        rows.hold_few();
        while let Some(row) = rows.next_row()? {
            if row.parts() {
                let last = self.cutter.end();
                self.extend(last);
            }
            let (accel, rate) = sample(row.values, self.zero_offset);
            let block = self.cutter.push(accel, rate);
            self.extend(block);
        }
        let last = self.cutter.end();
        self.extend(last);
        self.look_at(self.pending.len(), 0);
        Ok(())
    }
}
