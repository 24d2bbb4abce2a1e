//! The only place that knows text: a head to a [`Format`], lines to [`Rows`].

mod dialect;
mod format;
mod header;
mod lines;
mod names;
mod number;
mod parse;
mod roles;
mod rows;
mod sniff;
mod words;

pub(crate) use format::StampPart;
pub use format::{CALIBRATED, Format};
pub(crate) use lines::LineBlocks;
pub use names::Column;
pub(crate) use names::sensor_of_file;
pub(crate) use parse::Parser;
pub use rows::{AsideLines, CopiedText, Ledger, Reason, Rows};
pub use sniff::{is_prose, sniff};
pub(crate) use words::Heading;
