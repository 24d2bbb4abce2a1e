//! `gravical man`: manual pages.

use std::path::PathBuf;
use std::process::ExitCode;

use clap_mangen::Man;
use gravical::Error;
use gravical::output::{check_target, make_folder, write_atomic};

use crate::text;

/// Write the manual pages
#[derive(clap::Args)]
#[command(after_help = "Example: gravical man -o ~/.local/share/man/man1")]
pub struct Args {
    /// Folder for gravical.1 and one page per command [default: main page on stdout]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Overwrite existing pages
    #[arg(long)]
    force: bool,
}

/// Runs the command.
pub fn run(args: &Args, mut program: clap::Command) -> anyhow::Result<ExitCode> {
    program.build();
    let Some(folder) = &args.output else {
        let mut page = Vec::new();
        Man::new(program).render(&mut page)?;
        text::print(&String::from_utf8_lossy(&page))?;
        return Ok(ExitCode::SUCCESS);
    };
    make_folder(folder)?;
    let mut pages = vec![("gravical.1".to_owned(), program.clone())];
    collect("gravical", &program, &mut pages);
    for (name, _) in &pages {
        check_target(&folder.join(name), args.force)?;
    }
    for (name, command) in pages {
        let path = folder.join(name);
        let mut page = Vec::new();
        Man::new(command).render(&mut page)?;
        write_atomic(&path, args.force, |w| {
            w.write_all(&page).map_err(|e| Error::io(&path, e))
        })?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A page for each command and its subcommands.
fn collect(name: &str, command: &clap::Command, pages: &mut Vec<(String, clap::Command)>) {
    for verb in command.get_subcommands().filter(|v| v.get_name() != "help") {
        let name = format!("{name}-{}", verb.get_name());
        pages.push((format!("{name}.1"), verb.clone()));
        collect(&name, verb, pages);
    }
}
