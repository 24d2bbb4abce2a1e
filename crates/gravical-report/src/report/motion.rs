//! Report of a motion: timing, rests, moves, end point, uncertainty budget, comparison with a
//! reference.

use gravical::core::matrix3::norm;

use crate::document::{Block, Cell, Document, Grade, KeyFigure, Row, Section, Table, Verdict};
use crate::figure::Figure;
use gravical::motion::{MotionJudgement, MotionResult, Span};
use gravical::numfmt::{decimals_by, digits, fixed, words};
use gravical::recording::Recording;

use super::inspection::origin;
use super::moves::{end, error_budget, largest, moves, truth};
use super::{named, short_name};

/// The document of a motion computed from `recording`, with its figures ([`figure::motion::figures`](crate::figure::motion::figures)).
pub fn motion<'a>(
    result: &MotionResult,
    recording: &Recording,
    figures: &'a [Figure],
) -> Document<'a> {
    let figure = |id, title, names: &[&str]| Section::new(id, title).figures(named(figures, names));
    // For a recording at rest the verdict says everything.
    let moved = !result.moves.is_empty();
    let only = result.moves.len() == 1;
    let budget = result.largest_budget().filter(|_| moved);
    Document {
        verdict: Some(verdict(result)),
        ..Document::new(format!("Motion of {}", short_name(&result.input)))
    }
    .with(figure("position", "Position", &["position"]))
    .with(figure(
        "trajectory",
        "Trajectory",
        &["trajectory", "position-3d"],
    ))
    .with(figure("velocity", "Velocity", &["velocity"]))
    .with(figure(
        "acceleration",
        "Acceleration",
        &["acceleration", "motion-acceleration"],
    ))
    .with(moved.then(|| moves(result)))
    .with(moved.then(|| end(result)))
    .with(budget.map(|(number, b)| error_budget(number, only, &b)))
    .with(result.truth.as_ref().map(truth))
    .with(timing(result, recording))
    .with(rests(result))
    .with_findings(&result.findings, false)
}

/// What can be determined from the recording.
fn verdict(result: &MotionResult) -> Verdict {
    let all = result.moves.len();
    let usable = result.moves.iter().filter(|m| m.unusable.is_none()).count();
    let misfit = result.gravity_misfit.filter(|m| m.contradicts);
    let grade = match result.verdict.judgement {
        MotionJudgement::Bounded if misfit.is_none() => Grade::Good,
        MotionJudgement::NotUsable => Grade::Poor,
        MotionJudgement::AtRest => Grade::Unknown,
        _ => Grade::Fair,
    };
    let duration = || KeyFigure::new(fixed(result.duration_s, 2), "s", "duration");
    let known = KeyFigure::new(format!("{usable} of {all}"), "", "usable moves");
    let sigma = result.r#final.sigma_m.map(|s| {
        let what = "standard uncertainty of the end position, worst axis (1σ)";
        KeyFigure::new(format!("± {}", digits(largest(s), 2)), "m", what)
    });
    let mut figures = vec![single(result).unwrap_or_else(duration), known];
    figures.extend(sigma);
    // One number for one move, the end for several.
    let conclusion = match single(result) {
        Some(f) if usable > 0 => Some(format!("displacement {} m{}", f.value, one_sigma(f.value.contains('±')))),
        _ if usable > 0 => result.r#final.sigma_m.map(|sigma| {
            let sigma = digits(largest(sigma), 2);
            format!("{usable} of {all} moves are usable, end position ± {sigma} m on the worst axis (1σ)")
        }),
        _ => None,
    };
    let doubt = misfit.map_or("", |_| "; the calibration does not fit");
    Verdict {
        heading: "Result",
        conclusion: conclusion.map(|text| text + doubt),
        figures,
        ..Verdict::new(
            grade,
            &words(&result.verdict.judgement),
            &result.verdict.reasons,
        )
    }
}

/// Displacement of the only move, calibrated and uncalibrated.
fn single(result: &MotionResult) -> Option<KeyFigure> {
    let [only] = &result.moves[..] else {
        return None;
    };
    let (displacement, sigma) = (only.displacement_m?, only.sigma_m);
    let long = norm(&displacement);
    // Uncertainty along the displacement; undefined if that is zero.
    let sd = sigma.filter(|_| long > 0.0).map(|s| {
        let parts: [f64; 3] = std::array::from_fn(|i| s[i] * displacement[i] / long);
        norm(&parts)
    });
    let n = decimals_by(sd, long);
    let text = match sd {
        Some(sd) => format!("{} ± {}", fixed(long, n), digits(sd, 2)),
        None => digits(long, 3),
    };
    let plain = only.uncalibrated_m.map_or(String::new(), |u| {
        format!("; uncalibrated {} m", fixed(norm(&u), n))
    });
    let what = format!("displacement{}{plain}", one_sigma(sd.is_some()));
    Some(KeyFigure::new(text, "m", what))
}

