//! Report of the noise of a sensor.

use crate::document::{Block, Cell, Column, Document, Row, Section, Table};
use crate::figure::Figure;
use gravical::noise::{ChannelNoise, Estimate, NoiseResult, Term, Unit, duration_text};
use gravical::numfmt::{count, decimals_for, fixed, small, unit};

use super::short_name;

/// The document of an Allan deviation; `figures` are those of [`crate::figure::noise`].
#[must_use]
pub fn noise<'a>(result: &NoiseResult, figures: &'a [Figure]) -> Document<'a> {
    let input = result.inputs.first().map_or("", |input| &input.path);
    let name = short_name(input);
    let mut document = Document {
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
    document = document.with(reading.with(Block::Facts(facts)));
    let mut section = Section::new("noise", "Noise");
    for (letter, sensor) in [('a', "accelerometer"), ('g', "gyroscope")] {
        let own: Vec<&ChannelNoise> = result
            .channels
            .iter()
            .filter(|c| c.channel.starts_with(letter))
            .collect();
        if own.is_empty() {
            continue;
        }
        section = section
            .with(parameters(sensor, &own))
            .full(intervals(sensor, &own));
        let missing = missing(&own);
        if !missing.is_empty() {
            section = section.with(Block::List(missing));
        }
    }
    section = section.with(Block::note(
        "N: noise density, B: bias instability, K: random walk; ± 1σ, < upper limit (95 %). N by density: from the power spectral density at 1 to 10 Hz.",
    ));
    document = document.with(section);
    let mut curves = Section::new("allan", "Allan deviation").figures(figures);
    curves = curves
        .full(Block::Equation(vec![
            "σ²(τ) = N²/τ + (2 ln 2/π) B² + K²τ/3",
        ]))
        .full(Block::paragraph(METHOD));
    for channel in &result.channels {
        curves = curves.full(points(channel));
    }
    document.with(curves).with_findings(&result.findings, false)
}

/// One sentence.
fn conclusion(result: &NoiseResult) -> String {
    let sensors = [('a', "accelerometer"), ('g', "gyroscope")];
    let parts = sensors.iter().filter_map(|(letter, sensor)| {
        let own: Vec<&ChannelNoise> = result
            .channels
            .iter()
            .filter(|c| c.channel.starts_with(*letter))
            .collect();
        if own.is_empty() {
            return None;
        }
        let terms = Term::ALL.map(|term| span(term, *letter == 'g', &own));
        Some(format!("{sensor} {}", terms.join(", ")))
    });
    let parts: Vec<String> = parts.collect();
    match parts.is_empty() {
        true => "no channel could be analysed".to_owned(),
        false => parts.join("; "),
    }
}

/// A term of all axes: `N 330 to 480 µg/√Hz`.
fn span(term: Term, gyroscope: bool, own: &[&ChannelNoise]) -> String {
    let Unit { name, factor } = Unit::of(term, gyroscope);
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

/// The terms, each with its usual unit.
fn terms(gyroscope: bool) -> [(Term, Unit); 3] {
    Term::ALL.map(|term| (term, Unit::of(term, gyroscope)))
}

fn of_channels(caption: String, own: &[&ChannelNoise]) -> Table {
    Table::new(caption)
        .columns([Column::left("")])
        .columns(own.iter().map(|c| Column::number(&c.channel)))
}

fn parameters(sensor: &str, own: &[&ChannelNoise]) -> Table {
    let gyroscope = sensor == "gyroscope";
    let mut table = of_channels(sensor.to_owned(), own);
    for (term, Unit { name, factor }) in terms(gyroscope) {
        let label = format!("{}, {name}", term.symbol());
        let values = own.iter().map(|c| value(c, term, factor));
        table = table.row(std::iter::once(Cell::text(label)).chain(values));
    }
    table = table
        .row(in_si(own, gyroscope))
        .row(by_density(own, gyroscope));
    match own.iter().any(|c| c.data_sheet.is_some()) {
        true => table.row(by_data_sheet(own, gyroscope)),
        false => table,
    }
}

fn intervals(sensor: &str, own: &[&ChannelNoise]) -> Table {
    let mut table = of_channels(format!("{sensor}: 95 % intervals"), own);
    for (term, Unit { name, factor }) in terms(sensor == "gyroscope") {
        let label = format!("{}, {name}", term.symbol());
        let values = own.iter().map(|c| interval(c.estimate(term), factor));
        table = table.row(std::iter::once(Cell::text(label)).chain(values));
    }
    table
}

fn value(channel: &ChannelNoise, term: Term, factor: f64) -> Cell {
    match (channel.estimate(term), channel.missing(term)) {
        (Some(e), _) => {
            let deviation = factor * (e.high - e.low) / 3.92;
            let decimals = decimals_for(deviation);
            let sigma = fixed(deviation, decimals);
            let text = fixed(factor * e.value, decimals);
            Cell::number(text).plus_minus(Some(sigma))
        }
        (None, Some(missing)) => match missing.at_most {
            Some(most) => Cell::text(format!("< {}", small(factor * most, 2))),
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
            Cell::text(format!("{} to {}", text(e.low), text(e.high)))
        }
        None => Cell::none(),
    }
}

/// N in SI units, which code needs.
fn in_si(own: &[&ChannelNoise], gyroscope: bool) -> Row {
    let n = own
        .iter()
        .map(|c| Cell::maybe(c.n.map(|n| n.value), |n| format!("{n:.2e}")));
    let label = format!("N, {}", Unit::si(Term::N, gyroscope));
    std::iter::once(Cell::text(label)).chain(n).into()
}

fn by_density(own: &[&ChannelNoise], gyroscope: bool) -> Row {
    let Unit { name, factor } = Unit::of(Term::N, gyroscope);
    let n = own.iter().map(|c| {
        let known = c.density.filter(|_| c.n.is_some());
        Cell::maybe(known.map(|d| d.n), |n| small(factor * n, 3))
    });
    let label = format!("N by density, {name}");
    std::iter::once(Cell::text(label)).chain(n).into()
}

fn by_data_sheet(own: &[&ChannelNoise], gyroscope: bool) -> Row {
    let Unit { name, factor } = Unit::of(Term::N, gyroscope);
    let n = own.iter().map(|c| {
        let sheet = c.data_sheet.as_ref();
        Cell::maybe(sheet.map(|s| s.n), |n| small(factor * n, 3))
    });
    let label = format!("N by data sheet, {name}");
    std::iter::once(Cell::text(label)).chain(n).into()
}

/// Why terms are missing; axes with one reason together.
fn missing(own: &[&ChannelNoise]) -> Vec<String> {
    let mut all: Vec<(String, Vec<&str>)> = Vec::new();
    for channel in own {
        for missing in &channel.not_observable {
            let text = format!("{} is {}", missing.term, missing.reason);
            let text = match missing.reason.starts_with("not ") {
                true => text,
                false => format!("{}: {}", missing.term, missing.reason),
            };
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

fn points(channel: &ChannelNoise) -> Table {
    let of_unit = unit(&channel.unit);
    let row = |p: &gravical::noise::AllanPoint| {
        let number = |v: f64| Cell::number(format!("{v:.3e}"));
        Row::from([
            Cell::number(small(p.tau_s, 4)),
            number(p.sigma),
            number(p.low),
            number(p.high),
            Cell::number(small(p.edf, 2)),
        ])
    };
    Table::new(format!("{}: Allan deviation, {of_unit}", channel.channel))
        .columns(["τ, s", "σ", "low (95 %)", "high", "degrees of freedom"].map(Column::number))
        .rows(channel.adev.iter().map(row))
}
