//! `--figures`: what the verbs that draw share.

use std::path::{Path, PathBuf};

use gravical::figure::{Figure, Formats, check_figures, write_figures};
use gravical::output::path_text;
use gravical::{Error, Result};

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
        Formats {
            csv: true,
            png: self.png,
        }
    }

    /// The folder, if figures can be written to it; before the work.
    ///
    /// # Errors
    ///
    /// Those of [`check_figures`].
    pub fn check(&self, force: bool) -> Result<Option<&Path>> {
        let folder = self.figures.as_deref();
        if let Some(folder) = folder {
            check_figures(folder, self.formats(), force)?;
        }
        Ok(folder)
    }

    /// Writes the figures where that was asked for, and says so on stderr.
    ///
    /// # Errors
    ///
    /// Those of [`write_figures`].
    pub fn write(&self, figures: &[Figure], force: bool, quiet: bool) -> Result<()> {
        let Some(folder) = &self.figures else {
            return Ok(());
        };
        let files = write_figures(figures, folder, self.formats(), force)?;
        if !quiet {
            let place = path_text(folder);
            let names: Vec<&str> = figures.iter().map(|f| f.name.as_str()).collect();
            text::say(&format!("{files} files in {place}: {}", names.join(", ")));
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
