//! `gravical check`: test whether a calibration still fits.

mod each;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::calibration_file::{CalibrationFile, InputFile};
use gravical::check::{CheckOptions, CheckReport, Judgement, check};
use gravical::recording::{ReadOptions, Recording};
use gravical::{Result, report};

use crate::each::EachArgs;
use crate::failure::QUALITY;
use crate::options::{GravityArgs, RecordingArgs, SWAPPED, read_calibration};
use crate::report::{ReportArgs, with_origin};
use crate::session::read_session;
use crate::text;

/// Test whether a calibration still fits new recordings at rest
///
/// At rest the magnitude of the calibrated vector is gravity in any pose. The error of each static
/// interval is tested against the uncertainty that the calibration predicts.
#[derive(clap::Args)]
#[command(
    after_help = "\
Example: gravical check cal.json today.csv
How a recording is read (units, columns, rate): options in `gravical check --help`.

Exit codes: 0 fits or cannot be decided, 3 bad input, 4 does not fit (p < 0.01).",
    after_long_help = "\
Example: gravical check cal.json today.csv

One static interval in any pose is enough; more poses test more of the calibration.

Many recordings, such as those of a production line:
  gravical check cal.json --each tests/ --summary tests.csv
A line for each of them; one that cannot be tested does not stop the others.

Exit codes: 0 fits, or cannot be decided; 3 no static interval, or another unit;
4 does not fit any more (p < 0.01); with --each: 4 one of them does not fit or cannot
be tested, 130 interrupted."
)]
pub struct Args {
    /// Calibration file, of `gravical calibrate` or imucal
    #[arg(value_name = "CAL")]
    calibration: PathBuf,
    /// Recordings of the sensor at rest: files, or one folder; - reads standard input. With --each,
    /// sessions
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// Gyroscope of the recording in a second file, joined by time
    #[arg(long, value_name = "FILE")]
    gyro: Option<PathBuf>,
    #[command(flatten)]
    report: ReportArgs,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
    /// With --each: print only what does not fit or cannot be tested
    #[arg(short, long, requires = "each")]
    quiet: bool,
    #[command(flatten)]
    each: EachArgs,
    #[command(flatten)]
    gravity: GravityArgs,
    #[command(flatten)]
    recording: RecordingArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if args.each.each {
        return each::run(args);
    }
    args.each.refuse_alone()?;
    let options = args.options()?;
    let inputs: Vec<&Path> = args
        .recordings
        .iter()
        .chain([&args.calibration])
        .chain(&args.gyro)
        .map(PathBuf::as_path)
        .collect();
    args.report.check(None, &inputs, args.force)?;
    let (calibration, input) = read_calibration(
        &args.calibration,
        args.recordings.first().map(PathBuf::as_path),
        SWAPPED,
    )?;
    let read_options = args.recording.read_options(true);
    let (result, recordings) = compute(
        args,
        &calibration,
        &args.recordings,
        &read_options,
        &options,
    )?;
    let mut inputs = InputFile::of(&recordings);
    inputs.push(input);
    let document = with_origin(report::check(&result), &inputs);
    args.report.write(args.force, &document)?;
    if args.json {
        text::print_json(&result)?;
    } else {
        text::print_report(&document.to_text(args.report.detail()))?;
    }
    args.report.say();
    Ok(match result.verdict.judgement {
        Judgement::DoesNotFit => ExitCode::from(QUALITY),
        Judgement::Fits | Judgement::Undecided => ExitCode::SUCCESS,
    })
}

/// The check of one session, and its recordings.
///
/// # Errors
///
/// Those of reading and of the library.
fn compute(
    args: &Args,
    calibration: &CalibrationFile,
    inputs: &[PathBuf],
    read_options: &ReadOptions,
    options: &CheckOptions,
) -> Result<(CheckReport, Vec<Recording>)> {
    let (recordings, left_out) = read_session(
        inputs,
        args.gyro.as_deref(),
        read_options,
        Some(&options.still),
    )?;
    let name = args.calibration.display().to_string();
    let mut result = check(calibration, &name, &recordings, options)?;
    result.findings.extend(left_out);
    Ok((result, recordings))
}

impl Args {
    fn options(&self) -> Result<CheckOptions> {
        Ok(CheckOptions {
            gravity: self.gravity.given()?,
            axes: self.recording.axes.0,
            ..CheckOptions::default()
        })
    }
}
