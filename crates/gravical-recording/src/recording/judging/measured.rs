//! From the rows of a file to measurements of one sensor: timed, decoded, without rows that are none.

use std::collections::HashMap;

use super::findings;
use super::time::{JudgedTime, KnownClock};
use crate::error::Error;
use crate::finding::{Finding, FindingKind};
use crate::judge::{self, Encoding, HeldRows};
use crate::readings::Readings;
use crate::recording::Labels;
use crate::role::Role;
use crate::spans::LineSpans;
use crate::text::{Batch, Format, Reason, no_rows, sensor_of_file, sensor_unknown};

/// Sensors that are listed.
const MAX_SENSORS: usize = 256;
/// Names of the channels in messages.
const CHANNELS: [&str; 7] = ["ax", "ay", "az", "gx", "gy", "gz", "temperature"];
const ALONE: [&str; 7] = ["gx", "gy", "gz", "", "", "", ""];
/// Rows at the end of a batch whose magnitude shows whether channels may be shifted, and by how
/// much it then differs from gravity.
const SLIP_END_ROWS: usize = 640;
const SLIP_TOLERANCE: f64 = 0.2;

/// What the first rows of a recording showed, by which those that follow are read.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Known {
    pub encoding: Option<Encoding>,
    pub thermometer: Option<usize>,
    /// For how many rows the last values hold in empty cells.
    pub holds: HeldRows,
    /// Whether repeats of all channels mean that the sensor hung.
    pub marks_hung: bool,
    /// Gravity in the unit of the file; `None` if shifted columns and other units are not looked
    /// for.
    pub gravity: Option<f64>,
    /// Of the first rows with stamps.
    pub clock: Option<KnownClock>,
    /// Line and time of the last row whose time is known; `None` without a clock.
    pub anchor: Option<(u32, f64)>,
}

/// Measurements, and what was found of them; units are not judged yet.
pub(crate) struct Measured {
    /// The rows without these channels.
    pub rows: Batch,
    pub readings: Readings,
    /// Without the times.
    pub time: JudgedTime,
    pub findings: Vec<Finding>,
    pub known: Known,
}

