//! `gravical demo`: the whole way on a virtual sensor, whose truth is known.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::Serialize;

use gravical::Result;
use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::{CalibrationFile, InputFile, creation_time};
use gravical::document::paragraph;
use gravical::figure::{self, calibration::Session};
use gravical::gravity::Gravity;
use gravical::inspect::inspect;
use gravical::motion::{Calibrated, Motion, MotionOptions, motion};
use gravical::output::{check_target, make_folder};
use gravical::recording::{ReadOptions, Recording, Severity, read};
use gravical::report::{self, Provenance, TOOL};
use gravical::segment::face::AxisMap;
use gravical::simulate::{
    LineOptions, PosesOptions, Scenario, SimulateOptions, Simulation, simulate, write,
};
use gravical_core::matrix3::norm;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::report::write_report;
use crate::text;

const NEXT: &str = "
Next, with recordings of your own
  gravical calibrate FOLDER -o cal.json --report cal.html
  gravical motion RECORDING.csv -c cal.json -o track.csv --report motion.html
";

/// Whose draw it is: that of `examples/demo`.
const SEED: u64 = 2;
/// What the reports say they were made by.
const COMMAND: &str = "gravical demo";
/// Length of a hold, s.
const HOLD_S: f64 = 3.0;
/// Oblique positions beside the six faces: with six, an error of 5 mg could hide.
const FREE: u32 = 8;

#[derive(clap::Args)]
#[command(after_help = "\
Simulates a sensor in fourteen positions and on a way of 0.7 m, calibrates it with
the first, finds the way with the second, and writes two reports. Nothing is
opened; nothing is written outside of DIR.")]
pub struct Args {
    /// Folder for what it makes
    #[arg(default_value = "gravical-demo", value_name = "DIR")]
    folder: PathBuf,
    /// Replace what an earlier run left there
    #[arg(long)]
    force: bool,
    /// Print the files and numbers as JSON on stdout
    #[arg(long)]
    pub json: bool,
}

/// What the demo says.
#[derive(Debug, Serialize)]
struct Summary {
    /// What was written, in the order of the steps.
    files: Vec<PathBuf>,
    /// Verdict of the calibration.
    verdict: String,
    /// ‖a‖ − g over the positions as recorded, rms, m/s².
    norm_error_uncalibrated_mps2: f64,
    /// The same over positions left out of the fit, m/s².
    norm_error_left_out_mps2: Option<f64>,
    /// What the sensor really moved, m.
    true_displacement_m: [f64; 3],
    /// What was found, m.
    displacement_m: Option<[f64; 3]>,
    /// Its standard uncertainty, m.
    sigma_m: Option<[f64; 3]>,
    /// Distance of the end from the truth, m.
    end_error_m: Option<f64>,
    /// The same by the procedure of the classical report, m.
    end_error_report_m: Option<f64>,
}

/// Where everything goes.
struct Files {
    poses: PathBuf,
    line: PathBuf,
    calibration: PathBuf,
    calibration_report: PathBuf,
    track: PathBuf,
    motion_report: PathBuf,
}

impl Files {
    fn below(folder: &Path) -> Self {
        Files {
            poses: folder.join("poses"),
            line: folder.join("line"),
            calibration: folder.join("calibration.json"),
            calibration_report: folder.join("calibration.html"),
            track: folder.join("track.csv"),
            motion_report: folder.join("motion.html"),
        }
    }

    /// What a demo writes, in the order of its steps.
    fn made(&self) -> Vec<PathBuf> {
        let mut all = vec![self.poses.join("poses.csv"), self.poses.join("truth.json")];
        all.extend([self.line.join("line.csv"), self.line.join("truth.json")]);
        all.extend([&self.calibration, &self.calibration_report].map(PathBuf::clone));
        all.extend([&self.track, &self.motion_report].map(PathBuf::clone));
        all
    }

    /// Refuses before the first is written.
    fn check(&self, force: bool) -> Result<()> {
        for path in self.made() {
            check_target(&path, force).map_err(|e| {
                e.with_hint(
                    "name another folder, or add --force to replace what an earlier demo left",
                )
            })?;
        }
        Ok(())
    }
}

