//! What the head of a file says.

use std::slice;

use gravical_judge::finding::Misfit;
use gravical_judge::{ReadOptions, Role};

use super::dialect::Dialect;
use super::names::Column;
use super::rows::Rows;
use super::words::LinePattern;
use crate::board::BoardSettings;
use crate::date::compact_day_s;
use crate::metadata;

/// Names of the columns of calibrated specific force that `gravical apply` writes, in m/s² and in
/// g. Loggers use `ax_g` for what they measure.
pub const CALIBRATED: [[&str; 3]; 2] = [
    ["ax_mps2", "ay_mps2", "az_mps2"],
    ["ax_calibrated_g", "ay_calibrated_g", "az_calibrated_g"],
];

/// What the head of a file says: dialect, roles of columns, claims of units and clock.
#[derive(Clone, Debug, Default)]
pub struct Format {
    /// How the fields of a row are parted
    pub(crate) dialect: Dialect,
    /// The words around its numbers, if it is no table
    pub(crate) sentences: Option<LinePattern>,
    pub(crate) line_end: u8,
    pub(crate) head_lines: usize,
    /// Line that names the columns, from 1; 0 without one.
    pub(crate) header_line: usize,
    /// What it is in words, where it is no text: the device and its settings
    pub(crate) device: Option<String>,
    /// The file is packed
    pub(crate) is_packed: bool,
    /// Settings of our board, where the head has them.
    pub(crate) board: Option<BoardSettings>,
    /// Columns that are parsed.
    pub(crate) is_read: Vec<bool>,
    /// Lines above the rows
    pub metadata: Vec<String>,
    /// Names of the columns; empty without a header
    pub names: Vec<String>,
    /// What each column holds
    pub columns: Vec<Column>,
    /// Columns of the accelerometer, x, y, z
    pub accel: [usize; 3],
    /// Columns of the gyroscope
    pub gyro: Option<[usize; 3]>,
    /// Column that tells several sensors apart whose rows take turns
    pub sensor: Option<usize>,
    /// Columns of gravity that are added to those of the accelerometer, which lack it
    pub(crate) added: Option<[usize; 3]>,
    /// Names of all sensors of which one is read, unless the user asks for it
    pub(crate) sensors: Vec<String>,
    /// Which of them is read
    pub(crate) chosen: usize,
    /// The columns were recognised by their numbers
    pub(crate) is_guessed: bool,
    /// Why a line of names is no header
    pub(crate) misfit: Option<Misfit>,
    /// Columns whose sum is one stamp: date, time of day or hours, minutes and seconds, and a fraction
    pub(crate) stamp_parts: Vec<StampPart>,
    /// Columns that could be the time beside none that is named so
    pub(crate) unnamed_clocks: Vec<usize>,
    /// Columns of numbers that are used for nothing
    pub(crate) unread: Vec<usize>,
    /// The user says that there are no stamps
    pub(crate) has_no_clock: bool,
    /// What the user says
    pub options: ReadOptions,
    /// Rate that the head states
    pub rate_hz: Option<f64>,
}

/// A column that holds a part of the stamps.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum StampPart {
    /// Column, and seconds of one unit
    Unit(usize, f64),
    /// Columns of year, month and day, or one of days that are written as one number: 20240301
    Day(Vec<usize>),
}

impl StampPart {
    pub(crate) fn columns(&self) -> &[usize] {
        match self {
            StampPart::Unit(column, _) => slice::from_ref(column),
            StampPart::Day(columns) => columns,
        }
    }

    /// The sums of parts, s.
    pub(crate) fn sum(parts: &[StampPart], rows: &Rows) -> Vec<f64> {
        let second = |part: &StampPart, row: usize| match part {
            StampPart::Unit(column, unit_s) => rows.columns[*column][row] * unit_s,
            StampPart::Day(columns) => {
                let join = |day: f64, c: &usize| 100.0 * day + rows.columns[*c][row];
                compact_day_s(columns.iter().fold(0.0, join)).unwrap_or(f64::NAN)
            }
        };
        let sum = |row| parts.iter().map(|part| second(part, row)).sum();
        (0..rows.rows()).map(sum).collect()
    }
}

impl Format {
    pub(crate) fn new(dialect: Dialect, line_end: u8, names: Vec<String>) -> Self {
        let column = |c: usize| Column::from_name(names.get(c).map_or("", String::as_str));
        Format {
            dialect,
            line_end,
            is_read: vec![true; dialect.fields],
            columns: (0..dialect.fields).map(column).collect(),
            names,
            ..Format::default()
        }
    }

    /// The format in words: `comma separated, header in line 1`; the device, if it wrote no text.
    pub fn describe(&self) -> String {
        let packing = if self.is_packed { "gzip, " } else { "" };
        if let Some(device) = &self.device {
            return format!("{packing}{device}");
        }
        let header = match self.header_line {
            0 => "no header".to_owned(),
            line => format!("header in line {line}"),
        };
        let fields = match self.dialect.delimiter {
            _ if self.sentences.is_some() => "numbers in sentences",
            Some(b',') => "comma separated",
            Some(b';') => "semicolon separated",
            Some(b'\t') => "tab separated",
            Some(_) => "bar separated",
            None => "white space separated",
        };
        let decimals = if self.dialect.decimal_comma {
            ", decimal comma"
        } else {
            ""
        };
        format!("{packing}{fields}{decimals}, {header}")
    }

    /// Serial number of the sensor, where the lines above the header name it.
    pub fn serial(&self) -> Option<String> {
        metadata::serial(&self.metadata)
    }

    /// The board's settings line says that it sends calibrated values.
    pub fn is_calibrated_by_board(&self) -> bool {
        self.board.is_some_and(|board| board.is_calibrated())
    }

    /// The accelerometer is read from columns with the names that `gravical apply` writes, or a board
    /// calibrated it.
    pub fn is_calibrated(&self) -> bool {
        let reads = |own: &[&str; 3]| {
            let mut pairs = self.accel.iter().zip(own);
            pairs.all(|(column, own)| self.names.get(*column).is_some_and(|n| n == own))
        };
        self.is_calibrated_by_board() || CALIBRATED.iter().any(reads)
    }

    /// There are columns with the names that `gravical apply` writes, whether they are read or not: the file is a
    /// result, not a recording of a session.
    pub fn is_result(&self) -> bool {
        let has = |name: &&str| self.names.iter().any(|n| n == name);
        CALIBRATED.iter().any(|own| own.iter().all(has))
    }

    /// What a column is read as.
    pub(crate) fn role(&self, column: usize) -> Role {
        let axis = |axes: [usize; 3]| axes.iter().position(|c| *c == column);
        let accel = axis(self.accel).map(Role::Accel);
        let gyro = self.gyro.and_then(axis).map(Role::Gyro);
        accel.or(gyro).unwrap_or(match self.columns[column].role {
            Role::Accel(_) | Role::Gyro(_) => Role::Other,
            role => role,
        })
    }

    /// The column of the time, if there is but one.
    pub(crate) fn only_clock(&self) -> Option<usize> {
        let is_time = |c: &usize| self.columns[*c].role == Role::Time;
        let mut columns = (0..self.columns.len()).filter(is_time);
        columns.next().filter(|_| columns.next().is_none())
    }

    /// Columns of accelerometer and gyroscope.
    pub(crate) fn channels(&self) -> Vec<usize> {
        let gyro = self.gyro.into_iter().flatten();
        self.accel.into_iter().chain(gyro).collect()
    }
}
