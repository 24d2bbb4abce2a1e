//! Where a table goes that is made of another one: what the verbs that write one
//! share.

use std::io::Write;
use std::path::{Path, PathBuf};

use gravical::output::{check_targets, path_text, write_atomic};
use gravical::{Error, Result};

use crate::text;

#[derive(Debug, clap::Args)]
pub struct TableArgs {
    /// File to write [default: stdout]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace the file of -o when it is there
    #[arg(long)]
    force: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Print the summary as one JSON object on stdout (needs -o)
    #[arg(long)]
    pub json: bool,
}

impl TableArgs {
    fn target(&self) -> Option<&Path> {
        file(self.output.as_deref())
    }

    /// Looks at where the table goes, before the work. `inputs` are what is read.
    ///
    /// # Errors
    ///
    /// `json-needs-output` (usage) where two things would go to stdout; those of
    /// [`check_targets`].
    pub fn check(&self, inputs: &[&Path]) -> Result<()> {
        let Some(path) = self.target() else {
            return match self.json {
                false => Ok(()),
                true => Err(Error::usage(
                    "json-needs-output",
                    "--json prints the summary on stdout, where the recording goes",
                )
                .with_hint("write the recording to a file with -o")),
            };
        };
        let inputs: Vec<PathBuf> = inputs.iter().map(|p| p.to_path_buf()).collect();
        check_targets(&[path.to_owned()], &inputs, self.force)
    }

    /// Has the table written, to its file in one step or to stdout.
    ///
    /// # Errors
    ///
    /// Those of `fill` and [`write_atomic`].
    pub fn write<T>(&self, fill: impl FnOnce(&mut dyn Write) -> Result<T>) -> anyhow::Result<T> {
        match self.target() {
            None => Ok(fill(&mut *text::table_out())?),
            Some(path) => write_file(path, self.force, fill),
        }
    }

    /// Where it went, for people.
    pub fn place(&self) -> String {
        self.target().map_or_else(|| "stdout".to_owned(), path_text)
    }
}

/// The file that is named; none for standard output.
pub fn file(output: Option<&Path>) -> Option<&Path> {
    output.filter(|path| *path != Path::new("-"))
}

/// [`write_atomic`] with what `fill` returns.
///
/// # Errors
///
/// Those of `fill` and [`write_atomic`].
pub fn write_file<T>(
    path: &Path,
    force: bool,
    fill: impl FnOnce(&mut dyn Write) -> Result<T>,
) -> anyhow::Result<T> {
    let mut done = None;
    write_atomic(path, force, |out| {
        done = Some(fill(out)?);
        Ok(())
    })?;
    done.ok_or_else(|| anyhow::anyhow!("nothing was written"))
}
