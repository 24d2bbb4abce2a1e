//! `--figures`, shared by the commands that draw.

use std::path::{Path, PathBuf};

use gravical::Result;
use gravical::escape::path_text;
use gravical::numfmt::count;
use gravical_report::figure::{Figure, check_figures, write_figures};

use crate::text;

#[derive(Debug, clap::Args)]
pub struct FigureArgs {
    /// Folder for each figure as SVG
    #[arg(long, hide_short_help = true, value_name = "DIR")]
    pub figures: Option<PathBuf>,
}

impl FigureArgs {
    /// The folder, after checking that figures can be written to it.
    ///
    /// # Errors
    ///
    /// Those of [`check_figures`].
    pub fn check(&self, force: bool) -> Result<Option<&Path>> {
        let folder = self.figures.as_deref();
        if let Some(folder) = folder {
            check_figures(folder, force)?;
        }
        Ok(folder)
    }

    /// Writes the figures if requested, and reports that on stderr.
    ///
    /// # Errors
    ///
    /// Those of [`write_figures`].
    pub fn write(&self, figures: &[Figure], force: bool, quiet: bool) -> Result<()> {
        let Some(folder) = &self.figures else {
            return Ok(());
        };
        write_figures(figures, folder, force)?;
        if !quiet {
            let place = path_text(folder);
            let names: Vec<&str> = figures.iter().map(|f| f.name.as_str()).collect();
            text::say(&format!(
                "{} in {place}: {}",
                count(names.len(), "figure"),
                names.join(", ")
            ));
        }
        Ok(())
    }
}
