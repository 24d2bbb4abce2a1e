//! `gravical motion`: velocity and position with error bands.

mod args;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::calibration_file::InputFile;
use gravical::escape::one_line;
use gravical::motion::truth::{add_comparison, read_reference};
use gravical::motion::{Calibrated, Motion, MotionJudgement, MotionResult, motion, write_table};
use gravical::noise::read_noise;
use gravical::output::write_atomic;
use gravical::recording::{Recording, join_gyroscope, read_samples};
use gravical::{Error, Result};
use gravical_report::figure;
use gravical_report::report;

use crate::failure::QUALITY;
use crate::options::reading;
use crate::report::{check_outputs, with_origin};
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
    let files = args.files();
    check_outputs(
        target.file(),
        &args.report,
        Some(&args.figures),
        &files.iter().map(PathBuf::as_path).collect::<Vec<_>>(),
        args.force,
    )?;
    let noise = args.noise.as_deref().map(read_noise).transpose()?;
    let options = args.options(noise.as_ref().map(|(result, _)| result.section()))?;
    options.validate()?;
    let truth = args.truth()?;
    // A report lists the checksum of its input.
    let read_options = reading(&args.recording, args.report.is_wanted());
    let inputs = std::slice::from_ref(&args.input);
    let swap =
        "the arguments are swapped: the recording is the argument, the calibration belongs to -c";
    let quiet = args.quiet;
    let find = |path: &PathBuf| args.origin.read(path, inputs, &read_options, swap, quiet);
    let calibration = args.calibration.as_ref().map(find).transpose()?;
    let calibrated = calibration.as_ref().map(|found| Calibrated {
        file: &found.file,
        name: &found.input.path,
    });

    let recording = match &args.gyro {
        Some(path) => {
            let mut recording = read_samples(&args.input, &read_options.beside_gyroscope_file())?;
            join_gyroscope(&mut recording, path, &read_options)?;
            recording
        }
        None => read_samples(&args.input, &read_options)?,
    };
    let mut motion = motion(&recording, calibrated, &options)?;
    let mut inputs = InputFile::of(std::slice::from_ref(&recording));
    inputs.extend(calibration.iter().map(|found| found.input.clone()));
    inputs.extend(noise.map(|(_, input)| input));
    if let Some(path) = truth {
        let reference = read_reference(path, &recording, &args.input)?;
        add_comparison(&mut motion, &reference)?;
        inputs.push(reference.input());
    }

    match target {
        Target::File(path) => save(path, args.force, &motion)?,
        Target::Stdout if !args.json => write_table(&motion, &mut text::table_out())?,
        Target::Stdout | Target::Nowhere => {}
    }
    let drawn = args.report.is_wanted() || args.figures.figures.is_some();
    let figures = match drawn {
        true => figure::motion::figures(&motion),
        false => Vec::new(),
    };
    args.figures.write(&figures, args.force, args.quiet)?;
    if args.report.is_wanted() {
        let document = report::motion(&motion.result, &recording, &figures);
        args.report
            .write(args.force, &with_origin(document, &inputs))?;
    }
    tell(args, &motion.result, &recording)
}

/// Writes the table of a motion to a file.
///
/// # Errors
///
/// Those of [`write_atomic`].
pub fn save(path: &Path, force: bool, motion: &Motion) -> Result<()> {
    write_atomic(path, force, |out| {
        write_table(motion, out).map_err(|e| Error::io(path, e))
    })
}

/// Prints the result.
fn tell(args: &Args, result: &MotionResult, recording: &Recording) -> anyhow::Result<ExitCode> {
    if args.json {
        text::print_json(result)?;
    }
    if !args.quiet {
        let target = Target::of(args.output.as_deref());
        let to = match target {
            Target::Stdout if args.json => String::new(),
            _ => target.arrow(),
        };
        let input = one_line(&result.input);
        text::say(&format!("{input}: {} rows{to}", result.rows));
        let document = report::motion(result, recording, &[]);
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
