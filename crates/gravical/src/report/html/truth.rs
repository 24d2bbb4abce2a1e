//! The comparison with a reference.

use maud::{Markup, html};

use super::super::motion::decimals;
use super::super::text::decimals_of;
use super::ROWS;
use super::cells::{cell, digits, fixed, maybe, more, none, number, signed, table, three};
use crate::motion::{Comparison, MoveComparison};

pub(super) fn truth(c: &Comparison) -> Markup {
    let metre = |v: f64| digits(v, 2);
    let head = html! {
        thead {
            tr {
                th scope="colgroup" colspan="2" { "move, s" }
                th scope="colgroup" colspan="3" { "error of its displacement, m" }
                th scope="colgroup" colspan="3" { "1σ, m" }
                th.n scope="col" rowspan="2" { "RMSE, m" }
            }
            tr {
                th.n scope="col" { "from" } th.n scope="col" { "to" }
                @for _ in 0..2 { @for axis in ["x", "y", "z"] { th.n scope="col" { (axis) } } }
            }
        }
    };
    let body = html! { @for (i, m) in c.moves.iter().enumerate().take(ROWS) { (one(i, m)) } };
    let errors = html! {
        tr { th scope="row" { "end error, m" } (cell("/truth/end_error_m", c.end_error_m, &metre(c.end_error_m))) }
        tr { th scope="row" { "RMSE, m" } (cell("/truth/rmse_m", c.rmse_m, &metre(c.rmse_m))) }
        tr { th scope="row" { "end error, % of the path" } (maybe("/truth/percent_of_path", c.percent_of_path, metre)) }
        tr { th scope="row" { "path of the reference, m" } (cell("/truth/path_m", c.path_m, &digits(c.path_m, 3))) }
    };
    html! {
        p {
            (c.source) ": " (number("/truth/points", c.points as f64, &c.points.to_string())) " points from "
            (number("/truth/from_s", c.from_s, &fixed(c.from_s, 2))) " to "
            (number("/truth/to_s", c.to_s, &fixed(c.to_s, 2))) " s. It was turned by ("
            @for (k, v) in c.rotation_deg.into_iter().enumerate() {
                @if k > 0 { ", " } (number(&format!("/truth/rotation_deg/{k}"), v, &signed(v, 1)))
            }
            ")° to fit, and its clock shifted by " (number("/truth/time_offset_s", c.time_offset_s, &signed(c.time_offset_s, 3))) " s."
        }
        (table("Errors", &super::cells::heads(&["", "value"]), &errors))
        @if !c.moves.is_empty() { (table("Errors of moves", &head, &body)) (more(c.moves.len(), ROWS)) }
    }
}

fn one(i: usize, m: &MoveComparison) -> Markup {
    let base = format!("/truth/moves/{i}");
    // The error itself is known better than its uncertainty tells.
    let n = decimals_of(
        m.end_error_m
            .into_iter()
            .fold(0.0, |a: f64, v| a.max(v.abs())),
        2,
    );
    html! {
        tr {
            (cell(&format!("{base}/start_s"), m.start_s, &fixed(m.start_s, 2)))
            (cell(&format!("{base}/end_s"), m.end_s, &fixed(m.end_s, 2)))
            (three(&format!("{base}/end_error_m"), m.end_error_m, |_, v| fixed(v, n)))
            @match m.sigma_m {
                Some(s) => (three(&format!("{base}/sigma_m"), s, |k, v| fixed(v, decimals(Some(s), s)[k]))),
                None => (none(3)),
            }
            (cell(&format!("{base}/rmse_m"), m.rmse_m, &digits(m.rmse_m, 2)))
        }
    }
}
