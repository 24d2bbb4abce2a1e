//! Rows of a recording at rest, added to the sums of each channel.

use std::ops::Range;

use super::NoiseOptions;
use super::allan::Allan;
use super::density::Density;
use crate::recording::Recording;
use crate::stats::moments;

/// Up to this many consecutive samples that are missing are replaced by earlier ones.
const MOST_FILLED: usize = 8;
/// Samples before a missing one are replaced from so far back.
const BACK: usize = 64;
/// Length of the means that are compared with the temperature, s.
pub(super) const MEAN_S: f64 = 1.0;

/// Sums of one channel.
#[derive(Debug, Clone)]
pub(super) struct Channel {
    pub allan: Allan,
    pub density: Density,
    pub trend: Trend,
    pub scatter: Scatter,
    /// Number of samples that were replaced, and of gaps where too many are missing.
    pub filled: u64,
    pub gaps: u64,
    /// The latest samples of the segment, in a ring.
    recent: Vec<f64>,
    at: usize,
    /// Number of missing samples before the next one.
    missing: usize,
    ready: Vec<f64>,
}

impl Channel {
    pub fn new(period_s: f64, options: &NoiseOptions) -> Self {
        Channel {
            allan: Allan::new(options.spacing, options.full),
            density: Density::new(period_s),
            trend: Trend::default(),
            scatter: Scatter::new(period_s),
            filled: 0,
            gaps: 0,
            recent: Vec::with_capacity(BACK),
            at: 0,
            missing: 0,
            ready: Vec::new(),
        }
    }

    /// Adds samples; NaN for missing ones.
    pub fn push(&mut self, values: &[f64]) {
        for value in values {
            if !value.is_finite() {
                self.missing += 1;
                continue;
            }
            if self.missing > 0 {
                self.fill();
            }
            self.take(*value);
        }
        self.hand_on();
    }

    fn take(&mut self, value: f64) {
        self.ready.push(value);
        if self.recent.len() < BACK {
            self.recent.push(value);
        } else {
            self.recent[self.at] = value;
            self.at = (self.at + 1) % BACK;
        }
    }

    fn hand_on(&mut self) {
        self.allan.push(&self.ready);
        self.density.push(&self.ready);
        self.ready
            .iter()
            .for_each(|value| self.scatter.push(*value));
        self.ready.clear();
    }

    /// Replaces missing samples by earlier ones: they have the noise of the sensor, which an
    /// interpolation does not have. After too many a new segment begins.
    fn fill(&mut self) {
        if self.missing > MOST_FILLED || self.recent.is_empty() {
            if !self.recent.is_empty() {
                self.gaps += 1;
                self.hand_on();
                self.split();
            }
            self.missing = 0;
            return;
        }
        for _ in 0..std::mem::take(&mut self.missing) {
            let value = self.recent[self.at % self.recent.len()];
            self.take(value);
            self.filled += 1;
        }
    }

    /// The next sample does not continue the last one.
    pub fn split(&mut self) {
        self.allan.split();
        self.density.split();
        self.scatter.split();
        self.recent.clear();
        self.at = 0;
        self.missing = 0;
    }
}

/// Scatter of the samples about their means over a second.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scatter {
    /// Samples of a second.
    length: f64,
    count: f64,
    mean: f64,
    squares: f64,
    /// Sum of squares and degrees of freedom of the seconds so far.
    total: [f64; 2],
}

impl Scatter {
    fn new(period_s: f64) -> Self {
        Scatter {
            length: (1.0 / period_s).max(2.0),
            count: 0.0,
            mean: 0.0,
            squares: 0.0,
            total: [0.0; 2],
        }
    }

    fn push(&mut self, value: f64) {
        self.count += 1.0;
        let off = value - self.mean;
        self.mean += off / self.count;
        self.squares += off * (value - self.mean);
        if self.count >= self.length {
            self.split();
        }
    }

