//! Report of the noise of a sensor.

use std::collections::BTreeMap;

use crate::document::{Block, Cell, Document, Row, Section, Table};
use crate::figure::Figure;
use gravical::noise::{ChannelNoise, NoiseResult, Term, Unit, duration_text};
use gravical::numfmt::{count, decimals_for, fixed, small};

use super::short_name;

/// The document of an Allan deviation; `figures` are those of [`crate::figure::noise`].
pub fn noise<'a>(result: &NoiseResult, figures: &'a [Figure]) -> Document<'a> {
    let name = short_name(result.inputs.first().map_or("", |input| &input.path));
    let spans = count(result.static_intervals, "static interval");
    let segments = match result.segments {
        1 => String::new(),
        n => format!(", {n} segments between gaps"),
    };
    let at_rest = format!(
        "{} of {}, {spans}{segments}, {} Hz",
        duration_text(result.used_s),
        duration_text(result.recorded_s),
        fixed(result.rate_hz, 2)
    );
    let temperature = result.temperature_c;
    let reading = Section::new("reading", "How it was read").with(Block::facts([
        ("read as", Some(result.description.clone())),
        ("at rest", Some(at_rest)),
        (
            "temperature",
            temperature.map(|[low, high]| format!("{low:.1} to {high:.1} °C")),
        ),
    ]));
    let mut section = Section::new("noise", "Noise");
    let (gyroscope, accelerometer): (Vec<_>, Vec<_>) =
        result.channels.iter().partition(|c| c.is_gyroscope());
    for channels in [accelerometer, gyroscope] {
        if !channels.is_empty() {
            section = section.with(parameters(&channels));
            let reasons = not_observable(&channels).into_iter().map(Block::Note);
            section = reasons.fold(section, Section::with);
        }
    }
    let section = section.with(Block::note(
        "N: noise density, B: bias instability, K: random walk; ± 1σ, < upper limit (95 %).",
    ));
    let curves = Section::new("allan", "Allan deviation")
        .figures(figures)
        .full(Block::Equation(vec![
            "σ²(τ) = N²/τ + (2 ln 2/π) B² + K²τ/3",
        ]))
        .full(Block::paragraph(METHOD));
    Document {
        subject: vec![name.clone()],
        ..Document::new(format!("Noise of {name}"))
    }
    .with(reading)
    .with(section)
    .with(curves)
    .with_findings(&result.findings, false)
}

/// The parameters of a sensor, a column for each axis.
fn parameters(channels: &[&ChannelNoise]) -> Table {
    let gyroscope = channels.iter().any(|c| c.is_gyroscope());
    let row = |label: String, cell: &dyn Fn(&ChannelNoise) -> Cell| {
        Row::named(label, channels.iter().map(|c| cell(c)))
    };
    let terms = Term::ALL.map(|term| {
        let Unit { name, factor, .. } = Unit::of(term, gyroscope);
        row(format!("{}, {name}", term.symbol()), &|c| {
            value(c, term, factor)
        })
    });
    // In SI units, which code needs.
    let in_si = row(format!("N, {}", Unit::of(Term::N, gyroscope).si), &|c| {
        Cell::maybe(c.n.as_ref().map(|n| n.value), |n| format!("{n:.2e}"))
    });
    let sensor = if gyroscope {
        "gyroscope"
    } else {
        "accelerometer"
    };
    Table::new(sensor)
        .columns([""])
        .columns(channels.iter().map(|c| c.channel.as_str()))
        .rows(terms.into_iter().chain([in_si]))
}

fn value(channel: &ChannelNoise, term: Term, factor: f64) -> Cell {
    if let Some(e) = channel.estimate(term) {
        let deviation = factor * (e.high - e.low) / 3.92;
        let decimals = decimals_for(deviation);
        let text = fixed(factor * e.value, decimals);
        return Cell::number(text).plus_minus(Some(deviation), decimals);
    }
    let most = channel.missing(term).and_then(|missing| missing.at_most);
    Cell::maybe(most, |most| format!("< {}", small(factor * most, 2)))
}

/// Why terms are missing; axes with one reason together.
fn not_observable(channels: &[&ChannelNoise]) -> Vec<String> {
    let mut reasons: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for channel in channels {
        for missing in &channel.not_observable {
            let reason = format!("{}: {}", missing.term, missing.reason);
            reasons.entry(reason).or_default().push(&channel.channel);
        }
    }
    let line = |(text, channels): (String, Vec<&str>)| format!("{}: {text}", channels.join(", "));
    reasons.into_iter().map(line).collect()
}

const METHOD: &str = "Overlapping Allan deviation over every sample. Least squares on the variance, no term negative, weighted by the variances of overlapping estimates, with intervals from their covariance. Data sheets state one-sided densities, larger than N by √2. A term is not observable with fewer than four degrees of freedom, a standard deviation of over 35 %; its limit holds with 95 %.";
