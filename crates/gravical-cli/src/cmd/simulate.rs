//! `gravical simulate`: recordings of a simulated sensor with known true errors.

use std::path::PathBuf;
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
    SixPosition(Box<With<SixPositionOptions>>),
    /// Six face poses and free poses in one recording: poses.csv
    Poses(Box<With<PosesOptions>>),
    /// At rest with z up: static.csv
    Static(Box<With<StaticOptions>>),
    /// Rest, one smooth straight move, rest: line.csv
    Line(Box<With<LineOptions>>),
}

/// Options of a scenario, and of all.
#[derive(Debug, clap::Args)]
struct With<O: clap::Args> {
    /// Folder to write to, created if missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    own: O,
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

/// Runs the command.
///
/// # Errors
///
/// An option out of range, an existing file, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    match &args.scenario {
        Command::SixPosition(c) => c.run(Scenario::SixPosition(c.own)),
        Command::Poses(c) => c.run(Scenario::Poses(c.own)),
        Command::Static(c) => c.run(Scenario::Static(c.own)),
        Command::Line(c) => c.run(Scenario::Line(c.own)),
    }
}

impl<O: clap::Args> With<O> {
    fn run(&self, scenario: Scenario) -> anyhow::Result<ExitCode> {
        let options = SimulateOptions {
            scenario,
            ..self.options.clone()
        };
        let (truth, written) = simulate_to(&options, &self.output, self.force)?;
        if self.json {
            text::print_json(&truth)?;
        }
        if self.quiet {
            return Ok(ExitCode::SUCCESS);
        }
        for (i, path) in written.iter().enumerate() {
            let what = match truth.files.get(i) {
                Some(f) if f.clipped_rows == 0 => format!("{} rows", f.rows),
                Some(f) => format!("{} rows, {} of them clipped", f.rows, f.clipped_rows),
                // The last path is the truth.
                None => "true errors and motion".to_owned(),
            };
            text::say(&format!("wrote {} ({what})", path_text(path)));
        }
        text::say(&format!("next: {}", self.next(&truth, &scenario)));
        Ok(ExitCode::SUCCESS)
    }

    /// The command that makes most of what was written.
    fn next(&self, truth: &Truth, scenario: &Scenario) -> String {
        let name = truth.files.first().map_or("", |file| file.name.as_str());
        let file = path_word(&self.output.join(name));
        let gravity = truth.gravity_mps2;
        match scenario {
            Scenario::SixPosition(o) if !o.continuous => {
                let folder = path_word(&self.output);
                format!("gravical calibrate {folder} --gravity {gravity}")
            }
            Scenario::SixPosition(_) | Scenario::Poses(_) => {
                format!("gravical calibrate {file} --gravity {gravity}")
            }
            Scenario::Static(o) if o.duration_s >= 600.0 => format!("gravical noise {file}"),
            Scenario::Static(_) | Scenario::Line(_) => format!("gravical inspect {file}"),
        }
    }
}
