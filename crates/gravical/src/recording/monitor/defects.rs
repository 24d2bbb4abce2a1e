//! What is wrong with the samples themselves: frozen axes, clipping, rows that repeat.

use crate::finding::{Finding, FindingKind, LineSpans};
use crate::recording::full_scale::{Clipping, FullScale};
use crate::recording::row::{ACCEL, Values};
use crate::recording::units::{AccelScale, GyroScale};

/// Names of the channels.
const CHANNELS: [&str; 6] = ["ax", "ay", "az", "gx", "gy", "gz"];

/// Rows an axis has to stay exactly the same, while the others move, to be
/// called frozen.
const FROZEN_ROWS: u64 = 100;

/// Rows from which a channel that never changes is told.
const WHOLE_ROWS: u64 = 20;

/// Follows the samples, row by row.
#[derive(Debug, Clone)]
pub(crate) struct Defects {
    zero_offset: f64,
    resolution: [f64; 6],
    /// Nothing of a smaller magnitude is clipped: of the accelerometer, the gyroscope.
    certain: [f64; 2],
    /// Three, or six with a gyroscope.
    channels: usize,
    rows: u64,
    last_line: u64,
    previous: [f64; 6],
    /// A bit for each channel that is there.
    present: u8,
    /// A bit for each channel that kept its value in the last row.
    still: u8,
    runs: [Run; 6],
    frozen: [LineSpans; 6],
    longest: [u64; 6],
    clipped: [Clipping; 6],
    repeated: Repeats,
    ended: bool,
}

/// Rows through which a channel keeps one value.
#[derive(Debug, Clone, Copy, Default)]
struct Run {
    from_row: u64,
    from_line: u64,
    /// What the other two channels of the sensor did since.
    others: [Beside; 2],
}

