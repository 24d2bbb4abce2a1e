//! Report of a motion: figures, moves, end point, uncertainty budget,
//! timing, rests.

use gravical::calibration_file::Grade;
use gravical::core::matrix3::norm;
use gravical::motion::{
    Budget, Computation, Ends, MotionJudgement, MotionResult, OrientationJudgement,
    OrientationResult,
};
use gravical::numfmt::{count, decimals_for, decimals_of, digits, fixed, name, signed};
use gravical::recording::Recording;

use super::inspection::origin;
use super::{largest, short_name};
use crate::document::{Block, COVERAGE, Cell, Document, HOW, Section, Table, Verdict};
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
    // Of the move that is least certain.
    let budgets = (1..).zip(&result.moves);
    let budgets = budgets.filter_map(|(number, m)| Some((number, m.budget_m?, norm(&m.sigma_m?))));
    let budget = budgets.max_by(|a, b| a.2.total_cmp(&b.2));
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
    .with(budget.map(|(number, b, _)| error_budget(number, result.moves.len() == 1, &b).wide(5)))
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
    let conclusion = (!parts.is_empty()).then(|| parts.join(", ") + " (95 %)");
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
    Document {
        certificate: certificate(&result.computation, recording),
        verdict: Some(Verdict {
            grade,
            word: name(&result.verdict.judgement),
            headline: (!parts.is_empty()).then(|| [capital(&parts.join(", ")), "95 %".to_owned()]),
            proof: proof
                .into_iter()
                .chain(result.verdict.reasons.iter().cloned())
                .collect(),
            numbers: Vec::new(),
            conclusion,
            reasons: result.verdict.reasons.clone(),
            next: Vec::new(),
        }),
        ..Document::new(format!(
            "Orientation of {}",
            short_name(&result.computation.input)
        ))
    }
    .with(Section::new("Angles").figures(figures, &["angles"]).wide(7))
    .with(table)
    .with(timing(&result.computation, recording))
    .with_findings(&result.findings, false)
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    let first = chars.next().map(char::to_uppercase);
    first.into_iter().flatten().chain(chars).collect()
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
        headline: headline(result),
        proof: share.into_iter().chain(v.reasons.iter().cloned()).collect(),
        numbers: parts.map_or(Vec::new(), Vec::from),
        conclusion: conclusion.map(|text| text + doubt),
        reasons: v.reasons.clone(),
        next: next(result).into_iter().collect(),
    }
}

/// What would make the end better known.
fn next(result: &MotionResult) -> Option<String> {
    let parts = result.moves.iter().filter_map(|m| m.budget_m);
    let worst = parts.max_by(|a, b| norm(&a.calibration).total_cmp(&norm(&b.calibration)))?;
    let [noise, calibration, attitude] =
        [worst.noise, worst.calibration, worst.attitude].map(|v| norm(&v));
    let most = noise.max(calibration).max(attitude);
    let text = match () {
        () if most == calibration && result.computation.calibration.is_none() => {
            "Calibrate the sensor, of which most of the error is: `gravical calibrate SESSION -o cal.json`"
        }
        () if most == calibration => {
            "Most of the error is the calibration: more poses lower it: `gravical calibrate SESSION -o cal.json`"
        }
        () if most == noise => {
            "Most of the error is noise, which grows with the length of a move: rest more often"
        }
        () => {
            "Most of the error is the attitude in the move: record a gyroscope, calibrated, and rest more often"
        }
    };
    Some(text.to_owned())
}

/// The one number: how far it moved, or how well its end is known.
fn headline(result: &MotionResult) -> Option<[String; 2]> {
    let v = &result.verdict;
    let (size, within) = (v.size_m, v.expanded_m);
    let text = match (v.judgement, &result.moves[..]) {
        (MotionJudgement::AtRest, []) => "At rest".to_owned(),
        (MotionJudgement::AtRest, _) => {
            format!("Moved by less than {} m", digits(within?.max(size?), 2))
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

fn error_budget<'a>(number: usize, only: bool, b: &Budget) -> Section<'a> {
    let section = Section::new("Error budget");
    let noise = "noise, levelling, clock";
    let attitude = "attitude in the move";
    let parts = [
        (norm(&b.noise), noise),
        (norm(&b.calibration), "calibration, gravity"),
        (norm(&b.attitude), attitude),
    ];
    let total = norm(&parts.map(|(value, _)| value));
    if total == 0.0 || !total.is_finite() {
        return section;
    }
    let of = if only {
        "The displacement".to_owned()
    } else {
        format!("Move {number}, the least certain one")
    };
    let n = decimals_of(1e3 * total, 2).min(3);
    let mm = |value: f64| Cell::number(fixed(COVERAGE * 1e3 * value, n));
    let caption = format!("{of}, all axes together");
    let columns = ["source", "± 95 %, mm", "share of the variance, %"];
    let mut table = Table::new(caption, columns);
    for (value, what) in parts {
        let share = 100.0 * value * value / (total * total);
        table = table.row(what, [mm(value), Cell::Share(share)]);
    }
    let together = [mm(total), Cell::text("")];
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
