//! Report of filters and their effect on noise.

use gravical::core::matrix3::norm;
use gravical::denoise::{DenoiseSummary, Sigmas};
use gravical::numfmt::{count, decimals_of, fixed, small, unit};

use super::short_name;
use crate::document::{Block, Cell, Document, Section, Table, Verdict};
use crate::figure::Figure;

const NO_DRIFT: &str = "Smoothing does not reduce drift: the noise that it removes averages out in the integral anyway, and a bias passes a low-pass unchanged.";

/// The document of filters: the effect of each on white noise, and on this recording at rest.
pub fn denoise<'a>(summary: &DenoiseSummary, figures: &'a [Figure]) -> Document<'a> {
    let rate = summary.rate_hz.map(|rate| format!("{rate:.2} Hz"));
    let rate = rate.unwrap_or_else(|| "rate unknown".to_owned());
    let segments = count(summary.segments, "segment");
    let rests = (summary.static_intervals > 0).then(|| {
        let spans = count(summary.static_intervals, "static interval");
        format!("{spans}, {} rows", summary.static_rows)
    });
    let reading = Section::new("How it was read")
        .fact("read as", summary.description.clone())
        .fact("sampling", format!("{rate}, {segments}"))
        .fact("at rest", rests);
    let mut filters = Section::new("Filters").with(white(summary));
    let sensors: [(_, _, fn(&Sigmas) -> _); 2] = [
        ("accelerometer", summary.accel_unit, |s| s.accelerometer),
        ("gyroscope", summary.gyro_unit, |s| s.gyroscope),
    ];
    for (name, unit, of) in sensors {
        if of(&summary.recorded).is_some() {
            filters = filters.with(at_rest(summary, name, unit, of));
        }
    }
    let names: Vec<&str> = summary.filters.iter().map(|f| f.filter.as_str()).collect();
    let entry = |name: &str, value: String| [name.to_owned(), value, String::new()];
    let last = summary.filters.last().map(|f| f.sigma).unwrap_or_default();
    let share = |of: fn(&Sigmas) -> Option<[f64; 3]>| {
        let ratio = rms(&of(&last)?) / rms(&of(&summary.recorded)?);
        ratio
            .is_finite()
            .then(|| fixed(ratio, decimals_of(ratio, 2)))
    };
    let shares = [share(|s| s.accelerometer), share(|s| s.gyroscope)];
    let headline = match &shares {
        [Some(ratio), _] | [None, Some(ratio)] => format!("Noise at rest: {ratio} of what it was"),
        [None, None] => format!("Filtered by {}", names.join(", ")),
    };
    let numbers = shares.into_iter().zip(["accelerometer", "gyroscope"]);
    let numbers =
        numbers.filter_map(|(share, sensor)| Some([share?, format!("{sensor}, of its σ at rest")]));
    Document {
        certificate: vec![
            entry("Recording", short_name(&summary.input)),
            entry("Filters", names.join(", ")),
            entry("Rows", summary.rows.to_string()),
            entry("Rate", rate),
        ],
        verdict: Some(Verdict {
            numbers: numbers.collect(),
            ..Verdict::without_word([headline, String::new()], String::new())
        }),
        ..Document::new(format!("Filtering of {}", short_name(&summary.input)))
    }
    .with(
        Section::new("Raw and filtered")
            .figures(figures, &["filtered"])
            .wide(7),
    )
    .with(
        Section::new("Spectrum")
            .figures(figures, &["spectrum"])
            .wide(6),
    )
    .with(Section::new("Noise").figures(figures, &["noise"]).wide(6))
    .with(filters.with(Block::Paragraph(NO_DRIFT.to_owned())))
    .with(reading.folded("what was read"))
    .with_findings(&summary.findings, false)
}

fn rms(axes: &[f64; 3]) -> f64 {
    norm(axes) / 3_f64.sqrt()
}

/// Effect on white noise.
fn white(summary: &DenoiseSummary) -> Table {
    let replaced = summary.filters.iter().any(|f| f.replaced.is_some());
    let mut table = Table::new("Properties", ["filter", "factor on white noise"])
        .columns(replaced.then_some("samples replaced"));
    for f in &summary.filters {
        let gain = |gain| fixed(gain, decimals_of(gain, 3).min(4));
        let count = || Cell::maybe(f.replaced.map(|n| n as f64), |n| fixed(n, 0));
        let cells = [Cell::maybe(f.noise_gain, gain)];
        table = table.row(&f.filter, cells.into_iter().chain(replaced.then(count)));
    }
    table
}

/// Effect on this recording.
fn at_rest(
    summary: &DenoiseSummary,
    name: &str,
    of_unit: &str,
    of: fn(&Sigmas) -> Option<[f64; 3]>,
) -> Table {
    let cells = |sigmas: &Sigmas| Cell::axes(of(sigmas), |v| small(v, 3));
    let table = Table::new(format!("σ of {name} at rest, {}", unit(of_unit)), [""])
        .axes("")
        .row("as recorded", cells(&summary.recorded));
    summary.filters.iter().fold(table, |table, f| {
        table.row(format!("after {}", f.filter), cells(&f.sigma))
    })
}
