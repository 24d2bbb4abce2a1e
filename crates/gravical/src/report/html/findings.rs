//! Findings, and where a result comes from.

use maud::{Markup, html};

use super::super::text::short_name;
use super::ROWS;
use super::cells::{heads, more, table};
use crate::calibration_file::InputFile;
use crate::finding::format_spans;
use crate::recording::{Finding, Severity};

/// Warnings first, then notes.
pub(super) fn findings(all: &[Finding]) -> Markup {
    if all.is_empty() {
        return html! { p { "Nothing odd was found." } };
    }
    let of = |severity: Severity| all.iter().filter(move |f| f.severity == severity);
    let sorted: Vec<&Finding> = of(Severity::Warning).chain(of(Severity::Note)).collect();
    html! {
        ul.findings { @for f in sorted.iter().take(ROWS) { (finding(f)) } }
        (more(sorted.len(), ROWS))
    }
}

fn finding(f: &Finding) -> Markup {
    let (class, sign, word) = match f.severity {
        Severity::Warning => ("warning", "!", "Warning"),
        Severity::Note => ("note", "·", "Note"),
    };
    let mut place = Vec::new();
    if !f.lines.is_empty() {
        let word = if f.count == 1 { "line" } else { "lines" };
        place.push(format!("{word} {}", format_spans(&f.lines, f.count, 4)));
    }
    if let Some(file) = &f.file {
        place.push(short_name(file));
    }
    html! {
        li.(class) {
            span.sign aria-hidden="true" { (sign) } " "
            span.vh { (word) ": " }
            code { (f.kind) } " " (f.message)
            @if !place.is_empty() { span.where { " [" (place.join("; ")) "]" } }
        }
    }
}

/// Files with their checksums.
pub(super) fn inputs(files: &[InputFile]) -> Markup {
    let body = html! {
        @for file in files.iter().take(ROWS) {
            tr {
                th scope="row" { (file.path) }
                td { (file.role.name()) }
                td.hash { @match &file.sha256 { Some(sum) => code { (sum) }, None => "–" } }
            }
        }
    };
    html! {
        (table("Files", &heads(&["file", "<used as", "<SHA-256"]), &body))
        (more(files.len(), ROWS))
    }
}
