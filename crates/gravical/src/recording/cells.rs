//! Treatment of empty cells and of rows of zeros.
//!
//! A recorder that writes each channel when it arrives leaves most cells empty; in such a file
//! the last value of a channel is held until the next one. In other files an empty cell stays
//! empty. A temperature that no sensor can have (a driver's -999 for a failed read) is an empty
//! cell. If an accelerometer reads exactly zero on all axes, it was not read: the row is treated
//! as empty, and at the end of a file it is removed.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::POSSIBLE_C;
use super::row::{ACCEL, GYRO, TEMPERATURE, Values};
use crate::finding::{Finding, FindingKind, LineSpans};

/// Smallest number of rows for holding values.
const SPARSE_ROWS: u64 = 20;

/// Longest holding of the gyroscope's values, in usual distances between them. As for gaps, an
/// integral over longer holding would be meaningless.
const GYRO_HELD: f64 = 4.5;

/// Number of consecutive rows of zeros that cannot be free fall if the gyroscope reads other
/// values.
pub(super) const ZEROS_IN_A_ROW: u64 = 5;

/// Channels of a recording.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Channels {
    pub gyro: bool,
    /// In °C.
    pub temperature: bool,
}

impl Channels {
    /// Slots of accelerometer and gyroscope.
    pub fn slots(self) -> Range<usize> {
        ACCEL..if self.gyro { GYRO + 3 } else { GYRO }
    }

    /// The accelerometer reads zero on every axis.
    #[inline]
    pub fn accel_is_zero(self, values: &Values) -> bool {
        values[ACCEL..ACCEL + 3].iter().all(|v| *v == 0.0)
    }

    /// The gyroscope reads zero on every axis; true without a gyroscope.
    #[inline]
    pub fn gyro_is_zero(self, values: &Values) -> bool {
        !self.gyro || values[GYRO..GYRO + 3].iter().all(|v| *v == 0.0)
    }
}

/// Counts empty cells and rows of zeros.
#[derive(Debug, Clone, Default)]
pub(crate) struct CellCounts {
    channels: Channels,
    rows: u64,
    /// Number of empty cells of ax … gz and the temperature.
    empty: [u64; 7],
    /// Number of rows with an empty cell of the accelerometer, of the gyroscope.
    incomplete: [u64; 2],
    /// Number of rows in which the accelerometer, the gyroscope reads zero on all axes.
    zeros: [u64; 2],
    /// Number of temperatures that no sensor can have; they count as empty cells.
    impossible: u64,
    /// Lines of the incomplete rows of either sensor, and of impossible temperatures.
    lines: LineSpans,
}

impl CellCounts {
    pub fn new(channels: Channels) -> Self {
        CellCounts {
            channels,
            ..CellCounts::default()
        }
    }

    /// Processes a row as in the file.
    #[inline]
    pub fn observe(&mut self, values: &Values, line: u64) {
        self.rows += 1;
        let sum: f64 = values[self.channels.slots()].iter().sum();
        if sum.is_nan() || (self.channels.temperature && !POSSIBLE_C.contains(&values[TEMPERATURE]))
        {
            self.count_empty(values, line);
        }
        if values[ACCEL] == 0.0 && self.channels.accel_is_zero(values) {
            self.zeros[0] += 1;
        }
        if values[GYRO] == 0.0 && self.channels.gyro_is_zero(values) {
            self.zeros[1] += 1;
        }
    }

