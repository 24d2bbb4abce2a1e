//! From the rows of a file to a recording.

pub(crate) mod findings;
mod time;

pub(crate) use time::{find_clock, gap_text};

use std::collections::HashMap;

use super::{CALIBRATED, Labels, Recording};
use crate::error::Error;
use crate::finding::{Finding, FindingKind};
use crate::full_scale::Clipping;
use crate::judge::{self, AccelClaim, Encoding};
use crate::metadata;
use crate::role::Role;
use crate::text::{Batch, Format, Reason, no_rows, sensor_unknown};
use crate::units::{AccelUnit, GyroScale, GyroUnit, Origin};

use time::JudgedTime;

/// Sensors that are listed.
const MAX_SENSORS: usize = 256;
/// Names of the channels in messages.
const CHANNELS: [&str; 7] = ["ax", "ay", "az", "gx", "gy", "gz", "temperature"];
const ALONE: [&str; 7] = ["gx", "gy", "gz", "", "", "", ""];

impl Recording {
    /// Judges the rows of a whole file.
    ///
    /// # Errors
    ///
    /// There are no rows, or the sensor did not answer.
    pub fn judge(format: &Format, rows: Batch) -> Result<Self, Error> {
        Recording::judge_means(format, rows, None)
    }

    /// The same of rows that are means of samples with this resolution, if one is given: means of
    /// coarse samples are as fine as they are wrong.
    pub(crate) fn judge_means(
        format: &Format,
        mut rows: Batch,
        of_samples: Option<[f64; 6]>,
    ) -> Result<Self, Error> {
        let options = &format.options;
        let mut findings = findings::of_columns(format);
        if let Some((column, _)) = format.sensor {
            findings.extend(keep_sensor(format, &mut rows, column)?);
        }
        check_values(format, &rows)?;
        let text_cells = findings::of_text_cells(format, &rows);
        let temperature_c = take_temperature(format, &mut rows, &mut findings);
        let mut own = Vec::new();
        let mut time = JudgedTime::new(format, &rows, temperature_c.as_deref(), &mut own);
        let columns = format.columns.iter().zip(&mut rows.columns);
        let stamps = columns.filter(|(c, _)| matches!(c.role, Role::Time | Role::Step));
        stamps.for_each(|(_, column)| *column = Vec::new());
        // Rows that are set aside lose these, too.
        let has_temperature = temperature_c.is_some();
        rows.columns.push(std::mem::take(&mut time.time_s));
        rows.columns.push(temperature_c.unwrap_or_default());
        let emptied = set_aside_defects(format, &mut rows, of_samples.is_some());
        let encoding = decode(format, &mut rows);
        set_aside_slipped(format, &mut rows);
        let of_lines = findings::of_lines(&rows);
        let kept_temperature = rows.columns.pop().unwrap_or_default();
        let mut temperature_c = has_temperature.then_some(kept_temperature);
        let time_s = rows.columns.pop().unwrap_or_default();

        let mut accel = format.accel.map(|c| std::mem::take(&mut rows.columns[c]));
        let gyro = format.gyro;
        let mut gyro = gyro.map(|g| g.map(|c| std::mem::take(&mut rows.columns[c])));
        let zero_offset = options.zero_offset.unwrap_or(match encoding {
            Some(Encoding::OffsetBinary) => 32_768.0,
            _ => 0.0,
        });
        if options.zero_offset.is_some() {
            accel.iter_mut().flatten().for_each(|v| *v -= zero_offset);
        }
        findings.extend(of_lines);
        findings.extend(text_cells);
        findings.extend(encoding.map(|e| Finding::new(FindingKind::UnsignedCounts, e.to_string())));
        findings.append(&mut own);
        let (empty, is_held) = judge::fill_cells(
            &mut accel,
            gyro.as_mut(),
            temperature_c.as_mut(),
            &rows.lines,
            names(format),
        );
        findings.extend(empty);
        findings.extend(emptied);
        let resolution = of_samples.unwrap_or_else(|| resolution(&accel, gyro.as_ref()));
        let is_unsigned = encoding == Some(Encoding::OffsetBinary);
        let (axes, claim) = (accel.each_ref().map(Vec::as_slice), accel_claim(format));
        let judged = judge::accel_unit(axes, is_unsigned, claim, options);
        let mut breaks = rows.breaks.clone();
        breaks.extend(time.breaks(&rows, &time_s));
        breaks.sort_unstable();
        breaks.dedup();
        breaks.retain(|row| (1..rows.rows()).contains(row));
        let read_gyro = if options.is_gyroscope {
            Some((format.accel, &accel))
        } else {
            format.gyro.zip(gyro.as_ref())
        };
        let gyro_scale = read_gyro.map(|(c, gyro)| gyro_scale(format, c, gyro));
        let is_calibrated_by_board = format.board.is_some_and(|b| b.is_calibrated());
        let reads = |own: &[&str; 3]| {
            let mut pairs = format.accel.iter().zip(own);
            pairs.all(|(column, own)| format.names.get(*column).is_some_and(|n| n == own))
        };
        let mut recording = Recording {
            name: String::new(),
            sha256: None,
            description: format.describe(),
            serial: metadata::serial(&format.metadata),
            column_names: format.names.clone(),
            is_calibrated: is_calibrated_by_board || CALIBRATED.iter().any(reads),
            is_calibrated_by_board,
            accel,
            gyro,
            gyro_file: None,
            temperature_c,
            time_s: (!time_s.is_empty()).then_some(time_s),
            time_origin_s: time.start_s,
            stated_start_s: metadata::start_s(&format.metadata),
            restarted: !time.restarts.is_empty(),
            labels: find_labels(format, &rows)?,
            breaks,
            zero_offset,
            accel_scale: judged.scale,
            unit_doubt: judged.doubt,
            header_unit: claim.unit,
            gyro_scale,
            resolution,
            timing: time.timing,
            ledger: rows.ledger,
            findings,
            lines: rows.lines,
        };
        if !options.is_gyroscope {
            recording.findings.extend(judged.findings);
            let change = judge::unit_change(&recording.accel, &recording.lines, None);
            recording.findings.extend(change.map(|c| c.1));
        }
        recording.judge_samples(format, is_held);
        Ok(recording)
    }

