//! Checks time stamps one by one: wraps, restarts, repeats, steps back and gaps.

use super::odd::Faults;
use super::{PAUSE, is_usual_step};
use crate::finding::Finding;
use crate::recording::ledger::Aside;

/// Periods after which clocks begin again, s: parts of a second, seconds of a minute, of an hour,
/// of a day, of a week.
const WRAPS_S: [f64; 5] = [1.0, 60.0, 3600.0, 86_400.0, 604_800.0];

/// Smallest number of usual steps in such a period.
const LEAST_STEPS: f64 = 20.0;

/// Converts raw time stamps to continuous seconds since the first one.
#[derive(Debug, Clone)]
pub(crate) struct Follower {
    stamps: Stamps,
    offset: f64,
}

impl Follower {
    /// `median` is the usual step, in units of `per_s` seconds.
    pub(crate) fn new(median: f64, per_s: f64) -> Self {
        Follower {
            stamps: Stamps::new(median, per_s),
            offset: f64::NAN,
        }
    }

    /// Meaning of the time stamp, and its time, s; NaN if it is absent.
    #[inline]
    pub(crate) fn observe(&mut self, stamp: f64, line: u64) -> (Clock, f64) {
        let before = self.stamps.before;
        let clock = self.stamps.observe(stamp, line);
        match clock {
            Clock::Continues | Clock::Paused => {
                if self.offset.is_nan() {
                    self.offset = -stamp;
                }
            }
            Clock::Absent => return (clock, f64::NAN),
            Clock::Wrapped { period, .. } => self.offset += period,
            Clock::Restarted => self.offset += before + self.stamps.median - stamp,
        }
        (clock, (stamp + self.offset) * self.stamps.per_s)
    }

    /// Marks a break before the next row.
    pub(crate) fn mark_break(&mut self, how: BreakKind) {
        self.stamps.mark_break(how);
    }

    /// Pauses of the recorder: their number and total length, s.
    pub(crate) fn paused(&self) -> (u64, f64) {
        let faults = &self.stamps.faults;
        (faults.pauses.count(), faults.paused_s)
    }

    /// Adds the findings.
    pub(crate) fn report(&self, findings: &mut Vec<Finding>) {
        let stamps = &self.stamps;
        stamps.faults.report(findings, stamps.rows);
    }
}

/// Meaning of a time stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Clock {
    /// The clock continues, with or without a fault.
    Continues,
    /// The row has no time stamp.
    Absent,
    /// The recorder was stopped deliberately: samples in between are not missing.
    Paused,
    /// The counter wrapped to zero.
    Wrapped {
        /// Its period.
        period: f64,
        /// The recorder was stopped at the same time, as in [`Clock::Paused`].
        paused: bool,
    },
    /// The board was reset.
    Restarted,
}

/// Kind of a break in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum BreakKind {
    /// Blank lines or a header: the recorder was stopped and started again.
    Pause,
    /// A named gap: rows are missing, and the clock may restart.
    NamedGap,
}

impl BreakKind {
    /// The kind of break that a line makes; `None` if it makes none.
    pub(crate) fn of(reason: Aside) -> Option<Self> {
        match reason {
            Aside::NamedGap => Some(BreakKind::NamedGap),
            reason if reason.is_break() => Some(BreakKind::Pause),
            _ => None,
        }
    }
}

/// Checks raw time stamps one after the other and counts their faults.
#[derive(Debug, Clone)]
struct Stamps {
    /// Usual step, in the unit of the stamps.
    median: f64,
    /// Seconds per unit.
    per_s: f64,
    before: f64,
    /// Rows with a stamp.
    rows: u64,
    /// Value of `rows` at the last break, and its kind.
    last_break: Option<(u64, BreakKind)>,
    faults: Faults,
}

impl Stamps {
    fn new(median: f64, per_s: f64) -> Self {
        Stamps {
            median,
            per_s,
            before: f64::NAN,
            rows: 0,
            last_break: None,
            faults: Faults::default(),
        }
    }

    /// Marks a break before the next row. After a named gap, a clock that runs backwards has
    /// restarted, however long ago; blank lines within the gap do not make it a pause.
    fn mark_break(&mut self, how: BreakKind) {
        if self.last_break != Some((self.rows, BreakKind::NamedGap)) {
            self.last_break = Some((self.rows, how));
        }
    }

    #[inline]
    fn observe(&mut self, stamp: f64, line: u64) -> Clock {
        let step = stamp - self.before;
        if is_usual_step(step, self.median) {
            self.before = stamp;
            self.rows += 1;
            return Clock::Continues;
        }
        self.observe_unusual(stamp, line)
    }

    #[cold]
    fn observe_unusual(&mut self, stamp: f64, line: u64) -> Clock {
        if !stamp.is_finite() {
            self.faults.absent.push(line);
            return Clock::Absent;
        }
        let before = std::mem::replace(&mut self.before, stamp);
        let parted = self.last_break.filter(|(at, _)| *at == self.rows);
        let how = parted.map(|(_, how)| how);
        let after_gap = how == Some(BreakKind::NamedGap) && self.median.is_finite();
        self.rows += 1;
        let step = stamp - before;
        if step < 0.0 {
            if let Some(period) = self.wrap_period(before, stamp) {
                self.faults.wrapped.push(line);
                let paused = self.record_long_step(step + period, how, line);
                return Clock::Wrapped { period, paused };
            }
            let near_zero = stamp < 0.5 * before
                && -step > 20.0 * self.median
                && stamp < 100.0 * self.median.max(1.0 / self.per_s);
            if near_zero || after_gap {
                // The board was reset and counts from zero.
                self.faults.restarted.push(line);
                return Clock::Restarted;
            }
            self.faults.backward.push(line);
        } else if step == 0.0 {
            self.faults.duplicate.push(line);
        } else if self.record_long_step(step, how, line) {
            return Clock::Paused;
        }
        Clock::Continues
    }

    /// Period of a clock that stepped back, in its unit: a 32-bit counter that fell from near its
    /// end to near its start, or any other period that makes the step a usual one.
    fn wrap_period(&self, before: f64, now: f64) -> Option<f64> {
        let whole = 4_294_967_296.0; // 2³²
        if before > 0.95 * whole && before < whole && (0.0..0.05 * whole).contains(&now) {
            return Some(whole);
        }
        let of_time = WRAPS_S.map(|seconds| seconds / self.per_s);
        [65_536.0, 16_777_216.0, whole]
            .into_iter()
            .chain(of_time)
            .find(|&period| {
                // A clock that has passed the period did not wrap but step back; so did a clock
                // with few steps in the period.
                let within =
                    before < period && now >= 0.0 || before < 0.5 * period && now >= -0.5 * period;
                within
                    && period > LEAST_STEPS * self.median
                    && is_usual_step(now + period - before, self.median)
            })
    }

    /// Records a long step: a pause (returns true) or a gap.
    fn record_long_step(&mut self, step: f64, how: Option<BreakKind>, line: u64) -> bool {
        // Shorter steps are single lost samples, counted as missing. The first stamp has no step.
        let is_long = step > PAUSE * self.median;
        if !is_long {
            return false;
        }
        let faults = &mut self.faults;
        let step_s = step * self.per_s;
        let paused = how == Some(BreakKind::Pause);
        if paused {
            faults.pauses.push(line);
            faults.paused_s += step_s;
        } else {
            faults.gaps.push(line);
            faults.longest_gap_s = faults.longest_gap_s.max(step_s);
        }
        paused
    }
}
