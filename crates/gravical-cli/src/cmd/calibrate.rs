//! `gravical calibrate`: a calibration from recordings of static poses.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::calibrate::{self, CalibrateOptions, EstimateOptions};
use gravical::calibration_file::{CalibrationFile, Grade, InputFile, InputRole, SensorInfo};
use gravical::escape::path_word;
use gravical::noise::{NoiseResult, read_noise};
use gravical::output::is_special;
use gravical::poses::SegmentOptions;
use gravical::poses::sections::read_sections;
use gravical::recording::{ReadOptions, Recording, read};
use gravical::session::{self, SessionCalibration};
use gravical::utc::UtcTime;
use gravical::{Error, Result};
use gravical_report::figure;
use gravical_report::figure::calibration::Session;
use gravical_report::report;

use crate::each::{self, EachArgs, Outcome, Plan};
use crate::failure::QUALITY;
use crate::figures::FigureArgs;
use crate::options::command_line;
use crate::options::{GravityArgs, RecordingArgs};
use crate::report::{ReportArgs, check_outputs, next_step};
use crate::text;

/// Calibrate a sensor from recordings of static poses
#[derive(clap::Args)]
#[command(
    after_help = "\
Example: gravical calibrate session/ --latitude 48.1 -o cal.json --report cal.html
More options (method, how a recording is read): `gravical calibrate --help`.",
    after_long_help = "\
Example: gravical calibrate session/ --latitude 48.1 -o cal.json --report cal.html

A session is one file per pose, a folder of such files, the folder of a guided
session (`gravical live`), one file per axis with
blank rows between the two directions, one file with a label column, one file
with --sections, or one continuous recording in which the poses are found.

Many sessions: gravical calibrate --each sessions/ -o calibrations/ --summary all.csv
Each path is a session then; of a folder, each of its entries; @LIST stands for the
paths in a file. A session that fails is a row and does not stop the others. After
Ctrl-C, --resume continues.

Exit codes: 0 calibrated; 3 the parameters cannot be determined (nothing is
written); 4 calibrated, but the verdict is poor (the file is still written); with
--each: 4 a session is poor or has no result."
)]
pub struct Args {
    /// Recordings of the session: files, or one folder; - reads standard input. With --each, sessions
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// Gyroscope of the recording in a second file, joined by time
    #[arg(long, value_name = "FILE")]
    gyro: Option<PathBuf>,
    /// Calibration file to write (JSON); with --each, a folder for one of each session
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// When the session was recorded (UTC), stored in the calibration [default: by its time stamps]
    #[arg(long, hide_short_help = true, value_name = "DATE")]
    recorded: Option<UtcTime>,
    #[command(flatten)]
    report: ReportArgs,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print the calibration as JSON instead of the report
    #[arg(long)]
    pub json: bool,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    each: EachArgs,
    #[command(flatten)]
    figures: FigureArgs,
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    gravity: GravityArgs,
    #[command(flatten)]
    recording: RecordingArgs,
}

