//! Printing: data to stdout, messages to stderr, a closed pipe is no panic.

use std::io::{self, Write};

use serde::Serialize;

/// Prints `text` on stdout.
///
/// # Errors
///
/// What writing says; a closed pipe is told apart by the caller.
pub fn print(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()
}

/// Prints `value` as one JSON object on stdout.
///
/// # Errors
///
/// As [`print`].
pub fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    print(&text)?;
    Ok(())
}
