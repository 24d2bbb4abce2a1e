//! A filter with a window over rows as they come, from a recording of any size: the
//! same values as over all of them at once.
//!
//! Rows are gathered; those whose window is complete are filtered together, by the
//! code that filters a whole recording. A window of rows before them is kept, so that
//! nothing that is given away lies near an end that is none.

use std::ops::Range;
use std::rc::Rc;

use super::clock::{Clock, Parted, Stretch};
use super::filter::Filter;
use super::run::Outcome;
use super::summary::{told_of_filter, told_of_rows};
use super::{DenoiseOptions, Edge, FilterSpec};
use crate::Result;
use crate::recording::{Finding, Recording};

/// Rows that are filtered together.
const TOGETHER: usize = 4096;

/// Rows that are waited for at most.
const MOST: usize = 1 << 17;

/// Rows as they come; an empty cell is NaN.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rows {
    /// Time, s.
    pub t_s: Vec<f64>,
    /// Specific force in the unit of the file.
    pub accel: [Vec<f64>; 3],
    /// Temperature, °C.
    pub temperature_c: Vec<f64>,
    /// Line of the file.
    pub line: Vec<u64>,
    /// Rows before which the recording has a break.
    pub breaks: Vec<usize>,
}

impl Rows {
    fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Every cell of the accelerometer has a value.
    #[inline]
    fn is_complete(&self, row: usize) -> bool {
        let [x, y, z] = &self.accel;
        (x[row] + y[row] + z[row]).is_finite()
    }

    fn forget(&mut self, count: usize) {
        self.t_s.drain(..count);
        self.accel.iter_mut().for_each(|c| drop(c.drain(..count)));
        self.temperature_c.drain(..count);
        self.line.drain(..count);
        self.breaks.retain(|b| *b >= count);
        self.breaks.iter_mut().for_each(|b| *b -= count);
    }
}

/// How near a step came to where it would have been judged otherwise, s.
#[derive(Debug, Clone, Copy)]
struct Margin {
    even: f64,
    gap: f64,
}

/// The filter and its rows.
#[derive(Clone)]
pub(crate) struct Running {
    filter: Option<Rc<Filter>>,
    /// Rows to either side that tell on a value.
    window: usize,
    clock: Clock,
    /// There are stamps.
    stamped: bool,
    rows: Rows,
    /// Filtered, as far as given away.
    smooth: [Vec<f64>; 3],
    given: usize,
    outcome: Outcome,
    parted: Parted,
    empty: usize,
    margin: Margin,
}

impl Running {
    /// Ready for a recording that begins as `head` does; none for filters that take
    /// more than one window, and for several of them.
    ///
    /// # Errors
    ///
    /// As [`Filter::design`].
    pub fn new(head: &Recording, filters: &[FilterSpec], edge: Edge) -> Result<Option<Self>> {
        let clock = Clock::of(head, DenoiseOptions::GAP_STEPS);
        let filter = match filters {
            [] => None,
            [spec @ (FilterSpec::SavitzkyGolay { .. } | FilterSpec::Mean { .. })] => {
                Some(Filter::design(spec, head.timing.rate_hz(), edge)?)
            }
            _ => return Ok(None),
        };
        let window = filter.as_ref().map_or(0, Filter::shortest);
        if window > TOGETHER {
            return Ok(None);
        }
        Ok(Some(Running {
            filter: filter.map(Rc::new),
            window,
            clock,
            stamped: head.time_s.is_some(),
            rows: Rows::default(),
            smooth: Default::default(),
            given: 0,
            outcome: Outcome::default(),
            parted: Parted::default(),
            empty: 0,
            margin: Margin {
                even: f64::INFINITY,
                gap: f64::INFINITY,
            },
        }))
    }

    /// A row.
    #[inline]
    pub fn push(&mut self, t_s: f64, accel: [f64; 3], temperature_c: f64, line: u64) {
        self.rows.t_s.push(t_s);
        for (channel, value) in self.rows.accel.iter_mut().zip(accel) {
            channel.push(value);
        }
        self.rows.temperature_c.push(temperature_c);
        self.rows.line.push(line);
    }

