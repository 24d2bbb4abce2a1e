//! Arguments of `gravical motion`.

use std::path::{Path, PathBuf};

use gravical::calibration_file::NoiseSection;
use gravical::motion::MotionOptions;
use gravical::recording::ReadOptions;
use gravical::{Error, Result};

use crate::calibration::{OriginArgs, files_of};
use crate::figures::FigureArgs;
use crate::options::GravityArgs;
use crate::report::ReportArgs;

/// Compute velocity and position with error bands
///
/// Finds the rests, subtracts gravity using the attitude, integrates, and sets the velocity to zero at
/// the rests. The table goes to -o or a pipe, the summary to stderr.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Keep the sensor at rest for some seconds before and after each move.

Example: gravical motion walk.csv -c cal.json -o track.csv --report motion.html

Exit codes: 0 computed, 3 bad input, 4 no move is usable (the table is written)")]
pub struct Args {
    /// Recording, plain or .gz; - reads standard input
    #[arg(value_name = "RECORDING")]
    pub input: PathBuf,
    /// Table (CSV); - is stdout [default: if no terminal]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub report: ReportArgs,
    #[command(flatten)]
    pub figures: FigureArgs,
    /// File of `gravical calibrate` or imucal, or a folder
    #[arg(short, long, value_name = "CAL")]
    pub calibration: Option<PathBuf>,
    /// Result of `gravical noise`, for the bands
    #[arg(long, value_name = "FILE")]
    pub noise: Option<PathBuf>,
    /// Gyroscope in a second file, joined by time
    #[arg(long, value_name = "FILE")]
    pub gyro: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
    /// Print the result as JSON; the table needs -o
    #[arg(long)]
    pub json: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    #[command(flatten)]
    pub method: MotionOptions,
    #[command(flatten)]
    pub origin: OriginArgs,
    #[command(flatten)]
    truth: TruthArgs,
    #[command(flatten)]
    gravity: GravityArgs,
    #[command(flatten)]
    pub recording: ReadOptions,
}

#[derive(Debug, clap::Args)]
struct TruthArgs {
    /// Reference positions: t_s,px_m,py_m,pz_m
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
}

impl Args {
    /// The options, with gravity and the noise.
    ///
    /// # Errors
    ///
    /// `option-range` (usage).
    pub fn options(&self, noise: Option<NoiseSection>) -> Result<MotionOptions> {
        Ok(MotionOptions {
            noise,
            gravity: self.gravity.given()?,
            ..self.method.clone()
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
