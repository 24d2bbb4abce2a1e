//! Butterworth filters over samples that may be uneven: interpolation to an even grid and back.
//!
//! If every step is a whole multiple of the usual one, the lost samples are added by linear
//! interpolation. Otherwise the samples are interpolated linearly to an even grid and the result
//! back to the time stamps. This alone smooths: white noise to 0.61 of its standard deviation if
//! the grid is midway between the samples. Samples with equal time stamps are averaged.

use super::butterworth::{Butterworth, Passing};
use super::filter::Treatment;
use super::samples::{Samples, keep};

/// Steps that are whole multiples of the usual one within this share are due to lost samples;
/// others are uneven sampling.
const WHOLE_SHARE: f64 = 0.25;

/// Time stamps that differ by less than this share of the usual step are equal.
const SAME_SHARE: f64 = 0.01;

/// True if a step fits on the grid of the usual one.
pub(super) fn is_on_grid(step_s: f64, usual_s: f64) -> bool {
    let steps = step_s / usual_s;
    let off = (steps - steps.round()).abs();
    // Two samples with one index must have equal time stamps.
    off <= WHOLE_SHARE && (steps <= SAME_SHARE || steps.round() >= 1.0)
}

/// The samples of a stretch on their way through the filter.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    step_s: f64,
    /// All samples are interpolated; otherwise only the lost ones.
    resampled: bool,
    /// Number of samples, and the time of the first and the last one.
    count: usize,
    start_s: f64,
    last_s: f64,
    /// The last sample on the grid of the others.
    place: usize,
    /// Samples with the newest time stamp, and the mean of those with the one before.
    newest: Option<Group>,
    before: Option<Group>,
    /// Number of different time stamps.
    distinct: usize,
    /// Number of points of the grid.
    points: usize,
    /// The filter has enough samples.
    begun: bool,
    /// Samples that were not returned; their values only until the filter has begun.
    held: Samples,
    /// Where they are on the grid.
    at: Vec<f64>,
    channels: Vec<Passing>,
    /// Filtered points, and the number of the first one.
    filtered: Vec<Vec<f64>>,
    from: usize,
}

/// Samples with one time stamp.
#[derive(Debug, Clone)]
struct Group {
    /// The time, or the index on the grid.
    at: f64,
    count: usize,
    sums: Vec<f64>,
}

impl Group {
    fn mean(&self, channel: usize) -> f64 {
        self.sums[channel] / self.count as f64
    }
}

impl Grid {
    /// A stretch without samples yet. `resampled`: not all of its steps will be
    /// [on the grid](is_on_grid).
    pub fn new(filter: &Butterworth, step_s: f64, channels: usize, resampled: bool) -> Self {
        Grid {
            step_s,
            resampled,
            count: 0,
            start_s: 0.0,
            last_s: 0.0,
            place: 0,
            newest: None,
            before: None,
            distinct: 0,
            points: 0,
            begun: false,
            held: Samples::new(channels),
            at: Vec::new(),
            channels: vec![filter.start(); channels],
            filtered: vec![Vec::new(); channels],
            from: 0,
        }
    }

    /// Keeps the channels that are marked.
    pub fn keep(&mut self, marked: &[bool]) {
        for group in [&mut self.newest, &mut self.before].into_iter().flatten() {
            keep(&mut group.sums, marked);
        }
        keep(&mut self.held.channels, marked);
        keep(&mut self.channels, marked);
        keep(&mut self.filtered, marked);
    }

    /// Adds `input`, the next samples, and returns those that are filtered: at the `end` of the
    /// stretch all of them, otherwise only if at least `least` points are.
    pub fn run(
        &mut self,
        filter: &Butterworth,
        input: Samples,
        end: bool,
        least: usize,
        treatment: &mut Treatment,
    ) -> Samples {
        for (i, t) in input.time_s.iter().enumerate() {
            self.add(*t, input.channels.iter().map(|c| c[i]));
        }
        self.held.append(input);
        if end {
            self.close();
            self.add_last_points();
        }
        let shortest = filter.shortest();
        self.begun |= self.count >= shortest && self.points >= shortest;
        let channels = self.channels.len();
        if !self.begun {
            if !end {
                return Samples::new(channels);
            }
            treatment.too_short += channels * self.count;
            treatment.short_stretches += channels;
            return std::mem::take(&mut self.held);
        }
        if end && self.resampled {
            treatment.resampled += channels * self.count;
        } else if end {
            treatment.filled += channels * (self.points - self.distinct);
        }
        self.held.channels.iter_mut().for_each(Vec::clear);
        for (channel, filtered) in self.channels.iter_mut().zip(&mut self.filtered) {
            filter.advance(channel, end, least, filtered);
        }
        self.take_filtered(end)
    }