    /// A break before the next row.
    pub fn part(&mut self) {
        let row = self.rows.len();
        if self.rows.breaks.last() != Some(&row) {
            self.rows.breaks.push(row);
        }
    }

    /// Enough rows have come.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.rows.len() >= self.given + TOGETHER + self.window
    }

    /// So many rows without a value came that none can be given away.
    pub fn is_stuck(&self) -> bool {
        self.rows.len() > MOST
    }

    /// The rows, the accelerometer filtered, and which of them are new. With `last` all
    /// that there are. [`settle`](Self::settle) has to follow.
    pub fn go(&mut self, last: bool) -> (&Rows, &[Vec<f64>; 3], Range<usize>) {
        let to = if last {
            self.rows.len()
        } else {
            self.backwards(self.rows.len(), self.window)
                .unwrap_or(0)
                .max(self.given)
        };
        let new = self.given..to;
        for (smooth, raw) in self.smooth.iter_mut().zip(&self.rows.accel) {
            smooth.clear();
            smooth.extend_from_slice(raw);
        }
        if let Some(filter) = self.filter.clone()
            && !new.is_empty()
        {
            self.look_at_steps(&new);
            self.run(&filter, &new);
        }
        self.given = to;
        (&self.rows, &self.smooth, new)
    }

    /// Forgets all rows.
    pub fn forget_all(&mut self) {
        self.rows.forget(self.rows.len());
        self.given = 0;
    }

    /// Forgets rows that no window needs any more.
    pub fn settle(&mut self) {
        let keep = self.backwards(self.given, 2 * self.window).unwrap_or(0);
        self.rows.forget(keep);
        self.given -= keep;
    }

    /// The row from which on `count` rows before `end` are complete.
    fn backwards(&self, end: usize, count: usize) -> Option<usize> {
        let mut left = count;
        let mut row = end;
        while left > 0 {
            row = row.checked_sub(1)?;
            left -= usize::from(self.rows.is_complete(row));
        }
        Some(row)
    }

    fn look_at_steps(&mut self, new: &Range<usize>) {
        let from = new.start.max(1);
        let t = &self.rows.t_s[from - 1..new.end.max(from)];
        let (step, even, gap) = (self.clock.step_s, self.clock.even_s(), self.clock.gap_s);
        if !self.stamped {
            return;
        }
        for pair in t.windows(2) {
            self.margin.see(pair[1] - pair[0], step, even, gap);
        }
    }

    fn run(&mut self, filter: &Filter, new: &Range<usize>) {
        let mut edges = vec![0];
        edges.extend(self.rows.breaks.iter().copied().filter(|b| *b > 0));
        edges.push(self.rows.len());
        for pair in edges.windows(2) {
            let piece = pair[0]..pair[1];
            if piece.is_empty() {
                continue;
            }
            let wanted = within(new, &piece);
            let times = &self.rows.t_s[piece.clone()];
            let stretches = if self.stamped {
                self.clock.stretches(times, &mut Parted::default())
            } else {
                vec![Stretch {
                    rows: 0..times.len(),
                    uneven: Vec::new(),
                }]
            };
            for stretch in stretches.iter().skip(1) {
                let row = stretch.rows.start;
                if wanted.contains(&row) {
                    let backward = times[row] < times[row - 1];
                    self.parted.backward += usize::from(backward);
                    self.parted.gaps += usize::from(!backward);
                }
            }
            let whole = piece.clone().all(|row| self.rows.is_complete(row));
            let time_s = self.stamped.then_some(times);
            if whole {
                let parts = self.smooth.iter_mut().map(|c| &mut c[piece.clone()]);
                let parts: Vec<&mut [f64]> = parts.collect();
                run_stretches(
                    filter,
                    time_s,
                    &stretches,
                    parts,
                    &wanted,
                    &mut self.outcome,
                );
            } else {
                for channel in 0..3 {
                    self.run_holed(filter, channel, &piece, &wanted);
                }
            }
        }
    }

    /// One channel with empty cells: what is there is filtered as samples among which
    /// some are missing.
    fn run_holed(
        &mut self,
        filter: &Filter,
        channel: usize,
        piece: &Range<usize>,
        wanted: &Range<usize>,
    ) {
        let raw = &self.rows.accel[channel][piece.clone()];
        let there: Vec<usize> = (0..raw.len()).filter(|i| raw[*i].is_finite()).collect();
        let count = |rows: Range<usize>| rows.len();
        self.empty += count(wanted.clone()) - there.iter().filter(|i| wanted.contains(i)).count();
        let mut values: Vec<f64> = there.iter().map(|i| raw[*i]).collect();
        let time: Vec<f64> = there
            .iter()
            .map(|i| match self.stamped {
                true => self.rows.t_s[piece.start + i],
                false => *i as f64 * self.clock.step_s,
            })
            .collect();
        let own = there.partition_point(|i| *i < wanted.start)
            ..there.partition_point(|i| *i < wanted.end);
        let (step, even, gap) = (self.clock.step_s, self.clock.even_s(), self.clock.gap_s);
        for pair in time.windows(2) {
            self.margin.see(pair[1] - pair[0], step, even, gap);
        }
        let stretches = self.clock.stretches(&time, &mut Parted::default());
        let parts = vec![&mut values[..]];
        run_stretches(
            filter,
            Some(&time),
            &stretches,
            parts,
            &own,
            &mut self.outcome,
        );
        for (i, value) in there.iter().zip(values) {
            self.smooth[channel][piece.start + i] = value;
        }
    }

    /// What is odd, as [`smooth`](super::smooth) says it of the whole recording, whose
    /// stamps have this rate, Hz, and begin as `time_s`; none where a step would have
    /// been judged otherwise by that.
    pub fn finish(
        &self,
        rate_hz: Option<f64>,
        time_s: Option<&[f64]>,
        duration_s: Option<f64>,
    ) -> Option<Vec<Finding>> {
        let Some(filter) = &self.filter else {
            return Some(Vec::new());
        };
        let clock = Clock::new(rate_hz, time_s, DenoiseOptions::GAP_STEPS);
        let apart = (clock.step_s - self.clock.step_s).abs();
        let even = apart + (clock.even_s() - self.clock.even_s()).abs();
        let gap = (clock.gap_s - self.clock.gap_s).abs();
        let as_judged = |moved: f64, margin: f64| moved == 0.0 || moved < margin;
        if !(as_judged(even, self.margin.even) && as_judged(gap, self.margin.gap)) {
            return None;
        }
        let mut out = told_of_filter(filter, &self.outcome, rate_hz, duration_s);
        out.extend(told_of_rows(self.parted, clock.gap_s, 0, self.empty));
        Some(out)
    }
}

