//! Where rows are missing: by the clock of the board, and by what happened to its port.

use std::collections::VecDeque;

use gravical_judge::GAP_PERIODS;
use serde::Serialize;

/// Fewer rows than this are no gap: the reader counts them as missing.
const MIN_MISSING: u64 = 4;
/// The usual step is the median of this many, and is known by so many.
const STEPS: usize = 31;
const MIN_STEPS: usize = 3;
/// Clocks begin again here: a 32-bit counter, as it is and of µs in ms or s, and the time of day, s.
const WRAPS: [f64; 4] = [4_294_967_296.0, 4_294_967.296, 4_294.967_296, 86_400.0];

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
    /// The board sent faster than the computer took the bytes.
    Overflow,
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
    /// Bytes that the computer received and had no room for.
    pub dropped_bytes: u64,
    /// Time without a row, s: by the clock of the board, else by that of the computer.
    pub duration_s: f64,
    /// The clock of the board restarted.
    pub clock_restarts: bool,
}

impl Gap {
    /// The line of the file, without its end.
    pub fn line(&self) -> String {
        let cause = match self.cause {
            Cause::Unplugged => "unplugged",
            Cause::Reset => "the board was reset",
            Cause::Silent => "the board sent nothing",
            Cause::Lost => "rows were lost on the way from the board",
            Cause::Overflow => "the board sent faster than the computer could write",
            Cause::Continued => return "# gap: the recording was ended and continued".to_owned(),
        };
        let mut rows = match self.rows {
            Some(1) => "1 row is missing".to_owned(),
            Some(n) => format!("{n} rows are missing"),
            None => "an unknown number of rows is missing".to_owned(),
        };
        if self.dropped_bytes > 0 {
            rows += &format!(", {} bytes were dropped", self.dropped_bytes);
        }
        let clock = if self.clock_restarts {
            ", the clock of the board restarts"
        } else {
            ""
        };
        format!("# gap: {cause}: {rows}, {:.1} s{clock}", self.duration_s)
    }
}

/// The last row, and what is known of missing rows since.
#[derive(Default)]
pub struct Gaps {
    /// Why rows are missing: the first cause.
    cause: Option<Cause>,
    /// Lines that were rejected: they were rows.
    pub rejected: u64,
    dropped_bytes: u64,
    last_s: Option<f64>,
    last_stamp: Option<f64>,
    /// Steps of the clock between the last rows.
    steps: VecDeque<f64>,
}

impl Gaps {
    /// Rows are missing from here on.
    pub fn open(&mut self, cause: Cause) {
        self.cause.get_or_insert(cause);
    }

    /// Bytes were received and had no room.
    pub fn overflow(&mut self, bytes: u64) {
        self.open(Cause::Overflow);
        self.dropped_bytes += bytes;
    }

    /// The gap at the end of a recording, behind which no row is: bytes that had no room.
    pub fn at_end(&mut self, now_s: f64) -> Option<Gap> {
        let dropped_bytes = std::mem::take(&mut self.dropped_bytes);
        (dropped_bytes > 0).then(|| Gap {
            cause: self.cause.take().unwrap_or(Cause::Overflow),
            rows: None,
            dropped_bytes,
            duration_s: now_s - self.last_s.unwrap_or(now_s),
            clock_restarts: false,
        })
    }

    /// A pause ends, whose rows are not missing. Those that follow are, where the port is away.
    pub fn resume(&mut self, now_s: f64, is_plugged_in: bool) {
        let dropped = (self.dropped_bytes > 0).then_some(Cause::Overflow);
        self.cause = dropped.or((!is_plugged_in).then_some(Cause::Unplugged));
        self.last_s = Some(now_s);
        self.last_stamp = None;
    }

