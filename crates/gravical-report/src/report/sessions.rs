//! Report of many sessions: a table, with the page of each.

use std::collections::BTreeSet;

use gravical::calibration_file::Grade;
use gravical::numfmt::{count, mg};

use crate::document::{Cell, Document, Section, Table, Verdict};
use crate::figure::Figure;

/// What became of a session.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Session {
    /// Its path.
    pub name: String,
    /// The address of its page, from that of all.
    pub page: Option<String>,
    /// Its sensor; empty where it is not named.
    pub sensor: String,
    /// When it was recorded; empty where that is unknown.
    pub recorded: String,
    /// Its grade; none where it failed.
    pub grade: Option<Grade>,
    /// Error in the worst direction, m/s².
    pub error_mps2: Option<f64>,
    /// The main reason.
    pub reason: String,
}

/// The document of many sessions, with [its figure](crate::figure::sessions::sessions).
pub fn sessions<'a>(all: &[Session], figures: &'a [Figure]) -> Document<'a> {
    let of = |grade: Option<Grade>| all.iter().filter(|s| s.grade == grade).count();
    let counts = [
        (Some(Grade::Good), "good"),
        (Some(Grade::Fair), "fair"),
        (Some(Grade::NotVerifiable), "not verifiable"),
        (Some(Grade::Poor), "poor"),
        (None, "failed"),
    ];
    let counts = counts.map(|(grade, name)| (of(grade), name));
    let bad = of(Some(Grade::Poor)) + of(None);
    let mut errors: Vec<f64> = all.iter().filter_map(|s| s.error_mps2).collect();
    errors.sort_by(f64::total_cmp);
    let headline = match errors.last() {
        Some(last) => format!(
            "Half within {} mg, all within {} mg",
            mg(errors[errors.len() / 2]),
            mg(*last)
        ),
        None => "No calibration".to_owned(),
    };
    let text = match bad {
        0 => "Each has a result.".to_owned(),
        n => format!(
            "{} failed or poor: the table says why.",
            count(n, "session")
        ),
    };
    let numbers = counts.iter().filter(|(n, _)| *n > 0);
    let verdict = Verdict {
        grade: if bad > 0 { Grade::Fair } else { Grade::Good },
        word: if bad > 0 { "look at some" } else { "done" }.to_owned(),
        headline: [headline, "95 %".to_owned()],
        proof: vec![text],
        numbers: numbers
            .map(|(n, name)| [n.to_string(), (*name).to_owned()])
            .collect(),
        reasons: Vec::new(),
        next: Vec::new(),
    };
    // What no session says is no column.
    type Column = (&'static str, fn(&Session) -> &str);
    let columns: [Column; 2] = [("sensor", |s| &s.sensor), ("recorded", |s| &s.recorded)];
    let is_said = |(_, of): &Column| all.iter().any(|s| !of(s).is_empty());
    let said: Vec<Column> = columns.into_iter().filter(is_said).collect();
    let table = Table::new("", ["session"]).columns(said.iter().map(|(name, _)| *name));
    let table = table.columns(["grade", "error, mg", "reason"]);
    let table = all.iter().fold(table.sortable(), |table, s| {
        let name = match &s.page {
            Some(page) => Cell::Link(s.name.clone(), page.clone()),
            None => Cell::text(&s.name),
        };
        let grade = s
            .grade
            .map_or("failed".to_owned(), |grade| grade.to_string());
        let said = said.iter().map(|(_, of)| Cell::text(of(s)));
        let cells = [
            Cell::text(grade.replace('-', "\u{a0}")),
            Cell::maybe(s.error_mps2, mg),
            Cell::text(&s.reason),
        ];
        table.with(std::iter::once(name).chain(said).chain(cells))
    });
    let sensors: BTreeSet<&str> = all
        .iter()
        .map(|s| &*s.sensor)
        .filter(|s| !s.is_empty())
        .collect();
    let dates: BTreeSet<&str> = all
        .iter()
        .map(|s| &*s.recorded)
        .filter(|s| !s.is_empty())
        .collect();
    let dates = match (dates.first(), dates.last()) {
        (Some(first), Some(last)) if first != last => format!("{first} to {last}"),
        (Some(one), _) => (*one).to_owned(),
        _ => "dates unknown".to_owned(),
    };
    let sensors = match sensors.len() {
        0 => "not named".to_owned(),
        n => n.to_string(),
    };
    let certificate = [
        ("Sessions", all.len().to_string()),
        ("Sensors", sensors),
        ("Recorded", dates),
    ];
    Document {
        certificate: certificate
            .map(|(name, value)| [name.to_owned(), value, String::new()])
            .into(),
        verdict: Some(verdict),
        ..Document::new(format!("Calibration of {}", count(all.len(), "session")))
    }
    .with(
        Section::new("Errors")
            .figures(figures, &["sessions"])
            .wide(7),
    )
    .with(Section::new("Sessions").with(table))
}
