//! `gravical export`: a calibration in the format of another program.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::builder::{PossibleValue, PossibleValuesParser};
use gravical::Error;
use gravical::calibration_file::CalibrationFile;
use gravical::export::{ExportOptions, TARGETS, Target, export};
use gravical::output::write_text;
use gravical::targets::check_targets;

use crate::options::AxisMapArg;
use crate::text;

/// Convert a calibration to the format of another program
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  gravical export --to list
  gravical export cal.json --to c -o imu_left.h --name imu_left
  gravical export cal.json --to arduino --counts-per-g 16384 --counts-per-deg-s 65.5 -o mysensor.h
  gravical export cal.json --to px4 --device-id 2621448 -o accel.params")]
pub struct Args {
    /// Calibration file, of gravical or imucal
    #[arg(value_name = "CAL")]
    calibration: Option<PathBuf>,
    /// Target format; list explains each in a line
    #[arg(long, value_parser = parse_target(), value_name = "TARGET", hide_possible_values = true)]
    to: String,
    /// File to write [default: stdout]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Name in the code: of functions, a node [default: gravical, ros2: imu_apply]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Id that the autopilot has given to this sensor (px4, ardupilot)
    #[arg(long, value_name = "ID")]
    device_id: Option<u32>,
    /// Sensor axes that point along x, y and z of the autopilot's frame of the sensor, e.g. y,-x,z
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    rotation: Option<AxisMapArg>,
    /// Counts per g of the sketch's raw values (arduino) [default: the unit of the recordings]
    #[arg(long, value_name = "N")]
    counts_per_g: Option<f64>,
    /// Counts per °/s of the sketch's raw values (arduino) [default: the unit of the recordings]
    #[arg(long, value_name = "N")]
    counts_per_deg_s: Option<f64>,
    /// Take upper limits for noise parameters that are not determined (kalibr)
    #[arg(long)]
    upper_limit: bool,
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
    let output = args
        .output
        .as_ref()
        .filter(|p| p.as_path() != Path::new("-"));
    check_targets(
        output.map(std::slice::from_ref).unwrap_or_default(),
        std::slice::from_ref(calibration),
        args.force,
    )?;
    let file = CalibrationFile::read(calibration)?;
    let options = ExportOptions {
        name: args.name.clone(),
        device_id: args.device_id,
        rotation: args.rotation.as_ref().map(|r| r.0),
        counts_per_g: args.counts_per_g,
        counts_per_deg_s: args.counts_per_deg_s,
        upper_limit: args.upper_limit,
    };
    let written = export(&file, target, &options)?;
    match output {
        Some(path) => write_text(path, args.force, &written.text)?,
        None => text::print(&written.text)?,
    }
    for note in &written.notes {
        text::say(&format!("note: {note}"));
    }
    Ok(ExitCode::SUCCESS)
}
