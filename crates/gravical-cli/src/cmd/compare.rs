//! `gravical compare`: test whether two calibrations differ.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::calibration_file::Calibration;
use gravical::compare::compare;
use gravical_report::{figure, report};

use crate::failure::quality;
use crate::report::{ResultArgs, with_origin};

/// Test whether two calibrations of a sensor agree
///
/// The difference has two parts: one that changes the magnitude of the calibrated vector (bias, scale,
/// angles between the axes), and a rotation of the sensor frame, which does not.
#[derive(clap::Args)]
#[command(after_help = "\
Example: gravical compare march.json november.json

Exit codes: 0 agrees or undecided; 3 bad input; 4 they differ by
more than their uncertainty (p < 0.01 for both parts together).")]
pub struct Args {
    /// First calibration, of gravical or imucal
    #[arg(value_name = "A")]
    first: PathBuf,
    /// Second calibration; differences are B − A
    #[arg(value_name = "B")]
    second: PathBuf,
    #[command(flatten)]
    result: ResultArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    args.result.check(None, [&args.first, &args.second])?;
    let (a, first) = Calibration::read_with_input(&args.first)?;
    let (b, second) = Calibration::read_with_input(&args.second)?;
    let result = compare(&a, &b, [&first.path, &second.path])?;
    let figures = args
        .result
        .report
        .figures(|| figure::check::comparison(&result));
    let document = with_origin(report::comparison(&result, &figures), &[first, second]);
    args.result.present(&result, &document)?;
    Ok(quality(result.verdict.judgement.is_change()))
}
