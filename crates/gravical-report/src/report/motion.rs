//! Report of a motion: figures, moves, end point, uncertainty budget,
//! timing, rests.

use gravical::calibration_file::Grade;
use gravical::core::matrix3::norm;
use gravical::motion::{
    Budget, Computation, Ends, MotionJudgement, MotionResult, OrientationJudgement,
    OrientationResult,
};
use gravical::numfmt::{decimals_for, decimals_of, digits, fixed, name};
use gravical::recording::Recording;

use super::inspection::origin;
use super::{largest, short_name};
use crate::document::{Block, Cell, Document, Section, Table, Verdict};
use crate::figure::Figure;

/// The document of a motion computed from `recording`, with its figures ([`figure::motion::figures`](crate::figure::motion::figures)).
pub fn motion<'a>(
    result: &MotionResult,
    recording: &Recording,
    figures: &'a [Figure],
) -> Document<'a> {
    let figure = |title, names: &[&str]| Section::new(title).figures(figures, names);
    // For a recording at rest the verdict says everything.
    let moved = !result.moves.is_empty();
    // Of the move that is least certain.
    let budgets = (1..).zip(&result.moves);
    let budgets = budgets.filter_map(|(number, m)| Some((number, m.budget_m?, norm(&m.sigma_m?))));
    let budget = budgets.max_by(|a, b| a.2.total_cmp(&b.2));
    let accelerations = ["acceleration", "motion-acceleration"];
    Document {
        verdict: Some(verdict(result)),
        ..Document::new(format!(
            "Motion of {}",
            short_name(&result.computation.input)
        ))
    }
    .with(figure("Position", &["position"]))
    .with(figure("Trajectory", &["trajectory"]))
    .with(figure("Velocity", &["velocity"]))
    .with(figure("Acceleration", &accelerations))
    .with(moved.then(|| moves(result)))
    .with(moved.then(|| end(result)))
    .with(budget.map(|(number, b, _)| error_budget(number, result.moves.len() == 1, &b)))
    .with(timing(&result.computation, recording))
    .with(rests(result))
    .with_findings(&result.findings, false)
}

/// The document of an orientation.
pub fn orientation<'a>(result: &OrientationResult, recording: &Recording) -> Document<'a> {
    let within = |sd: Option<f64>| sd.map(|sd| digits(2.0 * sd, 2) + "°");
    let tilt = within(result.largest_sigma_tilt_deg).map(|u| format!("tilt within {u}"));
    let heading = within(result.largest_sigma_heading_deg);
    let heading = heading.map(|u| format!("heading within {u} of the start"));
    let parts: Vec<String> = tilt.into_iter().chain(heading).collect();
    let conclusion = (!parts.is_empty()).then(|| parts.join(", ") + " (95 %)");
    let grade = match result.verdict.judgement {
        OrientationJudgement::Known => Grade::Good,
        OrientationJudgement::NotKnown => Grade::Poor,
        _ => Grade::Fair,
    };
    let columns = ["roll", "pitch", "yaw", "tilt ± 1σ", "heading ± 1σ"];
    let table = result.ends.map(|ends| {
        let mut table = Table::new("Attitude, degrees", ["", "at, s"]).columns(columns);
        for (name, a) in ["start", "end"].into_iter().zip(ends) {
            let n = a.sigma_tilt_deg.map_or(1, decimals_for);
            let mut cells = seconds([a.t_s]);
            cells.extend(
                a.roll_pitch_yaw_deg
                    .map(|angle| Cell::number(fixed(angle, n))),
            );
            let sigmas = [a.sigma_tilt_deg, a.sigma_heading_deg];
            cells.extend(sigmas.map(|sd| Cell::maybe(sd, |sd| digits(sd, 2))));
            table = table.row(name, cells);
        }
        Section::new("Start and end").with(table)
    });
    Document {
        verdict: Some(Verdict {
            grade,
            word: name(&result.verdict.judgement),
            conclusion,
            reasons: result.verdict.reasons.clone(),
            next: Vec::new(),
        }),
        ..Document::new(format!(
            "Orientation of {}",
            short_name(&result.computation.input)
        ))
    }
    .with(table)
    .with(timing(&result.computation, recording))
    .with_findings(&result.findings, false)
}

