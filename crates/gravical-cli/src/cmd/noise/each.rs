//! `gravical noise --each`: the noise of each recording.

use std::process::ExitCode;

use gravical::cohort::{NoiseValues, Outcome, ending_of};
use gravical::noise::{NoiseOptions, noise};
use gravical::recording::ReadOptions;

use super::{Args, json, options_of, write_text};
use crate::cmd::words;
use crate::each::{self, EachArgs, Job, Kind, Plan, Work};

/// Runs the command for each of its recordings.
///
/// # Errors
///
/// What concerns all of them: options, targets.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    EachArgs::refuse_beside(&[
        ("--report", args.report.is_wanted()),
        ("--figures", args.figures.figures.is_some()),
        ("--to", args.to.is_some()),
    ])?;
    let read = ReadOptions {
        meter: None,
        ..args.recording.read_options(true)
    };
    read.validate()?;
    let plan = Plan {
        each: &args.each,
        words: words()?,
        inputs: &args.inputs,
        kind: Kind::Recordings,
        output: args.output.as_deref(),
        ending: ending_of("noise"),
        files: Vec::new(),
        force: args.force,
        json: args.json,
        quiet: args.quiet,
        verbose: args.report.is_verbose(),
    };
    let job = Analyses {
        read,
        options: options_of(args),
    };
    each::run(&plan, &job)
}

struct Analyses {
    read: ReadOptions,
    options: NoiseOptions,
}

impl Job for Analyses {
    type Values = NoiseValues;

    fn run(&self, work: &Work<'_>) -> anyhow::Result<Outcome<NoiseValues>> {
        let result = noise(work.path, &self.read, &self.options)?;
        work.check_unchanged()?;
        if let Some(path) = work.result {
            write_text(path, work.force, &json(&result)?)?;
        }
        Ok(Outcome::from(&result))
    }
}
