//! Errors as text or JSON, and their exit codes.

use std::ffi::OsString;
use std::io::{self, IsTerminal, Write};
use std::num::{ParseFloatError, ParseIntError};
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue};
use gravical::Category;
use gravical::escape::{one_line, shown, shown_json};
use gravical_report::document::{flag, paragraph};
use serde::Serialize;

use crate::{text, words};

/// Exit code when a result failed a quality check.
pub const QUALITY: u8 = 4;

/// Exit code when the board, its port or the cable fails.
pub const DEVICE: u8 = 5;

/// Exit code when the user stopped an incomplete recording.
pub const INTERRUPTED: u8 = 130;

/// Exit code of a result that was computed.
pub fn quality(failed: bool) -> ExitCode {
    ExitCode::from(if failed { QUALITY } else { 0 })
}

/// An error as it is printed; as JSON for scripts.
#[derive(Serialize)]
pub struct RenderedError {
    #[serde(skip)]
    exit: u8,
    pub code: String,
    pub hint: Option<String>,
    pub message: String,
}

impl RenderedError {
    /// An error of gravical, with its exit code.
    pub fn own(error: &gravical::Error) -> Self {
        RenderedError {
            exit: match error.category() {
                Category::Usage => 2,
                Category::Input => 3,
                Category::System => 1,
                Category::Device => DEVICE,
            },
            code: error.code().to_owned(),
            hint: error.worded_hint(flag),
            message: error.worded(flag),
        }
    }

    /// Any error; one of others prints its chain of causes.
    pub fn new(error: &anyhow::Error) -> Self {
        let other = || RenderedError {
            exit: 1,
            code: "internal".to_owned(),
            hint: None,
            message: format!("{error:#}"),
        };
        let own = error.downcast_ref::<gravical::Error>();
        own.map_or_else(other, Self::own)
    }

    fn usage(message: String, hint: Option<&str>) -> Self {
        RenderedError {
            exit: 2,
            code: "usage".to_owned(),
            hint: hint.map(str::to_owned),
            message,
        }
    }

    /// Prints it with `--json` as a line of JSON on stdout, else in words on stderr. Returns its exit
    /// code.
    pub fn print(&self) -> ExitCode {
        let json = serde_json::json!(self).to_string();
        let is_printed = wants_json() && text::print(&(shown_json(&json) + "\n")).is_ok();
        if !is_printed {
            let mut words = line("error: ", &self.message);
            words.extend(self.hint.iter().map(|hint| line("  try: ", hint)));
            words += &format!("  code: {}\n", self.code);
            // If stderr cannot be written, nothing is left to report that.
            let _ = io::stderr().write_all(shown(&words).as_bytes());
        }
        ExitCode::from(self.exit)
    }
}

/// Also where the command line is not understood.
fn wants_json() -> bool {
    words::all().iter().any(|word| word == "--json")
}

/// A paragraph on a terminal, a whole line for log files.
fn line(first: &str, text: &str) -> String {
    if io::stderr().is_terminal() {
        paragraph(first, text)
    } else {
        format!("{first}{}\n", one_line(text))
    }
}

/// Prints `error` and returns its exit code. A closed pipe is none: the reader has finished.
pub fn report(error: &anyhow::Error) -> ExitCode {
    if is_broken_pipe(error) {
        return ExitCode::SUCCESS;
    }
    RenderedError::new(error).print()
}

/// Prints a usage error, or the help or version that was requested.
pub fn usage(error: &clap::Error) -> ExitCode {
    if let Some(refused) = refused(error) {
        return refused.print();
    }
    // A message of clap quotes the words of the user.
    let is_hostile = |word: &OsString| shown(&word.to_string_lossy()) != word.to_string_lossy();
    if error.use_stderr() && (wants_json() || words::all().iter().any(is_hostile)) {
        return of_clap(error).print();
    }
    let _ = error.print();
    ExitCode::from(if error.use_stderr() { 2 } else { 0 })
}

/// A message of clap: its lines before the tip and the usage, a list of arguments having one line
/// each.
fn of_clap(error: &clap::Error) -> RenderedError {
    let text = error.render().to_string();
    let lines = || text.lines().map(str::trim).filter(|l| !l.is_empty());
    let ends = ["tip: ", "Usage: ", "For more information"];
    let message: Vec<&str> = lines()
        .take_while(|line| !ends.iter().any(|end| line.starts_with(end)))
        .collect();
    let message = message.join(" ");
    let hint = lines().find_map(|l| l.strip_prefix("tip: "));
    RenderedError::usage(message.trim_start_matches("error: ").to_owned(), hint)
}

/// A value that an option refused, as an error of this program.
fn refused(error: &clap::Error) -> Option<RenderedError> {
    let context = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    let option = context(ContextKind::InvalidArg)?.split(' ').next()?;
    let value = context(ContextKind::InvalidValue)?;
    let cause = std::error::Error::source(error)?;
    if let Some(own) = cause.downcast_ref::<gravical::Error>() {
        return Some(RenderedError {
            exit: 2,
            message: format!("{option}: {}", own.worded(flag)),
            ..RenderedError::own(own)
        });
    }
    let is_number = cause.is::<ParseFloatError>() || cause.is::<ParseIntError>();
    let message = format!("{option}: {value} is not a number");
    let hint = value
        .contains(',')
        .then_some("write numbers with a point: 48.1");
    is_number.then(|| RenderedError::usage(message, hint))
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let mut causes = error.chain().filter_map(|e| e.downcast_ref::<io::Error>());
    causes.any(|cause| cause.kind() == io::ErrorKind::BrokenPipe)
}
