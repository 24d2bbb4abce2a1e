//! `gravical apply`: a recording, calibrated.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use gravical::apply::{ApplyOptions, ApplySummary, GyroscopeOutcome, apply};
use gravical::calibration_file::CalibrationFile;
use gravical::output::one_line;
use gravical::recording::{Origin, open};
use gravical::report::findings_text;

use crate::options::RecordingArgs;
use crate::table::TableArgs;
use crate::text;

/// Apply a calibration to a recording: one pass, any size
///
/// The calibrated channels take the place of the raw ones, as ax_mps2 … and gx_rad_s …; every other
/// column is kept as it is. The table goes to a file with -o, to a pipe without; the summary to stderr.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Calibration: a file of `gravical calibrate` or of imucal
    #[arg(value_name = "CAL")]
    calibration: PathBuf,
    /// Recording, plain or gzip; - is standard input
    #[arg(value_name = "INPUT")]
    input: PathBuf,
    #[command(flatten)]
    pub output: TableArgs,
    /// Keep the raw columns too; the calibrated ones come last
    #[arg(long)]
    keep_raw: bool,
    #[command(flatten)]
    recording: RecordingArgs,
}

/// Calibrates, writes, tells.
///
/// # Errors
///
/// A calibration that does not fit the recording, a recording or file that
/// cannot be read, a file that is there already, or what the disk says.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    args.output.check(&[&args.input, &args.calibration])?;
    let calibration = CalibrationFile::read(&args.calibration)?;
    let options = ApplyOptions {
        read: args.recording.read_options(false),
        keep_raw: args.keep_raw,
        axes: args.recording.axes.0,
    };
    options.read.validate()?;
    let input = open::open(&args.input, &options.read)?;
    let name = args.input.display().to_string();
    let summary = args
        .output
        .write(|out| apply(&calibration, input, &name, out, &options))?;
    if args.output.json {
        text::print_json(&summary)?;
    }
    if !args.output.quiet {
        tell(&summary, &args.output)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn tell(summary: &ApplySummary, output: &TableArgs) -> io::Result<()> {
    let mut err = text::err_out();
    writeln!(
        err,
        "{}: {} rows calibrated{}",
        one_line(&summary.input),
        summary.rows,
        output.arrow()
    )?;
    writeln!(err, "  read as       {}", summary.description)?;
    write!(
        err,
        "  accelerometer {} ({}) → m/s²",
        summary.accelerometer.unit.name(),
        origin(summary.accelerometer.origin)
    )?;
    match summary.quiet_norm_mps2 {
        Some(norm) => writeln!(
            err,
            "; at its quietest {norm:.3} m/s², gravity is {:.3}",
            summary.gravity_mps2
        )?,
        None => writeln!(err)?,
    }
    match summary.gyroscope {
        GyroscopeOutcome::Calibrated(unit) => {
            writeln!(err, "  gyroscope     {} → rad/s", unit.name())?;
        }
        GyroscopeOutcome::Kept => {
            writeln!(
                err,
                "  gyroscope     kept as it is: the calibration has none"
            )?;
        }
        GyroscopeOutcome::Absent => {}
    }
    if let Some(t) = &summary.temperature {
        writeln!(
            err,
            "  temperature   drift of {} taken off, measured from {:.1} to {:.1} °C",
            t.channels.join(", "),
            t.range_c[0],
            t.range_c[1]
        )?;
    }
    write!(
        err,
        "  lines         {} = {} rows",
        summary.lines, summary.rows
    )?;
    for aside in &summary.set_aside {
        write!(err, " + {} {}", aside.lines, aside.reason.name())?;
    }
    writeln!(err)?;
    err.write_all(findings_text(&summary.findings, false).as_bytes())?;
    err.write_all(output.hint().as_bytes())
}

fn origin(origin: Origin) -> &'static str {
    match origin {
        Origin::Given => "given",
        Origin::Data => "as gravity shows",
        Origin::Header => "as the header says",
        Origin::Assumed => "assumed",
    }
}
