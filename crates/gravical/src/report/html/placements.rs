//! The table of placements, their tilts, and where one more would help.

use maud::{Markup, html};

use super::super::text::{decimals_of, direction};
use super::ROWS;
use super::calibration::mg;
use super::cells::{cell, fixed, heads, maybe, more, number, shown_unit, signed, table, three};
use super::gallery::Gallery;
use crate::calibration_file::{CalibrationFile, Position};

/// Every placement before and after, and the three error figures.
pub(super) fn placements(file: &CalibrationFile, gallery: &mut Gallery<'_>) -> Markup {
    let a = &file.accelerometer;
    let unit = &shown_unit(a.input_unit.name());
    let largest = a
        .positions
        .iter()
        .flat_map(|p| p.raw)
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    let decimals = decimals_of(largest, 5).min(4);
    let shown = a.positions.iter().enumerate().take(ROWS);
    let body = html! { @for (i, p) in shown { (row(i, p, decimals)) } };
    let head = html! {
        thead {
            tr {
                th scope="col" rowspan="2" { "placement" }
                th scope="colgroup" colspan="3" { "raw mean, " (unit) }
                th scope="colgroup" colspan="3" { "calibrated, m/s²" }
                th.n scope="col" rowspan="2" { "error, m/s²" }
                th.n scope="col" rowspan="2" { "‖a‖ − g, mm/s²" }
                th.n scope="col" rowspan="2" { "left out, mm/s²" }
                th.n scope="col" rowspan="2" { "tilt, °" }
                th.n scope="col" rowspan="2" { "rows" }
            }
            tr { @for _ in 0..2 { @for axis in ["x", "y", "z"] { th.n scope="col" { (axis) } } } }
        }
    };
    html! {
        (table("Each placement before and after", &head, &body))
        (more(a.positions.len(), ROWS))
        p.note {
            "error: length of calibrated − expected. left out: ‖a‖ − g when this placement and those within 25° of it take no part in the fit. tilt: off the face."
        }
        @if let Some(e) = a.errors {
            p {
                "Errors over the fitted faces, m/s²: RMS " (number("/accelerometer/errors/rms", e.rms, &fixed(e.rms, 5)))
                ", largest component " (number("/accelerometer/errors/max", e.max, &fixed(e.max, 5)))
                ", mean norm " (number("/accelerometer/errors/mean_norm", e.mean_norm, &fixed(e.mean_norm, 5)))
                ". The parameters were fitted to them: they are no measure of accuracy."
            }
        }
        (gallery.show(&["residuals"]))
    }
}

fn row(i: usize, p: &Position, decimals: usize) -> Markup {
    let base = format!("/accelerometer/positions/{i}");
    let mm = |v: f64| signed(1e3 * v, 2);
    html! {
        tr {
            th scope="row" { (p.label) @if !p.fitted { " (not used)" } }
            (three(&format!("{base}/raw"), p.raw, |_, v| fixed(v, decimals)))
            (three(&format!("{base}/calibrated"), p.calibrated, |_, v| fixed(v, 3)))
            (cell(&format!("{base}/error_norm"), p.error_norm, &fixed(p.error_norm, 4)))
            (maybe(&format!("{base}/magnitude_error_mps2"), p.magnitude_error_mps2, mm))
            (maybe(&format!("{base}/left_out_error_mps2"), p.left_out_error_mps2, mm))
            @match (p.tilt_deg, p.tilt_sd_deg) {
                (Some(tilt), Some(sd)) => (cell(&format!("{base}/tilt_deg"), tilt, &format!("{} ± {}", fixed(tilt, 1), fixed(sd, 1)))),
                (tilt, _) => (maybe(&format!("{base}/tilt_deg"), tilt, |v| fixed(v, 1))),
            }
            (cell(&format!("{base}/rows"), p.rows as f64, &p.rows.to_string()))
        }
    }
}

/// Where the placements lie, and the next ones.
pub(super) fn poses(file: &CalibrationFile, gallery: &mut Gallery<'_>) -> Markup {
    let a = &file.accelerometer;
    let body = html! {
        @for (i, next) in a.next_poses.iter().enumerate().take(ROWS) {
            @let base = format!("/accelerometer/next_poses/{i}");
            tr {
                th scope="row" { (i + 1) }
                td { (next.hint) }
                td { (direction(next.direction)) }
                (cell(&format!("{base}/predicted_norm_error_mps2"), next.predicted_norm_error_mps2, &mg(next.predicted_norm_error_mps2)))
            }
        }
    };
    html! {
        (gallery.show(&["sphere", "tilt"]))
        @if let Some(worst) = &a.worst_pose {
            p { "The result suffers most from " strong { (worst.label) } ": " (worst.reason) }
        }
        @if a.next_poses.is_empty() {
            p { "No further placement is proposed." }
        } @else {
            @if let Some(now) = a.predicted_norm_error_mps2 {
                p { "The standard uncertainty of the magnitude is " (digits_of_mg(now)) " mg. Each of these placements would lower it, after the ones before it." }
            }
            (table("Placements that would help most", &heads(&["", "<how to hold it", "<direction", "then, mg"]), &body))
        }
    }
}

fn digits_of_mg(v: f64) -> Markup {
    number("/accelerometer/predicted_norm_error_mps2", v, &mg(v))
}
