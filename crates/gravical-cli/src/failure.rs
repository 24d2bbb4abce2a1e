//! How a failure is told: a sentence with place, reason and next step, or the
//! same as JSON; and which exit code it has.

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

use gravical::Category;
use gravical::document::paragraph;
use gravical::output::{one_line, shown, shown_json};

/// Exit code when the program ran and a quality gate failed.
pub const QUALITY: u8 = 4;

/// Exit code when the board, its port or the cable fails.
pub const DEVICE: u8 = 5;

/// Exit code when the user ended it and something is missing.
pub const INTERRUPTED: u8 = 130;

/// What is said of an error.
pub struct Told {
    /// The exit code.
    pub exit: u8,
    /// For scripts.
    pub object: serde_json::Value,
    /// For people, in whole lines.
    pub text: String,
}

impl Told {
    /// None where the reader of our output has seen enough.
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
        // Our own errors say all of it themselves; others as a chain of causes.
        let message = known.map_or_else(|| format!("{error:#}"), ToString::to_string);
        let object = serde_json::json!({
            "code": known.map_or("internal", gravical::Error::code),
            "message": message,
            "hint": known.and_then(gravical::Error::hint),
        });
        // People read paragraphs; what searches a log wants whole lines.
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
        Some(Told { exit, object, text })
    }
}

/// Tells `error` and gives the exit code.
pub fn report(error: &anyhow::Error, json: bool) -> ExitCode {
    let Some(told) = Told::of(error) else {
        return ExitCode::SUCCESS;
    };
    let printed = json && {
        let text = format!("{:#}", told.object);
        let mut out = io::stdout().lock();
        writeln!(out, "{}", shown_json(&text))
            .and_then(|()| out.flush())
            .is_ok()
    };
    // Nowhere is left to complain when this cannot be written.
    if !printed {
        let _ = io::stderr().write_all(told.text.as_bytes());
    }
    ExitCode::from(told.exit)
}

/// Tells a wrong call; help and version come this way, too.
pub fn usage(error: &clap::Error) -> ExitCode {
    let code = u8::try_from(error.exit_code()).unwrap_or(2);
    let words: Vec<String> = std::env::args_os()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    if code != 0 && words.iter().any(|word| word == "--json") {
        let text = error.render().to_string();
        let mut lines = text.lines().map(str::trim).filter(|l| !l.is_empty());
        let object = serde_json::json!({
            "code": "usage",
            "message": lines.next().map(|l| l.trim_start_matches("error: ")),
            "hint": lines.find_map(|l| l.strip_prefix("tip: ")),
        });
        // The events of `log` are an object a line, and so is its error.
        let text = match words.get(1).map(|w| w == "log") {
            Some(true) => object.to_string(),
            _ => format!("{object:#}"),
        };
        let _ = writeln!(io::stdout(), "{}", shown_json(&text));
    } else if words.iter().any(|word| shown(word) != *word) {
        // What it says of the words is theirs.
        let _ = writeln!(io::stderr(), "{}", shown(&error.render().to_string()));
    } else {
        let _ = error.print();
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
