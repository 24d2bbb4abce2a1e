//! `gravical summarise`: epochs of a worn accelerometer.

mod each;

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::Error;
use gravical::calibration_file::{CalibrationFile, InputFile, InputRole};
use gravical::escape::one_line;
use gravical::wearable::{SummariseOptions, WearableSummary, Zone, summarise};
use gravical_report::report;

use crate::each::EachArgs;
use crate::options::{RecordingArgs, read_calibration};
use crate::report::{ReportArgs, with_origin};
use crate::table::TableArgs;

/// Summarise days of a worn accelerometer in epochs: ENMO, MAD, angle z, non-wear
///
/// One row for each epoch: means and standard deviations of the axes and of ‖a‖, ENMO, MAD, the angle
/// of the z axis, non-wear, temperature, and how many samples there are and are missing. The table goes
/// to -o or a pipe, the summary to stderr.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "\
Example: gravical summarise wrist.csv -o epochs.csv --calibration cal.json --time-zone Europe/Berlin
How a recording is read (units, columns, rate): options in `gravical summarise --help`.",
    after_long_help = "\
Examples:
  gravical summarise wrist.csv -o epochs.csv --calibration cal.json
  gravical summarise wrist.csv -o epochs.csv --epoch 60 --time-zone Europe/Berlin
  gravical summarise --each study -o epochs --summary study.csv

Exit codes: 0 done, 3 cannot be read."
)]
pub struct Args {
    /// Recording, plain or .gz; - reads standard input. With --each, many
    #[arg(value_name = "INPUT", required = true, num_args = 1..)]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub output: TableArgs,
    /// Length of an epoch in s, a part of a minute: 1 to 60
    #[arg(long, value_name = "S", default_value_t = 5)]
    epoch: u32,
    /// Calibration to apply first, of `gravical calibrate` or imucal
    #[arg(short, long, value_name = "CAL")]
    calibration: Option<PathBuf>,
    /// Time zone in which times are written, e.g. Europe/Berlin [default: UTC]
    #[arg(long, value_name = "ZONE")]
    time_zone: Option<Zone>,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    each: EachArgs,
    #[command(flatten)]
    recording: RecordingArgs,
}

/// Runs the command.
///
/// # Errors
///
/// An option that does not fit, a calibration in another unit, a file that cannot be read, an existing
/// output file, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let options = args.options();
    options.validate()?;
    if args.each.each {
        return each::run(args, options);
    }
    args.each.refuse_alone()?;
    let [input] = &args.inputs[..] else {
        return Err(Error::usage(
            "one-recording",
            format!(
                "summarise takes one recording, and {} are given",
                args.inputs.len()
            ),
        )
        .with_hint("add --each: then each of them is summarised")
        .into());
    };
    let mut inputs = vec![input.as_path()];
    inputs.extend(args.calibration.as_deref());
    args.output.check(&args.report, &inputs)?;
    let (calibration, used) = args.calibration()?.unzip();
    let summary = args
        .output
        .write(|out| summarise(input, calibration.as_ref(), &options, out))?;
    let mut inputs = vec![InputFile {
        path: summary.input.clone(),
        sha256: summary.sha256.clone(),
        role: InputRole::Recording,
    }];
    inputs.extend(used);
    let document = with_origin(report::wearable(&summary), &inputs);
    args.report.write(args.output.force, &document)?;
    args.output
        .print_summary(&summary, &said(&summary), &document, args.report.detail())?;
    if !args.output.quiet {
        args.report.say();
    }
    Ok(ExitCode::SUCCESS)
}

/// `wrist.csv: 17280 epochs of 5 s`.
fn said(summary: &WearableSummary) -> String {
    format!(
        "{}: {} epochs of {} s",
        one_line(&summary.input),
        summary.worn.epochs,
        summary.epoch_s
    )
}

impl Args {
    fn options(&self) -> SummariseOptions {
        SummariseOptions {
            read: self.recording.read_options(self.report.is_wanted()),
            epoch_s: self.epoch,
            time_zone: self.time_zone.clone(),
            axes: self.recording.axes.0,
        }
    }

    /// The calibration, and its file.
    fn calibration(&self) -> gravical::Result<Option<(CalibrationFile, InputFile)>> {
        let swapped = "--calibration takes the calibration, and INPUT the recording";
        let first = self.inputs.first().map(PathBuf::as_path);
        let read = |path: &PathBuf| read_calibration(path, first, swapped);
        self.calibration.as_ref().map(read).transpose()
    }
}