impl Defects {
    /// `resolution` of the channels as the first rows have it; `gyro`: the scale of the
    /// gyroscope, where there is one.
    pub fn new(
        accel: AccelScale,
        zero_offset: f64,
        resolution: [f64; 6],
        gyro: Option<GyroScale>,
    ) -> Self {
        let with_gyro = gyro.is_some();
        let ends = [
            FullScale::of_accel(&accel),
            gyro.map_or_else(|| FullScale::of_accel(&accel), |g| FullScale::of_gyro(&g)),
        ];
        Defects {
            zero_offset,
            resolution,
            certain: ends.each_ref().map(FullScale::least),
            clipped: std::array::from_fn(|i| Clipping::new(ends[i / 3].clone())),
            channels: if with_gyro { 6 } else { 3 },
            present: if with_gyro { 0b11_1111 } else { 0b111 },
            still: 0,
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

    /// A row and the line it stands in.
    #[inline]
    pub fn see(&mut self, values: &Values, line: u64) {
        let mut now = [0.0; 6];
        now[..self.channels].copy_from_slice(&values[ACCEL..ACCEL + self.channels]);
        let mut still = 0;
        for (i, (now, before)) in now.iter().zip(&self.previous).enumerate() {
            still |= u8::from(now == before) << i;
        }
        still &= self.present;
        // Noise moves every channel in nearly every row.
        if still | self.still != 0 {
            self.see_still(still, &now, line);
        }
        let largest = |values: &[f64], offset: f64| {
            let most = |most: f64, v: &f64| most.max((v - offset).abs());
            values.iter().fold(0.0_f64, most)
        };
        if largest(&now[..3], self.zero_offset) >= self.certain[0]
            || largest(&now[3..], 0.0) >= self.certain[1]
        {
            self.see_large(&now, line);
        }
        self.previous = now;
        self.rows += 1;
        self.last_line = line;
    }

    /// Channels that keep their value in this row, or did up to it.
    #[inline(never)]
    fn see_still(&mut self, still: u8, now: &[f64; 6], line: u64) {
        for i in 0..CHANNELS.len() {
            let (is_still, was_still) = (still >> i & 1 == 1, self.still >> i & 1 == 1);
            if was_still && !is_still {
                self.end_run(i);
            }
            if !is_still {
                continue;
            }
            if !was_still {
                self.runs[i] = Run {
                    from_row: self.rows - 1,
                    from_line: self.last_line,
                    others: Default::default(),
                };
            }
            let sensor = i / 3 * 3;
            for (k, other) in self.runs[i].others.iter_mut().enumerate() {
                let o = sensor + (i - sensor + 1 + k) % 3;
                other.see(self.previous[o], now[o]);
            }
        }
        self.still = still;
        if still == self.present {
            self.repeated.repeat(line);
        } else if self.repeated.is_open() {
            let jumps = |i: usize| is_jump(self.previous[i], now[i], self.resolution[i]);
            self.repeated.end((0..self.channels).any(jumps));
        }
    }

    #[cold]
    fn see_large(&mut self, now: &[f64; 6], line: u64) {
        for (i, clipped) in self.clipped.iter_mut().enumerate() {
            let offset = if i < 3 { self.zero_offset } else { 0.0 };
            let value = now[i] - offset;
            if value.abs() >= self.certain[i / 3] && i < self.channels {
                clipped.see(value, line);
            }
        }
    }

    /// Books the run of a channel up to the last row, when it is a frozen one:
    /// long, while the others move. A channel that never changes at all need not
    /// be as long.
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

    /// The findings, after the last row. Where values are held until the next one comes,
    /// repeats are ours: `held`.
    pub fn finish(mut self, held: bool) -> Vec<Finding> {
        let mut findings = Vec::new();
        self.ended = true;
        for i in 0..CHANNELS.len() {
            if self.still >> i & 1 == 1 {
                self.end_run(i);
            }
        }
        for (i, lines) in self.frozen.iter().enumerate() {
            if !lines.is_empty() {
                findings.push(
                    Finding::new(
                        FindingKind::FrozenAxis,
                        format!(
                            "{} stands still to the last digit for {} rows while the others move",
                            CHANNELS[i], self.longest[i]
                        ),
                    )
                    .at_lines(lines),
                );
            }
        }
        for (channel, clipped) in CHANNELS.iter().zip(&self.clipped) {
            findings.extend(clipped.finding(channel));
        }
        if !held {
            findings.extend(self.repeated.finding(self.rows));
        }
        findings
    }
}

/// What another axis of the sensor does while one keeps its value.
#[derive(Debug, Clone, Copy, Default)]
struct Beside {
    squares: f64,
    /// Lowest and highest value so far, less the first one.
    first: Option<f64>,
    low: f64,
    high: f64,
}

impl Beside {
    /// A value and the one of the row before.
    #[inline]
    pub fn see(&mut self, before: f64, now: f64) {
        let step = now - before;
        // Empty cells say nothing.
        if step.is_nan() {
            return;
        }
        self.squares += step * step;
        let off = now - *self.first.get_or_insert(before);
        self.low = self.low.min(off);
        self.high = self.high.max(off);
    }
}

/// Steps from row to row, in resolutions and rms, that no live axis hides beside
/// another that makes them: two of noise.
const LIVELY: f64 = 2.0 * std::f64::consts::SQRT_2;
/// Resolutions over which both other axes have to go: a turn or a push about one axis
/// leaves another alone, nothing leaves it alone that moves both so far.
const FAR: f64 = 20.0;

/// Whether an axis that keeps one value for `rows` rows is dead: one of the other two
/// scatters by more than its resolution `step` hides, or both move far. An axis that
/// lies still is not: with coarse digits it never changes.
fn is_frozen(others: &[Beside; 2], step: f64, rows: f64) -> bool {
    let lively = others
        .iter()
        .any(|o| o.squares > 0.0 && o.squares >= (LIVELY * step).powi(2) * rows);
    lively || others.iter().all(|o| o.high - o.low > FAR * step)
}

/// Steps of the resolution that a channel has to change by to show that a row before
/// was no new reading.
const JUMP: f64 = 2.5;

/// True where a channel changes by more than its last digit flips.
#[inline]
fn is_jump(before: f64, now: f64, step: f64) -> bool {
    (now - before).abs() > JUMP * step
}

/// Rows that repeat the row before in every channel. They are the same reading twice
/// where the next one is far off, all through the recording. Where the digits are
/// coarse rows repeat by nature: at rest, until the last digit flips or a motion begins.
#[derive(Debug, Clone, Default)]
struct Repeats {
    spans: LineSpans,
    /// First and last line of the rows that repeat now, and their number.
    open: Option<(u64, u64, u64)>,
    /// Runs of them that ended with a jump, and those that did not.
    jumped: u64,
    flipped: u64,
}

/// Rows for every run that ends with a jump, at most: a rest every four seconds at 25 Hz
/// is as rare.
const ROWS_OF_RUN: u64 = 100;

impl Repeats {
    /// A row, in that line, repeats the one before.
    #[inline]
    pub fn repeat(&mut self, line: u64) {
        match &mut self.open {
            Some((_, last, count)) => (*last, *count) = (line, *count + 1),
            None => self.open = Some((line, line, 1)),
        }
    }

    /// The last row repeated the one before it.
    #[inline]
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// A row does not repeat the one before, and may be far off.
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

    /// What is said of them, after the last of `rows`.
    pub fn finding(mut self, rows: u64) -> Option<Finding> {
        // Nothing comes after the last ones: they are as most of the others.
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
