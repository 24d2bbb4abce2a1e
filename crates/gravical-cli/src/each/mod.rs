//! Many sessions in one run: `--each`.
//!
//! # Overview
//!
//! Each item is what the command alone would do with it, by the same code; nothing that happens to
//! one of them ends the run.
//!
//! ```text
//! arguments → items → workers: content, journal, job of the command → rows, in order of the items
//!                                                                       → lines, summary
//! ```
//!
//! An item ([`items`]) is a session or a recording. Its result depends only on its content
//! ([`content`]), the options ([`words`]) and the version of the program; the journal
//! ([`journal`]) stores these three with its row ([`row`]), which is how `--resume` knows what is
//! done. Rows are taken in the order of the items, whatever the number of threads ([`workers`]),
//! and none is kept: memory does not grow with the number of results. [`run`](run::run) is the
//! loop around all this; a command adds its [`Job`].

mod args;
mod content;
mod items;
mod journal;
mod row;
mod run;
mod summary;
mod words;
mod workers;

pub use args::EachArgs;
pub use items::Kind;
#[cfg(test)]
pub use row::tests::assert_columns;
pub use row::{Columns, Outcome, kinds};
pub use run::{Job, Plan, Work, run};
pub use words::Words;
