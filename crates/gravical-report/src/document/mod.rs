//! A document for each result, with three renderings.
//!
//! A [`Document`] consists of sentences, tables of numbers, figures, findings and a verdict.
//! [`Document::to_text`] renders it for a terminal of 80 columns, [`Document::to_html`] as a
//! self-contained page, [`Document::to_markdown`] for use in other reports.
//! [`report`](crate::report) builds the documents. Renderings differ in their amount
//! ([`Detail`]), not in numbers or sentences.
//!
//! # Example
//!
//! ```
//! use gravical_report::document::{Cell, Detail, Document, Section, Table};
//!
//! let table = Table::new("", ["axis", "bias, m/s²"])
//!     .row("x", [Cell::number("0.0213")]);
//! let document = Document::new("Calibration").with(Section::new("Bias").with(table));
//! assert_eq!(document.to_text(Detail::Summary), "\nBias\n  axis  bias, m/s²\n  x         0.0213\n");
//! ```

mod findings;
mod html;
mod markdown;
mod model;
mod text;

#[cfg(test)]
mod tests;

pub(crate) use findings::short_name;
#[doc(hidden)]
pub use findings::{Remark, flag};
#[doc(hidden)]
pub use model::{Block, Cell, Column, Section, Table};
pub use model::{Detail, Document, Verdict};
#[doc(hidden)]
pub use text::paragraph;

/// The parts of a sentence, in order, and whether they are code: commands and options are between
/// backticks. A backtick without its second is text.
fn parts(text: &str) -> impl Iterator<Item = (&str, bool)> {
    let paired = text.matches('`').count() / 2 * 2;
    let parts = text.splitn(paired + 1, '`').enumerate();
    let parts = parts.map(|(i, part)| (part, i % 2 == 1));
    parts.filter(|(part, _)| !part.is_empty())
}
