//! Where a table goes that is made of another one: what the verbs that write one
//! share.

use std::io::{self, IsTerminal as _, Write};
use std::path::{Path, PathBuf};

use gravical::document::{Detail, Document};
use gravical::output::{path_text, write_atomic};
use gravical::{Error, Result};

use crate::report::ReportArgs;
use crate::text;

#[derive(Debug, clap::Args)]
pub struct TableArgs {
    /// File to write; - is stdout [default: stdout, unless that is a terminal]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace files that are there
    #[arg(long)]
    pub force: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Print the summary as one JSON object on stdout (needs -o)
    #[arg(long)]
    pub json: bool,
}

impl TableArgs {
    fn target(&self) -> Target<'_> {
        Target::of(self.output.as_deref())
    }

    /// Looks at where the table goes, before the work. `inputs` are what is read.
    ///
    /// # Errors
    ///
    /// `json-needs-output` (usage) where two things would go to stdout; those of
    /// [`ReportArgs::check`].
    pub fn check(&self, report: &ReportArgs, inputs: &[&Path]) -> Result<()> {
        if self.target() == Target::Stdout && self.json {
            return Err(Error::usage(
                "json-needs-output",
                "--json prints the summary on stdout, where the recording goes",
            )
            .with_hint("write the recording to a file with -o"));
        }
        report.check(self.target().file(), inputs, self.force)
    }

    /// Has the table written, to its file in one step or to stdout.
    ///
    /// # Errors
    ///
    /// Those of `fill` and [`write_atomic`].
    pub fn write<T>(&self, fill: impl FnOnce(&mut dyn Write) -> Result<T>) -> anyhow::Result<T> {
        match self.target() {
            Target::Stdout => Ok(fill(&mut *text::table_out())?),
            Target::Nowhere => Ok(fill(&mut io::sink())?),
            Target::File(path) => write_file(path, self.force, fill),
        }
    }

    /// Tells people what was done, where the table went, and what there is to say of it.
    pub fn tell(&self, done: &str, document: &Document<'_>) {
        let target = self.target();
        text::say(&format!("{done}{}", target.arrow()));
        text::say_report(document.to_text(Detail::Summary).trim_end());
        if target == Target::Nowhere {
            text::say(target.hint().trim_end());
        }
    }
}

/// Where a table goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target<'a> {
    /// The file of `-o`.
    File(&'a Path),
    /// Standard output: a pipe or a file, or asked for with `-o -`.
    Stdout,
    /// Nobody asked for a table, and a terminal is no place for thousands of rows.
    Nowhere,
}

impl<'a> Target<'a> {
    /// By what `-o` says, and by what standard output is.
    pub fn of(output: Option<&'a Path>) -> Self {
        match output {
            Some(path) if path == Path::new("-") => Target::Stdout,
            Some(path) => Target::File(path),
            None if io::stdout().is_terminal() => Target::Nowhere,
            None => Target::Stdout,
        }
    }

    /// The file of `-o`.
    pub fn file(self) -> Option<&'a Path> {
        match self {
            Target::File(path) => Some(path),
            Target::Stdout | Target::Nowhere => None,
        }
    }

    /// ` → place`, for people.
    pub fn arrow(self) -> String {
        match self {
            Target::File(path) => format!(" → {}", path_text(path)),
            Target::Stdout => " → stdout".to_owned(),
            Target::Nowhere => String::new(),
        }
    }

    /// What to add to see a table that went nowhere.
    pub fn hint(self) -> &'static str {
        match self {
            Target::Nowhere => {
                "No table was written: -o FILE writes it to a file, -o - prints it here.\n"
            }
            Target::File(_) | Target::Stdout => "",
        }
    }
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
