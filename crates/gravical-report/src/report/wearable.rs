//! Report of epochs of a worn sensor.

use crate::document::{Block, Cell, Column, Document, Row, Section, Table};
use gravical::noise::duration_text;
use gravical::numfmt::{count, fixed};
use gravical::wearable::{WearableSummary, Worn};

use super::short_name;

/// The document of [`gravical::wearable::summarise`]: time worn and activity, of each day.
#[must_use]
pub fn wearable(summary: &WearableSummary) -> Document<'static> {
    let mut facts: Vec<(String, String)> = Vec::new();
    let mut fact = |name: &str, text: String| facts.push((name.to_owned(), text));
    fact("read as", summary.description.clone());
    let rate = summary
        .rate_hz
        .map_or_else(String::new, |hz| format!(", {} Hz", fixed(hz, 2)));
    fact(
        "samples",
        format!("{}{rate}; {} missing", summary.samples, summary.missing),
    );
    let g = match summary.calibrated {
        true => format!("calibrated; 1 g is {} m/s²", fixed(summary.g_mps2, 5)),
        false => "by the nominal scale".to_owned(),
    };
    fact("acceleration", g);
    let zone = match &summary.time_zone {
        Some(zone) => format!("; {zone}"),
        None => " s from the first sample".to_owned(),
    };
    fact(
        "time",
        format!("{} to {}{zone}", summary.start, summary.end),
    );
    let all = &summary.worn;
    fact("epochs", epochs(all, summary.epoch_s));
    let enmo = all
        .enmo_mg
        .map_or_else(|| "not known".to_owned(), |mg| format!("{mg:.1} mg"));
    fact("ENMO", format!("{enmo} (mean, without non-wear)"));
    let day = |(_, day): (usize, &gravical::wearable::Day)| {
        let time = |_: &str, s: u64| {
            let hours = s as f64 / 3600.0;
            Cell::number(fixed(hours, 2))
        };
        Row::from([
            Cell::text(&day.day),
            time("wear_s", day.worn.wear_s),
            time("nonwear_s", day.worn.nonwear_s),
            time("unjudged_s", day.worn.unjudged_s),
            Cell::maybe(day.worn.enmo_mg, |mg| fixed(mg, 1)),
        ])
    };
    let table = Table::new("Time and activity")
        .columns([
            Column::left("day"),
            Column::number("worn, h"),
            Column::number("not worn, h"),
            Column::number("not judged, h"),
            Column::number("ENMO, mg"),
        ])
        .rows(summary.days.iter().enumerate().map(day));
    let reading = Section::new("reading", "How it was read").opening();
    let days = Section::new("days", "Days").with(table).with(Block::note(
        "Worn by the rule of van Hees et al. 2013, in blocks of 15 min; less than an hour is not judged.",
    ));
    Document::new(format!("Epochs of {}", short_name(&summary.input)))
        .with(reading.with(Block::Facts(facts)))
        .with(days)
        .with_findings(&summary.findings, false)
}

/// `17280 epochs of 5 s, 12 without samples; 23 h worn, 1.0 h not worn`.
fn epochs(worn: &Worn, epoch_s: u32) -> String {
    let mut text = format!("{} of {epoch_s} s", count(worn.epochs, "epoch"));
    if worn.epochs_empty > 0 {
        text += &format!(", {} without samples", worn.epochs_empty);
    }
    let parts = [
        (worn.wear_s, "worn"),
        (worn.nonwear_s, "not worn"),
        (worn.unjudged_s, "not judged"),
    ];
    let parts: Vec<String> = parts
        .iter()
        .filter(|(s, _)| *s > 0)
        .map(|(s, what)| format!("{} {what}", duration_text(*s as f64)))
        .collect();
    match parts.is_empty() {
        true => text,
        false => format!("{text}; {}", parts.join(", ")),
    }
}
