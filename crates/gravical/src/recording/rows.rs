//! Rows of a recording, read one after the other.
//!
//! [`Rows`] reads from any [`Source`], with known format and columns. It accounts for every line,
//! fills cells, converts time stamps to time, and passes every row to its [`Monitor`]. Memory
//! does not grow with the recording. All commands read recordings through it.

use std::collections::VecDeque;
use std::path::Path;

use crate::{Error, Result};

use super::cells::{CellFiller, Channels, ZEROS_IN_A_ROW};
use super::ledger::{Aside, Ledger};
use super::monitor::{Facts, Monitor, MonitorSummary, RecordingClaims};
use super::row::{ACCEL, GYRO, SLOTS, TIME, Values};
use super::timing::{BreakKind, Follower, RowTime, is_usual_step};
use crate::finding::{Finding, FindingKind, LineSpans};

/// Largest number of rows held back if memory must not grow with the recording.
const MOST_HELD: usize = 1 << 16;

/// Source of rows: lines of text, samples of a binary file, or samples in memory.
pub(crate) trait Source {
    /// The next line or sample; its numbers are written to `values`.
    ///
    /// # Errors
    ///
    /// Errors of reading.
    fn next(&mut self, values: &mut Values) -> Result<Option<Item>>;
    /// Its number, from 1.
    fn number(&self) -> u64;
    /// Text of the line, its fields and its label.
    fn text(&self) -> Text<'_> {
        Text::default()
    }
    /// Whether a line can be read without the lines before it.
    fn can_skip(&self) -> bool {
        false
    }
    /// Skips lines up to this one, if it [can](Self::can_skip).
    ///
    /// # Errors
    ///
    /// Errors of reading.
    fn skip_to(&mut self, _line: u64) -> Result<()> {
        Ok(())
    }
}

/// State needed to continue reading after a row.
#[derive(Debug, Clone)]
pub(crate) struct Mark {
    /// The line of that row.
    line: u64,
    filler: CellFiller,
    follower: Option<Follower>,
    last_stamp: f64,
}

/// Result of one line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Item {
    /// A row of numbers.
    Row,
    /// Not a row, and the reason.
    Aside(Aside),
    /// No line: rows are missing here.
    Gap,
}

/// Text of a line; empty for samples in memory.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Text<'a> {
    pub bytes: &'a [u8],
    pub label: &'a [u8],
}

/// A row of a recording.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<'a> {
    /// Line number, from 1.
    pub line: u64,
    pub text: Text<'a>,
    /// Numbers of the file, with cells filled.
    pub values: &'a Values,
    /// Lines before the row that are breaks: the row does not continue the row before. A single
    /// blank line or header is none if the clock continues across it.
    pub before: &'a [Aside],
    /// Seconds since the first row; NaN if unknown.
    pub t_s: f64,
    /// The clock restarted at this row.
    pub restarted: bool,
}

impl Row<'_> {
    /// The row does not continue the row before.
    #[inline]
    pub fn is_break(&self) -> bool {
        self.restarted || !self.before.is_empty()
    }
}

/// A row held back: only later rows show whether it was measured.
#[derive(Debug, Clone)]
struct Held {
    line: u64,
    values: Values,
    before: Vec<Aside>,
    label: Vec<u8>,
}

/// Meaning of a row in which all axes of the accelerometer are zero.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Zeros {
    /// Not all zero, or a measurement.
    None,
    /// The sensor was not read.
    Unread,
    /// Too many to hold back: a tail of zeros that may never have been measured.
    MaybeTail,
}

/// Where the current row is stored.
#[derive(Clone, Copy)]
enum Place {
    InSource,
    Held,
}

/// The rows of a recording.
pub(crate) struct Rows<S> {
    source: S,
    name: String,
    channels: Channels,
    facts: Facts,
    monitor: Monitor,
    filler: CellFiller,
    ledger: Ledger,
    /// Breaks since the last row, not yet confirmed.
    pending_breaks: Vec<Aside>,
    /// Confirmed breaks before the next row.
    before: Vec<Aside>,
    last_stamp: f64,
    held: VecDeque<Held>,
    /// Number of rows at the front of `held` that can be returned.
    released: usize,
    most_held: usize,
    /// Number of zero rows up to here.
    zeros: u64,
    any_reading: bool,
    /// Lines of zero rows that were too many to hold back and may be the end of the data.
    unresolved: LineSpans,
    /// The line from which all rows are zero, if known.
    zeros_from: Option<u64>,
    /// Results of all rows are known from an earlier reading.
    times_known: bool,
    current: Option<Held>,
    values: Values,
    expected: usize,
}