/// What the position is worth: of one move its displacement, of several how far it went.
fn verdict(result: &MotionResult) -> Verdict {
    let v = &result.verdict;
    let misfit = result.gravity_misfit.filter(|m| m.contradicts);
    let grade = match v.judgement {
        MotionJudgement::Usable if misfit.is_none() => Grade::Good,
        MotionJudgement::Usable | MotionJudgement::Rough => Grade::Fair,
        MotionJudgement::AtRest => Grade::NotVerifiable,
        _ => Grade::Poor,
    };
    let of = match &result.moves[..] {
        [only] => only.displacement_m.map(|d| ("displacement", norm(&d))),
        _ => v.size_m.map(|size| ("farthest from the start", size)),
    };
    let conclusion = of.map(|(what, long)| {
        let Some(within) = v.expanded_m else {
            return format!("{what} {} m", digits(long, 3));
        };
        if v.judgement == MotionJudgement::AtRest {
            return format!("moved by less than {} m", digits(within.max(long), 2));
        }
        let long = fixed(long, decimals_for(within));
        let within = digits(within, 2);
        match &result.moves[..] {
            _ if v.judgement == MotionJudgement::PositionNotKnown => {
                format!("end ± {within} m (95 %), farther than it went ({long} m)")
            }
            [_] => format!("{what} {long} ± {within} m (95 %)"),
            _ => format!("{what} {long} m, end ± {within} m (95 %)"),
        }
    });
    let conclusion = conclusion.filter(|_| !result.moves.is_empty());
    let doubt = misfit.map_or("", |_| "; the calibration does not fit");
    Verdict {
        grade,
        word: name(&v.judgement),
        conclusion: conclusion.map(|text| text + doubt),
        reasons: v.reasons.clone(),
        next: Vec::new(),
    }
}

/// Decimals of each axis for a length with this uncertainty, m: two digits of it;
/// without one four digits of the largest value.
fn decimals(sigma: Option<[f64; 3]>, value: [f64; 3]) -> [usize; 3] {
    sigma.map_or([decimals_of(largest(&value).max(1e-3), 4); 3], |s| {
        s.map(decimals_for)
    })
}

/// Lengths along the axes with their standard uncertainties, if known.
fn lengths(values: Option<[f64; 3]>, sigma: Option<[f64; 3]>, n: [usize; 3]) -> [Cell; 3] {
    let sigma = sigma.filter(|_| values.is_some());
    std::array::from_fn(|k| {
        let cell = Cell::maybe(values.map(|v| v[k]), |v| fixed(v, n[k]));
        cell.plus_minus(sigma.map(|s| s[k]), n[k])
    })
}

fn seconds<const N: usize>(times: [f64; N]) -> Vec<Cell> {
    times.map(|s| Cell::number(fixed(s, 2))).into()
}

fn moves<'a>(result: &MotionResult) -> Section<'a> {
    let mut table = Table::new("", ["move", "from, s", "to, s"])
        .axes("displacement ± 1σ, m")
        .columns(["path, m", "speed, m/s", "rest at"]);
    for (number, m) in (1..).zip(&result.moves) {
        let n = m.displacement_m.map_or([3; 3], |d| decimals(m.sigma_m, d));
        // At most the digits of the displacement.
        let finest = n.into_iter().max().unwrap_or(3).min(6);
        let ends = match m.ends {
            Ends::RestToRest => "both",
            Ends::FromRest => "start",
            Ends::ToRest => "end",
            Ends::Free => "none",
        };
        let mut cells = seconds([m.start_s, m.end_s]);
        cells.extend(lengths(m.displacement_m, m.sigma_m, n));
        cells.extend([
            Cell::maybe(m.path_m, |v| fixed(v, decimals_of(v, 3).min(finest))),
            Cell::maybe(m.peak_speed_mps, |v| fixed(v, decimals_of(v, 2).min(5))),
            Cell::text(ends),
        ]);
        table = table.row(number.to_string(), cells);
    }
    let unusable = (1..).zip(&result.moves).filter_map(|(number, m)| {
        let why = format!("not usable: {}", m.unusable.as_ref()?);
        Some((format!("move {number}"), why))
    });
    let note = "path: length of the path. speed: peak speed. rest at: the ends of the move at which the sensor is at rest.";
    let section = Section::new("Moves").with(table).reasons(unusable);
    section.with(Block::Note(note.to_owned()))
}

fn end<'a>(result: &MotionResult) -> Section<'a> {
    let section = Section::new("End point");
    let last = &result.r#final;
    let Some(position) = last.position_m else {
        let why = "The end position is unknown because a move before it is not usable.";
        return section.with(Block::Paragraph(why.to_owned()));
    };
    let n = decimals(last.sigma_m, position);
    let table = Table::new("Position relative to the start (± 1σ)", [""])
        .axes("")
        .row("position, m", lengths(Some(position), last.sigma_m, n));
    section.with(match result.uncalibrated {
        Some(plain) => table.row("uncalibrated, m", lengths(plain.position_m, None, n)),
        None => table,
    })
}