impl Measured {
    /// `known`: what the rows before showed.
    ///
    /// # Errors
    ///
    /// There are no rows, or the sensor did not answer in the first ones.
    pub fn new(format: &Format, mut rows: Batch, known: Option<&Known>) -> Result<Self, Error> {
        let options = &format.options;
        let mut findings = findings::of_columns(format);
        if let Some(column) = format.sensor {
            findings.extend(keep_sensor(format, &mut rows, column)?);
        }
        if known.is_none() {
            check_values(format, &rows)?;
        }
        let text_cells = findings::of_text_cells(format, &rows);
        let (thermometer, temperature_c) =
            take_temperature(format, &mut rows, known, &mut findings).unzip();
        let mut of_time = Vec::new();
        let clock = known.and_then(|known| known.clock);
        let mut time =
            JudgedTime::new(format, &rows, temperature_c.as_deref(), clock, &mut of_time);
        if let Some(known) = known {
            time.continue_from(known.anchor, &rows.lines);
        }
        rows.breaks.extend(&time.restarts);
        let times = rows.lines.iter().copied().zip(time.time_s.iter().copied());
        let times = times.take(stamped_rows(format, &rows));
        let anchor = times.rev().find(|(_, t)| t.is_finite());
        let columns = format.columns.iter().zip(&mut rows.columns);
        let stamps = columns.filter(|(c, _)| matches!(c.role, Role::Time | Role::Step));
        stamps.for_each(|(_, column)| *column = Vec::new());
        // Rows that are set aside lose these, too.
        rows.columns.push(std::mem::take(&mut time.time_s));
        rows.columns.push(temperature_c.unwrap_or_default());
        let marks_hung = known.map(|known| known.marks_hung);
        let emptied = set_aside_defects(format, &mut rows, marks_hung);
        let encoding = match known {
            Some(known) => known.encoding,
            None if options.zero_offset.is_some() || options.is_gyroscope => None,
            None => Encoding::of(format.accel.map(|c| rows.columns[c].as_slice())),
        };
        if let Some(encoding) = encoding {
            decode(format, &mut rows, encoding);
        }
        set_aside_slipped(format, &mut rows, known);
        let is_regular = judge::regular_blanks(&rows.blanks, rows.rows()) > 0;
        let of_lines = findings::of_lines(&rows.ledger, &rows.nul_lines).into_iter();
        let is_told = |f: &Finding| f.kind != FindingKind::BlankRows || !is_regular;
        findings.extend(of_lines.filter(is_told));
        findings.extend(text_cells);
        findings.extend(encoding.map(|e| Finding::new(FindingKind::UnsignedCounts, e.meaning())));
        findings.append(&mut of_time);

        let temperature_c = rows.columns.pop().unwrap_or_default();
        let time_s = rows.columns.pop().unwrap_or_default();
        let has_clock = known.map_or(!time_s.is_empty(), |known| known.anchor.is_some());
        let mut breaks = std::mem::take(&mut rows.breaks);
        let (headers, blanks) = (&rows.headers, &rows.blanks);
        let (rate_hz, count) = (time.timing.median_rate_hz, rows.rows());
        breaks.extend(judge::breaks(headers, blanks, &time_s, rate_hz, count));
        breaks.sort_unstable();
        breaks.dedup();
        breaks.retain(|row| (1..count).contains(row));
        let mut take = |c: usize| std::mem::take(&mut rows.columns[c]);
        let mut readings = Readings {
            accel: format.accel.map(&mut take),
            gyro: format.gyro.map(|g| g.map(&mut take)),
            temperature_c: thermometer.map(|_| temperature_c),
            is_measured: vec![true; count],
            time_s: has_clock.then_some(time_s),
            breaks,
        };
        if let Some(offset) = options.zero_offset {
            let values = readings.accel.iter_mut().flatten();
            values.for_each(|v| *v -= offset);
        }
        let known_holds = known.map(|known| known.holds);
        let texts: Vec<&[u8]> = format
            .channels()
            .iter()
            .map(|c| &rows.texts[*c][..])
            .collect();
        let (empty, holds) = judge::fill_cells(
            &mut readings,
            &rows.lines,
            names(format),
            &texts,
            known_holds,
        );
        findings.extend(empty);
        findings.extend(emptied);
        let clock = clock.or(time.clock);
        Ok(Measured {
            readings,
            rows,
            time,
            findings,
            known: Known {
                encoding,
                thermometer,
                holds,
                clock,
                anchor: anchor.or(known.and_then(|known| known.anchor)),
                ..known.copied().unwrap_or_default()
            },
        })
    }
}

/// Number of rows up to the last one with a stamp: the stamps after it tell how much later they are.
pub(crate) fn stamped_rows(format: &Format, rows: &Batch) -> usize {
    let columns = format.columns.iter().zip(&rows.columns);
    let stamps = columns.filter(|(c, _)| matches!(c.role, Role::Time | Role::Step));
    let last = stamps.filter_map(|(_, stamps)| stamps.iter().rposition(|s| s.is_finite()));
    last.max().map_or(rows.rows(), |row| row + 1)
}

/// Names of the channels of a format, in messages.
pub(crate) fn names(format: &Format) -> [&'static str; 7] {
    if format.options.is_gyroscope {
        ALONE
    } else {
        CHANNELS
    }
}

/// Keeps the rows of the sensor that the user asks for, else of the first word that names one of its
/// kind, else of the lowest number or first word.
pub(crate) fn keep_sensor(
    format: &Format,
    rows: &mut Batch,
    column: usize,
) -> Result<Option<Finding>, Error> {
    let labels = column_labels(rows, column);
    let sensors = labels.names.iter().filter(|name| !name.is_empty());
    let mut sensors: Vec<String> = sensors.take(MAX_SENSORS).cloned().collect();
    // Words stay in order.
    sensors.sort_by_key(|name| name.parse::<u64>().unwrap_or(u64::MAX));
    let kind = if format.options.is_gyroscope {
        Role::Gyro(0)
    } else {
        Role::Accel(0)
    };
    let named = || {
        sensors
            .iter()
            .filter(|name| sensor_of_file(name) == Some(kind))
    };
    let named = named()
        .find(|name| !name.contains("linear"))
        .or(named().next());
    let usual = named.or(sensors.first());
    let wanted = match (&format.options.sensor, usual) {
        (Some(wanted), _) if sensors.contains(wanted) => wanted,
        (Some(wanted), _) => return Err(sensor_unknown(wanted, &sensors)),
        (None, Some(first)) => first,
        (None, None) => return Ok(None),
    };
    let other = sensors.iter().find(|name| *name != wanted);
    let other = other.filter(|_| format.options.sensor.is_none());
    let finding = other.map(|other| {
        let name = format.names.get(column).map_or("", String::as_str);
        let text = format!(
            "rows of {} sensors, distinguished by column {name}: {}; those of {wanted} are read, unless another is chosen",
            sensors.len(),
            sensors.join(", ")
        );
        Finding::new(FindingKind::SeveralSensors, text).advise("sensor", other)
    });
    let is_kept = |label: &u32| labels.names[*label as usize] == *wanted;
    let keep: Vec<bool> = labels.of_row.iter().map(is_kept).collect();
    rows.keep(&keep, Reason::OtherSensor);
    Ok(finding)
}

