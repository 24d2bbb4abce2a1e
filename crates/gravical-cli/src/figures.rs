//! `--figures`: what the verbs that draw share.

use std::path::PathBuf;

use gravical::figure::{Figure, Formats, Run, check_figures, figure_files, write_figures};
use gravical::output::path_text;
use gravical::{Error, Result};

use crate::options::command_line;
use crate::text;

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Figures")]
pub struct FigureArgs {
    /// Write every figure to this folder, as SVG and its numbers as CSV
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// Write the figures as PNG, too
    #[arg(long, requires = "figures")]
    png: bool,
}

impl FigureArgs {
    fn formats(&self) -> Formats {
        Formats { png: self.png }
    }

    /// Whether figures of these names can be written; before the work.
    ///
    /// # Errors
    ///
    /// Those of [`check_figures`].
    pub fn check(&self, names: &[&str], force: bool) -> Result<()> {
        match &self.figures {
            Some(folder) => check_figures(folder, names, self.formats(), force),
            None => Ok(()),
        }
    }

    /// The files that figures of these names may be written to.
    pub fn files(&self, names: &[&str]) -> Vec<PathBuf> {
        let folder = self.figures.as_deref();
        folder.map_or_else(Vec::new, |f| figure_files(f, names, self.formats()))
    }

    /// Writes the figures of `verb` where that was asked for, and says so on stderr:
    /// what was written, and what of an earlier run is gone or stays.
    ///
    /// # Errors
    ///
    /// Those of [`write_figures`].
    pub fn write(
        &self,
        verb: &str,
        figures: impl FnOnce() -> Vec<Figure>,
        force: bool,
        quiet: bool,
    ) -> Result<()> {
        let Some(folder) = &self.figures else {
            return Ok(());
        };
        let figures = figures();
        let command = command_line();
        let run = Run {
            verb,
            command: Some(&command),
        };
        let done = write_figures(&figures, folder, run, self.formats(), force)?;
        if quiet {
            return Ok(());
        }
        let place = path_text(folder);
        let names: Vec<&str> = figures.iter().map(|f| f.name.as_str()).collect();
        text::say(&format!(
            "{} files in {place}: {}",
            done.files.len(),
            names.join(", ")
        ));
        if !done.removed.is_empty() {
            text::say(&format!(
                "removed from {place}, of an earlier run and not drawn by this one: {}",
                file_names(&done.removed)
            ));
        }
        if !done.kept.is_empty() {
            text::say(&format!(
                "left in {place}, of an earlier run {}: {}",
                if force {
                    "but changed since"
                } else {
                    "(--force takes them away)"
                },
                file_names(&done.kept)
            ));
        }
        Ok(())
    }

    /// `--figures` beside something that does not keep the samples.
    pub fn refused(&self) -> Option<Error> {
        self.figures.as_ref().map(|_| {
            Error::usage("not-causal", "--causal: --figures shows a whole track")
                .with_hint("leave --causal out: the whole recording is read then")
        })
    }
}

fn file_names(files: &[PathBuf]) -> String {
    let names = files.iter().filter_map(|f| f.file_name());
    let names: Vec<_> = names.map(|n| n.to_string_lossy()).collect();
    names.join(", ")
}
