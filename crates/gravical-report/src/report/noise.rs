//! Report of the noise of a sensor.

use crate::document::{Block, Cell, Document, Row, Section, Table};
use crate::figure::Figure;
use gravical::noise::{ChannelNoise, Estimate, NoiseResult, Term, Unit, duration_text};
use gravical::numfmt::{count, decimals_for, fixed, small};

use super::short_name;

/// The document of an Allan deviation; `figures` are those of [`crate::figure::noise`].
pub fn noise<'a>(result: &NoiseResult, figures: &'a [Figure]) -> Document<'a> {
    let input = result.inputs.first().map_or("", |input| &input.path);
    let name = short_name(input);
    let document = Document {
        subject: vec![format!("{name}: {}", conclusion(result))],
        ..Document::new(format!("Noise of {name}"))
    };
    let spans = count(result.static_intervals, "static interval");
    let segments = match result.segments {
        1 => String::new(),
        n => format!(", {n} segments between gaps"),
    };
    let mut facts = vec![
        ("read as".to_owned(), result.description.clone()),
        (
            "at rest".to_owned(),
            format!(
                "{} of {}, {spans}{segments}, {} Hz",
                duration_text(result.used_s),
                duration_text(result.recorded_s),
                fixed(result.rate_hz, 2)
            ),
        ),
    ];
    if let Some([low, high]) = result.temperature_c {
        facts.push((
            "temperature".to_owned(),
            format!("{low:.1} to {high:.1} °C"),
        ));
    }
    let reading = Section::new("reading", "How it was read").opening();
    let mut section = Section::new("noise", "Noise");
    for (sensor, channels) in &sensors(result) {
        section = section
            .with(parameters(sensor, channels))
            .full(intervals(sensor, channels));
        let missing = missing(channels);
        if !missing.is_empty() {
            section = section.with(Block::List(missing));
        }
    }
    section = section.with(Block::note(
        "N: noise density, B: bias instability, K: random walk; ± 1σ, < upper limit (95 %). N by density: from the power spectral density at 1 to 10 Hz.",
    ));
    let curves = Section::new("allan", "Allan deviation")
        .figures(figures)
        .full(Block::Equation(vec![
            "σ²(τ) = N²/τ + (2 ln 2/π) B² + K²τ/3",
        ]))
        .full(Block::paragraph(METHOD));
    document
        .with(reading.with(Block::Facts(facts)))
        .with(section)
        .with(curves)
        .with_findings(&result.findings, false)
}

/// The sensors of which channels could be analysed.
fn sensors(result: &NoiseResult) -> Vec<(&'static str, Vec<&ChannelNoise>)> {
    let sensors = [("accelerometer", 'a'), ("gyroscope", 'g')].map(|(sensor, letter)| {
        let channels = result.channels.iter();
        let channels = channels.filter(|c| c.channel.starts_with(letter));
        (sensor, channels.collect::<Vec<_>>())
    });
    let known = |(_, channels): &(_, Vec<_>)| !channels.is_empty();
    sensors.into_iter().filter(known).collect()
}

/// One sentence.
fn conclusion(result: &NoiseResult) -> String {
    let sensors = sensors(result);
    let part = |(sensor, channels): &(&str, Vec<&ChannelNoise>)| {
        let terms = Term::ALL.map(|term| span(term, *sensor == "gyroscope", channels));
        format!("{sensor} {}", terms.join(", "))
    };
    if sensors.is_empty() {
        return "no channel could be analysed".to_owned();
    }
    sensors.iter().map(part).collect::<Vec<_>>().join("; ")
}

/// A term of all axes: `N 330 to 480 µg/√Hz`.
fn span(term: Term, gyroscope: bool, own: &[&ChannelNoise]) -> String {
    let Unit { name, factor, .. } = Unit::of(term, gyroscope);
    let known: Vec<f64> = own
        .iter()
        .filter_map(|c| Some(factor * c.estimate(term)?.value))
        .collect();
    let low = known.iter().copied().fold(f64::INFINITY, f64::min);
    let high = known.iter().copied().fold(0.0, f64::max);
    let of = match known.len() {
        0 => return format!("{} not observable", term.symbol()),
        n if n < own.len() => format!(" ({n} of {} axes)", own.len()),
        _ => String::new(),
    };
    let (from, to) = (small(low, 2), small(high, 2));
    let range = if from == to {
        from
    } else {
        format!("{from} to {to}")
    };
    format!("{} {range} {name}{of}", term.symbol())
}