    fn add(&mut self, time_s: f64, values: impl Iterator<Item = f64>) {
        if self.count == 0 {
            self.start_s = time_s;
        } else {
            self.place += ((time_s - self.last_s) / self.step_s).round() as usize;
        }
        self.count += 1;
        self.last_s = time_s;
        let (at, on_grid) = match self.resampled {
            true => (time_s, (time_s - self.start_s) / self.step_s),
            false => (self.place as f64, self.place as f64),
        };
        self.at.push(on_grid);
        if let Some(newest) = self.newest.as_mut().filter(|n| n.at == at) {
            newest.count += 1;
            let sums = newest.sums.iter_mut();
            sums.zip(values).for_each(|(sum, value)| *sum += value);
            return;
        }
        self.close();
        let mut sums = self.before.take().map_or_else(Vec::new, |before| {
            // Its memory is used again.
            let mut sums = before.sums;
            sums.clear();
            sums
        });
        sums.extend(values);
        self.before = self.newest.take();
        self.newest = Some(Group { at, count: 1, sums });
        self.distinct += 1;
    }

    /// Time or index of a point of the grid.
    fn point(&self, number: usize) -> f64 {
        match self.resampled {
            true => self.start_s + number as f64 * self.step_s,
            false => number as f64,
        }
    }

    /// The newest time stamp has all its samples: interpolates the points before it.
    fn close(&mut self) {
        let (Some(before), Some(newest)) = (&self.before, &self.newest) else {
            return;
        };
        loop {
            let point = self.point(self.points);
            if point >= newest.at {
                return;
            }
            let share = (point - before.at) / (newest.at - before.at);
            for (i, channel) in self.channels.iter_mut().enumerate() {
                let value = before.mean(i);
                channel
                    .samples
                    .push(value + share * (newest.mean(i) - value));
            }
            self.points += 1;
        }
    }

    /// The points from the last sample on.
    fn add_last_points(&mut self) {
        let Some(newest) = &self.newest else { return };
        let count = match self.resampled {
            true => ((self.last_s - self.start_s) / self.step_s).ceil() as usize + 1,
            false => self.place + 1,
        };
        for (i, channel) in self.channels.iter_mut().enumerate() {
            let more = count.saturating_sub(self.points);
            let samples = &mut channel.samples;
            samples.resize(samples.len() + more, newest.mean(i));
        }
        self.points = self.points.max(count);
    }

    /// The samples that lie between filtered points.
    fn take_filtered(&mut self, end: bool) -> Samples {
        let known = self.from + self.filtered.first().map_or(0, Vec::len);
        let is_known = |at: &f64| {
            let point = *at as usize;
            point + 1 < known || point < known && (end || at.fract() == 0.0)
        };
        let ready = self.at.partition_point(is_known);
        let mut out = self.held.times(0..ready);
        for (filtered, out) in self.filtered.iter().zip(&mut out.channels) {
            out.extend(self.at[..ready].iter().map(|at| {
                let point = *at as usize - self.from;
                let value = filtered[point];
                match filtered.get(point + 1) {
                    Some(next) if at.fract() > 0.0 => value + at.fract() * (next - value),
                    _ => value,
                }
            }));
        }
        self.held.remove_first(ready);
        self.at.drain(..ready);
        let newest = known.saturating_sub(1);
        let next = self.at.first().map_or(newest, |at| *at as usize);
        let passed = next.min(newest).saturating_sub(self.from);
        for filtered in &mut self.filtered {
            filtered.drain(..passed);
        }
        self.from += passed;
        out
    }
}
