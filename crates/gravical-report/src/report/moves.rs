//! Report of the moves of a motion, its end point and error budget.

use crate::document::{Block, Cell, Column, Row, Section, Table};
use gravical::core::matrix3::norm;
use gravical::motion::{Budget, Comparison, Ends, MotionResult, Move, MoveComparison};
use gravical::numfmt::{decimals_for, decimals_of, digits, fixed};

use super::short_name;

/// Decimals of each axis for a length with this uncertainty, m: two digits of it;
/// without one four digits of the largest value.
fn decimals(sigma: Option<[f64; 3]>, value: [f64; 3]) -> [usize; 3] {
    sigma.map_or([decimals_of(largest(value).max(1e-3), 4); 3], |s| {
        s.map(decimals_for)
    })
}

pub(super) fn largest(value: [f64; 3]) -> f64 {
    value.into_iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// Lengths along the axes with their standard uncertainties, if known.
fn lengths(values: Option<[f64; 3]>, sigma: Option<[f64; 3]>, n: [usize; 3]) -> [Cell; 3] {
    let cell = |k: usize| {
        let length = Cell::maybe(values.map(|v| v[k]), |v| fixed(v, n[k]));
        length.plus_minus(sigma.map(|s| s[k]).filter(|_| values.is_some()), n[k])
    };
    [0, 1, 2].map(cell)
}

pub(super) fn moves<'a>(result: &MotionResult) -> Section<'a> {
    let table = Table::new("")
        .columns(["move", "from, s", "to, s"])
        .columns(Column::axes("displacement ± 1σ, m"))
        .columns(["path, m", "speed, m/s", "rest at"])
        .rows((1..).zip(&result.moves).map(one_move));
    let section = Section::new("moves", "Moves").with(table).with(Block::note(
        "path: length of the path. speed: peak speed. rest at: the ends of the move at which the sensor is at rest.",
    ));
    let plain = (1..)
        .zip(&result.moves)
        .filter(|(_, m)| m.uncalibrated_m.is_some());
    let plain = plain.map(|(number, m)| {
        let n = m.displacement_m.map_or([3; 3], |d| decimals(m.sigma_m, d));
        Row::named(
            number.to_string(),
            Cell::axes(m.uncalibrated_m, |k, v| fixed(v, n[k])),
        )
    });
    let plain: Vec<Row> = plain.collect();
    if plain.is_empty() {
        return section;
    }
    let columns = Column::axes("displacement, m");
    let table = Table::new("Without the calibration")
        .columns(["move"])
        .columns(columns);
    section.full(table.rows(plain))
}

fn one_move((number, m): (usize, &Move)) -> Row {
    let n = m.displacement_m.map_or([3; 3], |d| decimals(m.sigma_m, d));
    let finest = n.into_iter().max().unwrap_or(3).min(6);
    let ends = match m.ends {
        Ends::RestToRest => "both",
        Ends::FromRest => "start",
        Ends::ToRest => "end",
        Ends::Free => "none",
    };
    let mut cells = vec![
        Cell::text(number.to_string()),
        Cell::number(fixed(m.start_s, 2)),
        Cell::number(fixed(m.end_s, 2)),
    ];
    cells.extend(lengths(m.displacement_m, m.sigma_m, n));
    cells.extend([
        // At most the digits of the displacement.
        Cell::maybe(m.path_m, |v| fixed(v, decimals_of(v, 3).min(finest))),
        Cell::maybe(m.peak_speed_mps, |v| fixed(v, decimals_of(v, 2).min(5))),
        Cell::text(ends),
    ]);
    let unusable = m.unusable.as_ref().map(|why| format!("not usable: {why}"));
    Row::from(cells).noted(unusable.unwrap_or_default())
}

pub(super) fn end<'a>(result: &MotionResult) -> Section<'a> {
    let section = Section::new("end", "End point");
    let last = &result.r#final;
    let Some(position) = last.position_m else {
        return section.with(Block::paragraph(
            "The end position is unknown because a move before it is not usable.",
        ));
    };
    let n = decimals(last.sigma_m, position);
    let plain = result.uncalibrated.map(|u| lengths(u.position_m, None, n));
    let table = Table::new("Position relative to the start (± 1σ)")
        .columns([""])
        .columns(Column::axes(""))
        .row(Row::named(
            "position, m",
            lengths(Some(position), last.sigma_m, n),
        ))
        .rows(plain.map(|cells| Row::named("uncalibrated, m", cells)));
    section.with(table)
}

pub(super) fn error_budget<'a>(number: usize, only: bool, b: &Budget) -> Section<'a> {
    let section = Section::new("budget", "Error budget");
    let parts = [
        (
            norm(&b.noise),
            "noise of the accelerometer and of the levelling, clock",
        ),
        (norm(&b.calibration), "calibration of both sensors, gravity"),
        (
            norm(&b.attitude),
            "attitude in the move: gyroscope, or tilts without one",
        ),
    ];
    let total = parts.iter().map(|(v, _)| v * v).sum::<f64>().sqrt();
    if total == 0.0 || !total.is_finite() {
        return section;
    }
    let n = decimals_of(1e3 * total, 2).min(3);
    let row = |what: &str, value: f64, share: Cell| {
        Row::named(what, [Cell::number(fixed(1e3 * value, n)), share])
    };
    let parts = parts.map(|(value, what)| {
        let share = 100.0 * value * value / (total * total);
        row(what, value, Cell::number(fixed(share, 0)))
    });
    let of = if only {
        "the displacement".to_owned()
    } else {
        format!("move {number}, the least certain one")
    };
    let table = Table::new(format!("Uncertainty of {of}, all axes together, 1σ"))
        .columns(["source", "mm", "% of the variance"])
        .rows(parts)
        .row(row(
            "combined (root sum of squares)",
            total,
            Cell::number("100"),
        ))
        .row(row("expanded, k = 2", 2.0 * total, Cell::text("")));
    section.with(table)
}

pub(super) fn truth<'a>(c: &Comparison) -> Section<'a> {
    let rotated = format!("rotated by {:+.1}° about the vertical", c.yaw_deg);
    let shifted = match c.time_offset_s {
        0.0 => String::new(),
        offset => format!(", time offset {offset:+.3} s"),
    };
    let source = format!(
        "{}: {} points from {:.2} to {:.2} s, {rotated}{shifted}",
        short_name(&c.source),
        c.points,
        c.from_s,
        c.to_s
    );
    let percent = c.percent_of_path;
    let percent = percent.map_or(String::new(), |v| {
        format!(" ({} % of the path)", digits(v, 2))
    });
    let section = Section::new("truth", "Comparison with the reference")
        .with(Block::paragraph(source))
        .with(Block::facts([
            (
                "end error",
                Some(format!("{} m{percent}", digits(c.end_error_m, 2))),
            ),
            ("RMSE", Some(format!("{} m", digits(c.rmse_m, 2)))),
            ("path", Some(format!("{} m", digits(c.path_m, 3)))),
        ]));
    if c.moves.is_empty() {
        return section;
    }
    let moves = Table::new("Errors of moves")
        .columns(["move", "from, s", "to, s"])
        .columns(Column::axes("error of the displacement ± 1σ, m"))
        .columns(["RMSE, m"])
        .rows(c.moves.iter().map(error_of_move));
    section.with(moves)
}

fn error_of_move(m: &MoveComparison) -> Row {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_two_digits_of_their_uncertainty() {
        let sigma = Some([0.0028, 0.31, 0.012]);
        let n = decimals(sigma, [1.0; 3]);
        let cells = lengths(Some([0.69934, -0.001, f64::NAN]), sigma, n);
        let texts: Vec<String> = cells
            .iter()
            .map(|c| match c {
                Cell::Number(text, Some(sd)) => format!("{text} {sd}"),
                other => panic!("{other:?}"),
            })
            .collect();
        assert_eq!(texts, ["0.6993 0.0028", "0.00 0.31", "– 0.012"]);
        assert_eq!(decimals(None, [12.3, 0.1, 0.0]), [2; 3]);
        assert_eq!(decimals(Some([f64::NAN; 3]), [0.0; 3]), [6; 3]);
    }
}
