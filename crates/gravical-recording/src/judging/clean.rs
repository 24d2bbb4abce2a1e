//! From the rows of a file to measurements of one sensor: timed, decoded, without rows that are not measurements.

use std::collections::HashMap;
use std::ops::Range;

use gravical_judge::finding::Case;
use gravical_judge::units::{POSSIBLE_C, Units};
use gravical_judge::{self as judge, Encoding, Finding, LineSpans, Role};

use super::findings;
use super::time::JudgedTime;
use crate::problem::Problem;
use crate::recording::{Labels, ReadAs, Recording};
use crate::text::{Format, Reason, Rows, sensor_of_file};

/// Sensors that are listed.
const MAX_SENSORS: usize = 256;
/// Names of the channels in messages.
const CHANNELS: [&str; 6] = ["ax", "ay", "az", "gx", "gy", "gz"];

/// The measurements of one sensor as a recording whose units are not judged yet.
///
/// # Errors
///
/// There are no rows, or the sensor did not answer.
pub(super) fn clean(format: &Format, mut rows: Rows) -> Result<Recording, Problem> {
    let options = &format.options;
    let mut findings = findings::of_columns(format);
    let mut read_as = ReadAs::default();
    if let Some(column) = format.sensor {
        let (sensor, finding) = select_sensor(format, &mut rows, column)?;
        read_as.sensor = sensor;
        findings.extend(finding);
    }
    add_gravity(format, &mut rows);
    check_values(format, &rows)?;
    let text_cells = findings::of_text_cells(format, &rows);
    let (temperature, of_temperature) = take_temperature(format, &mut rows);
    let (thermometer, temperature_c) = temperature.unzip();
    let has_unknown_temperature = of_temperature.is_some();
    findings.extend(of_temperature);
    read_as.thermometer = thermometer;
    let mut of_time = Vec::new();
    let mut time = JudgedTime::new(format, &mut rows, temperature_c.as_deref(), &mut of_time);
    let columns = format.columns.iter().zip(&mut rows.columns);
    let stamps = columns.filter(|(c, _)| matches!(c.role, Role::Time | Role::Step));
    stamps.for_each(|(_, column)| *column = Vec::new());
    // Rows that are set aside lose these, too.
    rows.columns.push(std::mem::take(&mut time.time_s));
    rows.columns.push(temperature_c.unwrap_or_default());
    let emptied = set_aside_defects(format, &mut rows);
    let accel = format.accel.map(|c| rows.columns[c].as_slice());
    // A rate is as often below as above the middle.
    let is_possible = |e: &Encoding| !options.is_gyroscope || *e == Encoding::TwosComplement;
    let encoding = Encoding::of(accel).filter(is_possible);
    read_as.encoding = encoding.filter(|_| options.zero_offset.is_none());
    if let Some(encoding) = read_as.encoding {
        decode(format, &mut rows, encoding);
        findings.push(Case::UnsignedCounts { encoding }.finding());
    }
    let invalid = empty_invalid_counts(format, &mut rows);
    let tells_blanks = judge::regular_blanks(&rows.blanks, rows.rows()) == 0;
    let of_lines = findings::of_lines(&rows.ledger, &rows.nul_lines, tells_blanks);
    findings.extend(of_lines.into_iter().chain(text_cells));
    findings.append(&mut of_time);

    let temperature_c = rows.columns.pop().unwrap_or_default();
    time.time_s = rows.columns.pop().unwrap_or_default();
    let mut breaks = std::mem::take(&mut rows.breaks);
    let (headers, blanks) = (&rows.headers, &rows.blanks);
    let (rate_hz, count) = (time.clock.median_rate_hz, rows.rows());
    breaks.extend(judge::breaks(headers, blanks, &time.time_s, rate_hz, count));
    breaks.sort_unstable();
    breaks.dedup();
    breaks.retain(|row| (1..count).contains(row));
    let labels = find_labels(format, &rows)?;
    let mut take = |c: usize| std::mem::take(&mut rows.columns[c]);
    let mut accel = format.accel.map(&mut take);
    let gyro = format.gyro.map(|g| g.map(&mut take));
    if let Some(offset) = options.zero_offset {
        accel.iter_mut().flatten().for_each(|v| *v -= offset);
    }
    let mut recording = Recording {
        name: String::new(),
        sha256: None,
        gyro_file: None,
        format: format.clone(),
        accel,
        gyro,
        temperature_c: thermometer.map(|_| temperature_c),
        time_s: Some(time.time_s).filter(|time_s| !time_s.is_empty()),
        labels,
        lines: rows.lines,
        breaks,
        ledger: rows.ledger,
        read_as,
        clock: time.clock,
        units: Units {
            has_unknown_temperature,
            ..Units::default()
        },
        why_unit_unknown: None,
        findings,
    };
    let texts: Vec<&[u8]> = format
        .channels()
        .iter()
        .map(|c| &rows.texts[*c][..])
        .collect();
    let empty = recording.fill_cells(&texts, invalid);
    recording.findings.extend(empty.into_iter().chain(emptied));
    Ok(recording)
}