/// What an uncertainty behind a value is.
fn one_sigma(is_there: bool) -> &'static str {
    if is_there { " (± 1σ)" } else { "" }
}

/// How the recording was read and processed.
fn timing<'a>(result: &MotionResult, recording: &Recording) -> Section<'a> {
    let mut facts: Vec<(String, String)> = Vec::new();
    let mut fact = |name: &str, text: String| facts.push((name.to_owned(), text));
    fact("read as", recording.description.clone());
    // A finding reports a unit that is decided later.
    let gyro = match &recording.gyro {
        Some(_) => "; with a gyroscope",
        None => "; no gyroscope",
    };
    let origin = origin(recording.accel_scale.origin);
    let unit = recording.accel_scale.unit;
    fact("unit", format!("accelerometer {unit} ({origin}){gyro}"));
    let none = "none, nominal scale".to_owned();
    let calibration = result.calibration.as_deref().map_or(none, short_name);
    fact("calibration", calibration);
    fact("procedure", result.procedure.clone());
    fact("frame", result.frame.clone());
    fact("time", time(result));
    fact("rests", rest_list(&result.rests));
    if let Some(noise) = &result.noise {
        let three = |v: [f64; 3]| v.map(|n| digits(1e3 * n, 2)).join(" ");
        let gyro = noise.gyro_n.map_or(String::new(), |n| {
            format!("; gyroscope {} mrad/s/√Hz", three(n))
        });
        let accel = three(noise.accel_n);
        fact(
            "noise",
            format!("accelerometer {accel} mm/s²/√Hz{gyro} (N at rest)"),
        );
    }
    Section::new("timing", "Timing and procedure")
        .opening()
        .with(Block::Facts(facts))
}

fn time(result: &MotionResult) -> String {
    let rate = match (result.rate_hz.r#true, result.rate_hz.nominal) {
        (Some(t), Some(n)) if (t / n - 1.0).abs() > 0.002 => {
            format!("{t:.2} Hz from time stamps; {n} Hz according to the file")
        }
        (Some(t), _) => format!("{t:.2} Hz from time stamps"),
        (None, Some(n)) => format!("{n} Hz according to the file, no time stamps"),
        (None, None) => "rate unknown".to_owned(),
    };
    let left_out = match result.rows_left_out {
        0 => String::new(),
        n => format!("; {n} rows skipped"),
    };
    format!("{:.2} s, {rate}{left_out}", result.duration_s)
}

fn rest_list(still: &[Span]) -> String {
    let span = |s: &Span| format!("{:.2}–{:.2}", s.start_s, s.end_s);
    let total: f64 = still.iter().map(|s| s.end_s - s.start_s).sum();
    let list = |spans: &[Span]| spans.iter().map(span).collect::<Vec<_>>().join(", ");
    match still {
        [] => "none".to_owned(),
        few @ ([_] | [_, _] | [_, _, _] | [_, _, _, _]) => format!("{} s", list(few)),
        [first, second, .., last] => format!(
            "{}, {total:.1} s in total: {}, … {} s",
            still.len(),
            list(&[*first, *second]),
            span(last)
        ),
    }
}

fn rests<'a>(result: &MotionResult) -> Section<'a> {
    let section = Section::new("rests", "Rests");
    let spans = result.rests.iter().enumerate().map(|(i, span)| {
        Row::from([
            Cell::text((i + 1).to_string()),
            Cell::number(fixed(span.start_s, 2)),
            Cell::number(fixed(span.end_s, 2)),
            Cell::number(fixed(span.end_s - span.start_s, 2)),
        ])
    });
    let columns = ["from", "to", "duration"];
    let table = Table::new("Rests, s").columns(["rest"]).columns(columns);
    let section = if result.rests.is_empty() {
        section.full(Block::paragraph("No rest was found."))
    } else {
        section.full(table.rows(spans))
    };
    let hidden = result.visible_moves.iter();
    let hidden = hidden.map(|v| {
        let (duration, distance) = (digits(v.seconds, 2), digits(v.distance_m, 2));
        format!("{distance} m in {duration} s")
    });
    let hidden: Vec<String> = hidden.collect();
    if hidden.is_empty() {
        return section;
    }
    let hidden = format!("A shorter move may hide in a rest: {}.", hidden.join(", "));
    section.full(Block::Paragraph(hidden))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_of_rests_are_shortened() {
        let span = |start_s: f64| Span {
            start_s,
            end_s: start_s + 1.0,
        };
        let all: Vec<Span> = (0..9).map(|i| span(2.0 * f64::from(i))).collect();
        assert_eq!(
            rest_list(&all),
            "9, 9.0 s in total: 0.00–1.00, 2.00–3.00, … 16.00–17.00 s"
        );
        assert_eq!(rest_list(&all[..2]), "0.00–1.00, 2.00–3.00 s");
        assert_eq!(rest_list(&[]), "none");
    }
}
