//! The page of a motion.

use maud::{Markup, html};

use super::super::motion::{FAR, ROUND, decimals, facts};
use super::super::text::{decimals_of, short_name};
use super::cells::{cell, decimals_by, digits, fixed, heads, more, none, number, table, three};
use super::findings::{findings, inputs};
use super::gallery::Gallery;
use super::page::{Section, badge, list, page, tile};
use super::{ROWS, moves, truth};
use crate::calibration_file::{InputFile, creation_time};
use crate::figure::Figure;
use crate::motion::{Ends, MotionResult, PositionBudget, StaticDrift};
use crate::recording::Recording;
use gravical_core::matrix3::norm;

/// Where a motion comes from, for the record.
#[derive(Debug, Clone, Copy, Default)]
pub struct Provenance<'a> {
    /// The command that made it, where it was one.
    pub command: Option<&'a str>,
    /// Files beside the recording: calibration, reference.
    pub other_inputs: &'a [InputFile],
}

/// The report of a motion. `recording` is what it was computed from, `figures` are
/// its figures ([`figure::motion::figures`](crate::figure::motion::figures)).
#[must_use]
pub fn motion_html(
    result: &MotionResult,
    recording: &Recording,
    figures: &[Figure],
    origin: Provenance<'_>,
) -> String {
    let mut gallery = Gallery::new(figures);
    let mut sections = vec![
        Section::new("verdict", "What the recording allows", verdict(result)),
        Section::new("timing", "Timing and procedure", timing(result, recording)),
        Section::new("rests", "Rests", rests(result)),
    ];
    for (id, title, names) in [
        (
            "acceleration",
            "Acceleration",
            &["acceleration", "motion-acceleration"][..],
        ),
        ("velocity", "Velocity", &["velocity"]),
        ("trajectory", "Trajectory", &["trajectory", "position-3d"]),
        ("position", "Position", &["position"]),
    ] {
        if gallery.has(names) {
            sections.push(Section::new(id, title, gallery.show(names)));
        }
    }
    if !result.moves.is_empty() {
        let table = moves::moves(result);
        let shown = gallery.show(&["moves"]);
        sections.push(Section::new("moves", "Moves", html! { (table) (shown) }));
        sections.push(Section::new("end", "At the end", end(result)));
    }
    // At rest the position is known by definition: there is nothing to add up.
    if let Some(b) = result
        .budget_m
        .as_ref()
        .filter(|_| !result.moves.is_empty())
    {
        let shown = gallery.show(&["budget"]);
        sections.push(Section::new(
            "budget",
            "Error budget",
            html! { (budget(b)) (shown) },
        ));
    }
    if let Some(drift) = &result.static_drift {
        let shown = gallery.show(&["static-drift"]);
        sections.push(Section::new(
            "drift",
            "Drift at rest",
            html! { (static_drift(drift)) (shown) },
        ));
    }
    if let Some(comparison) = &result.truth {
        sections.push(Section::new(
            "truth",
            "Against the reference",
            truth::truth(comparison),
        ));
    }
    if let Some(rest) = gallery.rest() {
        sections.push(Section::new("more", "More figures", rest));
    }
    sections.push(Section::new(
        "findings",
        "Findings",
        findings(&result.findings),
    ));
    sections.push(Section::new(
        "provenance",
        "Provenance",
        provenance(recording, result, origin),
    ));
    let title = format!("Motion of {}", short_name(&result.input));
    let lead = html! {
        h1 { (title) }
        p.sub { "calibration: " (calibration(result)) }
        p.sub { (result.procedure) }
    };
    page(&title, &lead, &sections)
}

fn calibration(result: &MotionResult) -> String {
    let none = "none: nominal scale".to_owned();
    result.calibration.as_deref().map_or(none, short_name)
}

