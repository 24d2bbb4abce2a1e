//! `gravical collect`: what all runs over many recordings say together.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use gravical::cohort::{Cohort, Gathered};
use gravical::escape::path_text;
use gravical_report::figure::cohort::figures;
use gravical_report::report;

use crate::each::write_table;
use crate::failure::QUALITY;
use crate::figures::FigureArgs;
use crate::report::{ReportArgs, check_outputs, with_origin};
use crate::text;

/// Collect the results of runs over many recordings: one table, one report
///
/// Reads the journals of all runs with --each that wrote into a folder, on one machine or on many: what
/// is done, what failed and why, what is missing; the distribution of the parameters, the worst
/// recordings, the sensors that changed.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example: gravical collect calibrations -o cohort.csv --report cohort.html

Exit codes: 0 all have a result, 3 no journal, 4 a recording has no result or one that failed its
quality gate.")]
pub struct Args {
    /// Folder that runs with --each wrote into
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Table to write, one row for each recording (.csv or .json)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Command whose results are collected, where a folder has those of several
    #[arg(long, value_name = "COMMAND")]
    command: Option<String>,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    figures: FigureArgs,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
///
/// # Errors
///
/// `no-journal`, `collect-command`, `journal-syntax`, existing files, I/O errors.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let output = args.output.as_deref();
    check_outputs(output, &args.report, Some(&args.figures), &[], args.force)?;
    let gathered = Gathered::read(&args.folder, args.command.as_deref())?;
    let cohort = match output {
        Some(path) => write_table(path, args.force, &gathered)?,
        None => gathered.summarise(|_| Ok(()))?,
    };
    let figures = figures(&cohort);
    let page = args.report.folder();
    let link = |result: &str| address(Path::new(result), page.as_deref());
    let document = with_origin(report::cohort(&cohort, &figures, &link), &[]);
    args.report.write(args.force, &document)?;
    args.figures.write(&figures, args.force, args.quiet)?;
    if args.json {
        text::print_json(&cohort)?;
    } else if !args.quiet {
        text::print_report(&document.to_text(args.report.detail()))?;
        args.report.say();
        if let Some(path) = output {
            text::say(&format!("Table: {}", path_text(path)));
        }
    }
    Ok(exit_code(&cohort))
}

fn exit_code(cohort: &Cohort) -> ExitCode {
    let c = cohort.counts;
    match c.missing + c.error + c.poor {
        0 => ExitCode::SUCCESS,
        _ => ExitCode::from(QUALITY),
    }
}

/// By which address a page in the folder `page` leads to a file: relative to it, if the file is below it.
fn address(file: &Path, page: Option<&Path>) -> String {
    let file = file.canonicalize().unwrap_or_else(|_| file.to_owned());
    let folder = page.and_then(|page| page.canonicalize().ok());
    let (start, path) = match folder.as_ref().and_then(|f| file.strip_prefix(f).ok()) {
        Some(below) => ("", below),
        None => ("file://", &*file),
    };
    // RFC 3986: what is no unreserved character is given by its bytes.
    let mut address = start.to_owned();
    for byte in path.to_string_lossy().replace('\\', "/").bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                address.push(char::from(byte));
            }
            _ => address.push_str(&format!("%{byte:02X}")),
        }
    }
    address
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_relative_where_they_can_be() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("unit 1#.json");
        std::fs::write(&file, "").unwrap();
        assert_eq!(address(&file, Some(folder.path())), "unit%201%23.json");
        let other = tempfile::tempdir().unwrap();
        let far = address(&file, Some(other.path()));
        assert!(
            far.starts_with("file:///") && far.ends_with("/unit%201%23.json"),
            "{far}"
        );
    }
}
