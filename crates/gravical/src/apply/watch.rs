//! What is odd about the samples, found row by row with flat memory: the
//! findings of [`crate::recording::quality`] without its columns.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::recording::quality::{
    Beside, FROZEN_ROWS, Repeats, frozen_axis, is_clipped, is_frozen, is_jump,
};
use crate::recording::row::{ACCEL, Values};
use crate::recording::{AccelScale, AccelUnit, Finding, LineSpans};

/// Smallest full scale of any accelerometer here, g.
const SMALLEST_RANGE_G: f64 = 2.0;

/// Rows from which a channel that never changes is told, as in a batch.
const WHOLE_ROWS: u64 = 20;

const NAMES: [&str; 6] = ["ax", "ay", "az", "gx", "gy", "gz"];

/// Follows the samples.
pub(crate) struct Watch {
    scale: AccelScale,
    zero_offset: f64,
    resolution: [f64; 6],
    /// Nothing of a smaller magnitude is clipped.
    certain: f64,
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
    clipped: [Clipped; 3],
    repeated: Repeats,
    ended: bool,
}

/// Rows through which a channel keeps one value.
#[derive(Clone, Copy, Default)]
struct Run {
    from_row: u64,
    from_line: u64,
    /// What the other two channels of the sensor did since.
    others: [Beside; 2],
}

#[derive(Default)]
struct Clipped {
    lines: LineSpans,
    last: f64,
    repeats: u64,
}

impl Watch {
    /// `resolution` of the channels as the first rows have it.
    pub fn new(scale: AccelScale, zero_offset: f64, resolution: [f64; 6], with_gyro: bool) -> Self {
        let smallest = match (scale.unit, scale.nominal()) {
            (AccelUnit::Counts, _) => 32767.0,
            (_, Some(nominal)) => 0.999 * SMALLEST_RANGE_G * nominal * STANDARD_GRAVITY_MPS2,
            (_, None) => f64::INFINITY,
        };
        Watch {
            scale,
            zero_offset,
            resolution,
            certain: smallest,
            channels: if with_gyro { 6 } else { 3 },
            present: if with_gyro { 0b11_1111 } else { 0b111 },
            still: 0,
            rows: 0,
            last_line: 0,
            previous: [f64::NAN; 6],
            runs: Default::default(),
            frozen: Default::default(),
            longest: [0; 6],
            clipped: Default::default(),
            repeated: Repeats::default(),
            ended: false,
        }
    }

    /// Three, or six with a gyroscope.
    #[inline]
    pub fn channels(&self) -> usize {
        self.channels
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
        let largest = now
            .iter()
            .take(3)
            .fold(0.0_f64, |most, v| most.max((v - self.zero_offset).abs()));
        if largest >= self.certain {
            self.see_large(&now, line);
        }
        self.previous = now;
        self.rows += 1;
        self.last_line = line;
    }

    /// Channels that keep their value in this row, or did up to it.
    #[inline(never)]
    fn see_still(&mut self, still: u8, now: &[f64; 6], line: u64) {
        for i in 0..NAMES.len() {
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
        for (clipped, value) in self.clipped.iter_mut().zip(now) {
            let value = value - self.zero_offset;
            if is_clipped(value, &self.scale) {
                clipped.repeats += u64::from(clipped.last == value);
                clipped.last = value;
                clipped.lines.push(line);
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
        if (length >= FROZEN_ROWS as u64 || whole) && frozen() {
            self.longest[i] = self.longest[i].max(length);
            self.frozen[i].push_range(run.from_line, self.last_line, length);
        }
    }

    /// The findings, after the last row.
    pub fn finish(mut self, findings: &mut Vec<Finding>) {
        self.ended = true;
        for i in 0..NAMES.len() {
            if self.still >> i & 1 == 1 {
                self.end_run(i);
            }
        }
        for (i, lines) in self.frozen.iter().enumerate() {
            if !lines.is_empty() {
                findings.push(frozen_axis(NAMES[i], self.longest[i], lines));
            }
        }
        for (axis, clipped) in self.clipped.iter().enumerate() {
            // In physical units a single value at a full scale is chance.
            let repeats = self.scale.unit == AccelUnit::Counts || clipped.repeats >= 3;
            if repeats && !clipped.lines.is_empty() {
                findings.push(
                    Finding::warning(
                        "clipped",
                        format!(
                            "{} reaches the end of its range in {} rows: the true value is larger; record at a wider range",
                            NAMES[axis],
                            clipped.lines.count()
                        ),
                    )
                    .at_lines(&clipped.lines),
                );
            }
        }
        findings.extend(self.repeated.finding(self.rows));
    }
}
