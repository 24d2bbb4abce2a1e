//! `gravical simulate`: recordings of a simulated sensor with known true errors.

mod args;

use std::path::Path;
use std::process::ExitCode;

use gravical::escape::{path_text, path_word};
use gravical::simulate::{Scenario, Truth, simulate_to};

use crate::text;
pub use args::Args;

/// Runs the command.
///
/// # Errors
///
/// An option out of range, an existing file, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let (options, output, shared) = args.options();
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
