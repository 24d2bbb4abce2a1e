//! Rows gathered into columns while a file is read.

use std::collections::HashMap;
use std::path::Path;

use crate::{Error, Result};

use super::dialect::decode;
use super::ledger::{Aside, Ledger};
use super::row::{ACCEL, GYRO, SLOTS, Values};
use super::{Labels, LineMap};

/// Rows as they are read.
pub(super) struct Columns {
    pub slots: [Vec<f64>; SLOTS],
    pub labels: Labels,
    pub label_index: HashMap<Vec<u8>, u32>,
    pub lines: LineMap,
    pub breaks: Vec<usize>,
    /// … of these, before which a clock that goes on changes nothing: a gap is named,
    /// or somebody left more than one line blank.
    pub deliberate: Vec<usize>,
    /// Rows before which a gap is named.
    pub gaps: Vec<usize>,
    /// Why the last line that parts rows does so.
    parting: Option<Aside>,
    rows: usize,
}

impl Columns {
    pub fn new() -> Self {
        Columns {
            slots: std::array::from_fn(|_| Vec::new()),
            labels: Labels::default(),
            label_index: HashMap::new(),
            lines: LineMap::default(),
            breaks: Vec::new(),
            deliberate: Vec::new(),
            gaps: Vec::new(),
            parting: None,
            rows: 0,
        }
    }

    pub fn rows(&self) -> usize {
        self.rows
    }

    pub fn push(&mut self, values: &Values, present: &[bool; SLOTS], line: u64) {
        for slot in 0..SLOTS {
            if present[slot] {
                self.slots[slot].push(values[slot]);
            }
        }
        self.lines.push(line);
        self.rows += 1;
    }

    pub fn push_label(&mut self, text: &[u8]) {
        let text = text.trim_ascii();
        let index = match self.label_index.get(text) {
            Some(&index) => index,
            None => {
                let index = self.labels.names.len() as u32;
                self.labels
                    .names
                    .push(decode(text).trim_matches('"').to_owned());
                self.label_index.insert(text.to_vec(), index);
                index
            }
        };
        self.labels.of_row.push(index);
    }

    /// A line between rows that parts them.
    pub fn note_break(&mut self, reason: Aside) {
        let row = self.rows();
        if reason == Aside::NamedGap {
            self.gaps.push(row);
            self.deliberate.push(row);
        }
        if row == 0 {
            return;
        }
        if self.breaks.last() != Some(&row) {
            self.breaks.push(row);
        } else if reason == Aside::Blank && self.parting == Some(Aside::Blank) {
            self.deliberate.push(row);
        }
        self.parting = Some(reason);
    }

    pub fn truncate(&mut self, rows: usize) {
        for slot in &mut self.slots {
            slot.truncate(rows);
        }
        self.rows = self.rows.min(rows);
        self.labels.of_row.truncate(rows);
        self.breaks.retain(|b| *b < rows);
    }
}

/// Rows of zeros up to the end of the file were never written by the sensor.
pub(super) fn zero_tail(columns: &mut Columns, ledger: &mut Ledger) {
    let zero = |row: usize| {
        (ACCEL..ACCEL + 6).all(|slot| columns.slots[slot].get(row).is_none_or(|v| *v == 0.0))
    };
    let rows = columns.rows();
    let kept = (0..rows)
        .rev()
        .find(|row| !zero(*row))
        .map_or(0, |row| row + 1);
    if kept > 0 && rows - kept >= 2 {
        let lines: Vec<u64> = (kept..rows).map(|row| columns.lines.line(row)).collect();
        ledger.move_rows_aside(Aside::ZeroTail, lines.into_iter());
        columns.truncate(kept);
    }
}

/// Refuses a file whose accelerometer said nothing.
///
/// # Errors
///
/// `no-rows`, `no-values`, `all-zero`.
pub(super) fn refuse_unusable(columns: &Columns, ledger: &Ledger, here: &Path) -> Result<()> {
    refuse_without_values(columns, ledger, ACCEL, here)?;
    let rows = columns.rows();
    let accel = &columns.slots[ACCEL..ACCEL + 3];
    if accel.iter().all(|c| c.iter().all(|v| *v == 0.0)) {
        return Err(Error::input(
            "all-zero",
            format!("the accelerometer reads zero in all {rows} rows: it did not answer"),
        )
        .at(here, None)
        .with_hint("check the wiring (SDA, SCL, power) and that the sketch wakes the sensor"));
    }
    Ok(())
}

/// Refuses a file that is read for its gyroscope, and whose gyroscope said
/// nothing.
///
/// # Errors
///
/// `no-rows`, `no-values`, `all-zero`.
pub(super) fn refuse_silent_gyroscope(
    columns: &Columns,
    ledger: &Ledger,
    here: &Path,
) -> Result<()> {
    refuse_without_values(columns, ledger, GYRO, here)?;
    let gyro = &columns.slots[GYRO..GYRO + 3];
    if gyro.iter().all(|c| c.iter().all(|v| *v == 0.0)) {
        return Err(Error::input(
            "all-zero",
            format!(
                "the gyroscope reads zero in all {} rows: it did not answer",
                columns.rows()
            ),
        )
        .at(here, None)
        .with_hint("check that the sketch wakes the gyroscope, or leave --gyro out"));
    }
    Ok(())
}

fn refuse_without_values(
    columns: &Columns,
    ledger: &Ledger,
    first_slot: usize,
    here: &Path,
) -> Result<()> {
    let rows = columns.rows();
    if rows == 0 {
        return Err(
            Error::input("no-rows", format!("no row could be read: {}", ledger.sum()))
                .at(here, None)
                .with_hint("a recording is a table of text: one sample a line, its values separated by comma, semicolon, tab or spaces; --columns says which column is which"),
        );
    }
    let sensor = &columns.slots[first_slot..first_slot + 3];
    if let Some(axis) = (0..3).find(|i| sensor[*i].iter().all(|v| v.is_nan())) {
        return Err(Error::input(
            "no-values",
            format!(
                "{}{} has no value in any of the {rows} rows (empty or NaN)",
                if first_slot == ACCEL { "a" } else { "g" },
                ["x", "y", "z"][axis]
            ),
        )
        .at(here, None)
        .with_hint(
            "look at the columns with `gravical inspect`, or choose others with --columns",
        ));
    }
    Ok(())
}
