//! The page around the sections.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::figure::svg;
use crate::output::shown;

/// Nothing comes from elsewhere, whatever a file name or a label says.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// The script without comments and indentation. No text in it goes over a line.
pub(super) fn script() -> String {
    let lines = SCRIPT.lines().map(str::trim_start);
    let code = lines.filter(|l| !l.is_empty() && !l.starts_with("//"));
    code.flat_map(|l| [l, "\n"]).collect()
}

/// A part of the page with a heading.
pub(super) struct Section {
    /// Its anchor.
    pub id: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// What stands in it.
    pub body: Markup,
}

impl Section {
    pub fn new(id: &'static str, title: &'static str, body: Markup) -> Self {
        Section { id, title, body }
    }
}

/// The file.
pub(super) fn page(title: &str, lead: &Markup, sections: &[Section]) -> String {
    let dark = format!(
        "@media screen and (prefers-color-scheme:dark){{{}}}",
        svg::dark_rules()
    );
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                // Without it a browser asks the server for one.
                link rel="icon" href="data:,";
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(dark)) }
            }
            body {
                a.skip href="#main" { "Skip to the report" }
                header { (lead) }
                nav aria-label="Sections" {
                    ol { @for s in sections { li { a href={ "#" (s.id) } { (s.title) } } } }
                }
                main id="main" tabindex="-1" {
                    @for s in sections {
                        section id=(s.id) aria-labelledby={ (s.id) "-h" } {
                            h2 id={ (s.id) "-h" } { (s.title) }
                            (s.body)
                        }
                    }
                }
                script { (PreEscaped(script())) }
            }
        }
    }
    .into_string();
    shown(&page).into_owned()
}

/// A number that matters, large, with what it is below it.
pub(super) fn tile(value: &Markup, unit: &str, what: &str) -> Markup {
    html! {
        div.tile { p.value { (value) " " span.unit { (unit) } } p.what { (what) } }
    }
}

/// A verdict: word, sign and colour.
pub(super) fn badge(class: &str, sign: &str, word: &str) -> Markup {
    html! { p.badge.(class) { span.sign aria-hidden="true" { (sign) } " " strong { (word) } } }
}

/// Name and value in pairs.
pub(super) fn list(rows: &[(&str, Markup)]) -> Markup {
    html! { dl { @for (name, value) in rows { div { dt { (name) } dd { (value) } } } } }
}
