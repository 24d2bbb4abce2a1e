//! `gravical calibrate`: recordings of still placements → calibration.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::{CalibrationFile, Grade, InputFile, InputRole, SensorInfo};
use gravical::document::Detail;
use gravical::estimate::accelerometer::{self, EstimateOptions};
use gravical::excerpt;
use gravical::figure;
use gravical::figure::calibration::Session;
use gravical::output::{is_special, path_word};
use gravical::recording::Recording;
use gravical::segment::SegmentOptions;
use gravical::segment::sections::read_sections_with_input;
use gravical::segment::still::StillOptions;
use gravical::temperature::soak_alone;
use gravical::{Error, Result, report};

use crate::failure::QUALITY;
use crate::figures::FigureArgs;
use crate::options::command_line;
use crate::options::{GravityArgs, RecordingArgs};
use crate::report::{ReportArgs, check_outputs};
use crate::session::read_session;
use crate::text;

#[derive(clap::Args)]
#[command(after_help = "\
A session is six files, a folder, one file per axis with blank rows between the
two directions, one file with a label column, one with --sections, or one
continuous recording whose holds are found.

Exit codes: 0 calibrated, 3 no parameters could be had (nothing is written),
4 calibrated, but the verdict is poor (the file is written all the same).")]
pub struct Args {
    /// The session: files, or one folder; - is standard input
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// A second file with the gyroscope, joined to the one INPUT on time
    #[arg(long, value_name = "FILE")]
    gyro: Option<PathBuf>,
    /// Write the calibration to this file (JSON)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    report: ReportArgs,
    /// Replace files that are there
    #[arg(long)]
    force: bool,
    /// Print the calibration as JSON on stdout instead of the tables
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
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
    /// How to estimate
    #[arg(long, value_enum, default_value = "joint")]
    method: Method,
    /// Sections of the one recording: imucal's JSON, or CSV label,start,end
    #[arg(long, value_name = "FILE")]
    sections: Option<PathBuf>,
    /// Take the first N rows of each placement [default: its longest quiet part]
    #[arg(long, value_name = "N")]
    rows: Option<usize>,
    /// Whom to believe about faces when names and data disagree
    #[arg(long, value_enum, default_value = "data")]
    faces: FacesFrom,
    /// Angle of each of the three turns in degrees, with its sign
    #[arg(
        long,
        value_name = "DEG",
        allow_negative_numbers = true,
        default_value = "-360"
    )]
    turn_angle: f64,
    /// How far placements may be off level, degrees (sd of each of two directions):
    /// a jig 0.1, a box on a table 0.5 to 1, by hand 2 [default: estimated, else 1]
    #[arg(long, value_name = "DEG")]
    placement_tilt: Option<f64>,
    /// What the data sheet says about scale, cross-axis and bias
    #[arg(long, value_enum, default_value = "data-sheet")]
    prior: Prior,
    /// A placement (label or file) that lies on no face, whatever it looks like; repeatable
    #[arg(long, value_name = "NAME", allow_hyphen_values = true)]
    free: Vec<String>,
    /// A placement that lies on a face, however crookedly; repeatable
    #[arg(long, value_name = "NAME", allow_hyphen_values = true)]
    face: Vec<String>,
    /// Add a temperature model from a recording of the same sensor at rest that cools and warms;
    /// repeat it for more placements [default: from the session, where it spans over 5 °C at rest]
    #[arg(long, value_name = "FILE")]
    thermal: Vec<PathBuf>,
    /// Name or serial number of the sensor, for the file
    #[arg(long, value_name = "TEXT")]
    sensor_id: Option<String>,
    /// Type of the sensor, for the file
    #[arg(long, value_name = "TEXT")]
    sensor_model: Option<String>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Method {
    /// Faces and free poses in one fit, crooked placements allowed for
    Joint,
    /// Six faces in closed form
    Ferraris,
    /// Nine parameters from the length of gravity, any poses
    Magnitude9,
    /// Six parameters from the length of gravity: scale and bias only
    Magnitude6,
    /// Least squares with the faces taken as exact: for precise fixtures
    Linear12,
    /// Drift with temperature only, from a recording at rest that cools and warms
    Thermal,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Prior {
    /// Scale ±3 %, cross-axis ±2 %, bias ±0.6 m/s²
    DataSheet,
    /// Only what the recordings say
    Off,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum FacesFrom {
    /// What gravity shows
    Data,
    /// What files and labels are called
    Names,
}

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    // Before the work, not after it.
    let inputs = args
        .inputs
        .iter()
        .chain(&args.gyro)
        .chain(&args.method.sections);
    let inputs = inputs.chain(&args.method.thermal);
    check_outputs(
        args.output.as_deref(),
        &args.report,
        Some(&args.figures),
        &inputs.map(PathBuf::as_path).collect::<Vec<_>>(),
        args.force,
    )?;
    let options = args.options()?;
    let read_options = args.recording.read_options(true);
    // --sections and --rows name rows, any of all.
    let by_rows = options.segment.sections.is_some() || options.segment.rows.is_some();
    let still = (!by_rows).then_some(&options.segment.still);
    let gyro = args.gyro.as_deref();
    let (recordings, left_out) = read_session(&args.inputs, gyro, &read_options, still)?;
    let (mut file, segmentation) = match args.method.method {
        Method::Thermal => (soak_alone(&recordings, &options)?, None),
        _ => {
            let done = calibrate(&recordings, &options)?;
            (done.file, Some(done.segmentation))
        }
    };
    file.findings.extend(left_out);
    if let Some(path) = &args.output {
        save(path, args.force, &file)?;
    }
    let session = segmentation.as_ref().map(|segmentation| Session {
        recordings: &recordings,
        segmentation,
    });
    let drawn = args.report.is_wanted() || args.figures.figures.is_some();
    let figures = match drawn {
        true => figure::calibration::figures(&file, session),
        false => Vec::new(),
    };
    args.figures.write(&figures, args.force, args.quiet)?;
    let document = report::calibration(&file, &figures);
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
        text::print_report(&document.to_text(Detail::Summary))?;
        text::print(&next_step(args, &file))?;
    }
    Ok(match file.verdict.grade {
        Grade::Poor => ExitCode::from(QUALITY),
        _ => ExitCode::SUCCESS,
    })
}

