//! `gravical check`: test whether a calibration still fits.

use gravical::numfmt::words;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::Result;
use gravical::calibration_file::{CalibrationFile, InputFile};
use gravical::check::{CheckOptions, CheckReport, check};
use gravical::recording::{ReadOptions, Recording};
use gravical::session::read_session;
use gravical_report::report;

use crate::calibration::{OriginArgs, files_of, read_file};
use crate::each::{self, EachArgs, Outcome, Plan};
use crate::failure::quality;
use crate::options::{GravityArgs, SWAPPED, reading};
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
  gravical check cal.json --each tests/ --summary tests.csv

Exit codes: 0 fits or cannot be decided, 3 bad input, 4 does not fit (p < 0.01)")]
pub struct Args {
    /// File of `gravical calibrate` or imucal, or a folder
    #[arg(value_name = "CAL")]
    calibration: PathBuf,
    /// Files, a folder, or - for stdin; with --each, sessions
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    #[command(flatten)]
    result: ResultArgs,
    /// Gyroscope in a second file, joined by time
    #[arg(long, value_name = "FILE")]
    gyro: Option<PathBuf>,
    #[command(flatten)]
    each: EachArgs,
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
    if args.each.each {
        return check_each(args);
    }
    args.each.refuse_alone()?;
    let options = args.options()?;
    let calibrations = files_of(&args.calibration);
    let files = calibrations.iter().chain(&args.recordings);
    args.result.check(None, files.chain(&args.gyro))?;
    let quiet = args.result.json || args.result.quiet;
    let read_options = reading(&args.recording, true);
    let inputs = &args.recordings;
    let calibration = args
        .origin
        .read(&args.calibration, inputs, &read_options, SWAPPED, quiet)?;
    let (result, recordings) = compute(
        args,
        &calibration.file,
        &calibration.path,
        inputs,
        &read_options,
        &options,
    )?;
    let mut inputs = InputFile::of(&recordings);
    inputs.push(calibration.input);
    let document = with_origin(report::check(&result), &inputs);
    args.result.present(&result, &document)?;
    Ok(quality(result.verdict.judgement.is_change()))
}

/// Runs the command for each of its sessions, as on a production line.
///
/// # Errors
///
/// What concerns all of them: options, the calibration, targets.
fn check_each(args: &Args) -> anyhow::Result<ExitCode> {
    EachArgs::refuse_beside(&[
        ("--gyro", args.gyro.is_some()),
        ("--report", args.result.report.is_wanted()),
        ("--json", args.result.json),
    ])?;
    args.origin.refuse(&args.calibration)?;
    let why = "check writes no results that a second run could keep";
    each::refuse(&[("--resume", args.each.resume)], why, "leave it out")?;
    let options = args.options()?;
    let read = ReadOptions {
        hash: true,
        ..args.recording.clone()
    };
    read.validate()?;
    let first = args.recordings.first().map(PathBuf::as_path);
    let calibration = read_file(&args.calibration, first, SWAPPED)?.file;
    let plan = Plan {
        each: &args.each,
        inputs: &args.recordings,
        shared: files_of(&args.calibration),
        folders: true,
        output: None,
        ending: "",
        numbers: &[
            "static_intervals",
            "rms_mps2",
            "predicted_rms_mps2",
            "p_value",
        ],
        force: args.result.force,
        quiet: args.result.quiet,
    };
    let path = &args.calibration;
    let check = |session: &Path, _: Option<&Path>| {
        let input = [session.to_owned()];
        let (report, _) = compute(args, &calibration, path, &input, &read, &options)?;
        let reasons = report.verdict.reasons.iter();
        Ok(Outcome {
            grade: words(&report.verdict.judgement),
            is_poor: report.verdict.judgement.is_change(),
            reasons: reasons.map(ToString::to_string).collect(),
            numbers: vec![
                report.static_intervals.len().to_string(),
                report.rms_mps2.to_string(),
                report.predicted_rms_mps2.to_string(),
                report.test.p_value.to_string(),
            ],
            ..Outcome::default()
        })
    };
    each::run(&plan, check, |_, _| None)
}

/// The check of one session, and its recordings.
///
/// # Errors
///
/// Those of reading and of the library.
fn compute(
    args: &Args,
    calibration: &CalibrationFile,
    path: &Path,
    inputs: &[PathBuf],
    read_options: &ReadOptions,
    options: &CheckOptions,
) -> Result<(CheckReport, Vec<Recording>)> {
    let (recordings, left_out) = read_session(inputs, args.gyro.as_deref(), read_options)?;
    let name = path.display().to_string();
    let mut result = check(calibration, &name, &recordings, options)?;
    result.findings.extend(left_out);
    Ok((result, recordings))
}

impl Args {
    fn options(&self) -> Result<CheckOptions> {
        Ok(CheckOptions {
            gravity: self.gravity.given()?,
            ..self.options.clone()
        })
    }
}
