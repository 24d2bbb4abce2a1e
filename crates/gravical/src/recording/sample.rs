//! One row as numbers, for folds over a recording in memory or over its file.

use std::array::from_fn;

use super::Recording;

/// A row. What is missing is NaN.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    /// Time since the first row, s.
    pub time_s: f64,
    /// Accelerometer, without the offset of unsigned counts, and gyroscope.
    pub values: [f64; 6],
    pub temperature_c: f64,
    /// It does not continue the row before.
    pub is_break: bool,
}

impl Recording {
    /// Its rows.
    pub(crate) fn samples(&self) -> impl Iterator<Item = Sample> {
        let mut breaks = self.breaks.iter().peekable();
        let or_nan = |column: &Option<Vec<f64>>, row: usize| {
            column.as_ref().map_or(f64::NAN, |column| column[row])
        };
        (0..self.rows()).map(move |row| Sample {
            time_s: or_nan(&self.time_s, row),
            values: from_fn(|i| match (i, &self.gyro) {
                (0..3, _) => self.accel[i][row],
                (_, Some(gyro)) => gyro[i - 3][row],
                (_, None) => f64::NAN,
            }),
            temperature_c: or_nan(&self.temperature_c, row),
            is_break: breaks.next_if_eq(&&row).is_some(),
        })
    }
}
