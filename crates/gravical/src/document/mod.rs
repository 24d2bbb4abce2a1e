//! One document for each result, and three ways to write it.
//!
//! A [`Document`] holds what is said about a result: sentences, tables of numbers,
//! figures, findings, a verdict. [`Document::to_text`] writes it for a terminal of 80
//! columns, [`Document::to_html`] as a page that needs nothing else, and
//! [`Document::to_markdown`] for a report of one's own. [`report`](crate::report) makes the
//! documents. A rendering may hold less than another one ([`Detail`]), never another
//! number or sentence.
//!
//! # Example
//!
//! ```
//! use gravical::document::{Cell, Column, Detail, Document, Section, Table};
//!
//! let table = Table::new("")
//!     .columns([Column::left("axis"), Column::number("bias, m/s²")])
//!     .row([Cell::text("x"), Cell::number("/bias/0", 0.02134, "0.0213")]);
//! let document = Document::new("Calibration").with(Section::new("bias", "Bias").with(table));
//! assert_eq!(document.to_text(Detail::Summary), "\nBias\n  axis  bias, m/s²\n  x         0.0213\n");
//! ```

mod findings;
mod html;
mod markdown;
mod model;
pub mod number;
mod text;

#[cfg(test)]
mod tests;

pub use findings::Remark;
pub(crate) use findings::short_name;
pub use model::{
    Block, Cell, Column, Detail, Document, Grade, KeyFigure, Quantity, Row, Section, Snippet,
    Table, Verdict,
};
pub use text::paragraph;

/// Rows of a table that a document holds at most.
pub const ROWS: usize = 200;

/// Bytes of all drawings of a page.
pub const DRAWINGS: usize = 4_000_000;
