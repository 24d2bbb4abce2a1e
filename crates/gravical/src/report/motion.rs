//! Motion as text: what was read, rests, moves, the end, what the uncertainty is
//! made of, the comparison with a reference.

use crate::motion::{Ends, MotionResult, Move, Span, StaticDrift};
use crate::recording::{Origin, Recording};

use super::text::{decimals_for, decimals_of, findings_text, paragraph, short_name};
use super::truth::truth;

/// Moves that are listed one by one.
const LISTED: usize = 24;

/// Drift over its predicted uncertainty above which the band does not explain it.
pub(super) const FAR: f64 = 3.0;

/// What drifts beyond this shows two digits and a power of ten: nothing that is known
/// to more goes so far.
pub(super) const ROUND: f64 = 1e6;

/// The whole report; `recording` is what it was computed from.
#[must_use]
pub fn motion_text(result: &MotionResult, recording: &Recording) -> String {
    let mut out = head(result, recording);
    out.push_str(&moves(result));
    out.push_str(&end(result));
    out.push_str(&budget(result));
    if let Some(drift) = &result.static_drift {
        out.push_str(&static_drift(drift));
    }
    if let Some(comparison) = &result.truth {
        out.push_str(&truth(comparison));
    }
    if !result.findings.is_empty() {
        out.push_str("\nFindings\n");
        out.push_str(&findings_text(&result.findings, false));
    }
    out
}

fn head(result: &MotionResult, recording: &Recording) -> String {
    let rows = facts(result, recording);
    let row = |(name, text): &(&str, String)| paragraph(&format!("  {name:<13} "), text);
    rows.iter().map(row).collect()
}

/// How the recording was read and what was made of it: name, text.
pub(super) fn facts(result: &MotionResult, recording: &Recording) -> Vec<(&'static str, String)> {
    let mut rows = vec![("read as", recording.description.clone())];
    let mut row = |name, text: &str| rows.push((name, text.to_owned()));
    // Its unit may yet be decided otherwise: then a finding says so.
    let gyro = match &recording.gyro {
        Some(_) => "; with a gyroscope",
        None => "; no gyroscope",
    };
    let origin = match recording.accel_scale.origin {
        Origin::Given => "given",
        Origin::Data => "as gravity shows",
        Origin::Header => "as the header says",
        Origin::Assumed => "assumed",
    };
    let unit = recording.accel_scale.unit.name();
    row("unit", &format!("accelerometer {unit} ({origin}){gyro}"));
    row(
        "calibration",
        &result
            .calibration
            .as_deref()
            .map_or("none: nominal scale".to_owned(), short_name),
    );
    row("procedure", &result.procedure);
    row("frame", &result.frame);
    row("time", &time(result));
    row("rests", &rests(&result.still));
    if let Some(noise) = &result.noise {
        let three = |v: [f64; 3], factor: f64| v.map(|s| significant(factor * s, 2)).join(" ");
        let gyro = noise.gyro_sigma_rad_s.map_or(String::new(), |s| {
            format!("; gyroscope {} mrad/s", three(s, 1e3))
        });
        let accel = three(noise.accel_sigma_mps2, 1e3);
        row(
            "noise",
            &format!("accelerometer {accel} mm/s²{gyro} (1σ at rest)"),
        );
    }
    rows
}

fn time(result: &MotionResult) -> String {
    let rate = match (result.rate_hz.r#true, result.rate_hz.nominal) {
        (Some(t), Some(n)) if (t / n - 1.0).abs() > 0.002 => {
            format!("{t:.2} Hz by the stamps; {n} Hz is claimed")
        }
        (Some(t), _) => format!("{t:.2} Hz by the stamps"),
        (None, Some(n)) => format!("{n} Hz as claimed: there are no stamps"),
        (None, None) => "no rate".to_owned(),
    };
    let left_out = match result.rows_left_out {
        0 => String::new(),
        n => format!("; {n} rows without a whole sample stepped over"),
    };
    format!("{:.2} s, {rate}{left_out}", result.duration_s)
}

fn rests(still: &[Span]) -> String {
    let span = |s: &Span| format!("{:.2}–{:.2}", s.start_s, s.end_s);
    let total: f64 = still.iter().map(|s| s.end_s - s.start_s).sum();
    let list = |spans: &[Span]| spans.iter().map(span).collect::<Vec<_>>().join(", ");
    match still {
        [] => "none".to_owned(),
        few @ ([_] | [_, _] | [_, _, _] | [_, _, _, _]) => format!("{} s", list(few)),
        [first, second, .., last] => format!(
            "{} of {total:.1} s in all: {}, … {} s",
            still.len(),
            list(&[*first, *second]),
            span(last)
        ),
    }
}

/// `value` with `digits` significant digits, no exponent.
fn significant(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    format!("{value:.*}", decimals_of(value, digits))
}

