//! Text of any dialect, or blocks of a worn device, to columns, and what the columns say.
//!
//! # Overview
//!
//! 1. [`bytes`]: a path, plain or gzip, in any encoding, as UTF-8.
//! 2. [`sniff`]: the head of a file to its [`Format`]: dialect, roles of the columns, claims.
//! 3. [`Format::batches`]: lines to [`Batch`]es: rows as columns in the unit of the file.
//!    [`cwa::open`] does both for a file of Axivity.
//! 4. [`judge`]: functions over slices: clock, unit, encodings, defects, breaks.
//! 5. [`Recording`]: one batch that holds everything, and what was judged of it.
//! 6. [`write`](mod@write): batches to a table, other columns copied from the text of the rows.
//!
//! Rows and lines set aside ([`Aside`]) are all lines, always.
//!
//! # Example
//!
//! ```
//! use gravical_recording::{AccelUnit, ReadOptions, Recording, bytes};
//!
//! let text = "ms,ax,ay,az\n0,0.01,-0.02,0.99\n10,0.01,-0.02,1.00\n20,0.00,-0.02,0.99\n";
//! let recording = Recording::read(bytes::utf8(text.as_bytes())?, "rest.csv", &ReadOptions::default())?;
//! assert_eq!(recording.accel_scale.unit, AccelUnit::StandardGravity);
//! assert_eq!(recording.time_s, Some(vec![0.0, 0.01, 0.02]));
//! assert_eq!(recording.rows() + recording.aside.total(), 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(missing_docs)]

mod board;
pub mod bytes;
pub mod cwa;
mod date;
mod error;
pub mod escape;
mod follow;
pub mod full_scale;
pub mod judge;
mod later;
pub mod metadata;
mod note;
mod options;
mod recording;
mod role;
mod spans;
mod table;
mod text;
mod time_unit;
pub mod units;
pub mod write;

pub use board::BoardSettings;
pub use error::{Category, Error, Location, Result};
pub use follow::{Follow, Form, LinesRead, Sample};
pub use judge::UnitDoubt;
pub use later::{Later, Readings};
pub use note::{Note, NoteKind};
pub use options::{ColumnChoice, ColumnsSpec, ReadOptions};
pub use recording::{CALIBRATED, HEAD_BYTES, Labels, Recording, Timing, open_text, whole_lines};
pub use role::Role;
pub use spans::{LineSpans, format_spans};
pub use table::{TableColumn, table_channels};
pub use text::axes;
#[doc(hidden)]
pub use text::parse_cell;
pub use text::{
    Aside, AsideLines, Batch, Batches, Column, CopiedText, Format, Reason, is_prose, sniff,
    sniff_table, split_hint,
};
pub use time_unit::TimeUnit;
pub use units::POSSIBLE;
pub use units::{AccelScale, AccelUnit, GyroScale, GyroUnit, Origin};
