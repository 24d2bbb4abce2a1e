//! `gravical inspect`: the content of a recording.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::Error;
use gravical::calibration_file::InputFile;
use gravical::inspect::inspect;
use gravical::poses::SegmentOptions;
use gravical::recording::{ReadOptions, read, read_joined};
use gravical::session::{files_in, is_something_else, read_listed, several_with_gyro};
use gravical_report::document::flag;
use gravical_report::{figure, report};

use crate::failure::RenderedError;
use crate::options::reading;
use crate::report::{ResultArgs, with_origin};
use crate::text;

/// Show what is in a recording: columns, units, rate, defects, rests
#[derive(clap::Args)]
#[command(after_help = "\
Example: gravical inspect session/*.csv

Exit codes: 0 read, 3 at least one file cannot be read")]
pub struct Args {
    /// Recordings, or folders of them; - for stdin
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    result: ResultArgs,
    /// Gyroscope in a second file, joined by time
    #[arg(long, value_name = "FILE")]
    gyro: Option<PathBuf>,
    #[command(flatten)]
    recording: ReadOptions,
    #[command(flatten)]
    options: SegmentOptions,
}

/// Runs the command. A file that cannot be read does not stop the others.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let ResultArgs { report, json, .. } = &args.result;
    let options = reading(&args.recording, report.is_wanted());
    options.validate()?;
    args.result
        .check(None, args.files.iter().chain(&args.gyro))?;
    // Each with whether it is a file of a folder, which need not be a recording.
    let mut files: Vec<(PathBuf, bool)> = Vec::new();
    for path in &args.files {
        if path.is_dir() {
            files.extend(files_in(path)?.into_iter().map(|file| (file, true)));
        } else {
            files.push((path.clone(), false));
        }
    }
    if args.gyro.is_some() && files.len() != 1 {
        return Err(several_with_gyro(files.len()).into());
    }
    if report.is_wanted() && files.len() != 1 {
        let error = Error::usage("report-of-one", "a report describes one recording");
        let hint = "inspect one file at a time, each with its own report";
        return Err(error.with_hint(hint).into());
    }
    let (mut found, mut failed, mut is_bad) = (Vec::new(), Vec::new(), false);
    for (path, listed) in &files {
        let read_one = |path: &Path, how: &ReadOptions| {
            if *listed {
                read_listed(path, how)
            } else {
                read(path, how)
            }
        };
        let recording = match read_joined(path, args.gyro.as_deref(), &options, read_one) {
            Ok(recording) => recording,
            Err(error) if *listed && is_something_else(&error) && !json => {
                text::print(&format!("{}\n\n", error.worded(flag)))?;
                continue;
            }
            Err(error) => {
                is_bad |= !(*listed && is_something_else(&error));
                failed.push(RenderedError::own(&error));
                continue;
            }
        };
        let inspection = inspect(&recording, &args.options.axes);
        let figures = report.figures(|| figure::inspection::inspection(&inspection, &recording));
        let document = report::inspection(&inspection, &figures);
        let document = with_origin(document, &InputFile::of(&[recording]));
        if *json {
            report.write(args.result.force, &document)?;
            report.say(args.result.quiet);
            found.push(inspection);
        } else {
            args.result.present(&inspection, &document)?;
            if files.len() > 1 && !args.result.quiet {
                text::print("\n")?;
            }
        }
    }
    if *json {
        text::print_json(&serde_json::json!({"recordings": found, "errors": failed}))?;
        return Ok(ExitCode::from(if is_bad { 3 } else { 0 }));
    }
    let print = |_, error: &RenderedError| error.print();
    Ok(failed.iter().fold(ExitCode::SUCCESS, print))
}
