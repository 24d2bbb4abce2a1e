//! Report of a motion: figures, moves, end point, uncertainty budget,
//! timing, rests.

use std::path::Path;

use gravical::calibration_file::Grade;
use gravical::core::matrix3::norm;
use gravical::escape::path_word;
use gravical::motion::{
    Computation, Ends, MotionJudgement, MotionResult, Move, OrientationJudgement, OrientationResult,
};
use gravical::numfmt::{COVERAGE, count, decimals_for, decimals_of, digits, fixed, name, signed};
use gravical::recording::Recording;

use super::inspection::origin;
use super::{largest, short_name};
use crate::document::{Block, Cell, Document, HOW, Section, Step, Table, Verdict, capital};
use crate::figure::{Figure, XYZ};

/// The document of a motion computed from `recording`, with its figures ([`figure::motion::figures`](crate::figure::motion::figures)).
pub fn motion<'a>(
    result: &MotionResult,
    recording: &Recording,
    figures: &'a [Figure],
) -> Document<'a> {
    let figure = |title, names: &[&str]| Section::new(title).figures(figures, names);
    // For a recording at rest the verdict says everything.
    let moved = !result.moves.is_empty();
    let budget = least_certain(result);
    let drawn = |name: &&&str| figures.iter().any(|f| f.name == **name);
    let firsts = ["path", "position", "acceleration"];
    let first = *firsts.iter().find(drawn).unwrap_or(&"path");
    let accelerations = ["motion-acceleration", "acceleration"];
    let accelerations = &accelerations[..if first == "acceleration" { 1 } else { 2 }];
    Document {
        certificate: certificate(&result.computation, recording),
        verdict: Some(verdict(result)),
        ..Document::new(format!(
            "Motion of {}",
            short_name(&result.computation.input)
        ))
    }
    .with(figure("Path", &[first]).wide(7))
    .with(figure("Position", &["position"]).wide(6))
    .with(figure("Velocity", &["velocity"]).wide(6))
    .with(moved.then(|| moves(result).wide(7)))
    .with(budget.map(|(number, one)| error_budget(number, result.moves.len() == 1, one).wide(5)))
    .with(moved.then(|| end(result).folded("with the calibration and without")))
    .with(figure("Acceleration", accelerations).folded("without gravity; as measured"))
    .with(rests(result).folded(count(result.computation.rests.len(), "rest")))
    .with(timing(&result.computation, recording))
    .with_findings(&result.findings, false)
}

