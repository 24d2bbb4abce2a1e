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
//! An item ([`items`]) is a session or a recording. Its result depends only on its content,
//! the options ([`words`]) and the version of the program; the journal
//! ([`gravical::cohort`]) stores these three with its row, which is how `--resume` knows what is
//! done. Rows are taken in the order of the items, whatever the number of threads ([`workers`]),
//! and none is kept: memory does not grow with the number of results. [`run`](run::run) is the
//! loop around all this; a command adds its [`Job`].

mod args;
mod items;
mod run;
mod summary;
mod words;
mod workers;

pub use args::EachArgs;
pub use items::Kind;
pub use run::{Job, Plan, Work, run};
pub use summary::write_table;
pub use words::Words;

#[cfg(test)]
pub mod tests {
    use gravical::cohort::{Columns, Row, Status};
    use serde::{Deserialize, Serialize};

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    pub struct Length {
        pub length_m: f64,
    }

    impl Columns for Length {
        const NAMES: &'static [&'static str] = &["length_m"];
    }

    pub fn row(name: &str, length_m: Option<f64>) -> Row<Length> {
        Row {
            path: format!("in/{name}.csv"),
            verdict: Some("good".to_owned()),
            sha256: Some("00".to_owned()),
            values: length_m.map(|length_m| Length { length_m }),
            ..Row::of(name, Status::Done)
        }
    }
}
