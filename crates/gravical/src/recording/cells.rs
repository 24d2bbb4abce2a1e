//! Cells that are empty, and rows of zeros: what becomes of them.
//!
//! A recorder that writes each channel when it arrives leaves most cells empty; there the
//! last value of a channel holds until the next comes. Elsewhere an empty cell stays
//! empty. An accelerometer that reads zero on all axes, to the last digit, was not read:
//! such a row is empty too, and at the end of a file rows of zeros are none at all.

use super::row::{ACCEL, GYRO, TEMPERATURE, Values};
use crate::finding::{Finding, FindingKind, LineSpans};

/// Rows below which nothing is held: a few empty cells are no habit.
const SPARSE_ROWS: u64 = 20;

/// Of the gyroscope no more is held, in usual distances of its values, than rows may be
/// lost: an integral over what is held longer would be made up.
const GYRO_HELD: f64 = 4.5;

/// With a gyroscope that reads something, so many rows of zeros in a row are no free fall.
pub(super) const ZEROS_IN_A_ROW: u64 = 5;

/// Which channels a recording has.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Channels {
    pub gyro: bool,
    pub temperature: bool,
}

impl Channels {
    /// Number of those of accelerometer and gyroscope.
    fn count(self) -> usize {
        if self.gyro { 6 } else { 3 }
    }

    /// The accelerometer reads zero on every axis.
    #[inline]
    pub fn accel_is_zero(self, values: &Values) -> bool {
        values[ACCEL..ACCEL + 3].iter().all(|v| *v == 0.0)
    }

    /// The gyroscope does; true without one.
    #[inline]
    pub fn gyro_is_zero(self, values: &Values) -> bool {
        !self.gyro || values[GYRO..GYRO + 3].iter().all(|v| *v == 0.0)
    }
}

/// Counts cells without a value, and rows of zeros.
#[derive(Debug, Clone, Default)]
pub(crate) struct CellCounts {
    channels: Channels,
    rows: u64,
    /// Without a value, of ax … gz and the temperature.
    empty: [u64; 7],
    /// Rows that lack a value of the accelerometer, of the gyroscope.
    incomplete: [u64; 2],
    /// Rows in which the accelerometer, the gyroscope reads zero on all axes.
    zeros: [u64; 2],
    /// Lines of the rows that lack a value of either.
    lines: LineSpans,
}

impl CellCounts {
    pub fn new(channels: Channels) -> Self {
        CellCounts {
            channels,
            ..CellCounts::default()
        }
    }

    /// A row as it stands in the file.
    #[inline]
    pub fn see(&mut self, values: &Values, line: u64) {
        self.rows += 1;
        let count = self.channels.count();
        let sum: f64 = values[ACCEL..ACCEL + count].iter().sum();
        if sum.is_nan() || (self.channels.temperature && values[TEMPERATURE].is_nan()) {
            self.see_empty(values, line);
        }
        if values[ACCEL] == 0.0 && self.channels.accel_is_zero(values) {
            self.zeros[0] += 1;
        }
        if values[GYRO] == 0.0 && self.channels.gyro_is_zero(values) {
            self.zeros[1] += 1;
        }
    }

    #[cold]
    fn see_empty(&mut self, values: &Values, line: u64) {
        let count = self.channels.count();
        for (empty, value) in self.empty.iter_mut().zip(&values[ACCEL..ACCEL + count]) {
            *empty += u64::from(value.is_nan());
        }
        let lacks = |first: usize| values[first..first + 3].iter().any(|v| v.is_nan());
        let incomplete = [lacks(ACCEL), self.channels.gyro && lacks(GYRO)];
        for (count, lacks) in self.incomplete.iter_mut().zip(incomplete) {
            *count += u64::from(lacks);
        }
        if incomplete != [false; 2] {
            self.lines.push(line);
        }
        if self.channels.temperature {
            self.empty[6] += u64::from(values[TEMPERATURE].is_nan());
        }
    }

    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// An axis of the sensor whose first slot is `first` that has no value at all.
    pub fn axis_without_values(&self, first: usize) -> Option<usize> {
        let empty = self.empty.get(first - ACCEL..first - ACCEL + 3)?;
        empty.iter().position(|n| *n == self.rows)
    }

    /// That sensor reads zero in all rows.
    pub fn is_all_zero(&self, first: usize) -> bool {
        self.zeros[usize::from(first == GYRO)] == self.rows
    }

    /// How cells are to be filled, by all rows so far.
    pub fn rules(&self, without_gravity: bool) -> CellRules {
        let sparse = |incomplete: u64| self.rows >= SPARSE_ROWS && 5 * incomplete > self.rows;
        let distance = |empty: u64| self.rows as f64 / (self.rows - empty).max(1) as f64;
        let mut longest = [0.0; 6];
        if sparse(self.incomplete[0]) {
            longest[..3].fill(f64::INFINITY);
        }
        if sparse(self.incomplete[1]) {
            for i in 3..6 {
                longest[i] = GYRO_HELD * distance(self.empty[i]);
            }
        }
        CellRules {
            longest,
            // Without gravity it reads zero at rest.
            zeros_are_empty: !without_gravity && 2 * self.zeros[0] <= self.rows,
        }
    }