impl Margin {
    #[inline]
    fn see(&mut self, step: f64, usual: f64, even: f64, gap: f64) {
        self.even = self.even.min(((step - usual).abs() - even).abs());
        self.gap = self.gap.min((step - gap).abs());
    }
}

/// Those of `rows` in `piece`, counted from its start.
fn within(rows: &Range<usize>, piece: &Range<usize>) -> Range<usize> {
    let from = rows.start.clamp(piece.start, piece.end);
    let to = rows.end.clamp(from, piece.end);
    from - piece.start..to - piece.start
}

/// As over a whole recording, but that only what becomes of the `wanted` rows counts.
fn run_stretches(
    filter: &Filter,
    time_s: Option<&[f64]>,
    stretches: &[Stretch],
    mut channels: Vec<&mut [f64]>,
    wanted: &Range<usize>,
    outcome: &mut Outcome,
) {
    let count = channels.len();
    for stretch in stretches {
        let own = within(wanted, &stretch.rows);
        if own.is_empty() {
            continue;
        }
        let mut parts: Vec<&mut [f64]> = channels
            .iter_mut()
            .map(|channel| &mut channel[stretch.rows.clone()])
            .collect();
        let time_s = time_s.map(|t| &t[stretch.rows.clone()]);
        let treated = filter.apply_at(time_s, &stretch.uneven, &mut parts, own.clone());
        outcome.samples += count * own.len();
        if treated.too_short > 0 {
            outcome.short_stretches += count * usize::from(own.start == 0);
            outcome.treated.too_short += count * own.len();
        }
        outcome.treated.fitted += count * treated.fitted;
        outcome.treated.too_few += count * treated.too_few;
    }
}
