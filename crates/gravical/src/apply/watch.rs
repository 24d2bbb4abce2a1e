//! What is odd about the samples, found row by row with flat memory: the
//! findings of [`crate::recording::quality`] without its columns.

use crate::recording::quality::{
    Beside, CHANNELS, Clipping, FROZEN_ROWS, FullScale, Repeats, frozen_axis, is_frozen, is_jump,
};
use crate::recording::row::{ACCEL, Values};
use crate::recording::{AccelScale, Finding, GyroScale, LineSpans};

/// Rows from which a channel that never changes is told, as in a batch.
const WHOLE_ROWS: u64 = 20;

/// Follows the samples.
pub(crate) struct Watch {
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
#[derive(Clone, Copy, Default)]
struct Run {
    from_row: u64,
    from_line: u64,
    /// What the other two channels of the sensor did since.
    others: [Beside; 2],
}

impl Watch {
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
        Watch {
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
        if (length >= FROZEN_ROWS as u64 || whole) && frozen() {
            self.longest[i] = self.longest[i].max(length);
            self.frozen[i].push_range(run.from_line, self.last_line, length);
        }
    }

    /// The findings, after the last row.
    pub fn finish(mut self, findings: &mut Vec<Finding>) {
        self.ended = true;
        for i in 0..CHANNELS.len() {
            if self.still >> i & 1 == 1 {
                self.end_run(i);
            }
        }
        for (i, lines) in self.frozen.iter().enumerate() {
            if !lines.is_empty() {
                findings.push(frozen_axis(CHANNELS[i], self.longest[i], lines));
            }
        }
        for (channel, clipped) in CHANNELS.iter().zip(&self.clipped) {
            findings.extend(clipped.finding(channel));
        }
        findings.extend(self.repeated.finding(self.rows));
    }
}
