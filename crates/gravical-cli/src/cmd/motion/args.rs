//! Arguments of `gravical motion`.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use gravical::calibration_file::NoiseSection;
use gravical::denoise::FilterSpec;
use gravical::motion::Intervals;
use gravical::motion::{GravityRemoval, MotionOptions};
use gravical::{Error, Result};

use crate::calibration::{OriginArgs, files_of};
use crate::figures::FigureArgs;
use crate::options::{GravityArgs, RecordingArgs};
use crate::report::ReportArgs;

/// Compute velocity and position with error bands
///
/// Finds the rests, subtracts gravity using the attitude, integrates, and sets the velocity to zero at
/// the rests. The table goes to -o or a pipe, the summary to stderr.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "\
Keep the sensor at rest for some seconds before and after each move: drift is
corrected between rests and grows without limit after the last one.

Example: gravical motion walk.csv -c cal.json -o track.csv --report motion.html
More options (method, reference, reading): `gravical motion --help`.",
    after_long_help = "\
Keep the sensor at rest for some seconds before and after each move: drift is
corrected between rests and grows without limit after the last one.

Example: gravical motion walk.csv -c cal.json -o track.csv --report motion.html

Exit codes: 0 computed, 3 bad input, 4 computed, but no move is usable (the table
is still written)."
)]
pub struct Args {
    /// Recording, plain or .gz; - reads standard input
    #[arg(value_name = "RECORDING")]
    pub input: PathBuf,
    /// Calibration file, of `gravical calibrate` or imucal, or a folder of them
    #[arg(short, long, value_name = "CAL")]
    pub calibration: Option<PathBuf>,
    /// Noise of the sensor by `gravical noise`, for the bands [default: that of the rests]
    #[arg(long, value_name = "FILE")]
    pub noise: Option<PathBuf>,
    /// Gyroscope of the recording in a second file, joined by time
    #[arg(long, value_name = "FILE")]
    pub gyro: Option<PathBuf>,
    /// Table to write (CSV); - writes to stdout [default: stdout if it is not a terminal]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub report: ReportArgs,
    /// Causal: use the past only, as if the samples came one by one
    #[arg(long)]
    pub causal: bool,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
    /// Print the result as JSON; the table is then written only with -o
    #[arg(long)]
    pub json: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    #[command(flatten)]
    pub figures: FigureArgs,
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    pub origin: OriginArgs,
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
    /// Preset; the options below change single steps of it
    #[arg(long, value_enum, value_name = "NAME", default_value = "default")]
    procedure: Procedure,
    /// How gravity is subtracted [default: strapdown]
    #[arg(long, hide_short_help = true, value_enum, value_name = "HOW")]
    gravity_removal: Option<Removal>,
    /// Filter of the accelerometer, e.g. savgol:5,2 or butter:4,5Hz; repeatable [default: none]
    #[arg(long, hide_short_help = true, value_name = "FILTER|none")]
    smooth: Vec<Smooth>,
    /// Zero-velocity update at rests [default: on]
    #[arg(long, hide_short_help = true, value_enum, value_name = "ON|OFF")]
    zero_velocity: Option<Switch>,
    /// Rests in s, e.g. 0-5,7.2- (no end: to the end of the recording) [default: found]
    #[arg(long, value_name = "SPANS", allow_hyphen_values = true)]
    rests: Option<Intervals>,
    /// Zero-velocity update at stances of a walking foot: their highest angular rate in rad/s, or off
    /// [default: 1]
    #[arg(long, hide_short_help = true, value_name = "RATE|off")]
    stances: Option<Stances>,
    /// Velocity at the start in m/s, of a sensor that moves evenly there; with --zero-velocity off
    #[arg(long, hide_short_help = true, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    v0: Option<Vector>,
    /// Initial position in m [default: 0,0,0]
    #[arg(long, hide_short_help = true, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    p0: Option<Vector>,
    /// Write no error bands: a smaller table
    #[arg(long, hide_short_help = true)]
    no_bands: bool,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Comparison with a reference")]
struct TruthArgs {
    /// Reference positions, columns t_s,px_m,py_m,pz_m; may be RECORDING itself
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Procedure {
    /// strapdown with zero-velocity updates
    Default,
    /// as in the student report: --gravity-removal initial-mean --smooth savgol:5,2
    Report,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Removal {
    /// using the attitude from the gyroscope
    Strapdown,
    /// using the tilt at the rests, without the gyroscope
    ConstantTilt,
    /// the mean of the first 500 rows, in sensor axes, without zero-velocity updates
    InitialMean,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Switch {
    /// yes
    On,
    /// no
    Off,
}

/// A filter; `none` removes the one of a preset.
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

/// The highest rate of a stance; none where they are not looked for.
#[derive(Debug, Clone, Copy)]
struct Stances(Option<f64>);

impl std::str::FromStr for Stances {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "off" => Ok(Stances(None)),
            rate => match rate.parse() {
                Ok(rate) => Ok(Stances(Some(rate))),
                Err(e) => Err(format!("{e}; a rate in rad/s or off")),
            },
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
            "expected three numbers such as 0,0,0, found {}",
            numbers.len()
        )),
    }
}

impl Args {
    /// The options of the library: the preset, changed by the options given, and the noise.
    ///
    /// # Errors
    ///
    /// `option-range` (usage).
    pub fn options(&self, noise: Option<NoiseSection>) -> Result<MotionOptions> {
        let m = &self.method;
        let preset = match m.procedure {
            Procedure::Default => MotionOptions::default(),
            Procedure::Report => MotionOptions::report(),
        };
        let preset = match m.gravity_removal {
            Some(Removal::Strapdown) => preset.with_removal(GravityRemoval::Strapdown),
            Some(Removal::ConstantTilt) => preset.with_removal(GravityRemoval::ConstantTilt),
            Some(Removal::InitialMean) => preset.with_removal(GravityRemoval::InitialMean),
            None => preset,
        };
        Ok(MotionOptions {
            gravity_removal: preset.gravity_removal,
            causal: self.causal,
            smooth: match &m.smooth[..] {
                [] => preset.smooth,
                given => given.iter().filter_map(|s| s.0).collect(),
            },
            zero_velocity: m
                .zero_velocity
                .map_or(preset.zero_velocity, |s| s == Switch::On),
            rests_s: m.rests.as_ref().map(|i| i.0.clone()),
            stance_rate_rad_s: match m.stances {
                Some(Stances(rate)) => rate,
                None => preset.stance_rate_rad_s,
            },
            meter: preset.meter,
            v0_mps: m.v0.map(|v| v.0),
            p0_m: m.p0.map_or(preset.p0_m, |p| p.0),
            noise,
            gravity: self.gravity.given()?,
            bands: !m.no_bands,
            axes: self.recording.axes.0,
        })
    }

    /// All input files.
    pub fn files(&self) -> Vec<PathBuf> {
        let others = [&self.gyro, &self.noise, &self.truth.truth];
        let files = [&self.input]
            .into_iter()
            .chain(others.into_iter().flatten());
        let calibrations = self.calibration.iter().flat_map(|path| files_of(path));
        files.cloned().chain(calibrations).collect()
    }

    /// The reference; none without --truth.
    ///
    /// # Errors
    ///
    /// `truth-stdin` (usage) for standard input.
    pub fn truth(&self) -> Result<Option<&Path>> {
        let path = self.truth.truth.as_deref();
        if path == Some(Path::new("-")) {
            return Err(
                Error::usage("truth-stdin", "--truth reads a file, not standard input")
                    .with_hint("write the reference to a file first"),
            );
        }
        Ok(path)
    }
}
