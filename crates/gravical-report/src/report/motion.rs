//! Report of a motion: timing, rests, moves, end point, uncertainty budget, comparison with a
//! reference.

use gravical::core::matrix3::norm;

use crate::document::{Block, Cell, Document, Grade, Row, Section, Table, Verdict};
use crate::figure::Figure;
use gravical::motion::{MotionJudgement, MotionResult};
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
    .with(figure("trajectory", "Trajectory", &["trajectory"]))
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
    // One number for one move, the end for several.
    let sigma = result.r#final.sigma_m.map(|s| digits(largest(s), 2));
    let conclusion = match (displacement(result), sigma) {
        _ if usable == 0 => None,
        (Some(displacement), _) => Some(displacement),
        (None, Some(sigma)) => Some(format!(
            "{usable} of {all} moves are usable, end position ± {sigma} m on the worst axis (1σ)"
        )),
        (None, None) => None,
    };
    let doubt = misfit.map_or("", |_| "; the calibration does not fit");
    let word = words(&result.verdict.judgement);
    Verdict {
        conclusion: conclusion.map(|text| text + doubt),
        ..Verdict::new(grade, &word, &result.verdict.reasons)
    }
}

/// Displacement of the only move, with its uncertainty along it where that is known.
fn displacement(result: &MotionResult) -> Option<String> {
    let [only] = &result.moves[..] else {
        return None;
    };
    let displacement = only.displacement_m?;
    let long = norm(&displacement);
    let Some(s) = only.sigma_m.filter(|_| long > 0.0) else {
        return Some(format!("displacement {} m", digits(long, 3)));
    };
    let parts: [f64; 3] = std::array::from_fn(|i| s[i] * displacement[i] / long);
    let sd = norm(&parts);
    let long = fixed(long, decimals_by(Some(sd), long));
    Some(format!("displacement {long} ± {} m (± 1σ)", digits(sd, 2)))
}

/// How the recording was read and processed.
fn timing<'a>(result: &MotionResult, recording: &Recording) -> Section<'a> {
    // A finding reports a unit that is decided later.
    let gyro = match &recording.gyro {
        Some(_) => "; with a gyroscope",
        None => "; no gyroscope",
    };
    let (unit, origin) = (
        recording.accel_scale.unit,
        origin(recording.accel_scale.origin),
    );
    let calibration = result.calibration.as_deref();
    let calibration = calibration.map_or("none, nominal scale".to_owned(), short_name);
    let at_rest_s: f64 = result.rests.iter().map(|s| s.end_s - s.start_s).sum();
    let rests = match result.rests.len() {
        0 => "none".to_owned(),
        count => format!("{count}, {at_rest_s:.1} s in total"),
    };
    Section::new("timing", "Timing and procedure").with(Block::facts([
        ("read as", Some(recording.description.clone())),
        (
            "unit",
            Some(format!("accelerometer {unit} ({origin}){gyro}")),
        ),
        ("calibration", Some(calibration)),
        ("procedure", Some(result.procedure.clone())),
        ("frame", Some(result.frame.clone())),
        ("time", Some(time(result))),
        ("rests", Some(rests)),
    ]))
}

fn time(result: &MotionResult) -> String {
    let rate = match (result.rate_hz.r#true, result.rate_hz.nominal) {
        (Some(rate), _) => format!("{rate:.2} Hz from time stamps"),
        (None, Some(rate)) => format!("{rate} Hz according to the file, no time stamps"),
        (None, None) => "rate unknown".to_owned(),
    };
    let left_out = match result.rows_left_out {
        0 => String::new(),
        n => format!("; {n} rows skipped"),
    };
    format!("{:.2} s, {rate}{left_out}", result.duration_s)
}

fn rests<'a>(result: &MotionResult) -> Section<'a> {
    let section = Section::new("rests", "Rests");
    if result.rests.is_empty() {
        return section.full(Block::paragraph("No rest was found."));
    }
    let rests = result.rests.iter().enumerate().map(|(i, span)| {
        let times = [span.start_s, span.end_s, span.end_s - span.start_s];
        Row::named(
            (i + 1).to_string(),
            times.map(|s| Cell::number(fixed(s, 2))),
        )
    });
    let table = Table::new("").columns(["rest", "from, s", "to, s", "duration, s"]);
    let section = section.full(table.rows(rests));
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
