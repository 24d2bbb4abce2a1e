//! Reports of a check of a calibration, and of a comparison of two.

use gravical::calibration_file::Grade;
use gravical::check::{CheckReport, Judgement, Side, StillCheck};
use gravical::compare::Comparison;
use gravical::numfmt::{
    COVERAGE, count, decimals_for, duration_text, fixed, mg, milli_g, signed, unit,
};
use gravical::poses::face::in_words;

use super::{gravity_source, short_name};
use crate::document::{Block, Cell, Document, Section, Step, Table, Verdict};
use crate::figure::Figure;
use crate::figure::check::still_name;

/// The document of a check.
pub fn check<'a>(report: &CheckReport, figures: &'a [Figure]) -> Document<'a> {
    let calibration = short_name(&report.calibration);
    let recordings = match &report.recordings[..] {
        [one] => short_name(one),
        several => format!("{} recordings", several.len()),
    };
    let stills = count(report.static_intervals.len(), "static interval");
    let of_calibration = if report.gravity_of_calibration {
        ", as in the calibration"
    } else {
        ""
    };
    let (g, source) = (report.gravity_mps2, gravity_source(report.gravity_source));
    Document {
        subject: vec![
            format!("{calibration} checked with {recordings}: {stills}"),
            format!("g = {} m/s² ({source}{of_calibration})", fixed(g, 5)),
        ],
        certificate: vec![
            entry("Calibration", calibration.clone(), ""),
            entry("Calibrated", dated(&report.sides[0]), ""),
            entry("Checked", dated(&report.sides[1]), &age(report.age_days)),
            entry("Recording", recordings.clone(), &stills),
            entry("Gravity", format!("{} m/s²", fixed(g, 5)), source),
        ],
        verdict: Some(Verdict {
            headline: headline(report),
            numbers: vec![
                [mg(report.rms_mps2) + " mg", "found, rms".to_owned()],
                [
                    mg(report.predicted_rms_mps2) + " mg",
                    "predicted, rms".to_owned(),
                ],
            ],
            ..judged(&report.verdict, next(report))
        }),
        ..Document::new(format!("Check of {calibration}"))
    }
    .with(Section::new("Errors").figures(figures, &["errors"]).wide(7))
    .with(
        Section::new("Temperature")
            .figures(figures, &["temperature"])
            .wide(12),
    )
    .with(intervals(report).wide(12))
    .with(sides(
        "Dates and sensors",
        ["calibration", "recordings"],
        [String::new(), String::new()],
        (&report.sides, report.age_days),
    ))
    .with_findings(&report.findings, report.recordings.len() > 1)
}

fn entry(name: &str, value: String, remark: &str) -> [String; 3] {
    [name.to_owned(), value, remark.to_owned()]
}

/// When it was recorded, else computed.
fn dated(side: &Side) -> String {
    let recorded = side.recorded.map(|time| time.minute());
    let day = |time: &String| format!("computed {}", time.chars().take(10).collect::<String>());
    let computed = || side.created.as_ref().map(day);
    recorded
        .or_else(computed)
        .unwrap_or_else(|| "date unknown".to_owned())
}

/// The largest error that counts.
fn headline(report: &CheckReport) -> [String; 2] {
    let counted = report.static_intervals.iter().filter(|s| s.counts);
    let worst = counted.max_by(|a, b| a.error_mps2.abs().total_cmp(&b.error_mps2.abs()));
    let at = worst.map_or(String::new(), |still| format!("{} up", still.nearest));
    let error = worst.map_or(0.0, |still| still.error_mps2.abs());
    [format!("Off by at most {} mg", mg(error)), at]
}

/// The verdict of `check` or `compare`, with the next step.
fn judged(verdict: &gravical::check::Verdict, next: Option<&str>) -> Verdict {
    let grade = match verdict.judgement {
        Judgement::Agrees => Grade::Good,
        Judgement::DoesNotFit | Judgement::Differs => Grade::Poor,
        Judgement::Undecided => Grade::NotVerifiable,
    };
    Verdict {
        grade,
        word: verdict.judgement.name(),
        headline: Default::default(),
        proof: Vec::new(),
        numbers: Vec::new(),
        reasons: verdict.reasons.clone(),
        next: next.map(Step::by_hand).into_iter().collect(),
    }
}

