//! Sensors whose rows take turns.

use std::collections::HashMap;

use gravical_judge::units::is_listed;
use gravical_judge::{Role, median};

use crate::text::format::Format;
use crate::text::names::words;
use crate::text::rows::Rows;

/// Rows of each sensor from which on several are told apart.
const MIN_TURNS: usize = 4;

/// From one sensor to another the step between rows is more than so many times that within one.
const JUMP: f64 = 5.0;

/// The column that tells several sensors apart whose rows take turns: few values, each as often as
/// the others, another one in nearly every row, and rows of one instant or a name that says so; or
/// another one in every fifth row, a name or words, and measurements that jump with it.
pub(super) fn find_column(format: &Format, sample: &Rows) -> Option<usize> {
    const NAMES: &str = "i id instance sensor device channel node type kind";
    (0..format.columns.len()).find_map(|c| {
        let (column, is_text) = (&format.columns[c], sample.is_text(c));
        let is_read = column.is_accel() || column.is_gyro() || column.role == Role::Label;
        if is_read || column.role != Role::Other && !is_text {
            return None;
        }
        let values = sensor_codes(sample, c)?;
        let rows = values.len();
        let counts = (0..16).map(|code| values.iter().filter(|v| **v == code).count());
        let counts: Vec<usize> = counts.filter(|count| *count > 0).collect();
        let kinds = counts.len();
        if !(2..=8).contains(&kinds) {
            return None;
        }
        let is_near = |count: &usize| (*count * kinds).abs_diff(rows) * 5 <= rows;
        let is_even = rows >= MIN_TURNS * kinds && counts.iter().all(is_near);
        let changes = values.windows(2).filter(|w| w[0] != w[1]).count();
        let takes_turns = is_even && changes * 5 >= rows * 4;
        let is_named = || {
            let name = format.names.get(c);
            name.is_some_and(|n| words(n).iter().any(|w| is_listed(NAMES, w)))
        };
        let has_pairs = || {
            let columns = format.columns.iter().zip(&sample.columns);
            let mut clocks = columns.filter(|(column, _)| column.role == Role::Time);
            clocks.any(|(_, stamps)| {
                let same = stamps.windows(2).filter(|w| w[0] == w[1]).count();
                same * kinds * 5 >= stamps.len() * (kinds - 1) * 4
            })
        };
        let is_mixed = || {
            let axes = 0..format.columns.len();
            let axes = axes.filter(|c| format.columns[*c].is_accel());
            let axes = sample.slices(&axes.collect::<Vec<_>>());
            (is_text || is_named())
                && counts.iter().all(|count| *count >= MIN_TURNS)
                && changes * 5 >= rows
                && rows == sample.rows()
                && jumps(&axes, &values)
        };
        let is_told = takes_turns && (is_text || is_named() || has_pairs());
        (is_told || is_mixed()).then_some(c)
    })
}

/// Whether measurements jump from one kind of row to another as they do not within each kind.
fn jumps(axes: &[&[f64]], kinds: &[u8]) -> bool {
    let mut last = HashMap::new();
    let (mut within, mut across) = (Vec::new(), Vec::new());
    for (row, kind) in kinds.iter().enumerate() {
        let step = |before: usize| {
            let steps = axes.iter().map(|axis| (axis[row] - axis[before]).abs());
            steps.fold(0.0, f64::max)
        };
        within.extend(last.insert(kind, row).map(step));
        if row > 0 && kinds[row - 1] != *kind {
            across.push(step(row - 1));
        }
    }
    let jump = median(across).zip(median(within));
    jump.is_some_and(|(across, within)| across > JUMP * within)
}

/// The values of a column as small numbers, if that is what they are.
fn sensor_codes(rows: &Rows, column: usize) -> Option<Vec<u8>> {
    if rows.is_text(column) {
        let codes = &rows.texts[column];
        return codes.iter().all(|c| *c < 16).then(|| codes.clone());
    }
    let is_code = |v: &f64| v.fract() == 0.0 && (0.0..16.0).contains(v);
    let values = rows.columns[column].iter().filter(|v| !v.is_nan());
    let are_codes = values.clone().all(is_code);
    are_codes.then(|| values.map(|v| *v as u8).collect())
}
