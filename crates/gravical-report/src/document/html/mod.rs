//! A document as one self-contained HTML file: no network, fonts or server; complete without
//! its script, too.

mod page;

use maud::{Markup, PreEscaped, html};

use super::inline::{self, Part};
use super::{
    Block, Cell, Column, DRAWINGS, Detail, Document, Grade, Remark, Row, Snippet, Table, Verdict,
};
use crate::figure::{Figure, svg};

impl Document<'_> {
    /// The whole document as a page. Tables have at most [`ROWS`](super::ROWS) rows, all figures
    /// together at most [`DRAWINGS`] bytes; a figure beyond that is replaced by its name.
    #[must_use]
    pub fn to_html(&self) -> String {
        let mut room = DRAWINGS;
        let verdict = self
            .verdict
            .iter()
            .map(|v| ("verdict", v.heading, verdict(v)));
        let sections = self.sections.iter().map(|s| {
            let blocks: Vec<Markup> = s
                .shown(Detail::Full)
                .map(|b| block(b, s.id, s.title, &mut room))
                .collect();
            (s.id, s.title, html! { @for block in blocks { (block) } })
        });
        let sections: Vec<page::Part<'_>> = verdict.chain(sections).collect();
        let lead = html! {
            h1 { (self.title) }
            @for line in self.lead() {
                p.sub { (line) }
            }
        };
        page::page(&self.title, &lead, &sections)
    }
}

/// Badge, main numbers, reasons, next steps.
fn verdict(v: &Verdict) -> Markup {
    let (class, sign) = match v.grade {
        Grade::Good => ("good", "✓"),
        Grade::Fair => ("fair", "~"),
        Grade::Poor => ("poor", "✗"),
        Grade::Unknown => ("unknown", "?"),
    };
    html! {
        p.badge.(class) { span.sign aria-hidden="true" { (sign) } " " strong { (v.word) } }
        @if !v.figures.is_empty() {
            div.tiles {
                @for f in &v.figures {
                    div.tile {
                        p.value { (shown(&f.value)) " " span.unit { (f.unit) } }
                        p.what { (f.what) }
                    }
                }
            }
        }
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
        @for part in inline::parts(text) {
            @match part { Part::Words(words) => (words), Part::Code(code) => code { (code) } }
        }
    }
}

fn block(block: &Block<'_>, id: &str, title: &str, room: &mut usize) -> Markup {
    match block {
        Block::Paragraph(text) => html! { p { (words(text)) } },
        Block::Note(text) => html! { p.note { (words(text)) } },
        Block::Heading(text) => html! { h3 { (text) } },
        Block::Equation(lines) => html! {
            p.equation { @for (i, line) in lines.iter().enumerate() { @if i > 0 { br; } (line) } }
        },
        Block::List(points) => list(points),
        Block::Facts(facts) => html! {
            dl { @for (name, text) in facts { div { dt { (name) } dd class=[name.is_empty().then_some("bar")] { (words(text)) } } } }
        },
        Block::Table(t) => table(t, title),
        Block::Figure(f) => figure(f, room),
        Block::Snippets(all) => snippets(id, all),
        Block::Findings(all) => html! { ul.findings { @for r in all { (remark(r)) } } },
    }
}

fn remark(r: &Remark) -> Markup {
    let (class, sign, word) = match r.warning {
        true => ("warning", "!", "Warning"),
        false => ("note", "·", "Note"),
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

/// Tabs, one per language, without a script.
fn snippets(id: &str, all: &[Snippet]) -> Markup {
    html! {
        div.tabs {
            @for (i, s) in all.iter().enumerate() {
                @let tab = format!("{id}-code-{i}");
                input type="radio" name={ (id) "-code" } id=(tab) checked[i == 0];
                label for=(tab) { (s.language) }
            }
            @for s in all {
                div.pane { pre.paste role="region" aria-label=(s.language) tabindex="0" { (s.code) } }
            }
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
    let head = |c: &Column, rows: &str| {
        html! { th class=[c.numbers.then_some("n")] scope="col" rowspan=(rows) { (c.name) } }
    };
    let left_out = t.all.saturating_sub(t.rows.len());
    html! {
        div.scroll tabindex="0" role="region" aria-label=(caption) {
            table {
                caption class=[t.caption.is_empty().then_some("vh")] { (caption) }
                thead {
                    tr {
                        @for group in t.columns.chunk_by(|a, b| !a.group.is_empty() && a.group == b.group) {
                            @match group {
                                [c, ..] if !c.group.is_empty() => th scope="colgroup" colspan=(group.len()) { (c.group) },
                                [c, ..] => (head(c, if grouped { "2" } else { "1" })),
                                [] => {}
                            }
                        }
                    }
                    @if grouped {
                        tr { @for c in t.columns.iter().filter(|c| !c.group.is_empty()) { (head(c, "1")) } }
                    }
                }
                tbody { @for r in &t.rows { (row(r, &t.columns)) } }
            }
        }
        @if left_out > 0 { p.note { "… and " (left_out) " more; " code { "--json" } " has all." } }
    }
}

fn row(r: &Row, columns: &[Column]) -> Markup {
    html! {
        tr class=[r.sum.then_some("sum")] {
            @for (i, (c, column)) in r.cells.iter().zip(columns).enumerate() {
                @if i == 0 { th scope="row" { (cell_text(c)) } } @else { (cell(c, column.numbers)) }
            }
        }
        @if !r.note.is_empty() { tr.reason { td colspan=(columns.len()) { (words(&r.note)) } } }
    }
}

fn cell(c: &Cell, numbers: bool) -> Markup {
    match c {
        Cell::Text(text) => html! { td class=[numbers.then_some("n")] { (text) } },
        Cell::Link(..) => html! { td { (cell_text(c)) } },
        Cell::Code(_) => html! { td.hash { (cell_text(c)) } },
        Cell::Number(..) => html! { td.n { (cell_text(c)) } },
    }
}

fn cell_text(c: &Cell) -> Markup {
    match c {
        Cell::Text(text) => html! { (text) },
        Cell::Link(text, target) => html! { a href=(target) { (text) } },
        Cell::Code(text) => html! { code { (text) } },
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
    let drawings = svg::inline(f);
    let size: usize = drawings.iter().map(String::len).sum();
    let fits = size <= *room;
    *room -= if fits { size } else { 0 };
    let id = format!("figure-{}", f.name);
    html! {
        figure id=(id) aria-labelledby={ (id) "-h" } {
            figcaption { h3 id={ (id) "-h" } { (f.title) } p { (f.caption) } }
            @if fits {
                div.drawings.beside[drawings.len() > 1] {
                    @for drawing in &drawings { div.drawing { (PreEscaped(drawing)) } }
                }
            } @else {
                p.note {
                    "This drawing would make the page too large; "
                    code { "--figures DIR" } " writes it as a file of its own."
                }
            }
        }
    }
}
