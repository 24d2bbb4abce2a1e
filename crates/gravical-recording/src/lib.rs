//! Text of any dialect, or blocks of a worn device, to columns, and what the columns say.
//!
//! The API is internal to gravical and may change.
//!
//! # Overview
//!
//! 1. [`source`]: a path, standard input or bytes; [`bytes`]: unpacked; [`encoding`]: as UTF-8;
//!    [`read`](read()) does all of the following.
//! 2. [`sniff`]: the head of a file to its [`Format`]: dialect, roles of the columns, claims.
//! 3. [`Format::parse`]: lines to [`Rows`]: columns in the unit of the file. `cwa` does both for a
//!    file of Axivity.
//! 4. [`gravical_judge`]: functions over slices: clock, unit, encodings, defects, breaks.
//! 5. [`Recording`]: the rows, and what was judged of them.
//! 6. [`Stream`]: a recording judged by its head, with the text of its other columns, for
//!    [`write`](mod@write): rows to a table.
//!
//! Rows and lines set aside ([`Ledger`]) are all lines, always.
//!
//! # Example
//!
//! ```
//! use gravical_recording::{AccelUnit, ReadOptions, read_bytes};
//!
//! let text = "ms,ax,ay,az\n0,0.01,-0.02,0.99\n10,0.01,-0.02,1.00\n20,0.00,-0.02,0.99\n";
//! let recording = read_bytes(text.as_bytes(), "rest.csv", &ReadOptions::default())?;
//! assert_eq!(recording.units.accel.unit, AccelUnit::StandardGravity);
//! assert_eq!(recording.time_s, Some(vec![0.0, 0.01, 0.02]));
//! assert_eq!(recording.rows() + recording.ledger.total(), 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(missing_docs)]

mod board;
pub mod bytes;
mod cwa;
mod date;
pub mod encoding;
mod follow;
mod foreign;
#[doc(hidden)]
pub mod hash;
mod join;
mod judging;
mod memory;
mod metadata;
#[doc(hidden)]
pub mod output;
mod problem;
mod read;
mod recording;
pub mod source;
mod stream;
mod table;
mod text;
pub mod write;

pub use board::BoardSettings;
pub use follow::{Follow, Form, LineKind, Sample};
pub use gravical_judge::units::{AccelUnit, GyroUnit, Origin, TimeUnit};
pub use gravical_judge::{Error, Finding, ReadOptions, Result};
pub use join::{holds_gyroscope_alone, is_named_gyroscope, join_gyroscope, read_joined};
#[doc(hidden)]
pub use memory::max_bytes;
pub use read::{read, read_bytes, read_head, read_named, read_samples};
pub use recording::{Clock, JoinedFile, Labels, ReadAs, Recording};
pub use stream::{Piece, Stream};
pub use table::TableColumn;
pub use text::{
    AsideLines, CALIBRATED, Column, CopiedText, Format, Ledger, Reason, Rows, is_prose, sniff,
};
