//! Printing: data to stdout, messages to stderr; a closed pipe is no error.

use std::io::{self, Write};
use std::path::Path;

use anstyle::{AnsiColor, Style};
use gravical::escape::{shown, shown_json};
use gravical::{Error, Result};
use serde::Serialize;

use crate::progress;

const GOOD: Style = AnsiColor::Green.on_default().bold();
const CAUTION: Style = AnsiColor::Yellow.on_default().bold();
const BAD: Style = AnsiColor::Red.on_default().bold();
const BOLD: Style = Style::new().bold();

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

/// What of a line fits into the terminal, with a column to spare for the cursor.
pub fn fit_terminal(line: &str) -> String {
    let columns = crossterm::terminal::size().map_or(80, |(columns, _)| usize::from(columns));
    let room = columns.max(20) - 1;
    if line.chars().count() <= room {
        return line.to_owned();
    }
    let start: String = line.chars().take(room - 1).collect();
    format!("{}…", start.trim_end())
}

/// Prints a report on stdout, in colour on a terminal.
///
/// # Errors
///
/// As [`print`].
pub fn print_report(text: &str) -> Result<()> {
    let out = anstream::AutoStream::auto(io::stdout().lock());
    print_to(out, &coloured(&shown(text)))
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
    let _ = writeln!(err, "{}", coloured(&shown(text)));
}

/// The same lines with verdicts, warnings and headings coloured. The writer removes colours for
/// `NO_COLOR`, pipes and files.
fn coloured(text: &str) -> String {
    let mut after_blank = false;
    let lines = text.split('\n').map(|line| {
        let coloured = one(line, after_blank);
        after_blank = line.is_empty();
        coloured
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn one(line: &str, after_blank: bool) -> String {
    if let Some(grade) = line.strip_prefix("Verdict: ") {
        let style = match grade {
            "good" | "agrees" | "usable" | "known" => GOOD,
            "poor" | "does-not-fit" | "differs" | "position-not-known" | "not-known" => BAD,
            _ => CAUTION,
        };
        return format!("{BOLD}Verdict:{BOLD:#} {style}{grade}{style:#}");
    }
    if let Some((kind, rest)) = line.strip_prefix("  ! ").and_then(|w| w.split_once(':')) {
        return format!("  {CAUTION}! {kind}:{CAUTION:#}{rest}");
    }
    // A heading ends before its unit or note.
    if after_blank && line.starts_with(|c: char| c.is_ascii_uppercase()) {
        let length = line.find([':', ',', '(']).unwrap_or(line.len());
        let (heading, rest) = line.split_at(length);
        return format!("{BOLD}{heading}{BOLD:#}{rest}");
    }
    line.to_owned()
}
