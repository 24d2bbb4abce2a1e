//! Text of any dialect to columns, and what the columns say.
//!
//! # Overview
//!
//! 1. [`bytes`]: a path, plain or gzip, in any encoding, as UTF-8.
//! 2. [`sniff`]: the head of a file to its [`Format`]: dialect, roles of the columns, claims.
//! 3. [`Format::batches`]: lines to [`Batch`]es: rows as columns in the unit of the file.
//! 4. [`judge`]: functions over slices: clock, unit, encodings, defects, breaks.
//! 5. [`Recording`]: one batch that holds everything, and what was judged of it.
//! 6. [`write`]: batches to a table, other columns copied from the text of the rows.
//!
//! Rows and lines set aside ([`Aside`]) are all lines, always.
//!
//! # Example
//!
//! ```
//! use gravical_recording::{AccelUnit, Recording, bytes};
//!
//! let text = "ms,ax,ay,az\n0,0.01,-0.02,0.99\n10,0.01,-0.02,1.00\n20,0.00,-0.02,0.99\n";
//! let recording = Recording::read(bytes::utf8(text.as_bytes())?, "rest.csv")?;
//! assert_eq!(recording.accel_scale.unit, Some(AccelUnit::G));
//! assert_eq!(recording.time_s, [0.0, 0.01, 0.02]);
//! assert_eq!(recording.rows() + recording.aside.total(), 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(missing_docs)]

pub mod bytes;
mod error;
pub mod judge;
mod later;
mod note;
mod recording;
mod text;
mod units;
pub mod write;

pub use error::Error;
pub use later::{Channels, Contradicted, Contradiction, Later};
pub use note::Note;
pub use recording::{Labels, Recording};
pub use text::{
    Aside, BATCH_ROWS, Batch, Batches, Column, CopiedText, Format, Reason, Role, sniff,
};
pub use units::{AccelUnit, GyroUnit};
