//! `gravical apply`: a calibrated recording.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context as _;
use gravical::apply::{ApplyOptions, ApplySummary, GyroscopeOutcome, apply};
use gravical::output::write_atomic;
use gravical::recording::{ReadOptions, source};
use gravical::{Error, numfmt};
use gravical_report::document::{Document, Section};
use gravical_report::report::origin;
use serde::Serialize;

use crate::calibration::{OriginArgs, files_of};
use crate::each::{self, EachArgs, Item, Outcome, Plan};
use crate::options::reading;
use crate::report::{ReportArgs, TableArgs, how_it_was_read};

/// Apply a calibration to a recording
///
/// The calibrated channels replace the raw ones (ax_mps2 …, gx_rad_s …); all other columns are copied
/// unchanged. One pass, recordings of any size. The table goes to -o or a pipe, the summary to stderr.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  gravical apply cal.json ride.csv -o ride-calibrated.csv
  gravical apply cals/ ride.csv --sensor-id left-foot -o ride-calibrated.csv
  gravical apply cal.json rides/*.csv -o calibrated/

Exit codes: 0 done, 3 bad input, 4 one of many recordings failed")]
pub struct Args {
    /// File of `gravical calibrate` or imucal, or a folder
    #[arg(value_name = "CAL")]
    calibration: PathBuf,
    /// Recording, - for stdin; several need -o DIR
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    output: TableArgs,
    #[command(flatten)]
    options: ApplyOptions,
    /// Print all findings
    #[arg(short, long)]
    verbose: bool,
    #[command(flatten)]
    each: EachArgs,
    #[command(flatten)]
    origin: OriginArgs,
    #[command(flatten)]
    recording: ReadOptions,
}

/// Runs the command.
///
/// # Errors
///
/// A calibration in another unit, a file that cannot be read, an existing output file, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let path = match &args.inputs[..] {
        [one] if !args.each.each => {
            args.each.refuse_alone()?;
            one
        }
        _ => return apply_each(args, &args.inputs),
    };
    let calibrations = files_of(&args.calibration);
    let inputs = calibrations.iter().chain([path]).chain(&args.options.gyro);
    args.output.check(&ReportArgs::default(), inputs)?;
    let options = args.options(&reading(&args.recording, false));
    let recordings = std::slice::from_ref(path);
    let (origin, output) = (&args.origin, &args.output);
    let (calibration, quiet) = (&args.calibration, output.quiet);
    let (found, file) = origin.read(calibration, recordings, &options.read, quiet)?;
    options.read.validate()?;
    let input = source::open(path, &options.read)?;
    let name = path.display().to_string();
    let summary = output.write(|out| apply(&found, input, &name, out, &options))?;
    let done = format!("{}: {} rows calibrated", summary.input, summary.rows);
    let document = document(&summary);
    let applied = Applied {
        calibration: &file.path,
        summary: &summary,
    };
    output.print_summary(&applied, &done, &document, args.verbose)?;
    Ok(ExitCode::SUCCESS)
}

/// The summary, and the calibration that was taken.
#[derive(Serialize)]
struct Applied<'a> {
    calibration: &'a str,
    #[serde(flatten)]
    summary: &'a ApplySummary,
}

/// Runs the command for each of its recordings.
///
/// # Errors
///
/// What concerns all of them: options, the calibration, targets; `each-option` (usage) without a
/// folder for the results.
fn apply_each(args: &Args, inputs: &[PathBuf]) -> anyhow::Result<ExitCode> {
    EachArgs::refuse_beside(&[
        ("--gyro", args.options.gyro.is_some()),
        ("--json", args.output.json),
    ])?;
    args.origin.refuse(&args.calibration)?;
    let Some(output) = args.output.output.as_deref() else {
        let what = "several recordings need a folder for their results";
        let error = Error::usage("each-option", what);
        return Err(error.with_hint("give -o DIR").into());
    };
    let options = args.options(&args.recording);
    options.read.validate()?;
    let (origin, quiet) = (&args.origin, args.output.quiet);
    let (calibration, _) = origin.read(&args.calibration, inputs, &options.read, quiet)?;
    let plan = Plan {
        each: &args.each,
        inputs,
        shared: files_of(&args.calibration),
        folders: false,
        output: Some(output),
        ending: ".csv",
        report: None,
        numbers: &["rows"],
        force: args.output.force,
        quiet: args.output.quiet,
    };
    let apply = |item: &Item| {
        let result = item.result.as_deref().context("no result is wanted")?;
        let name = item.path.display().to_string();
        let input = source::open(&item.path, &options.read)?;
        let summary = write_atomic(result, true, |out| {
            apply(&calibration, input, &name, out, &options)
        })?;
        Ok(Outcome {
            grade: "done".to_owned(),
            numbers: vec![summary.rows.to_string()],
            ..Outcome::default()
        })
    };
    each::run(&plan, apply, |_, _| {
        Some(Outcome {
            grade: "done before".to_owned(),
            ..Outcome::default()
        })
    })
}

impl Args {
    fn options(&self, read: &ReadOptions) -> ApplyOptions {
        ApplyOptions {
            read: read.clone(),
            ..self.options.clone()
        }
    }
}

/// The summary as a document.
fn document(summary: &ApplySummary) -> Document<'static> {
    let at_rest = summary.quiet_norm_mps2.map_or(String::new(), |norm| {
        let g = summary.gravity_mps2;
        format!("; {norm:.3} m/s² at rest, gravity {g:.3}")
    });
    let scale = summary.accelerometer;
    let (unit, how) = (scale.unit, origin(scale.origin));
    let written = numfmt::unit(summary.output_unit.name());
    let accelerometer = format!("{unit} ({how}) → {written}{at_rest}");
    let gyroscope = match summary.gyroscope {
        GyroscopeOutcome::Calibrated(unit) => Some(format!("{unit} → rad/s")),
        GyroscopeOutcome::Kept => Some("unchanged: the calibration has no gyroscope".to_owned()),
        GyroscopeOutcome::Absent => None,
    };
    let temperature = summary.temperature.as_ref().map(|t| {
        let (channels, [low, high]) = (t.channels.join(", "), t.range_c);
        format!("drift of {channels} subtracted, measured from {low:.1} to {high:.1} °C")
    });
    let aside = summary.set_aside.iter();
    let aside = aside.map(|aside| format!(" + {} {}", aside.lines, aside.reason.name()));
    let aside: String = aside.collect();
    let lines = format!("{} = {} rows{aside}", summary.lines, summary.rows);
    let facts = Section::new("How it was read")
        .fact("read as", summary.description.clone())
        .fact("accelerometer", accelerometer)
        .fact("gyroscope", gyroscope)
        .fact("temperature", temperature)
        .fact("lines", lines);
    how_it_was_read(facts, &summary.findings)
}
