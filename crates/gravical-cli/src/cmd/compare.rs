//! `gravical compare`: do two calibrations differ by more than their uncertainty?

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::calibration_file::CalibrationFile;
use gravical::compare::{Agreement, compare};
use gravical::document::Detail;
use gravical::report::comparison;

use crate::failure::QUALITY;
use crate::report::{ReportArgs, with_origin};
use crate::text;

/// Do two calibrations of one sensor differ by more than their uncertainty?
///
/// The difference is told in two parts: what changes the length of the calibrated vector (bias,
/// scale, angles between the axes), and the rotation of the frame, which does not.
#[derive(clap::Args)]
#[command(after_help = "\
Exit codes: 0 they agree, or it cannot be said; 4 they differ by more than their
uncertainty (p < 0.01 for both parts together).")]
pub struct Args {
    /// The first calibration: a file of gravical or of imucal
    #[arg(value_name = "A")]
    first: PathBuf,
    /// The second one; differences are B − A
    #[arg(value_name = "B")]
    second: PathBuf,
    #[command(flatten)]
    report: ReportArgs,
    /// Replace files that are there
    #[arg(long)]
    force: bool,
    /// Print the comparison as one JSON object on stdout
    #[arg(long)]
    pub json: bool,
}

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    args.report
        .check(None, &[&args.first, &args.second], args.force)?;
    let (a, first) = CalibrationFile::read_with_input(&args.first)?;
    let (b, second) = CalibrationFile::read_with_input(&args.second)?;
    let names = [&args.first, &args.second].map(|p| p.display().to_string());
    let result = compare(&a, &b, [&names[0], &names[1]])?;
    let document = with_origin(comparison(&result), &[first, second]);
    args.report.write(args.force, &document)?;
    if args.json {
        text::print_json(&result)?;
    } else {
        text::print_report(&document.to_text(Detail::Summary))?;
    }
    args.report.say();
    Ok(match result.verdict.judgement {
        Agreement::Differ => ExitCode::from(QUALITY),
        Agreement::Agree | Agreement::CannotSay => ExitCode::SUCCESS,
    })
}
