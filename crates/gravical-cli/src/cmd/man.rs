//! `gravical man`: the manual, as pages in a folder or the main one on stdout.

use std::path::PathBuf;
use std::process::ExitCode;

use clap_mangen::Man;
use gravical::Error;
use gravical::output::{check_target, write_atomic};

use crate::text;

#[derive(clap::Args)]
pub struct Args {
    /// Write gravical.1 and a page a verb into this folder [default: the main page on stdout]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Replace existing pages
    #[arg(long)]
    force: bool,
}

/// Runs the verb.
pub fn run(args: &Args, mut program: clap::Command) -> anyhow::Result<ExitCode> {
    program.build();
    let Some(folder) = &args.output else {
        let mut page = Vec::new();
        Man::new(program).render(&mut page)?;
        text::print(&String::from_utf8_lossy(&page))?;
        return Ok(ExitCode::SUCCESS);
    };
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
    let mut pages = vec![("gravical.1".to_owned(), program.clone())];
    for verb in program.get_subcommands().filter(|v| v.get_name() != "help") {
        pages.push((format!("gravical-{}.1", verb.get_name()), verb.clone()));
    }
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
