//! Errors as text or JSON, and their exit codes.

use std::ffi::OsString;
use std::io::{self, IsTerminal, Write};
use std::num::{ParseFloatError, ParseIntError};
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue};
use gravical::Category;
use gravical::escape::{one_line, shown, shown_json};
use gravical_report::document::{flag, paragraph};

use crate::text;

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

/// An error as it is printed.
pub struct RenderedError {
    /// The exit code.
    pub exit: u8,
    /// For scripts.
    pub object: serde_json::Value,
    /// For people, in whole lines.
    pub text: String,
}

impl RenderedError {
    fn new(exit: u8, code: &str, message: &str, hint: Option<&str>) -> Self {
        let mut text = line("error: ", message);
        text.extend(hint.map(|hint| line("  try: ", hint)));
        text.push_str(&format!("  code: {code}\n"));
        RenderedError {
            exit,
            object: serde_json::json!({ "code": code, "message": message, "hint": hint }),
            text: shown(&text).into_owned(),
        }
    }

    /// None for a closed pipe: the reader has finished.
    pub fn of(error: &anyhow::Error) -> Option<Self> {
        if is_broken_pipe(error) {
            return None;
        }
        // Our own errors are complete; others print their chain of causes.
        let Some(own) = error.downcast_ref::<gravical::Error>() else {
            return Some(Self::new(1, "internal", &format!("{error:#}"), None));
        };
        let exit = match own.category() {
            Category::Usage => 2,
            Category::Input => 3,
            Category::Contradiction => 4,
            Category::System => 1,
            Category::Device => DEVICE,
        };
        let (message, hint) = (own.worded(flag), own.worded_hint(flag));
        Some(Self::new(exit, own.code(), &message, hint.as_deref()))
    }

    /// Prints it with `--json` as a line of JSON on stdout, else in words on stderr. Returns its exit
    /// code.
    fn print(&self) -> ExitCode {
        let line = format!("{}\n", shown_json(&self.object.to_string()));
        let printed = wants_json() && text::print(&line).is_ok();
        // If stderr cannot be written, nothing is left to report that.
        if !printed {
            let _ = io::stderr().write_all(self.text.as_bytes());
        }
        ExitCode::from(self.exit)
    }
}

/// Also where the command line is not understood.
fn wants_json() -> bool {
    std::env::args_os().any(|word| word == "--json")
}

/// A paragraph on a terminal, a whole line for log files.
fn line(first: &str, text: &str) -> String {
    if io::stderr().is_terminal() {
        paragraph(first, text)
    } else {
        format!("{first}{}\n", one_line(text))
    }
}

/// Prints `error` and returns its exit code.
pub fn report(error: &anyhow::Error) -> ExitCode {
    match RenderedError::of(error) {
        Some(rendered) => rendered.print(),
        None => ExitCode::SUCCESS,
    }
}

/// Prints a usage error, or the help or version that was requested.
pub fn usage(error: &clap::Error) -> ExitCode {
    let exit = u8::try_from(error.exit_code()).unwrap_or(2);
    if let Some(refused) = refused(error) {
        return refused.print();
    }
    // A message of clap quotes the words of the user.
    let is_hostile = |word: OsString| shown(&word.to_string_lossy()) != word.to_string_lossy();
    if exit != 0 && (wants_json() || std::env::args_os().any(is_hostile)) {
        return of_clap(error, exit).print();
    }
    let _ = error.print();
    ExitCode::from(exit)
}

/// A message of clap: its lines before the tip and the usage, a list of arguments having one line
/// each.
fn of_clap(error: &clap::Error, exit: u8) -> RenderedError {
    let text = error.render().to_string();
    let lines = || text.lines().map(str::trim).filter(|l| !l.is_empty());
    let ends = ["tip: ", "Usage: ", "For more information"];
    let message: Vec<&str> = lines()
        .take_while(|line| !ends.iter().any(|end| line.starts_with(end)))
        .collect();
    let message = message.join(" ");
    let hint = lines().find_map(|l| l.strip_prefix("tip: "));
    let message = message.trim_start_matches("error: ");
    RenderedError::new(exit, "usage", message, hint)
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
        let (message, hint) = (own.worded(flag), own.worded_hint(flag));
        let message = format!("{option}: {message}");
        return Some(RenderedError::new(2, own.code(), &message, hint.as_deref()));
    }
    let is_number = cause.is::<ParseFloatError>() || cause.is::<ParseIntError>();
    let message = format!("{option}: {value} is not a number");
    let hint = value
        .contains(',')
        .then_some("write numbers with a point: 48.1");
    is_number.then(|| RenderedError::new(2, "usage", &message, hint))
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let mut causes = error.chain().filter_map(|e| e.downcast_ref::<io::Error>());
    causes.any(|cause| cause.kind() == io::ErrorKind::BrokenPipe)
}
