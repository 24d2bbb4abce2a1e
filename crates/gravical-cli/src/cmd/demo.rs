//! `gravical demo`: the commands of a first session, on a simulated sensor with known true errors.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context as _;
use clap::Parser as _;
use gravical::Error;
use gravical::calibration_file::Calibration;
use gravical::core::matrix3::{norm, sub};
use gravical::escape::path_word;
use gravical::motion::{MotionOptions, motion};
use gravical::numfmt::{COVERAGE, milli_g};
use gravical::output::make_folder;
use gravical::recording::{ReadOptions, read};
use gravical_report::document::paragraph;

use crate::{Cli, text};

const INTRODUCTION: &str = "\
A simulated MPU6050: its true errors are known, so every result can be checked.
The header of its recordings is wrong on purpose: it names g and °/s, the values
are in m/s² and rad/s.
";

/// What it runs; `DIR` is the folder. With six free poses an error of 5 mg could stay undetected.
const COMMANDS: [&str; 4] = [
    "simulate poses -o DIR/poses --seed 2 --hold 3 --free 8 --wrong-header",
    "simulate line -o DIR/line --seed 2 --wrong-header",
    "calibrate DIR/poses/poses.csv --gravity 9.80665 -o DIR/calibration.json --report DIR/calibration.html",
    "motion DIR/line/line.csv -c DIR/calibration.json -o DIR/track.csv --report DIR/motion.html",
];

const NEXT: &str = "
Next, with your own recordings
  gravical calibrate FOLDER -o cal.json --report cal.html
  gravical motion RECORDING.csv -c cal.json -o track.csv --report motion.html
";

/// End-to-end demo on a simulated sensor (takes seconds)
#[derive(clap::Args)]
#[command(after_help = "\
Simulates a sensor at rest in fourteen poses and on a straight move of 0.7 m,
calibrates it with the poses, computes the move, and writes two reports.
Nothing is written outside DIR.")]
pub struct Args {
    /// Folder for the results [default: gravical-demo, gravical-demo-2, …]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Overwrite the results of an earlier run
    #[arg(long)]
    force: bool,
}

/// The folder of the first demo; with the next number where it is there and must stay.
fn free_folder(force: bool) -> PathBuf {
    let numbered = (2..).map(|n| PathBuf::from(format!("gravical-demo-{n}")));
    let mut folders = std::iter::once(PathBuf::from("gravical-demo")).chain(numbered);
    let is_free = |folder: &PathBuf| force || !folder.exists();
    folders.find(is_free).unwrap_or_default()
}

/// Runs the command.
///
/// # Errors
///
/// A folder that cannot be written, or that holds an earlier demo.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let folder = args.output.clone();
    let folder = folder.unwrap_or_else(|| free_folder(args.force));
    let mut files = std::fs::read_dir(&folder).into_iter().flatten();
    if !args.force && files.next().is_some() {
        let error = Error::usage("exists", "this folder is not empty; nothing was written");
        let error = error.at(&folder, None);
        let error = error.with_hint("name another folder, or overwrite the earlier demo");
        return Err(error.advise("force", "true").into());
    }
    make_folder(&folder)?;
    text::say(INTRODUCTION);
    for command in COMMANDS {
        let (mut shown, mut words) = ("$ gravical".to_owned(), vec!["gravical".into()]);
        for word in command.split(' ') {
            let path = word.strip_prefix("DIR/").map(|file| -> PathBuf {
                // With the separators of the system.
                folder.join(file).components().collect()
            });
            let typed = path.as_deref().map_or(word.to_owned(), path_word);
            shown += &format!(" {typed}");
            words.push(path.map_or(OsString::from(word), OsString::from));
        }
        text::say(&shown);
        words.push("--quiet".into());
        if args.force {
            words.push("--force".into());
        }
        Cli::try_parse_from(words)?.verb.run()?;
    }
    text::print_report(&summary(&folder)?)?;
    Ok(ExitCode::SUCCESS)
}

/// The three main numbers and the reports.
fn summary(folder: &Path) -> anyhow::Result<String> {
    let (file, input) = Calibration::read_with_input(&folder.join("calibration.json"))?;
    let calibration = (&file, &*input.path);
    let line = read(folder.join("line/line.csv"), &ReadOptions::default())?;
    let moved = motion(&line, Some(calibration), &MotionOptions::default())?.result;
    let classical = motion(&line, Some(calibration), &MotionOptions::report())?.result;
    let json = std::fs::read_to_string(folder.join("line/truth.json"))?;
    let truth: serde_json::Value = serde_json::from_str(&json)?;
    let truth = &truth["files"][0]["moves"][0]["displacement_m"];
    let truth: [f64; 3] = serde_json::from_value(truth.clone())?;
    let only = moved.moves.first().context("the line has no move")?;

    let errors = file.poses.iter().map(|p| norm(&p.raw) - file.gravity_mps2);
    let uncalibrated = (errors.map(|e| e * e).sum::<f64>() / file.poses.len() as f64).sqrt();
    let mg = |v: f64| format!("{:.1} mg", milli_g(v));
    let along = |v: Option<[f64; 3]>| v.map_or(f64::NAN, |v| v[1]);
    let end_error = |end: Option<[f64; 3]>| {
        end.map_or("–".to_owned(), |end| {
            format!("{:.0} mm", 1000.0 * norm(&sub(&end, &truth)))
        })
    };
    let left_out = file
        .reliability
        .left_out_rms_mps2
        .map_or("–".to_owned(), mg);
    let uncalibrated = mg(uncalibrated);
    let [y, sigma] = [only.displacement_m, only.sigma_m].map(along);
    let [end, report] = [&moved, &classical].map(|m| end_error(m.r#final.position_m));
    let numbers = [
        format!("leave-one-out error of ‖a‖ at rest: {left_out} rms; uncalibrated {uncalibrated}"),
        format!(
            "displacement along y: {y:.4} ± {:.4} m (95 %); true {:.4} m",
            COVERAGE * sigma,
            truth[1]
        ),
        format!(
            "end error: {end}; with the procedure of the student report and the same calibration: {report}"
        ),
    ];
    let numbers: String = numbers.iter().map(|text| paragraph("  - ", text)).collect();
    Ok(format!(
        "\nThe three main numbers\n{numbers}\nVerdict: {}\n\nReports, open them in a browser\n  {}\n  {}\n{NEXT}",
        file.grade(),
        folder.join("calibration.html").display(),
        folder.join("motion.html").display()
    ))
}
