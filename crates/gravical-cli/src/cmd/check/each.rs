//! `gravical check --each`: the check of each session, as on a production line.

use std::path::Path;
use std::process::ExitCode;

use gravical::calibration_file::CalibrationFile;
use gravical::check::CheckOptions;
use gravical::cohort::{CheckValues, Outcome};
use gravical::recording::ReadOptions;

use super::{Args, compute};
use crate::cmd::words;
use crate::each::{self, EachArgs, Job, Kind, Plan, Work};
use crate::options::{SWAPPED, read_calibration};

/// Runs the command for each of its sessions.
///
/// # Errors
///
/// What concerns all of them: options, the calibration, targets.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    EachArgs::refuse_beside(&[
        ("--gyro", args.gyro.is_some()),
        ("--report", args.report.is_wanted()),
        ("--store", args.store.is_given()),
    ])?;
    let read = ReadOptions {
        meter: None,
        ..args.recording.read_options(true)
    };
    read.validate()?;
    let first = args.recordings.first().map(|p| p.as_path());
    let (calibration, _) = read_calibration(&args.calibration, first, SWAPPED)?;
    let plan = Plan {
        each: &args.each,
        words: words()?,
        inputs: &args.recordings,
        kind: Kind::Sessions,
        output: None,
        ending: None,
        files: vec![Path::new(&args.calibration)],
        force: args.force,
        json: args.json,
        quiet: args.quiet,
        verbose: args.report.is_verbose(),
    };
    let job = Checks {
        args,
        options: args.options()?,
        read,
        calibration,
    };
    each::run(&plan, &job)
}

struct Checks<'a> {
    args: &'a Args,
    options: CheckOptions,
    read: ReadOptions,
    calibration: CalibrationFile,
}

impl Job for Checks<'_> {
    type Values = CheckValues;

    fn run(&self, work: &Work<'_>) -> anyhow::Result<Outcome<CheckValues>> {
        let input = [work.path.to_owned()];
        let (report, _) = compute(
            self.args,
            &self.calibration,
            &self.args.calibration,
            &input,
            &self.read,
            &self.options,
        )?;
        work.check_unchanged()?;
        Ok(Outcome::from(&report))
    }
}
