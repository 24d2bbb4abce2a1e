//! Report of the comparison of a motion with a reference.

use crate::document::{Block, Cell, Column, Row, Section, Table};
use gravical::motion::{Comparison, MoveComparison};
use gravical::numfmt::{decimals_of, digits, fixed};

use super::moves::{decimals, largest, lengths};
use super::short_name;

pub(super) fn truth<'a>(c: &Comparison) -> Section<'a> {
    let rotated = format!("rotated by {:+.1}° about the vertical", c.yaw_deg);
    let shifted = match c.time_offset_s {
        0.0 => String::new(),
        offset => format!(", time offset {offset:+.3} s"),
    };
    let section =
        Section::new("truth", "Comparison with the reference").with(Block::paragraph(format!(
            "{}: {} points from {:.2} to {:.2} s, {rotated}{shifted}",
            short_name(&c.source),
            c.points,
            c.from_s,
            c.to_s
        )));
    let row = |name: &str, value: Option<f64>, n: i32| {
        Row::from([Cell::text(name), Cell::maybe(value, |v| digits(v, n))])
    };
    let errors = Table::new("Errors")
        .columns([Column::left(""), Column::number("value")])
        .row(row("end error, m", Some(c.end_error_m), 2))
        .row(row("RMSE, m", Some(c.rmse_m), 2))
        .row(row("end error, % of the path", c.percent_of_path, 2))
        .row(row("path of the reference, m", Some(c.path_m), 3));
    let section = section.with(errors);
    if c.moves.is_empty() {
        return section;
    }
    let moves = Table::new("Errors of moves")
        .columns([
            Column::left("move"),
            Column::number("from, s"),
            Column::number("to, s"),
        ])
        .columns(Column::axes("error of the displacement ± 1σ, m"))
        .columns([Column::number("RMSE, m")])
        .rows(c.moves.iter().map(one_move));
    section.with(moves)
}

fn one_move(m: &MoveComparison) -> Row {
    // The error has its own digits.
    let n = decimals_of(largest(m.end_error_m), 2);
    let n = m
        .sigma_m
        .map_or([n; 3], |s| decimals(Some(s), s).map(|d| d.max(n)));
    let mut cells = vec![
        Cell::text(m.number.to_string()),
        Cell::number(fixed(m.start_s, 2)),
        Cell::number(fixed(m.end_s, 2)),
    ];
    cells.extend(lengths(Some(m.end_error_m), m.sigma_m, n));
    cells.push(Cell::number(digits(m.rmse_m, 2)));
    cells.into()
}