fn verdict(result: &MotionResult) -> Markup {
    let all = result.moves.len();
    let usable = result.moves.iter().filter(|m| m.usable).count();
    let closed = result
        .moves
        .iter()
        .filter(|m| m.ends == Ends::RestToRest && m.usable)
        .count();
    let (class, sign, word, text) = if all == 0 {
        (
            "unknown",
            "=",
            "at rest",
            "No move is seen in it: it shows how far the result drifts by itself. What its noise may hide stands in the uncertainty of the position.".to_owned(),
        )
    } else if usable == 0 {
        (
            "poor",
            "✗",
            "not usable",
            "How far it moved cannot be known from this recording; the table of moves says why."
                .to_owned(),
        )
    } else if closed == all {
        ("good", "✓", "bounded", "Every move lies between two rests: velocity is known to be zero at both of its ends, which keeps the drift down.".to_owned())
    } else if usable == all {
        (
            "fair",
            "~",
            "partly open",
            format!(
                "{closed} of {all} moves lie between two rests. Where one end is open, the error grows with the time squared."
            ),
        )
    } else {
        (
            "fair",
            "~",
            "partly usable",
            format!(
                "{usable} of {all} moves can be known; the others are named with their reason."
            ),
        )
    };
    let sigma = result.r#final.sigma_m.filter(|_| all > 0).map(|s| {
        let largest = (0..3).max_by(|a, b| s[*a].total_cmp(&s[*b])).unwrap_or(0);
        (largest, s[largest])
    });
    html! {
        (badge(class, sign, word))
        p { (text) }
        div.tiles {
            @match single(result) {
                Some((text, what)) => (tile(&html! { (text) }, "m", &what)),
                None => (tile(&number("/duration_s", result.duration_s, &fixed(result.duration_s, 2)), "s", "from the first sample to the last")),
            }
            (tile(&html! { (usable) " of " (all) }, "", "moves that can be known"))
            @if let Some((axis, v)) = sigma {
                (tile(&number(&format!("/final/sigma_m/{axis}"), v, &format!("± {}", digits(v, 2))), "m",
                    "standard uncertainty of the position at the end, along its worst axis (1σ)"))
            }
        }
    }
}

/// How far the only move went, and what it would be without the calibration.
fn single(result: &MotionResult) -> Option<(String, String)> {
    let [only] = &result.moves[..] else {
        return None;
    };
    let (way, sigma) = (only.displacement_m?, only.sigma_m);
    let long = norm(&way);
    // Along the way itself; where it ends at its start there is none.
    let sd = sigma.filter(|_| long > 0.0).map(|s| {
        let parts: [f64; 3] = std::array::from_fn(|i| s[i] * way[i] / long);
        norm(&parts)
    });
    let text = match sd {
        Some(sd) => format!(
            "{} ± {}",
            fixed(long, decimals_by(Some(sd), long)),
            digits(sd, 2)
        ),
        None => digits(long, 3),
    };
    let plain = only.uncalibrated_m.map_or(String::new(), |u| {
        format!(
            "; uncalibrated {} m",
            fixed(norm(&u), decimals_by(sd, long))
        )
    });
    Some((text, format!("moved in one go (± 1σ){plain}")))
}