/// A cell as text: its word, its number, or nothing.
pub(crate) fn cell_label(rows: &Batch, column: usize, row: usize) -> String {
    let code = rows.texts[column].get(row).copied().unwrap_or(0);
    let word = usize::from(code)
        .checked_sub(1)
        .and_then(|at| rows.words[column].get(at));
    match (word, rows.columns[column].get(row)) {
        (Some(word), _) => word.trim_matches('"').to_owned(),
        (None, Some(value)) if value.is_finite() => value.to_string(),
        _ => String::new(),
    }
}

/// The cells of a column as labels.
pub(super) fn column_labels(rows: &Batch, column: usize) -> Labels {
    let mut labels = Labels::default();
    let mut known: HashMap<String, u32> = HashMap::new();
    for row in 0..rows.rows() {
        let name = cell_label(rows, column, row);
        let next = labels.names.len() as u32;
        let at = *known.entry(name).or_insert_with_key(|name| {
            labels.names.push(name.clone());
            next
        });
        labels.of_row.push(at);
    }
    labels
}

/// Whether the sensor answered at all.
fn check_values(format: &Format, rows: &Batch) -> Result<(), Error> {
    let count = rows.rows();
    if count == 0 {
        return Err(no_rows(format!(
            "no row could be read: {}",
            rows.ledger.sum()
        )));
    }
    let channels = format.accel.map(|c| &rows.columns[c]);
    for (channel, name) in channels.iter().zip(names(format)) {
        if channel.iter().all(|v| v.is_nan()) {
            let text = format!("{name} has no value in any of the {count} rows (empty or NaN)");
            return Err(Error::input("no-values", text)
                .with_hint("choose other columns, as ax=…,ay=…,az=…")
                .advise("columns", ""));
        }
    }
    let is_zero = |c: &&Vec<f64>| c.iter().all(|v| v.is_nan() || *v == 0.0);
    if channels.iter().all(is_zero) {
        let axes = names(format)[..3].join(", ");
        let text =
            format!("{axes} read zero or nothing in all {count} rows: the sensor did not answer");
        let hint = "check the wiring (SDA, SCL, power) and that the sketch wakes the sensor";
        return Err(Error::input("all-zero", text).with_hint(hint));
    }
    Ok(())
}

/// The column of the thermometer, and the temperature in °C. Of several the first that changes, else
/// the first that is not zero.
fn take_temperature(
    format: &Format,
    rows: &mut Batch,
    known: Option<&Known>,
    findings: &mut Vec<Finding>,
) -> Option<(usize, Vec<f64>)> {
    let find = |is_one: fn(f64, f64) -> bool| {
        let mut columns = format.columns.iter().zip(&rows.columns);
        columns.position(|(column, values)| {
            let known = || values.iter().copied().filter(|t| t.is_finite());
            let shows = |first| known().any(|t| is_one(t, first));
            column.role == Role::Temperature && known().next().is_some_and(shows)
        })
    };
    let column = match known {
        Some(known) => known.thermometer?,
        None => find(|t, first| t != first).or_else(|| find(|t, _| t != 0.0))?,
    };
    let mut values = std::mem::take(&mut rows.columns[column]);
    let is_bare = format.columns[column].unit.is_empty();
    if let Some(board) = format.board.filter(|b| b.is_counts() && is_bare) {
        values.iter_mut().for_each(|v| *v = board.celsius(*v));
    }
    if known.is_some() {
        return Some((column, values));
    }
    let middle = judge::median(values.iter().copied())?;
    if judge::POSSIBLE_C.contains(&middle) {
        return Some((column, values));
    }
    let text = format!(
        "the temperature column is around {middle:.0}, not °C (raw counts?); it is not used"
    );
    findings.push(Finding::new(FindingKind::TemperatureUnit, text));
    None
}

