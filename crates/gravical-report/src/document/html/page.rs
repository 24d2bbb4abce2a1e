//! The frame of a page.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::figure::svg;
use gravical::escape::shown;

/// Nothing is loaded, whatever a file name or label contains.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// The script without comments and indentation. It has no multi-line strings.
fn script() -> String {
    let lines = SCRIPT.lines().map(str::trim_start);
    let code = lines.filter(|l| !l.is_empty() && !l.starts_with("//"));
    code.flat_map(|l| [l, "\n"]).collect()
}

/// Anchor, heading and content of a section.
pub(super) type Part<'a> = (&'a str, &'a str, Markup);

/// The file.
pub(super) fn page(title: &str, lead: &Markup, sections: &[Part<'_>]) -> String {
    let dark = format!(
        "@media screen and (prefers-color-scheme:dark){{{}}}",
        svg::DARK
    );
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
                title { (title) }
                style { (PreEscaped(STYLE)) }
                // Of its own: a figure that is saved takes it along.
                style id="figures" { (PreEscaped(svg::STYLE)) }
                style { (PreEscaped(dark)) }
            }
            body {
                a.skip href="#main" { "Skip to the report" }
                header { (lead) }
                nav aria-label="Sections" {
                    ol { @for (id, title, _) in sections { li { a href={ "#" (id) } { (title) } } } }
                }
                main id="main" tabindex="-1" {
                    @for (id, title, body) in sections {
                        section id=(id) aria-labelledby={ (id) "-h" } {
                            h2 id={ (id) "-h" } { (title) }
                            (body)
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
