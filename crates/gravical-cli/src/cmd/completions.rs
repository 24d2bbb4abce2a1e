//! `gravical completions`: shell completions on stdout.

use std::process::ExitCode;

use clap_complete::Shell;

use crate::text;

/// Print completions for a shell
#[derive(clap::Args)]
#[command(
    after_help = "Example: gravical completions bash > ~/.local/share/bash-completion/completions/gravical"
)]
pub struct Args {
    /// The shell
    shell: Shell,
}

/// Runs the command.
pub fn run(args: &Args, mut program: clap::Command) -> anyhow::Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "gravical", &mut script);
    text::print(&String::from_utf8_lossy(&script))?;
    Ok(ExitCode::SUCCESS)
}