/// Adds gravity to acceleration without it, where both stand in the rows.
pub(crate) fn add_gravity(format: &Format, rows: &mut Rows) {
    let added = format.added.into_iter().flatten();
    for (column, added) in format.accel.into_iter().zip(added) {
        let gravity = std::mem::take(&mut rows.columns[added]);
        let cells = rows.columns[column].iter_mut().zip(gravity);
        cells.for_each(|(cell, gravity)| *cell += gravity);
    }
}

/// Names of the channels of a format, in messages.
pub(super) fn names(format: &Format) -> &'static [&'static str] {
    &CHANNELS[if format.options.is_gyroscope { 3 } else { 0 }..]
}

/// Keeps the rows of the sensor that the user asks for, else of the first word that names one of its
/// kind, else of the lowest number or first word.
fn select_sensor(
    format: &Format,
    rows: &mut Rows,
    column: usize,
) -> Result<(Option<String>, Option<Finding>), Problem> {
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
    let is_of = |name: &String, label: &u32| labels.names[*label as usize] == *name;
    let answers = |name: &&String| {
        let is_value = |(label, v): (&u32, &f64)| is_of(name, label) && *v != 0.0 && !v.is_nan();
        let mut axes = format.accel.iter().map(|c| &rows.columns[*c]);
        axes.any(|axis| labels.of_row.iter().zip(axis).any(is_value))
    };
    let is_named = |name: &&String| sensor_of_file(name) == Some(kind);
    let named = sensors.iter().filter(is_named);
    let named = named.min_by_key(|name| name.contains("linear"));
    let usual = named.or_else(|| sensors.iter().find(answers));
    let usual = usual.or(sensors.first());
    let wanted = match (&format.options.sensor, usual) {
        (Some(wanted), _) if sensors.contains(wanted) => wanted,
        (Some(wanted), _) => {
            let wanted = wanted.clone();
            return Err(Problem::SensorUnknown { wanted, sensors });
        }
        (None, Some(first)) => first,
        (None, None) => return Ok((None, None)),
    };
    let other = sensors.iter().find(|name| *name != wanted);
    let other = other.filter(|_| format.options.sensor.is_none());
    let finding = other.map(|other| {
        let case = Case::SensorsInRows {
            column: format.names.get(column).cloned().unwrap_or_default(),
            sensors: sensors.clone(),
            read: wanted.clone(),
        };
        case.finding().advise("sensor", other)
    });
    let is_kept = |label: &u32| is_of(wanted, label);
    let keep: Vec<bool> = labels.of_row.iter().map(is_kept).collect();
    rows.keep(&keep, Reason::OtherSensor);
    Ok((Some(wanted.clone()), finding))
}

