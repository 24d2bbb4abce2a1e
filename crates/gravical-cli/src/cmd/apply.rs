//! Placeholder until the branch lands.
use std::process::ExitCode;
#[derive(clap::Args)]
pub struct Args {
    #[arg(long)]
    pub json: bool,
}
pub fn run(_: &Args) -> anyhow::Result<ExitCode> {
    Ok(ExitCode::SUCCESS)
}
