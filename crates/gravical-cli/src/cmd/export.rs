//! `gravical export`: a calibration in the format of another program.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::Error;
use gravical::calibration_file::{CalibrationFile, to_imucal};
use gravical::output::{shown_json, write_atomic};

use crate::text;

/// Convert a calibration to the format of another program
#[derive(clap::Args)]
#[command(after_help = "Example: gravical export cal.json --to imucal -o cal-imucal.json")]
pub struct Args {
    /// Calibration file, of gravical or imucal
    #[arg(value_name = "CAL")]
    calibration: PathBuf,
    /// Target format
    #[arg(long, value_enum, value_name = "TARGET")]
    to: Target,
    /// File to write [default: stdout]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Target {
    /// JSON of the Python library imucal, format 2.0
    Imucal,
    /// The format of gravical (converts a file of imucal)
    Gravical,
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let file = CalibrationFile::read(&args.calibration)?;
    let text = match args.to {
        Target::Imucal => to_imucal(&file)?,
        Target::Gravical => file.to_json()?,
    };
    match &args.output {
        Some(path) => write_atomic(path, args.force, |w| {
            w.write_all(text.as_bytes()).map_err(|e| Error::io(path, e))
        })?,
        None => text::print(&shown_json(&text))?,
    }
    Ok(ExitCode::SUCCESS)
}
