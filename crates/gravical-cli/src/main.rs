//! The program `gravical`: its commands. Each has a file in `cmd`; the work is done by the library.

mod calibration;
mod cmd;
mod colour;
mod crash;
mod device;
mod each;
mod failure;
mod figures;
mod options;
mod outlet;
mod progress;
mod report;
mod table;
mod text;

use std::process::ExitCode;

use clap::{CommandFactory as _, Parser, Subcommand};

#[derive(Parser)]
#[command(
    name = "gravical",
    version,
    about = "Turn a cheap IMU into an instrument you can trust.",
    after_help = "New here? Run `gravical demo`: it calibrates a simulated sensor and writes two reports.

Exit codes: 0 ok, 1 internal, 2 usage, 3 bad input, 4 the result failed a quality check, 5 board or port, 130 interrupted.",
    arg_required_else_help = true,
    propagate_version = true
)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Inspect(cmd::inspect::Args),
    Calibrate(Box<cmd::calibrate::Args>),
    Apply(cmd::apply::Args),
    Denoise(Box<cmd::denoise::Args>),
    Convert(Box<cmd::convert::Args>),
    Motion(Box<cmd::motion::Args>),
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
    Man(cmd::man::Args),
}

fn main() -> ExitCode {
    crash::watch();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // `help` is a command of its own and has no options.
            let words: Vec<String> = std::env::args_os()
                .skip(1)
                .map(|w| w.to_string_lossy().into_owned())
                .collect();
            if matches!(&words[..], [help, flag] if help == "help" && ["-h", "--help"].contains(&flag.as_str()))
            {
                let printed = Cli::command().print_help();
                return if printed.is_ok() {
                    ExitCode::SUCCESS
                } else {
                    ExitCode::FAILURE
                };
            }
            return failure::usage(&error);
        }
    };
    let json = cli.verb.wants_json();
    progress::watch();
    let done = cli.verb.run();
    progress::end();
    done.unwrap_or_else(|error| failure::report(&error, json))
}
