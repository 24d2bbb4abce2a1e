//! `gravical demo`: end-to-end demo on a simulated sensor with known true errors.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::Serialize;

use gravical::Result;
use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::{CalibrationFile, InputFile};
use gravical::gravity::Gravity;
use gravical::inspect::inspect;
use gravical::motion::{Calibrated, Motion, MotionOptions, motion};
use gravical::output::{check_target, make_folder};
use gravical::poses::face::AxisMap;
use gravical::recording::{ReadOptions, Recording, Severity, read};
use gravical::simulate::{
    FileOptions, LineOptions, PosesOptions, Scenario, SimulateOptions, Truth, simulate_to,
};
use gravical_core::matrix3::norm;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_report::document::{flag, paragraph};
use gravical_report::figure::{self, calibration::Session};
use gravical_report::report;

use crate::options::command_line;
use crate::report::{with_origin, write_report};
use crate::text;

const NEXT: &str = "
Next, with your own recordings
  gravical calibrate FOLDER -o cal.json --report cal.html
  gravical motion RECORDING.csv -c cal.json -o track.csv --report motion.html
";

/// Seed, the same as in `examples/demo`.
const SEED: u64 = 2;
/// Duration of a pose, s.
const HOLD_S: f64 = 3.0;
/// Free poses beside the six faces; with six of them an error of 5 mg could stay undetected.
const FREE: u32 = 8;

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
    /// Print the files and numbers as JSON
    #[arg(long)]
    json: bool,
}

/// Result of the demo.
#[derive(Debug, Serialize)]
struct Summary {
    /// Files written, in the order of the steps.
    files: Vec<PathBuf>,
    /// Verdict of the calibration.
    verdict: String,
    /// ‖a‖ − g of the raw poses, rms, m/s².
    norm_error_uncalibrated_mps2: f64,
    /// The same of poses left out of the fit, calibrated, m/s².
    norm_error_left_out_mps2: Option<f64>,
    /// True displacement, m.
    true_displacement_m: [f64; 3],
    /// Computed displacement, m.
    displacement_m: Option<[f64; 3]>,
    /// Its standard uncertainty, m.
    sigma_m: Option<[f64; 3]>,
    /// End-point error, m.
    end_error_m: Option<f64>,
    /// The same by the procedure of the student report, m.
    end_error_report_m: Option<f64>,
}

/// Output files, in the order of the steps.
const FILES: [&str; 8] = [
    "poses/poses.csv",
    "poses/truth.json",
    "line/line.csv",
    "line/truth.json",
    CALIBRATION,
    CALIBRATION_REPORT,
    TRACK,
    MOTION_REPORT,
];
const CALIBRATION: &str = "calibration.json";
const CALIBRATION_REPORT: &str = "calibration.html";
const TRACK: &str = "track.csv";
const MOTION_REPORT: &str = "motion.html";

/// The folder of the first demo; with the next number where it is there and must stay.
fn free_folder(force: bool) -> PathBuf {
    let first = PathBuf::from("gravical-demo");
    let mut numbered = (2..).map(|n| PathBuf::from(format!("gravical-demo-{n}")));
    if force || !first.exists() {
        return first;
    }
    numbered.find(|folder| !folder.exists()).unwrap_or(first)
}

