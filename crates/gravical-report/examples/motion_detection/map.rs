//! The map as a figure.

use gravical_report::figure::{Axis, Figure, Panel, Role, Series, Symbol, svg};

use super::moves::{Cell, Profile};
use super::{MOVES_S, Outcome, WAYS_M};

/// How many σ the whole of a move has to stand out by to count.
const CLEAR: f64 = 10.0;

/// What came of the smoothest moves: duration across, distance up, a panel for each sensor and
/// length of the rests.
pub fn figure(cells: &[(&Cell, &Outcome)]) -> String {
    let mut out = Figure::new(
        "detection-map",
        "Which moves are found",
        "Moves by the smoothest path, their duration across and their distance up. Blue: found in at least nine of ten recordings; orange: taken for rest in more, with a band that says so; red: a band that the truth leaves by 4σ in more than one of twenty. Below the line a move stands out from the noise by less than 10σ even for a filter that knows its shape and place.",
    )
    .beside();
    for gyro in [true, false] {
        for rest_s in [5.0, 1.0] {
            let shown: Vec<_> = cells
                .iter()
                .filter(|(c, _)| {
                    c.gyro == gyro && c.rest_s == rest_s && c.profile == Profile::MinimumJerk
                })
                .collect();
            if !shown.is_empty() {
                out = out.with(panel(&shown, gyro, rest_s));
            }
        }
    }
    svg::standalone(&out)
}

fn panel(cells: &[&(&Cell, &Outcome)], gyro: bool, rest_s: f64) -> Panel {
    let names = |values: &[f64]| values.iter().map(f64::to_string).collect();
    let sensor = if gyro { "with" } else { "without" };
    let mut out = Panel::new(
        Axis::names("duration, s", names(&MOVES_S)),
        Axis::names("distance, m", names(&WAYS_M)),
    )
    .titled(format!("{sensor} gyroscope, rests of {rest_s} s"));
    let place = |of: &[f64], value: f64| of.iter().position(|v| *v == value).unwrap_or(0) as f64;
    for (name, role, symbol, wanted) in [
        ("found", Role::Calibrated, Symbol::Circle, 0),
        ("taken for rest", Role::Warning, Symbol::Square, 1),
        ("band wrong", Role::Bad, Symbol::Cross, 2),
    ] {
        let (x, y) = cells
            .iter()
            .filter(|(_, o)| kind(o) == wanted)
            .map(|(c, _)| (place(&MOVES_S, c.move_s), place(&WAYS_M, c.way_m)))
            .unzip();
        out = out.with(Series::points(name, role, x, y).drawn_as(symbol));
    }
    let clear = MOVES_S.map(|move_s| {
        let of_1_m = Cell {
            way_m: 1.0,
            move_s,
            ..*cells[0].0
        };
        position(CLEAR / of_1_m.sigmas())
    });
    let x = (0..MOVES_S.len()).map(|k| k as f64).collect();
    out.with(Series::line("10σ", Role::Reference, x, clear.to_vec()))
}

/// Found, taken for rest, wrong.
fn kind(outcome: &Outcome) -> u32 {
    if 20 * outcome.wrong > outcome.runs {
        2
    } else if 10 * outcome.missed > outcome.runs {
        1
    } else {
        0
    }
}

/// Where a distance lies among the names of the axis.
fn position(way_m: f64) -> f64 {
    let after = WAYS_M
        .partition_point(|w| *w < way_m)
        .clamp(1, WAYS_M.len() - 1);
    let (low, high) = (WAYS_M[after - 1], WAYS_M[after]);
    let share = (way_m / low).ln() / (high / low).ln();
    (after as f64 - 1.0 + share).clamp(-0.4, WAYS_M.len() as f64 - 0.6)
}
