//! The page of a calibration.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use maud::{Markup, html};

use super::super::calibration::head;
use super::super::text::short_name;
use super::cells::{digits, heads, maybe, more, number, table};
use super::findings::{findings, inputs};
use super::gallery::Gallery;
use super::page::{Section, badge, list, page, tile};
use super::{ROWS, gyroscope, parameters, placements, temperature};
use crate::calibration_file::{CalibrationFile, Grade, InputFile};
use crate::figure::Figure;
use crate::recording::Finding;

/// The report of a calibration, with its figures
/// ([`figure::calibration::figures`](crate::figure::calibration::figures)).
#[must_use]
pub fn calibration_html(file: &CalibrationFile, figures: &[Figure]) -> String {
    let mut gallery = Gallery::new(figures);
    let mut sections = vec![
        Section::new("verdict", "Verdict", verdict(file)),
        Section::new(
            "parameters",
            "Parameters",
            parameters::accelerometer(file, &mut gallery),
        ),
    ];
    if let Some(gyro) = &file.gyroscope {
        sections.push(Section::new(
            "gyroscope",
            "Gyroscope",
            gyroscope::gyroscope(gyro),
        ));
    }
    if gallery.has(&["norm"]) {
        sections.push(Section::new(
            "magnitude",
            "Magnitude at rest",
            gallery.show(&["norm"]),
        ));
    }
    if !file.accelerometer.positions.is_empty() {
        let table = placements::placements(file, &mut gallery);
        sections.push(Section::new("placements", "Placements", table));
        let poses = placements::poses(file, &mut gallery);
        sections.push(Section::new("directions", "Directions and tilts", poses));
    }
    for (id, title, name) in [
        ("captures", "Captures", "captures"),
        ("noise", "Noise", "noise"),
    ] {
        if gallery.has(&[name]) {
            sections.push(Section::new(id, title, gallery.show(&[name])));
        }
    }
    let warmth = temperature::temperature(file, &mut gallery);
    sections.push(Section::new("temperature", "Temperature and time", warmth));
    sections.push(Section::new(
        "method",
        "Method and uncertainty",
        method(file, &mut gallery),
    ));
    if let Some(rest) = gallery.rest() {
        sections.push(Section::new("more", "More figures", rest));
    }
    sections.push(Section::new(
        "findings",
        "Findings",
        findings(&file.findings),
    ));
    sections.push(Section::new("provenance", "Provenance", provenance(file)));
    let title = format!("Calibration{}", named(file));
    page(&title, &lead(file, &title), &sections)
}

/// " of board 3 (MPU6050)", else of the file that it is from.
fn named(file: &CalibrationFile) -> String {
    let recordings: Vec<&InputFile> = file.recordings().collect();
    match (&file.sensor.id, &file.sensor.model, &recordings[..]) {
        (Some(id), Some(model), _) => format!(" of {id} ({model})"),
        (Some(one), None, _) | (None, Some(one), _) => format!(" of {one}"),
        (None, None, [one]) => format!(" of {}", short_name(&one.path)),
        (None, None, _) => String::new(),
    }
}

fn lead(file: &CalibrationFile, title: &str) -> Markup {
    html! {
        h1 { (title) }
        p.sub {
            time datetime=(file.created) { (file.created) } " · " (file.tool)
        }
        @for line in head(file).lines().filter(|_| file.accelerometer.method != "thermal") {
            p.sub { (line) }
        }
    }
}

fn verdict(file: &CalibrationFile) -> Markup {
    let a = &file.accelerometer;
    let (class, sign) = match file.verdict.grade {
        Grade::Good => ("good", "✓"),
        Grade::Fair => ("fair", "~"),
        Grade::Poor => ("poor", "✗"),
        Grade::NotVerifiable => ("unknown", "?"),
    };
    let worst = a
        .positions
        .iter()
        .enumerate()
        .filter_map(|(i, p)| Some((i, p.magnitude_error_mps2?)))
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    html! {
        (badge(class, sign, file.verdict.grade.name()))
        @if !file.verdict.reasons.is_empty() {
            ul { @for reason in &file.verdict.reasons { li { (reason) } } }
        }
        div.tiles {
            @if let Some(v) = a.predicted_norm_error_mps2 {
                (tile(&number("/accelerometer/predicted_norm_error_mps2", v, &mg(v)), "mg",
                    "standard uncertainty of the magnitude at rest, over all directions (1σ)"))
            }
            @if let Some(v) = a.leave_one_out_rms_mps2 {
                (tile(&number("/accelerometer/leave_one_out_rms_mps2", v, &mg(v)), "mg",
                    "error of the magnitude on placements that were left out of the fit (RMS)"))
            }
            @if let Some((i, v)) = worst {
                (tile(&number(&format!("/accelerometer/positions/{i}/magnitude_error_mps2"), v, &mg(v)), "mg",
                    "largest error of the magnitude at a placement"))
            } @else if let Some(e) = a.errors {
                (tile(&number("/accelerometer/errors/rms", e.rms, &digits(e.rms, 2)), "m/s²",
                    "RMS error over the fitted faces"))
            }
        }
    }
}

/// m/s² as mg with two digits: 1 mg is a thousandth of 9.80665 m/s².
pub(super) fn mg(mps2: f64) -> String {
    let mg = 1000.0 * mps2 / STANDARD_GRAVITY_MPS2;
    if mg != 0.0 && mg.abs() < 0.001 {
        return "±< 0.001".to_owned();
    }
    digits(mg, 2)
}

