//! Report of a comparison of two calibrations.

use crate::document::{Block, Cell, Document, Row, Section, Table, Verdict};
use gravical::compare::{Comparison, Judgement, ParameterDifference};
use gravical::numfmt::{decimals_for, fixed, milli_g, signed, unit};
use gravical::poses::face::in_words;

use super::check::judged;
use super::short_name;

/// The document of a comparison.
pub fn comparison(c: &Comparison) -> Document<'static> {
    let of = |i: usize| {
        let temperature =
            c.temperature_c[i].map_or(String::new(), |t| format!(", {:.1} °C", t.mean));
        format!(
            "{}: g = {:.5} m/s²{temperature}",
            c.files[i], c.gravity_mps2[i]
        )
    };
    let facts = Block::facts([("A", Some(of(0))), ("B", Some(of(1)))]);
    let [a, b] = c.files.each_ref().map(|file| short_name(file));
    let frame = c.orientation.as_ref().map(|o| {
        let axis = o.axis.map(|v| signed(v, 2)).join(", ");
        let text = format!("{}° about ({axis})", fixed(o.angle_deg, 3));
        Section::new("frame", "Rotation of frame B relative to frame A")
            .with(Block::Paragraph(text))
    });
    Document {
        subject: vec![format!("{b} (B) against {a} (A)")],
        verdict: Some(Verdict {
            next: next(c),
            ..judged(&c.verdict)
        }),
        ..Document::new(format!("{b} against {a}"))
    }
    .with(magnitude(c))
    .with(parameters(&c.parameters))
    .with(frame)
    .with(Section::new("calibrations", "Calibrations").with(facts))
    .with_findings(&c.findings, true)
}

/// What to do about it.
fn next(c: &Comparison) -> Vec<String> {
    let step = if c.two_sensors.is_some() {
        "Use each calibration for its own sensor"
    } else if c.orientation.is_none() {
        "Find the session in which two poses were swapped or an axis had the wrong sign, and calibrate again"
    } else if c.magnitude.judgement.is_change() {
        "Record the sensor at rest in several poses: `gravical check` tells which of the two fits"
    } else if c.verdict.judgement.is_change() {
        "Use the calibration whose session had the board in its case as it is now"
    } else if c.verdict.judgement == Judgement::Undecided {
        "Compare calibrations of two sessions, each with a covariance"
    } else {
        return Vec::new();
    };
    vec![step.to_owned()]
}

fn parameters(list: &[ParameterDifference]) -> Section<'static> {
    let table = Table::new("")
        .columns(["", "A", "B", "B − A", "z"])
        .rows(list.iter().map(parameter));
    Section::new("parameters", "Parameters").with(table)
}

fn parameter(p: &ParameterDifference) -> Row {
    // Three digits of what is judged, whether σ is known or not.
    let coarse = if p.unit == "m/s^2" { 1e-3 } else { 1e-2 };
    let worth = p.sigma.filter(|s| *s > 0.0).unwrap_or(coarse);
    let n = decimals_for(worth);
    let cells = [
        Cell::text(format!("{}, {}", p.name.replace('_', " "), unit(p.unit))),
        Cell::maybe(p.a, |v| fixed(v, n)),
        Cell::maybe(p.b, |v| fixed(v, n)),
        Cell::number(signed(p.difference, n)).plus_minus(p.sigma, n),
        Cell::maybe(p.z, |z| signed(z, 1)),
    ];
    cells.into()
}

fn magnitude(c: &Comparison) -> Section<'static> {
    let m = &c.magnitude;
    let row = |name: &str, value: f64, predicted: Option<f64>| {
        let mg = |v: f64| fixed(milli_g(v), 2);
        Row::named(name, [Cell::number(mg(value)), Cell::maybe(predicted, mg)])
    };
    let rms = (m.norm_rms_mps2, m.predicted_rms_mps2);
    let largest = format!("largest: {}", in_words(m.largest_at));
    let table = Table::new("")
        .columns(["", "B − A, mg", "predicted, mg"])
        .row(row("RMS over all directions", rms.0, rms.1))
        .row(row(&largest, m.norm_largest_mps2, None));
    Section::new("magnitude", "Magnitude at rest").with(table)
}
