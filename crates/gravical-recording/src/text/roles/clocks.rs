//! Columns of time that no name tells.

use crate::judge::{median, trend};
use crate::role::Role;
use crate::text::format::Format;
use crate::text::names::Column;
use crate::text::rows::Rows;

/// Rows from which on a column that always rises is a clock.
const MIN_CLOCK_ROWS: usize = 20;

/// Columns of dates are clocks; without any clock so is the only column that always rises.
pub(super) fn assign(format: &mut Format, sample: &Rows) {
    if format.has_no_clock {
        return;
    }
    let is_given_clock = |c: &Column| c.is_given && c.role == Role::Time;
    let names_clock = format.columns.iter().any(is_given_clock);
    let axes = format.channels();
    for c in 0..format.columns.len() {
        let column = &format.columns[c];
        let is_open = !column.is_dropped && !column.is_given && !names_clock;
        if column.is_dated && is_open && !axes.contains(&c) && !sample.is_text(c) {
            format.columns[c].role = Role::Time;
        }
    }
    let is_clock = |c: &Column| matches!(c.role, Role::Time | Role::Step);
    let has_clock = format.columns.iter().any(is_clock);
    if has_clock || format.names.is_empty() {
        return;
    }
    let rises = |c: &usize| {
        let values = &sample.columns[*c];
        format.columns[*c].role == Role::Other
            && !axes.contains(c)
            && !format.columns[*c].is_dropped
            && values.len() > MIN_CLOCK_ROWS
            && values.windows(2).all(|w| w[1] > w[0])
            && !counts_mostly(values)
    };
    format.unnamed_clocks = (0..format.columns.len()).filter(rises).collect();
    if let [only] = format.unnamed_clocks[..] {
        format.columns[only].role = Role::Time;
    }
}

/// Numbers of rows, perhaps with lost ones.
fn counts_mostly(values: &[f64]) -> bool {
    let is_whole = values.windows(2).all(|w| (w[1] - w[0]).fract() == 0.0);
    is_whole && median(values.windows(2).map(|w| w[1] - w[0])) == Some(1.0)
}

/// Whether a column without a name rises as a clock or a counter does.
pub(super) fn rises(values: &[f64]) -> bool {
    let mut steps = values.windows(2).map(|w| w[1] - w[0]);
    let seconds = values.windows(2).filter(|w| w[1] - w[0] == 1.0).count();
    if seconds >= 2 && steps.all(|s| s == 0.0 || s == 1.0) {
        return true;
    }
    let (up, down) = trend(values);
    up >= 0.1 && down < 0.1 && down < 0.2 * up
}

/// Numbers of rows.
pub(crate) fn is_counter(values: &[f64]) -> bool {
    values.windows(2).all(|w| w[1] - w[0] == 1.0)
}