    /// Frozen axes, values at the end of the range, repeats, columns of another sensor.
    fn judge_samples(&mut self, format: &Format, is_held: bool) {
        let [ax, ay, az, gx, gy, gz, _] = names(format);
        let (accel_step, gyro_step) = self.resolution.split_at(3);
        let mut findings = judge::frozen_axes(&self.accel, [ax, ay, az], accel_step, &self.lines);
        if let Some(gyro) = &self.gyro {
            let frozen = judge::frozen_axes(gyro, [gx, gy, gz], gyro_step, &self.lines);
            findings.extend(frozen);
        }
        for (channel, name, mut clipping) in self.ends_of_ranges(format) {
            clipping.observe_all(channel, &self.lines);
            findings.extend(clipping.finding(name));
        }
        if !is_held {
            let channels = self.accel.iter().chain(self.gyro.iter().flatten());
            let channels: Vec<&[f64]> = channels.map(Vec::as_slice).collect();
            findings.extend(judge::repeated_rows(
                &channels,
                &self.resolution,
                &self.lines,
            ));
        }
        if format.is_guessed {
            findings.extend(findings::not_an_accelerometer(&self.accel));
        }
        self.findings.append(&mut findings);
    }

    /// Channels, their names and what detects the ends of their ranges.
    pub(crate) fn ends_of_ranges(&self, format: &Format) -> Vec<(&[f64], &'static str, Clipping)> {
        let accel_end = Clipping::of_accel(&self.accel_scale);
        let gyro_end = self.gyro_scale.as_ref().map(Clipping::of_gyro);
        let accel = self.accel.iter().map(|channel| (channel, &accel_end));
        let gyro = self.gyro.iter().flatten().zip(gyro_end.iter().cycle());
        let channels = accel.chain(gyro).zip(names(format));
        channels
            .map(|((channel, end), name)| (channel.as_slice(), name, end.clone()))
            .collect()
    }
}

fn names(format: &Format) -> [&'static str; 7] {
    if format.options.is_gyroscope {
        ALONE
    } else {
        CHANNELS
    }
}

/// Keeps the rows of the sensor that the user asks for, else of the lowest number or first word.
pub(crate) fn keep_sensor(
    format: &Format,
    rows: &mut Batch,
    column: usize,
) -> Result<Option<Finding>, Error> {
    let label = |row: usize| cell_label(rows, column, row);
    let mut all: Vec<String> = Vec::new();
    for label in (0..rows.rows()).map(label) {
        if !label.is_empty() && all.len() < MAX_SENSORS && !all.contains(&label) {
            all.push(label);
        }
    }
    // Words stay in order.
    all.sort_by_key(|label| label.parse::<u64>().unwrap_or(u64::MAX));
    let wanted = match &format.options.sensor {
        Some(wanted) if all.contains(wanted) => wanted,
        Some(wanted) => return Err(sensor_unknown(wanted, &all)),
        None => match all.first() {
            Some(first) => first,
            None => return Ok(None),
        },
    };
    let keep: Vec<bool> = (0..rows.rows()).map(|row| label(row) == *wanted).collect();
    let finding = (format.options.sensor.is_none() && all.len() > 1).then(|| {
        let name = format.names.get(column).map_or("", String::as_str);
        let text = format!(
            "rows of {} sensors, distinguished by column {name}: {}; those of {wanted} are read, unless another is chosen",
            all.len(),
            all.join(", ")
        );
        Finding::new(FindingKind::SeveralSensors, text).advise("sensor", &all[1])
    });
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

/// Whether the sensor answered at all.
fn check_values(format: &Format, rows: &Batch) -> Result<(), Error> {
    let count = rows.rows();
    if count == 0 {
        return Err(no_rows(format!(
            "no row could be read: {}",
            rows.ledger.sum()
        )));
    }
    let (sensor, hint) = if format.options.is_gyroscope {
        (
            "gyroscope",
            "check that the sketch wakes the gyroscope, or leave its file out",
        )
    } else {
        (
            "accelerometer",
            "check the wiring (SDA, SCL, power) and that the sketch wakes the sensor",
        )
    };
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
        let text =
            format!("the {sensor} reads zero or nothing in all {count} rows: it did not answer");
        return Err(Error::input("all-zero", text).with_hint(hint));
    }
    Ok(())
}

