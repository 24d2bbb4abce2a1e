//! Errors as text or JSON, and their exit codes.

use std::io::{self, IsTerminal, Write};
use std::num::{ParseFloatError, ParseIntError};
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue};
use gravical::Category;
use gravical::escape::{one_line, shown, shown_json};
use gravical_report::document::{flag, paragraph};

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
        let hint = own.worded_hint(flag);
        Some(Self::new(
            exit,
            own.code(),
            &own.worded(flag),
            hint.as_deref(),
        ))
    }
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
pub fn report(error: &anyhow::Error, json: bool) -> ExitCode {
    let Some(rendered) = RenderedError::of(error) else {
        return ExitCode::SUCCESS;
    };
    let printed = json && {
        let text = format!("{:#}", rendered.object);
        let mut out = io::stdout().lock();
        writeln!(out, "{}", shown_json(&text))
            .and_then(|()| out.flush())
            .is_ok()
    };
    // If stderr cannot be written, nothing is left to report that.
    if !printed {
        let _ = io::stderr().write_all(rendered.text.as_bytes());
    }
    ExitCode::from(rendered.exit)
}

/// Prints a usage error, or the help or version that was requested.
pub fn usage(error: &clap::Error) -> ExitCode {
    let code = u8::try_from(error.exit_code()).unwrap_or(2);
    let words: Vec<String> = std::env::args_os()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let json = code != 0 && words.iter().any(|word| word == "--json");
    match refused(error) {
        Some(refused) if json => print_object(&refused.object, &words),
        Some(refused) => {
            let _ = io::stderr().write_all(refused.text.as_bytes());
        }
        None if json => {
            let text = error.render().to_string();
            let lines = || text.lines().map(str::trim).filter(|l| !l.is_empty());
            // All lines before the tip and the usage: a list of arguments has one line each.
            let ends = ["tip: ", "Usage: ", "For more information"];
            let message: Vec<&str> = lines()
                .take_while(|line| !ends.iter().any(|end| line.starts_with(end)))
                .collect();
            let object = serde_json::json!({
                "code": "usage",
                "message": message.join(" ").trim_start_matches("error: "),
                "hint": lines().find_map(|l| l.strip_prefix("tip: ")),
            });
            print_object(&object, &words);
        }
        // The message quotes the words of the user.
        None if words.iter().any(|word| shown(word) != *word) => {
            let _ = writeln!(io::stderr(), "{}", shown(&error.render().to_string()));
        }
        None => {
            let _ = error.print();
        }
    }
    ExitCode::from(code)
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
    let own = cause.downcast_ref::<gravical::Error>();
    let number = cause.is::<ParseFloatError>() || cause.is::<ParseIntError>();
    let (code, message, hint) = match own {
        Some(own) => (
            own.code(),
            format!("{option}: {}", own.worded(flag)),
            own.worded_hint(flag),
        ),
        None if number => (
            "usage",
            format!("{option}: {value} is not a number"),
            value
                .contains(',')
                .then(|| "write numbers with a point: 48.1".to_owned()),
        ),
        None => return None,
    };
    Some(RenderedError::new(2, code, &message, hint.as_deref()))
}

/// `log` writes one JSON object per line.
fn print_object(object: &serde_json::Value, words: &[String]) {
    let text = match words.get(1).map(|w| w == "log") {
        Some(true) => object.to_string(),
        _ => format!("{object:#}"),
    };
    let _ = writeln!(io::stdout(), "{}", shown_json(&text));
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause
            .downcast_ref::<gravical::Error>()
            .is_some_and(gravical::Error::is_broken_pipe)
            || cause
                .downcast_ref::<io::Error>()
                .is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
    })
}
