//! `gravical inspect`: the content of a recording.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::Error;
use gravical::calibration_file::InputFile;
use gravical::inspect::{InspectOptions, inspect};
use gravical::recording::{ReadOptions, join_gyroscope, read};
use gravical::session::{axes, files_in, is_something_else, read_listed, several_with_gyro};
use gravical_report::document::flag;
use gravical_report::report;

use crate::options::reading;
use crate::report::{ReportArgs, with_origin};
use crate::{failure, text};

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
    report: ReportArgs,
    /// Gyroscope in a second file, joined by time
    #[arg(long, value_name = "FILE")]
    gyro: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print JSON: {"recordings": […], "errors": […]}
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    recording: ReadOptions,
    #[command(flatten)]
    options: InspectOptions,
}

/// Runs the command. A file that cannot be read does not stop the others.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let options = reading(&args.recording, args.report.is_wanted());
    options.validate()?;
    let inputs = args.files.iter().chain(&args.gyro);
    args.report.check(None, inputs, args.force)?;
    let (mut found, mut failed) = (Vec::new(), Vec::new());
    let mut files: Vec<(PathBuf, bool)> = Vec::new();
    for path in axes::group(&args.files) {
        if path.is_dir() {
            files.extend(files_in(&path)?.into_iter().map(|file| (file, true)));
        } else {
            files.push((path, false));
        }
    }
    if args.gyro.is_some() && files.len() != 1 {
        return Err(several_with_gyro(files.len()).into());
    }
    if args.report.is_wanted() && files.len() != 1 {
        return Err(
            Error::usage("report-of-one", "a report describes one recording")
                .with_hint("inspect one file at a time, each with its own report")
                .into(),
        );
    }
    let of_recording = match &args.gyro {
        Some(_) => options.beside_gyroscope_file(),
        None => options.clone(),
    };
    for (path, listed) in &files {
        let recording = if *listed {
            read_listed(path, &of_recording)
        } else {
            read(path, &of_recording)
        };
        let recording = recording.and_then(|mut recording| {
            if let Some(gyro) = &args.gyro {
                join_gyroscope(&mut recording, gyro, &options)?;
            }
            Ok(recording)
        });
        match recording {
            Ok(recording) => {
                let inspection = inspect(&recording, &args.options.axes);
                let document = report::inspection(&inspection);
                let document = with_origin(document, &InputFile::of(&[recording]));
                args.report.write(args.force, &document)?;
                args.report.say();
                if args.json {
                    found.push(inspection);
                } else {
                    text::print_report(&document.to_text(args.report.detail()))?;
                    if files.len() > 1 {
                        text::print("\n")?;
                    }
                }
            }
            // A file of a folder need not be a recording.
            Err(error) if *listed && is_something_else(&error) && !args.json => {
                text::print(&format!("{}\n\n", error.worded(flag)))?;
            }
            Err(error) => failed.push((error, *listed)),
        }
    }
    let serious = failed
        .iter()
        .any(|(error, listed)| !(*listed && is_something_else(error)));
    if args.json {
        let errors: Vec<_> = failed
            .iter()
            .map(|(e, _)| serde_json::json!({"code": e.code(), "message": e.worded(flag), "hint": e.worded_hint(flag)}))
            .collect();
        text::print_json(&serde_json::json!({"recordings": found, "errors": errors}))?;
        return Ok(ExitCode::from(if serious { 3 } else { 0 }));
    }
    let mut code = ExitCode::SUCCESS;
    for (error, _) in failed {
        code = failure::report(&error.into(), false);
    }
    Ok(code)
}
