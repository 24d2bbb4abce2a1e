//! Rows of a recording, one after the other, whatever they come from.
//!
//! [`Rows`] is the one way in: it knows how a file is written and which column is which,
//! accounts for every line, fills cells, makes time of stamps, and has its [`Monitor`] see
//! every row. Memory is flat. What commands do with a recording is a fold over it.

use std::collections::VecDeque;
use std::path::Path;

use crate::{Error, Result};

use super::cells::{CellFiller, Channels, ZEROS_IN_A_ROW};
use super::ledger::{Aside, Ledger};
use super::monitor::{Facts, Monitor, MonitorFindings, RecordingClaims};
use super::row::{ACCEL, GYRO, SLOTS, Span, TIME, Values};
use super::timing::{Follower, Parting, RowTime, Timing, Treatment, is_usual_step};
use super::unit_choice::UnitDoubt;
use crate::finding::{Finding, FindingKind, LineSpans};

/// Rows that are held back at most, where memory is to be flat.
const MOST_HELD: usize = 1 << 16;

/// What rows come from: lines of text, or samples in memory.
pub(crate) trait Source {
    /// The next line or sample, whose numbers go to `values`.
    ///
    /// # Errors
    ///
    /// What reading reports.
    fn next(&mut self, values: &mut Values) -> Result<Option<Item>>;
    /// Its number, from 1.
    fn number(&self) -> u64;
    /// Its text, where the fields of it are, and its label.
    fn text(&self) -> Text<'_> {
        Text::default()
    }
    /// Whether a line may be read without those before it.
    fn can_skip(&self) -> bool {
        false
    }
    /// Passes over lines up to this one, where it [can](Self::can_skip).
    ///
    /// # Errors
    ///
    /// What reading reports.
    fn skip_to(&mut self, _line: u64) -> Result<()> {
        Ok(())
    }
}

/// What reading goes on by after a row.
#[derive(Debug, Clone)]
pub(crate) struct Mark {
    /// The line of that row.
    line: u64,
    filler: CellFiller,
    follower: Option<Follower>,
    last_stamp: f64,
}

/// What a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Item {
    /// A row of numbers.
    Row,
    /// None, and why.
    Aside(Aside),
}

/// The text of a line; empty where there is none.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Text<'a> {
    pub bytes: &'a [u8],
    /// Of every field, where they are asked for.
    pub spans: &'a [Span],
    pub label: &'a [u8],
}

/// A row of a recording.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<'a> {
    /// The line it stands in, from 1.
    pub line: u64,
    pub text: Text<'a>,
    /// As they stand in the file, cells filled.
    pub values: &'a Values,
    /// Lines that part it from the row before: no sample follows its predecessor across
    /// them. A single blank line and a header are none where the clock goes on.
    pub before: &'a [Aside],
    /// Seconds from the first row; NaN where it is not known.
    pub t_s: f64,
    /// The clock started anew.
    pub restarted: bool,
}

impl Row<'_> {
    /// It does not follow the row before.
    #[inline]
    pub fn parts(&self) -> bool {
        self.restarted || !self.before.is_empty()
    }
}

/// A row that is held back: only what comes after it tells whether it was measured.
#[derive(Debug, Clone)]
struct Held {
    line: u64,
    values: Values,
    before: Vec<Aside>,
    bytes: Vec<u8>,
    spans: Vec<Span>,
    label: Vec<u8>,
}

/// What zeros on all axes of the accelerometer are.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Zeros {
    /// There are none, or they were measured.
    None,
    /// The sensor was not read.
    Unread,
    /// They were too many to hold back: nobody knows whether they were ever written.
    MaybeTail,
}

/// Where the row that is handed out stands.
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
    /// Lines since the last row that part rows.
    parts: Vec<Aside>,
    /// … those of them that do.
    before: Vec<Aside>,
    last_stamp: f64,
    held: VecDeque<Held>,
    /// Rows at the front of them that are handed out.
    released: usize,
    most_held: usize,
    /// Rows up to here in which the accelerometer reads zero.
    zeros: u64,
    any_reading: bool,
    /// Rows of zeros at what may be the end that were too many to hold back.
    given_up: LineSpans,
    /// Zeros to the end may well have been measured.
    keeps_zeros: bool,
    /// The line from which on there are but zeros, where that is known.
    zeros_from: Option<u64>,
    /// What the rows say is known.
    known: bool,
    current: Option<Held>,
    values: Values,
}