#[derive(clap::Args)]
#[command(next_help_heading = "Method")]
struct MethodArgs {
    /// Estimation method
    #[arg(long, value_enum, default_value = "joint")]
    method: Method,
    /// Poses as row ranges of one recording: JSON of imucal, or CSV label,start,end
    #[arg(long, value_name = "FILE")]
    sections: Option<PathBuf>,
    /// Use the first N rows of each pose [default: its longest static interval]
    #[arg(long, hide_short_help = true, value_name = "N")]
    rows: Option<usize>,
    /// What decides which face was up when file names and data disagree
    #[arg(long, hide_short_help = true, value_enum, default_value = "data")]
    faces_from: FacesFrom,
    /// Signed angle of the turns about each axis in degrees, for the gyroscope
    #[arg(
        long,
        hide_short_help = true,
        value_name = "DEG",
        allow_negative_numbers = true,
        default_value = "-360"
    )]
    turn_angle: f64,
    /// Expected tilt of the face poses, degrees (standard deviation in each of two directions):
    /// 0.1 in a jig, 0.5 to 1 in a box on a table, 2 by hand [default: estimated, else 1]
    #[arg(long, value_name = "DEG")]
    pose_tilt: Option<f64>,
    /// Data sheet limits of scale, cross-axis and bias as prior knowledge
    #[arg(long, hide_short_help = true, value_enum, default_value = "data-sheet")]
    prior: Prior,
    /// Treat this pose (label or file) as a free pose, even near a face; repeatable
    #[arg(
        long,
        hide_short_help = true,
        value_name = "NAME",
        allow_hyphen_values = true
    )]
    free_pose: Vec<String>,
    /// Treat this pose as a face pose, even if tilted; repeatable
    #[arg(
        long,
        hide_short_help = true,
        value_name = "NAME",
        allow_hyphen_values = true
    )]
    face_pose: Vec<String>,
    /// Fit a temperature model to this recording of the sensor at rest while it warms or cools;
    /// repeatable for more poses [default: from the session if it spans more than 5 °C]
    #[arg(long, hide_short_help = true, value_name = "FILE")]
    thermal: Vec<PathBuf>,
    /// Noise of the sensor by `gravical noise`, stored in the calibration
    #[arg(long, value_name = "FILE")]
    noise: Option<PathBuf>,
    /// Name or serial number of the sensor, stored in the calibration
    #[arg(long, hide_short_help = true, value_name = "TEXT")]
    sensor_id: Option<String>,
    /// Type of the sensor, stored in the calibration
    #[arg(long, hide_short_help = true, value_name = "TEXT")]
    sensor_model: Option<String>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Method {
    /// Face and free poses in one fit that allows for tilted face poses
    Joint,
    /// Six faces, closed form
    Ferraris,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Prior {
    /// Scale ±3 %, cross-axis ±2 %, bias ±0.6 m/s²
    DataSheet,
    /// None
    Off,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum FacesFrom {
    /// The measured direction of gravity
    Data,
    /// Names of files and labels
    Names,
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if args.each.each {
        return calibrate_each(args);
    }
    args.each.refuse_alone()?;
    // Checked before the work starts.
    let others = args.other_files();
    let inputs = args.inputs.iter().chain(&others).map(PathBuf::as_path);
    check_outputs(
        args.output.as_deref(),
        &args.report,
        Some(&args.figures),
        &inputs.collect::<Vec<_>>(),
        args.force,
    )?;
    let options = args.options()?;
    let noise = args.method.noise.as_deref().map(read_noise).transpose()?;
    let read_options = args.recording.read_options(true);
    let computed = compute(args, &args.inputs, &read_options, &options, noise.as_ref())?;
    let SessionCalibration {
        file,
        segmentation,
        recordings,
    } = computed;
    if let Some(path) = &args.output {
        save(path, args.force, &file)?;
    }
    let session = Session {
        recordings: &recordings,
        segmentation: &segmentation,
    };
    let drawn = args.report.is_wanted() || args.figures.figures.is_some();
    let figures = match drawn {
        true => figure::calibration::figures(&file, Some(session)),
        false => Vec::new(),
    };
    args.figures.write(&figures, args.force, args.quiet)?;
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
        text::print(&next_step(&document, args.report.detail()))?;
    }
    Ok(match file.verdict.grade {
        Grade::Poor => ExitCode::from(QUALITY),
        _ => ExitCode::SUCCESS,
    })
}

/// Runs the command for each of its sessions.
///
/// # Errors
///
/// What concerns all of them: options, `--noise`, `--sections`, targets.
fn calibrate_each(args: &Args) -> anyhow::Result<ExitCode> {
    EachArgs::refuse_beside(&[
        ("--gyro", args.gyro.is_some()),
        ("--report", args.report.is_wanted()),
        ("--figures", args.figures.figures.is_some()),
        ("--json", args.json),
        ("--recorded", args.recorded.is_some()),
        ("--sensor-id", args.method.sensor_id.is_some()),
    ])?;
    let options = args.options()?;
    options.validate()?;
    let read = ReadOptions {
        meter: None,
        ..args.recording.read_options(true)
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
            save(result, true, &file)?;
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
        grade: file.verdict.grade.name().to_owned(),
        is_poor: file.verdict.grade == Grade::Poor,
        reasons: file.verdict.reasons.clone(),
        numbers,
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
        gyro: args.gyro.as_deref(),
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
        let m = &self.method;
        let files = self.gyro.iter().chain(&m.sections).chain(&m.noise);
        files.chain(&m.thermal).cloned().collect()
    }

    /// The recordings of --thermal.
    fn thermal(&self) -> Result<Vec<Recording>> {
        let options = self.recording.read_options(true);
        let files = self.method.thermal.iter();
        files.map(|file| read(file, &options)).collect()
    }

    fn options(&self) -> Result<CalibrateOptions> {
        let m = &self.method;
        let sections = m.sections.as_deref().map(read_sections);
        let (sections, list) = sections.transpose()?.unzip();
        Ok(CalibrateOptions {
            segment: SegmentOptions {
                rows: m.rows,
                sections,
                axes: self.recording.axes.0,
                faces_by_name: m.faces_from == FacesFrom::Names,
                turn_angle_deg: m.turn_angle,
            },
            gravity: self.gravity.given()?.unwrap_or_default(),
            estimate: EstimateOptions {
                method: match m.method {
                    Method::Joint => calibrate::Method::Joint,
                    Method::Ferraris => calibrate::Method::Ferraris,
                },
                pose_tilt_deg: m.pose_tilt,
                prior: m.prior == Prior::DataSheet,
                free: m.free_pose.clone(),
                face: m.face_pose.clone(),
            },
            sensor: SensorInfo {
                id: m.sensor_id.clone(),
                model: m.sensor_model.clone(),
            },
            recorded: self.recorded,
            command: Some(command_line()),
            other_inputs: list.into_iter().collect(),
            thermal: self.thermal()?,
        })
    }
}

/// Writes the file, reads it back and compares. Returns path and checksum of what was written.
///
/// # Errors
///
/// `not-saved` (input), and those of writing and reading.
pub fn save(path: &Path, force: bool, file: &CalibrationFile) -> Result<InputFile> {
    file.write(path, force)?;
    if is_special(path) {
        // A pipe cannot be read back: the text is parsed instead.
        let text = file.to_json()?;
        CalibrationFile::parse(text.as_bytes())?;
        return Ok(InputFile::of_bytes(
            path,
            InputRole::Calibration,
            text.as_bytes(),
        ));
    }
    let (back, input) = CalibrationFile::read_with_input(path)?;
    if back.accelerometer.matrix != file.accelerometer.matrix
        || back.accelerometer.bias != file.accelerometer.bias
    {
        return Err(Error::input(
            "not-saved",
            "the file reads back differently from what was written",
        )
        .at(path, None));
    }
    Ok(input)
}
