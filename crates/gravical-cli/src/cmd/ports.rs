//! `gravical ports`: serial ports and likely boards.

use std::process::ExitCode;

use crate::device::ports::{line, list};
use crate::text;

/// List serial ports and mark likely boards
#[derive(clap::Args)]
pub struct Args {
    /// Print JSON: {"ports": […]}
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let ports = list()?;
    if args.json {
        text::print_json(&serde_json::json!({ "ports": ports }))?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut out: String = ports.iter().map(|port| line(port) + "\n").collect();
    if ports.is_empty() {
        out += "No serial ports. Some USB cables only charge; try another cable.\n";
    } else if !ports.iter().any(|port| port.board) {
        out += "None of them has the USB vendor of a known board.\n";
    }
    text::print(&out)?;
    Ok(ExitCode::SUCCESS)
}
