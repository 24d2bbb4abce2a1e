//! What the head of a file says.

use super::dialect::Dialect;
use super::names::{Column, Role};
use super::words::Sentences;

#[derive(Clone, Debug)]
pub(crate) enum Layout {
    Table(Dialect),
    Sentences(Sentences),
}

impl Layout {
    /// Place of the last line of a row.
    pub(crate) fn last_place(&self) -> usize {
        match self {
            Layout::Table(_) => 0,
            Layout::Sentences(sentences) => sentences.last_place(),
        }
    }
}

/// What the head of a file says: dialect, roles of columns, claims of units and clock.
#[derive(Clone, Debug)]
pub struct Format {
    pub(crate) layout: Layout,
    pub(crate) line_end: u8,
    pub(crate) head_lines: usize,
    /// Columns that are parsed.
    pub(crate) is_read: Vec<bool>,
    /// Lines above the rows.
    pub(crate) metadata: Vec<String>,
    /// Names of the columns; empty without a header
    pub names: Vec<String>,
    /// What each column holds
    pub columns: Vec<Column>,
    /// Columns of the accelerometer, x, y, z
    pub accel: [usize; 3],
    /// Columns of the gyroscope
    pub gyro: Option<[usize; 3]>,
    /// Column that tells several sensors apart whose rows take turns, and their number
    pub sensor: Option<(usize, usize)>,
    /// Rate that the head states
    pub rate_hz: Option<f64>,
}

impl Format {
    pub(crate) fn new(layout: Layout, line_end: u8, names: Vec<String>, fields: usize) -> Self {
        let column = |c: usize| Column::from_name(names.get(c).map_or("", String::as_str));
        Format {
            layout,
            line_end,
            head_lines: 0,
            is_read: vec![true; fields],
            metadata: Vec::new(),
            columns: (0..fields).map(column).collect(),
            names,
            accel: [0; 3],
            gyro: None,
            sensor: None,
            rate_hz: None,
        }
    }

    pub(crate) fn asks_for(&self, column: usize) -> bool {
        self.is_axis(column)
            || self.sensor.is_some_and(|s| s.0 == column)
            || matches!(
                self.columns[column].role,
                Role::Time | Role::Step | Role::Temperature | Role::Label
            )
            || matches!(self.layout, Layout::Sentences(_))
    }

    /// Columns of accelerometer and gyroscope.
    pub(crate) fn channels(&self) -> Vec<usize> {
        self.accel
            .into_iter()
            .chain(self.gyro.into_iter().flatten())
            .collect()
    }

    pub(crate) fn is_axis(&self, column: usize) -> bool {
        self.accel.contains(&column) || self.gyro.is_some_and(|g| g.contains(&column))
    }
}
