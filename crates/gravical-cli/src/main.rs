//! The program `gravical`: the table of contents. Every verb has its file in
//! `cmd`; what it does lives in the library.

mod cmd;
mod colour;
mod device;
mod failure;
mod figures;
mod options;
mod progress;
mod report;
mod session;
mod table;
mod text;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(
    name = "gravical",
    version,
    about = "Turn a cheap IMU into an instrument you can trust.",
    after_help = "Exit codes: 0 ok, 1 internal, 2 usage, 3 bad input, 4 ran but a quality gate failed, 5 board or port, 130 interrupted.",
    arg_required_else_help = true,
    propagate_version = true
)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// What is in a recording: columns, units, rate, defects, stills, faces
    Inspect(cmd::inspect::Args),
    /// Recordings of still placements → calibration
    Calibrate(Box<cmd::calibrate::Args>),
    /// Recording → calibrated recording, streaming
    Apply(cmd::apply::Args),
    /// Recording → filtered recording, and what that does to its noise
    Denoise(Box<cmd::denoise::Args>),
    /// Recording → velocity and position, with error bands
    Motion(Box<cmd::motion::Args>),
    /// The whole way on a virtual sensor: two reports in seconds
    Demo(cmd::demo::Args),
    /// Does a calibration still fit new still readings?
    Check(Box<cmd::check::Args>),
    /// Do two calibrations differ by more than their uncertainty?
    Compare(cmd::compare::Args),
    /// A calibration in another program's format
    Export(cmd::export::Args),
    /// From a board into a file: every row, or a gap with a name; space pauses
    Log(Box<cmd::log::Args>),
    /// Serial ports, and which of them is a board
    Ports(cmd::ports::Args),
    /// Recordings of a virtual sensor with known truth
    Simulate(Box<cmd::simulate::Args>),
    /// Completions for your shell
    Completions(cmd::completions::Args),
    /// The manual as man pages
    Man(cmd::man::Args),
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return failure::usage(&error),
    };
    let json = cli.verb.wants_json();
    progress::watch();
    let done = cli.verb.run();
    progress::end();
    done.unwrap_or_else(|error| failure::report(&error, json))
}