/// The first thermometer that lives: one that stays at zero loses.
pub(crate) fn find_thermometer(format: &Format, rows: &Batch) -> Option<usize> {
    let is_alive = |v: &[f64]| v.iter().any(|t| t.is_finite() && *t != v[0]);
    let is_one = |c: &usize| format.columns[*c].role == Role::Temperature;
    let all = (0..format.columns.len()).filter(is_one);
    let is_known = |v: &[f64]| v.iter().any(|t| t.is_finite() && *t != 0.0);
    let mut alive = all.clone().filter(|c| is_alive(&rows.columns[*c]));
    let mut known = all.filter(|c| is_known(&rows.columns[*c]));
    alive.next().or_else(|| known.next())
}

/// Converts the counts of our board to °C.
pub(crate) fn celsius(format: &Format, thermometer: usize, values: &mut [f64]) {
    let board = format
        .board
        .filter(|b| b.is_counts() && format.columns[thermometer].unit.is_empty());
    if let Some(board) = board {
        values.iter_mut().for_each(|v| *v = board.celsius(*v));
    }
}

/// The temperature in °C.
fn take_temperature(
    format: &Format,
    rows: &mut Batch,
    findings: &mut Vec<Finding>,
) -> Option<Vec<f64>> {
    let column = find_thermometer(format, rows)?;
    let mut values = std::mem::take(&mut rows.columns[column]);
    celsius(format, column, &mut values);
    let middle = judge::median(values.iter().copied())?;
    if judge::POSSIBLE_C.contains(&middle) {
        return Some(values);
    }
    let text = format!(
        "the temperature column is around {middle:.0}, not °C (raw counts?); it is not used"
    );
    findings.push(Finding::new(FindingKind::TemperatureUnit, text));
    None
}

/// Sets rows aside that were not read, or repeat because the sensor hung; empties the
/// accelerometer where it alone was not read.
fn set_aside_defects(format: &Format, rows: &mut Batch, are_means: bool) -> Option<Finding> {
    let channels = format.channels();
    let mut emptied = None;
    // Zero is no rate that a sensor at rest could not have.
    if !format.columns[format.accel[0]].is_linear && !format.options.is_gyroscope {
        let values = rows.slices(&channels);
        let is_read = |row: usize| values.iter().any(|c| c[row] != 0.0);
        let keep: Vec<bool> = (0..rows.rows()).map(is_read).collect();
        rows.keep(&keep, Reason::Zeros);
        emptied = empty_unread(format, rows);
    }
    if !are_means {
        let values = rows.slices(&channels);
        let keep = judge::mark_hung([values[0], values[1], values[2]], &values[3..]);
        rows.keep(&keep, Reason::Hung);
    }
    emptied
}

fn empty_unread(format: &Format, rows: &mut Batch) -> Option<Finding> {
    let (runs, _) = judge::unread_runs(format.accel.map(|c| rows.columns[c].as_slice()), 0);
    let mut lines = Vec::new();
    for run in runs {
        for column in format.accel {
            rows.columns[column][run.clone()].fill(f64::NAN);
        }
        lines.extend(rows.lines[run].iter().map(|l| u64::from(*l)));
    }
    let text = format!(
        "the accelerometer reads zero on all axes in {} rows: it was not read; treated as empty",
        lines.len()
    );
    (!lines.is_empty())
        .then(|| Finding::new(FindingKind::ZeroRows, text).at_lines(&lines.into_iter().collect()))
}

