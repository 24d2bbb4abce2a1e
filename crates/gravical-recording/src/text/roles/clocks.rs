//! Columns of time that no name tells.

use gravical_judge::units::{TimeUnit, is_listed};
use gravical_judge::{Role, counts_rows, trend};

use crate::date::compact_day_s;
use crate::text::format::{Format, StampPart};
use crate::text::names::{Column, words};
use crate::text::rows::Rows;

const DAY_S: f64 = 86_400.0;
/// Rows from which on a column that always rises is a clock.
const MIN_CLOCK_ROWS: usize = 20;

/// Columns of dates are clocks; without any clock so is the only column that always rises.
pub(super) fn assign(format: &mut Format, sample: &Rows) {
    if format.has_no_clock {
        return;
    }
    let axes = format.channels();
    if !format
        .columns
        .iter()
        .any(|c| c.is_given && c.role == Role::Time)
    {
        for c in (0..format.columns.len()).filter(|c| !axes.contains(c) && !sample.is_text(*c)) {
            let column = &mut format.columns[c];
            let is_open = !column.is_dropped && !column.is_given;
            if is_open && column.is_dated && !holds_days(&sample.columns[c]) {
                column.role = Role::Time;
            }
        }
        format.stamp_parts = find_parts(format, sample);
        for c in format.stamp_parts.iter().flat_map(StampPart::columns) {
            format.columns[*c].role = Role::Time;
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
            && !counts_rows(values)
    };
    format.unnamed_clocks = (0..format.columns.len()).filter(rises).collect();
    if let [only] = format.unnamed_clocks[..] {
        format.columns[only].role = Role::Time;
    }
}

/// Columns that are one stamp: a date, and a time of day in one column or in several.
fn find_parts(format: &Format, sample: &Rows) -> Vec<StampPart> {
    let values = |c: usize| sample.columns[c].as_slice();
    let is_time = |c: usize| format.columns[c].role == Role::Time;
    let columns = 0..format.columns.len();
    let is_of_day =
        |c: &usize| is_time(*c) && format.columns[*c].is_dated && are_within(values(*c), DAY_S);
    let parts = hours_to_seconds(format, sample).or_else(|| second_and_fraction(format, sample));
    let time = columns.clone().find(is_of_day);
    let time = time.map(|c| vec![StampPart::Unit(c, 1.0)]);
    let mut parts = parts.or(time).unwrap_or_default();
    if parts.is_empty() || !are_within(&StampPart::sum(&parts, sample), DAY_S) {
        return parts;
    }
    parts.splice(0..0, find_date(format, sample));
    if parts.len() > 1 { parts } else { Vec::new() }
}

/// The date in one column, or year, month and day in columns of these names.
fn find_date(format: &Format, sample: &Rows) -> Option<StampPart> {
    let is_open = |c: &usize| {
        let column = &format.columns[*c];
        !column.is_dropped && matches!(column.role, Role::Time | Role::Other)
    };
    let mut open = (0..format.columns.len()).filter(is_open);
    let name = |c: usize| words(format.names.get(c).map_or("", String::as_str));
    let find = |names: &str| {
        let is_it = |c: &usize| matches!(&name(*c)[..], [word] if is_listed(names, word));
        open.clone().find(is_it)
    };
    let columns = [find("year yyyy"), find("month mon"), find("day dd")];
    if let [Some(year), Some(month), Some(day)] = columns {
        let day = [StampPart::Day(vec![year, month, day])];
        let sums = StampPart::sum(&day, sample);
        if sums.iter().any(|s| s.is_finite()) {
            return day.into_iter().next();
        }
    }
    let is_compact = |v: &f64| v.is_nan() || compact_day_s(*v).is_some();
    open.find_map(|c| {
        let values = &sample.columns[c];
        if format.columns[c].is_dated && holds_days(values) {
            return Some(StampPart::Unit(c, 1.0));
        }
        let is_named = name(c).iter().any(|word| word == "date");
        (is_named && values.iter().all(is_compact)).then(|| StampPart::Day(vec![c]))
    })
}

/// Whether a column has values, and all are such.
fn are_all(values: &[f64], is: impl Fn(f64) -> bool) -> bool {
    let mut known = values.iter().filter(|v| v.is_finite()).peekable();
    known.peek().is_some() && known.all(|v| is(*v))
}

/// Whether the dates of a column have no time of day.
fn holds_days(values: &[f64]) -> bool {
    are_all(values, |v| v >= DAY_S && v % DAY_S == 0.0)
}

fn are_within(values: &[f64], end: f64) -> bool {
    are_all(values, |v| (0.0..end).contains(&v))
}

/// Minutes and seconds in neighbouring columns, with hours before them or not, and a fraction behind
/// them or not: `h,m,s,ms`, `HH,MM,SS`.
fn hours_to_seconds(format: &Format, sample: &Rows) -> Option<Vec<StampPart>> {
    let axes = format.channels();
    let unit_s = |c: usize| {
        let unit = words(format.names.get(c)?).pop()?;
        let unit_s = match unit.as_str() {
            "hh" => 3600.0,
            "m" | "mm" => 60.0,
            "ss" => 1.0,
            unit => TimeUnit::parse(unit)?.seconds(),
        };
        let end = if unit_s == 3600.0 { 24.0 } else { 60.0 };
        let end = if unit_s < 1.0 { 1.0 / unit_s } else { end };
        let is_open = !axes.contains(&c) && !format.columns[c].is_dropped;
        (is_open && are_within(&sample.columns[c], end)).then_some(unit_s)
    };
    let is_whole = |c: usize| are_all(&sample.columns[c], |v| v.fract() == 0.0);
    let has_unit = |c: usize, unit: f64| unit_s(c) == Some(unit);
    let minutes = (0..format.columns.len())
        .find(|c| has_unit(*c, 60.0) && is_whole(*c) && has_unit(c + 1, 1.0))?;
    let hours = minutes.checked_sub(1);
    let hours = hours.filter(|c| has_unit(*c, 3600.0) && is_whole(*c));
    let fraction = unit_s(minutes + 2).filter(|u| *u < 1.0 && is_whole(minutes + 1));
    let hours = hours.map(|c| (c, 3600.0)).into_iter();
    let parts = hours.chain([(minutes, 60.0), (minutes + 1, 1.0)]);
    let parts = parts.chain(fraction.map(|unit_s| (minutes + 2, unit_s)));
    let parts = parts.map(|(c, unit_s)| StampPart::Unit(c, unit_s));
    let parts: Vec<StampPart> = parts.collect();
    let (rises, falls) = trend(&StampPart::sum(&parts, sample));
    (falls <= 0.2 * rises).then_some(parts)
}

/// Whole seconds, and the fraction in ms, µs or ns (`stamp.sec` and `nanosec`).
fn second_and_fraction(format: &Format, sample: &Rows) -> Option<Vec<StampPart>> {
    let is_time = |c: &usize| format.columns[*c].role == Role::Time;
    let times = || (0..format.columns.len()).filter(is_time);
    let unit_s = |c: usize| format.columns[c].stated_unit_s();
    let mut wholes = times().filter(|c| unit_s(*c).is_none_or(|u| u == 1.0));
    wholes.find_map(|whole| {
        let mut fractions = times().filter_map(|c| Some((c, unit_s(c).filter(|u| *u < 1.0)?)));
        fractions.find_map(|(below, unit_s)| {
            let parts = vec![StampPart::Unit(whole, 1.0), StampPart::Unit(below, unit_s)];
            let ((rises, falls), (turns, _)) = (
                trend(&StampPart::sum(&parts, sample)),
                trend(&sample.columns[whole]),
            );
            // The sum rises. An independent clock falls where it begins again, and the duration of a
            // loop at any time.
            let is_sum = turns < 1.0 && rises >= 0.9 && falls <= 0.2 * turns;
            let are_parts = are_all(&sample.columns[whole], |s| s.fract() == 0.0)
                && are_within(&sample.columns[below], 1.0 / unit_s);
            (is_sum && are_parts).then_some(parts)
        })
    })
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
