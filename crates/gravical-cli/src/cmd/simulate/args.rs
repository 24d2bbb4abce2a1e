//! Arguments of `gravical simulate`.

use std::path::{Path, PathBuf};

use gravical::simulate::{
    LineOptions, PosesOptions, Scenario, SimulateOptions, SixPositionOptions, StaticOptions,
};

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
pub struct Shared {
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Print the truth as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    options: SimulateOptions,
}

impl Args {
    fn parts(&self) -> (Scenario, &Path, &Shared) {
        match &self.scenario {
            Command::SixPosition(c) => (Scenario::SixPosition(c.own), &c.output, &c.shared),
            Command::Poses(c) => (Scenario::Poses(c.own), &c.output, &c.shared),
            Command::Static(c) => (Scenario::Static(c.own), &c.output, &c.shared),
            Command::Line(c) => (Scenario::Line(c.own), &c.output, &c.shared),
        }
    }

    /// Whether the truth and errors are printed as JSON.
    pub fn json(&self) -> bool {
        self.parts().2.json
    }

    /// Options of the library, the folder, and the options of the command itself.
    pub fn options(&self) -> (SimulateOptions, &Path, &Shared) {
        let (scenario, output, shared) = self.parts();
        let options = SimulateOptions {
            scenario,
            ..shared.options.clone()
        };
        (options, output, shared)
    }
}
