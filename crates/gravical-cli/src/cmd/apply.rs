//! `gravical apply`: a recording, calibrated.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::apply::{ApplyOptions, ApplySummary, GyroscopeOutcome, apply};
use gravical::calibration_file::CalibrationFile;
use gravical::document::{Block, Document, Remark, Section};
use gravical::output::one_line;
use gravical::recording::{Origin, open};

use crate::options::RecordingArgs;
use crate::report::ReportArgs;
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
    args.output
        .check(&ReportArgs::default(), &[&args.input, &args.calibration])?;
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
        let done = format!(
            "{}: {} rows calibrated",
            one_line(&summary.input),
            summary.rows
        );
        args.output.tell(&done, &document(&summary));
    }
    Ok(ExitCode::SUCCESS)
}

/// What was calibrated, from what to what.
fn document(summary: &ApplySummary) -> Document<'static> {
    let mut facts: Vec<(String, String)> = Vec::new();
    let mut fact = |name: &str, text: String| facts.push((name.to_owned(), text));
    fact("read as", summary.description.clone());
    let quiet = summary.quiet_norm_mps2.map_or(String::new(), |norm| {
        let g = summary.gravity_mps2;
        format!("; at its quietest {norm:.3} m/s², gravity is {g:.3}")
    });
    let (unit, how) = (
        summary.accelerometer.unit.name(),
        origin(summary.accelerometer.origin),
    );
    fact("accelerometer", format!("{unit} ({how}) → m/s²{quiet}"));
    match summary.gyroscope {
        GyroscopeOutcome::Calibrated(unit) => fact("gyroscope", format!("{} → rad/s", unit.name())),
        GyroscopeOutcome::Kept => {
            fact(
                "gyroscope",
                "kept as it is: the calibration has none".to_owned(),
            );
        }
        GyroscopeOutcome::Absent => {}
    }
    if let Some(t) = &summary.temperature {
        let (channels, [low, high]) = (t.channels.join(", "), t.range_c);
        let text = format!("drift of {channels} taken off, measured from {low:.1} to {high:.1} °C");
        fact("temperature", text);
    }
    let mut lines = format!("{} = {} rows", summary.lines, summary.rows);
    for aside in &summary.set_aside {
        lines.push_str(&format!(" + {} {}", aside.lines, aside.reason.name()));
    }
    fact("lines", lines);
    let mut section = Section::new("reading", "How it was read")
        .opening()
        .with(Block::Facts(facts));
    if !summary.findings.is_empty() {
        section = section.with(Block::Findings(Remark::all(&summary.findings, false)));
    }
    Document::default().with(section)
}

fn origin(origin: Origin) -> &'static str {
    match origin {
        Origin::Given => "given",
        Origin::Data => "as gravity shows",
        Origin::Header => "as the header says",
        Origin::Assumed => "assumed",
    }
}
