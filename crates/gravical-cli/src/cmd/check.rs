//! `gravical check`: does a calibration still fit new still readings?

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::calibration_file::{CalibrationFile, InputFile};
use gravical::check::{CheckOptions, Judgement, check};
use gravical::document::Detail;
use gravical::report;

use crate::failure::QUALITY;
use crate::options::{GravityArgs, RecordingArgs};
use crate::report::{ReportArgs, with_origin};
use crate::session::read_session;
use crate::text;

/// Does a calibration still fit new still readings?
///
/// At rest the calibrated vector has to be as long as gravity, in any pose. Every still of the
/// recordings is held against that, and the error against what the calibration predicts.
#[derive(clap::Args)]
#[command(after_help = "\
A recording with one still of any pose will do; more poses test more.

Exit codes: 0 it fits, or it cannot be said; 3 no still, or another unit; 4 it
does not fit any more (p < 0.01).")]
pub struct Args {
    /// Calibration: a file of `gravical calibrate` or of imucal
    #[arg(value_name = "CAL")]
    calibration: PathBuf,
    /// Recordings with stills: files, or one folder; - is standard input
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    #[command(flatten)]
    report: ReportArgs,
    /// Replace files that are there
    #[arg(long)]
    force: bool,
    /// Print the check as one JSON object on stdout
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    gravity: GravityArgs,
    #[command(flatten)]
    recording: RecordingArgs,
}

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let options = CheckOptions {
        gravity: args.gravity.given()?,
        axes: args.recording.axes.0,
        ..CheckOptions::default()
    };
    let inputs: Vec<&Path> = args
        .recordings
        .iter()
        .chain([&args.calibration])
        .map(PathBuf::as_path)
        .collect();
    args.report.check(None, &inputs, args.force)?;
    let (calibration, input) = CalibrationFile::read_with_input(&args.calibration)?;
    let read_options = args.recording.read_options(true);
    let (recordings, left_out) =
        read_session(&args.recordings, None, &read_options, Some(&options.still))?;
    let name = args.calibration.display().to_string();
    let mut result = check(&calibration, &name, &recordings, &options)?;
    result.findings.extend(left_out);
    let mut inputs = InputFile::of(&recordings);
    inputs.push(input);
    let document = with_origin(report::check(&result), &inputs);
    args.report.write(args.force, &document)?;
    if args.json {
        text::print_json(&result)?;
    } else {
        text::print_report(&document.to_text(Detail::Summary))?;
    }
    args.report.say();
    Ok(match result.verdict.judgement {
        Judgement::DoesNotFit => ExitCode::from(QUALITY),
        Judgement::Fits | Judgement::CannotSay => ExitCode::SUCCESS,
    })
}
