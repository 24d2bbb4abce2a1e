//! `gravical motion`: velocity and position with error bands.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::calibration_file::InputFile;
use gravical::motion::{Motion, MotionOptions, motion};
use gravical::recording::{ReadOptions, Recording, read_joined, read_samples};
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

Exit codes: 0 computed, 3 bad input, 4 the end is open or its position not known (the table is written)")]
pub struct Args {
    #[command(flatten)]
    output: TableArgs,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    source: SourceArgs,
}

/// What a motion is computed from.
#[derive(Debug, clap::Args)]
pub struct SourceArgs {
    /// Recording, plain or .gz; - reads standard input
    #[arg(value_name = "RECORDING")]
    input: PathBuf,
    /// File of `gravical calibrate` or imucal, or a folder
    #[arg(short, long, value_name = "CAL")]
    calibration: Option<PathBuf>,
    /// Gyroscope in a second file, joined by time
    #[arg(long, value_name = "FILE")]
    gyro: Option<PathBuf>,
    #[command(flatten)]
    pub method: MotionOptions,
    #[command(flatten)]
    origin: OriginArgs,
    #[command(flatten)]
    gravity: GravityArgs,
    #[command(flatten)]
    recording: ReadOptions,
}

impl SourceArgs {
    /// The motion, of which recording it is, and all files that it was computed from.
    ///
    /// # Errors
    ///
    /// Files that cannot be read or do not belong together, an existing output file.
    pub fn compute(
        &self,
        output: &TableArgs,
        report: &ReportArgs,
    ) -> anyhow::Result<(Motion, Recording, Vec<InputFile>)> {
        let calibrations = self.calibration.as_deref().map_or(Vec::new(), files_of);
        let files = calibrations.iter().chain([&self.input]);
        output.check(report, files.chain(&self.gyro))?;
        let options = MotionOptions {
            gravity: self.gravity.given()?,
            ..self.method.clone()
        };
        options.validate()?;
        // A report lists the checksum of its input.
        let read_options = reading(&self.recording, report.is_wanted());
        let inputs = std::slice::from_ref(&self.input);
        let find = |path: &PathBuf| self.origin.read(path, inputs, &read_options, output.quiet);
        let calibration = self.calibration.as_ref().map(find).transpose()?;
        let calibrated = calibration
            .as_ref()
            .map(|(file, input)| (file, &*input.path));
        let gyro = self.gyro.as_deref();
        let recording = read_joined(&self.input, gyro, &read_options, |path, how| {
            read_samples(path, how)
        })?;
        let motion = motion(&recording, calibrated, &options)?;
        let mut inputs = InputFile::of(std::slice::from_ref(&recording));
        inputs.extend(calibration.iter().map(|(_, input)| input.clone()));
        Ok((motion, recording, inputs))
    }
}

/// Runs the command.
///
/// # Errors
///
/// Those of [`SourceArgs::compute`], I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let (output, report) = (&args.output, &args.report);
    let (motion, recording, inputs) = args.source.compute(output, report)?;
    output.write_table(&motion.table())?;
    let figures = report.figures(|| figure::motion::figures(&motion));
    let result = &motion.result;
    let document = with_origin(report::motion(result, &recording, &figures), &inputs);
    report.write(output.force, &document)?;
    let done = format!("{}: {} rows", result.computation.input, motion.rows());
    output.print_summary(result, &done, &document, report.verbose)?;
    report.say(output.quiet);
    Ok(quality(!result.verdict.judgement.is_known()))
}
