//! A document as one self-contained HTML file: no network, fonts or server; complete without
//! its script, too.

use gravical::calibration_file::Grade;
use gravical::escape;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{
    Block, Cell, Column, Detail, Document, HOW, Place, Remark, Section, Step, Table, Verdict,
    capital, left_out, parts,
};
use crate::figure::{draw, signs};
use crate::style;

/// Nothing is loaded, and no script runs but [`SCRIPT`], whatever a file name or label contains. The test in a browser
/// says the hash of a script that was changed.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; \
    script-src 'sha256-P5Yz5JDRhmVTHjT8e5jWdDGw8lPZFIzUavd3bMEdxRE='";

/// Reasons that a page shows with the verdict where all stand below "How do you know?".
const PROOFS: usize = 2;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

impl Document<'_> {
    /// The whole document as a page: certificate, verdict with its chart, tables, figures, what is folded, foot.
    pub fn to_html(&self) -> String {
        let mark = self.verdict.as_ref().map_or("note", mark);
        let is_drawn = self.has_board();
        let placed = |at: fn(&Place) -> bool| self.sections.iter().filter(move |s| at(&s.place));
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
                    style { (PreEscaped(style::SHARED)) @if is_drawn { (PreEscaped(style::BOARD)) } (PreEscaped(STYLE)) }
                }
                body {
                    a.skip href="#main" { "Skip to the result" }
                    @if is_drawn { (PreEscaped(style::SHEET)) }
                    header {
                        h1 { strong { "gravical" } " " (self.title) }
                        @if self.certificate.is_empty() { @for line in &self.subject { p { (line) } } }
                    }
                    main id="main" tabindex="-1" data-mark=(mark) {
                        @if !self.certificate.is_empty() { (certificate(&self.certificate)) }
                        @if let Some(v) = &self.verdict {
                            @let beside = placed(|p| matches!(p, Place::Card(_))).next().map(|s| &s.place);
                            @let wide = if beside == Some(&Place::Card(7)) { 5 } else { 12 };
                            (verdict(v, self.sections.iter().any(|s| s.title == HOW), wide))
                        }
                        @for s in placed(|p| matches!(p, Place::Card(_))) { (card(s)) }
                        @if placed(|p| matches!(p, Place::Fold(_))).next().is_some() {
                            div.card.folds { @for s in placed(|p| matches!(p, Place::Fold(_))) { (fold(s, self.verdict.as_ref())) } }
                        }
                    }
                    footer {
                        p { "Every ± and every “within” is 95 % (k = 2), unless it says otherwise." }
                        @for s in placed(|p| matches!(p, Place::Foot)) { (foot(s)) }
                    }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        };
        escape::shown(&page.into_string()).into_owned()
    }
}

impl Document<'_> {
    /// Whether a board is drawn anywhere.
    fn has_board(&self) -> bool {
        let steps = self.verdict.iter().flat_map(|v| &v.next);
        let mut blocks = self.sections.iter().flat_map(|s| &s.blocks);
        blocks.any(|(_, b)| matches!(b, Block::Board(..))) || { steps }
            .any(|step| matches!(step, Step::Pose(_)))
    }
}

/// Which colour and sign it has.
fn mark(v: &Verdict) -> &'static str {
    match v.grade {
        _ if v.word.is_empty() => "note",
        Grade::Good => "good",
        Grade::Fair => "fair",
        Grade::Poor => "poor",
        Grade::NotVerifiable => "open",
    }
}

fn certificate(entries: &[[String; 3]]) -> Markup {
    html! {
        dl.card.cert role="group" aria-label="Certificate" {
            @for [name, value, remark] in entries {
                div {
                    dt { (name) }
                    dd { (signs(value)) @if !remark.is_empty() { " " small { (signs(remark)) } } }
                }
            }
        }
    }
}

/// Word, one number, its proof, other numbers, what to do next; `wide` of twelve columns. Reasons that stand below "How
/// do you know?" are not all said here.
fn verdict(v: &Verdict, is_explained: bool, wide: u8) -> Markup {
    let most = if is_explained {
        PROOFS
    } else {
        v.reasons.len()
    };
    let reasons = v.reasons.iter().take(most);
    let proof: Vec<&String> = match &v.proof[..] {
        [] => reasons.collect(),
        proof => proof.iter().collect(),
    };
    let [headline, small] = &v.headline;
    let class = format!("card verdict w{wide}");
    html! {
        section class=(class) data-mark=(mark(v)) aria-labelledby="verdict" {
            @if !v.word.is_empty() { p.mark.pill { (v.word.replace('-', " ")) } }
            h2 id="verdict" {
                (unbroken(&signs(headline)))
                @if !small.is_empty() { " " small { (signs(small)) } }
            }
            @for text in proof { p { (words(&capital(text))) } }
            @if !v.numbers.is_empty() {
                div.numbers { @for [value, what] in &v.numbers { p { b { (signs(value)) } span { (what) } } } }
            }
            @if !v.next.is_empty() {
                div.next { h3 { "Next" } ol { @for step in &v.next { (self::step(step)) } } }
            }
        }
    }
}

/// What to do; a command is there to be copied, a pose is drawn.
fn step(step: &Step) -> Markup {
    let (text, command) = step.in_words();
    html! {
        @if let Step::Pose(up) = step {
            li.pose { span { (words(&text)) } (style::board(style::lying(*up), None)) }
        } @else {
            li { (words(&text)) @if let Some(command) = command { div.command { code { (command) } } } }
        }
    }
}

