//! The only place that knows text: a head to a [`Format`], lines to [`Batch`]es.

pub mod axes;
mod batch;
mod batches;
mod dialect;
mod format;
mod header;
mod lines;
mod names;
mod number;
mod roles;
mod sniff;
mod words;

pub(crate) use batch::check_bytes;
pub use batch::{AsideLines, Batch, CopiedText, Ledger, Reason};
pub(crate) use batches::BATCH_ROWS;
pub use batches::{Batches, split_hint};
pub use format::Format;
pub use names::Column;
pub(crate) use names::sensor_of_file;
pub(crate) use roles::sensor_unknown;
pub use sniff::{is_prose, sniff, sniff_table};
pub(crate) use sniff::{no_rows, no_table};
