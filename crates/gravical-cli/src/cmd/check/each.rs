//! `gravical check --each`: the check of each session, as on a production line.

use std::path::Path;
use std::process::ExitCode;

use gravical::calibration_file::CalibrationFile;
use gravical::check::{CheckOptions, CheckReport, Judgement};
use gravical::recording::ReadOptions;
use serde::{Deserialize, Serialize};

use super::{Args, compute};
use crate::cmd::words;
use crate::each::{self, Columns, EachArgs, Job, Kind, Outcome, Plan, Work};
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
    type Values = Values;

    fn run(&self, work: &Work<'_>) -> anyhow::Result<Outcome<Values>> {
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
        let judgement = report.verdict.judgement;
        Ok(Outcome {
            verdict: judgement.name().to_owned(),
            is_poor: judgement == Judgement::DoesNotFit,
            reasons: report.verdict.reasons.clone(),
            values: Values::of(&report),
        })
    }
}

/// The numbers of a check.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Values {
    static_intervals: usize,
    rms_mps2: f64,
    predicted_rms_mps2: Option<f64>,
    worst_error_mps2: Option<f64>,
    worst_z: Option<f64>,
    p_value: Option<f64>,
    gyroscope: Option<String>,
    findings: String,
}

impl Columns for Values {
    const NAMES: &'static [&'static str] = &[
        "static_intervals",
        "rms_mps2",
        "predicted_rms_mps2",
        "worst_error_mps2",
        "worst_z",
        "p_value",
        "gyroscope",
        "findings",
    ];
}

impl Values {
    fn of(report: &CheckReport) -> Self {
        let worst = report.static_intervals.get(report.worst);
        Values {
            static_intervals: report.static_intervals.len(),
            rms_mps2: report.rms_mps2,
            predicted_rms_mps2: report.predicted_rms_mps2,
            worst_error_mps2: worst.map(|s| s.error_mps2),
            worst_z: worst.and_then(|s| s.z),
            p_value: report.p_value,
            gyroscope: report
                .gyroscope
                .as_ref()
                .map(|g| g.judgement.name().to_owned()),
            findings: each::kinds(&report.findings),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_the_fields() {
        each::assert_columns(&Values::default());
    }
}
