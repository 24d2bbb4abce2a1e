//! Errors as text or JSON, and their exit codes.

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

use gravical::Category;
use gravical::document::paragraph;
use gravical::output::{one_line, shown, shown_json};

/// Exit code when a result failed a quality check.
pub const QUALITY: u8 = 4;

/// Exit code when the board, its port or the cable fails.
pub const DEVICE: u8 = 5;

/// Exit code when the user stopped an incomplete recording.
pub const INTERRUPTED: u8 = 130;

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
    /// None for a closed pipe: the reader has finished.
    pub fn of(error: &anyhow::Error) -> Option<Self> {
        if is_broken_pipe(error) {
            return None;
        }
        let known = error.downcast_ref::<gravical::Error>();
        let exit = known.map_or(1, |e| match e.category() {
            Category::Usage => 2,
            Category::Input => 3,
            Category::System => 1,
            Category::Device => DEVICE,
        });
        // Our own errors are complete; others print their chain of causes.
        let message = known.map_or_else(|| format!("{error:#}"), ToString::to_string);
        let object = serde_json::json!({
            "code": known.map_or("internal", gravical::Error::code),
            "message": message,
            "hint": known.and_then(gravical::Error::hint),
        });
        // Paragraphs on a terminal, whole lines for log files.
        let line = |first: &str, text: &str| {
            if io::stderr().is_terminal() {
                paragraph(first, text)
            } else {
                format!("{first}{}\n", one_line(text))
            }
        };
        let mut text = line("error: ", &message);
        if let Some(e) = known {
            if let Some(hint) = e.hint() {
                text.push_str(&line("  try: ", hint));
            }
            text.push_str(&format!("  code: {}\n", e.code()));
        }
        let text = shown(&text).into_owned();
        Some(RenderedError { exit, object, text })
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
    // A value that an option refused, with the hint of the library.
    let own = std::error::Error::source(error).and_then(|e| e.downcast_ref::<gravical::Error>());
    let words: Vec<String> = std::env::args_os()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    if code != 0 && words.iter().any(|word| word == "--json") {
        let text = error.render().to_string();
        let lines = || text.lines().map(str::trim).filter(|l| !l.is_empty());
        // All lines before the tip and the usage: a list of arguments has one line each.
        let ends = ["tip: ", "Usage: ", "For more information"];
        let message: Vec<&str> = lines()
            .take_while(|line| !ends.iter().any(|end| line.starts_with(end)))
            .collect();
        let tip = lines().find_map(|l| l.strip_prefix("tip: "));
        let object = serde_json::json!({
            "code": own.map_or("usage", gravical::Error::code),
            "message": message.join(" ").trim_start_matches("error: "),
            "hint": own.and_then(gravical::Error::hint).or(tip),
        });
        // `log` writes one JSON object per line.
        let text = match words.get(1).map(|w| w == "log") {
            Some(true) => object.to_string(),
            _ => format!("{object:#}"),
        };
        let _ = writeln!(io::stdout(), "{}", shown_json(&text));
    } else if words.iter().any(|word| shown(word) != *word) {
        // The message quotes the words of the user.
        let _ = writeln!(io::stderr(), "{}", shown(&error.render().to_string()));
    } else {
        let _ = error.print();
        if let Some(hint) = own.and_then(gravical::Error::hint) {
            let _ = io::stderr().write_all(paragraph("  try: ", hint).as_bytes());
        }
    }
    ExitCode::from(code)
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
