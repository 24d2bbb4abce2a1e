//! Report of the noise of a sensor.

use gravical::noise::{ChannelNoise, NoiseResult, Term, printed_unit};
use gravical::numfmt::{COVERAGE, count, decimals_for, digits, duration_text, fixed, small, unit};

use super::short_name;
use crate::document::{Block, Cell, Document, HOW, Section, Table, Verdict};
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
        .fact("temperature", temperature.clone());
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
    let note = "N: noise density, B: bias instability, K: random walk; ± and < are 95 %.";
    let section = section.with(Block::Note(note.to_owned()));
    let method = Section::new(HOW)
        .full(Block::Equation("σ²(τ) = N²/τ + (2 ln 2/π) B² + K²τ/3"))
        .full(Block::Paragraph(METHOD.to_owned()))
        .folded("the fit, and what is not visible");
    let entry =
        |name: &str, value: String, remark: &str| [name.to_owned(), value, remark.to_owned()];
    let degrees = temperature.unwrap_or_else(|| "not recorded".to_owned());
    let of = |sensor: &str| {
        let channels = result.channels.iter();
        let channels = channels.filter(move |c| c.is_gyroscope() == (sensor == "gyroscope"));
        let found = channels.filter_map(|c| Some((c.n.as_ref()?.value, c.is_gyroscope())));
        let (worst, gyroscope) = found.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let (name, factor) = printed_unit(Term::N, gyroscope);
        Some(format!("{} {name}", digits(factor * worst, 3)))
    };
    let both: Vec<String> = ["accelerometer", "gyroscope"]
        .into_iter()
        .filter_map(of)
        .collect();
    let headline = match &both[..] {
        [] => "The noise density is not visible".to_owned(),
        both => both.join(" and "),
    };
    let missing = result
        .channels
        .iter()
        .flat_map(|c| &c.not_observable)
        .count();
    let proof = match missing {
        0 => "White noise, bias instability and random walk are all visible.".to_owned(),
        n => format!(
            "{} not visible in this recording; the table has their upper limits.",
            match n {
                1 => "One term is".to_owned(),
                n => format!("{n} terms are"),
            }
        ),
    };
    Document {
        subject: vec![name.clone()],
        certificate: vec![
            entry("Recording", name.clone(), ""),
            entry("At rest", used.clone(), &format!("of {recorded}")),
            entry("Rate", format!("{rate} Hz"), ""),
            entry("Temperature", degrees, ""),
        ],
        verdict: Some(Verdict::without_word(
            [headline, "noise density N, noisiest axis".to_owned()],
            proof,
        )),
        ..Document::new(format!("Noise of {name}"))
    }
    .with(
        Section::new("Allan deviation")
            .figures(figures, &["allan-accelerometer"])
            .wide(12),
    )
    .with(
        Section::new("Gyroscope")
            .figures(figures, &["allan-gyroscope"])
            .wide(12),
    )
    .with(section.wide(12))
    .with(reading.folded("what was read"))
    .with(method)
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
        // Half of the interval is two deviations.
        let deviation = factor * (e.high - e.low) / 4.0;
        let decimals = decimals_for(COVERAGE * deviation);
        let text = fixed(factor * e.value, decimals);
        return Cell::number(text).plus_minus(Some(deviation), decimals);
    }
    let most = channel
        .missing(term)
        .and_then(|missing| missing.limit.at_most);
    Cell::maybe(most, |most| format!("< {}", small(factor * most, 2)))
}

const METHOD: &str = "Overlapping Allan deviation over every sample. Least squares on the variance, no term negative, weighted by the variances of overlapping estimates, with intervals from their covariance. Data sheets state one-sided densities, larger than N by √2. A term is not observable with fewer than four degrees of freedom, a standard deviation of over 35 %; its limit holds with 95 %.";