fn method(file: &CalibrationFile, gallery: &mut Gallery<'_>) -> Markup {
    let a = &file.accelerometer;
    html! {
        p { (how(&a.method)) }
        ul {
            @for line in assumptions(file) { li { (line) } }
        }
        (rejected(file))
        (gallery.show(&["budget"]))
        (budget(file))
    }
}

/// A method in words.
fn how(method: &str) -> &'static str {
    match method {
        "joint" => {
            "All placements in one fit: on faces the direction of gravity is known up to a tilt, which is fitted along; at free poses only its length counts. Bias, scale and the angles between the axes come with their covariance."
        }
        "ferraris" => {
            "Six faces in closed form (Ferraris, Grimaldi and Parvis 1995): the faces are taken as exact, so a crooked placement goes into the parameters."
        }
        "magnitude-9" | "magnitude9" => {
            "Nine parameters from the length of gravity alone, any poses: the frame is the sensor's own, not that of its case."
        }
        "magnitude-6" | "magnitude6" => {
            "Scale and bias from the length of gravity alone; the axes are taken as perpendicular."
        }
        "linear-12" | "linear12" => {
            "Least squares of twelve parameters with the faces taken as exact: for precise fixtures."
        }
        "thermal" => {
            "A recording at rest that cools and warms: what temperature does to each channel. Scale and axes are nominal."
        }
        _ => "The parameters come from elsewhere; how they were estimated is not known here.",
    }
}

fn assumptions(file: &CalibrationFile) -> Vec<String> {
    let a = &file.accelerometer;
    let mut lines = vec![format!(
        "Local gravity is {} m/s²; an error of it goes into the scale in full.",
        file.gravity_mps2
    )];
    if let Some(tilt) = a.placement_tilt_deg {
        lines.push(format!(
            "A face may be off level by {} (standard deviation of each of two directions).",
            super::cells::fixed(tilt.value, 1) + "°"
        ));
    }
    if let Some(fit) = a.fit {
        lines.push(if fit.prior {
            "What a data sheet says of scale, cross-axis terms and bias took part, with little weight.".to_owned()
        } else {
            "No data sheet took part.".to_owned()
        });
        if let Some(chi2) = fit.chi2_per_freedom {
            lines.push(format!(
                "χ² over its {} degrees of freedom: {}.",
                digits(fit.freedom, 3),
                digits(chi2, 2)
            ));
        }
        if fit.model_error_mps2 > 0.0 {
            lines.push(format!(
                "The sensor misses the linear model by {} mm/s², which is part of the uncertainty.",
                digits(1e3 * fit.model_error_mps2, 2)
            ));
        }
        if !fit.oriented {
            lines.push("Too few faces tell how the frame lies in the case: the matrix is triangular by convention.".to_owned());
        }
    }
    lines.push(format!(
        "Degrees of freedom of the magnitudes: {}.",
        a.degrees_of_freedom
    ));
    lines
}

/// Placements that took no part, with what was found about them.
fn rejected(file: &CalibrationFile) -> Markup {
    let left: Vec<&str> = file
        .accelerometer
        .positions
        .iter()
        .filter(|p| !p.fitted)
        .map(|p| p.label.as_str())
        .collect();
    if left.is_empty() {
        return html! { p { "Every placement took part in the fit." } };
    }
    let reason = |label: &str| {
        // The label as a whole: "still 3" is not "still 30".
        let names_it = |f: &&Finding| {
            let mut found = f.message.match_indices(label);
            found.any(|(at, _)| {
                let edge = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
                let (before, after) = (&f.message[..at], &f.message[at + label.len()..]);
                edge(before.chars().next_back()) && edge(after.chars().next())
            })
        };
        let about = file.findings.iter().filter(names_it);
        about
            .map(|f| f.message.as_str())
            .next()
            .unwrap_or("its findings say why")
    };
    html! {
        h3 { "Placements that took no part" }
        ul { @for label in left.iter().take(ROWS) { li { strong { (label) } ": " (reason(label)) } } }
        (more(left.len(), ROWS))
    }
}

fn budget(file: &CalibrationFile) -> Markup {
    let Some(budget) = &file.accelerometer.budget else {
        return html! {};
    };
    let base = "/accelerometer/budget";
    let body = html! {
        @for (i, part) in budget.contributions.iter().enumerate() {
            tr {
                th scope="row" { (part.source.replace('-', " ")) }
                (maybe(&format!("{base}/contributions/{i}/norm_mps2"), part.norm_mps2, mg))
                td { (part.basis) }
            }
        }
        tr.sum {
            th scope="row" { "combined" }
            (super::cells::cell(&format!("{base}/combined_mps2"), budget.combined_mps2, &mg(budget.combined_mps2)))
            td { "root of the sum of the squares" }
        }
        tr.sum {
            th scope="row" { "expanded" }
            (super::cells::cell(&format!("{base}/expanded_mps2"), budget.expanded_mps2, &mg(budget.expanded_mps2)))
            td { "k = " (budget.coverage_factor) }
        }
    };
    table(
        "Uncertainty of the magnitude at rest, all directions, 1σ",
        &heads(&["source", "mg", "<from"]),
        &body,
    )
}

fn provenance(file: &CalibrationFile) -> Markup {
    let command = html! { @match &file.command { Some(c) => code { (c) }, None => "–" } };
    html! {
        (list(&[
            ("program", html! { (file.tool) }),
            ("command", command),
            ("computed", html! { time datetime=(file.created) { (file.created) } }),
            ("format", html! { code { (file.format) } }),
        ]))
        (inputs(&file.inputs))
    }
}
