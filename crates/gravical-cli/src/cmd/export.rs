//! `gravical export`: a calibration in the format of another program.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::builder::{PossibleValue, PossibleValuesParser};
use gravical::Error;
use gravical::calibration_file::Calibration;
use gravical::export::{ExportOptions, TARGETS, Target, export, export_noise};
use gravical::noise::read_noise;
use gravical::output::write_text;
use gravical::targets::check_targets;

use crate::text;

/// Convert a calibration to the format of another program
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  gravical export --to list
  gravical export cal.json --to c -o imu_left.h --name imu_left
  gravical export cal.json --to ros2 -o imu.yaml")]
pub struct Args {
    /// Calibration, of gravical or imucal; for kalibr and ros-noise the result of noise
    #[arg(value_name = "CAL")]
    calibration: Option<PathBuf>,
    /// File to write [default: stdout]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Target; list explains each in a line
    #[arg(long, value_parser = parse_target(), value_name = "TARGET", hide_possible_values = true)]
    to: String,
    #[command(flatten)]
    options: ExportOptions,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
}

/// A target, or the list of all.
fn parse_target() -> PossibleValuesParser {
    let list = PossibleValue::new("list").help("explains each target in a line");
    let targets = TARGETS
        .iter()
        .map(|t| PossibleValue::new(t.name).help(t.holds));
    PossibleValuesParser::new(std::iter::once(list).chain(targets))
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let Some(target) = Target::find(&args.to) else {
        for target in &TARGETS {
            text::print(&format!("{:<11} {}\n", target.name, target.holds))?;
        }
        return Ok(ExitCode::SUCCESS);
    };
    let Some(calibration) = &args.calibration else {
        let error = Error::usage("usage", "no calibration is given");
        let hint = format!("gravical export cal.json --to {}", target.name);
        return Err(error.with_hint(hint).into());
    };
    let is_file = |path: &&PathBuf| path.as_path() != Path::new("-");
    let output = args.output.as_ref().filter(is_file);
    let targets = output.map(std::slice::from_ref).unwrap_or_default();
    check_targets(targets, std::slice::from_ref(calibration), args.force)?;
    target.check(&args.options)?;
    let written = if target.is_noise() {
        export_noise(&read_noise(calibration)?, target, &args.options)?
    } else {
        export(&Calibration::read(calibration)?, target, &args.options)?
    };
    match output {
        Some(path) => write_text(path, args.force, &written.text)?,
        None => text::print(&written.text)?,
    }
    for note in &written.notes {
        text::say(&format!("note: {note}"));
    }
    Ok(ExitCode::SUCCESS)
}