fn timing(result: &MotionResult, recording: &Recording) -> Markup {
    let rows: Vec<(&str, Markup)> = facts(result, recording)
        .into_iter()
        .map(|(name, text)| (name, html! { (text) }))
        .collect();
    let t = &recording.timing;
    let body = html! {
        @for (name, key, value, decimals) in [
            ("rate by the stamps, Hz", "/rate_hz/true", result.rate_hz.r#true, 3),
            ("rate that is claimed, Hz", "/rate_hz/nominal", result.rate_hz.nominal, 3),
            ("duration, s", "/duration_s", Some(result.duration_s), 3),
            ("rows", "/rows", Some(result.rows as f64), 0),
            ("rows stepped over", "/rows_left_out", Some(result.rows_left_out as f64), 0),
        ] {
            @if let Some(v) = value { tr { th scope="row" { (name) } (cell(key, v, &fixed(v, decimals))) } }
        }
        @if let Some(v) = t.jitter_s { tr { th scope="row" { "jitter of the stamps, ms" } td.n { (fixed(1e3 * v, 2)) } } }
        @if let Some(v) = t.missing_share { tr { th scope="row" { "samples that are missing, %" } td.n { (fixed(100.0 * v, 2)) } } }
    };
    html! { (list(&rows)) (table("Timing", &heads(&["", "value"]), &body)) }
}

fn rests(result: &MotionResult) -> Markup {
    let body = html! {
        @for (i, span) in result.still.iter().enumerate().take(ROWS) {
            tr {
                th scope="row" { (i + 1) }
                (cell(&format!("/still/{i}/start_s"), span.start_s, &fixed(span.start_s, 2)))
                (cell(&format!("/still/{i}/end_s"), span.end_s, &fixed(span.end_s, 2)))
                td.n { (fixed(span.end_s - span.start_s, 2)) }
            }
        }
    };
    let noise = result.noise.map(|n| {
        html! {
            tr { th scope="row" { "accelerometer, mm/s²" } (three("/noise/accel_sigma_mps2", n.accel_sigma_mps2, |_, v| digits(1e3 * v, 2)))
                (cell("/noise/accel_vif", n.accel_vif, &digits(n.accel_vif, 2))) }
            @if let (Some(s), Some(vif)) = (n.gyro_sigma_rad_s, n.gyro_vif) {
                tr { th scope="row" { "gyroscope, mrad/s" } (three("/noise/gyro_sigma_rad_s", s, |_, v| digits(1e3 * v, 2)))
                    (cell("/noise/gyro_vif", vif, &digits(vif, 2))) }
            }
        }
    });
    html! {
        @if result.still.is_empty() { p { "It rests nowhere." } }
        @else {
            (table("Where it rests, s", &heads(&["rest", "from", "to", "long"]), &body))
            (more(result.still.len(), ROWS))
        }
        @if let Some(body) = noise {
            (table("Noise of one sample at rest, 1σ", &heads(&["", "x", "y", "z", "variance inflation"]), &body))
            p.note { "variance inflation: how much more the variance of a mean is than that of independent samples." }
        }
    }
}

fn end(result: &MotionResult) -> Markup {
    let last = &result.r#final;
    let Some(position) = last.position_m else {
        return html! { p { "The position at the end is not known, since a move before it is not usable." } };
    };
    let n = decimals(last.sigma_m, position);
    let speed =
        |v: [f64; 3]| decimals_of(v.into_iter().fold(0.0, |m: f64, c| m.max(c.abs())), 2).min(3);
    let rows = |name: &str, key: &str, values: Option<[f64; 3]>, n: [usize; 3], mark: &str| {
        html! {
            tr {
                th scope="row" { (name) }
                @match values {
                    Some(v) => (three(key, v, |k, v| format!("{mark}{}", far(v, n[k])))),
                    None => (none(3)),
                }
            }
        }
    };
    let plain = result.uncalibrated;
    let body = html! {
        (rows("position, m", "/final/position_m", Some(position), n, ""))
        @if last.sigma_m.is_some() { (rows("its 1σ, m", "/final/sigma_m", last.sigma_m, n, "± ")) }
        @if plain.is_some() { (rows("uncalibrated, m", "/uncalibrated/position_m", plain.and_then(|u| u.position_m), n, "")) }
        @if let Some(v) = last.velocity_mps {
            @let n = [speed(v); 3];
            (rows("velocity, m/s", "/final/velocity_mps", Some(v), n, ""))
            @if plain.is_some() { (rows("uncalibrated, m/s", "/uncalibrated/velocity_mps", plain.and_then(|u| u.velocity_mps), n, "")) }
        }
    };
    html! { p { (result.frame) } (table("At the end of the recording, from its start", &heads(&["", "x", "y", "z"]), &body)) }
}

fn budget(b: &PositionBudget) -> Markup {
    let parts = [
        ("noise", b.noise, "noise of the accelerometer"),
        (
            "bias",
            b.bias,
            "bias of the accelerometer, and what goes along with it",
        ),
        (
            "scale",
            b.scale,
            "scale and cross-axis terms of the accelerometer",
        ),
        ("clock", b.clock, "clock of the recorder"),
        ("tilt", b.tilt, "attitude: gyroscope, levelling, yaw"),
    ];
    let total = parts.iter().map(|(_, v, _)| v * v).sum::<f64>().sqrt();
    let n = decimals_of(1e3 * total, 2).min(3);
    let body = html! {
        @for (key, value, what) in parts {
            tr {
                th scope="row" { (what) }
                (cell(&format!("/budget_m/{key}"), value, &fixed(1e3 * value, n)))
                td.n { @if total > 0.0 { (fixed(100.0 * value * value / (total * total), 0)) } @else { "–" } }
            }
        }
        tr.sum { th scope="row" { "together (squares add up)" } td.n { (fixed(1e3 * total, n)) } td.n { "100" } }
        tr.sum { th scope="row" { "expanded, k = 2" } td.n { (fixed(2e3 * total, n)) } td {} }
    };
    table(
        "Uncertainty of the position at the end, all axes together, 1σ",
        &heads(&["source", "mm", "% of the variance"]),
        &body,
    )
}

/// As [`fixed`]; what went beyond [`ROUND`] with two digits.
fn far(v: f64, decimals: usize) -> String {
    if v.abs() < ROUND || !v.is_finite() {
        return fixed(v, decimals);
    }
    format!("{v:.1e}").replace('-', "−")
}

fn static_drift(d: &StaticDrift) -> Markup {
    let n = decimals(Some(d.predicted_sigma_m), d.position_m);
    let over: [f64; 3] = std::array::from_fn(|k| d.position_m[k].abs() / d.predicted_sigma_m[k]);
    let farthest = over.into_iter().fold(0.0, f64::max);
    let row = |name: &str, key: &str, v: [f64; 3], factor: f64, n: [usize; 3]| {
        html! {
            tr { th scope="row" { (name) } (three(&format!("/static_drift/{key}"), v, |k, v| far(factor * v, n[k]))) }
        }
    };
    let body = html! {
        (row("position, m", "position_m", d.position_m, 1.0, n))
        (row("predicted, 1σ, m", "predicted_sigma_m", d.predicted_sigma_m, 1.0, n))
        (row("velocity, mm/s", "velocity_mps", d.velocity_mps, 1e3, [1; 3]))
        (row("as by a bias, mm/s²", "bias_mps2", d.bias_mps2, 1e3, [1; 3]))
        (row("that rises, mm/s³", "slope_mps3", d.slope_mps3, 1e3, [2; 3]))
        (row("left over, m", "unexplained_m", d.unexplained_m, 1.0, n))
    };
    html! {
        p {
            "Over " (number("/static_drift/duration_s", d.duration_s, &fixed(d.duration_s, 1)))
            " s, nothing corrected, levelled over the " (number("/static_drift/levelled_over_s", d.levelled_over_s, &fixed(d.levelled_over_s, 1)))
            " s before."
        }
        (table("Drift at rest", &heads(&["", "x", "y", "z"]), &body))
        p {
            @if !farthest.is_finite() { "No band was predicted." }
            @else if farthest <= FAR { "That is within the predicted band (" (fixed(farthest, 1)) "σ at most)." }
            @else { "That is " (fixed(farthest, 1)) "σ off: the band does not explain it; the bias drifts, or the sensor was not quite at rest." }
            " With the zero-velocity correction it would be zero by construction, which would prove nothing."
        }
    }
}

fn provenance(recording: &Recording, result: &MotionResult, origin: Provenance<'_>) -> Markup {
    let mut files = InputFile::of(std::slice::from_ref(recording));
    files.extend_from_slice(origin.other_inputs);
    let command = html! { @match origin.command { Some(c) => code { (c) }, None => "–" } };
    let now = creation_time();
    html! {
        (list(&[
            ("program", html! { "gravical " (env!("CARGO_PKG_VERSION")) }),
            ("command", command),
            ("computed", html! { time datetime=(now) { (now) } }),
            ("calibration", html! { (result.calibration.as_deref().unwrap_or("none")) }),
        ]))
        (inputs(&files))
    }
}