fn table(caption: String, channels: &[&ChannelNoise]) -> Table {
    Table::new(caption)
        .columns([""])
        .columns(channels.iter().map(|c| c.channel.as_str()))
}

/// A cell for each channel.
fn row(label: String, channels: &[&ChannelNoise], cell: impl Fn(&ChannelNoise) -> Cell) -> Row {
    Row::named(label, channels.iter().map(|c| cell(c)))
}

fn parameters(sensor: &str, channels: &[&ChannelNoise]) -> Table {
    let gyroscope = sensor == "gyroscope";
    let terms = Term::ALL.map(|term| {
        let Unit { name, factor, .. } = Unit::of(term, gyroscope);
        let label = format!("{}, {name}", term.symbol());
        row(label, channels, |c| value(c, term, factor))
    });
    let Unit { name, factor, si } = Unit::of(Term::N, gyroscope);
    // In SI units, which code needs.
    let si = row(format!("N, {si}"), channels, |c| {
        Cell::maybe(c.n.map(|n| n.value), |n| format!("{n:.2e}"))
    });
    let density = row(format!("N by density, {name}"), channels, |c| {
        let known = c.density.filter(|_| c.n.is_some());
        Cell::maybe(known.map(|d| d.n), |n| small(factor * n, 3))
    });
    let sheet = row(format!("N by data sheet, {name}"), channels, |c| {
        Cell::maybe(c.data_sheet.as_ref().map(|s| s.n), |n| small(factor * n, 3))
    });
    let sheet = channels
        .iter()
        .any(|c| c.data_sheet.is_some())
        .then_some(sheet);
    let rows = terms.into_iter().chain([si, density]).chain(sheet);
    table(sensor.to_owned(), channels).rows(rows)
}

fn intervals(sensor: &str, channels: &[&ChannelNoise]) -> Table {
    let rows = Term::ALL.map(|term| {
        let Unit { name, factor, .. } = Unit::of(term, sensor == "gyroscope");
        let label = format!("{}, {name}", term.symbol());
        row(label, channels, |c| interval(c.estimate(term), factor))
    });
    table(format!("{sensor}: 95 % intervals"), channels).rows(rows)
}

fn value(channel: &ChannelNoise, term: Term, factor: f64) -> Cell {
    match (channel.estimate(term), channel.missing(term)) {
        (Some(e), _) => {
            let deviation = factor * (e.high - e.low) / 3.92;
            let decimals = decimals_for(deviation);
            let text = fixed(factor * e.value, decimals);
            Cell::number(text).plus_minus(Some(deviation), decimals)
        }
        (None, Some(missing)) => match missing.at_most {
            Some(most) => Cell::number(format!("< {}", small(factor * most, 2))),
            None => Cell::none(),
        },
        (None, None) => Cell::none(),
    }
}

fn interval(estimate: Option<&Estimate>, factor: f64) -> Cell {
    match estimate {
        Some(e) => {
            let decimals = decimals_for(factor * (e.high - e.low) / 3.92);
            let text = |v: f64| fixed(factor * v, decimals);
            Cell::number(format!("{} to {}", text(e.low), text(e.high)))
        }
        None => Cell::none(),
    }
}

/// Why terms are missing; axes with one reason together.
fn missing(own: &[&ChannelNoise]) -> Vec<String> {
    let mut all: Vec<(String, Vec<&str>)> = Vec::new();
    for channel in own {
        for missing in &channel.not_observable {
            let verb = if missing.reason.starts_with("not ") {
                " is"
            } else {
                ":"
            };
            let text = format!("{}{verb} {}", missing.term, missing.reason);
            match all.iter_mut().find(|(known, _)| *known == text) {
                Some((_, channels)) => channels.push(&channel.channel),
                None => all.push((text, vec![&channel.channel])),
            }
        }
    }
    all.sort();
    let line = |(text, channels): (String, Vec<&str>)| format!("{}: {text}", channels.join(", "));
    all.into_iter().map(line).collect()
}

const METHOD: &str = "Overlapping Allan deviation over every sample. Least squares on the variance, no term negative, weighted by the variances of overlapping estimates, with intervals from their covariance. Data sheets state one-sided densities, larger than N by √2. A term is not observable with fewer than four degrees of freedom, a standard deviation of over 35 %; its limit holds with 95 %.";
