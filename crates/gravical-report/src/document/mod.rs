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
//! use gravical_report::document::{Cell, Column, Detail, Document, Section, Table};
//!
//! let table = Table::new("")
//!     .columns(["axis", "bias, m/s²"])
//!     .row([Cell::text("x"), Cell::number("0.0213")]);
//! let document = Document::new("Calibration").with(Section::new("bias", "Bias").with(table));
//! assert_eq!(document.to_text(Detail::Summary), "\nBias\n  axis  bias, m/s²\n  x         0.0213\n");
//! ```

mod findings;
mod html;
mod inline;
mod markdown;
mod model;
mod text;

#[cfg(test)]
mod tests;

pub(crate) use findings::short_name;
#[doc(hidden)]
pub use findings::{Remark, flag};
#[doc(hidden)]
pub use model::{Block, Cell, Column, Row, Section, Snippet, Table};
pub use model::{Detail, Document, Grade, Verdict};
#[doc(hidden)]
pub use text::paragraph;

/// Largest number of rows of a table.
#[doc(hidden)]
pub const ROWS: usize = 200;

/// Largest size of all figures of a page, bytes.
#[doc(hidden)]
pub const DRAWINGS: usize = 4_000_000;
