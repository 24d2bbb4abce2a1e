//! Where rows are missing: by the clock of the board, and by what happened to its port.

use std::collections::VecDeque;

use serde::Serialize;

/// Fewer rows than this are no gap: the reader counts them as missing.
const MIN_MISSING: u64 = 4;

/// Why rows are missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// The port was lost: a cable was pulled, a hub was suspended.
    Unplugged,
    /// The clock of the board restarted.
    Reset,
    /// The board sent nothing for a while.
    Silent,
    /// The clock of the board jumped.
    Lost,
    /// The recording had ended and was continued.
    Continued,
}

/// Rows that are missing, why, and how many.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gap {
    /// The first cause.
    pub cause: Cause,
    /// Rows that are missing by the clock of the board; none where it does not tell.
    pub rows: Option<u64>,
    /// Time without a row, s: by the clock of the board, else by that of the computer.
    pub duration_s: f64,
    /// The clock of the board restarted.
    pub clock_restarts: bool,
    /// No row arrived after it.
    pub until_end: bool,
}

impl Gap {
    /// The line of the file, without its end.
    pub fn line(&self) -> String {
        let cause = match self.cause {
            Cause::Unplugged => "unplugged",
            Cause::Reset => "the board was reset",
            Cause::Silent => "the board sent nothing",
            Cause::Lost => "rows were lost on the way from the board",
            Cause::Continued => return "# gap: the recording was ended and continued".to_owned(),
        };
        let rows = match self.rows {
            _ if self.until_end => "no row arrived until the end".to_owned(),
            Some(1) => "1 row is missing".to_owned(),
            Some(n) => format!("{n} rows are missing"),
            None => "an unknown number of rows is missing".to_owned(),
        };
        let clock = if self.clock_restarts {
            ", the clock of the board restarts"
        } else {
            ""
        };
        format!("# gap: {cause}: {rows}, {:.1} s{clock}", self.duration_s)
    }
}

/// What is known of missing rows since the last row.
#[derive(Default)]
pub struct Gaps {
    clock: Clock,
    last_row_s: f64,
    /// Why rows are missing.
    open: Option<Cause>,
    clock_restarts: bool,
    /// Lines that were rejected: they were rows.
    rejected: u64,
}

impl Gaps {
    /// Rows are missing from here on. The first cause counts.
    pub fn open(&mut self, cause: Cause) {
        self.open.get_or_insert(cause);
    }

    /// A line was rejected.
    pub fn reject(&mut self) {
        self.rejected += 1;
    }

    /// The gap before a row that arrived at `at_s` with this stamp; NaN: it has none. In a pause only a
    /// restart of the clock is kept for the next row that is stored.
    pub fn before_row(
        &mut self,
        at_s: f64,
        stamp: f64,
        is_stored: bool,
        rate_hz: Option<f64>,
    ) -> Option<Gap> {
        let step = self.clock.next(stamp);
        let rejected = std::mem::take(&mut self.rejected);
        let silence_s = at_s - std::mem::replace(&mut self.last_row_s, at_s);
        let missing = match step {
            Step::Missing(rows) => Some(rows.saturating_sub(rejected)),
            Step::Restart | Step::Unknown => None,
        };
        match missing {
            Some(MIN_MISSING..) => self.open(Cause::Lost),
            // The board was silent, and no row is missing.
            Some(_) if self.open == Some(Cause::Silent) => self.open = None,
            _ if step == Step::Restart => {
                self.clock_restarts = true;
                self.open(Cause::Reset);
            }
            _ => {}
        }
        if !is_stored {
            self.open = self.open.filter(|_| self.clock_restarts);
            return None;
        }
        let cause = self.open.take()?;
        let clock_restarts = std::mem::take(&mut self.clock_restarts);
        let rows = missing.filter(|_| !clock_restarts);
        let by_clock_s = rows.zip(rate_hz).map(|(rows, hz)| (rows as f64 + 1.0) / hz);
        Some(Gap {
            cause,
            rows,
            duration_s: by_clock_s.unwrap_or(silence_s),
            clock_restarts,
            until_end: false,
        })
    }

    /// The gap at the end: one that is open, or a silence of more than `max_silence_s`.
    pub fn at_end(&mut self, now_s: f64, max_silence_s: f64) -> Option<Gap> {
        let duration_s = now_s - self.last_row_s;
        if duration_s > max_silence_s {
            self.open(Cause::Silent);
        }
        Some(Gap {
            cause: self.open.take()?,
            rows: None,
            duration_s,
            clock_restarts: false,
            until_end: true,
        })
    }
}

