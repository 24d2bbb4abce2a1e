//! `gravical check`: test whether a calibration still fits.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::calibration_file::InputFile;
use gravical::check::{CheckOptions, check};
use gravical::recording::ReadOptions;
use gravical::session::read_session;
use gravical_report::{figure, report};

use crate::calibration::{OriginArgs, files_of};
use crate::failure::quality;
use crate::options::{GravityArgs, reading};
use crate::report::{ResultArgs, with_origin};

/// Test whether a calibration still fits new recordings at rest
///
/// At rest the magnitude of the calibrated vector is gravity in any pose. The error of each static
/// interval is tested against the uncertainty that the calibration predicts.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  gravical check cal.json today.csv
  gravical check cals/ today.csv --sensor-id left-foot

Exit codes: 0 agrees or undecided, 3 bad input, 4 does not fit (p < 0.01)")]
pub struct Args {
    /// File of `gravical calibrate` or imucal, or a folder
    #[arg(value_name = "CAL")]
    calibration: PathBuf,
    /// Files, a folder, or - for stdin
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    #[command(flatten)]
    result: ResultArgs,
    /// Gyroscope in a second file, joined by time
    #[arg(long, value_name = "FILE")]
    gyro: Option<PathBuf>,
    #[command(flatten)]
    origin: OriginArgs,
    #[command(flatten)]
    gravity: GravityArgs,
    #[command(flatten)]
    recording: ReadOptions,
    #[command(flatten)]
    options: CheckOptions,
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let options = CheckOptions {
        gravity: args.gravity.given()?,
        ..args.options.clone()
    };
    let calibrations = files_of(&args.calibration);
    let files = calibrations.iter().chain(&args.recordings);
    args.result.check(None, files.chain(&args.gyro))?;
    let quiet = args.result.json || args.result.quiet;
    let read = reading(&args.recording, true);
    let origin = &args.origin;
    let (calibration, file) = origin.read(&args.calibration, &args.recordings, &read, quiet)?;
    let (recordings, left_out) = read_session(&args.recordings, args.gyro.as_deref(), &read)?;
    let mut result = check(&calibration, &file.path, &recordings, &options)?;
    result.findings.extend(left_out);
    let mut inputs = InputFile::of(&recordings);
    inputs.push(file);
    let figures = args.result.report.figures(|| figure::check::check(&result));
    let document = with_origin(report::check(&result, &figures), &inputs);
    args.result.present(&result, &document)?;
    Ok(quality(result.verdict.judgement.is_change()))
}
