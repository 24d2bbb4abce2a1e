//! Report of many recordings.

use crate::document::{
    Block, Cell, Column, Document, Grade, KeyFigure, Row, Section, Table, Verdict,
};
use crate::figure::Figure;
use gravical::cohort::{Cohort, Distribution};
use gravical::numfmt::{count, decimals_for, digits, fixed, small};

/// Shards that a sentence names.
const MOST_SHARDS: usize = 8;

/// The document of a cohort; `figures` are those of [`crate::figure::cohort`], and `link` makes of the
/// file of a result the address by which a page leads to it.
#[must_use]
pub fn cohort<'a>(
    cohort: &Cohort,
    figures: &'a [Figure],
    link: &dyn Fn(&str) -> String,
) -> Document<'a> {
    let title = format!("Results of {} in {}", cohort.command, cohort.folder);
    Document {
        subject: vec![format!("{title}: {}", counts(cohort))],
        verdict: Some(verdict(cohort)),
        ..Document::new(title)
    }
    .with(errors(cohort))
    .with(distributions(cohort).figures(figures))
    .with(worst(cohort, link))
    .with(sensors(cohort))
    .with(origins(cohort))
}

/// What became of the items, in words.
fn counts(cohort: &Cohort) -> String {
    let c = cohort.counts;
    let failures = [
        (c.poor, "poor"),
        (c.error, "failed"),
        (c.missing, "missing"),
    ];
    let mut text = format!("{}: {} done", count(c.items, "recording"), c.done);
    for (n, word) in failures.into_iter().filter(|(n, _)| *n > 0) {
        text.push_str(&format!(", {n} {word}"));
    }
    text
}

fn verdict(cohort: &Cohort) -> Verdict {
    let c = cohort.counts;
    let mut reasons = Vec::new();
    if c.missing > 0 {
        reasons.push(format!("{} no result yet", have(c.missing)));
    }
    if !cohort.missing_shards.is_empty() {
        let shards = cohort.missing_shards.iter();
        let named: Vec<String> = shards.take(MOST_SHARDS).map(ToString::to_string).collect();
        let more = match cohort.missing_shards.len() - named.len() {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        let of = "of these shards there is no journal";
        reasons.push(format!("{of}: {}{more}", named.join(", ")));
    }
    if c.error > 0 {
        reasons.push(format!("{} failed, the reasons are below", items(c.error)));
    }
    if c.poor > 0 {
        reasons.push(format!(
            "{} a result that failed its quality gate",
            have(c.poor)
        ));
    }
    if cohort.origins.len() > 1 {
        let n = cohort.origins.len();
        reasons.push(format!(
            "the results come from {n} different versions or options"
        ));
    }
    if !cohort.changed_sensors.is_empty() {
        let n = cohort.changed_sensors.len();
        reasons.push(format!(
            "{} changed between calibrations",
            count(n, "sensor")
        ));
    }
    let (grade, word) = match () {
        () if c.missing > 0 => (Grade::Poor, "incomplete"),
        () if c.error + c.poor > 0 => (Grade::Fair, "complete, with failures"),
        () => (Grade::Good, "complete"),
    };
    if reasons.is_empty() {
        reasons.push("all have a result".to_owned());
    }
    let number = |_: &str, n: u64, what: &str| KeyFigure {
        value: n.to_string(),
        unit: "",
        what: what.to_owned(),
    };
    let mut verdict = Verdict::new(grade, word, &reasons);
    verdict.figures = vec![
        number("done", c.done, "done"),
        number("poor", c.poor, "poor"),
        number("error", c.error, "failed"),
        number("missing", c.missing, "missing"),
    ];
    if c.missing > 0 {
        verdict.next.push(
            "run again with --resume: what is done is skipped, the rest is worked on".to_owned(),
        );
    }
    verdict
}

fn items(n: u64) -> String {
    count(n, "recording")
}

fn have(n: u64) -> String {
    let verb = if n == 1 { "has" } else { "have" };
    format!("{} {verb}", items(n))
}

fn errors(cohort: &Cohort) -> Section<'static> {
    let section = Section::new("failed", "What failed");
    if cohort.errors.is_empty() {
        return section;
    }
    let row = |(_, e): (usize, &gravical::cohort::ErrorCount)| {
        Row::from([
            Cell::Code(e.code.clone()),
            Cell::number(e.items.to_string()),
            Cell::text(e.examples.join(", ")),
            Cell::text(&e.message),
            Cell::text(e.hint.as_deref().unwrap_or("–")),
        ])
    };
    let table = Table::new("")
        .columns([
            Column::left("code"),
            Column::number("recordings"),
            Column::left("first ones"),
            Column::left("message of the first"),
            Column::left("what helps").full(),
        ])
        .rows(cohort.errors.iter().enumerate().map(row));
    section.with(table)
}

