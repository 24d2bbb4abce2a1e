//! Faults of the samples: frozen axes, clipping, repeated rows.

use std::ops::Range;

use gravical_recording::judge::{OtherAxis, is_frozen};

use crate::finding::{Finding, FindingKind, LineSpans};
use crate::recording::cells::Channels;
use crate::recording::full_scale::{Clipping, FullScale};
use crate::recording::row::{ACCEL, Values};
use crate::recording::units::{AccelScale, GyroScale};

const CHANNELS: [&str; 6] = ["ax", "ay", "az", "gx", "gy", "gz"];

/// Number of rows in which an axis must keep exactly one value, while the others change, to count
/// as frozen.
const FROZEN_ROWS: u64 = 100;

/// The same for a channel that never changes in the whole recording.
const WHOLE_ROWS: u64 = 20;

/// Checks the samples, row by row.
#[derive(Debug, Clone)]
pub(crate) struct Defects {
    zero_offset: f64,
    resolution: [f64; 6],
    /// Smallest magnitude that may be clipped: of the accelerometer, of the gyroscope.
    least_clipped: [f64; 2],
    /// Slots of the channels in a row.
    slots: Range<usize>,
    rows: u64,
    last_line: u64,
    previous: [f64; 6],
    /// One bit for each channel of the recording.
    present: u8,
    /// One bit for each channel whose value did not change in the last row.
    unchanged: u8,
    runs: [Run; 6],
    frozen: [LineSpans; 6],
    longest: [u64; 6],
    clipped: [Clipping; 6],
    repeated: Repeats,
    ended: bool,
}

/// Rows in which a channel keeps one value.
#[derive(Debug, Clone, Copy, Default)]
struct Run {
    from_row: u64,
    from_line: u64,
    /// Changes of the other two channels of the sensor meanwhile.
    others: [OtherAxis; 2],
}

impl Defects {
    /// `resolution`: of the channels, from the first rows.
    pub fn new(
        channels: Channels,
        accel: AccelScale,
        zero_offset: f64,
        resolution: [f64; 6],
        gyro: Option<GyroScale>,
    ) -> Self {
        let gyro = gyro.filter(|_| channels.gyro);
        let ends = [
            FullScale::of_accel(&accel),
            gyro.map_or_else(|| FullScale::of_accel(&accel), |g| FullScale::of_gyro(&g)),
        ];
        Defects {
            zero_offset,
            resolution,
            least_clipped: ends.each_ref().map(FullScale::least),
            clipped: std::array::from_fn(|i| Clipping::new(ends[i / 3].clone())),
            slots: channels.slots(),
            present: match channels.gyro {
                true => 0b11_1111,
                false => 0b111,
            },
            unchanged: 0,
            rows: 0,
            last_line: 0,
            previous: [f64::NAN; 6],
            runs: Default::default(),
            frozen: Default::default(),
            longest: [0; 6],
            repeated: Repeats::default(),
            ended: false,
        }
    }

    /// Processes a row; `line` is its line number.
    #[inline]
    pub fn observe(&mut self, values: &Values, line: u64) {
        let mut now = [0.0; 6];
        let channels = self.slots.start - ACCEL..self.slots.end - ACCEL;
        now[channels].copy_from_slice(&values[self.slots.clone()]);
        let mut unchanged = 0;
        for (i, (now, before)) in now.iter().zip(&self.previous).enumerate() {
            unchanged |= u8::from(now == before) << i;
        }
        unchanged &= self.present;
        // Skips the common case: noise changes every channel in nearly every row.
        if unchanged | self.unchanged != 0 {
            self.update_runs(unchanged, &now, line);
        }
        let largest = |values: &[f64], offset: f64| {
            let most = |most: f64, v: &f64| most.max((v - offset).abs());
            values.iter().fold(0.0_f64, most)
        };
        if largest(&now[..3], self.zero_offset) >= self.least_clipped[0]
            || largest(&now[3..], 0.0) >= self.least_clipped[1]
        {
            self.check_range(&now, line);
        }
        self.previous = now;
        self.rows += 1;
        self.last_line = line;
    }

    /// Updates the runs of channels whose value did not change in this row or in the last one.
    #[inline(never)]
    fn update_runs(&mut self, unchanged: u8, now: &[f64; 6], line: u64) {
        for i in 0..CHANNELS.len() {
            let (is_unchanged, was_unchanged) =
                (unchanged >> i & 1 == 1, self.unchanged >> i & 1 == 1);
            if was_unchanged && !is_unchanged {
                self.end_run(i);
            }
            if !is_unchanged {
                continue;
            }
            if !was_unchanged {
                self.runs[i] = Run {
                    from_row: self.rows - 1,
                    from_line: self.last_line,
                    others: Default::default(),
                };
            }
            let sensor = i / 3 * 3;
            for (k, other) in self.runs[i].others.iter_mut().enumerate() {
                let o = sensor + (i - sensor + 1 + k) % 3;
                other.observe(self.previous[o], now[o]);
            }
        }
        self.unchanged = unchanged;
        if unchanged == self.present {
            self.repeated.repeat(line);
        } else if self.repeated.is_open() {
            let jumps = |i: usize| is_jump(self.previous[i], now[i], self.resolution[i]);
            self.repeated.end((0..CHANNELS.len()).any(jumps));
        }
    }