/// A section in sight. A figure has its own heading.
fn card(s: &Section<'_>) -> Markup {
    let Place::Card(width) = s.place else {
        return html! {};
    };
    let class = format!("card w{width}");
    let own = matches!(s.blocks.first(), Some((_, Block::Figure(_))));
    html! {
        section class=(class) id=[(!own).then(|| anchor(s.title))] {
            @if !own { div.head { h2 { (s.title) } } }
            (blocks(s))
        }
    }
}

/// A section that opens; that of the method has the reasons of the verdict.
fn fold(s: &Section<'_>, verdict: Option<&Verdict>) -> Markup {
    let Place::Fold(note) = &s.place else {
        return html! {};
    };
    html! {
        details id=(anchor(s.title)) {
            summary { h2 { (s.title) } @if !note.is_empty() { span.note { (note) } } }
            @if let Some(v) = verdict.filter(|_| s.title == HOW) {
                ul { @for reason in &v.reasons { li { (words(&capital(reason))) } } }
            }
            (blocks(s))
        }
    }
}

fn foot(s: &Section<'_>) -> Markup {
    html! {
        @for b in s.shown(Detail::Full) {
            @if let Block::Facts(facts) = b {
                @for (name, text) in facts { p { (name) " " (words(text)) } }
            }
        }
    }
}

fn anchor(title: &str) -> String {
    format!("section-{}", title.to_lowercase().replace([' ', '?'], "-"))
}

/// The blocks of a section; languages of code are tabs.
fn blocks(s: &Section<'_>) -> Markup {
    let shown: Vec<&Block<'_>> = s.shown(Detail::Full).collect();
    let is_code = |b: &&Block<'_>| matches!(b, Block::Code(..));
    html! {
        @for run in shown.chunk_by(|a, b| is_code(a) && is_code(b)) {
            @if is_code(&run[0]) { (tabs(run)) } @else { (block(run[0], s.title)) }
        }
    }
}

fn tabs(all: &[&Block<'_>]) -> Markup {
    html! {
        div.tabs role="group" aria-label="Language" {
            @for (i, b) in all.iter().enumerate() {
                @if let Block::Code(language, code) = b {
                    @let id = format!("code-{i}");
                    input.unseen type="radio" name="code" id=(id) checked[i == 0];
                    label for=(id) { (language) }
                    pre tabindex="0" { (code) }
                }
            }
        }
    }
}

/// Commands and options as code.
fn words(text: &str) -> Markup {
    html! {
        @for (part, is_code) in parts(text) {
            @if is_code { code { (part) } } @else { (signs(part)) }
        }
    }
}

/// A number stays with its unit, and with its ±.
fn unbroken(text: &str) -> String {
    let words: Vec<&str> = text.split(' ').collect();
    let number = |word: &str| word.ends_with(|c: char| c.is_ascii_digit()) || word == "±";
    let mut out = String::new();
    for (i, word) in words.iter().enumerate() {
        out += match i {
            0 => "",
            i if number(words[i - 1]) => "\u{a0}",
            _ => " ",
        };
        out += word;
    }
    out
}

fn block(block: &Block<'_>, title: &str) -> Markup {
    match block {
        Block::Paragraph(text) => html! { p { (words(text)) } },
        Block::Note(text) => html! { p.note { (words(text)) } },
        Block::Equation(lines) => html! { p.equation { (lines) } },
        Block::Facts(facts) => html! {
            dl.facts { @for (name, text) in facts { div { dt { (name) } dd { (words(text)) } } } }
        },
        Block::Table(t) => table(t, title),
        Block::Figure(f) => draw::figure(f),
        Block::Board(angles, figure) => style::board(*angles, Some(figure)),
        Block::Code(language, code) => html! { h3 { (language) } pre { (code) } },
        Block::Findings(all) => html! { ul.findings { @for r in all { (remark(r)) } } },
    }
}

fn remark(r: &Remark) -> Markup {
    let (mark, word) = if r.warning {
        ("fair", "Warning")
    } else {
        ("note", "Note")
    };
    html! {
        li.mark data-mark=(mark) {
            span { span.unseen { (word) ": " } (words(&r.text)) " " code { (r.kind) } }
        }
    }
}

/// A table that scrolls if it is wider than the page.
fn table(t: &Table, title: &str) -> Markup {
    let class: Vec<Option<&str>> = (0..t.columns.len())
        .map(|i| t.is_numeric(i).then_some("n"))
        .collect();
    let groups: Vec<&[Column]> = t.columns.chunk_by(|a, b| a.group == b.group).collect();
    let (rows, more) = t.shown(Detail::Full);
    html! {
        @if !t.caption.is_empty() { div.head { h3 { (t.caption) } } }
        div.table.stack[t.columns.len() > 7] tabindex="0" role="region" aria-label=(if t.caption.is_empty() { title } else { &t.caption }) {
            table data-sort[t.is_sortable] aria-label=(if t.caption.is_empty() { title } else { &t.caption }) {
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
                                @if let Cell::Share(share) = cell {
                                    td.share {
                                        span { (format!("{share:.0}")) }
                                        i style={ "--share:" (format!("calc(({share:.1}%) * .7)")) } {}
                                    }
                                } @else {
                                    td class=[*class] { (cell_text(cell)) }
                                }
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
        Cell::Text(text) => html! { (signs(text)) },
        Cell::Share(share) => html! { (format!("{share:.0}")) },
        Cell::Link(text, address) => html! { a href=(address) { (text) } },
        Cell::Number(text, sd) => html! {
            (shown(text))
            @if let Some(sd) = sd { " " small { "± " (shown(sd)) } }
        },
    }
}