/// A cell as text: its word, its number, or nothing.
pub(crate) fn cell_label(rows: &Rows, column: usize, row: usize) -> String {
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
fn column_labels(rows: &Rows, column: usize) -> Labels {
    let mut labels = Labels::default();
    let mut known: HashMap<String, u32> = HashMap::new();
    for row in 0..rows.rows() {
        let name = cell_label(rows, column, row);
        let next = labels.names.len() as u32;
        let at = known.entry(name).or_insert_with_key(|name| {
            labels.names.push(name.clone());
            next
        });
        labels.of_row.push(*at);
    }
    labels
}

fn find_labels(format: &Format, rows: &Rows) -> Result<Option<Labels>, Problem> {
    let Some(column) = format.columns.iter().position(|c| c.role == Role::Label) else {
        return Ok(None);
    };
    if rows.texts[column].contains(&u8::MAX) {
        return Err(Problem::TooManyLabels);
    }
    Ok(Some(column_labels(rows, column)))
}

/// Whether the sensor answered at all.
fn check_values(format: &Format, rows: &Rows) -> Result<(), Problem> {
    let count = rows.rows();
    if count == 0 {
        let sum = rows.ledger.sum();
        return Err(Problem::NoRowRead { sum });
    }
    let channels = format.accel.map(|c| &rows.columns[c]);
    for (values, channel) in channels.iter().zip(names(format)) {
        if values.iter().all(|v| v.is_nan()) {
            let rows = count;
            return Err(Problem::NoValues { channel, rows });
        }
    }
    let is_zero = |c: &&Vec<f64>| c.iter().all(|v| v.is_nan() || *v == 0.0);
    if channels.iter().all(is_zero) {
        let axes = if format.names.is_empty() {
            names(format)[..3].iter().map(|n| (*n).to_owned()).collect()
        } else {
            let name = |c: usize| format.names.get(c).cloned().unwrap_or_default();
            format.accel.map(name).to_vec()
        };
        return Err(Problem::AllZero { axes, rows: count });
    }
    Ok(())
}

/// The column of the thermometer, and the temperature in °C; a finding if it is in another unit. Of several
/// the first that changes, else the first that is not zero.
fn take_temperature(
    format: &Format,
    rows: &mut Rows,
) -> (Option<(usize, Vec<f64>)>, Option<Finding>) {
    let known = |c: usize| rows.columns[c].iter().filter(|t| t.is_finite());
    let is_one = |c: &usize| format.columns[*c].role == Role::Temperature;
    let columns = || (0..format.columns.len()).filter(is_one);
    let changes = |c: &usize| {
        let first = known(*c).next();
        known(*c).any(|t| Some(t) != first)
    };
    let shows = |c: &usize| known(*c).any(|t| *t != 0.0);
    let Some(column) = columns().find(changes).or_else(|| columns().find(shows)) else {
        return (None, None);
    };
    let mut values = std::mem::take(&mut rows.columns[column]);
    to_celsius(format, column, &mut values);
    let finite = values.iter().filter(|t| t.is_finite());
    let possible = finite.clone().filter(|t| POSSIBLE_C.contains(*t));
    if 2 * possible.count() > finite.count() {
        return (Some((column, values)), None);
    }
    let middle = judge::median(values.iter().copied()).unwrap_or(f64::NAN);
    (None, Some(Case::TemperatureUnit { middle }.finding()))
}

/// Counts of the thermometer of our board as °C.
pub(crate) fn to_celsius(format: &Format, column: usize, values: &mut [f64]) {
    let is_bare = format.columns[column].unit.is_empty();
    if let Some(board) = format.board.filter(|b| b.is_counts() && is_bare) {
        values.iter_mut().for_each(|v| *v = board.celsius(*v));
    }
}

/// Sets rows aside that were not read, or repeat because the sensor hung; empties the
/// accelerometer where it alone was not read.
fn set_aside_defects(format: &Format, rows: &mut Rows) -> Option<Finding> {
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
                empty_failed(rows, column, run.clone());
            }
            emptied.extend(rows.lines[run].iter().map(|l| u64::from(*l)));
        }
    }
    let keep = judge::detect_stuck(&rows.slices(&channels));
    rows.keep(&keep, Reason::Hung);
    let rows = emptied.len();
    let lines: LineSpans = emptied.into_iter().collect();
    (rows > 0).then(|| Case::ZeroAccel { rows }.finding().at_lines(&lines))
}

/// Empties cells that hold a failed reading: as in those of text no value before holds there.
fn empty_failed(rows: &mut Rows, column: usize, cells: Range<usize>) {
    let count = rows.rows();
    rows.columns[column][cells.clone()].fill(f64::NAN);
    rows.texts[column].resize(count, 0);
    rows.texts[column][cells].fill(u8::MAX);
}

/// Lowest count of 16 bits, with which drivers mark a sample as invalid.
const INVALID_COUNT: f64 = -32_768.0;
/// No neighbour of an invalid sample is so near to the end of the range.
const NEAR_END: f64 = -30_000.0;

/// Empties cells of counts that hold the lowest one alone among ordinary neighbours; how many.
fn empty_invalid_counts(format: &Format, rows: &mut Rows) -> usize {
    let mut count = 0;
    for column in format.channels() {
        for row in 0..rows.rows() {
            let values = &rows.columns[column];
            let beside = [row.wrapping_sub(1), row + 1].map(|beside| values.get(beside));
            let is_ordinary = |v: &f64| *v > NEAR_END || v.is_nan();
            if values[row] == INVALID_COUNT && beside.into_iter().flatten().all(is_ordinary) {
                empty_failed(rows, column, row..row + 1);
                count += 1;
            }
        }
    }
    count
}

/// Undoes an encoding; that of the gyroscope only if it is written so, too.
pub(crate) fn decode(format: &Format, rows: &mut Rows, encoding: Encoding) {
    for (channel, column) in format.channels().into_iter().enumerate() {
        let values = &mut rows.columns[column];
        let is_alike = || encoding == Encoding::TwosComplement && judge::are_unsigned(values);
        if channel < 3 || is_alike() {
            encoding.undo(values);
        }
    }
}