/// Results, available after the last row.
pub(crate) struct Finished {
    pub ledger: Ledger,
    /// Of all rows, whatever facts they were read with.
    pub summary: MonitorSummary,
    /// About rows of zeros.
    pub zeros: Vec<Finding>,
    /// The line from which all rows are zero, if they were too many to hold back and count as
    /// rows.
    pub zeros_from: Option<u64>,
}

impl Finished {
    /// Results of the rows so far, of which more may follow: without the account of lines.
    pub fn so_far(monitor: &Monitor) -> Self {
        Finished {
            ledger: Ledger::default(),
            summary: monitor.finish_with_resolution(),
            zeros: Vec::new(),
            zeros_from: None,
        }
    }

    /// Findings about cells and time stamps, then about units and samples.
    pub fn findings(&mut self) -> Vec<Finding> {
        let found = std::mem::take(&mut self.summary.found);
        let mut all = found.channels;
        all.extend(found.clock);
        all.extend(found.cells);
        all.append(&mut self.zeros);
        all.extend(found.unit);
        all.extend(found.values);
        all
    }
}

impl<S: Source> Rows<S> {
    /// Rows of `source`, read with `facts`; `name` is used in messages.
    pub fn new(source: S, name: &str, claims: RecordingClaims, facts: Facts) -> Self {
        let channels = claims.channels(&facts);
        Rows {
            source,
            name: name.to_owned(),
            channels,
            facts,
            monitor: Monitor::new(claims, facts),
            filler: CellFiller::new(facts.cells, channels),
            ledger: Ledger::default(),
            pending_breaks: Vec::new(),
            before: Vec::new(),
            last_stamp: f64::NAN,
            held: VecDeque::new(),
            released: 0,
            most_held: MOST_HELD,
            zeros: 0,
            any_reading: false,
            unresolved: LineSpans::default(),
            zeros_from: None,
            times_known: false,
            current: None,
            values: [f64::NAN; SLOTS],
            expected: 0,
        }
    }

    /// Sets about how many rows there are, to make room for them.
    pub fn expecting(mut self, rows: usize) -> Self {
        self.expected = rows;
        self
    }

    /// About how many rows there are; 0 if nothing tells.
    pub fn expected(&self) -> usize {
        self.expected
    }

    /// Sets the largest number of rows held back.
    pub fn hold_at_most(&mut self, rows: usize) {
        self.most_held = rows;
    }

    /// Restores the default limit of rows held back.
    pub fn hold_default(&mut self) {
        self.hold_at_most(MOST_HELD);
    }

    /// Zero rows from this line on continue to the end.
    pub fn with_zeros_from(mut self, line: Option<u64>) -> Self {
        self.zeros_from = line;
        self
    }

    /// Results of all rows are known already; only the time of each row is computed.
    pub fn times_only(mut self) -> Self {
        self.times_known = true;
        self
    }

    /// What the rows are read with.
    pub fn facts(&self) -> &Facts {
        &self.facts
    }

    pub fn source(&self) -> &S {
        &self.source
    }

