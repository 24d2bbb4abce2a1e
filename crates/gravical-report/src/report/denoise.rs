//! Report of filters and their effect on noise.

use crate::document::{Block, Cell, Column, Document, Row, Section, Table};
use gravical::denoise::{DenoiseSummary, FilterOutcome, Sigmas};
use gravical::numfmt::{count, decimals_of, fixed, small, unit};

use super::short_name;

const NO_DRIFT: &str = "Smoothing does not reduce drift: the noise that it removes averages out in the integral anyway, and a bias passes a low-pass unchanged.";

/// The document of filters: the effect of each on white noise, and on this recording at rest.
pub fn denoise(summary: &DenoiseSummary) -> Document<'static> {
    let rate = match summary.rate_hz {
        Some(rate) => format!("{rate:.2} Hz"),
        None => "rate unknown".to_owned(),
    };
    let segments = count(summary.segments, "segment");
    let rests = (summary.static_intervals > 0).then(|| {
        let spans = count(summary.static_intervals, "static interval");
        format!("{spans}, {} rows", summary.static_rows)
    });
    let facts = Block::facts([
        ("read as", Some(summary.description.clone())),
        ("sampling", Some(format!("{rate}, {segments}"))),
        ("at rest", rests),
    ]);
    let mut filters = Section::new("filters", "Filters").with(white(summary));
    let sensors: [(_, _, fn(&Sigmas) -> _); 2] = [
        ("accelerometer", summary.accel_unit, |s| s.accelerometer),
        ("gyroscope", summary.gyro_unit, |s| s.gyroscope),
    ];
    for (name, unit, of) in sensors {
        if of(&summary.recorded).is_some() {
            filters = filters.with(at_rest(summary, name, unit, of));
        }
    }
    let reading = Section::new("reading", "How it was read");
    Document::new(format!("Filtering of {}", short_name(&summary.input)))
        .with(reading.with(facts))
        .with(filters.with(Block::paragraph(NO_DRIFT)))
        .with_findings(&summary.findings, false)
}

/// Effect on white noise.
fn white(summary: &DenoiseSummary) -> Table {
    let replaced = summary.filters.iter().any(|f| f.replaced.is_some());
    let row = |f: &FilterOutcome| {
        let gain = |gain| fixed(gain, decimals_of(gain, 3).min(4));
        let cells = [Cell::text(&f.filter), Cell::maybe(f.noise_gain, gain)];
        let count = || Cell::maybe(f.replaced.map(|n| n as f64), |n| fixed(n, 0));
        Row::from(cells.into_iter().chain(replaced.then(count)))
    };
    Table::new("Properties")
        .columns(["filter", "factor on white noise"])
        .columns(replaced.then_some("samples replaced"))
        .rows(summary.filters.iter().map(row))
}

/// Effect on this recording.
fn at_rest(
    summary: &DenoiseSummary,
    name: &str,
    of_unit: &str,
    of: fn(&Sigmas) -> Option<[f64; 3]>,
) -> Table {
    let of_unit = match of_unit {
        "unknown" => "unit unknown".to_owned(),
        known => unit(known),
    };
    let row =
        |name: &str, sigmas: &Sigmas| Row::named(name, Cell::axes(of(sigmas), |_, v| small(v, 3)));
    let filters = summary.filters.iter();
    Table::new(format!("σ of {name} at rest, {of_unit}"))
        .columns([""])
        .columns(Column::axes(""))
        .row(row("as recorded", &summary.recorded))
        .rows(filters.map(|f| row(&format!("after {}", f.filter), &f.sigma)))
}
