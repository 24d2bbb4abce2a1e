//! Printing: data to stdout, messages to stderr, a closed pipe is no panic.

use std::io::{self, Write};

use serde::Serialize;

use crate::colour;

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

/// Prints a report on stdout, in colour where that is seen.
///
/// # Errors
///
/// As [`print`].
pub fn print_report(text: &str) -> io::Result<()> {
    let mut out = anstream::AutoStream::auto(io::stdout().lock());
    out.write_all(colour::report(text).as_bytes())?;
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

/// Says `text` on stderr; when that is gone, nobody listens.
pub fn say(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Says a report on stderr, in colour where that is seen.
pub fn say_report(text: &str) {
    let mut err = anstream::AutoStream::auto(io::stderr().lock());
    let _ = writeln!(err, "{}", colour::report(text));
}