/// Decimals of each axis for a length with this uncertainty, m: two digits of it;
/// without one four digits of the largest value.
pub(super) fn decimals(sigma: Option<[f64; 3]>, value: [f64; 3]) -> [usize; 3] {
    sigma.map_or([decimals_of(largest(value).max(1e-3), 4); 3], |s| {
        s.map(decimals_for)
    })
}

fn largest(value: [f64; 3]) -> f64 {
    value.into_iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// Three columns of eleven characters.
pub(super) fn columns(values: [f64; 3], decimals: [usize; 3], mark: &str) -> String {
    let text = |k: usize| {
        let v = values[k];
        if !v.is_finite() {
            return format!("{:>11}", "–");
        }
        let n = decimals[k];
        if v.abs() >= ROUND {
            return format!("{:>11}", format!("{mark}{v:.1e}"));
        }
        // What rounds to zero has no sign.
        let shown = format!("{v:.n$}");
        let shown = match shown.strip_prefix('-') {
            Some(rest) if rest.bytes().all(|b| matches!(b, b'0' | b'.')) => rest,
            _ => &shown,
        };
        format!("{:>11}", format!("{mark}{shown}"))
    };
    [0, 1, 2].map(text).concat()
}

fn moves(result: &MotionResult) -> String {
    if result.moves.is_empty() {
        let hidden = result.r#final.sigma_m.map_or(String::new(), |s| {
            let most = largest(s);
            format!(
                " The position is 0 ± {most:.*} m (1σ): so far a move may go that the noise hides.",
                decimals_for(most)
            )
        });
        return format!("\n{}", paragraph("", &format!("Moves: none is seen.{hidden}")));
    }
    let mut out = format!(
        "\nMoves, m{}\n  {:>3} {:>16}{:>11}{:>11}{:>11}{:>9}{:>8}  {}\n",
        if result.moves.iter().any(|m| m.sigma_m.is_some()) {
            " (± 1σ)"
        } else {
            ""
        },
        "",
        "time, s",
        "x",
        "y",
        "z",
        "path",
        "m/s",
        "rest"
    );
    let shown = if result.moves.len() > LISTED {
        LISTED - 1
    } else {
        LISTED
    };
    for (i, m) in result.moves.iter().take(shown).enumerate() {
        out.push_str(&one_move(i, m));
    }
    let rest = result.moves.len().saturating_sub(shown);
    if rest > 0 {
        out.push_str(&format!("  … and {rest} more; --json has all\n"));
    }
    out.push_str("  path: its length; m/s: highest speed; rest: at which of its ends\n");
    out
}

fn one_move(i: usize, m: &Move) -> String {
    let when = format!("{:.2}–{:.2}", m.start_s, m.end_s);
    let ends = match m.ends {
        Ends::RestToRest => "both",
        Ends::FromRest => "start",
        Ends::ToRest => "end",
        Ends::Free => "none",
    };
    let mut out = format!("  {:>3} {when:>16}", i + 1);
    match m.displacement_m {
        Some(d) => {
            let n = decimals(m.sigma_m, d);
            // No finer than the displacement.
            let path = m.path_m.map_or(String::new(), |p| {
                format!(
                    "{p:.*}",
                    decimals_of(p, 3).min(n[0].max(n[1]).max(n[2])).min(6)
                )
            });
            let peak = m.peak_speed_mps.map_or(String::new(), |p| {
                format!("{p:.*}", decimals_of(p, 2).min(5))
            });
            out.push_str(&format!(
                "{}{path:>9}{peak:>8}  {ends}\n",
                columns(d, n, "")
            ));
            if let Some(s) = m.sigma_m {
                out.push_str(&format!("{:22}{}\n", "", columns(s, n, "± ")));
            }
        }
        None => out.push_str(&format!("{:>33}{:19}{ends}\n", "not usable", "")),
    }
    if let Some(reason) = &m.reason {
        out.push_str(&paragraph("      ", reason));
    }
    out
}

fn end(result: &MotionResult) -> String {
    let last = &result.r#final;
    if result.moves.is_empty() {
        return String::new();
    }
    let Some(position) = last.position_m else {
        return "\nPosition at the end: not known, since a move before it is not usable.\n"
            .to_owned();
    };
    let n = decimals(last.sigma_m, position);
    let mut out = format!("\nAt the end{:>24}{:>11}{:>11}\n", "x", "y", "z");
    let mut row = |name: &str, values: [f64; 3], decimals: [usize; 3], mark: &str| {
        out.push_str(&format!(
            "  {name:<21}{}\n",
            columns(values, decimals, mark)
        ));
    };
    row("position, m", position, n, "");
    if let Some(sigma) = last.sigma_m {
        row("", sigma, n, "± ");
    }
    if let Some(other) = result.uncalibrated.and_then(|u| u.position_m) {
        row("uncalibrated", other, n, "");
    }
    let moving = |v: &[f64; 3]| v.iter().any(|v| v.abs() > 0.0);
    if let Some(velocity) = last.velocity_mps.filter(moving) {
        let n = [decimals_of(largest(velocity), 2).min(3); 3];
        row("velocity, m/s", velocity, n, "");
        if let Some(other) = result.uncalibrated.and_then(|u| u.velocity_mps) {
            row("uncalibrated", other, n, "");
        }
    }
    out
}

