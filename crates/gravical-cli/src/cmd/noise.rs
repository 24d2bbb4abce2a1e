//! `gravical noise`: the Allan deviation of a recording at rest.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::Error;
use gravical::escape::path_text;
use gravical::export::kalibr;
use gravical::noise::noise;
use gravical::output::write_text;
use gravical::recording::ReadOptions;
use gravical_report::figure::noise::figures;
use gravical_report::report;

use crate::options::reading;
use crate::report::{ReportArgs, with_origin};
use crate::text;

/// Determine the noise of a sensor at rest (Allan deviation)
///
/// For each channel the noise density N, the bias instability B and the random walk K with 95 %
/// intervals, or how long a recording would show them. What moves is not noise: only static
/// intervals are used.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  gravical noise desk.csv --report noise.html
  gravical noise desk.csv -o noise.json
  gravical noise desk.csv --to kalibr -o imu.yaml

Two hours at a constant temperature show N and B; K takes longer.")]
pub struct Args {
    /// Recording of a sensor at rest, plain or .gz; - reads standard input
    #[arg(value_name = "INPUT")]
    input: PathBuf,
    /// The result as JSON, or that of --to
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    report: ReportArgs,
    /// kalibr: its imu.yaml, to -o or stdout
    #[arg(long, value_name = "TARGET", value_parser = ["kalibr"], hide_possible_values = true)]
    to: Option<String>,
    /// With --to: limits for what is not determined
    #[arg(long, requires = "to")]
    upper_limit: bool,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: ReadOptions,
}

/// Runs the command.
///
/// # Errors
///
/// A file that cannot be read, a sensor that is never at rest, an existing output file, I/O
/// errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let output = args.output.as_deref();
    if args.to.is_some() && args.json && output.is_none() {
        return Err(Error::usage(
            "json-needs-output",
            "--json and --to would both write to stdout",
        )
        .with_hint("name the file of --to with -o")
        .into());
    }
    args.report.check(output, [&args.input], args.force)?;
    let named = args.report.is_wanted() || output.is_some();
    let read = reading(&args.recording, named);
    let result = noise(&args.input, &read)?;
    let figures = figures(&result);
    let document = with_origin(report::noise(&result, &figures), &result.inputs);
    args.report.write(args.force, &document)?;
    if args.json {
        text::print_json(&result)?;
    } else if !args.quiet {
        let report = document.to_text(args.report.detail());
        if args.to.is_some() && output.is_none() {
            text::say_report(report.trim_end());
        } else {
            text::print_report(&report)?;
        }
        args.report.say();
    }
    // What is refused here does not take the analysis away.
    let written = if args.to.is_some() {
        let export = kalibr(&result.section(), args.upper_limit)?;
        for note in export.notes.iter().filter(|_| !args.quiet) {
            text::say(&format!("note: {note}"));
        }
        export.text
    } else {
        serde_json::to_string_pretty(&result)? + "\n"
    };
    match output {
        Some(path) => {
            write_text(path, args.force, &written)?;
            if !args.quiet {
                text::say(&format!("Noise: {}", path_text(path)));
            }
        }
        None if args.to.is_some() => text::print(&written)?,
        None => {}
    }
    Ok(ExitCode::SUCCESS)
}
