//! A document as one self-contained HTML file: no network, fonts or server; complete without
//! its script, too.

use gravical::escape;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::inline::parts;
use super::{Block, Cell, DRAWINGS, Detail, Document, Grade, Remark, Table, Verdict};
use crate::figure::{Figure, svg};

/// Nothing is loaded, whatever a file name or label contains.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

impl Document<'_> {
    /// The whole document as a page. Tables have at most [`ROWS`](super::ROWS) rows, all figures
    /// together at most [`DRAWINGS`] bytes; a figure beyond that is replaced by its name.
    #[must_use]
    pub fn to_html(&self) -> String {
        let mut room = DRAWINGS;
        let verdict = self.verdict.iter();
        let verdict = verdict.map(|v| ("verdict", "Verdict", verdict_html(v)));
        let sections = self.sections.iter().map(|s| {
            let blocks = s.shown(Detail::Full);
            let blocks = blocks.map(|b| block(b, s.title, &mut room).into_string());
            (s.id, s.title, PreEscaped(blocks.collect()))
        });
        // Anchor, heading and content.
        let sections: Vec<(&str, &str, Markup)> = verdict.chain(sections).collect();
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    // Prevents a request for /favicon.ico.
                    link rel="icon" href="data:,";
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) }
                    // Of its own: a figure that is saved takes it along.
                    style id="figures" { (PreEscaped(svg::STYLE)) }
                    style { "@media screen and (prefers-color-scheme:dark){" (PreEscaped(svg::DARK)) "}" }
                }
                body {
                    a.skip href="#main" { "Skip to the report" }
                    header {
                        h1 { (self.title) }
                        @for line in self.lead() { p.sub { (line) } }
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
fn verdict_html(v: &Verdict) -> Markup {
    let (class, sign) = match v.grade {
        Grade::Good => ("good", "✓"),
        Grade::Fair => ("fair", "~"),
        Grade::Poor => ("poor", "✗"),
        Grade::Unknown => ("unknown", "?"),
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

fn block(block: &Block<'_>, title: &str, room: &mut usize) -> Markup {
    match block {
        Block::Paragraph(text) => html! { p { (words(text)) } },
        Block::Note(text) => html! { p.note { (words(text)) } },
        Block::Equation(lines) => html! {
            p.equation { @for (i, line) in lines.iter().enumerate() { @if i > 0 { br; } (line) } }
        },
        Block::Facts(facts) => html! {
            dl { @for (name, text) in facts { div { dt { (name) } dd { (words(text)) } } } }
        },
        Block::Table(t) => table(t, title),
        Block::Figure(f) => figure(f, room),
        Block::Snippets(all) => html! {
            @for (i, s) in all.iter().enumerate() {
                details open[i == 0] {
                    summary { (s.language) }
                    pre.paste role="region" aria-label=(s.language) tabindex="0" { (s.code) }
                }
            }
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
            @if !r.place.is_empty() { span.where { " [" (r.place) "]" } }
        }
    }
}

/// A table that scrolls if it is wider than the page.
fn table(t: &Table, title: &str) -> Markup {
    let caption = if t.caption.is_empty() {
        title
    } else {
        &t.caption
    };
    let grouped = t.columns.iter().any(|c| !c.group.is_empty());
    let numeric: Vec<bool> = (0..t.columns.len()).map(|i| t.is_numeric(i)).collect();
    let head = |i: usize, rows: &str| {
        html! { th class=[numeric[i].then_some("n")] scope="col" rowspan=(rows) { (t.columns[i].name) } }
    };
    let in_group = |i: &usize| !t.columns[*i].group.is_empty();
    let indices: Vec<usize> = (0..t.columns.len()).collect();
    let left_out = t.all.saturating_sub(t.rows.len());
    html! {
        div.scroll tabindex="0" role="region" aria-label=(caption) {
            table {
                caption class=[t.caption.is_empty().then_some("vh")] { (caption) }
                thead {
                    tr {
                        @for group in indices.chunk_by(|a, b| in_group(a) && t.columns[*a].group == t.columns[*b].group) {
                            @if in_group(&group[0]) {
                                th scope="colgroup" colspan=(group.len()) { (t.columns[group[0]].group) }
                            } @else {
                                (head(group[0], if grouped { "2" } else { "1" }))
                            }
                        }
                    }
                    @if grouped {
                        tr { @for i in indices.iter().filter(|i| in_group(i)) { (head(*i, "1")) } }
                    }
                }
                tbody {
                    @for row in &t.rows {
                        tr {
                            @for (i, cell) in row.cells.iter().enumerate() {
                                @if i == 0 {
                                    th scope="row" { (cell_text(cell)) }
                                } @else {
                                    td class=[numeric[i].then_some("n")] { (cell_text(cell)) }
                                }
                            }
                        }
                        @if !row.note.is_empty() {
                            tr.reason { td colspan=(t.columns.len()) { (words(&row.note)) } }
                        }
                    }
                }
            }
        }
        @if left_out > 0 { p.note { "… and " (left_out) " more; " code { "--json" } " has all." } }
    }
}

fn cell_text(c: &Cell) -> Markup {
    match c {
        Cell::Text(text) => html! { (text) },
        Cell::Number(text, sd) => html! {
            (shown(text))
            @if let Some(sd) = sd { " " span.sd { "± " (shown(sd)) } }
        },
    }
}

/// With a typographic minus sign.
fn shown(text: &str) -> String {
    text.replace('-', "−")
}

fn figure(f: &Figure, room: &mut usize) -> Markup {
    let drawing = svg::inline(f);
    let fits = drawing.len() <= *room;
    *room -= if fits { drawing.len() } else { 0 };
    let id = format!("figure-{}", f.name);
    html! {
        figure id=(id) aria-labelledby={ (id) "-h" } {
            figcaption { h3 id={ (id) "-h" } { (f.title) } p { (f.caption) } }
            @if fits {
                div.drawing { (PreEscaped(drawing)) }
            } @else {
                p.note {
                    "This drawing would make the page too large; "
                    code { "--figures DIR" } " writes it as a file of its own."
                }
            }
        }
    }
}
