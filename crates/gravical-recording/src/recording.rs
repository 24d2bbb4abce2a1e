//! A recording: one batch that holds everything, and what was judged of it.

use std::io::{BufRead, Cursor, ErrorKind, Read};
use std::path::Path;

use crate::bytes;
use crate::error::{Error, Kind};
use crate::judge::{self, AccelScale, Clock, ClockOptions, Encoding};
use crate::note::Note;
use crate::text::{Aside, Batch, Format, Reason, Role, retain, sensor_codes, sniff};
use crate::units::{AccelUnit, GyroUnit, time_scale_s};

/// Bytes of the text that decide on the format.
const HEAD_BYTES: usize = 262_144;
/// Bytes that the columns of a recording may take.
const MAX_BYTES: usize = 1 << 30;

/// What a column of labels says.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Labels {
    /// The names, in order of appearance
    pub names: Vec<String>,
    /// For each row the number of its name, from 1; 0 for a row without one
    pub codes: Vec<u8>,
}

/// Everything that a file holds, in columns, and what was judged of it.
#[derive(Clone, PartialEq, Debug)]
pub struct Recording {
    /// Time of each row from the first on, s; empty without clock and rate
    pub time_s: Vec<f64>,
    /// Specific force in the unit of the file
    pub accel: [Vec<f64>; 3],
    /// Its unit, with the nominal scale
    pub accel_scale: AccelScale,
    /// How the numbers were written, where it was undone
    pub encoding: Option<Encoding>,
    /// Angular rate in the unit of the file
    pub gyro: Option<[Vec<f64>; 3]>,
    /// Its unit, where the head gives it
    pub gyro_unit: Option<GyroUnit>,
    /// Temperature in °C; NaN where a cell is empty
    pub temperature_c: Option<Vec<f64>>,
    /// Placement or section of each row
    pub labels: Option<Labels>,
    /// Rows per second
    pub rate_hz: Option<f64>,
    /// Rows before which the recording breaks
    pub breaks: Vec<usize>,
    /// Line in which each row begins, from 1
    pub lines: Vec<u32>,
    /// Lines and rows that were set aside; with the rows they are all lines
    pub aside: Aside,
    /// What whoever uses the recording should know
    pub notes: Vec<Note>,
}

impl Recording {
    /// Reads a file; `-` is standard input.
    ///
    /// # Errors
    ///
    /// The file cannot be read, or holds no samples of an accelerometer.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Recording::read(bytes::open(path)?, &name)
    }

    /// Reads UTF-8 (see [`bytes::utf8`]); the name of the file may tell the sensor.
    ///
    /// # Errors
    ///
    /// Reading fails, or there are no samples of an accelerometer.
    pub fn read(mut text: impl BufRead, file_name: &str) -> Result<Self, Error> {
        let head = bytes::read_head(&mut text, HEAD_BYTES)?;
        let format = sniff(&whole_lines(&head), file_name)?;
        let mut rows = Batch::default();
        let mut is_cut = false;
        for batch in format.batches(Cursor::new(head).chain(text)) {
            match batch {
                Ok(batch) => rows.append(batch),
                Err(e) if e.kind() == ErrorKind::UnexpectedEof && rows.rows() > 0 => is_cut = true,
                Err(e) => return Err(e.into()),
            }
            if rows.bytes() > MAX_BYTES {
                return Err(Kind::TooLarge(rows.bytes()).into());
            }
        }
        let mut recording = Recording::judge(&format, rows)?;
        recording.notes.extend(is_cut.then_some(Note::CutOff));
        Ok(recording)
    }

    /// Judges the rows of a whole file.
    ///
    /// # Errors
    ///
    /// There are no rows.
    pub fn judge(format: &Format, mut rows: Batch) -> Result<Self, Error> {
        let mut notes = Vec::new();
        if let Some((column, sensors)) = format.sensor {
            keep_first_sensor(&mut rows, column);
            notes.push(Note::Sensors(sensors));
        }
        if rows.rows() == 0 {
            return Err(Kind::NoTable.into());
        }
        let (mut time_s, rate_hz) = judge_clock(format, &rows, &mut notes);
        notes.extend(unreadable_cells(format, &rows));
        set_aside_defects(format, &mut rows, &mut time_s);
        let mut accel = format.accel.map(|c| std::mem::take(&mut rows.columns[c]));
        let mut gyro = format
            .gyro
            .map(|g| g.map(|c| std::mem::take(&mut rows.columns[c])));
        let encoding = judge::decode(&mut accel, gyro.as_mut());
        notes.extend(encoding.map(Note::Encoded));
        if let Some(row) = slipped_row(format, &accel, gyro.as_ref()) {
            let keep: Vec<bool> = (0..rows.rows()).map(|r| r < row).collect();
            rows.keep(&keep, Reason::Slipped);
            let channels = accel.iter_mut().chain(gyro.iter_mut().flatten());
            channels.chain([&mut time_s]).for_each(|c| c.truncate(row));
        }
        for axis in &mut accel {
            judge::hold_slow(axis);
        }
        let accel_scale = judge_unit(format, &accel, encoding, &mut notes);
        let breaks = judge::breaks(&time_s, rate_hz, &rows.breaks, &rows.blanks, rows.rows());
        notes.extend(
            format.columns[format.accel[0]]
                .is_linear
                .then_some(Note::Linear),
        );
        notes.extend((rows.rejected > 0).then_some(Note::Rejected(rows.rejected)));
        notes.extend(notes_of_aside(&rows.aside));
        Ok(Recording {
            time_s,
            accel,
            accel_scale,
            encoding,
            gyro,
            gyro_unit: format
                .gyro
                .and_then(|g| GyroUnit::parse(&format.columns[g[0]].unit)),
            temperature_c: find_thermometer(format, &rows)
                .map(|c| std::mem::take(&mut rows.columns[c])),
            labels: find_labels(format, &mut rows),
            rate_hz,
            breaks,
            lines: rows.lines,
            aside: rows.aside,
            notes,
        })
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.lines.len()
    }
}

