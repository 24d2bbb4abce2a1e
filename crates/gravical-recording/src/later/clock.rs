//! Times of rows after those by which a recording was judged.

use crate::finding::{Finding, FindingKind};
use crate::judge::ClockOptions;
use crate::recording::Recording;
use crate::recording::judging::{find_clock, gap_text};
use crate::role::Role;
use crate::spans::LineSpans;
use crate::text::{Batch, Format};

/// Rows before a batch with which its stamps are judged.
const TAIL_ROWS: usize = 1024;

/// The clock of a recording, carried on from batch to batch.
#[derive(Clone, Debug)]
pub(super) struct LaterClock {
    format: Format,
    pub rate_hz: Option<f64>,
    /// The last rows up to one of known time; of their columns only those of time.
    tail: Batch,
    /// Which of them has a known time, and that time, s.
    anchor: (usize, f64),
    /// Time of the last row, s; NaN where it is not known.
    pub last_s: f64,
    /// Lines of the rows before which more than four are missing, and the longest step, s.
    gaps: LineSpans,
    longest_gap_s: f64,
}

impl LaterClock {
    /// The stamps of the first rows; to be taken before they are judged.
    pub fn stamps(format: &Format, head: &Batch) -> Batch {
        let mut stamps = Batch::new(format.columns.len());
        let from = head.rows().saturating_sub(TAIL_ROWS);
        push(format, &mut stamps, head, from..head.rows());
        stamps
    }

    /// Goes on after a recording with these stamps; `None` if it has no clock.
    pub fn new(format: &Format, stamps: Batch, recording: &Recording) -> Option<Self> {
        let time_s = recording.time_s.as_ref()?;
        let known = time_s.iter().zip(&recording.lines).rev();
        let mut known = known.filter(|(t, _)| t.is_finite());
        let last = known.clone().next().map_or(0.0, |(t, _)| *t);
        let in_tail = known.find_map(|(t, line)| {
            let row = stamps.lines.binary_search(line).ok()?;
            Some((row, *t))
        });
        Some(LaterClock {
            format: format.clone(),
            rate_hz: recording.timing.rate_hz(),
            anchor: in_tail.unwrap_or((stamps.rows().saturating_sub(1), last)),
            tail: stamps,
            last_s: time_s.last().copied().unwrap_or(f64::NAN),
            gaps: LineSpans::default(),
            longest_gap_s: 0.0,
        })
    }

    /// What is said of the gaps.
    pub fn gap_finding(&self) -> Option<Finding> {
        let count = self.gaps.count() as usize;
        (count > 0).then(|| {
            let text = gap_text(count, self.longest_gap_s);
            Finding::new(FindingKind::Gap, text).at_lines(&self.gaps)
        })
    }

    /// Times of these rows of a batch since the first row of the recording, s, NaN in the others;
    /// and rows at which the clock begins again.
    pub fn times(&mut self, batch: &Batch, own: &[usize]) -> (Vec<f64>, Vec<usize>) {
        let before = self.tail.rows();
        push(&self.format, &mut self.tail, batch, own.iter().copied());
        let place = |row: &usize| before + own.partition_point(|r| r < row);
        let gaps: Vec<usize> = batch.breaks.iter().map(place).collect();
        let blanks = batch.blanks.iter().map(|b| &b.0);
        let mut pauses: Vec<usize> = batch.headers.iter().chain(blanks).map(place).collect();
        pauses.sort_unstable();
        let options = ClockOptions {
            rate_hz: self.rate_hz,
            gaps: &gaps,
            pauses: &pauses,
            ..ClockOptions::default()
        };
        let mut times_s = vec![f64::NAN; batch.rows()];
        let mut restarts = Vec::new();
        let (row, time_s) = self.anchor;
        if let Some(Ok(clock)) = find_clock(&self.format, &self.tail, options) {
            let offset_s = time_s - clock.time_s[row];
            for (k, row) in own.iter().enumerate() {
                times_s[*row] = clock.time_s[before + k] + offset_s;
            }
            let in_batch = |row: &usize| row.checked_sub(before).map(|k| own[k]);
            restarts = clock.restarts.iter().filter_map(in_batch).collect();
            for row in clock.gaps.into_iter().filter(|row| *row >= before.max(1)) {
                let step_s = clock.time_s[row] - clock.time_s[row - 1];
                self.longest_gap_s = self.longest_gap_s.max(step_s);
                self.gaps.push(u64::from(self.tail.lines[row]));
            }
        }
        if let Some(last) = own.last() {
            self.last_s = times_s[*last];
        }
        // The tail ends with a row of known time: the stamps after it tell how much later they are.
        let last = own.iter().rposition(|row| times_s[*row].is_finite());
        let end = last.map_or(before, |k| before + k + 1);
        let drop = end.saturating_sub(TAIL_ROWS);
        self.anchor = match last {
            Some(k) => (before + k - drop, times_s[own[k]]),
            None => (row.saturating_sub(drop), time_s),
        };
        self.tail.crop(drop..end);
        (times_s, restarts)
    }
}

/// Adds the stamps of rows.
fn push(
    format: &Format,
    stamps: &mut Batch,
    batch: &Batch,
    rows: impl Iterator<Item = usize> + Clone,
) {
    for (c, column) in stamps.columns.iter_mut().enumerate() {
        if matches!(format.columns[c].role, Role::Time | Role::Step) {
            column.extend(rows.clone().map(|row| batch.columns[c][row]));
        }
    }
    stamps.lines.extend(rows.map(|row| batch.lines[row]));
}