    #[cold]
    fn check_range(&mut self, now: &[f64; 6], line: u64) {
        for (i, clipped) in self.clipped.iter_mut().enumerate() {
            let offset = if i < 3 { self.zero_offset } else { 0.0 };
            let value = now[i] - offset;
            if value.abs() >= self.least_clipped[i / 3] && self.present >> i & 1 == 1 {
                clipped.observe(value, line);
            }
        }
    }

    /// Ends the run of a channel at the last row, and records it if the channel is frozen: the
    /// run is long and the others change. A channel that never changes may have a shorter run.
    fn end_run(&mut self, i: usize) {
        let run = self.runs[i];
        let length = self.rows - run.from_row;
        let whole = run.from_row == 0 && length >= WHOLE_ROWS && self.ended;
        let frozen = || is_frozen(&run.others, self.resolution[i], length as f64);
        if (length >= FROZEN_ROWS || whole) && frozen() {
            self.longest[i] = self.longest[i].max(length);
            self.frozen[i].push_range(run.from_line, self.last_line, length);
        }
    }

    /// The findings, after the last row. `held`: repeated rows come from values that the reader
    /// held, and are not reported.
    pub fn finish(mut self, held: bool) -> Vec<Finding> {
        let mut findings = Vec::new();
        self.ended = true;
        for i in 0..CHANNELS.len() {
            if self.unchanged >> i & 1 == 1 {
                self.end_run(i);
            }
        }
        for (i, lines) in self.frozen.iter().enumerate() {
            if !lines.is_empty() {
                findings.push(
                    Finding::new(
                        FindingKind::FrozenAxis,
                        format!(
                            "{} keeps exactly one value for {} rows while the other axes change",
                            CHANNELS[i], self.longest[i]
                        ),
                    )
                    .at_lines(lines),
                );
            }
        }
        for (channel, clipped) in CHANNELS.iter().zip(&self.clipped) {
            findings.extend(clipped.finding(channel).map(Finding::from));
        }
        if !held {
            findings.extend(self.repeated.finding(self.rows));
        }
        findings
    }
}

/// Number of resolution steps by which a channel must change to show that the row before was not
/// a new reading.
const JUMP: f64 = 2.5;

/// True if a channel changes by more than a flip of its last digit.
#[inline]
fn is_jump(before: f64, now: f64, step: f64) -> bool {
    (now - before).abs() > JUMP * step
}

/// Rows that repeat the row before in every channel. If the value after such rows regularly
/// differs by much, the sensor was read twice per measurement. With a coarse resolution rows also
/// repeat at rest, until the last digit flips or a motion begins.
#[derive(Debug, Clone, Default)]
struct Repeats {
    spans: LineSpans,
    /// First and last line of the current run of repeated rows, and their number.
    open: Option<(u64, u64, u64)>,
    /// Number of runs that ended with a jump, and without one.
    jumped: u64,
    flipped: u64,
}

/// Largest number of rows per run that ends with a jump; a rest every four seconds at 25 Hz is as
/// rare.
const ROWS_OF_RUN: u64 = 100;

impl Repeats {
    /// A row, in this line, repeats the row before.
    #[inline]
    pub fn repeat(&mut self, line: u64) {
        match &mut self.open {
            Some((_, last, count)) => (*last, *count) = (line, *count + 1),
            None => self.open = Some((line, line, 1)),
        }
    }

    /// True if the last row repeated the row before it.
    #[inline]
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// A row differs from the row before; `jumps`: by more than the last digit.
    pub fn end(&mut self, jumps: bool) {
        let Some((first, last, count)) = self.open.take() else {
            return;
        };
        if jumps {
            self.spans.push_range(first, last, count);
            self.jumped += 1;
        } else {
            self.flipped += 1;
        }
    }

    /// The finding, after the last of `rows`.
    pub fn finding(mut self, rows: u64) -> Option<Finding> {
        // The last run has no end: it is assumed to be like most of the others.
        self.end(self.jumped > self.flipped);
        let count = self.spans.count();
        let often = self.jumped > self.flipped && self.jumped * ROWS_OF_RUN > rows;
        (often && count >= 10).then(|| {
            Finding::new(
                FindingKind::RepeatedRows,
                format!(
                    "{count} rows ({:.0} %) repeat the row before in every channel: the sensor was read faster than it measures",
                    100.0 * count as f64 / rows.max(1) as f64
                ),
            )
            .at_lines(&self.spans)
        })
    }
}
