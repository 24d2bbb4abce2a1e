//! `gravical convert`: any recording as a plain table.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::convert::{ConvertOptions, ConvertSummary, convert_file};
use gravical::numfmt;
use gravical::recording::ReadOptions;
use gravical_report::document::{Document, Section};

use crate::options::reading;
use crate::report::{ReportArgs, TableArgs, how_it_was_read};

/// Write a recording of any format as a plain table in SI units
///
/// Nothing is calibrated or filtered: time_s, ax_m_s2 …, gx_rad_s …, temperature_c, and a label if
/// there is one. Other columns are left out, breaks are blank lines. The table goes to -o or a
/// pipe, the summary to stderr.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  gravical convert wrist.cwa -o wrist.csv
  gravical convert wrist.cwa --absolute-time --output-unit g -o wrist.csv.gz")]
pub struct Args {
    /// Recording: text or .cwa, plain or .gz; - reads standard input
    #[arg(value_name = "INPUT")]
    input: PathBuf,
    #[command(flatten)]
    output: TableArgs,
    #[command(flatten)]
    options: ConvertOptions,
    /// Print all findings
    #[arg(short, long)]
    verbose: bool,
    #[command(flatten)]
    recording: ReadOptions,
}

/// Runs the command.
///
/// # Errors
///
/// A file that cannot be read, counts of unknown range, an existing output file, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let output = &args.output;
    output.check(&ReportArgs::default(), [&args.input])?;
    let read = reading(&args.recording, false);
    let summary = output.write(|out| convert_file(&args.input, &read, &args.options, out))?;
    let done = format!("{}: {} rows converted", summary.input, summary.rows);
    output.print_summary(&summary, &done, &document(&summary), args.verbose)?;
    Ok(ExitCode::SUCCESS)
}

/// The summary as a document.
fn document(summary: &ConvertSummary) -> Document<'static> {
    let unit = summary.accelerometer.unit;
    let written = numfmt::unit(summary.output_unit.name());
    let gyro = summary.gyroscope.as_ref().map(|gyro| gyro.unit.to_string());
    let facts = Section::new("How it was read")
        .fact("read as", summary.description.clone())
        .fact("serial number", summary.serial.clone())
        .fact("accelerometer", format!("{unit} → {written}"))
        .fact("gyroscope", gyro)
        .fact("columns", summary.columns.join(", "));
    how_it_was_read(facts, &summary.findings)
}
