//! `gravical export`: a calibration in another program's format.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::Error;
use gravical::calibration_file::{CalibrationFile, to_imucal};
use gravical::output::{shown_json, write_atomic};

use crate::text;

#[derive(clap::Args)]
pub struct Args {
    /// The calibration: a file of gravical or of imucal
    #[arg(value_name = "CAL")]
    calibration: PathBuf,
    /// For which program
    #[arg(long, value_enum, value_name = "TARGET")]
    to: Target,
    /// Write to this file [default: stdout]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Target {
    /// JSON of the Python library imucal, format 2.0
    Imucal,
    /// gravical's own format (to convert a file of imucal)
    Gravical,
}

/// Runs the verb.
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