    /// The next sample does not continue the last one.
    fn split(&mut self) {
        if self.count > 1.0 {
            self.total[0] += self.squares;
            self.total[1] += self.count - 1.0;
        }
        (self.count, self.mean, self.squares) = (0.0, 0.0, 0.0);
    }

    /// Variance; NaN without two samples that follow each other.
    pub fn variance(mut self) -> f64 {
        self.split();
        self.total[0] / self.total[1]
    }
}

/// Regression of means over about a second on the temperature, in constant memory.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Trend {
    pub count: f64,
    mean_c: f64,
    mean: f64,
    pub squares_c: f64,
    pub squares: f64,
    products: f64,
}

impl Trend {
    fn push(&mut self, t_c: f64, value: f64) {
        self.count += 1.0;
        let off_c = t_c - self.mean_c;
        let off = value - self.mean;
        self.mean_c += off_c / self.count;
        self.mean += off / self.count;
        self.squares_c += off_c * (t_c - self.mean_c);
        self.squares += off * (value - self.mean);
        self.products += off_c * (value - self.mean);
    }

    /// Change for each °C.
    pub fn slope(&self) -> f64 {
        self.products / self.squares_c
    }
}

/// What is read with the samples.
#[derive(Debug, Clone, Default)]
pub(super) struct Counts {
    pub rows: u64,
    /// Rows in blocks that are not quiet, and number of such blocks.
    pub disturbed: u64,
    pub bumps: u64,
    /// Gaps and breaks within the intervals.
    pub gaps: u64,
    /// Time between the samples that follow each other, s, and their number of periods.
    time_s: f64,
    periods: f64,
    pub temperature_c: Option<[f64; 2]>,
}

/// The fold.
#[derive(Debug, Clone)]
pub(super) struct Fold {
    /// Rows that are used, in order.
    ranges: Vec<Range<usize>>,
    period_s: f64,
    /// A block with a larger variance, sum of the axes, is not quiet.
    most_variance: f64,
    width: usize,
    last_t_s: f64,
    /// Stamps that repeat, and are made up for by the next gap.
    repeated: usize,
    block: [Vec<f64>; 6],
    /// Rows of the block; it also has the samples that are missing between them.
    block_rows: u64,
    temperature: (f64, f64),
    /// Sums of the means towards the next point of the trend: temperature, channels, weight.
    towards: (f64, [f64; 6], f64),
    pub channels: Vec<Channel>,
    pub counts: Counts,
}

/// Where and how the fold works.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// Rows that are used, in order.
    pub ranges: Vec<Range<usize>>,
    pub period_s: f64,
    pub channels: usize,
    pub most_variance: f64,
    pub width: usize,
}

impl Fold {
    pub fn new(plan: Plan, options: &NoiseOptions) -> Self {
        let channel = Channel::new(plan.period_s, options);
        Fold {
            ranges: plan.ranges,
            period_s: plan.period_s,
            most_variance: plan.most_variance,
            width: plan.width,
            last_t_s: f64::NAN,
            repeated: 0,
            block: Default::default(),
            block_rows: 0,
            temperature: (0.0, 0.0),
            towards: (0.0, [0.0; 6], 0.0),
            channels: vec![channel; plan.channels],
            counts: Counts::default(),
        }
    }

    /// Rows that are used.
    pub fn ranges(&self) -> &[Range<usize>] {
        &self.ranges
    }

    /// Sampling period, s: the mean over the samples that were used.
    pub fn period_s(&self) -> f64 {
        match self.counts.periods > 0.0 {
            true => self.counts.time_s / self.counts.periods,
            false => self.period_s,
        }
    }