/// The document of an orientation.
pub fn orientation<'a>(
    result: &OrientationResult,
    recording: &Recording,
    figures: &'a [Figure],
) -> Document<'a> {
    let within = |sd: Option<f64>| sd.map(|sd| digits(COVERAGE * sd, 2) + "°");
    let tilt = within(result.largest_sigma_tilt_deg).map(|u| format!("tilt ± {u}"));
    let heading = within(result.largest_sigma_heading_deg);
    let heading = heading.map(|u| format!("heading ± {u} of the start"));
    let parts: Vec<String> = tilt.into_iter().chain(heading).collect();
    let grade = match result.verdict.judgement {
        OrientationJudgement::Known => Grade::Good,
        OrientationJudgement::NotKnown => Grade::Poor,
        _ => Grade::Fair,
    };
    let rests = result.computation.rests.len();
    let proof = (rests > 0).then(|| format!("Levelled at {}; heading is relative to the start, and nothing but the gyroscope knows it.", count(rests, "rest")));
    let columns = ["roll, °", "pitch, °", "yaw, °", "tilt ±, °", "heading ±, °"];
    let table = result.ends.map(|ends| {
        let mut table = Table::new("", ["", "at, s"]).columns(columns);
        for (name, a) in ["start", "end"].into_iter().zip(ends) {
            let n = a.sigma_tilt_deg.map_or(1, decimals_for);
            let mut cells = seconds([a.t_s]);
            cells.extend(
                a.roll_pitch_yaw_deg
                    .map(|angle| Cell::number(fixed(angle, n))),
            );
            let sigmas = [a.sigma_tilt_deg, a.sigma_heading_deg];
            cells.extend(sigmas.map(|sd| Cell::maybe(sd, |sd| digits(COVERAGE * sd, 2))));
            table = table.row(name, cells);
        }
        Section::new("Start and end").with(table)
    });
    let board = result.ends.map(|[start, _]| {
        let board = Block::Board(start.roll_pitch_yaw_deg, "angles");
        Section::new("Board at the start").full(board)
    });
    Document {
        certificate: certificate(&result.computation, recording),
        verdict: Some(Verdict {
            grade,
            word: name(&result.verdict.judgement),
            headline: match &parts[..] {
                [] => ["Not known".to_owned(), String::new()],
                parts => [capital(&parts.join(", ")), "95 %".to_owned()],
            },
            proof: proof
                .into_iter()
                .chain(result.verdict.reasons.iter().cloned())
                .collect(),
            numbers: Vec::new(),
            reasons: result.verdict.reasons.clone(),
            next: Vec::new(),
        }),
        ..Document::new(format!(
            "Orientation of {}",
            short_name(&result.computation.input)
        ))
    }
    .with(Section::new("Angles").figures(figures, &["angles"]).wide(7))
    .with(board.map(|b| b.wide(5)))
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
        MotionJudgement::AtRest | MotionJudgement::Open => Grade::NotVerifiable,
        _ => Grade::Poor,
    };
    let share = v
        .ratio
        .filter(|_| v.judgement.is_known() && v.judgement != MotionJudgement::AtRest);
    let share = share.map(|ratio| {
        let percent = digits(100.0 * ratio, 2);
        format!(
            "The uncertainty of the end is {percent} % of the farthest distance from the start."
        )
    });
    let parts = result.r#final.position_m.zip(result.r#final.sigma_m);
    let parts = parts
        .filter(|_| !result.moves.is_empty())
        .map(|(position, sd)| {
            [0, 1, 2].map(|k| {
                let (value, within) = (position[k], COVERAGE * sd[k]);
                let value = signed(value, decimals_for(within));
                [
                    format!("{value} m"),
                    format!("{} ± {} m", XYZ[k], digits(within, 2)),
                ]
            })
        });
    Verdict {
        grade,
        word: name(&v.judgement),
        headline: headline(result).unwrap_or_default(),
        proof: share.into_iter().chain(v.reasons.iter().cloned()).collect(),
        numbers: parts.map_or(Vec::new(), Vec::from),
        reasons: v.reasons.clone(),
        next: next(result).into_iter().collect(),
    }
}

/// The move that is least certain, with its number.
fn least_certain(result: &MotionResult) -> Option<(usize, &Move)> {
    let known = (1..)
        .zip(&result.moves)
        .filter(|(_, m)| m.budget_m.is_some());
    let sd = |m: &Move| m.sigma_m.map_or(0.0, |sd| norm(&sd));
    known.max_by(|a, b| sd(a.1).total_cmp(&sd(b.1)))
}

/// What would make the end better known.
fn next(result: &MotionResult) -> Option<Step> {
    if result.moves.iter().any(|m| m.unusable.is_some()) {
        return None;
    }
    let calibration = result.computation.calibration.as_deref();
    if let Some(path) = calibration.filter(|_| result.gravity_misfit.is_some_and(|m| m.contradicts))
    {
        let [path, input] = [path, &result.computation.input].map(|p| path_word(Path::new(p)));
        let files = format!("{path} {input}");
        return Some(Step::run("Test the calibration", "check", &files));
    }
    let [noise, own, attitude] = parts(least_certain(result)?.1)?;
    let most = noise.max(own).max(attitude);
    let calibrate = |what| Step::run(what, "calibrate", "SESSION -o cal.json");
    Some(match () {
        () if most == own && calibration.is_none() => {
            calibrate("The largest part of the error is the sensor's")
        }
        () if most == own => {
            calibrate("The largest part of the error is the calibration's, which more poses lower")
        }
        () if most == noise => Step::by_hand(
            "The largest part of the error is noise, which grows with the length of a move: rest more often",
        ),
        () => Step::by_hand(
            "The largest part of the error is the attitude in the move: rest more often, and calibrate the gyroscope",
        ),
    })
}

/// The one number: how far it moved, or how well its end is known.
fn headline(result: &MotionResult) -> Option<[String; 2]> {
    let v = &result.verdict;
    let (size, within) = (v.size_m, v.expanded_m);
    let text = match (v.judgement, &result.moves[..]) {
        (MotionJudgement::AtRest, []) => "At rest".to_owned(),
        (MotionJudgement::AtRest, _) => {
            format!("Moved by less than {} m", digits(within? + size?, 2))
        }
        (MotionJudgement::PositionNotKnown, _) => match size.zip(within) {
            Some((size, within)) => {
                let [size, within] = [size, within].map(|v| digits(v, 2));
                format!("Known to ± {within} m; it spans {size} m")
            }
            None => "Where it ends is not known".to_owned(),
        },
        (_, [only]) => {
            let long = norm(&only.displacement_m?);
            match within {
                Some(u) => format!(
                    "Moved {} ± {} m",
                    fixed(long, decimals_for(u)),
                    digits(u, 2)
                ),
                None => format!("Moved {} m", digits(long, 3)),
            }
        }
        _ => {
            let [size, within] = [size?, within?].map(|v| digits(v, 2));
            format!("End known to ± {within} m; it spans {size} m")
        }
    };
    let share = if within.is_some() { "95 %" } else { "" };
    Some([text, share.to_owned()])
}

