//! `gravical orient`: the attitude with its uncertainty.

use std::process::ExitCode;

use gravical::motion::OrientationJudgement;
use gravical_report::{figure, report};

use super::motion::SourceArgs;
use crate::failure::quality;
use crate::report::{ReportArgs, TableArgs, with_origin};

/// Compute the orientation with its uncertainty
///
/// The attitude of `motion`: levelled at rest, by the gyroscope and the mean force in between. Heading is
/// relative to the start. The table goes to -o or a pipe, the summary to stderr.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Start at rest for some seconds, and rest now and then.

Example: gravical orient turn.csv -c cal.json -o q.csv

Exit codes: 0 computed, 3 bad input, 4 the attitude is not known (the table is written)")]
pub struct Args {
    #[command(flatten)]
    output: TableArgs,
    /// Add the acceleration without gravity
    #[arg(long)]
    acceleration: bool,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    source: SourceArgs,
}

/// Runs the command.
///
/// # Errors
///
/// Those of [`SourceArgs::compute`] and [`Motion::orientation`](gravical::motion::Motion::orientation), I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let (output, report) = (&args.output, &args.report);
    let (motion, recording, inputs) = args.source.compute(output, report)?;
    let result = motion.orientation()?;
    output.write_table(&motion.orientation_table(args.acceleration))?;
    let figures = report.figures(|| figure::motion::orientation(&motion));
    let document = with_origin(report::orientation(&result, &recording, &figures), &inputs);
    report.write(output.force, &document)?;
    let done = format!("{}: {} rows", result.computation.input, motion.rows());
    output.print_summary(&result, &done, &document, report.verbose)?;
    report.say(output.quiet);
    Ok(quality(
        result.verdict.judgement == OrientationJudgement::NotKnown,
    ))
}
