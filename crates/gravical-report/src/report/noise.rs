//! Report of the noise of a sensor.

use gravical::noise::{ChannelNoise, NoiseResult, Term, printed_unit};
use gravical::numfmt::{count, decimals_for, duration_text, fixed, small, unit};

use super::short_name;
use crate::document::{Block, Cell, Document, Section, Table};
use crate::figure::Figure;

/// The document of an Allan deviation; `figures` are those of [`crate::figure::noise`].
pub fn noise<'a>(result: &NoiseResult, figures: &'a [Figure]) -> Document<'a> {
    let name = short_name(result.inputs.first().map_or("", |input| &input.path));
    let segments = match result.segments {
        1 => String::new(),
        n => format!(", {n} segments between gaps"),
    };
    let [used, recorded] = [result.used_s, result.recorded_s].map(duration_text);
    let intervals = count(result.static_intervals, "static interval");
    let rate = fixed(result.rate_hz, 2);
    let at_rest = format!("{used} of {recorded}, {intervals}{segments}, {rate} Hz");
    let temperature = result.temperature_c;
    let temperature = temperature.map(|[low, high]| format!("{low:.1} to {high:.1} °C"));
    let reading = Section::new("How it was read")
        .fact("read as", result.description.clone())
        .fact("at rest", at_rest)
        .fact("temperature", temperature);
    let mut section = Section::new("Noise");
    for sensor in ["accelerometer", "gyroscope"] {
        let channels = result.channels.iter();
        let channels = channels.filter(|c| c.is_gyroscope() == (sensor == "gyroscope"));
        let channels: Vec<&ChannelNoise> = channels.collect();
        if !channels.is_empty() {
            let missing = channels.iter().flat_map(|c| {
                let missing = c.not_observable.iter();
                missing.map(move |m| (c.channel.clone(), format!("{}: {}", m.term, m.reason)))
            });
            section = section.with(parameters(sensor, &channels)).reasons(missing);
        }
    }
    let note = "N: noise density, B: bias instability, K: random walk; ± 1σ, < upper limit (95 %).";
    let section = section.with(Block::Note(note.to_owned()));
    let curves = Section::new("Allan deviation")
        .figures(figures, &["allan-accelerometer", "allan-gyroscope"])
        .full(Block::Equation("σ²(τ) = N²/τ + (2 ln 2/π) B² + K²τ/3"))
        .full(Block::Paragraph(METHOD.to_owned()));
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
fn parameters(sensor: &str, channels: &[&ChannelNoise]) -> Table {
    let gyroscope = sensor == "gyroscope";
    let mut table = Table::new(sensor, [""]).columns(channels.iter().map(|c| c.channel.as_str()));
    for term in Term::ALL {
        let (unit, factor) = printed_unit(term, gyroscope);
        let cells = channels.iter().map(|c| value(c, term, factor));
        table = table.row(format!("{}, {unit}", term.symbol()), cells);
    }
    // In SI units, which code needs.
    let n = channels.iter().map(|c| c.n.as_ref().map(|n| n.value));
    let n = n.map(|n| Cell::maybe(n, |n| format!("{n:.2e}")));
    let si = channels.first().map_or(String::new(), |c| unit(&c.unit));
    table.row(format!("N, {si}/√Hz"), n)
}

fn value(channel: &ChannelNoise, term: Term, factor: f64) -> Cell {
    if let Some(e) = channel.estimate(term) {
        let deviation = factor * (e.high - e.low) / 3.92;
        let decimals = decimals_for(deviation);
        let text = fixed(factor * e.value, decimals);
        return Cell::number(text).plus_minus(Some(deviation), decimals);
    }
    let most = channel
        .missing(term)
        .and_then(|missing| missing.limit.at_most);
    Cell::maybe(most, |most| format!("< {}", small(factor * most, 2)))
}

const METHOD: &str = "Overlapping Allan deviation over every sample. Least squares on the variance, no term negative, weighted by the variances of overlapping estimates, with intervals from their covariance. Data sheets state one-sided densities, larger than N by √2. A term is not observable with fewer than four degrees of freedom, a standard deviation of over 35 %; its limit holds with 95 %.";
