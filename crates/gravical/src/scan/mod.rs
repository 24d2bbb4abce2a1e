//! The innermost loops of reading and writing recordings: lines, decimal numbers.
//!
//! # Overview
//!
//! [`Lines`] splits a byte stream into lines in memory that does not grow, [`scan_number`] and
//! [`parse_field`] convert decimal text to `f64` exactly as the standard parser, [`write_fixed`]
//! writes numbers with a fixed number of decimals. They are optimised because reading takes nine
//! tenths of the run time on a long recording.
//!
//! # Example
//!
//! ```
//! use gravical::scan::{Lines, scan_number, write_fixed};
//!
//! let mut lines = Lines::new(&b"9.81,0.02\r\n9.79,0.03"[..]);
//! let mut out = Vec::new();
//! while let Some(line) = lines.next_line()? {
//!     if let Some((value, _)) = scan_number(line.bytes) {
//!         write_fixed(&mut out, value / 9.80665, 4);
//!         out.push(b'\n');
//!     }
//! }
//! assert_eq!(out, b"1.0003\n0.9983\n");
//! # Ok::<(), std::io::Error>(())
//! ```

mod lines;
mod number;

pub use gravical_recording::write::{write_fixed, write_trimmed};
pub use lines::{Line, Lines, MAX_LINE};
pub use number::{parse_field, parse_field_decimal_comma, scan_number};
