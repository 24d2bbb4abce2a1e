//! `gravical noise`: the Allan deviation of a recording at rest.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::escape::path_text;
use gravical::noise::noise;
use gravical::output::write_text;
use gravical::recording::ReadOptions;
use gravical_report::figure::noise::figures;
use gravical_report::report;

use crate::options::reading;
use crate::report::{ResultArgs, with_origin};
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
  gravical export noise.json --to kalibr -o imu.yaml

Two hours at a constant temperature show N and B; K takes longer.")]
pub struct Args {
    /// Recording of a sensor at rest, plain or .gz; - reads standard input
    #[arg(value_name = "INPUT")]
    input: PathBuf,
    /// The result as JSON
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: ResultArgs,
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
    args.result.check(output, [&args.input])?;
    let named = args.result.report.is_wanted() || output.is_some();
    let result = noise(&args.input, &reading(&args.recording, named))?;
    if let Some(path) = output {
        let text = serde_json::to_string_pretty(&result)? + "\n";
        write_text(path, args.result.force, &text)?;
    }
    let figures = args.result.report.figures(|| figures(&result));
    let document = with_origin(report::noise(&result, &figures), &result.inputs);
    args.result.present(&result, &document)?;
    if let Some(path) = output.filter(|_| !args.result.quiet) {
        text::say(&format!("Noise: {}", path_text(path)));
    }
    Ok(ExitCode::SUCCESS)
}
