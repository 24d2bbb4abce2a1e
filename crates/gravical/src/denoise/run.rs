//! Rows through the filters: not across breaks and gaps, and around empty cells.

use crate::Result;
use crate::recording::sample::Sample;

use super::clock::{Splits, StampFiller, Step};
use super::filter::Treatment;
use super::lane::{Lane, Output, Setup};
use super::noise::Noise;

/// Receives filtered rows: the first `rows` values of each filtered channel.
pub(super) type Receiver<'a> = dyn FnMut(&[Vec<f64>; 6], usize) -> Result<()> + 'a;

/// Rows on their way through the filters.
pub(super) struct Run<'a> {
    setup: &'a Setup,
    filler: StampFiller,
    lanes: Vec<Lane>,
    out: Output,
    /// Number of rows whose time is known, and the time of the last one.
    rows: usize,
    last_s: Option<f64>,
    /// Row of the last break.
    break_at: usize,
    counts: Counts,
}

/// What was counted in all rows.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Counts {
    /// Parts between breaks, gaps and steps back.
    pub stretches: usize,
    /// Gaps and steps back between breaks.
    pub splits: Splits,
    /// Number of rows without a time stamp.
    pub stamps_filled: usize,
    /// Number of empty cells.
    pub empty: usize,
}

/// Results, after the last row.
pub(super) struct Done {
    pub counts: Counts,
    /// Of each filter.
    pub treatments: Vec<Treatment>,
    /// Before the filters and after each, if requested.
    pub noise: Vec<Noise>,
}

impl<'a> Run<'a> {
    /// With `noise` before the filters and after each, or none.
    pub fn new(setup: &'a Setup, noise: Vec<Noise>) -> Self {
        Run {
            filler: StampFiller::new(setup.clock.step_s),
            lanes: vec![Lane::new(setup.channels.clone())],
            out: Output {
                first: 0,
                cells: Default::default(),
                treatments: vec![Treatment::default(); setup.filters.len()],
                noise,
            },
            rows: 0,
            last_s: None,
            break_at: 0,
            counts: Counts::default(),
            setup,
        }
    }

    /// Adds a row, whose time is NaN if unknown.
    ///
    /// # Errors
    ///
    /// Those of `receive`.
    pub fn push(&mut self, row: Sample, receive: &mut Receiver<'_>) -> Result<()> {
        if !self.setup.stamped {
            return self.push_timed(row, receive);
        }
        for row in self.filler.push(row) {
            self.push_timed(row, receive)?;
        }
        Ok(())
    }

    fn push_timed(&mut self, mut row: Sample, receive: &mut Receiver<'_>) -> Result<()> {
        let setup = self.setup;
        if row.is_break {
            self.end_lanes();
            self.lanes = vec![Lane::new(setup.channels.clone())];
            (self.last_s, self.break_at) = (None, self.rows);
        }
        if !setup.stamped {
            row.time_s = (self.rows - self.break_at) as f64 * setup.clock.step_s;
        }
        let step = self
            .last_s
            .map(|last_s| setup.clock.step(last_s, row.time_s));
        self.last_s = Some(row.time_s);
        self.counts.stretches += usize::from(step.is_none_or(Step::parts));
        self.counts.splits.gaps += usize::from(step == Some(Step::Gap));
        self.counts.splits.backward += usize::from(step == Some(Step::Backward));
        let mut empty = 0;
        for c in &setup.channels {
            empty += usize::from(!row.values[*c].is_finite());
            self.out.cells[*c].push(row.values[*c]);
        }
        self.counts.empty += empty;
        if empty > 0 && empty < setup.channels.len() {
            let split = self
                .lanes
                .iter_mut()
                .filter_map(|lane| lane.split(&row.values));
            let split: Vec<Lane> = split.collect();
            self.lanes.extend(split);
        }
        let mut split = Vec::new();
        for lane in &mut self.lanes {
            split.extend(lane.push(setup, self.rows, row.time_s, &row.values, &mut self.out));
        }
        self.lanes.append(&mut split);
        self.rows += 1;
        if self.rows.is_multiple_of(setup.block) {
            for lane in &mut self.lanes {
                lane.run(setup, false, &mut self.out);
            }
            self.hand_on(receive)?;
        }
        Ok(())
    }

    fn end_lanes(&mut self) {
        for lane in &mut self.lanes {
            lane.end(self.setup, &mut self.out);
        }
    }

    /// Hands on the rows that are complete.
    fn hand_on(&mut self, receive: &mut Receiver<'_>) -> Result<()> {
        let first = self.lanes.iter().filter_map(Lane::first_row).min();
        let rows = first.unwrap_or(self.rows) - self.out.first;
        receive(&self.out.cells, rows)?;
        for channel in &mut self.out.cells {
            channel.drain(..rows.min(channel.len()));
        }
        self.out.first += rows;
        Ok(())
    }

    /// Filters the last rows.
    ///
    /// # Errors
    ///
    /// Those of `receive`.
    pub fn finish(mut self, receive: &mut Receiver<'_>) -> Result<Done> {
        for row in self.filler.finish() {
            self.push_timed(row, receive)?;
        }
        self.end_lanes();
        self.hand_on(receive)?;
        self.counts.stamps_filled = self.filler.filled;
        Ok(Done {
            counts: self.counts,
            treatments: self.out.treatments,
            noise: self.out.noise,
        })
    }
}
