//! A document as one self-contained HTML file: no network, fonts or server; complete without
//! its script, too.

use gravical::calibration_file::Grade;
use gravical::escape;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{
    Block, Cell, Column, Detail, Document, Remark, Section, Table, Verdict, left_out, parts,
};
use crate::figure::{Figure, svg};

/// Nothing is loaded, whatever a file name or label contains.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

impl Document<'_> {
    /// The whole document as a page.
    pub fn to_html(&self) -> String {
        let verdict = self.verdict.iter().map(|v| ("Verdict", verdict(v)));
        let blocks =
            |s: &Section<'_>| html! { @for b in s.shown(Detail::Full) { (block(b, s.title)) } };
        let sections = verdict.chain(self.sections.iter().map(|s| (s.title, blocks(s))));
        // Where a link leads, heading and content.
        let anchor = |title: &str| title.to_lowercase().replace(' ', "-");
        let sections = sections.map(|(title, body)| (anchor(title), title, body));
        let sections: Vec<(String, &str, Markup)> = sections.collect();
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    // Prevents a request for /favicon.ico.
                    link rel="icon" href="data:,";
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    a.skip href="#main" { "Skip to the report" }
                    header {
                        h1 { (self.title) }
                        @for line in &self.subject { p.sub { (line) } }
                    }
                    nav aria-label="Sections" {
                        ol { @for (id, title, _) in &sections { li { a href={ "#" (id) } { (title) } } } }
                    }
                    main id="main" tabindex="-1" {
                        @for (id, title, body) in &sections {
                            section id=(id) aria-labelledby={ (id) "-h" } {
                                h2 id={ (id) "-h" } { (title) }
                                (body)
                            }
                        }
                    }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        };
        escape::shown(&page.into_string()).into_owned()
    }
}

/// Badge, conclusion, reasons, next steps.
fn verdict(v: &Verdict) -> Markup {
    let (class, sign) = match v.grade {
        Grade::Good => ("good", "✓"),
        Grade::Fair => ("fair", "~"),
        Grade::Poor => ("poor", "✗"),
        Grade::NotVerifiable => ("unknown", "?"),
    };
    html! {
        p.badge.(class) { span.sign aria-hidden="true" { (sign) } " " strong { (v.word) } }
        @if let Some(conclusion) = &v.conclusion { p.conclusion { (words(conclusion)) } }
        (list(&v.reasons))
        @if !v.next.is_empty() { h3 { "Next" } (list(&v.next)) }
    }
}

fn list(points: &[String]) -> Markup {
    html! { @if !points.is_empty() { ul { @for point in points { li { (words(point)) } } } } }
}

/// Commands and options as code.
fn words(text: &str) -> Markup {
    html! {
        @for (part, is_code) in parts(text) {
            @if is_code { code { (part) } } @else { (part) }
        }
    }
}

fn block(block: &Block<'_>, title: &str) -> Markup {
    match block {
        Block::Paragraph(text) => html! { p { (words(text)) } },
        Block::Note(text) => html! { p.note { (words(text)) } },
        Block::Equation(lines) => html! { p.equation { (lines) } },
        Block::Facts(facts) => html! {
            dl { @for (name, text) in facts { div { dt { (name) } dd { (words(text)) } } } }
        },
        Block::Table(t) => table(t, title),
        Block::Figure(f) => figure(f),
        Block::Code(language, _, code) => html! {
            h3 { (language) }
            pre role="region" aria-label=(language) tabindex="0" { (code) }
        },
        Block::Findings(all) => html! { ul.findings { @for r in all { (remark(r)) } } },
    }
}

fn remark(r: &Remark) -> Markup {
    let (class, sign, word) = if r.warning {
        ("warning", "!", "Warning")
    } else {
        ("note", "·", "Note")
    };
    html! {
        li.(class) {
            span.sign aria-hidden="true" { (sign) } " "
            span.vh { (word) ": " }
            code { (r.kind) } " " (words(&r.text))
        }
    }
}

/// A table that scrolls if it is wider than the page.
fn table(t: &Table, title: &str) -> Markup {
    let caption = Some(t.caption.as_str()).filter(|c| !c.is_empty());
    let class: Vec<Option<&str>> = (0..t.columns.len())
        .map(|i| t.is_numeric(i).then_some("n"))
        .collect();
    let groups: Vec<&[Column]> = t.columns.chunk_by(|a, b| a.group == b.group).collect();
    let (rows, more) = t.shown(Detail::Full);
    html! {
        div.scroll tabindex="0" role="region" aria-label=(caption.unwrap_or(title)) {
            table {
                caption class=[caption.is_none().then_some("vh")] { (caption.unwrap_or(title)) }
                thead {
                    @if groups.iter().any(|g| !g[0].group.is_empty()) {
                        tr {
                            @for group in &groups {
                                @if group[0].group.is_empty() {
                                    td colspan=(group.len()) {}
                                } @else {
                                    th scope="colgroup" colspan=(group.len()) { (group[0].group) }
                                }
                            }
                        }
                    }
                    tr {
                        @for (column, class) in t.columns.iter().zip(&class) {
                            th class=[*class] scope="col" { (column.name) }
                        }
                    }
                }
                tbody {
                    @for row in rows {
                        tr {
                            @if let Some(name) = row.first() { th scope="row" { (cell_text(name)) } }
                            @for (cell, class) in row.iter().zip(&class).skip(1) {
                                td class=[*class] { (cell_text(cell)) }
                            }
                        }
                    }
                }
            }
        }
        @if more > 0 { p.note { (left_out(more)) } }
    }
}

fn cell_text(c: &Cell) -> Markup {
    // With a typographic minus sign.
    let shown = |text: &str| text.replace('-', "−");
    match c {
        Cell::Text(text) => html! { (text) },
        Cell::Number(text, sd) => html! {
            (shown(text))
            @if let Some(sd) = sd { " " span.sd { "± " (shown(sd)) } }
        },
    }
}

fn figure(f: &Figure) -> Markup {
    html! {
        figure id={ "figure-" (f.name) } aria-label=(f.title) {
            figcaption { p { (f.caption) } }
            div.drawing { (PreEscaped(svg::standalone(f))) }
        }
    }
}
