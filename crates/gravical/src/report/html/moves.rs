//! The table of moves.

use maud::{Markup, html};

use super::super::motion::decimals;
use super::super::text::decimals_of;
use super::ROWS;
use super::cells::{cell, digits, fixed, maybe, more, none, table, three};
use crate::motion::{Ends, MotionResult, Move};

pub(super) fn moves(result: &MotionResult) -> Markup {
    let plain = result.moves.iter().any(|m| m.uncalibrated_m.is_some());
    let head = html! {
        thead {
            tr {
                th scope="col" rowspan="2" { "move" }
                th scope="colgroup" colspan="2" { "time, s" }
                th.n scope="col" rowspan="2" { "long, s" }
                th scope="colgroup" colspan="3" { "displacement, m" }
                th scope="colgroup" colspan="3" { "1σ, m" }
                @if plain { th scope="colgroup" colspan="3" { "uncalibrated, m" } }
                th.n scope="col" rowspan="2" { "path, m" }
                th.n scope="col" rowspan="2" { "top speed, m/s" }
                th scope="col" rowspan="2" { "rest at" }
            }
            tr {
                th.n scope="col" { "from" } th.n scope="col" { "to" }
                @for _ in 0..(2 + usize::from(plain)) { @for axis in ["x", "y", "z"] { th.n scope="col" { (axis) } } }
            }
        }
    };
    let width = if plain { 16 } else { 13 };
    let shown = result.moves.iter().enumerate().take(ROWS);
    let body = html! { @for (i, m) in shown { (one(i, m, plain, width)) } };
    html! {
        (table("Moves", &head, &body))
        (more(result.moves.len(), ROWS))
        p.note { "path: its length. rest at: at which ends of the move the sensor rests." }
    }
}

fn one(i: usize, m: &Move, plain: bool, width: usize) -> Markup {
    let base = format!("/moves/{i}");
    let n = m.displacement_m.map_or([3; 3], |d| decimals(m.sigma_m, d));
    let finest = n.into_iter().max().unwrap_or(3).min(6);
    let ends = match m.ends {
        Ends::RestToRest => "both",
        Ends::FromRest => "start",
        Ends::ToRest => "end",
        Ends::Free => "none",
    };
    let triple = |key: &str, values: Option<[f64; 3]>| {
        html! {
            @match values {
                Some(v) => (three(&format!("{base}/{key}"), v, |k, v| fixed(v, n[k]))),
                None => (none(3)),
            }
        }
    };
    html! {
        tr {
            th scope="row" { (i + 1) }
            (cell(&format!("{base}/start_s"), m.start_s, &fixed(m.start_s, 2)))
            (cell(&format!("{base}/end_s"), m.end_s, &fixed(m.end_s, 2)))
            td.n { (fixed(m.end_s - m.start_s, 2)) }
            (triple("displacement_m", m.displacement_m))
            (triple("sigma_m", m.sigma_m))
            @if plain { (triple("uncalibrated_m", m.uncalibrated_m)) }
            (maybe(&format!("{base}/path_m"), m.path_m, |v| fixed(v, decimals_of(v, 3).min(finest))))
            (maybe(&format!("{base}/peak_speed_mps"), m.peak_speed_mps, |v| digits(v, 2)))
            td { (ends) }
        }
        @if let Some(reason) = &m.reason {
            tr.reason { td colspan=(width) { (reason) } }
        }
    }
}
