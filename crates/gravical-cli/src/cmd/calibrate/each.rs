//! `gravical calibrate --each`: a calibration of each session.

use std::path::PathBuf;
use std::process::ExitCode;

use gravical::calibrate::CalibrateOptions;
use gravical::calibration_file::InputFile;
use gravical::cohort::{CalibrationValues, Outcome, ending_of};
use gravical::noise::{NoiseResult, read_noise};
use gravical::recording::ReadOptions;

use super::{Args, compute, save};
use crate::cmd::words;
use crate::each::{self, EachArgs, Job, Kind, Plan, Words, Work};

/// Runs the command for each of its sessions.
///
/// # Errors
///
/// What concerns all of them: options, `--noise`, `--sections`, targets.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    EachArgs::refuse_beside(&[
        ("--gyro", args.gyro.is_some()),
        ("--report", args.report.is_wanted()),
        ("--figures", args.figures.figures.is_some()),
        ("--store, --recorded", args.store.is_given()),
    ])?;
    let options = CalibrateOptions {
        // Of each session its own.
        command: None,
        ..args.options()?
    };
    options.validate()?;
    let read = ReadOptions {
        meter: None,
        ..args.recording.read_options(true)
    };
    read.validate()?;
    let noise = args.method.noise.as_deref().map(read_noise).transpose()?;
    let words = words()?;
    let files = args.method.sections.iter().chain(&args.method.thermal);
    let files = files.chain(&args.method.noise).map(PathBuf::as_path);
    let plan = Plan {
        each: &args.each,
        words: words.clone(),
        inputs: &args.inputs,
        kind: Kind::Sessions,
        output: args.output.as_deref(),
        ending: ending_of("calibrate"),
        files: files.collect(),
        force: args.force,
        json: args.json,
        quiet: args.quiet,
        verbose: args.report.is_verbose(),
    };
    let job = Calibrations {
        args,
        options,
        read,
        noise,
        words,
    };
    each::run(&plan, &job)
}

struct Calibrations<'a> {
    args: &'a Args,
    options: CalibrateOptions,
    read: ReadOptions,
    noise: Option<(NoiseResult, InputFile)>,
    words: Words,
}

impl Job for Calibrations<'_> {
    type Values = CalibrationValues;

    fn run(&self, work: &Work<'_>) -> anyhow::Result<Outcome<CalibrationValues>> {
        let input = [work.path.to_owned()];
        let noise = self.noise.as_ref();
        let mut file = compute(self.args, &input, &self.read, &self.options, noise)?.file;
        file.command = Some(self.words.command(work.path, work.result));
        work.check_unchanged()?;
        if let Some(path) = work.result {
            save(path, work.force, &file)?;
        }
        Ok(Outcome::from(&file))
    }
}
