//! Arguments of `gravical motion`, and what they mean.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use gravical::denoise::{Edge, FilterSpec};
use gravical::motion::stance::StanceOptions;
use gravical::motion::still::{Intervals, RestOptions};
use gravical::motion::truth::{TruthAlign, TruthColumns, TruthOptions};
use gravical::motion::{GravityRemoval, MotionOptions};
use gravical::{Error, Result};

use crate::figures::FigureArgs;
use crate::options::{GravityArgs, RecordingArgs};
use crate::report::ReportArgs;

/// Recording → velocity and position, with error bands
///
/// Rests are found, gravity is taken off along the attitude, velocity is zero at rests. The table
/// goes to a file with -o, to a pipe without; the summary to stderr.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Hold the sensor still for some seconds before and after each move: drift is
corrected between rests, and grows without limit after the last one.

Exit codes: 0 computed, 3 bad input, 4 computed, but no move can be known (the
table is written all the same).")]
pub struct Args {
    /// Recording, plain or gzip; - is standard input
    #[arg(value_name = "RECORDING")]
    pub input: PathBuf,
    /// Calibration: a file of `gravical calibrate` or of imucal
    #[arg(short, long, value_name = "CAL")]
    pub calibration: Option<PathBuf>,
    /// A second file with the gyroscope, joined on time
    #[arg(long, value_name = "FILE")]
    pub gyro: Option<PathBuf>,
    /// Table to write; - is stdout [default: stdout, unless that is a terminal]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub report: ReportArgs,
    /// Sample by sample without look-ahead: any size, no bands, nothing corrected backwards
    #[arg(long)]
    pub causal: bool,
    /// Replace files that are there
    #[arg(long)]
    pub force: bool,
    /// Print the result as one JSON object on stdout; the table only with -o
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    #[command(flatten)]
    pub figures: FigureArgs,
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    truth: TruthArgs,
    #[command(flatten)]
    gravity: GravityArgs,
    #[command(flatten)]
    pub recording: RecordingArgs,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Method")]
struct MethodArgs {
    /// A preset; the options below change single steps of it
    #[arg(long, value_enum, value_name = "NAME", default_value = "default")]
    procedure: Procedure,
    /// How gravity is taken off [default: strapdown]
    #[arg(long, value_enum, value_name = "HOW")]
    gravity_removal: Option<Removal>,
    /// Rows at the start that still-mean takes the mean of [default: 500]
    #[arg(long, value_name = "N")]
    still_rows: Option<usize>,
    /// Filter for the accelerometer, as savgol:5,2 or butter:4,5Hz; may be repeated [default: none]
    #[arg(long, value_name = "FILTER|none")]
    smooth: Vec<Smooth>,
    /// What stands beyond the ends of a smoothed stretch [default: interp]
    #[arg(long, value_name = "EDGE", requires = "smooth")]
    edge: Option<Edge>,
    /// Whether velocity is zero at rests [default: on]
    #[arg(long, value_enum, value_name = "ON|OFF")]
    zero_velocity: Option<Switch>,
    /// Where it rests, in s: 0-5,7.2- (an open end is the end) [default: found]
    #[arg(long, value_name = "SPANS", allow_hyphen_values = true)]
    still: Option<Intervals>,
    /// Whether stances of a walking foot count as standing [default: on]
    #[arg(long, value_enum, value_name = "ON|OFF")]
    stances: Option<Switch>,
    /// Angular rate that a foot in stance stays under, rad/s [default: 0.6]
    #[arg(long, value_name = "RAD_S")]
    stance_rate: Option<f64>,
    /// Velocity at the start in m/s, where it does not start at rest
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    v0: Option<Vector>,
    /// Position at the start in m [default: 0,0,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    p0: Option<Vector>,
    /// Standard uncertainty of the recorder's clock, relative [default: 0.001]
    #[arg(long, value_name = "SHARE")]
    clock_error: Option<f64>,
    /// Without a gyroscope: how far it tilts during a move, degrees [default: 0.5]
    #[arg(long, value_name = "DEG")]
    wobble: Option<f64>,
    /// Compute no error bands: faster, and a smaller table
    #[arg(long)]
    no_bands: bool,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Comparison with a reference")]
struct TruthArgs {
    /// Positions measured otherwise: columns t_s,px_m,py_m,pz_m; may be RECORDING itself
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Its columns by name: t=…,px=…,py=…,pz=… [default: what is called a position]
    #[arg(long, value_name = "COLUMNS", requires = "truth")]
    truth_columns: Option<TruthColumns>,
    /// How it is turned to fit [default: yaw; rotation where its z is not up]
    #[arg(long, value_enum, value_name = "HOW", requires = "truth")]
    truth_align: Option<Align>,
    /// Seconds to add to its stamps [default: found by the speeds; 0 within RECORDING]
    #[arg(
        long,
        value_name = "S",
        requires = "truth",
        allow_negative_numbers = true
    )]
    truth_offset: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Procedure {
    /// strapdown, velocity zero at rests
    Default,
    /// the classical student's report: --gravity-removal still-mean --still-rows 500
    /// --smooth savgol:5,2 --zero-velocity off
    Report,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Removal {
    /// along the attitude, followed with the gyroscope
    Strapdown,
    /// along the tilt of the rest before
    ConstantTilt,
    /// by the mean of the first rows, in the sensor's own axes
    StillMean,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Switch {
    /// yes
    On,
    /// no
    Off,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Align {
    /// about the vertical: its z is up
    Yaw,
    /// by any rotation
    Rotation,
    /// not at all
    None,
}

/// A filter, or `none`, which takes away that of a preset.
#[derive(Debug, Clone)]
struct Smooth(Option<FilterSpec>);

impl std::str::FromStr for Smooth {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text {
            "none" => Ok(Smooth(None)),
            filter => filter.parse().map(|f| Smooth(Some(f))),
        }
    }
}

/// Three numbers.
#[derive(Debug, Clone, Copy)]
struct Vector([f64; 3]);

fn vector(text: &str) -> std::result::Result<Vector, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|part| {
            part.trim()
                .parse::<f64>()
                .map_err(|e| format!("\"{part}\": {e}"))
        })
        .collect::<std::result::Result<_, _>>()?;
    match numbers[..] {
        [x, y, z] => Ok(Vector([x, y, z])),
        _ => Err(format!(
            "three numbers are wanted, as 0,0,0; these are {}",
            numbers.len()
        )),
    }
}

impl Args {
    /// As the library wants them: the preset, changed by what is given.
    ///
    /// # Errors
    ///
    /// `option-range` (usage).
    pub fn options(&self) -> Result<MotionOptions> {
        let m = &self.method;
        let preset = match m.procedure {
            Procedure::Default => MotionOptions::default(),
            Procedure::Report => MotionOptions::report(),
        };
        Ok(MotionOptions {
            gravity_removal: m
                .gravity_removal
                .map_or(preset.gravity_removal, |r| match r {
                    Removal::Strapdown => GravityRemoval::Strapdown,
                    Removal::ConstantTilt => GravityRemoval::ConstantTilt,
                    Removal::StillMean => GravityRemoval::StillMean,
                }),
            still_rows: m.still_rows.unwrap_or(preset.still_rows),
            smooth: match &m.smooth[..] {
                [] => preset.smooth,
                given => given.iter().filter_map(|s| s.0).collect(),
            },
            edge: m.edge.unwrap_or(preset.edge),
            zero_velocity: m
                .zero_velocity
                .map_or(preset.zero_velocity, |s| s == Switch::On),
            rests: RestOptions {
                given_s: m.still.as_ref().map(|i| i.0.clone()),
            },
            stance: StanceOptions {
                search: m.stances != Some(Switch::Off),
                rate_rad_s: m.stance_rate.unwrap_or(preset.stance.rate_rad_s),
                ..preset.stance
            },
            v0_mps: m.v0.map(|v| v.0),
            p0_m: m.p0.map_or(preset.p0_m, |p| p.0),
            gravity: self.gravity.given()?,
            clock_error: m.clock_error.unwrap_or(preset.clock_error),
            wobble_deg: m.wobble.unwrap_or(preset.wobble_deg),
            bands: !m.no_bands,
            keep_uncalibrated: self.figures.figures.is_some() || self.report.is_wanted(),
            axes: self.recording.axes.0,
        })
    }

    /// Every file that is read.
    pub fn files(&self) -> Vec<&Path> {
        let others = [&self.calibration, &self.gyro, &self.truth.truth];
        let others = others.into_iter().flatten();
        [&self.input]
            .into_iter()
            .chain(others)
            .map(PathBuf::as_path)
            .collect()
    }

    /// The reference and how it is compared; none without --truth.
    ///
    /// # Errors
    ///
    /// `truth-stdin` (usage) for standard input,
    /// `option-range` (usage).
    pub fn truth(&self) -> Result<Option<(&Path, TruthOptions)>> {
        let Some(path) = self.truth.truth.as_deref() else {
            return Ok(None);
        };
        if path == Path::new("-") {
            return Err(
                Error::usage("truth-stdin", "--truth reads a file, not standard input")
                    .with_hint("write the reference to a file first"),
            );
        }
        let options = TruthOptions {
            columns: self.truth.truth_columns.clone(),
            align: self.truth.truth_align.map(|a| match a {
                Align::Yaw => TruthAlign::Yaw,
                Align::Rotation => TruthAlign::Rotation,
                Align::None => TruthAlign::None,
            }),
            offset_s: self.truth.truth_offset,
        };
        options.validate()?;
        Ok(Some((path, options)))
    }
}
