//! `gravical calibrate`: a calibration from recordings of static poses.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::Result;
use gravical::calibrate::{CalibrateOptions, EstimateOptions, RecordOptions};
use gravical::calibration_file::{CalibrationFile, Deviations, Grade};
use gravical::escape::path_word;
use gravical::poses::SegmentOptions;
use gravical::recording::ReadOptions;
use gravical::session::{SessionFiles, calibrate_files};
use gravical_report::figure;
use gravical_report::report;

use crate::each::{self, EachArgs, Outcome, Plan};
use crate::failure::quality;
use crate::options::{GravityArgs, command_line, reading};
use crate::report::ResultArgs;
use crate::text;

/// Calibrate a sensor from recordings of static poses
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  gravical calibrate session/ --latitude 48.1 -o cal.json --report cal.html
  gravical calibrate --each sessions/ -o calibrations/ --summary all.csv
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
        done.file.write(path, asked.force)?;
    }
    let figures = if asked.report.is_wanted() {
        let session = (&recordings[..], &done.segmentation);
        figure::calibration::figures(&done.file, Some(session))
    } else {
        Vec::new()
    };
    let document = report::calibration(&done.file, output, &figures);
    asked.present(&done.file, &document)?;
    let verdict = &done.file.verdict;
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
    EachArgs::refuse_beside(&[
        ("--gyro", args.method.files.gyro.is_some()),
        ("--report", args.result.report.is_wanted()),
        ("--json", args.result.json),
        ("--recorded", args.method.record.recorded.is_some()),
        ("--sensor-id", args.method.record.sensor_id.is_some()),
    ])?;
    let options = args.options()?;
    options.validate()?;
    let read = ReadOptions {
        hash: true,
        ..args.recording.clone()
    };
    read.validate()?;
    let gravity = args.gravity.given()?;
    let numbers = COLUMNS.map(|(name, _)| name);
    let plan = Plan {
        each: &args.each,
        inputs: &args.inputs,
        shared: args.other_files(),
        folders: true,
        output: args.output.as_deref(),
        ending: ".json",
        numbers: &numbers,
        force: args.result.force,
        quiet: args.result.quiet,
    };
    let calibrate = |session: &Path, result: Option<&Path>| {
        let input = [session.to_owned()];
        let (_, done) = calibrate_files(&input, None, &read, &options, gravity)?;
        let file = done.file;
        if let Some(result) = result {
            file.write(result, true)?;
        }
        Ok(outcome(&file))
    };
    each::run(&plan, calibrate, |result, session| {
        let file = CalibrationFile::read(result).ok()?;
        let mut inputs = file.inputs.iter();
        let is_own = inputs.any(|input| Path::new(&input.path).starts_with(session));
        is_own.then(|| outcome(&file))
    })
}

/// A cell of a calibration; empty where there is no value.
type OfCalibration = fn(&CalibrationFile) -> Option<String>;

/// Columns of the summary of `--each`, in the units of each calibration.
const COLUMNS: [(&str, OfCalibration); 20] = [
    ("sensor_id", |f| f.sensor.id.clone()),
    ("input_unit", |f| {
        Some(f.accelerometer.input_unit.name().to_owned())
    }),
    ("bias_x", |f| number(f.accelerometer.bias[0])),
    ("bias_y", |f| number(f.accelerometer.bias[1])),
    ("bias_z", |f| number(f.accelerometer.bias[2])),
    ("bias_x_sd", |f| number(deviations(f)?.bias[0])),
    ("bias_y_sd", |f| number(deviations(f)?.bias[1])),
    ("bias_z_sd", |f| number(deviations(f)?.bias[2])),
    ("scale_x", |f| number(f.accelerometer.scale[0])),
    ("scale_y", |f| number(f.accelerometer.scale[1])),
    ("scale_z", |f| number(f.accelerometer.scale[2])),
    ("scale_x_sd", |f| number(deviations(f)?.scale[0])),
    ("scale_y_sd", |f| number(deviations(f)?.scale[1])),
    ("scale_z_sd", |f| number(deviations(f)?.scale[2])),
    ("worst_direction_error_mps2", |f| {
        number(f.accelerometer.worst_direction.as_ref()?.error_mps2)
    }),
    ("predicted_norm_error_mps2", |f| {
        number(f.accelerometer.predicted_norm_error_mps2?)
    }),
    ("leave_one_out_rms_mps2", |f| {
        number(f.accelerometer.leave_one_out_rms_mps2?)
    }),
    ("poses", |f| Some(f.accelerometer.poses.len().to_string())),
    ("temperature_c", |f| number(f.temperature_c?.mean)),
    ("sha256", |f| {
        let sums = f.inputs.iter().filter_map(|i| i.sha256.as_deref());
        Some(sums.collect::<Vec<_>>().join(" "))
    }),
];

fn number(value: f64) -> Option<String> {
    Some(value.to_string())
}

fn deviations(file: &CalibrationFile) -> Option<&Deviations> {
    file.accelerometer.deviations.as_ref()
}

fn outcome(file: &CalibrationFile) -> Outcome {
    Outcome {
        grade: file.verdict.grade.to_string(),
        is_poor: file.verdict.grade == Grade::Poor,
        reasons: file.verdict.reasons.clone(),
        numbers: COLUMNS
            .map(|(_, cell)| cell(file).unwrap_or_default())
            .to_vec(),
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
