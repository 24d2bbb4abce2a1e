//! `gravical calibrate`: a calibration from recordings of static poses.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::Result;
use gravical::calibrate::{CalibrateOptions, EstimateOptions, RecordOptions};
use gravical::calibration_file::{Calibration, Grade};
use gravical::escape::path_word;
use gravical::poses::SegmentOptions;
use gravical::recording::ReadOptions;
use gravical::session::{BY_FOLDER, SessionFiles, calibrate_files};
use gravical_report::figure;
use gravical_report::figure::sessions::Session;
use gravical_report::report;

use crate::each::{self, EachArgs, Item, Outcome, Plan};
use crate::failure::quality;
use crate::options::{GravityArgs, command_line, reading};
use crate::report::{ResultArgs, write_report};
use crate::text;

/// Calibrate a sensor from recordings of static poses
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  gravical calibrate session/ --latitude 48.1 -o cal.json --report cal.html
  gravical calibrate --each sessions/ -o calibrations/ --report all.html
Exit codes: 0 calibrated, 3 undetermined, 4 poor (or one session is, or failed)")]
pub struct Args {
    /// Files, a folder, or - for stdin; with --each, sessions
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// Calibration file (JSON); with --each, a folder
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: ResultArgs,
    #[command(flatten)]
    each: EachArgs,
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    gravity: GravityArgs,
    #[command(flatten)]
    recording: ReadOptions,
}

#[derive(clap::Args)]
#[command(next_help_heading = "Method")]
struct MethodArgs {
    #[command(flatten)]
    estimate: EstimateOptions,
    #[command(flatten)]
    segment: SegmentOptions,
    #[command(flatten)]
    files: SessionFiles,
    #[command(flatten)]
    record: RecordOptions,
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if args.each.each {
        return calibrate_each(args);
    }
    args.each.refuse_alone()?;
    let (output, others) = (args.output.as_deref(), args.other_files());
    args.result
        .check(output, args.inputs.iter().chain(&others))?;
    let options = args.options()?;
    let read = reading(&args.recording, true);
    let (gyro, gravity) = (args.method.files.gyro.as_deref(), args.gravity.given()?);
    let (recordings, done) = calibrate_files(&args.inputs, gyro, &read, &options, gravity)?;
    let asked = &args.result;
    if let Some(path) = output {
        done.calibration.write(path, asked.force)?;
    }
    let session = (&recordings[..], &done.segmentation);
    let draw = || figure::calibration::figures(&done.calibration, Some(session));
    let figures = asked.report.figures(draw);
    let document = report::calibration(&done.calibration, output, &figures);
    asked.present(&done.calibration, &document)?;
    let verdict = done.calibration.verdict();
    let is_poor = verdict.grade == Grade::Poor;
    if asked.quiet && !asked.json && is_poor {
        text::say(&format!("verdict: poor: {}", verdict.reasons.join("; ")));
    }
    if let Some(path) = output.filter(|_| !asked.quiet && !asked.json) {
        text::print(&format!("\nSaved to {}.\n", path_word(path)))?;
    }
    Ok(quality(is_poor))
}