/// Undoes an encoding of all channels, unless the user says where zero is.
fn decode(format: &Format, rows: &mut Batch) -> Option<Encoding> {
    if format.options.zero_offset.is_some() || format.options.is_gyroscope {
        return None;
    }
    let mut accel = format.accel.map(|c| std::mem::take(&mut rows.columns[c]));
    let mut gyro = format
        .gyro
        .map(|g| g.map(|c| std::mem::take(&mut rows.columns[c])));
    let encoding = judge::decode(&mut accel, gyro.as_mut());
    let values = accel.into_iter().chain(gyro.into_iter().flatten());
    for (column, values) in format.channels().into_iter().zip(values) {
        rows.columns[column] = values;
    }
    encoding
}

/// Accelerometer and gyroscope that stand side by side may be shifted against their names.
fn set_aside_slipped(format: &Format, rows: &mut Batch) {
    let channels = rows.slices(&format.channels());
    let Ok(channels) = <[&[f64]; 6]>::try_from(channels) else {
        return;
    };
    if let Some(row) = slipped_row(format, channels) {
        let keep: Vec<bool> = (0..rows.rows()).map(|r| r < row).collect();
        rows.keep(&keep, Reason::Slipped);
    }
}

/// The row from which on the channels, those of the accelerometer first, are shifted.
pub(crate) fn slipped_row(format: &Format, channels: [&[f64]; 6]) -> Option<usize> {
    let (a, g) = (format.accel, format.gyro?);
    let is_adjacent = |axes: [usize; 3]| axes[1] == axes[0] + 1 && axes[2] == axes[0] + 2;
    if !is_adjacent(a) || !is_adjacent(g) || a[0].abs_diff(g[0]) != 3 {
        return None;
    }
    let [ax, ay, az, gx, gy, gz] = channels;
    if a[0] < g[0] {
        judge::slip(channels, 0)
    } else {
        judge::slip([gx, gy, gz, ax, ay, az], 3)
    }
}

/// What header and board claim about the accelerometer.
fn accel_claim(format: &Format) -> AccelClaim {
    let column = &format.columns[format.accel[0]];
    let mut claim = AccelClaim {
        unit: AccelUnit::parse(&column.unit),
        lsb_per_g: AccelUnit::per_g(&column.unit),
        without_gravity: column.is_linear,
    };
    let board = format
        .board
        .filter(|b| b.is_counts() && b.accel_range_g > 0);
    if let (Some(board), None) = (board, claim.unit) {
        claim.unit = Some(AccelUnit::Counts);
        claim.lsb_per_g = Some(board.lsb_per_g());
    }
    // For other counts a converter of 16 bits is assumed unless gravity contradicts.
    if claim.unit == Some(AccelUnit::Counts) && claim.lsb_per_g.is_none() {
        claim.lsb_per_g = metadata::range_g(&format.metadata).map(|range| 32_768.0 / range);
    }
    claim
}

/// The unit of the gyroscope before any turn was evaluated.
fn gyro_scale(format: &Format, columns: [usize; 3], gyro: &[Vec<f64>; 3]) -> GyroScale {
    let options = &format.options;
    let text = &format.columns[columns[0]].unit;
    let board = format
        .board
        .filter(|b| b.is_counts() && GyroUnit::parse(text).is_none());
    let claimed = GyroUnit::parse(text).or(board.map(|_| GyroUnit::Counts));
    let values = || gyro.iter().flatten();
    let are_counts =
        values().all(|v| v.is_nan() || v.fract() == 0.0) && values().any(|v| v.abs() >= 1.0);
    let (unit, origin) = match (options.gyro_unit, claimed) {
        (Some(unit), _) => (unit, Origin::Given),
        (None, Some(unit)) => (unit, Origin::Header),
        (None, None) if are_counts => (GyroUnit::Counts, Origin::Data),
        (None, None) => (GyroUnit::Unknown, Origin::Assumed),
    };
    let range = options.gyro_range_deg_s.map(|range| 32_768.0 / range);
    let by_board = || board.and_then(|b| b.lsb_per_deg_s());
    GyroScale {
        unit,
        lsb_per_deg_s: range
            .or_else(|| GyroUnit::per_deg_s(text))
            .or_else(by_board),
        origin,
    }
}

pub(crate) fn resolution(accel: &[Vec<f64>; 3], gyro: Option<&[Vec<f64>; 3]>) -> [f64; 6] {
    let [ax, ay, az] = judge::resolution(accel);
    let [gx, gy, gz] = gyro.map_or([0.0; 3], judge::resolution);
    [ax, ay, az, gx, gy, gz]
}

fn find_labels(format: &Format, rows: &Batch) -> Result<Option<Labels>, Error> {
    let Some(column) = format.columns.iter().position(|c| c.role == Role::Label) else {
        return Ok(None);
    };
    if rows.texts[column].contains(&u8::MAX) {
        return Err(Error::input(
            "too-many-labels",
            "the label column holds more than 254 words",
        )
        .with_hint("leave the column out, or cut the file")
        .advise("columns", "label=-"));
    }
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
    Ok(Some(labels))
}
