//! Rows of a recording, read one after the other.
//!
//! [`Rows`] reads from any [`Source`], with known format and columns. It accounts for every line,
//! fills cells, converts time stamps to time, and passes every row to its [`Monitor`]. Memory
//! does not grow with the recording.

use std::collections::VecDeque;

use crate::Result;

use super::cells::{CellFiller, Channels, ZEROS_IN_A_ROW};
use super::ledger::Aside;
use super::monitor::{Facts, Monitor, RecordingClaims};
use super::row::{ACCEL, SLOTS, TIME, Values};
use super::timing::{BreakKind, RowTime, is_usual_step};

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
    /// Its label; empty for samples in memory.
    fn label(&self) -> &[u8] {
        &[]
    }
}

/// Result of one line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Item {
    /// A row of numbers.
    Row,
    /// Not a row, and the reason.
    Aside(Aside),
}

/// A row of a recording.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<'a> {
    /// Line number, from 1.
    pub line: u64,
    pub label: &'a [u8],
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
    channels: Channels,
    facts: Facts,
    monitor: Monitor,
    filler: CellFiller,
    has_rows: bool,
    /// Breaks since the last row, not yet confirmed.
    pending_breaks: Vec<Aside>,
    /// Confirmed breaks before the next row.
    before: Vec<Aside>,
    last_stamp: f64,
    held: VecDeque<Held>,
    /// Number of rows at the front of `held` that can be returned.
    released: usize,
    /// Number of zero rows up to here.
    zeros: u64,
    any_reading: bool,
    /// Zero rows that were too many to hold back may be the end of the data.
    is_unresolved: bool,
    current: Option<Held>,
    values: Values,
}

impl<S: Source> Rows<S> {
    /// Rows of `source`, read with `facts`.
    pub fn new(source: S, claims: RecordingClaims, facts: Facts) -> Self {
        let channels = claims.channels(&facts);
        Rows {
            source,
            channels,
            facts,
            monitor: Monitor::new(claims, facts),
            filler: CellFiller::new(facts.cells, channels),
            has_rows: false,
            pending_breaks: Vec::new(),
            before: Vec::new(),
            last_stamp: f64::NAN,
            held: VecDeque::new(),
            released: 0,
            zeros: 0,
            any_reading: false,
            is_unresolved: false,
            current: None,
            values: [f64::NAN; SLOTS],
        }
    }

    /// What the rows are read with.
    pub fn facts(&self) -> &Facts {
        &self.facts
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
                Some(Item::Aside(reason)) if reason.is_break() => self.break_here(reason),
                Some(Item::Aside(_)) => {}
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
                        self.is_unresolved = false;
                        break (Place::InSource, Zeros::None);
                    }
                    if let Some(zeros) = self.judge_zeros(&values, zero) {
                        break (Place::InSource, zeros);
                    }
                }
            }
        };
        self.has_rows = true;
        Ok(Some(self.hand_out(place, values, zeros)))
    }

    #[inline]
    fn hand_out(&mut self, place: Place, raw: Values, zeros: Zeros) -> Row<'_> {
        let line = match (place, &self.current) {
            (Place::Held, Some(held)) => held.line,
            _ => self.source.number(),
        };
        self.values = raw;
        self.filler.fill(&mut self.values, zeros != Zeros::None);
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
            _ => self.monitor.observe(&raw, &self.values, line, break_kind),
        };
        let (label, before) = match (place, &self.current) {
            (Place::Held, Some(held)) => (&held.label[..], &held.before),
            _ => (self.source.label(), &self.before),
        };
        Row {
            line,
            label,
            values: &self.values,
            before,
            t_s: time.t_s,
            restarted: time.restarted,
        }
    }

    /// A break needs a row before it.
    fn break_here(&mut self, reason: Aside) {
        if self.has_rows || !self.held.is_empty() {
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
            self.is_unresolved = false;
        }
        if !zero {
            self.hold(*values);
            self.released = self.held.len();
            return None;
        }
        self.zeros += 1;
        if self.is_unresolved {
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
        } else if self.held.len() > MOST_HELD {
            self.is_unresolved = true;
            self.released = self.held.len();
        }
        None
    }

    fn hold(&mut self, values: Values) {
        let held = Held {
            line: self.source.number(),
            values,
            before: std::mem::take(&mut self.before),
            label: self.source.label().to_vec(),
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
            true if self.is_unresolved => Zeros::MaybeTail,
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
                breaks.extend(held.before);
            }
            breaks.append(&mut self.pending_breaks);
            self.pending_breaks = breaks;
        }
        self.released = self.held.len();
        self.released > 0
    }

    /// The monitor of all rows so far.
    pub fn monitor(&self) -> &Monitor {
        &self.monitor
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::ReadOptions;
    use crate::recording::layout::Layout;
    use crate::recording::names::Quantity;
    use crate::recording::row::GYRO;

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
        Rows::new(Listed(list.to_vec(), 0), claims, Facts::none())
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
        assert_eq!(returned(&mut rows(&list)).len(), 50);
        list.resize(list.len() + MOST_HELD, DEAD);
        let all = returned(&mut rows(&list));
        assert_eq!(all.len(), list.len());
        assert!(all[50..].iter().all(|r| r.1 && r.2));
    }
}