/// Runs the command for each of its sessions.
///
/// # Errors
///
/// What concerns all of them: options, `--sections`, targets.
fn calibrate_each(args: &Args) -> anyhow::Result<ExitCode> {
    let sensor_id = &args.method.record.sensor_id;
    EachArgs::refuse_beside(&[
        ("--gyro", args.method.files.gyro.is_some()),
        ("--figures", args.result.report.has_folder()),
        ("--json", args.result.json),
        ("--recorded", args.method.record.recorded.is_some()),
        (
            "--sensor-id",
            sensor_id.as_ref().is_some_and(|id| id != BY_FOLDER),
        ),
    ])?;
    let options = args.options()?;
    options.validate()?;
    let read = ReadOptions {
        hash: true,
        max_bytes: Some(args.each.max_bytes()),
        ..args.recording.clone()
    };
    read.validate()?;
    let gravity = args.gravity.given()?;
    let numbers: Vec<&str> = COLUMNS.split(' ').collect();
    let plan = Plan {
        each: &args.each,
        inputs: &args.inputs,
        shared: args.other_files(),
        folders: true,
        output: args.output.as_deref(),
        ending: ".json",
        report: args.result.report.page()?,
        numbers: &numbers,
        force: args.result.force,
        quiet: args.result.quiet,
    };
    let calibrate = |item: &Item| {
        let input = [item.path.clone()];
        let (recordings, done) = calibrate_files(&input, None, &read, &options, gravity)?;
        let file = done.calibration;
        if let Some(result) = &item.result {
            file.write(result, true)?;
        }
        if let Some(page) = &item.page {
            let session = Some((&recordings[..], &done.segmentation));
            let figures = figure::calibration::figures(&file, session);
            let document = report::calibration(&file, item.result.as_deref(), &figures);
            write_report(page, true, &document)?;
        }
        Ok(outcome(&file))
    };
    each::run(&plan, calibrate, |result, session| {
        let file = Calibration::read(result).ok()?;
        let mut inputs = file.inputs.iter();
        let is_own = inputs.any(|input| Path::new(&input.path).starts_with(session));
        is_own.then(|| outcome(&file))
    })
}

/// Columns of the summary of `--each`, in the units of each calibration.
const COLUMNS: &str = "sensor_id recorded input_unit bias_x bias_y bias_z bias_x_sd bias_y_sd bias_z_sd \
    scale_x scale_y scale_z scale_x_sd scale_y_sd scale_z_sd worst_direction_error_mps2 \
    predicted_mps2 left_out_rms_mps2 poses temperature_c sha256";

/// A row of the summary; a cell is empty where there is no value.
fn outcome(file: &Calibration) -> Outcome {
    let (a, r) = (&file.accelerometer, &file.reliability);
    let verdict = file.verdict();
    let sd = a.deviations();
    let vectors = [
        Some(a.bias),
        sd.map(|sd| sd.bias),
        Some(a.scale()),
        sd.map(|sd| sd.scale),
    ];
    let numbers = vectors
        .iter()
        .flat_map(|v| [0, 1, 2].map(|axis| v.map(|v| v[axis])));
    let numbers = numbers.chain([
        r.worst_direction.as_ref().map(|w| w.error_mps2),
        r.predicted_mps2,
        r.left_out_rms_mps2,
        Some(file.poses.len() as f64),
        file.temperature_c.map(|t| t.mean),
    ]);
    let numbers = numbers.map(|v| v.map_or(String::new(), |v| v.to_string()));
    let recorded = file.recorded.as_ref();
    let recorded = recorded.map_or(String::new(), |r| r.time.minute());
    let names = [
        file.sensor.id.clone().unwrap_or_default(),
        recorded.clone(),
        a.input_unit.name().to_owned(),
    ];
    let sums = file.inputs.iter().filter_map(|i| i.sha256.as_deref());
    let sums = sums.collect::<Vec<_>>().join(" ");
    Outcome {
        grade: verdict.grade.to_string(),
        is_poor: verdict.grade == Grade::Poor,
        reasons: verdict.reasons,
        numbers: names.into_iter().chain(numbers).chain([sums]).collect(),
        session: Session {
            sensor: file
                .sensor
                .id
                .clone()
                .or(file.sensor.model.clone())
                .unwrap_or_default(),
            recorded,
            grade: Some(verdict.grade),
            error_mps2: r.worst_direction.as_ref().map(|w| w.error_mps2),
            ..Session::default()
        },
        ..Outcome::default()
    }
}

impl Args {
    /// Files that are read beside the session.
    fn other_files(&self) -> Vec<PathBuf> {
        self.method.files.paths().cloned().collect()
    }

    fn options(&self) -> Result<CalibrateOptions> {
        let m = &self.method;
        let mut options = CalibrateOptions {
            segment: m.segment.clone(),
            gravity: self.gravity.given()?.unwrap_or_default(),
            estimate: m.estimate.clone(),
            record: m.record.clone(),
            command: Some(command_line()),
            ..CalibrateOptions::default()
        };
        m.files
            .read_into(&mut options, &reading(&self.recording, true))?;
        Ok(options)
    }
}
