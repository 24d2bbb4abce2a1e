//! `gravical completions`: completions for a shell, on stdout.

use std::process::ExitCode;

use clap_complete::Shell;

use crate::text;

#[derive(clap::Args)]
pub struct Args {
    /// Your shell
    shell: Shell,
}

/// Runs the verb.
pub fn run(args: &Args, mut program: clap::Command) -> anyhow::Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "gravical", &mut script);
    text::print(&String::from_utf8_lossy(&script))?;
    Ok(ExitCode::SUCCESS)
}
