//! The innermost loops of reading and writing recordings: lines, decimal numbers.
//!
//! # Overview
//!
//! [`Lines`] cuts a byte stream into lines with flat memory, [`scan_number`] and
//! [`parse_field`] turn decimal text into `f64` exactly as the standard parser
//! does, [`write_fixed`] writes numbers with a given number of decimals. They
//! exist because reading is nine tenths of the run time on a long recording.
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

mod fixed;
mod lines;
mod number;

pub use fixed::write_fixed;
pub use lines::{Line, Lines, MAX_LINE};
pub use number::{parse_field, parse_field_decimal_comma, scan_number};
