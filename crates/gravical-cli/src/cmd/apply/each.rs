//! `gravical apply` with several recordings: each to a file of its own.

use std::path::Path;
use std::process::ExitCode;

use gravical::Error;
use gravical::apply::{ApplyOptions, ApplySummary, apply};
use gravical::calibration_file::CalibrationFile;
use gravical::cohort::{ApplyValues, kinds};
use gravical::recording::{ReadOptions, open};

use super::Args;
use crate::cmd::words;
use crate::each::{self, EachArgs, Job, Kind, Outcome, Plan, Work};
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
        ending: Some(ending),
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

/// The ending of the recording, unpacked.
fn ending(path: &Path) -> String {
    let plain = match path.extension() {
        Some(e) if e.eq_ignore_ascii_case("gz") => path.with_extension(""),
        _ => path.to_owned(),
    };
    let ending = plain.extension().unwrap_or_else(|| "csv".as_ref());
    format!(".{}", ending.to_string_lossy())
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
        Ok(Outcome {
            verdict: "done".to_owned(),
            is_poor: false,
            reasons: vec![reason(&summary)],
            values: ApplyValues::from(&summary),
        })
    }
}

fn reason(summary: &ApplySummary) -> String {
    let rows = format!("{} rows", summary.rows);
    match kinds(&summary.findings) {
        none if none.is_empty() => rows,
        kinds => format!("{rows}; {kinds}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_not_packed() {
        for (path, own) in [
            ("a.csv", ".csv"),
            ("a.TXT", ".TXT"),
            ("a.csv.gz", ".csv"),
            ("a.gz", ".csv"),
            ("a", ".csv"),
        ] {
            assert_eq!(ending(Path::new(path)), own, "{path}");
        }
    }
}
