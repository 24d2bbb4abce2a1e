//! Report of a comparison of two calibrations.

use gravical::compare::{Comparison, Judgement};
use gravical::numfmt::{decimals_for, fixed, milli_g, signed, unit};
use gravical::poses::face::in_words;

use super::check::judged;
use super::short_name;
use crate::document::{Block, Cell, Document, Section, Table};

/// The document of a comparison.
pub fn comparison(c: &Comparison) -> Document<'static> {
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
        verdict: Some(judged(&c.verdict, next(c))),
        ..Document::new(format!("{b} against {a}"))
    }
    .with(magnitude(c))
    .with(parameters(c))
    .with(frame)
    .with(
        Section::new("Calibrations")
            .fact("A", of(0))
            .fact("B", of(1)),
    )
    .with_findings(&c.findings, true)
}

/// What to do about it.
fn next(c: &Comparison) -> Option<&'static str> {
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

fn parameters(c: &Comparison) -> Section<'static> {
    let mut table = Table::new("").columns(["", "A", "B", "B − A", "z"]);
    for p in &c.parameters {
        // Three digits of what is judged, whether σ is known or not.
        let coarse = if p.unit == "m/s^2" { 1e-3 } else { 1e-2 };
        let n = decimals_for(p.sigma.filter(|s| *s > 0.0).unwrap_or(coarse));
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

fn magnitude(c: &Comparison) -> Section<'static> {
    let m = &c.magnitude;
    let cells = |value: f64, predicted: Option<f64>| {
        let mg = |v: f64| fixed(milli_g(v), 2);
        [Cell::number(mg(value)), Cell::maybe(predicted, mg)]
    };
    let largest = format!("largest: {}", in_words(m.largest_at));
    let rms = cells(m.norm_rms_mps2, m.predicted_rms_mps2);
    let table = Table::new("")
        .columns(["", "B − A, mg", "predicted, mg"])
        .row("RMS over all directions", rms)
        .row(largest, cells(m.norm_largest_mps2, None));
    Section::new("Magnitude at rest").with(table)
}
