//! `gravical denoise`: a filtered recording, and the effect on its noise.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::denoise::{DenoiseOptions, denoise, denoise_file};
use gravical::recording::{ReadOptions, read_samples};
use gravical_report::{figure, report};

use crate::options::reading;
use crate::report::{ReportArgs, TableArgs, with_origin};

/// Filter a recording and report the effect on its noise
///
/// Columns keep their names, units and order; only the values of the filtered channels change. The
/// table goes to -o or a pipe, the summary to stderr. Smoothing makes plots readable; it does not
/// reduce the drift of velocity or position.
#[derive(Debug, clap::Args)]
#[command(after_help = FILTERS)]
pub struct Args {
    /// Recording, plain or .gz; - reads standard input
    #[arg(value_name = "INPUT")]
    input: PathBuf,
    #[command(flatten)]
    output: TableArgs,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    options: DenoiseOptions,
    #[command(flatten)]
    recording: ReadOptions,
}

const FILTERS: &str = "\
Filters:
  savgol:WINDOW,ORDER         Savitzky-Golay polynomial over WINDOW samples
  butter:ORDER,CUTOFFHz       Butterworth low-pass, zero phase
  highpass:ORDER,CUTOFFHz     high-pass
  hampel:WINDOW,SIGMAS        outliers replaced by the median of their window
Butterworth filters are 3 dB down at the cutoff, the two passes together.

Example: gravical denoise walk.csv -f hampel:7,3 -f butter:4,5Hz -o smooth.csv";

/// Runs the command.
///
/// # Errors
///
/// A filter that does not exist or does not fit the rate, a file that cannot be read, an existing
/// output file, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    args.options.validate()?;
    let output = &args.output;
    output.check(&args.report, [&args.input])?;
    let read_options = reading(&args.recording, args.report.is_wanted());
    let (summary, inputs) =
        output.write(|out| denoise_file(&args.input, &read_options, &args.options, out))?;
    let mut figures = args.report.figures(|| figure::denoise::denoise(&summary));
    // What was written is read no more: the recording is filtered once more for its figures.
    if args.report.draws() && args.input != Path::new("-") {
        let raw = read_samples(&args.input, &read_options)?;
        let mut filtered = raw.clone();
        denoise(&mut filtered, &args.options)?;
        figures.extend(figure::denoise::before_and_after(&raw, &filtered));
    }
    let document = with_origin(report::denoise(&summary, &figures), &inputs);
    args.report.write(output.force, &document)?;
    let done = format!("{}: {} rows filtered", summary.input, summary.rows);
    output.print_summary(&summary, &done, &document, args.report.verbose)?;
    args.report.say(output.quiet);
    Ok(ExitCode::SUCCESS)
}
