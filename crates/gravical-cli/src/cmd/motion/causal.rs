//! `gravical motion --causal`: one pass without look-ahead.

use std::io;
use std::process::ExitCode;

use gravical::motion::{Calibrated, MotionOptions, Streamed, motion_stream};
use gravical::recording::open;
use gravical::{Error, Result};

use super::{Args, tell};
use crate::table::{Target, write_file};
use crate::text;

/// As [`super::run`], sample by sample.
///
/// # Errors
///
/// Those of [`super::run`]; `not-causal` (usage) for what needs the whole recording.
pub(super) fn run(
    args: &Args,
    target: Target<'_>,
    calibration: Option<Calibrated<'_>>,
    options: &MotionOptions,
) -> anyhow::Result<ExitCode> {
    if args.gyro.is_some() {
        return Err(not_causal("--gyro joins two files by time").into());
    }
    if args.truth()?.is_some() {
        return Err(not_causal("--truth compares a whole track").into());
    }
    if args.report.is_wanted() {
        return Err(not_causal("--report draws the whole track").into());
    }
    let name = args.input.display().to_string();
    let read = args.recording.read_options(false);
    let pass = |out: Option<&mut dyn io::Write>| -> Result<Streamed> {
        let input = open::open(&args.input, &read)?;
        motion_stream(input, &name, &read, calibration, options, out)
    };
    let done = match target {
        Target::File(path) => write_file(path, args.force, |out| pass(Some(out)))?,
        Target::Stdout if !args.json => pass(Some(&mut text::table_out()))?,
        Target::Stdout | Target::Nowhere => pass(None)?,
    };
    tell(args, &done.result, &done.head)
}

fn not_causal(what: &str) -> Error {
    Error::usage("not-causal", format!("--causal: {what}"))
        .with_hint("remove --causal: then the whole recording is read")
}
