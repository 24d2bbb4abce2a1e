//! Printing: data to stdout, messages to stderr; a closed pipe is no error.

use std::io::{self, Write};
use std::path::Path;

use gravical::escape::{shown, shown_json};
use gravical::{Error, Result};
use serde::Serialize;

use crate::{colour, progress};

/// Prints `text` on stdout, control characters escaped.
///
/// # Errors
///
/// I/O errors, a closed pipe included.
pub fn print(text: &str) -> Result<()> {
    print_to(io::stdout().lock(), &shown(text))
}

fn print_to(mut out: impl Write, text: &str) -> Result<()> {
    progress::end();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    written.map_err(|e| Error::io(Path::new("standard output"), e))
}

/// Prints a report on stdout, in colour on a terminal.
///
/// # Errors
///
/// As [`print`].
pub fn print_report(text: &str) -> Result<()> {
    let out = anstream::AutoStream::auto(io::stdout().lock());
    print_to(out, &colour::report(&shown(text)))
}

/// Prints `value` as one JSON object on stdout.
///
/// # Errors
///
/// As [`print`].
pub fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    print(&shown_json(&text))?;
    Ok(())
}

/// Prints `text` on stderr; errors of that are ignored.
pub fn say(text: &str) {
    progress::end();
    let _ = writeln!(io::stderr(), "{}", shown(text));
}

/// Prints a report on stderr, in colour on a terminal.
pub fn say_report(text: &str) {
    progress::end();
    let mut err = anstream::AutoStream::auto(io::stderr().lock());
    let _ = writeln!(err, "{}", colour::report(&shown(text)));
}