fn budget(result: &MotionResult) -> String {
    let Some(b) = result.budget_m else {
        return String::new();
    };
    let parts = [
        ("noise", b.noise),
        ("bias", b.bias),
        ("scale", b.scale),
        ("clock", b.clock),
        ("attitude", b.tilt),
    ];
    let total = parts.iter().map(|(_, v)| v * v).sum::<f64>().sqrt();
    if total == 0.0 || !total.is_finite() {
        return String::new();
    }
    let (factor, unit) = if total < 0.1 { (1e3, "mm") } else { (1.0, "m") };
    let n = decimals_of(factor * total, 2).min(3);
    let list: Vec<String> = parts
        .iter()
        .map(|(name, v)| format!("{name} {:.n$}", factor * v))
        .collect();
    let mut out = format!(
        "\nUncertainty of it, 1σ, all axes together: {:.n$} {unit}\n",
        factor * total
    );
    out.push_str(&paragraph(
        "  ",
        &format!("{} (squares add up)", list.join(", ")),
    ));
    out
}

fn static_drift(d: &StaticDrift) -> String {
    let n = decimals(Some(d.predicted_sigma_m), d.position_m);
    let mut out = format!(
        "\nDrift at rest over {:.1} s, nothing corrected, levelled over the {:.1} s before\n{:>34}{:>11}{:>11}\n",
        d.duration_s, d.levelled_over_s, "x", "y", "z"
    );
    let mut row = |name: &str, values: [f64; 3], decimals: [usize; 3], mark: &str| {
        out.push_str(&format!(
            "  {name:<21}{}\n",
            columns(values, decimals, mark)
        ));
    };
    row("position, m", d.position_m, n, "");
    row("predicted, 1σ", d.predicted_sigma_m, n, "± ");
    row(
        "as by a bias, mm/s²",
        d.bias_mps2.map(|v| 1e3 * v),
        [1; 3],
        "",
    );
    row(
        "that rises, mm/s³",
        d.slope_mps3.map(|v| 1e3 * v),
        [2; 3],
        "",
    );
    row("left over, m", d.unexplained_m, n, "");
    let over: [f64; 3] = std::array::from_fn(|k| d.position_m[k].abs() / d.predicted_sigma_m[k]);
    let farthest = over.into_iter().fold(0.0, f64::max);
    let judged = if !farthest.is_finite() {
        "no band was predicted".to_owned()
    } else if farthest <= FAR {
        format!("within the predicted band ({farthest:.1}σ at most)")
    } else {
        format!(
            "{farthest:.1}σ off: the band does not explain it; the bias drifts, or the sensor was not quite at rest"
        )
    };
    out.push_str(&paragraph(
        "  ",
        &format!("That is {judged}. With the zero-velocity correction it would be zero by construction, which would prove nothing."),
    ));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_show_two_digits_of_their_uncertainty() {
        let n = decimals(Some([0.0028, 0.31, 0.012]), [1.0; 3]);
        assert_eq!(
            columns([0.69934, -0.001, f64::NAN], n, ""),
            "     0.6993       0.00          –"
        );
        assert_eq!(columns([0.0028; 3], n, "± ").chars().count(), 33);
        // A day of drift stays in its columns.
        assert_eq!(
            columns([-2.484e9, 25_192_777_403.0, 999_999.4], [0; 3], "± "),
            "   ± -2.5e9   ± 2.5e10   ± 999999"
        );
        assert_eq!(decimals(None, [12.3, 0.1, 0.0]), [2; 3]);
        assert_eq!(decimals(Some([f64::NAN; 3]), [0.0; 3]), [6; 3]);
    }

    #[test]
    fn many_rests_are_summed_up() {
        let span = |start_s: f64| Span {
            start_s,
            end_s: start_s + 1.0,
        };
        let all: Vec<Span> = (0..9).map(|i| span(2.0 * f64::from(i))).collect();
        assert_eq!(
            rests(&all),
            "9 of 9.0 s in all: 0.00–1.00, 2.00–3.00, … 16.00–17.00 s"
        );
        assert_eq!(rests(&all[..2]), "0.00–1.00, 2.00–3.00 s");
        assert_eq!(rests(&[]), "none");
    }
}