    #[cold]
    fn count_empty(&mut self, values: &Values, line: u64) {
        for slot in self.channels.slots() {
            self.empty[slot - ACCEL] += u64::from(values[slot].is_nan());
        }
        let is_incomplete = |first: usize| values[first..first + 3].iter().any(|v| v.is_nan());
        let incomplete = [
            is_incomplete(ACCEL),
            self.channels.gyro && is_incomplete(GYRO),
        ];
        for (count, is_incomplete) in self.incomplete.iter_mut().zip(incomplete) {
            *count += u64::from(is_incomplete);
        }
        let impossible = self.channels.temperature
            && !values[TEMPERATURE].is_nan()
            && !POSSIBLE_C.contains(&values[TEMPERATURE]);
        if incomplete != [false; 2] || impossible {
            self.lines.push(line);
        }
        self.impossible += u64::from(impossible);
        if self.channels.temperature {
            self.empty[6] += u64::from(values[TEMPERATURE].is_nan() || impossible);
        }
    }

    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Rules for filling cells, from all rows so far.
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
            // Without gravity the sensor reads zero at rest.
            zeros_are_empty: !without_gravity && 2 * self.zeros[0] <= self.rows,
        }
    }

    /// The finding about empty cells, which were filled by `rules`; `None` without any.
    pub fn finding(&self, rules: &CellRules) -> Option<Finding> {
        let names = ["ax", "ay", "az", "gx", "gy", "gz", "temperature"];
        let some = names.iter().zip(self.empty).filter(|(_, empty)| *empty > 0);
        let mut parts: Vec<String> = some
            .map(|(name, empty)| format!("{name} {empty}"))
            .collect();
        if self.impossible > 0 {
            let (n, low, high) = (self.impossible, POSSIBLE_C.start(), POSSIBLE_C.end());
            parts.push(format!("{n} of them outside {low} to {high} °C"));
        }
        let total: u64 = self.empty.iter().sum();
        let incomplete = self.incomplete[0];
        // If cells are empty throughout the file, their lines are of no use.
        let lines = match rules.holds_any() {
            true => &LineSpans::default(),
            false => &self.lines,
        };
        (total > 0).then(|| {
            Finding::new(
                FindingKind::EmptyCells,
                format!(
                    "{total} empty cells ({}); {incomplete} of {} rows lack a value of the accelerometer{}",
                    parts.join(", "),
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

/// Rules for filling empty cells.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct CellRules {
    /// Number of rows for which the last value of each channel is held.
    longest: [f64; 6],
    /// Rows of zeros are treated as empty.
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
    /// Values of the accelerometer are held.
    pub fn holds(&self) -> bool {
        self.longest[0] > 0.0
    }

    fn holds_any(&self) -> bool {
        self.longest.iter().any(|l| *l > 0.0)
    }

    /// Both fill the same cells.
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
}

impl CellFiller {
    pub fn new(rules: CellRules, channels: Channels) -> Self {
        CellFiller {
            rules,
            channels,
            holds: rules.holds_any(),
            last: [f64::NAN; 6],
            held: [0.0; 6],
        }
    }

    /// Fills or empties the cells of a row; `unread`: the accelerometer was not read.
    #[inline]
    pub fn fill(&mut self, values: &mut Values, unread: bool) {
        if !(self.channels.temperature && POSSIBLE_C.contains(&values[TEMPERATURE])) {
            values[TEMPERATURE] = f64::NAN;
        }
        // Such a row stays empty: the sensor did not answer.
        if unread && self.rules.zeros_are_empty {
            self.empty(values);
        } else if self.holds {
            self.hold(values);
        }
    }

    /// Fills empty cells with the last values.
    fn hold(&mut self, values: &mut Values) {
        for slot in self.channels.slots() {
            let (i, value) = (slot - ACCEL, &mut values[slot]);
            if !value.is_nan() {
                (self.last[i], self.held[i]) = (*value, 0.0);
            } else if self.held[i] < self.rules.longest[i] {
                *value = self.last[i];
                self.held[i] += 1.0;
            }
        }
    }

    #[cold]
    fn empty(&self, values: &mut Values) {
        if self.channels.gyro && self.channels.gyro_is_zero(values) {
            values[GYRO..GYRO + 3].fill(f64::NAN);
        }
        values[ACCEL..ACCEL + 3].fill(f64::NAN);
    }
}