/// What was found out, after the last row.
pub(crate) struct Finished {
    pub ledger: Ledger,
    /// What all rows say, whatever they were read by.
    pub facts: Facts,
    pub timing: Timing,
    /// The first stamp itself, s.
    pub origin_s: Option<f64>,
    /// Why the accelerometer's unit is not known.
    pub unit_doubt: Option<UnitDoubt>,
    pub found: MonitorFindings,
    /// About rows of zeros.
    pub zeros: Vec<Finding>,
    /// Lines after the last row that part rows.
    pub trailing: Vec<Aside>,
    /// The line from which on there are but zeros: too many to hold back, so that they
    /// count as rows.
    pub zeros_from: Option<u64>,
}

impl Finished {
    /// What is said about cells and stamps, then about units and samples.
    pub fn findings(&mut self) -> Vec<Finding> {
        let found = std::mem::take(&mut self.found);
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
    /// Rows of `source`, which `name` stands for in messages, read by `facts`.
    pub fn new(source: S, name: &str, claims: RecordingClaims, facts: Facts) -> Self {
        let channels = claims.channels();
        Rows {
            source,
            name: name.to_owned(),
            channels,
            facts,
            monitor: Monitor::new(claims, facts),
            filler: CellFiller::new(facts.cells, channels),
            ledger: Ledger::default(),
            parts: Vec::new(),
            before: Vec::new(),
            last_stamp: f64::NAN,
            held: VecDeque::new(),
            released: 0,
            most_held: MOST_HELD,
            zeros: 0,
            any_reading: false,
            given_up: LineSpans::default(),
            keeps_zeros: false,
            zeros_from: None,
            known: false,
            current: None,
            values: [f64::NAN; SLOTS],
        }
    }

    /// Rows of zeros at the end are rows: at rest a gyroscope may well read so.
    pub fn keeping_zeros(mut self) -> Self {
        self.keeps_zeros = true;
        self
    }

    /// Rows of zeros at the end are none, however many: for those who keep all rows.
    pub fn holding_any_number(mut self) -> Self {
        self.most_held = usize::MAX;
        self
    }

    /// So many rows are held back at most.
    pub fn hold_at_most(&mut self, rows: usize) {
        self.most_held = rows;
    }

    /// So many at most, where memory is to be flat.
    pub fn hold_few(&mut self) {
        self.hold_at_most(MOST_HELD);
    }

    /// Zeros from this line on are known to go on to the end.
    pub fn with_zeros_from(mut self, line: Option<u64>) -> Self {
        self.zeros_from = line;
        self
    }

    /// What rows say is known already: of each its time is needed and nothing else.
    pub fn known_already(mut self) -> Self {
        self.known = true;
        self
    }

    /// What they are read by.
    pub fn facts(&self) -> &Facts {
        &self.facts
    }

    pub fn source(&self) -> &S {
        &self.source
    }

    pub fn source_mut(&mut self) -> &mut S {
        &mut self.source
    }

    /// The next row; none after the last.
    ///
    /// # Errors
    ///
    /// What reading reports.
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
                Some(Item::Row) => {
                    if !self.parts.is_empty() {
                        self.settle_parts(values[TIME]);
                    } else if !self.before.is_empty() {
                        self.before.clear();
                    }
                    if values[TIME].is_finite() {
                        self.last_stamp = values[TIME];
                    }
                    let zero = values[ACCEL] == 0.0
                        && !self.keeps_zeros
                        && self.channels.accel_is_zero(&values);
                    if !zero && self.held.is_empty() {
                        self.zeros = 0;
                        self.any_reading = true;
                        if !self.given_up.is_empty() {
                            self.given_up = LineSpans::default();
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
        let parting = before
            .iter()
            .filter_map(|reason| Parting::by(*reason))
            .max();
        // What may never have been measured says nothing of clock and units.
        let time = match zeros {
            Zeros::MaybeTail => RowTime::UNKNOWN,
            _ if self.known => self.monitor.see_time(&raw, line, parting),
            _ => self.monitor.see(&raw, &self.values, line, parting),
        };
        let (text, before) = match (place, &self.current) {
            (Place::Held, Some(held)) => (
                Text {
                    bytes: &held.bytes,
                    spans: &held.spans,
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
        // Before the first row there is nothing to part.
        if reason.parts() && (self.ledger.rows > 0 || !self.held.is_empty()) {
            self.parts.push(reason);
        }
        self.ledger
            .aside(reason, self.source.number(), self.source.text().bytes);
    }

    /// A blank line or a header between rows parts nothing where the clock goes on across
    /// it; `stamp` is that of the next row. Several blank lines in a row are deliberate.
    #[cold]
    fn settle_parts(&mut self, stamp: f64) {
        self.before = std::mem::take(&mut self.parts);
        let two = |w: &[Aside]| w == [Aside::Blank; 2];
        let deliberate = self.before.windows(2).any(two) || self.before.contains(&Aside::NamedGap);
        let usual = self.facts.stamp_reading.map_or(f64::NAN, |b| b.usual);
        if !deliberate && is_usual_step(stamp - self.last_stamp, usual) {
            self.before.clear();
        }
    }

    /// A row in which the accelerometer reads zero, or that follows such rows. It is held
    /// back, or else: what its zeros are.
    #[cold]
    fn judge_zeros(&mut self, values: &Values, zero: bool) -> Option<Zeros> {
        let may_be_tail = zero && self.channels.gyro_is_zero(values);
        if !may_be_tail {
            // Those before it are no tail.
            self.given_up = LineSpans::default();
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
        if !self.given_up.is_empty() {
            self.given_up.push(self.source.number());
            return Some(Zeros::MaybeTail);
        }
        if may_be_tail && !self.any_reading {
            // From the very start.
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
            lines.for_each(|line| self.given_up.push(line));
            self.released = self.held.len();
        }
        None
    }

    fn hold(&mut self, values: Values) {
        let text = self.source.text();
        // Who asks for no fields asks for no text: a long tail is held by its numbers.
        let bytes = match text.spans {
            [] => &[],
            _ => text.bytes,
        };
        let held = Held {
            line: self.source.number(),
            values,
            before: std::mem::take(&mut self.before),
            bytes: bytes.to_vec(),
            spans: text.spans.to_vec(),
            label: text.label.to_vec(),
        };
        self.held.push_back(held);
    }

    /// Hands out a row that was held back, and says what its zeros are.
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
            true if !self.given_up.is_empty() => Zeros::MaybeTail,
            true if unread => Zeros::Unread,
            _ => Zeros::None,
        })
    }

    /// Rows of zeros up to the end were never written by the sensor, where there are
    /// several; true where some that were held back are rows after all.
    #[cold]
    fn release_at_end(&mut self) -> bool {
        let is_tail = |held: &Held| {
            self.channels.accel_is_zero(&held.values) && self.channels.gyro_is_zero(&held.values)
        };
        let tail = self.held.iter().rev().take_while(|h| is_tail(h)).count();
        if tail >= 2 {
            let mut parts = Vec::new();
            for held in self.held.split_off(self.held.len() - tail) {
                self.ledger.aside(Aside::ZeroTail, held.line, &held.bytes);
                parts.extend(held.before);
            }
            parts.append(&mut self.parts);
            self.parts = parts;
        }
        self.released = self.held.len();
        self.released > 0
    }

    /// To go on from the row that was given last; none where what comes next depends on
    /// more.
    pub fn mark(&self) -> Option<Mark> {
        let plain = self.held.is_empty() && self.parts.is_empty() && self.zeros == 0;
        // Even samples are counted.
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

    /// Goes on after the row of a mark, which lies ahead; of rows that are
    /// [known already](Self::known_already).
    ///
    /// # Errors
    ///
    /// What reading reports.
    pub fn skip_to(&mut self, mark: &Mark) -> Result<()> {
        self.source.skip_to(mark.line)?;
        self.filler = mark.filler.clone();
        self.monitor.follow(mark.follower.clone());
        self.last_stamp = mark.last_stamp;
        (self.zeros, self.any_reading) = (0, true);
        self.parts.clear();
        self.before.clear();
        Ok(())
    }

    /// What has seen all rows so far.
    pub fn monitor(&self) -> &Monitor {
        &self.monitor
    }

    /// What was found out; to be asked after the last row.
    ///
    /// # Errors
    ///
    /// `no-rows`, `no-values`, `all-zero` where the sensor that is read said nothing.
    pub fn finish(&mut self, treatment: Treatment) -> Result<Finished> {
        self.refuse_silence()?;
        let seen = self.monitor.finish(treatment);
        let mut found = seen.found;
        if treatment == Treatment::Kept {
            self.monitor.keep_stamps(&mut found.clock);
        }
        let mut zeros = Vec::new();
        if !self.given_up.is_empty() {
            zeros.push(
                Finding::new(
                    FindingKind::ZeroTail,
                    format!(
                        "all channels are zero in the last {} rows: too many to hold back, so they count as rows",
                        self.given_up.count()
                    ),
                )
                .at_lines(&self.given_up),
            );
        }
        zeros.extend(self.filler.finding());
        Ok(Finished {
            ledger: std::mem::take(&mut self.ledger),
            facts: Facts {
                resolution: self.monitor.resolution(),
                ..seen.facts
            },
            timing: seen.timing,
            origin_s: seen.origin_s,
            unit_doubt: seen.unit_doubt,
            found,
            zeros,
            trailing: std::mem::take(&mut self.parts),
            zeros_from: self.given_up.first(),
        })
    }

    fn refuse_silence(&self) -> Result<()> {
        let here = Path::new(&self.name);
        let cells = self.monitor.cells();
        let rows = cells.rows();
        if rows == 0 {
            return Err(
                Error::input("no-rows", format!("no row could be read: {}", self.ledger.sum()))
                    .at(here, None)
                    .with_hint("a recording is a table of text: one sample a line, its values separated by comma, semicolon, tab or spaces; --columns says which column is which"),
            );
        }
        let (first, letter, sensor) = match self.keeps_zeros {
            false => (ACCEL, "a", "accelerometer"),
            true => (GYRO, "g", "gyroscope"),
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
            let hint = match self.keeps_zeros {
                false => "check the wiring (SDA, SCL, power) and that the sketch wakes the sensor",
                true => "check that the sketch wakes the gyroscope, or leave --gyro out",
            };
            return Err(Error::input(
                "all-zero",
                format!("the {sensor} reads zero in all {rows} rows: it did not answer"),
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

    /// For each row that is given: its line, and whether accelerometer and gyroscope are
    /// empty.
    fn given(rows: &mut Rows<Listed>) -> Vec<(u64, bool, bool)> {
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
    fn zeros_among_the_rows_are_empty_and_at_the_end_no_rows() {
        let list = [STILL, DEAD, STILL, STILL, DEAD, DEAD, DEAD];
        let mut some = rows(&list);
        let expected = [
            (1, false, false),
            (2, true, true),
            (3, false, false),
            (4, false, false),
        ];
        assert_eq!(given(&mut some), expected);
        let done = some.finish(Treatment::Repaired).unwrap();
        assert_eq!((done.ledger.lines, done.ledger.rows), (7, 4));
        assert_eq!(done.ledger.lines_aside(Aside::ZeroTail).count(), 3);
        // One row alone can be a measurement, of a sensor that was not read.
        assert_eq!(given(&mut rows(&[STILL, STILL, DEAD]))[2], (3, true, true));
    }

    #[test]
    fn beside_a_gyroscope_that_reads_few_zeros_are_chance() {
        let list = [STILL, UNREAD, UNREAD, STILL];
        assert!(given(&mut rows(&list)).iter().all(|r| !r.1 && !r.2));
        let mut list = vec![STILL; 20];
        list[5..12].fill(UNREAD);
        let all = given(&mut rows(&list));
        let empty: Vec<u64> = all.iter().filter(|r| r.1).map(|r| r.0).collect();
        assert_eq!(empty, [6, 7, 8, 9, 10, 11, 12]);
        assert!(all.iter().all(|r| !r.2) && all.is_sorted());
        // At the end those that were read stay, the others go.
        let list = [STILL, STILL, UNREAD, DEAD, DEAD];
        assert_eq!(given(&mut rows(&list)).len(), 3);
    }

    #[test]
    fn a_tail_too_long_to_hold_back_counts_as_rows_that_are_empty() {
        let mut list = vec![STILL; 50];
        list.extend([DEAD; 40]);
        let mut some = rows(&list);
        some.hold_at_most(10);
        let all = given(&mut some);
        assert_eq!(all.len(), 90);
        assert!(all[50..].iter().all(|r| r.1 && r.2));
        let done = some.finish(Treatment::Kept).unwrap();
        // They are no half of the rows, which would make zeros a reading.
        assert!(done.facts.cells == CellRules::default());
        let tail = done.zeros.iter().find(|f| f.kind == "zero-tail").unwrap();
        assert_eq!((tail.count, &tail.lines[..]), (40, &[[51, 90]][..]));
        // Those who keep all rows hold any number.
        assert_eq!(given(&mut rows(&list).holding_any_number()).len(), 50);
        // Where the gyroscope reads they are no tail.
        list[70] = UNREAD;
        let mut some = rows(&list);
        some.hold_at_most(10);
        assert_eq!(given(&mut some).len(), 90);
        let done = some.finish(Treatment::Kept).unwrap();
        let tail = done.zeros.iter().find(|f| f.kind == "zero-tail").unwrap();
        assert_eq!(tail.lines, [[72, 90]]);
        // Rows that come after all end it.
        list.push(STILL);
        let mut some = rows(&list);
        some.hold_at_most(10);
        assert_eq!(given(&mut some).len(), 91);
        let done = some.finish(Treatment::Kept).unwrap();
        assert!(!done.zeros.iter().any(|f| f.kind == "zero-tail"));
    }
}
