//! `gravical convert`: any recording as a plain table.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::convert::{ConvertOptions, ConvertSummary, convert_file};
use gravical::escape::one_line;
use gravical::numfmt;
use gravical_report::document::Document;

use crate::options::{OutputUnitArg, RecordingArgs};
use crate::report::ReportArgs;
use crate::table::{TableArgs, how_it_was_read};

/// Write a recording of any format as a plain table in SI units
///
/// Nothing is calibrated or filtered: time_s, ax_m_s2 …, gx_rad_s …, temperature_c, and a label if
/// there is one. Other columns are left out, breaks are blank lines. The table goes to -o or a
/// pipe, the summary to stderr.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  gravical convert wrist.cwa -o wrist.csv
  gravical convert wrist.cwa --absolute-time --output-unit g -o wrist.csv.gz
How a recording is read (units, columns, rate): options in `gravical convert --help`.")]
pub struct Args {
    /// Recording: text or .cwa, plain or .gz; - reads standard input
    #[arg(value_name = "INPUT")]
    input: PathBuf,
    #[command(flatten)]
    pub output: TableArgs,
    /// Unit of the acceleration; with g angular rates are in °/s
    #[arg(long, value_enum, value_name = "UNIT", default_value = "m/s^2")]
    output_unit: OutputUnitArg,
    /// Times in seconds since 1970, by the clock of the recorder; default: since the first row
    #[arg(long)]
    absolute_time: bool,
    /// Print all findings
    #[arg(short, long)]
    verbose: bool,
    #[command(flatten)]
    recording: RecordingArgs,
}

/// Runs the command.
///
/// # Errors
///
/// A file that cannot be read, counts of unknown range, an existing output file, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    args.recording
        .refuse_axes("convert writes each axis as it is")?;
    args.output.check(&ReportArgs::default(), &[&args.input])?;
    let options = ConvertOptions {
        output_unit: args.output_unit.into(),
        absolute_time: args.absolute_time,
    };
    let read = args.recording.read_options(false);
    let summary = args
        .output
        .write(|out| convert_file(&args.input, &read, &options, out))?;
    let (input, rows) = (one_line(&summary.input), summary.rows);
    let done = format!("{input}: {rows} rows converted");
    let detail = ReportArgs::detail_of(args.verbose);
    args.output
        .print_summary(&summary, &done, &document(&summary), detail)?;
    Ok(ExitCode::SUCCESS)
}

/// The summary as a document.
fn document(summary: &ConvertSummary) -> Document<'static> {
    let mut facts: Vec<(String, String)> = Vec::new();
    let mut fact = |name: &str, text: String| facts.push((name.to_owned(), text));
    fact("read as", summary.description.clone());
    if let Some(serial) = &summary.serial {
        fact("serial number", serial.clone());
    }
    let unit = summary.accelerometer.unit;
    let written = numfmt::unit(summary.output_unit.name());
    fact("accelerometer", format!("{unit} → {written}"));
    if let Some(gyro) = &summary.gyroscope {
        fact("gyroscope", gyro.unit.to_string());
    }
    fact("columns", summary.columns.join(", "));
    how_it_was_read(facts, &summary.findings)
}
