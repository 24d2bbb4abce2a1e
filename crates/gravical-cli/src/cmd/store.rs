//! `gravical store`: the calibrations of many sensors over time.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::calibration_file::{CalibrationFile, InputFile};
use gravical::compare::Stability;
use gravical::escape::path_text;
use gravical::store::{Query, QueryTimeSource, Store, Stored, StoredCalibration};
use gravical::utc::UtcTime;
use gravical_report::document::Document;
use gravical_report::figure::history::figures;
use gravical_report::report;
use serde::Serialize;

use crate::failure::QUALITY;
use crate::report::{ReportArgs, with_origin};
use crate::store::{Limits, filed};
use crate::text;

/// Keep the calibrations of many sensors, and test whether a sensor changed
///
/// A store is a folder with one folder for each sensor and an ordinary calibration file for each
/// calibration. `gravical calibrate --store DIR` files them; `apply`, `motion` and `check` take the one
/// that fits with `--store DIR`. Folders of imucal are read, too.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  gravical calibrate session/ --sensor-id left-foot --store cals
  gravical apply --store cals walk.csv --sensor-id left-foot -o walk-calibrated.csv
  gravical store list --store cals
  gravical store history left-foot --store cals --report left-foot.html

Exit codes: 0 done; 2 wrong usage; 3 no such sensor, or no calibration that fits;
4 `history`: the sensor changed by more than the uncertainty.")]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    List(ListArgs),
    Show(ShowArgs),
    History(HistoryArgs),
    Add(AddArgs),
}

/// List the sensors of a store
#[derive(clap::Args)]
struct ListArgs {
    #[command(flatten)]
    common: Common,
}

/// Show the calibration of a sensor that fits a time, and why
#[derive(clap::Args)]
#[command(after_help = "Example: gravical store show left-foot --store cals --at 2026-03-09")]
struct ShowArgs {
    /// Id of the sensor
    #[arg(value_name = "ID")]
    sensor: String,
    /// Time of the recording that it has to fit (UTC) [default: now]
    #[arg(long, value_name = "DATE")]
    at: Option<UtcTime>,
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    common: Common,
}

/// Parameters of a sensor over time, and a test whether it changed
#[derive(clap::Args)]
#[command(after_help = "\
Example: gravical store history left-foot --store cals --report left-foot.html

Exit codes: 0 unchanged, or it cannot be decided; 3 no such sensor; 4 changed by
more than the uncertainty (p < 0.01 for all tests together).")]
struct HistoryArgs {
    /// Id of the sensor
    #[arg(value_name = "ID")]
    sensor: String,
    #[command(flatten)]
    common: Common,
}

/// File existing calibrations in a store
#[derive(clap::Args)]
#[command(after_help = "Example: gravical store add cal.json --sensor-id left-foot --store cals")]
struct AddArgs {
    /// Calibrations of gravical
    #[arg(required = true, value_name = "CAL")]
    files: Vec<PathBuf>,
    /// Folder of the store; it is created if necessary
    #[arg(long, value_name = "DIR")]
    store: PathBuf,
    /// Id of the sensor [default: that of each calibration]
    #[arg(long, value_name = "TEXT")]
    sensor_id: Option<String>,
    /// When the session was recorded (UTC) [default: that of each calibration]
    #[arg(long, value_name = "DATE")]
    recorded: Option<UtcTime>,
    /// Print what was filed as JSON
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
struct Common {
    /// Folder of the store
    #[arg(long, value_name = "DIR")]
    store: PathBuf,
    #[command(flatten)]
    report: ReportArgs,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl Args {
    /// Whether errors are written as JSON on stdout.
    pub fn json(&self) -> bool {
        match &self.what {
            What::List(args) => args.common.json,
            What::Show(args) => args.common.json,
            What::History(args) => args.common.json,
            What::Add(args) => args.json,
        }
    }
}

/// Runs the command.
///
/// # Errors
///
/// A store, sensor or calibration that does not exist, an existing report, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    match &args.what {
        What::List(args) => list(args),
        What::Show(args) => show(args),
        What::History(args) => history(args),
        What::Add(args) => add(args),
    }
}