    /// The next row; `None` after the last.
    ///
    /// # Errors
    ///
    /// Errors of reading.
    #[inline]
    pub fn next_row(&mut self) -> Result<Option<Row<'_>>> {
        let mut values: Values = [f64::NAN; SLOTS];
        let (place, zeros) = loop {
            if self.released > 0 {
                match self.release_one(&mut values) {
                    Some(zeros) => break (Place::Held, zeros),
                    None => continue,
                }
            }
            match self.source.next(&mut values)? {
                None => {
                    if !self.release_at_end() {
                        return Ok(None);
                    }
                }
                Some(Item::Aside(reason)) => self.set_aside(reason),
                Some(Item::Gap) => self.break_here(Aside::NamedGap),
                Some(Item::Row) => {
                    if !self.pending_breaks.is_empty() {
                        self.confirm_breaks(values[TIME]);
                    } else if !self.before.is_empty() {
                        self.before.clear();
                    }
                    if values[TIME].is_finite() {
                        self.last_stamp = values[TIME];
                    }
                    let zero = values[ACCEL] == 0.0 && self.channels.accel_is_zero(&values);
                    if !zero && self.held.is_empty() {
                        self.zeros = 0;
                        self.any_reading = true;
                        if !self.unresolved.is_empty() {
                            self.unresolved = LineSpans::default();
                        }
                        break (Place::InSource, Zeros::None);
                    }
                    if let Some(zeros) = self.judge_zeros(&values, zero) {
                        break (Place::InSource, zeros);
                    }
                }
            }
        };
        self.ledger.row();
        Ok(Some(self.hand_out(place, values, zeros)))
    }

    #[inline]
    fn hand_out(&mut self, place: Place, raw: Values, zeros: Zeros) -> Row<'_> {
        let line = match (place, &self.current) {
            (Place::Held, Some(held)) => held.line,
            _ => self.source.number(),
        };
        self.values = raw;
        self.filler
            .fill(&mut self.values, zeros != Zeros::None, line);
        let before = match (place, &self.current) {
            (Place::Held, Some(held)) => &held.before,
            _ => &self.before,
        };
        let break_kind = before
            .iter()
            .filter_map(|reason| BreakKind::of(*reason))
            .max();
        // A row that may not be a measurement must not affect the clock and the units.
        let time = match zeros {
            Zeros::MaybeTail => RowTime::UNKNOWN,
            _ if self.times_known => self.monitor.observe_time(&raw, line, break_kind),
            _ => self.monitor.observe(&raw, &self.values, line, break_kind),
        };
        let (text, before) = match (place, &self.current) {
            (Place::Held, Some(held)) => (
                Text {
                    bytes: &[],
                    label: &held.label,
                },
                &held.before,
            ),
            _ => (self.source.text(), &self.before),
        };
        Row {
            line,
            text,
            values: &self.values,
            before,
            t_s: time.t_s,
            restarted: time.restarted,
        }
    }

    #[cold]
    fn set_aside(&mut self, reason: Aside) {
        if reason.is_break() {
            self.break_here(reason);
        }
        self.ledger
            .aside(reason, self.source.number(), self.source.text().bytes);
    }

    /// A break needs a row before it.
    fn break_here(&mut self, reason: Aside) {
        if self.ledger.rows > 0 || !self.held.is_empty() {
            self.pending_breaks.push(reason);
        }
    }

    /// A single blank line or header between rows is no break if the clock continues across it;
    /// `stamp` is the time stamp of the next row. Several consecutive blank lines are deliberate.
    #[cold]
    fn confirm_breaks(&mut self, stamp: f64) {
        self.before = std::mem::take(&mut self.pending_breaks);
        let two = |w: &[Aside]| w == [Aside::Blank; 2];
        let deliberate = self.before.windows(2).any(two) || self.before.contains(&Aside::NamedGap);
        let usual = self.facts.stamp_reading.map_or(f64::NAN, |b| b.usual);
        if !deliberate && is_usual_step(stamp - self.last_stamp, usual) {
            self.before.clear();
        }
    }

    /// Handles a row in which the accelerometer reads zero, or that follows such rows. `None` if
    /// it is held back, otherwise the meaning of its zeros.
    #[cold]
    fn judge_zeros(&mut self, values: &Values, zero: bool) -> Option<Zeros> {
        let may_be_tail = zero && self.channels.gyro_is_zero(values);
        if !may_be_tail {
            // The zeros before it were not at the end.
            self.unresolved = LineSpans::default();
        }
        if !zero {
            self.hold(*values);
            self.released = self.held.len();
            return None;
        }
        let number = self.source.number();
        if may_be_tail && self.zeros_from.is_some_and(|from| number >= from) {
            let text = self.source.text();
            self.ledger.aside(Aside::ZeroTail, number, text.bytes);
            return None;
        }
        self.zeros += 1;
        if !self.unresolved.is_empty() {
            self.unresolved.push(self.source.number());
            return Some(Zeros::MaybeTail);
        }
        if may_be_tail && !self.any_reading {
            // Zeros from the first row on.
            return Some(Zeros::Unread);
        }
        let enough = self.zeros >= ZEROS_IN_A_ROW;
        self.any_reading = true;
        if !may_be_tail && enough && self.held.is_empty() {
            return Some(Zeros::Unread);
        }
        self.hold(*values);
        if !may_be_tail && enough {
            self.released = self.held.len();
        } else if self.held.len() > self.most_held {
            let lines = self.held.iter().map(|held| held.line);
            lines.for_each(|line| self.unresolved.push(line));
            self.released = self.held.len();
        }
        None
    }

    fn hold(&mut self, values: Values) {
        let held = Held {
            line: self.source.number(),
            values,
            before: std::mem::take(&mut self.before),
            label: self.source.text().label.to_vec(),
        };
        self.held.push_back(held);
    }

    /// Releases a row that was held back, with the meaning of its zeros.
    #[cold]
    fn release_one(&mut self, values: &mut Values) -> Option<Zeros> {
        self.released = self.released.saturating_sub(1);
        let held = self.held.pop_front()?;
        *values = held.values;
        let zero = self.channels.accel_is_zero(values);
        let unread = self.zeros >= ZEROS_IN_A_ROW || self.channels.gyro_is_zero(values);
        if !zero {
            self.zeros = 0;
            self.any_reading = true;
        }
        self.current = Some(held);
        Some(match zero {
            true if !self.unresolved.is_empty() => Zeros::MaybeTail,
            true if unread => Zeros::Unread,
            _ => Zeros::None,
        })
    }

    /// Two or more rows of zeros at the end are not rows. True if other rows that were held back
    /// can be returned.
    #[cold]
    fn release_at_end(&mut self) -> bool {
        let is_tail = |held: &Held| {
            self.channels.accel_is_zero(&held.values) && self.channels.gyro_is_zero(&held.values)
        };
        let tail = self.held.iter().rev().take_while(|h| is_tail(h)).count();
        if tail >= 2 {
            let mut breaks = Vec::new();
            for held in self.held.split_off(self.held.len() - tail) {
                self.ledger.aside(Aside::ZeroTail, held.line, b"");
                breaks.extend(held.before);
            }
            breaks.append(&mut self.pending_breaks);
            self.pending_breaks = breaks;
        }
        self.released = self.held.len();
        self.released > 0
    }

    /// State to continue from the last returned row; `None` if the following rows depend on more
    /// than it.
    pub fn mark(&self) -> Option<Mark> {
        let plain = self.held.is_empty() && self.pending_breaks.is_empty() && self.zeros == 0;
        // Evenly timed samples depend on the row count.
        let counted = self
            .facts
            .stamp_reading
            .is_some_and(|s| s.even_hz.is_some());
        (plain && !counted && self.any_reading && self.source.can_skip()).then(|| Mark {
            line: self.source.number(),
            filler: self.filler.without_findings(),
            follower: self.monitor.follower(),
            last_stamp: self.last_stamp,
        })
    }

    /// Continues after the row of `mark`, which must lie ahead; only for rows that are [known
    /// already](Self::times_only).
    ///
    /// # Errors
    ///
    /// Errors of reading.
    pub fn skip_to(&mut self, mark: &Mark) -> Result<()> {
        self.source.skip_to(mark.line)?;
        self.filler = mark.filler.clone();
        self.monitor.follow(mark.follower.clone());
        self.last_stamp = mark.last_stamp;
        (self.zeros, self.any_reading) = (0, true);
        self.pending_breaks.clear();
        self.before.clear();
        Ok(())
    }

    /// The monitor of all rows so far.
    pub fn monitor(&self) -> &Monitor {
        &self.monitor
    }

    /// Results; to be called after the last row.
    ///
    /// # Errors
    ///
    /// `no-rows`, `no-values`, `all-zero` if the sensor delivered no data.
    pub fn finish(&mut self) -> Result<Finished> {
        self.check_for_values()?;
        let mut zeros = Vec::new();
        if !self.unresolved.is_empty() {
            zeros.push(
                Finding::new(
                    FindingKind::ZeroRows,
                    format!(
                        "all channels are zero in the last {} rows: too many to hold in memory, so they count as rows",
                        self.unresolved.count()
                    ),
                )
                .at_lines(&self.unresolved),
            );
        }
        zeros.extend(self.filler.finding());
        Ok(Finished {
            ledger: std::mem::take(&mut self.ledger),
            summary: self.monitor.finish_with_resolution(),
            zeros,
            zeros_from: self.unresolved.first(),
        })
    }

    fn check_for_values(&self) -> Result<()> {
        let here = Path::new(&self.name);
        let cells = self.monitor.cells();
        let rows = cells.rows();
        if rows == 0 {
            return Err(
                Error::input("no-rows", format!("no row could be read: {}", self.ledger.sum()))
                    .at(here, None)
                    .with_hint("a recording is a table of text: one sample a line, its values separated by comma, semicolon, tab or spaces; --columns assigns the columns"),
            );
        }
        let (first, letter, sensor) = match self.channels.accel {
            true => (ACCEL, "a", "accelerometer"),
            false => (GYRO, "g", "gyroscope"),
        };
        if let Some(axis) = cells.axis_without_values(first) {
            return Err(Error::input(
                "no-values",
                format!(
                    "{letter}{} has no value in any of the {rows} rows (empty or NaN)",
                    ["x", "y", "z"][axis]
                ),
            )
            .at(here, None)
            .with_hint(
                "look at the columns with `gravical inspect`, or choose others with --columns",
            ));
        }
        if cells.is_all_zero(first) {
            let hint = match self.channels.accel {
                true => "check the wiring (SDA, SCL, power) and that the sketch wakes the sensor",
                false => "check that the sketch wakes the gyroscope, or leave --gyro out",
            };
            return Err(Error::input(
                "all-zero",
                format!("the {sensor} reads zero or nothing in all {rows} rows: it did not answer"),
            )
            .at(here, None)
            .with_hint(hint));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::ReadOptions;
    use crate::recording::cells::CellRules;
    use crate::recording::layout::Layout;
    use crate::recording::names::Quantity;

    /// Rows of ax, ay, az, gx, gy, gz.
    struct Listed(Vec<[f64; 6]>, usize);

    impl Source for Listed {
        fn next(&mut self, values: &mut Values) -> Result<Option<Item>> {
            let Some(row) = self.0.get(self.1) else {
                return Ok(None);
            };
            values[ACCEL..ACCEL + 6].copy_from_slice(row);
            self.1 += 1;
            Ok(Some(Item::Row))
        }

        fn number(&self) -> u64 {
            self.1 as u64
        }
    }

    fn rows(list: &[[f64; 6]]) -> Rows<Listed> {
        let accel = (0..3).map(|i| (Quantity::Accel(i), i));
        let gyro = (0..3).map(|i| (Quantity::Gyro(i), 3 + i));
        let claims = RecordingClaims {
            layout: Layout {
                fields: accel.chain(gyro).collect(),
                ..Layout::default()
            },
            options: ReadOptions::default(),
            metadata_rate_hz: None,
        };
        Rows::new(Listed(list.to_vec(), 0), "", claims, Facts::none())
    }

    const STILL: [f64; 6] = [0.1, 0.2, 9.8, 0.01, 0.0, 0.02];
    const DEAD: [f64; 6] = [0.0; 6];
    const UNREAD: [f64; 6] = [0.0, 0.0, 0.0, 0.01, 0.0, 0.02];

    /// Line of each returned row, and whether accelerometer and gyroscope are empty.
    fn returned(rows: &mut Rows<Listed>) -> Vec<(u64, bool, bool)> {
        let mut out = Vec::new();
        while let Some(row) = rows.next_row().unwrap() {
            out.push((
                row.line,
                row.values[ACCEL].is_nan(),
                row.values[GYRO].is_nan(),
            ));
        }
        out
    }

    #[test]
    fn few_zeros_are_values_if_the_gyroscope_reads() {
        let list = [STILL, UNREAD, UNREAD, STILL];
        assert!(returned(&mut rows(&list)).iter().all(|r| !r.1 && !r.2));
        let mut list = vec![STILL; 20];
        list[5..12].fill(UNREAD);
        let all = returned(&mut rows(&list));
        let empty: Vec<u64> = all.iter().filter(|r| r.1).map(|r| r.0).collect();
        assert_eq!(empty, [6, 7, 8, 9, 10, 11, 12]);
        assert!(all.iter().all(|r| !r.2) && all.is_sorted());
        // At the end the rows with a gyroscope reading stay.
        let list = [STILL, STILL, UNREAD, DEAD, DEAD];
        assert_eq!(returned(&mut rows(&list)).len(), 3);
    }

    #[test]
    fn a_zero_tail_too_long_to_hold_back_counts_as_empty_rows() {
        let mut list = vec![STILL; 50];
        list.extend([DEAD; 40]);
        let mut some = rows(&list);
        some.hold_at_most(10);
        let all = returned(&mut some);
        assert_eq!(all.len(), 90);
        assert!(all[50..].iter().all(|r| r.1 && r.2));
        let done = some.finish().unwrap();
        // They do not count as half of the rows, which would make zero a valid reading.
        assert!(done.summary.facts.cells == CellRules::default());
        let tail = done.zeros.iter().find(|f| f.kind == "zero-rows").unwrap();
        assert_eq!((tail.count, &tail.lines[..]), (40, &[[51, 90]][..]));
        // With all rows in memory there is no limit.
        let mut some = rows(&list);
        some.hold_at_most(usize::MAX);
        assert_eq!(returned(&mut some).len(), 50);
        // They are no tail if the gyroscope reads.
        list[70] = UNREAD;
        let mut some = rows(&list);
        some.hold_at_most(10);
        assert_eq!(returned(&mut some).len(), 90);
        let done = some.finish().unwrap();
        let tail = done.zeros.iter().find(|f| f.kind == "zero-rows").unwrap();
        assert_eq!(tail.lines, [[72, 90]]);
        // A later row ends the tail.
        list.push(STILL);
        let mut some = rows(&list);
        some.hold_at_most(10);
        assert_eq!(returned(&mut some).len(), 91);
        let done = some.finish().unwrap();
        assert!(!done.zeros.iter().any(|f| f.message.contains("too many")));
    }
}
