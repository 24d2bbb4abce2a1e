//! The program `gravical`: its commands. Each has a file in `cmd`; the work is done by the library.
//!
//! The API is internal to gravical and may change: [`run`] is the program, for its binary and for the Python package.
#![deny(missing_docs)]

mod calibration;
mod cmd;
mod crash;
mod device;
mod each;
mod failure;
mod interrupt;
mod options;
mod outlet;
mod progress;
mod report;
mod text;
mod words;

use std::ffi::OsString;
use std::io::{self, Write as _};
use std::process::ExitCode;

use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

#[derive(Parser)]
#[command(
    name = "gravical",
    version,
    about = "Turn a cheap IMU into an instrument you can trust.",
    after_help = "New here? Run `gravical demo`: it calibrates a simulated sensor and writes two reports.

Exit codes: 0 ok, 1 internal, 2 usage, 3 bad input, 4 the result failed a quality check, 5 board or port, 130 interrupted.",
    arg_required_else_help = true
)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Inspect(cmd::inspect::Args),
    Calibrate(Box<cmd::calibrate::Args>),
    Apply(Box<cmd::apply::Args>),
    Denoise(Box<cmd::denoise::Args>),
    Convert(Box<cmd::convert::Args>),
    Motion(Box<cmd::motion::Args>),
    Orient(Box<cmd::orient::Args>),
    Noise(Box<cmd::noise::Args>),
    Demo(cmd::demo::Args),
    Check(Box<cmd::check::Args>),
    Compare(cmd::compare::Args),
    Export(cmd::export::Args),
    Live(Box<cmd::live::Args>),
    Log(Box<cmd::log::Args>),
    Ports(cmd::ports::Args),
    Simulate(Box<cmd::simulate::Args>),
    Completions(cmd::completions::Args),
}

/// The verbs by what one wants to do.
const GROUPS: [(&str, &[&str]); 4] = [
    ("Record", &["live", "log", "ports"]),
    ("Calibrate", &["inspect", "calibrate", "check", "compare"]),
    (
        "Use",
        &[
            "apply", "export", "motion", "orient", "noise", "denoise", "convert",
        ],
    ),
    ("More", &["demo", "simulate", "completions", "help"]),
];

/// The program with its verbs in groups.
fn program() -> clap::Command {
    let mut command = Cli::command();
    if words::all().iter().any(|word| word == "--help") {
        command = command.mut_subcommands(with_every_option);
    }
    let mut groups = String::new();
    for (title, verbs) in GROUPS {
        groups += &format!("{title}:\n");
        for verb in verbs {
            let about = command.find_subcommand(verb).and_then(|c| c.get_about());
            let help = "Print this message, or the help of a command";
            let about = about.map_or(help.to_owned(), ToString::to_string);
            groups += &format!("  {verb:<12} {about}\n");
        }
        groups += "\n";
    }
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}Options:\n{{options}}{{after-help}}"
    ))
}

/// `--help`: every option, each in a line where it fits.
fn with_every_option(verb: clap::Command) -> clap::Command {
    verb.mut_args(|arg| arg.hide_short_help(false).long_help(None::<&str>))
        .mut_subcommands(with_every_option)
        .long_about(None::<&str>)
}

/// Runs the program with the words of a command line, the first of which is its own name.
pub fn run(command_line: Vec<OsString>) -> ExitCode {
    words::set(command_line);
    crash::watch();
    let words = program().try_get_matches_from(words::all());
    let cli = match words.and_then(|words| Cli::from_arg_matches(&words)) {
        Ok(cli) => cli,
        Err(error) => return failure::usage(&error),
    };
    progress::watch();
    let done = interrupt::watch().and_then(|()| cli.verb.run());
    progress::end();
    let code = done.unwrap_or_else(|error| failure::report(&error));
    // The interpreter of Python does not flush what Rust has buffered. The others flush each event, and whoever
    // reads them may have stopped reading.
    if !matches!(cli.verb, Verb::Log(_) | Verb::Live(_)) {
        let _ = io::stdout().flush();
    }
    code
}