impl Args {
    /// The soak recordings of --thermal.
    fn thermal(&self) -> Result<Vec<Recording>> {
        let options = self.recording.read_options(true);
        let files = self.method.thermal.iter();
        let still = StillOptions::default();
        files
            .map(|file| excerpt::read(file, &options, &still))
            .collect()
    }

    fn options(&self) -> Result<CalibrateOptions> {
        let m = &self.method;
        let sections = m.sections.as_deref().map(read_sections_with_input);
        let (sections, list) = sections.transpose()?.unzip();
        Ok(CalibrateOptions {
            segment: SegmentOptions {
                rows: m.rows,
                sections,
                axes: self.recording.axes.0,
                faces_by_name: m.faces == FacesFrom::Names,
                turn_angle_deg: m.turn_angle,
                ..SegmentOptions::default()
            },
            gravity: self.gravity.given()?.unwrap_or_default(),
            estimate: EstimateOptions {
                method: match m.method {
                    Method::Joint | Method::Thermal => accelerometer::Method::Joint,
                    Method::Ferraris => accelerometer::Method::Ferraris,
                    Method::Magnitude9 => accelerometer::Method::Magnitude9,
                    Method::Magnitude6 => accelerometer::Method::Magnitude6,
                    Method::Linear12 => accelerometer::Method::Linear12,
                },
                placement_tilt_deg: m.placement_tilt,
                prior: m.prior == Prior::DataSheet,
                free: m.free.clone(),
                face: m.face.clone(),
            },
            sensor: SensorInfo {
                id: m.sensor_id.clone(),
                model: m.sensor_model.clone(),
            },
            command: Some(command_line()),
            other_inputs: list.into_iter().collect(),
            thermal: self.thermal()?,
        })
    }
}

/// Writes the file and reads it back: "saved" is said of what can be read. Says
/// which bytes it is now.
///
/// # Errors
///
/// `not-saved` (input), and those of writing and reading.
pub fn save(path: &Path, force: bool, file: &CalibrationFile) -> Result<InputFile> {
    file.write(path, force)?;
    if is_special(path) {
        // What went into a pipe is gone: it is read as it was written.
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
        return Err(
            Error::input("not-saved", "what was written reads back differently").at(path, None),
        );
    }
    Ok(input)
}

fn next_step(args: &Args, file: &CalibrationFile) -> String {
    match &args.output {
        Some(path) => {
            let caution = if file.verdict.grade == Grade::Poor { " (but mend what the verdict names first)" } else { "" };
            format!(
                "\nSaved to {p}.\nNext: gravical apply {p} RECORDING.csv -o calibrated.csv{caution}\n",
                p = path_word(path)
            )
        }
        None if file.verdict.grade == Grade::Poor => {
            "\nNothing was saved. Mend what the verdict names first;\n-o cal.json saves it all the same.\n".to_owned()
        }
        None => "\nNothing was saved. Next: the same command with -o cal.json, then\n`gravical apply cal.json RECORDING.csv -o calibrated.csv`\n".to_owned(),
    }
}
