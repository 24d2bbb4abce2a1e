//! Matrices as tables.

use crate::document::{Cell, Column, Row, Table};
use gravical::numfmt::{decimals_of, fixed};

/// R and the calibration matrix, side by side.
pub(super) fn matrices(orientation: &[[f64; 3]; 3], matrix: &[[f64; 3]; 3], name: &str) -> Table {
    let text = power_of_ten(matrix, 6);
    let row = |i: usize| {
        let mut cells = vec![Cell::text(["x", "y", "z"][i])];
        cells.extend(Cell::axes(Some(orientation[i]), |_, v| fixed(v, 5)));
        cells.extend(Cell::axes(Some(matrix[i]), |_, v| text(v)));
        Row::from(cells)
    };
    Table::new("")
        .columns([Column::left("")])
        .columns(Column::axes("R"))
        .columns(Column::axes(name))
        .rows((0..3).map(row))
}

/// Formats the elements of a matrix, with powers of ten if all are small.
pub(super) fn power_of_ten(matrix: &[[f64; 3]; 3], precision: usize) -> impl Fn(f64) -> String {
    let largest = matrix.iter().flatten().fold(0.0_f64, |a, v| a.max(v.abs()));
    move |v| match v {
        0.0 => "0".to_owned(),
        v if largest < 0.1 => format!("{v:.precision$e}"),
        v => fixed(v, decimals_of(largest, 6)),
    }
}
