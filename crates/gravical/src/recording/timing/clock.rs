//! Stamps followed one by one: where they wrap, restart, repeat, run backwards
//! or leave a gap.

use super::odd::{Faults, Treatment};
use super::{PAUSE, is_usual_step};
use crate::finding::Finding;
use crate::recording::ledger::Aside;

/// Clocks begin anew after so many seconds: parts of a second, seconds of a minute, of an
/// hour, of a day, of a week.
const WRAPS_S: [f64; 5] = [1.0, 60.0, 3600.0, 86_400.0, 604_800.0];

/// Clocks begin anew after so many usual steps at the least.
const LEAST_STEPS: f64 = 20.0;

/// Makes raw stamps seconds from the first one that go on.
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

    /// The same, which has found nothing yet.
    pub(crate) fn without_findings(&self) -> Self {
        Follower {
            stamps: Stamps {
                faults: Faults::default(),
                ..self.stamps
            },
            offset: self.offset,
        }
    }

    /// What the stamp says, and its time, s; NaN where it is absent.
    #[inline]
    pub(crate) fn see(&mut self, stamp: f64, line: u64) -> (Clock, f64) {
        let before = self.stamps.before;
        let clock = self.stamps.see(stamp, line);
        match clock {
            Clock::GoesOn | Clock::Paused => {
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

    /// The recording is parted before the next row.
    pub(crate) fn part(&mut self, how: Parting) {
        self.stamps.part(how);
    }

    /// Pauses of the recorder: how many, and how long in all, s.
    pub(crate) fn paused(&self) -> (u64, f64) {
        let faults = &self.stamps.faults;
        (faults.pauses.count(), faults.paused_s)
    }

    /// What was odd.
    pub(crate) fn report(&self, treatment: Treatment, findings: &mut Vec<Finding>) {
        let stamps = &self.stamps;
        stamps.faults.report(findings, stamps.rows, treatment);
    }
}

/// What a stamp says about the clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Clock {
    /// The stamp stands as it is, odd or not.
    GoesOn,
    /// The row has none.
    Absent,
    /// The recorder had stopped, and says so: what was not recorded is not missing.
    Paused,
    /// The counter began at zero again.
    Wrapped {
        /// After this many.
        period: f64,
        /// While the recorder had stopped, as [`Clock::Paused`].
        paused: bool,
    },
    /// The board was reset.
    Restarted,
}

/// How a recording is parted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Parting {
    /// By blank lines, or a header: it was stopped and goes on.
    Break,
    /// By a gap that is named: rows are missing, and the clock may start anew.
    NamedGap,
}

impl Parting {
    /// What a line that parts rows does to them; none for one that does not.
    pub(crate) fn by(reason: Aside) -> Option<Self> {
        match reason {
            Aside::NamedGap => Some(Parting::NamedGap),
            reason if reason.parts() => Some(Parting::Break),
            _ => None,
        }
    }
}

/// Follows raw stamps one after the other and books what is odd about them.
#[derive(Debug, Clone)]
struct Stamps {
    /// Usual step, in the unit of the stamps.
    median: f64,
    /// Seconds per unit.
    per_s: f64,
    before: f64,
    /// Rows with a stamp.
    rows: u64,
    /// How many of them there were at the last parting.
    parted_at: Option<(u64, Parting)>,
    faults: Faults,
}

impl Stamps {
    fn new(median: f64, per_s: f64) -> Self {
        Stamps {
            median,
            per_s,
            before: f64::NAN,
            rows: 0,
            parted_at: None,
            faults: Faults::default(),
        }
    }

    /// The recording is parted before the next row. At a gap that is named a clock
    /// that runs backwards was started anew, however long ago; blank lines in one do
    /// not make it a pause.
    fn part(&mut self, how: Parting) {
        if self.parted_at != Some((self.rows, Parting::NamedGap)) {
            self.parted_at = Some((self.rows, how));
        }
    }

    #[inline]
    fn see(&mut self, stamp: f64, line: u64) -> Clock {
        let step = stamp - self.before;
        if is_usual_step(step, self.median) {
            self.before = stamp;
            self.rows += 1;
            return Clock::GoesOn;
        }
        self.see_odd(stamp, line)
    }

    #[cold]
    fn see_odd(&mut self, stamp: f64, line: u64) -> Clock {
        if !stamp.is_finite() {
            self.faults.absent.push(line);
            return Clock::Absent;
        }
        let before = std::mem::replace(&mut self.before, stamp);
        let parted = self.parted_at.filter(|(at, _)| *at == self.rows);
        let how = parted.map(|(_, how)| how);
        let after_gap = how == Some(Parting::NamedGap) && self.median.is_finite();
        self.rows += 1;
        let step = stamp - before;
        if step < 0.0 {
            if let Some(period) = self.wrap_period(before, stamp) {
                self.faults.wrapped.push(line);
                let paused = self.waited(step + period, how, line);
                return Clock::Wrapped { period, paused };
            }
            let near_zero = stamp < 0.5 * before
                && -step > 20.0 * self.median
                && stamp < 100.0 * self.median.max(1.0 / self.per_s);
            if near_zero || after_gap {
                // The board began to count anew: it was reset.
                self.faults.restarted.push(line);
                return Clock::Restarted;
            }
            self.faults.backward.push(line);
        } else if step == 0.0 {
            self.faults.duplicate.push(line);
        } else if self.waited(step, how, line) {
            return Clock::Paused;
        }
        Clock::GoesOn
    }

    /// What a clock that fell counts to, in its unit: a 32-bit counter that fell from
    /// near its end to near its start, or any other that comes out at a usual step.
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
                // A step back in a clock that has passed the period is no wrap, nor is one
                // of a clock that has few steps in it.
                let within =
                    before < period && now >= 0.0 || before < 0.5 * period && now >= -0.5 * period;
                within
                    && period > LEAST_STEPS * self.median
                    && is_usual_step(now + period - before, self.median)
            })
    }

    /// Books a long step: a pause (then true), or a gap.
    fn waited(&mut self, step: f64, how: Option<Parting>, line: u64) -> bool {
        // Below that, single lost samples: they are in the missing share. The first
        // stamp has no step.
        let is_long = step > PAUSE * self.median;
        if !is_long {
            return false;
        }
        let faults = &mut self.faults;
        let step_s = step * self.per_s;
        let paused = how == Some(Parting::Break);
        if paused {
            faults.pauses.push(line);
            faults.paused_s += step_s;
            faults.longest_pause_s = faults.longest_pause_s.max(step_s);
        } else {
            faults.gaps.push(line);
            faults.longest_gap_s = faults.longest_gap_s.max(step_s);
        }
        paused
    }
}
