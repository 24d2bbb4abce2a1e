//! `gravical log`: from a board into a file.

mod files;
mod keys;
mod outlet;
mod session;
mod summary;
mod target;
mod teller;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use gravical::Result;

use teller::Teller;

use crate::device::board::Wanted;
use crate::device::recorder::TEXT_BAUD;

#[derive(clap::Args)]
pub struct Args {
    /// The axis that is recorded: writes x_axis.csv, y_axis.csv or z_axis.csv
    #[arg(value_enum)]
    axis: Option<Axis>,
    /// The file to write [default: AXIS_axis.csv, recording.csv without an axis]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Go on with a file that is there already
    #[arg(long)]
    append: bool,
    /// End so many seconds after the first row, pauses left out
    #[arg(long, value_name = "S")]
    duration: Option<f64>,
    /// End after so many rows
    #[arg(long, value_name = "N")]
    rows: Option<u64>,
    /// One JSON object a line on standard output for everything that happens
    #[arg(long)]
    pub json: bool,
    /// Say nothing but warnings and errors
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    board: BoardArgs,
}

#[derive(clap::Args)]
#[command(next_help_heading = "About the board")]
struct BoardArgs {
    /// The port, see gravical ports [default: the only board that is plugged in]
    #[arg(long, value_name = "PORT")]
    port: Option<String>,
    /// Wait until a board is plugged in and speaks
    #[arg(long)]
    wait: bool,
    /// Bits a second of text; binary has 250000
    #[arg(long, value_name = "BAUD", default_value_t = TEXT_BAUD)]
    baud: u32,
    /// Full scale of the accelerometer in g: 2, 4, 8, 16 [default: as the board is]
    #[arg(long, value_name = "G")]
    range: Option<u16>,
    /// Full scale of the gyroscope in °/s: 250, 500, 1000, 2000
    #[arg(long, value_name = "DEG_S")]
    gyro_range: Option<u16>,
    /// Samples a second: 4 to 150, counts to 250, binary to 1000 (500 get through)
    #[arg(long, value_name = "HZ")]
    rate: Option<u16>,
    /// Low-pass of the sensor in Hz: 184, 94, 44, 21, 10, 5
    #[arg(long, value_name = "HZ")]
    low_pass: Option<u16>,
    /// What the board sends
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
    /// raw counts in frames with a checksum, for 500 Hz; the file has text all the same
    Binary,
}

impl Args {
    fn file(&self) -> PathBuf {
        let default = match self.axis {
            Some(Axis::X) => "x_axis.csv",
            Some(Axis::Y) => "y_axis.csv",
            Some(Axis::Z) => "z_axis.csv",
            None => "recording.csv",
        };
        self.output.clone().unwrap_or_else(|| default.into())
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
                Format::Binary => 2,
            }),
        }
    }

    fn validate(&self) -> Result<()> {
        let out_of_range = |text: String| Err(gravical::Error::usage("option-range", text));
        match (self.duration, self.rows) {
            (Some(s), _) if !(s > 0.0 && s <= 1e9) => {
                return out_of_range(format!("--duration has to be above 0 s, not {s}"));
            }
            (_, Some(0)) => return out_of_range("--rows has to be at least 1".to_owned()),
            _ => {}
        }
        if !(300..=4_000_000).contains(&self.board.baud) {
            return out_of_range(format!(
                "--baud has to be between 300 and 4000000, not {}",
                self.board.baud
            ));
        }
        if self.append {
            // The file says the rest.
            return Ok(());
        }
        self.wanted().validate()
    }
}

/// Runs the verb. It tells its errors itself: nobody may be there to read them.
pub fn run(args: &Args) -> ExitCode {
    let mut teller = Teller::new(args.json, args.quiet);
    let done = args.validate().map_err(Into::into);
    let done = done.and_then(|()| session::record(args, &mut teller));
    let code = done.unwrap_or_else(|error| teller.fail(&error));
    teller.drain();
    code
}
