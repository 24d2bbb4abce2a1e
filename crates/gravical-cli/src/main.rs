//! The program `gravical`.

use std::process::ExitCode;

fn main() -> ExitCode {
    gravical_cli::run(std::env::args_os().collect())
}
