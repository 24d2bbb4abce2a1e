//! Many recordings, each with its row: what runs over them write, and what all of them say together.
//!
//! ```text
//! runs (one machine, shards, an engine) → results and journals in one folder → collect → Cohort
//! ```
//!
//! The unit is one recording or session. Its result depends on its [content](Content), the options
//! and the version of the program ([`Origin`]) alone; a failure is a [row](Row), too. A [`Journal`]
//! stores the rows of one run; [`Gathered`] reads those of all runs. Where an engine (Dask, Ray, Spark)
//! distributes the items, each one is a [`Task`] that needs nothing but the folder.

mod collect;
mod content;
mod engine;
mod journal;
mod names;
mod row;
mod values;

pub use collect::{
    AnyValues, ChangedSensor, Cohort, CohortCounts, Distribution, ErrorCount, Gathered,
    OriginCount, WorstItem,
};
pub use content::{Content, not_twice, sha256_of};
pub use engine::{Task, TaskWork, Work};
pub use journal::{Beginning, FORMAT, Item, Journal, Line, List, Origin, Shard, journal_name};
pub use names::{Ending, ending_of, named};
pub use row::{COMMON, Columns, Outcome, Row, SEPARATOR, Status, columns, kinds};
pub use values::{
    ApplyValues, AxisColumns, COMMANDS, CalibrationValues, CheckValues, ColumnUnit, CommandColumns,
    NoiseValues,
};