/// What was recorded, and by what it was calibrated.
fn certificate(of: &Computation, recording: &Recording) -> Vec<[String; 3]> {
    let rate = of.rate_hz.r#true.or(of.rate_hz.nominal);
    let rate = rate.map_or("rate unknown".to_owned(), |rate| format!("{rate:.2} Hz"));
    let calibration = of.calibration.as_deref();
    let calibration = calibration.map_or("none, nominal scale".to_owned(), short_name);
    let gyro = if recording.gyro.is_some() {
        "yes"
    } else {
        "none"
    };
    let recorded = recording.recorded_at();
    let recorded = recorded.map_or("date unknown".to_owned(), |t| t.minute());
    let entry =
        |name: &str, value: String, remark: &str| [name.to_owned(), value, remark.to_owned()];
    vec![
        entry("Recording", short_name(&of.input), ""),
        entry("Recorded", recorded, ""),
        entry("Calibration", calibration, ""),
        entry("Length", format!("{:.1} s", of.duration_s), &rate),
        entry("Gyroscope", gyro.to_owned(), ""),
        entry("Rests", of.rests.len().to_string(), ""),
    ]
}

/// Decimals of each axis for a length with this uncertainty, m: two digits of it;
/// without one four digits of the largest value.
fn decimals(sigma: Option<[f64; 3]>, value: [f64; 3]) -> [usize; 3] {
    sigma.map_or([decimals_of(largest(&value).max(1e-3), 4); 3], |s| {
        s.map(|sd| decimals_for(COVERAGE * sd))
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
        .axes("displacement ± 95 %, m")
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
    let table = Table::new("Position relative to the start, ± 95 %", [""])
        .axes("")
        .row("position, m", lengths(Some(position), last.sigma_m, n));
    section.with(match result.uncalibrated {
        Some(plain) => table.row("uncalibrated, m", lengths(plain.position_m, None, n)),
        None => table,
    })
}

/// What the uncertainty of a move consists of, along its displacement: noise, calibration, attitude, 1σ, m.
fn parts(one: &Move) -> Option<[f64; 3]> {
    let (b, displacement) = (one.budget_m?, one.displacement_m?);
    let long = norm(&displacement);
    let along = |sd: [f64; 3]| match long > 0.0 {
        true => norm(&[0, 1, 2].map(|i| displacement[i] / long * sd[i])),
        false => largest(&sd),
    };
    Some([b.noise, b.calibration, b.attitude].map(along))
}

fn error_budget<'a>(number: usize, only: bool, one: &Move) -> Section<'a> {
    let section = Section::new("Error budget");
    let Some([noise, calibration, attitude]) = parts(one) else {
        return section;
    };
    let parts = [
        (noise, "noise, levelling, clock"),
        (calibration, "calibration, gravity"),
        (attitude, "attitude in the move"),
    ];
    let total = norm(&parts.map(|(value, _)| value));
    if total == 0.0 || !total.is_finite() {
        return section;
    }
    let of = if only {
        "Along the displacement".to_owned()
    } else {
        format!("Move {number}, the least certain one, along its displacement")
    };
    let (unit, factor) = if total < 1.0 { ("mm", 1e3) } else { ("m", 1.0) };
    let n = decimals_of(factor * COVERAGE * total, 2).min(3);
    let cell = |value: f64| Cell::number(fixed(COVERAGE * factor * value, n));
    let columns = [
        "source".to_owned(),
        format!("± 95 %, {unit}"),
        "share, %".to_owned(),
    ];
    let columns = columns.iter().map(String::as_str);
    let mut table = Table::new(of, columns);
    for (value, what) in parts {
        let share = 100.0 * value * value / (total * total);
        table = table.row(what, [cell(value), Cell::Share(share)]);
    }
    let together = [cell(total), Cell::text("")];
    section.with(table.row("together (root sum of squares)", together))
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
    Section::new(HOW)
        .folded("procedure, frame, time")
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