/// The usual step is the median of this many, and is known by so many.
const STEPS: usize = 31;
const MIN_STEPS: usize = 3;
/// Nothing for more usual steps than this is a gap, as for the reader of recordings.
pub const GAP_STEPS: f64 = 4.5;
/// Clocks begin again here: a 32-bit counter, as it is and of µs in ms or s, and the time of day, s.
const WRAPS: [f64; 4] = [4_294_967_296.0, 4_294_967.296, 4_294.967_296, 86_400.0];
/// Two long steps in a row that differ by less than this are another rate, not two gaps.
const SAME_STEP: f64 = 0.1;

/// Follows the stamps of the board.
#[derive(Default)]
struct Clock {
    last: Option<f64>,
    steps: VecDeque<f64>,
    /// The last step that was longer than a gap.
    long: Option<f64>,
    /// Rows, and those at which the stamp changed: a stamp may stand for several rows.
    rows: u64,
    stamps: u64,
}

/// The way from one stamp to the next.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Step {
    /// There is no stamp.
    Unknown,
    /// The clock began again.
    Restart,
    /// So many rows are missing; 0 up to four usual steps.
    Missing(u64),
}

impl Clock {
    /// Takes the stamp of the next row, in any unit; NaN: it has none.
    fn next(&mut self, stamp: f64) -> Step {
        if stamp.is_nan() {
            return Step::Unknown;
        }
        let Some(last) = self.last.replace(stamp) else {
            return Step::Missing(0);
        };
        let wraps = |wrap: &f64| {
            (0.95 * wrap..*wrap).contains(&last) && (0.0..0.05 * wrap).contains(&stamp)
        };
        let wrap = WRAPS.into_iter().find(wraps).filter(|_| stamp < last);
        let step = stamp - last + wrap.unwrap_or(0.0);
        if step < 0.0 {
            self.steps.clear();
            return Step::Restart;
        }
        self.rows += 1;
        if step == 0.0 {
            return Step::Missing(0);
        }
        self.stamps += 1;
        let mut sorted: Vec<f64> = self.steps.iter().copied().collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let usual = sorted.get(sorted.len() / 2);
        let usual = usual.filter(|usual| sorted.len() >= MIN_STEPS && step > GAP_STEPS * **usual);
        let long = std::mem::replace(&mut self.long, usual.map(|_| step));
        self.steps.push_back(step);
        self.steps.drain(..self.steps.len().saturating_sub(STEPS));
        let Some(usual) = usual else {
            return Step::Missing(0);
        };
        if long.is_some_and(|long| (step / long - 1.0).abs() < SAME_STEP) {
            self.steps.drain(..self.steps.len() - 1);
            (self.rows, self.stamps) = (1, 1);
            return Step::Missing(0);
        }
        let rows_a_stamp = (self.rows as f64 / self.stamps as f64).round().max(1.0);
        Step::Missing(((step / usual).round() - 1.0).max(0.0) as u64 * rows_a_stamp as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_restarts_and_wraps() {
        let mut clock = Clock::default();
        let mut next = |stamp: f64| clock.next(stamp);
        assert_eq!(next(f64::NAN), Step::Unknown);
        for i in 0..20 {
            assert_eq!(next(10.0 * f64::from(i)), Step::Missing(0));
        }
        assert_eq!(next(230.0), Step::Missing(0));
        assert_eq!(next(330.0), Step::Missing(9));
        assert_eq!(next(10.0), Step::Restart);
        next(WRAPS[0] - 5.0);
        assert_eq!(next(5.0), Step::Missing(0));
        // Over midnight; ten rows a stamp; another rate.
        let mut clock = Clock::default();
        let mut all =
            |stamps: &[f64]| -> Vec<Step> { stamps.iter().map(|s| clock.next(*s)).collect() };
        assert_eq!(
            all(&[86_399.5, 86_399.75, 0.0, 0.25]),
            [Step::Missing(0); 4]
        );
        let mut clock = Clock::default();
        let ten = |stamp: f64| [stamp; 10];
        let stamps = [0.0, 0.1, 0.2, 0.3, 0.4, 1.5].map(ten).concat();
        let steps: Vec<Step> = stamps.iter().map(|s| clock.next(*s)).collect();
        let gaps: Vec<&Step> = steps.iter().filter(|s| **s != Step::Missing(0)).collect();
        assert_eq!(gaps, [&Step::Missing(100)]);
        let mut clock = Clock::default();
        let fast = (0..40).map(|i| 10.0 * f64::from(i));
        let slow = (1..20).map(|i| 390.0 + 60.0 * f64::from(i));
        let gaps = fast
            .chain(slow)
            .filter(|s| clock.next(*s) != Step::Missing(0))
            .count();
        assert_eq!(gaps, 1);
    }
}