/// The head as text, without the line that it cuts.
fn whole_lines(head: &[u8]) -> String {
    let is_cut = head.len() == HEAD_BYTES;
    let end = head
        .iter()
        .rposition(|b| is_cut && matches!(b, b'\n' | b'\r'));
    String::from_utf8_lossy(&head[..end.map_or(head.len(), |e| e + 1)]).into_owned()
}

pub(crate) fn slices<'a>(rows: &'a Batch, columns: &[usize]) -> Vec<&'a [f64]> {
    columns
        .iter()
        .map(|c| rows.columns[*c].as_slice())
        .collect()
}

fn keep_first_sensor(rows: &mut Batch, column: usize) {
    let keep: Vec<bool> = match sensor_codes(rows, column) {
        Some(codes) => codes.iter().map(|c| *c == codes[0]).collect(),
        None => rows.columns[column]
            .iter()
            .map(|v| *v == rows.columns[column][0])
            .collect(),
    };
    rows.keep(&keep, Reason::OtherSensor);
}

/// Times of the rows and their rate: by the stamps, else by the rate that the head states.
fn judge_clock(format: &Format, rows: &Batch, notes: &mut Vec<Note>) -> (Vec<f64>, Option<f64>) {
    if let Some(clock) = find_clock(format, rows) {
        notes.extend((clock.bad_stamps > 0).then_some(Note::BadStamps(clock.bad_stamps)));
        notes.extend((clock.missing > 0).then_some(Note::MissingRows(clock.missing)));
        return (clock.time_s, Some(clock.rate_hz));
    }
    notes.extend(unread_stamps(format, rows));
    if let Some(rate_hz) = format.rate_hz {
        return (
            (0..rows.rows()).map(|row| row as f64 / rate_hz).collect(),
            Some(rate_hz),
        );
    }
    notes.push(Note::NoRate);
    (Vec::new(), None)
}

fn unreadable_cells(format: &Format, rows: &Batch) -> Option<Note> {
    let texts = format.channels().into_iter().flat_map(|c| &rows.texts[c]);
    let count = texts.filter(|t| **t > 0).count();
    (count > 0).then_some(Note::Unreadable(count))
}

/// Sets rows aside that were not read, or repeat because the sensor hung.
fn set_aside_defects(format: &Format, rows: &mut Batch, time_s: &mut Vec<f64>) {
    let channels = format.channels();
    let keep = judge::mark_zeros(&slices(rows, &channels));
    rows.keep(&keep, Reason::Zeros);
    retain(time_s, &keep);
    let axes = format.accel.map(|c| rows.columns[c].as_slice());
    let keep = judge::mark_hung(axes, &slices(rows, &channels[3..]));
    rows.keep(&keep, Reason::Hung);
    retain(time_s, &keep);
}

