//! `gravical log`: record from a serial board to a file.

mod content;
pub mod files;
mod keys;
pub mod reporter;
pub mod session;
mod summary;
mod target;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use gravical::Result;
use gravical::recording::ColumnsSpec;

use files::Existing;
use reporter::Reporter;

use crate::device::board::Wanted;
use crate::device::recorder::TEXT_BAUD;

/// Record from a serial board; losses are marked; Space pauses
#[derive(clap::Args)]
#[command(after_help = "\
Example: gravical log x     records x_axis.csv; Space pauses, q ends

Exit codes: 0 recorded, 1 rows lost on disk, 2 usage, 3 the file cannot be used,
5 board or port, 130 interrupted, or rows are missing.")]
pub struct Args {
    /// Axis under calibration: the file is x_axis.csv, y_axis.csv or z_axis.csv
    #[arg(value_enum)]
    axis: Option<Axis>,
    /// File to write [default: AXIS_axis.csv; without an axis recording.csv]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Append to an existing file
    #[arg(long)]
    append: bool,
    /// Overwrite an existing file
    #[arg(long, conflicts_with = "append")]
    force: bool,
    /// Stop S seconds after the first row, not counting pauses
    #[arg(long, value_name = "S")]
    duration: Option<f64>,
    /// Stop after N rows
    #[arg(long, value_name = "N")]
    rows: Option<u64>,
    /// Print events as JSON, one object per line
    #[arg(long)]
    pub json: bool,
    /// Print warnings and errors only
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    board: BoardArgs,
    /// Rows are written this often, s, and kept for those who read along.
    #[arg(skip)]
    write_every_s: Option<f64>,
}

/// The board, and how it is set.
#[derive(Clone, clap::Args)]
#[command(next_help_heading = "Board")]
pub struct BoardArgs {
    /// Serial port, see `gravical ports` [default: the only board plugged in]
    #[arg(long, value_name = "PORT")]
    pub port: Option<String>,
    /// Wait until a board is plugged in and sends data
    #[arg(long)]
    wait: bool,
    /// Baud rate
    #[arg(long, value_name = "BAUD", default_value_t = TEXT_BAUD)]
    baud: u32,
    /// Columns of a board that does not name them: t,ax,ay,az,-,gx,gy,gz in order, or t=ms,ax=…
    /// by name
    #[arg(long, value_name = "COLUMNS", allow_hyphen_values = true)]
    pub columns: Option<ColumnsSpec>,
    /// Full scale of the accelerometer in g: 2, 4, 8, 16 [default: as set on the board]
    #[arg(long, value_name = "G")]
    range: Option<u16>,
    /// Full scale of the gyroscope in °/s: 250, 500, 1000, 2000
    #[arg(long, value_name = "DEG_S")]
    gyro_range: Option<u16>,
    /// Sampling rate in Hz: 4 to 150, with counts to 250
    #[arg(long, value_name = "HZ")]
    pub rate: Option<u16>,
    /// Low-pass of the sensor in Hz: 184, 94, 44, 21, 10, 5
    #[arg(long, value_name = "HZ")]
    low_pass: Option<u16>,
    /// Format of the data from the board
    #[arg(long, value_enum)]
    format: Option<Format>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Axis {
    X,
    Y,
    Z,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Format {
    /// m/s², °C and °/s
    Si,
    /// raw counts
    Counts,
    /// m/s², °C and rad/s, calibrated by a board whose sketch has a calibration
    Calibrated,
}

/// Time between two writes of rows that are shown, s.
const SHOWN_EVERY_S: f64 = 0.02;

impl Args {
    /// For a session that reads along: into the file `output`, which is continued with `append`.
    pub fn of_session(board: &BoardArgs, output: PathBuf, append: bool) -> Self {
        Args {
            axis: None,
            output: Some(output),
            append,
            force: false,
            duration: None,
            rows: None,
            json: false,
            quiet: true,
            board: board.clone(),
            write_every_s: Some(SHOWN_EVERY_S),
        }
    }

    fn file(&self) -> PathBuf {
        let default = match self.axis {
            Some(Axis::X) => "x_axis.csv",
            Some(Axis::Y) => "y_axis.csv",
            Some(Axis::Z) => "z_axis.csv",
            None => "recording.csv",
        };
        self.output.clone().unwrap_or_else(|| default.into())
    }

    fn existing(&self) -> Existing {
        match (self.append, self.force) {
            (true, _) => Existing::Append,
            (_, true) => Existing::Replace,
            _ => Existing::Refuse,
        }
    }

    fn wanted(&self) -> Wanted {
        Wanted {
            accel_range_g: self.board.range,
            gyro_range_deg_s: self.board.gyro_range,
            low_pass_hz: self.board.low_pass,
            rate_hz: self.board.rate,
            format: self.board.format.map(|format| match format {
                Format::Si => 0,
                Format::Counts => 1,
                Format::Calibrated => 3,
            }),
        }
    }

    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `option-range` (usage).
    pub fn validate(&self) -> Result<()> {
        let out_of_range = |text: String| Err(gravical::Error::usage("option-range", text));
        match (self.duration, self.rows) {
            (Some(s), _) if !(s > 0.0 && s <= 1e9) => {
                return out_of_range(format!("--duration must be above 0 s, not {s}"));
            }
            (_, Some(0)) => return out_of_range("--rows must be at least 1".to_owned()),
            _ => {}
        }
        if !(300..=4_000_000).contains(&self.board.baud) {
            return out_of_range(format!(
                "--baud must be between 300 and 4000000, not {}",
                self.board.baud
            ));
        }
        if self.append {
            // The settings are read from the file.
            return Ok(());
        }
        self.wanted().validate()
    }
}

/// Runs the command. It reports its errors itself, without waiting for a reader.
pub fn run(args: &Args) -> ExitCode {
    let mut reporter = Reporter::new(args.json, args.quiet);
    let done = args.validate().map_err(Into::into);
    let done = done.and_then(|()| session::record(args, &mut reporter));
    let code = done.unwrap_or_else(|error| reporter.fail(&error));
    reporter.drain();
    code
}
