//! `gravical noise`: the Allan deviation of a recording at rest.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use gravical::escape::path_text;
use gravical::export::kalibr;
use gravical::noise::{NoiseOptions, NoiseResult, PARTS, Part, Spacing, noise};
use gravical::output::write_text;
use gravical::poses::face::AxisMap;
use gravical::{Error, Result};
use gravical_report::figure::noise::figures;
use gravical_report::report;

use crate::figures::FigureArgs;
use crate::options::RecordingArgs;
use crate::report::{ReportArgs, check_outputs, with_origin};
use crate::text;

/// Determine the noise of a sensor at rest (Allan deviation)
///
/// For each channel the noise density N, the bias instability B and the random walk K with 95 %
/// intervals, or how long a recording would show them. What moves is not noise: only static
/// intervals are used.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "\
Example: gravical noise desk.csv --part mpu6050 --report noise.html
How a recording is read (units, columns, rate): options in `gravical noise --help`.",
    after_long_help = "\
Examples:
  gravical noise desk.csv --part mpu6050 --report noise.html
  gravical noise desk.csv -o noise.json
  gravical noise desk.csv --to kalibr -o imu.yaml

Two hours at a constant temperature show N and B; K takes longer. Exit codes: 0 analysed, 3 cannot
be read, or never at rest."
)]
pub struct Args {
    /// Recording of a sensor at rest, plain or .gz; - reads standard input
    #[arg(value_name = "INPUT")]
    input: PathBuf,
    /// File to write: the result as JSON, which `calibrate --noise` and `motion --noise` take, or
    /// that of --to
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    figures: FigureArgs,
    /// Averaging times
    #[arg(long, value_enum, value_name = "SPACING", default_value = "octave")]
    spacing: SpacingArg,
    /// Part whose data sheet N is compared with: MPU6050, MPU9250 or ICM42688P
    #[arg(long, value_name = "PART", value_parser = part)]
    part: Option<&'static Part>,
    /// Write the noise for another program to -o, or to stdout
    #[arg(long, value_enum, value_name = "TARGET")]
    to: Option<To>,
    /// With --to: upper limits for parameters that are not determined
    #[arg(long, requires = "to")]
    upper_limit: bool,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    recording: RecordingArgs,
}

/// A target of --to.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum To {
    /// imu.yaml of Kalibr
    Kalibr,
}

/// [`Spacing`] as an option.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum SpacingArg {
    /// 1, 2, 4, 8 … samples
    Octave,
    /// Four in each octave
    Dense,
    /// 1, 2, 5, 10 … samples
    Decade,
}

fn part(name: &str) -> std::result::Result<&'static Part, String> {
    Part::of_name(name).ok_or_else(|| {
        let names: Vec<&str> = PARTS.iter().map(|part| part.name).collect();
        format!("known parts: {}", names.join(", "))
    })
}

/// Runs the command.
///
/// # Errors
///
/// A file that cannot be read, a sensor that is never at rest, an existing output file, I/O
/// errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    check_axes(args)?;
    let output = args.output.as_deref();
    if args.to.is_some() && args.json && output.is_none() {
        return Err(Error::usage(
            "json-needs-output",
            "--json and --to would both write to stdout",
        )
        .with_hint("name the file of --to with -o")
        .into());
    }
    check_outputs(
        output,
        &args.report,
        Some(&args.figures),
        &[&args.input],
        args.force,
    )?;
    let read = args
        .recording
        .read_options(args.report.is_wanted() || output.is_some());
    let result = noise(&args.input, &read, &options_of(args))?;
    let figures = figures(&result);
    let document = with_origin(report::noise(&result, &figures), &result.inputs);
    args.report.write(args.force, &document)?;
    args.figures.write(&figures, args.force, args.quiet)?;
    if args.json {
        text::print_json(&result)?;
    } else if !args.quiet {
        let report = document.to_text(args.report.detail());
        match args.to.is_some() && output.is_none() {
            true => text::say_report(report.trim_end()),
            false => text::print_report(&report)?,
        }
        args.report.say();
    }
    // What is refused here does not take the analysis away.
    let written = match args.to {
        Some(To::Kalibr) => {
            let export = kalibr(&result.section(), None, args.upper_limit)?;
            if !args.quiet {
                for note in &export.notes {
                    text::say(&format!("note: {note}"));
                }
            }
            export.text
        }
        None => json(&result)?,
    };
    match output {
        Some(path) => {
            write_text(path, args.force, &written)?;
            if !args.quiet {
                text::say(&format!("Noise: {}", path_text(path)));
            }
        }
        None if args.to.is_some() => text::print(&written)?,
        None => {}
    }
    Ok(ExitCode::SUCCESS)
}

fn check_axes(args: &Args) -> Result<()> {
    if args.recording.axes.0 == AxisMap::default() {
        return Ok(());
    }
    Err(Error::usage(
        "axes-unused",
        "noise analyses each axis of the sensor separately",
    )
    .with_hint("remove --axes"))
}

fn options_of(args: &Args) -> NoiseOptions {
    NoiseOptions {
        spacing: match args.spacing {
            SpacingArg::Octave => Spacing::Octave,
            SpacingArg::Dense => Spacing::Dense,
            SpacingArg::Decade => Spacing::Decade,
        },
        part: args.part,
    }
}

fn json(result: &NoiseResult) -> anyhow::Result<String> {
    Ok(serde_json::to_string_pretty(result)? + "\n")
}