    /// Takes the rows that are used.
    pub fn take_recording(&mut self, recording: &Recording) {
        for range in self.ranges.clone() {
            for row in range.clone() {
                let is_break = recording.breaks.binary_search(&row).is_ok();
                let t_s = recording.time_s.as_ref().map_or(f64::NAN, |t| t[row]);
                if row > range.start && is_break {
                    self.counts.gaps += 1;
                    self.split();
                } else if row > range.start {
                    self.step(t_s - self.last_t_s);
                }
                self.last_t_s = t_s;
                self.push(recording, row);
            }
            self.split();
        }
    }

    fn push(&mut self, recording: &Recording, row: usize) {
        self.counts.rows += 1;
        self.block_rows += 1;
        let columns = recording
            .accel
            .iter()
            .chain(recording.gyro.iter().flatten());
        for (channel, column) in self.block.iter_mut().zip(columns) {
            channel.push(column[row]);
        }
        let t_c = recording
            .temperature_c
            .as_ref()
            .map_or(f64::NAN, |t| t[row]);
        if t_c.is_finite() {
            self.temperature.0 += t_c;
            self.temperature.1 += 1.0;
            let [low, high] = self.counts.temperature_c.unwrap_or([t_c; 2]);
            self.counts.temperature_c = Some([low.min(t_c), high.max(t_c)]);
        }
        if self.block[0].len() >= self.width {
            self.end_block();
        }
    }

    /// Time from the last row to this one: missing samples are marked, a gap ends the segment.
    fn step(&mut self, step_s: f64) {
        if !step_s.is_finite() {
            return;
        }
        let periods = (step_s / self.period_s).round();
        if periods < 0.0 || periods > (MOST_FILLED + 1) as f64 {
            self.counts.gaps += 1;
            self.split();
            return;
        }
        let periods = periods as usize;
        if periods == 0 {
            self.repeated = (self.repeated + 1).min(MOST_FILLED);
        }
        let missing = periods.saturating_sub(1);
        let made_up = missing.min(self.repeated);
        self.repeated -= made_up;
        for _ in 0..missing - made_up {
            self.block
                .iter_mut()
                .for_each(|channel| channel.push(f64::NAN));
        }
        self.counts.time_s += step_s;
        self.counts.periods += (1 + missing - made_up) as f64;
    }

    fn split(&mut self) {
        self.end_block();
        self.channels.iter_mut().for_each(Channel::split);
        self.last_t_s = f64::NAN;
        self.repeated = 0;
    }

    fn end_block(&mut self) {
        let rows = self.block[0].len();
        if rows == 0 {
            return;
        }
        let accel: &[Vec<f64>; 3] = match self.block.first_chunk() {
            Some(accel) => accel,
            None => return,
        };
        let (_, variance) = moments(accel, 0..rows);
        if variance > self.most_variance {
            self.counts.disturbed += self.block_rows;
            self.counts.bumps += 1;
            self.channels.iter_mut().for_each(Channel::split);
        } else {
            for (channel, values) in self.channels.iter_mut().zip(&self.block) {
                channel.push(values);
            }
            self.compare_with_temperature();
        }
        self.temperature = (0.0, 0.0);
        self.block_rows = 0;
        self.block.iter_mut().for_each(Vec::clear);
    }

    fn compare_with_temperature(&mut self) {
        let (sum_c, count) = self.temperature;
        if count == 0.0 {
            return;
        }
        let (towards_c, towards, weight) = &mut self.towards;
        *towards_c += sum_c;
        for (sum, values) in towards.iter_mut().zip(&self.block) {
            let finite = values.iter().filter(|v| v.is_finite());
            let (n, total) = finite.fold((0.0, 0.0), |(n, total), v| (n + 1.0, total + v));
            *sum += if n > 0.0 { count * total / n } else { f64::NAN };
        }
        *weight += count;
        if *weight * self.period_s >= MEAN_S {
            for (channel, sum) in self.channels.iter_mut().zip(&*towards) {
                if sum.is_finite() {
                    channel.trend.push(*towards_c / *weight, sum / *weight);
                }
            }
            self.towards = (0.0, [0.0; 6], 0.0);
        }
    }
}
