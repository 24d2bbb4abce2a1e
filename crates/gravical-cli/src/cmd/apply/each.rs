//! `gravical apply` with several recordings: each to a file of its own.

use std::path::Path;
use std::process::ExitCode;

use gravical::Error;
use gravical::apply::{ApplyOptions, apply};
use gravical::calibration_file::CalibrationFile;
use gravical::cohort::{ApplyValues, Outcome, ending_of};
use gravical::recording::{ReadOptions, open};

use super::Args;
use crate::cmd::words;
use crate::each::{self, EachArgs, Job, Kind, Plan, Work};
use crate::options::{SWAPPED, read_calibration};
use crate::table::write_file;

/// Runs the command for each of its recordings.
///
/// # Errors
///
/// What concerns all of them: options, the calibration, targets; `each-option` (usage) without a
/// folder for the results.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    EachArgs::refuse_beside(&[
        ("--gyro", args.gyro.is_some()),
        ("--store", args.store.is_given()),
    ])?;
    let Some(output) = args.output.output.as_deref() else {
        return Err(Error::usage(
            "each-option",
            "several recordings need a folder for their results",
        )
        .with_hint("give -o DIR")
        .into());
    };
    let options = args.options(&ReadOptions {
        meter: None,
        ..args.recording.read_options(false)
    });
    options.read.validate()?;
    let first = args.inputs.first().map(|p| p.as_path());
    let (calibration, _) = read_calibration(&args.calibration, first, SWAPPED)?;
    let plan = Plan {
        each: &args.each,
        words: words()?,
        inputs: &args.inputs,
        kind: match args.each.each {
            true => Kind::Recordings,
            false => Kind::Named,
        },
        output: Some(output),
        ending: ending_of("apply"),
        files: vec![Path::new(&args.calibration)],
        force: args.output.force,
        json: args.output.json,
        quiet: args.output.quiet,
        verbose: args.verbose,
    };
    let job = Applications {
        calibration,
        options,
    };
    each::run(&plan, &job)
}

struct Applications {
    calibration: CalibrationFile,
    options: ApplyOptions,
}

impl Job for Applications {
    type Values = ApplyValues;

    fn run(&self, work: &Work<'_>) -> anyhow::Result<Outcome<ApplyValues>> {
        let name = work.path.display().to_string();
        let input = open::open(work.path, &self.options.read)?;
        let result = work
            .result
            .ok_or_else(|| anyhow::anyhow!("no result is wanted"))?;
        let summary = write_file(result, work.force, |out| {
            let summary = apply(&self.calibration, input, &name, out, &self.options)?;
            // Published only if this returns.
            work.check_unchanged()?;
            Ok(summary)
        })?;
        Ok(Outcome::from(&summary))
    }
}