fn distributions(cohort: &Cohort) -> Section<'static> {
    let section = Section::new("distributions", "Distributions");
    if cohort.distributions.is_empty() {
        return section;
    }
    let row = |(_, d): (usize, &Distribution)| {
        let cell = |_: &str, v: f64| Cell::number(number(d, v));
        let count = |_: &str, n: u64| Cell::number(n.to_string());
        let row = Row::from([
            Cell::text(words(&d.name)),
            Cell::text(&d.unit),
            count("values", d.values),
            cell("min", d.min),
            cell("q05", d.q05),
            cell("q25", d.q25),
            cell("median", d.median),
            cell("q75", d.q75),
            cell("q95", d.q95),
            cell("max", d.max),
        ]);
        match d.in_other_units {
            0 => row,
            n => row.noted(format!("{} in another unit: not counted", values(n))),
        }
    };
    let table = |caption: &str, sd: bool| {
        let all = cohort.distributions.iter().enumerate();
        let own = all.filter(|(_, d)| d.name.ends_with("_sd") == sd);
        Table::new(caption)
            .columns([
                Column::left(""),
                Column::left("unit"),
                Column::number("values"),
            ])
            .columns([Column::number("least").full(), Column::number("5 %")])
            .columns([Column::number("25 %").full()])
            .columns([Column::number("median")])
            .columns([Column::number("75 %").full()])
            .columns([Column::number("95 %"), Column::number("largest").full()])
            .rows(own.map(row))
    };
    let note = Block::note("Below each value lies that share of the results.");
    let section = section.with(table("", false)).with(note);
    match cohort.distributions.iter().any(|d| d.name.ends_with("_sd")) {
        true => section.full(table("Standard deviations", true)),
        false => section,
    }
}

/// A column in words; its unit stands elsewhere.
fn words(column: &str) -> String {
    let name = ["_mps2", "_c", "_hz", "_s"]
        .iter()
        .find_map(|unit| column.strip_suffix(unit));
    name.unwrap_or(column).replace('_', " ")
}

fn values(n: u64) -> String {
    count(n, "value")
}

/// A number of a distribution, with digits by the spread of most values.
fn number(d: &Distribution, value: f64) -> String {
    let whole = |v: f64| v == v.round() && v.abs() < 1e15;
    let ends = [d.min, d.q05, d.q25, d.median, d.q75, d.q95, d.max];
    if ends.into_iter().all(whole) {
        return fixed(value, 0);
    }
    match d.q95 - d.q05 {
        spread if spread > 0.0 => fixed(value, decimals_for(0.1 * spread)),
        _ => small(value, 4),
    }
}

fn worst(cohort: &Cohort, link: &dyn Fn(&str) -> String) -> Section<'static> {
    let section = Section::new("worst", "The worst");
    if cohort.worst.len() < 2 {
        return section;
    }
    let name = words(&cohort.worst_by);
    let row = |(_, w): (usize, &gravical::cohort::WorstItem)| {
        Row::from([
            Cell::text(&w.name),
            Cell::number(digits(w.value, 3)),
            Cell::text(w.verdict.as_deref().unwrap_or("–")),
            Cell::text(&w.path),
            match &w.result {
                Some(result) => Cell::Link(result.clone(), link(result)),
                None => Cell::none(),
            },
        ])
    };
    let unit = match cohort.worst_unit.is_empty() {
        true => String::new(),
        false => format!(", {}", cohort.worst_unit),
    };
    let table = Table::new("")
        .columns([
            Column::left("name"),
            Column::number(format!("{name}{unit}")),
        ])
        .columns([
            Column::left("verdict"),
            Column::left("recording"),
            Column::left("result").full(),
        ])
        .rows(cohort.worst.iter().enumerate().map(row));
    section.with(table)
}

fn sensors(cohort: &Cohort) -> Section<'static> {
    let section = Section::new("sensors", "Sensors that changed");
    if cohort.repeated_sensors == 0 {
        return section;
    }
    let section = match cohort.unreadable.is_empty() {
        true => section,
        false => section.with(Block::List(cohort.unreadable.clone())),
    };
    let with_several = format!(
        "{} with several calibrations",
        count(cohort.repeated_sensors, "sensor")
    );
    if cohort.changed_sensors.is_empty() {
        return section.with(Block::paragraph(format!(
            "{with_several}; none of them changed by more than its uncertainty."
        )));
    }
    let row = |s: &gravical::cohort::ChangedSensor| {
        Row::from([
            Cell::text(&s.sensor_id),
            Cell::text(s.items.join(", ")),
            Cell::text(s.reasons.first().map_or("–", String::as_str)),
        ])
    };
    let table = Table::new("")
        .columns(["sensor", "calibrations", "why"].map(Column::left))
        .rows(cohort.changed_sensors.iter().map(row));
    section.with(Block::paragraph(format!("{with_several}."))).with(table).with(Block::note(
        "By the test of `gravical store history`: at most 1 % of sensors that did not change are listed here.",
    ))
}

fn origins(cohort: &Cohort) -> Section<'static> {
    let section = Section::new("origins", "Versions and options");
    let line = |o: &gravical::cohort::OriginCount| {
        let words = o.options.join(" ");
        format!(
            "{} by {}: `gravical {}`",
            count(o.items, "row"),
            o.tool,
            format!("{} {words}", cohort.command).trim_end()
        )
    };
    let list = Block::List(cohort.origins.iter().map(line).collect());
    match cohort.origins.len() {
        0 => section,
        1 => section.full(list),
        _ => section
            .with(Block::paragraph(
                "These results do not come from the same computation:",
            ))
            .with(list),
    }
}