    /// The gap before a row that arrived at `at_s` with this stamp; without one only a silence of more
    /// than `max_silence_s` tells.
    pub fn before_row(
        &mut self,
        at_s: f64,
        stamp: Option<f64>,
        rate_hz: Option<f64>,
        max_silence_s: f64,
    ) -> Option<Gap> {
        let silence_s = at_s - self.last_s.replace(at_s).unwrap_or(at_s);
        let rejected = std::mem::take(&mut self.rejected);
        let step = stamp.and_then(|stamp| self.step_to(stamp));
        let clock_restarts = step.is_some_and(|step| step < 0.0);
        let rows = step.and_then(|step| self.missing(step));
        let rows = rows.map(|rows| rows.saturating_sub(rejected));
        let cause = match (self.cause.take(), rows) {
            (Some(cause), _) => cause,
            _ if clock_restarts => Cause::Reset,
            (_, Some(..MIN_MISSING)) => return None,
            _ if silence_s > max_silence_s => Cause::Silent,
            (_, Some(_)) => Cause::Lost,
            (_, None) => return None,
        };
        let by_clock_s = rows.zip(rate_hz).map(|(rows, hz)| (rows as f64 + 1.0) / hz);
        Some(Gap {
            cause,
            rows,
            dropped_bytes: std::mem::take(&mut self.dropped_bytes),
            duration_s: by_clock_s.unwrap_or(silence_s),
            clock_restarts,
        })
    }

    /// The step of the clock to this stamp, in its unit; negative where it restarts.
    fn step_to(&mut self, stamp: f64) -> Option<f64> {
        let last = self.last_stamp.replace(stamp)?;
        let wraps = |wrap: &f64| {
            (0.95 * wrap..*wrap).contains(&last) && (0.0..0.05 * wrap).contains(&stamp)
        };
        let wrap = WRAPS.into_iter().find(wraps);
        Some(stamp - last + wrap.unwrap_or(0.0))
    }

    /// Rows that are missing in this step; none where the usual one is not known.
    fn missing(&mut self, step: f64) -> Option<u64> {
        let mut sorted: Vec<f64> = self.steps.iter().copied().collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let usual = sorted.get(sorted.len() / 2).copied();
        // Of a stamp that stands for several rows the steps do not tell.
        let usual = usual.filter(|usual| *usual > 0.0 && sorted.len() >= MIN_STEPS);
        let steps = usual.map(|usual| step / usual);
        let is_gap = steps.is_some_and(|steps| steps > GAP_PERIODS);
        if step < 0.0 || is_gap {
            // A rate that is another one from now on is one gap.
            self.steps.clear();
        } else {
            self.steps.push_back(step);
            self.steps.drain(..self.steps.len().saturating_sub(STEPS));
        }
        let steps = steps.filter(|steps| *steps >= 0.0)?;
        Some(if is_gap { steps.round() as u64 - 1 } else { 0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows at which some are missing, or the clock restarts (none).
    fn gaps(stamps: &[f64]) -> Vec<(usize, Option<u64>)> {
        let mut gaps = Gaps::default();
        let found = stamps
            .iter()
            .map(|s| gaps.before_row(0.0, Some(*s), None, 1.0));
        let found = found.enumerate().filter_map(|(at, gap)| Some((at, gap?)));
        found.map(|(at, gap)| (at, gap.rows)).collect()
    }

    #[test]
    fn jumps_restarts_and_wraps() {
        let even =
            |from: f64| -> Vec<f64> { (0..20).map(|i| from + 10.0 * f64::from(i)).collect() };
        let jumps = [230.0, 240.0, 250.0, 260.0, 270.0, 370.0, 10.0];
        let found = gaps(&[&even(0.0)[..], &jumps].concat());
        assert_eq!(found, [(25, Some(9)), (26, None)]);
        // A counter that wraps, and midnight.
        assert_eq!(gaps(&[&even(WRAPS[0] - 195.0)[..], &[5.0]].concat()), []);
        assert_eq!(gaps(&[86_399.5, 86_399.75, 0.0, 0.25]), []);
        // Ten rows a stamp.
        let stamps = [0.0, 0.1, 0.2, 0.3, 0.4, 1.5].map(|stamp| [stamp; 10]);
        assert_eq!(gaps(&stamps.concat()), []);
    }
}
