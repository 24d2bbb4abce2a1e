//! Channels that have values in the same rows, on their way through the filters.

use super::clock::{Clock, Step};
use super::filter::{Filter, Treatment};
use super::noise::Noise;
use super::off_grid::OffGrid;
use super::samples::{Samples, keep};
use super::stage::Stage;

/// What does not change while rows are filtered.
pub(super) struct Setup {
    pub filters: Vec<Filter>,
    pub clock: Clock,
    pub off_grid: OffGrid,
    /// The rows have time stamps, though not necessarily all of them.
    pub stamped: bool,
    /// Numbers of the filtered channels: 0 to 2 the accelerometer, 3 to 5 the gyroscope.
    pub channels: Vec<usize>,
    /// Number of rows that are filtered together.
    pub block: usize,
}

/// What all lanes add to.
pub(super) struct Output {
    /// Number of the first row that was not handed on.
    pub first: usize,
    /// Values of the rows from there on.
    pub cells: [Vec<f64>; 6],
    /// Of each filter.
    pub treatments: Vec<Treatment>,
    /// Before the filters and after each.
    pub noise: Vec<Noise>,
}

/// Channels that have values in the same rows since the last break.
#[derive(Clone)]
pub(super) struct Lane {
    pub channels: Vec<usize>,
    /// The time of the last sample of the stretch, s, and the number of uneven steps before it.
    last_s: Option<f64>,
    uneven: usize,
    /// Samples that no filter has seen yet.
    incoming: Samples,
    /// Row numbers of the samples that not all filters have returned.
    rows: Vec<usize>,
    /// Number of samples that all filters have returned.
    returned: usize,
    stages: Vec<Stage>,
}

impl Lane {
    pub fn new(channels: Vec<usize>) -> Self {
        Lane {
            incoming: Samples::new(channels.len()),
            channels,
            last_s: None,
            uneven: 0,
            rows: Vec::new(),
            returned: 0,
            stages: Vec::new(),
        }
    }

    /// Row of the first sample that not all filters have returned.
    pub fn first_row(&self) -> Option<usize> {
        self.rows.first().copied()
    }

    /// Splits off the channels without a value in a row in which others have one.
    pub fn split(&mut self, values: &[f64; 6]) -> Option<Lane> {
        let known = |c: &usize| values[*c].is_finite();
        let some = self.channels.iter().any(known);
        if self.channels.iter().all(|c| known(c) == some) {
            return None;
        }
        let known: Vec<bool> = self.channels.iter().map(known).collect();
        Some(self.split_off(&known))
    }

    /// Splits off the channels that are not marked.
    fn split_off(&mut self, marked: &[bool]) -> Lane {
        let mut other = self.clone();
        let others: Vec<bool> = marked.iter().map(|marked| !marked).collect();
        self.keep(marked);
        other.keep(&others);
        other
    }

    fn keep(&mut self, marked: &[bool]) {
        keep(&mut self.channels, marked);
        keep(&mut self.incoming.channels, marked);
        self.stages.iter_mut().for_each(|stage| stage.keep(marked));
    }

    /// Adds the values of a row, if there are any. Channels whose stretches begin here, but are not
    /// alike, are split off.
    #[inline]
    pub fn push(
        &mut self,
        setup: &Setup,
        row: usize,
        time_s: f64,
        values: &[f64; 6],
        out: &mut Output,
    ) -> Option<Lane> {
        let step = self.last_s.map(|last_s| setup.clock.step(last_s, time_s));
        let is_empty = !values[self.channels[0]].is_finite();
        if is_empty {
            // Later samples are beyond the gap, too.
            if step == Some(Step::Gap) {
                self.end(setup, out);
            }
            return None;
        }
        match step {
            Some(step) if step.parts() => self.end(setup, out),
            Some(Step::Uneven) => self.uneven += 1,
            _ => {}
        }
        let mut other = None;
        if self.last_s.is_none() {
            let off_grid = setup.off_grid.contains(self.channels[0], row);
            let is_alike = |c: &usize| setup.off_grid.contains(*c, row) == off_grid;
            if !self.channels.iter().all(is_alike) {
                let alike: Vec<bool> = self.channels.iter().map(is_alike).collect();
                let mut others = self.split_off(&alike);
                others.push(setup, row, time_s, values, out);
                other = Some(others);
            }
            let stage = |f| Stage::new(f, self.channels.len(), off_grid);
            self.stages = setup.filters.iter().map(stage).collect();
        }
        self.last_s = Some(time_s);
        self.incoming.time_s.push(time_s);
        self.incoming.uneven.push(self.uneven);
        for (channel, c) in self.incoming.channels.iter_mut().zip(&self.channels) {
            channel.push(values[*c]);
        }
        self.rows.push(row);
        other
    }

    /// Ends the stretch.
    pub fn end(&mut self, setup: &Setup, out: &mut Output) {
        if self.last_s.take().is_some() {
            self.run(setup, true, out);
            self.stages.clear();
        }
        (self.uneven, self.returned) = (0, 0);
    }

    /// Filters what was added; at the `end` of a stretch all of it is handed on.
    pub fn run(&mut self, setup: &Setup, end: bool, out: &mut Output) {
        let channels = self.channels.len();
        let mut samples = std::mem::replace(&mut self.incoming, Samples::new(channels));
        let new = self.rows.len() - samples.len();
        if let Some(noise) = out.noise.first_mut() {
            noise.add(&self.channels, &self.rows[new..], &samples.channels);
        }
        for (i, (stage, filter)) in self.stages.iter_mut().zip(&setup.filters).enumerate() {
            let from = stage.returned - self.returned;
            samples = stage.run(filter, samples, end, setup.block, &mut out.treatments[i]);
            if let Some(noise) = out.noise.get_mut(i + 1) {
                let rows = &self.rows[from..from + samples.len()];
                noise.add(&self.channels, rows, &samples.channels);
            }
        }
        for (c, channel) in self.channels.iter().zip(&samples.channels) {
            for (row, value) in self.rows.iter().zip(channel) {
                out.cells[*c][row - out.first] = *value;
            }
        }
        self.returned += samples.len();
        self.rows.drain(..samples.len());
    }
}