/// Runs the command.
///
/// # Errors
///
/// A folder that cannot be written, or that holds an earlier demo.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let force = args.force;
    let folder = args.output.clone().unwrap_or_else(|| free_folder(force));
    let at = |file: &str| folder.join(file);
    for file in FILES {
        check_target(&at(file), force).map_err(|e| {
            e.with_hint("name another folder, or add --force to overwrite the earlier demo")
        })?;
    }
    make_folder(&folder)?;
    let say = |line: &str| {
        if !args.json {
            text::say(line);
        }
    };

    say(
        "A simulated MPU6050: its true errors are known, so every result can be checked.\n\
         The header of its recordings is wrong on purpose: it names g and °/s, the values\n\
         are in m/s² and rad/s.\n",
    );
    let poses = Scenario::Poses(PosesOptions {
        hold_s: HOLD_S,
        free: FREE,
    });
    let (_, poses) = record(poses, &at("poses"), force)?;
    let (truth, line) = record(Scenario::Line(LineOptions::default()), &at("line"), force)?;
    say(&format!(
        "1 record     {}\n             {}",
        poses.name, line.name
    ));

    let seen = inspect(&poses, &AxisMap::default());
    say(&format!(
        "2 inspect    {} rows, {} poses",
        seen.row_counts.rows,
        seen.static_intervals.len(),
    ));
    let warnings = seen.findings.iter();
    for finding in warnings.filter(|f| f.severity == Severity::Warning) {
        let text = format!("{}: {}", finding.kind, finding.worded(flag));
        say(paragraph("             noticed: ", &text).trim_end());
    }

    let recordings = std::slice::from_ref(&poses);
    let options = CalibrateOptions {
        gravity: Gravity::given(truth.gravity_mps2)?,
        command: Some(command_line()),
        ..CalibrateOptions::default()
    };
    let done = calibrate(recordings, &options)?;
    let path = at(CALIBRATION);
    let saved = super::calibrate::save(&path, force, &done.file)?;
    let session = Session {
        recordings,
        segmentation: &done.segmentation,
    };
    let figures = figure::calibration::figures(&done.file, Some(session));
    let document = report::calibration(&done.file, Some(&path), &figures);
    write_report(&at(CALIBRATION_REPORT), force, &document)?;
    say(&format!("3 calibrate  {}", path.display()));

    let calibration = Calibrated {
        file: &done.file,
        name: &saved.path,
    };
    let moved = motion(&line, Some(calibration), &MotionOptions::default())?;
    super::motion::save(&at(TRACK), force, &moved)?;
    let figures = figure::motion::figures(&moved);
    let mut inputs = InputFile::of(std::slice::from_ref(&line));
    inputs.push(saved.clone());
    let document = with_origin(report::motion(&moved.result, &line, &figures), &inputs);
    write_report(&at(MOTION_REPORT), force, &document)?;
    say(&format!("4 motion     {}", at(TRACK).display()));

    let classical = motion(&line, Some(calibration), &MotionOptions::report())?;
    let summary = summary(&folder, &truth, &done.file, &moved, &classical);
    if args.json {
        text::print_json(&summary)?;
    } else {
        text::print_report(&summary_text(&summary, &folder))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Simulates a recording, writes it under a wrong header and reads it back.
fn record(scenario: Scenario, folder: &Path, force: bool) -> Result<(Truth, Recording)> {
    let options = SimulateOptions {
        seed: SEED,
        file: FileOptions {
            wrong_header: true,
            ..FileOptions::default()
        },
        ..SimulateOptions::new(scenario)
    };
    let (truth, written) = simulate_to(&options, folder, force)?;
    let path = written.first().map_or(folder, PathBuf::as_path);
    let hashed = ReadOptions {
        hash: true,
        ..ReadOptions::default()
    };
    Ok((truth, read(path, &hashed)?))
}

fn summary(
    folder: &Path,
    truth: &Truth,
    file: &CalibrationFile,
    moved: &Motion,
    classical: &Motion,
) -> Summary {
    let a = &file.accelerometer;
    let g = file.gravity_mps2;
    let rms = |errors: Vec<f64>| {
        let n = errors.len().max(1) as f64;
        (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt()
    };
    let raw = a.poses.iter().map(|p| norm(&p.raw) - g).collect();
    let moves = truth.files.iter().flat_map(|f| &f.moves);
    let truth = moves.map(|m| m.displacement_m).next().unwrap_or_default();
    let error = |end: Option<[f64; 3]>| {
        let end = end?;
        Some(norm(&std::array::from_fn(|k| end[k] - truth[k])))
    };
    let only = moved.result.moves.first();
    Summary {
        files: FILES.map(|file| folder.join(file)).to_vec(),
        verdict: file.verdict.grade.to_string(),
        norm_error_uncalibrated_mps2: rms(raw),
        norm_error_left_out_mps2: a.leave_one_out_rms_mps2,
        true_displacement_m: truth,
        displacement_m: only.and_then(|m| m.displacement_m),
        sigma_m: only.and_then(|m| m.sigma_m),
        end_error_m: error(moved.result.r#final.position_m),
        end_error_report_m: error(classical.result.r#final.position_m),
    }
}

/// The three main numbers and the reports.
fn summary_text(s: &Summary, folder: &Path) -> String {
    let mg = |v: f64| format!("{:.1} mg", 1000.0 * v / STANDARD_GRAVITY_MPS2);
    let mm = |v: Option<f64>| v.map_or("–".to_owned(), |v| format!("{:.0} mm", 1000.0 * v));
    let along = |v: Option<[f64; 3]>| v.map_or(f64::NAN, |v| v[1]);
    let mut out = String::from("\nThe three main numbers\n");
    let mut row = |text: String| out.push_str(&paragraph("  - ", &text));
    row(format!(
        "leave-one-out error of ‖a‖ at rest: {} rms; uncalibrated {}",
        s.norm_error_left_out_mps2.map_or("–".to_owned(), mg),
        mg(s.norm_error_uncalibrated_mps2)
    ));
    row(format!(
        "displacement along y: {:.4} ± {:.4} m (1σ); true {:.4} m",
        along(s.displacement_m),
        along(s.sigma_m),
        s.true_displacement_m[1]
    ));
    row(format!(
        "end error: {}; with the procedure of the student report and the same calibration: {}",
        mm(s.end_error_m),
        mm(s.end_error_report_m)
    ));
    out.push_str(&format!(
        "\nVerdict: {}\n\nReports, open them in a browser\n  {}\n  {}\n",
        s.verdict,
        folder.join(CALIBRATION_REPORT).display(),
        folder.join(MOTION_REPORT).display()
    ));
    out + NEXT
}
