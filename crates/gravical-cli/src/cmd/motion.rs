//! `gravical motion`: velocity and position with error bands.

mod args;
mod causal;

use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;

use gravical::calibration_file::InputFile;
use gravical::escape::one_line;
use gravical::motion::truth::{add_comparison, read_reference};
use gravical::motion::{
    Calibrated, Motion, MotionJudgement, MotionOptions, MotionResult, Table, motion, motion_into,
    write_table,
};
use gravical::noise::read_noise;
use gravical::output::write_atomic;
use gravical::recording::{Recording, join_gyroscope, read};
use gravical::{Error, Result};
use gravical_report::figure;
use gravical_report::report;

use crate::failure::QUALITY;
use crate::report::{check_outputs, with_origin};
use crate::store::{Taken, WithChoice};
use crate::table::Target;
use crate::text;

pub use args::Args;

/// Runs the command.
///
/// # Errors
///
/// Files that cannot be read or do not belong together, an existing output file, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let target = Target::of(args.output.as_deref());
    if args.causal
        && let Some(error) = args.figures.refused()
    {
        return Err(error.into());
    }
    check_outputs(
        target.file(),
        &args.report,
        Some(&args.figures),
        &args.files(),
        args.force,
    )?;
    let noise = args.noise.as_deref().map(read_noise).transpose()?;
    let options = args.options(noise.as_ref().map(|(result, _)| result.section()))?;
    options.validate()?;
    let truth = args.truth()?;
    // A report lists the checksum of its input.
    let read_options = args.recording.read_options(args.report.is_wanted());
    let taken = args.store.take(
        args.calibration.as_deref(),
        std::slice::from_ref(&args.input),
        &read_options,
        "the arguments are swapped: the recording is the argument, the calibration belongs to -c",
    )?;
    let calibrated = taken.as_ref().map(|taken| Calibrated {
        file: &taken.file,
        name: &taken.input.path,
    });

    if args.causal {
        return causal::run(args, target, calibrated, taken.as_ref(), &options);
    }
    let mut recording = match &args.gyro {
        Some(path) => {
            let mut recording = read(&args.input, &read_options.beside_gyroscope_file())?;
            join_gyroscope(&mut recording, path, &read_options)?;
            recording
        }
        None => read(&args.input, &read_options)?,
    };
    let whole = truth.is_some() || args.report.is_wanted() || args.figures.figures.is_some();
    if !whole {
        let result = samples_away(args, target, &mut recording, calibrated, &options)?;
        return tell(args, &result, taken.as_ref(), &recording);
    }
    let mut motion = motion(&recording, calibrated, &options)?;
    let calibration = taken.iter().map(|taken| taken.input.clone());
    let mut inputs = InputFile::of(std::slice::from_ref(&recording));
    inputs.extend(calibration);
    inputs.extend(noise.map(|(_, input)| input));
    if let Some((path, truth)) = truth {
        let reference = read_reference(path, truth.columns.as_ref(), &recording, &args.input)?;
        add_comparison(&mut motion, &reference, &truth)?;
        inputs.push(reference.input());
    }

    match target {
        Target::File(path) => save(path, args.force, &motion)?,
        Target::Stdout if !args.json => write_table(&motion.track, &mut text::table_out())?,
        Target::Stdout | Target::Nowhere => {}
    }
    let drawn = args.report.is_wanted() || args.figures.figures.is_some();
    let figures = match drawn {
        true => figure::motion::figures(&motion),
        false => Vec::new(),
    };
    args.figures.write(&figures, args.force, args.quiet)?;
    if args.report.is_wanted() {
        let mut document = report::motion(&motion.result, &recording, &figures);
        taken.iter().for_each(|taken| taken.add_to(&mut document));
        args.report
            .write(args.force, &with_origin(document, &inputs))?;
    }
    tell(args, &motion.result, taken.as_ref(), &recording)
}

/// The result, its table written sample by sample without keeping the track.
fn samples_away(
    args: &Args,
    target: Target<'_>,
    recording: &mut Recording,
    calibrated: Option<Calibrated<'_>>,
    options: &MotionOptions,
) -> anyhow::Result<MotionResult> {
    let path = match target {
        Target::File(path) => path,
        Target::Stdout if !args.json => {
            let mut out = text::table_out();
            let mut table = Table::new(&mut out);
            let result = motion_into(recording, calibrated, options, Some(&mut table))?;
            table.finish()?;
            return Ok(result);
        }
        Target::Stdout | Target::Nowhere => {
            return Ok(motion_into(recording, calibrated, options, None)?);
        }
    };
    let mut result = None;
    write_atomic(path, args.force, |out| {
        let mut table = Table::new(out);
        result = Some(motion_into(
            recording,
            calibrated,
            options,
            Some(&mut table),
        )?);
        table.finish().map_err(|e| Error::io(path, e))
    })?;
    result.context("a table without a result")
}

/// Writes the table of a motion to a file.
///
/// # Errors
///
/// Those of [`write_atomic`].
pub fn save(path: &Path, force: bool, motion: &Motion) -> Result<()> {
    write_atomic(path, force, |out| {
        write_table(&motion.track, out).map_err(|e| Error::io(path, e))
    })
}

/// Prints the result.
fn tell(
    args: &Args,
    result: &MotionResult,
    taken: Option<&Taken>,
    recording: &Recording,
) -> anyhow::Result<ExitCode> {
    if args.json {
        let store = taken.and_then(|taken| taken.choice.as_ref());
        text::print_json(&WithChoice { result, store })?;
    }
    if !args.quiet {
        let target = Target::of(args.output.as_deref());
        let to = match target {
            Target::Stdout if args.json => String::new(),
            _ => target.arrow(),
        };
        let input = one_line(&result.input);
        text::say(&format!("{input}: {} rows{to}", result.rows));
        let mut document = report::motion(result, recording, &[]);
        taken.iter().for_each(|taken| taken.add_to(&mut document));
        text::say_report(document.to_text(args.report.detail()).trim_end());
        if target == Target::Nowhere && !args.json {
            text::say(target.hint().trim_end());
        }
        args.report.say();
    }
    Ok(if result.verdict.judgement == MotionJudgement::NotUsable {
        ExitCode::from(QUALITY)
    } else {
        ExitCode::SUCCESS
    })
}