/// What to do about it.
fn next(report: &CheckReport) -> Option<&'static str> {
    match report.verdict.judgement {
        Judgement::Undecided if report.only_fitted => {
            Some("Record the sensor at rest again, and check with that recording")
        }
        Judgement::Undecided => Some(
            "Calibrate from recordings, not from means, so that the calibration has a covariance",
        ),
        judgement if judgement.is_change() && report.gravity_of_calibration => Some(
            "Give the gravity of this place if it is another; if it does not fit then, either, calibrate again",
        ),
        judgement if judgement.is_change() => Some("Calibrate again"),
        _ if !report.untested_axes.is_empty() => {
            Some("To test the other axes, too, record the sensor with each of them up")
        }
        _ => None,
    }
}

fn intervals<'a>(report: &CheckReport) -> Section<'a> {
    let columns = "interval|rows|nearest face|angle to face, °|error of ‖a‖ ± 95 %, mg|z|";
    let mut table = Table::new("", columns.split('|'));
    // The largest error first: a long table is cut.
    let mut stills: Vec<(usize, &StillCheck)> =
        report.static_intervals.iter().enumerate().collect();
    stills.sort_by_key(|(i, _)| *i != report.worst);
    for (i, still) in &stills {
        let name = still_name(report, still);
        let mark = match still {
            _ if *i == report.worst && stills.len() > 1 => "← largest",
            still if still.counts => "",
            still if still.clipped > 0 => "clipped",
            _ => "not counted",
        };
        let error = Cell::number(signed(milli_g(still.error_mps2), 2));
        let cells = [
            Cell::number(still.rows.to_string()),
            Cell::text(&still.nearest),
            Cell::number(fixed(still.face_angle_deg, 1)),
            error.plus_minus(Some(milli_g(still.sigma_mps2)), 2),
            Cell::number(signed(still.z, 1)),
            Cell::text(mark),
        ];
        table = table.row(name, cells);
    }
    Section::new("Static intervals").with(table)
}

/// Dates and sensors of what is held against each other, after what is already said of each.
fn sides<'a>(
    heading: &'static str,
    names: [&'static str; 2],
    said: [String; 2],
    (sides, age_days): (&[Side; 2], Option<f64>),
) -> Section<'a> {
    let mut section = Section::new(heading);
    for ((name, said), side) in names.into_iter().zip(said).zip(sides) {
        let sensor = &side.sensor;
        let facts = [
            Some(said).filter(|said| !said.is_empty()),
            Some(side.recorded.map_or_else(
                || "no date of recording".to_owned(),
                |time| format!("recorded {}", time.minute()),
            )),
            side.created.as_ref().map(|time| format!("created {time}")),
            sensor.model.clone(),
            sensor.id.as_ref().map(|id| format!("sensor \"{id}\"")),
            (sensor.id.is_none() && sensor.model.is_none()).then(|| "sensor not named".to_owned()),
        ];
        let facts: Vec<String> = facts.into_iter().flatten().collect();
        section = section.fact(name, facts.join(", "));
    }
    section
        .fact("between them", age(age_days))
        .folded("dates, sensors, age")
}

fn age(days: Option<f64>) -> String {
    days.map_or_else(
        || "age not known".to_owned(),
        |days| match duration_text(86_400.0 * days.abs()) {
            age if days < 0.0 => format!("{age}, the first is the later one"),
            _ if days == 0.0 => "no time between them".to_owned(),
            age => format!("{age} later"),
        },
    )
}