/// Records, inspects, calibrates, moves, reports.
///
/// # Errors
///
/// A folder that cannot be written, or that holds an earlier demo.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let files = Files::below(&args.folder);
    files.check(args.force)?;
    make_folder(&args.folder)?;
    let say = |line: &str| {
        if !args.json {
            text::say(line);
        }
    };

    say("A virtual MPU6050: what is true is known, so that every claim can be checked.\n");
    let poses = Scenario::Poses(PosesOptions {
        hold_s: HOLD_S,
        free: FREE,
    });
    let (_, poses) = record(poses, &files.poses, args.force)?;
    let (truth, line) = record(
        Scenario::Line(LineOptions::default()),
        &files.line,
        args.force,
    )?;
    say(&format!(
        "1 recorded    {}\n              {}",
        poses.name, line.name
    ));

    let seen = inspect(&poses, &AxisMap::default());
    let mut odd: Vec<&str> = seen
        .findings
        .iter()
        .filter(|f| f.severity == Severity::Warning)
        .map(|f| f.kind.name())
        .collect();
    odd.dedup();
    say(&format!(
        "2 inspected   {} rows, {} rests; odd: {}",
        seen.account.rows,
        seen.stills.len(),
        if odd.is_empty() {
            "nothing".to_owned()
        } else {
            odd.join(", ")
        }
    ));

    let (file, saved) = calibrated(&poses, &files, args.force)?;
    say(&format!("3 calibrated  {}", files.calibration.display()));
    let calibration = Calibrated {
        file: &file,
        name: &saved.path,
    };
    let moved = moved(&line, calibration, &saved, &files, args.force)?;
    say(&format!("4 moved       {}", files.track.display()));

    let classical = motion(&line, Some(calibration), &MotionOptions::report())?;
    let summary = summary(&files, &truth, &file, &moved, &classical);
    if args.json {
        text::print_json(&summary)?;
    } else {
        text::print_report(&told(&summary, &files))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A recording that is simulated, written, and read back like any other.
fn record(scenario: Scenario, folder: &Path, force: bool) -> Result<(Simulation, Recording)> {
    let options = SimulateOptions {
        seed: SEED,
        ..SimulateOptions::new(scenario)
    };
    let simulation = simulate(&options)?;
    let written = write(&simulation, folder, force)?;
    let path = written.first().map_or(folder, PathBuf::as_path);
    let recording = read(
        path,
        &ReadOptions {
            hash: true,
            ..ReadOptions::default()
        },
    )?;
    Ok((simulation, recording))
}

/// The calibration, its file and its report.
fn calibrated(
    poses: &Recording,
    files: &Files,
    force: bool,
) -> Result<(CalibrationFile, InputFile)> {
    let recordings = std::slice::from_ref(poses);
    let options = CalibrateOptions {
        gravity: Gravity::given(
            SimulateOptions::new(Scenario::Poses(PosesOptions::default())).gravity_mps2,
        )?,
        command: Some(COMMAND.to_owned()),
        ..CalibrateOptions::default()
    };
    let done = calibrate(recordings, &options)?;
    let saved = super::calibrate::save(&files.calibration, force, &done.file)?;
    let session = Session {
        recordings,
        segmentation: &done.segmentation,
    };
    let figures = figure::calibration::figures(&done.file, Some(session));
    let document = report::calibration(&done.file, &figures);
    write_report(&files.calibration_report, force, &document)?;
    Ok((done.file, saved))
}

/// The way, its table and its report.
fn moved(
    line: &Recording,
    calibration: Calibrated<'_>,
    saved: &InputFile,
    files: &Files,
    force: bool,
) -> Result<Motion> {
    let options = MotionOptions {
        keep_uncalibrated: true,
        ..MotionOptions::default()
    };
    let moved = motion(line, Some(calibration), &options)?;
    super::motion::save(&files.track, force, &moved)?;
    let figures = figure::motion::figures(&moved);
    let mut inputs = InputFile::of(std::slice::from_ref(line));
    inputs.push(saved.clone());
    let document = report::motion(&moved.result, line, &figures).with_provenance(&Provenance {
        tool: TOOL,
        command: Some(COMMAND),
        created: &creation_time(),
        inputs: &inputs,
    });
    write_report(&files.motion_report, force, &document)?;
    Ok(moved)
}

fn summary(
    files: &Files,
    simulation: &Simulation,
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
    let raw = a.positions.iter().map(|p| norm(&p.raw) - g).collect();
    let truth = simulation
        .truth
        .files
        .first()
        .and_then(|f| f.moves.first())
        .map(|m| m.displacement_m)
        .unwrap_or_default();
    let error = |end: Option<[f64; 3]>| {
        let end = end?;
        Some(norm(&std::array::from_fn(|k| end[k] - truth[k])))
    };
    let only = moved.result.moves.first();
    Summary {
        files: files.made(),
        verdict: file.verdict.grade.name().to_owned(),
        norm_error_uncalibrated_mps2: rms(raw),
        norm_error_left_out_mps2: a.leave_one_out_rms_mps2,
        true_displacement_m: truth,
        displacement_m: only.and_then(|m| m.displacement_m),
        sigma_m: only.and_then(|m| m.sigma_m),
        end_error_m: error(moved.result.r#final.position_m),
        end_error_report_m: error(classical.result.r#final.position_m),
    }
}

/// The three numbers that matter, and where to look.
fn told(s: &Summary, files: &Files) -> String {
    let mg = |v: f64| format!("{:.1} mg", 1000.0 * v / STANDARD_GRAVITY_MPS2);
    let mm = |v: Option<f64>| v.map_or("–".to_owned(), |v| format!("{:.0} mm", 1000.0 * v));
    let along = |v: Option<[f64; 3]>| v.map_or(f64::NAN, |v| v[1]);
    let mut out = String::from("\nThe three numbers that matter\n");
    let mut row = |text: String| out.push_str(&paragraph("  - ", &text));
    row(format!(
        "gravity at rest, in positions left out of the fit: off by {}; uncalibrated {}",
        s.norm_error_left_out_mps2.map_or("–".to_owned(), mg),
        mg(s.norm_error_uncalibrated_mps2)
    ));
    row(format!(
        "the way along y: {:.4} ± {:.4} m (1σ); in truth {:.4} m",
        along(s.displacement_m),
        along(s.sigma_m),
        s.true_displacement_m[1]
    ));
    row(format!(
        "distance from the true end: {}; by the classical report's procedure, with the same calibration: {}",
        mm(s.end_error_m),
        mm(s.end_error_report_m)
    ));
    out.push_str(&format!(
        "\nVerdict: {}\n\nReports, for any browser\n  {}\n  {}\n",
        s.verdict,
        files.calibration_report.display(),
        files.motion_report.display()
    ));
    out + NEXT
}
