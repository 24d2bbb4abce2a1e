//! `gravical summarise --each`: the epochs of each recording.

use std::process::ExitCode;

use gravical::calibration_file::CalibrationFile;
use gravical::cohort::{Outcome, SummaryValues, ending_of};
use gravical::wearable::{SummariseOptions, summarise};

use super::Args;
use crate::cmd::words;
use crate::each::{self, EachArgs, Job, Kind, Plan, Work};
use crate::table::write_file;

/// Runs the command for each of its recordings.
///
/// # Errors
///
/// What concerns all of them: options, the calibration, targets.
pub fn run(args: &Args, mut options: SummariseOptions) -> anyhow::Result<ExitCode> {
    EachArgs::refuse_beside(&[("--report", args.report.is_wanted())])?;
    options.read.meter = None;
    let calibration = args.calibration()?.map(|(file, _)| file);
    let plan = Plan {
        each: &args.each,
        words: words()?,
        inputs: &args.inputs,
        kind: Kind::Recordings,
        output: args.output.output.as_deref(),
        ending: ending_of("summarise"),
        files: args.calibration.iter().map(|p| p.as_path()).collect(),
        force: args.output.force,
        json: args.output.json,
        quiet: args.output.quiet,
        verbose: args.report.is_verbose(),
    };
    let job = Summaries {
        calibration,
        options,
    };
    each::run(&plan, &job)
}

struct Summaries {
    calibration: Option<CalibrationFile>,
    options: SummariseOptions,
}

impl Job for Summaries {
    type Values = SummaryValues;

    fn run(&self, work: &Work<'_>) -> anyhow::Result<Outcome<SummaryValues>> {
        let calibration = self.calibration.as_ref();
        let pass = |out: &mut dyn std::io::Write| {
            let summary = summarise(work.path, calibration, &self.options, out)?;
            // Published only if this returns.
            work.check_unchanged()?;
            Ok(summary)
        };
        let summary = match work.result {
            Some(path) => write_file(path, work.force, pass)?,
            None => pass(&mut std::io::sink())?,
        };
        Ok(Outcome::from(&summary))
    }
}