fn list(args: &ListArgs) -> anyhow::Result<ExitCode> {
    let stored = args.common.read()?;
    let list = stored.list();
    let inputs = inputs(&stored.calibrations);
    args.common
        .tell(&list, with_origin(report::store_list(&list), &inputs))?;
    Ok(ExitCode::SUCCESS)
}

/// What would be taken.
#[derive(Serialize)]
struct Shown<'a> {
    choice: &'a gravical::store::Choice,
    calibration: &'a CalibrationFile,
}

fn show(args: &ShowArgs) -> anyhow::Result<ExitCode> {
    let stored = args.common.read()?;
    let mut query = Query::now();
    query.sensor_id = Some(args.sensor.clone());
    if let Some(time) = args.at {
        (query.time, query.time_source) = (time, QueryTimeSource::Given);
    }
    args.limits.set(&mut query);
    let (chosen, choice) = stored.choose(&query)?;
    let shown = Shown {
        choice: &choice,
        calibration: &chosen.file,
    };
    args.common.tell(&shown, report::stored(chosen, &choice))?;
    Ok(ExitCode::SUCCESS)
}

fn history(args: &HistoryArgs) -> anyhow::Result<ExitCode> {
    let stored = args.common.read()?;
    let result = stored.history(&args.sensor)?;
    let figures = figures(&result);
    let inputs = inputs(stored.of(&args.sensor)?);
    let document = with_origin(report::history(&result, &figures), &inputs);
    args.common.tell(&result, document)?;
    Ok(match result.history.verdict.judgement {
        Stability::Changed => ExitCode::from(QUALITY),
        Stability::Unchanged | Stability::Undecided => ExitCode::SUCCESS,
    })
}

fn add(args: &AddArgs) -> anyhow::Result<ExitCode> {
    let mut calibrations = Vec::new();
    // All are read before the first one is filed.
    for path in &args.files {
        let mut file = CalibrationFile::read(path)?;
        if args.sensor_id.is_some() {
            file.sensor.id.clone_from(&args.sensor_id);
        }
        if let Some(time) = args.recorded {
            let source = gravical::calibration_file::RecordingTimeSource::Given;
            file.recorded = Some(gravical::calibration_file::RecordingTime { time, source });
        }
        if file
            .sensor
            .id
            .as_deref()
            .is_none_or(|id| id.trim().is_empty())
        {
            return Err(gravical::Error::usage(
                "sensor-id-missing",
                "the calibration names no sensor, and a store is kept by sensor",
            )
            .at(path, None)
            .with_hint("name it: --sensor-id NAME")
            .into());
        }
        if file.tool == "imucal" && file.recorded.is_none() {
            return Err(gravical::Error::usage(
                "date-missing",
                "a file of imucal does not say when it was recorded",
            )
            .at(path, None)
            .with_hint("give it: --recorded 2026-03-09; or copy the file into the store under imucal's name, ID_2026-03-09_10-15.json")
            .into());
        }
        calibrations.push(file);
    }
    let store = Store::create(&args.store)?;
    let mut done = Vec::new();
    for file in &calibrations {
        let added = store.add(file)?;
        if !args.json {
            text::say(&filed(&added));
        }
        done.push(serde_json::json!({
            "path": path_text(&added.path),
            "existed": added.existed,
        }));
    }
    if args.json {
        text::print_json(&serde_json::json!({ "added": done }))?;
    }
    Ok(ExitCode::SUCCESS)
}

impl Common {
    /// Checks the report and reads the store.
    fn read(&self) -> anyhow::Result<Stored> {
        self.report.check(None, &[], self.force)?;
        Ok(Store::open(&self.store)?.read()?)
    }

    /// Writes the report, prints the result.
    fn tell(&self, result: &impl Serialize, document: Document<'_>) -> anyhow::Result<()> {
        self.report.write(self.force, &document)?;
        if self.json {
            text::print_json(result)?;
        } else {
            text::print_report(&document.to_text(self.report.detail()))?;
        }
        self.report.say();
        Ok(())
    }
}

fn inputs(calibrations: &[StoredCalibration]) -> Vec<InputFile> {
    calibrations.iter().map(|c| c.input.clone()).collect()
}
