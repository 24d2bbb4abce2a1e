//! `gravical motion`: velocity and position with error bands.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::Error;
use gravical::calibration_file::InputFile;
use gravical::motion::{Calibrated, MotionJudgement, MotionOptions, motion, write_table};
use gravical::recording::{ReadOptions, read_joined, read_samples};
use gravical_report::figure;
use gravical_report::report;

use crate::calibration::{OriginArgs, files_of};
use crate::failure::quality;
use crate::options::{GravityArgs, reading};
use crate::report::{ReportArgs, TableArgs, with_origin};

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
    input: PathBuf,
    #[command(flatten)]
    output: TableArgs,
    #[command(flatten)]
    report: ReportArgs,
    /// File of `gravical calibrate` or imucal, or a folder
    #[arg(short, long, value_name = "CAL")]
    calibration: Option<PathBuf>,
    /// Gyroscope in a second file, joined by time
    #[arg(long, value_name = "FILE")]
    gyro: Option<PathBuf>,
    #[command(flatten)]
    method: MotionOptions,
    #[command(flatten)]
    origin: OriginArgs,
    #[command(flatten)]
    gravity: GravityArgs,
    #[command(flatten)]
    recording: ReadOptions,
}

/// Runs the command.
///
/// # Errors
///
/// Files that cannot be read or do not belong together, an existing output file, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let output = &args.output;
    let calibrations = args.calibration.as_deref().map_or(Vec::new(), files_of);
    let files = calibrations.iter().chain([&args.input]);
    let files = files.chain(&args.gyro);
    output.check(&args.report, files)?;
    let options = MotionOptions {
        gravity: args.gravity.given()?,
        ..args.method.clone()
    };
    options.validate()?;
    // A report lists the checksum of its input.
    let read_options = reading(&args.recording, args.report.is_wanted());
    let inputs = std::slice::from_ref(&args.input);
    let find = |path: &PathBuf| args.origin.read(path, inputs, &read_options, output.quiet);
    let calibration = args.calibration.as_ref().map(find).transpose()?;
    let calibrated = calibration.as_ref().map(|(file, input)| Calibrated {
        file,
        name: &input.path,
    });

    let gyro = args.gyro.as_deref();
    let recording = read_joined(&args.input, gyro, &read_options, |path, how| {
        read_samples(path, how)
    })?;
    let motion = motion(&recording, calibrated, &options)?;
    let mut inputs = InputFile::of(std::slice::from_ref(&recording));
    inputs.extend(calibration.iter().map(|(_, input)| input.clone()));

    if output.file().is_some() || output.is_printed() {
        let path = output.file().unwrap_or(Path::new("standard output"));
        output.write(|out| write_table(&motion, out).map_err(|e| Error::io(path, e)))?;
    }
    let draw = || figure::motion::figures(&motion);
    let figures = args.report.figures(draw);
    let result = &motion.result;
    let document = with_origin(report::motion(result, &recording, &figures), &inputs);
    args.report.write(output.force, &document)?;
    let done = format!("{}: {} rows", result.input, result.rows);
    output.print_summary(result, &done, &document, args.report.verbose)?;
    args.report.say(output.quiet);
    let judgement = result.verdict.judgement;
    Ok(quality(judgement == MotionJudgement::NotUsable))
}