/// Sets rows aside that were not read, or repeat because the sensor hung; empties the
/// accelerometer where it alone was not read. `marks_hung` as of [`judge::mark_hung`].
fn set_aside_defects(
    format: &Format,
    rows: &mut Batch,
    marks_hung: Option<bool>,
) -> Option<Finding> {
    let channels = format.channels();
    // Zero is no rate that a sensor at rest could not have.
    let mut emptied: Vec<u64> = Vec::new();
    if !format.columns[format.accel[0]].is_linear && !format.options.is_gyroscope {
        let values = rows.slices(&channels);
        let is_read = |row: usize| values.iter().any(|c| c[row] != 0.0);
        let keep: Vec<bool> = (0..rows.rows()).map(is_read).collect();
        rows.keep(&keep, Reason::Zeros);
        for run in judge::unread_runs(format.accel.map(|c| rows.columns[c].as_slice())) {
            for column in format.accel {
                rows.columns[column][run.clone()].fill(f64::NAN);
            }
            emptied.extend(rows.lines[run].iter().map(|l| u64::from(*l)));
        }
    }
    let keep = judge::mark_hung(&rows.slices(&channels), marks_hung);
    rows.keep(&keep, Reason::Hung);
    let text = format!(
        "the accelerometer reads zero on all axes in {} rows: it was not read; treated as empty",
        emptied.len()
    );
    let lines: LineSpans = emptied.into_iter().collect();
    (!lines.is_empty()).then(|| Finding::new(FindingKind::ZeroRows, text).at_lines(&lines))
}

/// Undoes an encoding; that of the gyroscope only if it is written so, too.
fn decode(format: &Format, rows: &mut Batch, encoding: Encoding) {
    for (channel, column) in format.channels().into_iter().enumerate() {
        let values = &mut rows.columns[column];
        let is_alike = || encoding == Encoding::TwosComplement && judge::are_unsigned(values);
        if channel < 3 || is_alike() {
            encoding.undo(values);
        }
    }
}

/// Accelerometer and gyroscope that stand side by side may be shifted against their names: the bus
/// lost a byte.
fn set_aside_slipped(format: &Format, rows: &mut Batch, known: Option<&Known>) {
    let (a, Some(g)) = (format.accel, format.gyro) else {
        return;
    };
    let is_adjacent = |axes: [usize; 3]| axes[1] == axes[0] + 1 && axes[2] == axes[0] + 2;
    let are_adjacent = is_adjacent(a) && is_adjacent(g) && a[0].abs_diff(g[0]) == 3;
    if !are_adjacent || known.is_some_and(|known| !is_off_at_the_end(format, rows, known)) {
        return;
    }
    let first = a[0].min(g[0]);
    let channels = std::array::from_fn(|i| rows.columns[first + i].as_slice());
    let gravity = known.and_then(|known| known.gravity);
    if let Some(row) = judge::slip(channels, a[0] - first, gravity) {
        let keep: Vec<bool> = (0..rows.rows()).map(|r| r < row).collect();
        rows.keep(&keep, Reason::Slipped);
    }
}

/// Whether the magnitude at the end of the new rows is not that of gravity.
fn is_off_at_the_end(format: &Format, rows: &Batch, known: &Known) -> bool {
    let last = known.anchor.map_or(0, |(line, _)| line);
    let from = rows.lines.partition_point(|line| *line <= last);
    let from = from.max(rows.rows().saturating_sub(SLIP_END_ROWS));
    let end = format.accel.map(|c| &rows.columns[c][from..]);
    let norm = known.gravity.zip(judge::quiet_norm(end));
    norm.is_some_and(|(gravity, norm)| (norm / gravity - 1.0).abs() >= SLIP_TOLERANCE)
}