fn error_budget<'a>(number: usize, only: bool, b: &Budget) -> Section<'a> {
    let section = Section::new("Error budget");
    let noise = "noise of the accelerometer and of the levelling, clock";
    let attitude = "attitude in the move: gyroscope, or tilts without one";
    let parts = [
        (norm(&b.noise), noise),
        (norm(&b.calibration), "calibration of both sensors, gravity"),
        (norm(&b.attitude), attitude),
    ];
    let total = norm(&parts.map(|(value, _)| value));
    if total == 0.0 || !total.is_finite() {
        return section;
    }
    let of = if only {
        "the displacement".to_owned()
    } else {
        format!("move {number}, the least certain one")
    };
    let n = decimals_of(1e3 * total, 2).min(3);
    let mm = |value: f64| Cell::number(fixed(1e3 * value, n));
    let caption = format!("Uncertainty of {of}, all axes together, 1σ");
    let mut table = Table::new(caption, ["source", "mm", "% of the variance"]);
    for (value, what) in parts {
        let share = 100.0 * value * value / (total * total);
        table = table.row(what, [mm(value), Cell::number(fixed(share, 0))]);
    }
    let all = [mm(total), Cell::number("100")];
    let table = table.row("combined (root sum of squares)", all);
    section.with(table.row("expanded, k = 2", [mm(2.0 * total), Cell::text("")]))
}

/// How the recording was read and processed.
fn timing<'a>(of: &Computation, recording: &Recording) -> Section<'a> {
    // A finding reports a unit that is decided later.
    let gyro = if recording.gyro.is_some() {
        "with a gyroscope"
    } else {
        "no gyroscope"
    };
    let scale = &recording.units.accel;
    let (unit, how) = (scale.unit, origin(scale.origin));
    let calibration = of.calibration.as_deref();
    let calibration = calibration.map_or("none, nominal scale".to_owned(), short_name);
    let at_rest_s: f64 = of.rests.iter().map(|s| s.end_s - s.start_s).sum();
    let rests = match of.rests.len() {
        0 => "none".to_owned(),
        count => format!("{count}, {at_rest_s:.1} s in total"),
    };
    let rate = match (of.rate_hz.r#true, of.rate_hz.nominal) {
        (Some(rate), _) => format!("{rate:.2} Hz from time stamps"),
        (None, Some(rate)) => format!("{rate} Hz according to the file, no time stamps"),
        (None, None) => "rate unknown".to_owned(),
    };
    let mut time = format!("{:.2} s, {rate}", of.duration_s);
    if of.rows_left_out > 0 {
        time += &format!("; {} rows skipped", of.rows_left_out);
    }
    Section::new("Timing and procedure")
        .fact("read as", recording.format.describe())
        .fact("unit", format!("accelerometer {unit} ({how}); {gyro}"))
        .fact("calibration", calibration)
        .fact("procedure", of.procedure.clone())
        .fact("frame", of.frame.clone())
        .fact("time", time)
        .fact("rests", rests)
}

fn rests<'a>(result: &MotionResult) -> Section<'a> {
    let section = Section::new("Rests");
    if result.computation.rests.is_empty() {
        return section.full(Block::Paragraph("No rest was found.".to_owned()));
    }
    let mut table = Table::new("", ["rest", "from, s", "to, s", "duration, s"]);
    for (number, span) in (1..).zip(&result.computation.rests) {
        let times = [span.start_s, span.end_s, span.end_s - span.start_s];
        table = table.row(number.to_string(), seconds(times));
    }
    let section = section.full(table);
    if result.visible_moves.is_empty() {
        return section;
    }
    let hidden = result.visible_moves.iter();
    let hidden = hidden.map(|v| digits(v.distance_m, 2) + " m in " + &digits(v.seconds, 2) + " s");
    let hidden = hidden.collect::<Vec<_>>().join(", ");
    let mut text = format!("A shorter move may hide in a rest: {hidden}.");
    if let Some(speed_mps) = result.visible_speed_mps {
        let speed = digits(100.0 * speed_mps, 2);
        text += &format!(" A steady travel below {speed} cm/s would look like one.");
    }
    section.full(Block::Paragraph(text))
}