/// The document of a comparison.
pub fn comparison<'a>(c: &Comparison, figures: &'a [Figure]) -> Document<'a> {
    let of = |i: usize| {
        let temperature = c.temperature_c[i].as_ref();
        let temperature = temperature.map_or(String::new(), |t| format!(", {:.1} °C", t.mean));
        let (file, g) = (&c.files[i], c.gravity_mps2[i]);
        format!("{file}: g = {g:.5} m/s²{temperature}")
    };
    let [a, b] = c.files.each_ref().map(|file| short_name(file));
    let frame = c.orientation.as_ref().map(|o| {
        let axis = o.axis.map(|v| signed(v, 2)).join(", ");
        let text = format!("{}° about ({axis})", fixed(o.angle_deg, 3));
        Section::new("Rotation of frame B relative to frame A").with(Block::Paragraph(text))
    });
    Document {
        subject: vec![format!("{b} (B) against {a} (A)")],
        certificate: vec![
            entry("A", a.clone(), &dated(&c.sides[0])),
            entry("B", b.clone(), &dated(&c.sides[1])),
            entry("Between them", age(c.age_days), ""),
        ],
        verdict: Some(Verdict {
            headline: compared(c),
            ..judged(&c.verdict, next_of_comparison(c))
        }),
        ..Document::new(format!("{b} against {a}"))
    }
    .with(
        Section::new("Each parameter")
            .figures(figures, &["parameters"])
            .wide(7),
    )
    .with(parameters(c).wide(12))
    .with(magnitude(c).wide(12))
    .with(frame)
    .with(sides(
        "Calibrations",
        ["A", "B"],
        [of(0), of(1)],
        (&c.sides, c.age_days),
    ))
    .with_findings(&c.findings, true)
}

/// The one number: by how much ‖a‖ differs.
fn compared(c: &Comparison) -> [String; 2] {
    let m = &c.magnitude;
    let expected = m
        .predicted_rms_mps2
        .map(|rms| format!("{} mg expected", mg(rms)));
    let text = format!("‖a‖ differs by {} mg rms", mg(m.norm_rms_mps2));
    [text, expected.unwrap_or_default()]
}

/// What to do about it.
fn next_of_comparison(c: &Comparison) -> Option<&'static str> {
    if c.two_sensors.is_some() {
        Some("Use each calibration for its own sensor")
    } else if c.orientation.is_none() {
        Some(
            "Find the session in which two poses were swapped or an axis had the wrong sign, and calibrate again",
        )
    } else if c.magnitude.judgement.is_change() {
        Some(
            "Record the sensor at rest in several poses: `gravical check` tells which of the two fits",
        )
    } else if c.verdict.judgement.is_change() {
        Some("Use the calibration whose session had the board in its case as it is now")
    } else if c.verdict.judgement == Judgement::Undecided {
        Some("Compare calibrations of two sessions, each with a covariance")
    } else {
        None
    }
}

fn parameters<'a>(c: &Comparison) -> Section<'a> {
    let mut table = Table::new("", ["", "A", "B", "B − A, ± 95 %", "z"]);
    for p in &c.parameters {
        // Three digits of what is judged, whether σ is known or not.
        let coarse = if p.unit == "m/s^2" { 1e-3 } else { 1e-2 };
        let within = p.sigma.filter(|s| *s > 0.0).map(|s| COVERAGE * s);
        let n = decimals_for(within.unwrap_or(coarse));
        let cells = [
            Cell::maybe(p.a, |v| fixed(v, n)),
            Cell::maybe(p.b, |v| fixed(v, n)),
            Cell::number(signed(p.difference, n)).plus_minus(p.sigma, n),
            Cell::maybe(p.z, |z| signed(z, 1)),
        ];
        let name = format!("{}, {}", p.name.replace('_', " "), unit(p.unit));
        table = table.row(name, cells);
    }
    Section::new("Parameters").with(table)
}

fn magnitude<'a>(c: &Comparison) -> Section<'a> {
    let m = &c.magnitude;
    let cells = |value: f64, predicted: Option<f64>| {
        let mg = |v: f64| fixed(milli_g(v), 2);
        [Cell::number(mg(value)), Cell::maybe(predicted, mg)]
    };
    let largest = format!("largest: {}", in_words(m.largest_at));
    let rms = cells(m.norm_rms_mps2, m.predicted_rms_mps2);
    let table = Table::new("", ["", "B − A, mg", "predicted, mg"])
        .row("RMS over all directions", rms)
        .row(largest, cells(m.norm_largest_mps2, None));
    Section::new("Magnitude at rest").with(table)
}