    /// What is said of empty ones, which were filled by `rules`; none without any.
    pub fn finding(&self, rules: &CellRules) -> Option<Finding> {
        let names = ["ax", "ay", "az", "gx", "gy", "gz", "temperature"];
        let some = names.iter().zip(self.empty).filter(|(_, empty)| *empty > 0);
        let parts: Vec<String> = some
            .map(|(name, empty)| format!("{name} {empty}"))
            .collect();
        let total: u64 = self.empty.iter().sum();
        // Where it is a habit, lines tell nothing.
        let lines = match rules.holds_any() {
            true => &LineSpans::default(),
            false => &self.lines,
        };
        (total > 0).then(|| {
            Finding::new(
                FindingKind::EmptyCells,
                format!(
                    "{total} empty cells ({}); {} of {} rows lack a value of the accelerometer{}",
                    parts.join(", "),
                    self.incomplete[0],
                    self.rows,
                    if rules.holds() {
                        ": each channel is written when it arrives; the last value of the others is held"
                    } else if rules.holds_any() {
                        "; each channel of the gyroscope is written when it arrives: its last value is held for a few rows"
                    } else {
                        "; they stay empty"
                    }
                ),
            )
            .at_lines(lines)
            .counting(total)
        })
    }
}

/// How cells without a value are filled, and which values are none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CellRules {
    /// Rows over which the last value of each channel holds.
    longest: [f64; 6],
    /// Rows of zeros are empty.
    zeros_are_empty: bool,
}

impl Default for CellRules {
    fn default() -> Self {
        CellRules {
            longest: [0.0; 6],
            zeros_are_empty: true,
        }
    }
}

impl CellRules {
    /// Last values of the accelerometer are held.
    pub fn holds(&self) -> bool {
        self.longest[0] > 0.0
    }

    fn holds_any(&self) -> bool {
        self.longest.iter().any(|l| *l > 0.0)
    }

    /// The same cells are filled by either.
    pub fn agrees(&self, other: &CellRules) -> bool {
        let held = |rules: &CellRules| rules.longest.map(|l| l > 0.0);
        held(self) == held(other) && self.zeros_are_empty == other.zeros_are_empty
    }
}

/// Fills cells row by row.
#[derive(Debug, Clone)]
pub(crate) struct CellFiller {
    rules: CellRules,
    channels: Channels,
    holds: bool,
    last: [f64; 6],
    held: [f64; 6],
    zeros: LineSpans,
}

impl CellFiller {
    pub fn new(rules: CellRules, channels: Channels) -> Self {
        CellFiller {
            rules,
            channels,
            holds: rules.holds_any(),
            last: [f64::NAN; 6],
            held: [0.0; 6],
            zeros: LineSpans::default(),
        }
    }

    /// The same, which has found nothing yet.
    pub fn without_findings(&self) -> Self {
        CellFiller {
            zeros: LineSpans::default(),
            ..*self
        }
    }

    /// The row in `line`, whose cells are filled or emptied. `unread`: its
    /// accelerometer's zeros are none.
    #[inline]
    pub fn fill(&mut self, values: &mut Values, unread: bool, line: u64) {
        // Such a row stays empty: a sensor that does not answer has no last value.
        if unread && self.rules.zeros_are_empty {
            self.empty(values, line);
        } else if self.holds {
            self.hold(values);
        }
    }

    /// The last value of a channel holds until the next comes.
    fn hold(&mut self, values: &mut Values) {
        let channels = values[ACCEL..ACCEL + self.channels.count()].iter_mut();
        for (i, value) in channels.enumerate() {
            if !value.is_nan() {
                (self.last[i], self.held[i]) = (*value, 0.0);
            } else if self.held[i] < self.rules.longest[i] {
                *value = self.last[i];
                self.held[i] += 1.0;
            }
        }
    }

    #[cold]
    fn empty(&mut self, values: &mut Values, line: u64) {
        self.zeros.push(line);
        if self.channels.gyro && self.channels.gyro_is_zero(values) {
            values[GYRO..GYRO + 3].fill(f64::NAN);
        }
        values[ACCEL..ACCEL + 3].fill(f64::NAN);
    }

    /// What is said of rows of zeros.
    pub fn finding(&self) -> Option<Finding> {
        (!self.zeros.is_empty()).then(|| {
            Finding::new(
                FindingKind::ZeroRows,
                format!(
                    "the accelerometer reads zero on all axes in {} rows: it was not read; taken as empty",
                    self.zeros.count()
                ),
            )
            .at_lines(&self.zeros)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gyroscope_is_held_from_reading_to_reading_and_not_on() {
        let channels = Channels {
            gyro: true,
            temperature: false,
        };
        // Every other row, until it falls silent.
        let row = |i: i32| -> Values {
            let rate = if i % 2 == 0 && i < 20 {
                f64::from(i)
            } else {
                f64::NAN
            };
            [0.0, 0.1, 0.2, 9.8, rate, rate, rate, f64::NAN]
        };
        let mut counts = CellCounts::new(channels);
        (0..40).for_each(|i| counts.see(&row(i), i as u64 + 1));
        let mut filler = CellFiller::new(counts.rules(false), channels);
        let filled: Vec<f64> = (0..40)
            .map(|i| {
                let mut values = row(i);
                filler.fill(&mut values, false, i as u64);
                values[GYRO]
            })
            .collect();
        assert_eq!((filled[7], filled[36]), (6.0, 18.0));
        assert!(filled[37..].iter().all(|v| v.is_nan()), "{filled:?}");
    }
}
