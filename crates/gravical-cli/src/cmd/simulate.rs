//! `gravical simulate`: recordings of a simulated sensor with known true errors.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::escape::{path_text, path_word};
use gravical::simulate::{
    LineOptions, PosesOptions, Scenario, SimulateOptions, SixPositionOptions, StaticOptions, Truth,
    simulate_to,
};

use crate::text;

/// Simulate recordings of an MPU6050 with known true errors
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: gravical simulate poses -o sim --seed 3 --free 8")]
pub struct Args {
    #[command(subcommand)]
    scenario: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Six face poses, one file each, or one continuous session with turns
    SixPosition(With<SixPositionOptions>),
    /// Six face poses and free poses in one recording: poses.csv
    Poses(With<PosesOptions>),
    /// At rest with z up: static.csv
    Static(With<StaticOptions>),
    /// Rest, one smooth straight move, rest: line.csv
    Line(With<LineOptions>),
}

/// Options of a scenario, and of all.
#[derive(Debug, clap::Args)]
struct With<O: clap::Args> {
    /// Folder to write to, created if missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    own: O,
    #[command(flatten)]
    shared: Box<Shared>,
}

#[derive(Debug, clap::Args)]
struct Shared {
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
    /// Print the truth as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: SimulateOptions,
}

impl Args {
    /// The scenario, the folder, and the options of all scenarios.
    fn parts(&self) -> (Scenario, &Path, &Shared) {
        match &self.scenario {
            Command::SixPosition(c) => (Scenario::SixPosition(c.own), &c.output, &c.shared),
            Command::Poses(c) => (Scenario::Poses(c.own), &c.output, &c.shared),
            Command::Static(c) => (Scenario::Static(c.own), &c.output, &c.shared),
            Command::Line(c) => (Scenario::Line(c.own), &c.output, &c.shared),
        }
    }
}

/// Runs the command.
///
/// # Errors
///
/// An option out of range, an existing file, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let (scenario, output, shared) = args.parts();
    let options = SimulateOptions {
        scenario,
        ..shared.options.clone()
    };
    let (truth, written) = simulate_to(&options, output, shared.force)?;
    if shared.json {
        text::print_json(&truth)?;
    }
    if !shared.quiet {
        // The last path is the truth, which has no rows.
        for (path, truth) in written.iter().zip(&truth.files) {
            text::say(&format!(
                "wrote {} ({} rows{})",
                path_text(path),
                truth.rows,
                clipped(truth.clipped_rows)
            ));
        }
        if let Some(path) = written.last() {
            text::say(&format!(
                "wrote {} (true errors and motion)",
                path_text(path)
            ));
        }
        let next = next(&truth, &options.scenario, output);
        text::say(&format!("next: {next}"));
    }
    Ok(ExitCode::SUCCESS)
}

fn clipped(rows: usize) -> String {
    match rows {
        0 => String::new(),
        n => format!(", {n} of them clipped"),
    }
}

/// The command that makes most of what was written.
fn next(truth: &Truth, scenario: &Scenario, output: &Path) -> String {
    let dir = path_word(output);
    let file = truth.files.first().map_or("", |f| f.name.as_str());
    let file = path_word(&output.join(file));
    let gravity = truth.gravity_mps2;
    match scenario {
        Scenario::SixPosition(o) if !o.continuous => {
            format!("gravical calibrate {dir} --gravity {gravity}")
        }
        Scenario::SixPosition(_) | Scenario::Poses(_) => {
            format!("gravical calibrate {file} --gravity {gravity}")
        }
        Scenario::Static(o) if o.duration_s >= 600.0 => format!("gravical noise {file}"),
        Scenario::Static(_) | Scenario::Line(_) => format!("gravical inspect {file}"),
    }
}