/// The column of time that rises most often and most evenly; steps only if there is no other.
fn find_clock(format: &Format, rows: &Batch) -> Option<Clock> {
    let mut candidates = Vec::new();
    for (column, values) in format.columns.iter().zip(&rows.columns) {
        let is_step = match column.role {
            Role::Time => !column.is_dated && judge::holds_steps(values),
            Role::Step => true,
            _ => continue,
        };
        let stamps = if is_step {
            judge::sum_steps(values)
        } else {
            values.clone()
        };
        let unit_s = if column.is_dated {
            Some(1.0)
        } else {
            time_scale_s(&column.unit)
        };
        candidates.push((is_step, stamps, unit_s));
    }
    if candidates.len() > 1 {
        // The last of equals: files begin with the coarser clock.
        let score = |(is_step, stamps, _): &(bool, Vec<f64>, _)| {
            judge::steadiness(stamps).map_or(f64::MIN, |s| if *is_step { s - 1.0 } else { s })
        };
        candidates.sort_by(|a, b| score(a).total_cmp(&score(b)));
    }
    let (_, stamps, unit_s) = candidates.pop()?;
    judge::clock(
        stamps,
        ClockOptions {
            unit_s,
            rate_hz: format.rate_hz,
        },
    )
}

/// Accelerometer and gyroscope that stand side by side may be shifted against their names.
pub(crate) fn slipped_row(
    format: &Format,
    accel: &[Vec<f64>; 3],
    gyro: Option<&[Vec<f64>; 3]>,
) -> Option<usize> {
    let (a, g, gyro) = (format.accel, format.gyro?, gyro?);
    let is_adjacent = |axes: [usize; 3]| axes[1] == axes[0] + 1 && axes[2] == axes[0] + 2;
    if !is_adjacent(a) || !is_adjacent(g) || a[0].abs_diff(g[0]) != 3 {
        return None;
    }
    let (first, second) = if a[0] < g[0] {
        (accel, gyro)
    } else {
        (gyro, accel)
    };
    let channels = [
        &first[0], &first[1], &first[2], &second[0], &second[1], &second[2],
    ]
    .map(Vec::as_slice);
    judge::slip(channels, if a[0] < g[0] { 0 } else { 3 })
}

fn judge_unit(
    format: &Format,
    accel: &[Vec<f64>; 3],
    encoding: Option<Encoding>,
    notes: &mut Vec<Note>,
) -> AccelScale {
    if encoding == Some(Encoding::OffsetBinary) {
        return AccelScale {
            unit: Some(AccelUnit::Counts),
            counts_per_g: None,
        };
    }
    let claim = AccelUnit::parse(&format.columns[format.accel[0]].unit);
    let scale = judge::accel_scale(accel.each_ref().map(Vec::as_slice), claim);
    match (claim, scale.unit) {
        (Some(claim), unit) if unit != Some(claim) => {
            notes.push(Note::UnitContradicted(claim, unit))
        }
        (None, None) => notes.push(Note::UnitUnknown),
        _ => {}
    }
    scale
}

/// The first thermometer that lives: one that stays at zero loses.
pub(crate) fn find_thermometer(format: &Format, rows: &Batch) -> Option<usize> {
    let mut columns = format.columns.iter().zip(&rows.columns);
    let is_alive = |v: &[f64]| v.iter().any(|t| t.is_finite() && *t != 0.0);
    columns.position(|(c, v)| c.role == Role::Temperature && is_alive(v))
}

fn find_labels(format: &Format, rows: &mut Batch) -> Option<Labels> {
    let is_label = |c: &usize| format.columns[*c].role == Role::Label && rows.is_text(*c);
    let column = (0..format.columns.len()).find(is_label)?;
    let names = std::mem::take(&mut rows.words[column]);
    Some(Labels {
        names,
        codes: std::mem::take(&mut rows.texts[column]),
    })
}

/// A column of time that holds text, where no other column is a clock.
fn unread_stamps(format: &Format, rows: &Batch) -> Option<Note> {
    let mut columns = format.columns.iter().zip(&rows.words);
    let (_, words) = columns.find(|(c, words)| c.role == Role::Time && !words.is_empty())?;
    words.first().cloned().map(Note::StampsUnread)
}

fn notes_of_aside(aside: &Aside) -> impl Iterator<Item = Note> + '_ {
    let is_expected = |r: &Reason| {
        matches!(
            r,
            Reason::Head | Reason::Blank | Reason::Comment | Reason::Continuation
        )
    };
    let others = aside
        .reasons
        .iter()
        .filter(move |(reason, _)| !is_expected(reason));
    others.map(|(reason, (count, line))| Note::SetAside(*reason, *count, *line))
}
