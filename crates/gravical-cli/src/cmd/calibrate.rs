//! `gravical calibrate`: a calibration from recordings of static poses.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::Result;
use gravical::calibrate::{CalibrateOptions, EstimateOptions, RecordOptions};
use gravical::calibration_file::{CalibrationFile, Grade, InputFile};
use gravical::escape::path_word;
use gravical::noise::{NoiseResult, read_noise};
use gravical::poses::SegmentOptions;
use gravical::recording::ReadOptions;
use gravical::session::{self, SessionCalibration, SessionFiles};
use gravical_report::figure;
use gravical_report::figure::calibration::Session;
use gravical_report::report;

use crate::each::{self, EachArgs, Outcome, Plan};
use crate::failure::quality;
use crate::options::{GravityArgs, command_line, reading};
use crate::report::ReportArgs;
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
    report: ReportArgs,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print the calibration as JSON instead of the report
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
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
    /// Result of `gravical noise`, stored
    #[arg(long, value_name = "FILE")]
    noise: Option<PathBuf>,
    #[command(flatten)]
    record: RecordOptions,
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if args.each.each {
        return calibrate_each(args);
    }
    args.each.refuse_alone()?;
    // Checked before the work starts.
    let others = args.other_files();
    let files = args.inputs.iter().chain(&others);
    args.report
        .check(args.output.as_deref(), files, args.force)?;
    let options = args.options()?;
    let noise = args.method.noise.as_deref().map(read_noise).transpose()?;
    let read_options = reading(&args.recording, true);
    let computed = compute(args, &args.inputs, &read_options, &options, noise.as_ref())?;
    let SessionCalibration {
        file,
        segmentation,
        recordings,
    } = computed;
    if let Some(path) = &args.output {
        file.write(path, args.force)?;
    }
    let session = Session {
        recordings: &recordings,
        segmentation: &segmentation,
    };
    let figures = if args.report.is_wanted() {
        figure::calibration::figures(&file, Some(session))
    } else {
        Vec::new()
    };
    let document = report::calibration(&file, args.output.as_deref(), &figures);
    args.report.write(args.force, &document)?;
    if !args.quiet {
        args.report.say();
    }
    if args.json {
        text::print_json(&file)?;
    } else if args.quiet {
        if file.verdict.grade == Grade::Poor {
            text::say(&format!(
                "verdict: poor: {}",
                file.verdict.reasons.join("; ")
            ));
        }
    } else {
        text::print_report(&document.to_text(args.report.detail()))?;
        if let Some(path) = &args.output {
            text::print(&format!("\nSaved to {}.\n", path_word(path)))?;
        }
    }
    Ok(quality(file.verdict.grade == Grade::Poor))
}

/// Runs the command for each of its sessions.
///
/// # Errors
///
/// What concerns all of them: options, `--noise`, `--sections`, targets.
fn calibrate_each(args: &Args) -> anyhow::Result<ExitCode> {
    EachArgs::refuse_beside(&[
        ("--gyro", args.method.files.gyro.is_some()),
        ("--report", args.report.is_wanted()),
        ("--json", args.json),
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
    let noise = args.method.noise.as_deref().map(read_noise).transpose()?;
    let plan = Plan {
        each: &args.each,
        inputs: &args.inputs,
        shared: args.other_files(),
        folders: true,
        output: args.output.as_deref(),
        ending: ".json",
        numbers: &NUMBERS,
        force: args.force,
        quiet: args.quiet,
    };
    let calibrate = |session: &Path, result: Option<&Path>| {
        let input = [session.to_owned()];
        let file = compute(args, &input, &read, &options, noise.as_ref())?.file;
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

/// Columns of the summary of `--each`, in the units of each calibration.
const NUMBERS: [&str; 20] = [
    "sensor_id",
    "input_unit",
    "bias_x",
    "bias_y",
    "bias_z",
    "bias_x_sd",
    "bias_y_sd",
    "bias_z_sd",
    "scale_x",
    "scale_y",
    "scale_z",
    "scale_x_sd",
    "scale_y_sd",
    "scale_z_sd",
    "worst_direction_error_mps2",
    "predicted_norm_error_mps2",
    "leave_one_out_rms_mps2",
    "poses",
    "temperature_c",
    "sha256",
];

fn outcome(file: &CalibrationFile) -> Outcome {
    let a = &file.accelerometer;
    let number = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    let mut numbers = vec![
        file.sensor.id.clone().unwrap_or_default(),
        a.input_unit.name().to_owned(),
    ];
    let sd = a.deviations.as_ref();
    for (values, sd) in [(a.bias, sd.map(|d| d.bias)), (a.scale, sd.map(|d| d.scale))] {
        numbers.extend(values.map(|v| number(Some(v))));
        numbers.extend([0, 1, 2].map(|axis| number(sd.map(|sd| sd[axis]))));
    }
    numbers.extend([
        number(a.worst_direction.as_ref().map(|w| w.error_mps2)),
        number(a.predicted_norm_error_mps2),
        number(a.leave_one_out_rms_mps2),
        a.poses.len().to_string(),
        number(file.temperature_c.map(|t| t.mean)),
    ]);
    let sums = file
        .inputs
        .iter()
        .filter_map(|input| input.sha256.as_deref());
    numbers.push(sums.collect::<Vec<_>>().join(" "));
    Outcome {
        grade: file.verdict.grade.to_string(),
        is_poor: file.verdict.grade == Grade::Poor,
        reasons: file.verdict.reasons.clone(),
        numbers,
        ..Outcome::default()
    }
}

/// The calibration of one session.
///
/// # Errors
///
/// Those of reading and of the library.
fn compute(
    args: &Args,
    inputs: &[PathBuf],
    read_options: &ReadOptions,
    options: &CalibrateOptions,
    noise: Option<&(NoiseResult, InputFile)>,
) -> Result<SessionCalibration> {
    let session = session::Session {
        inputs,
        gyro: args.method.files.gyro.as_deref(),
        read: read_options,
        options,
        gravity: args.gravity.given()?,
    };
    let mut done = session.calibrate()?;
    if let Some((noise, input)) = noise {
        done.file.noise = Some(noise.section());
        done.file.inputs.push(input.clone());
    }
    Ok(done)
}

impl Args {
    /// Files that are read beside the session.
    fn other_files(&self) -> Vec<PathBuf> {
        let files = self.method.files.paths().chain(&self.method.noise);
        files.cloned().collect()
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
