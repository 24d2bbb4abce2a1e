//! The options of `--each`.

use std::path::PathBuf;

use gravical::cohort::Shard;
use gravical::{Error, Result};

#[derive(Debug, Default, clap::Args)]
#[command(next_help_heading = "Many sessions")]
pub struct EachArgs {
    /// Take each path as a session of its own; of a folder, each of its entries
    #[arg(long)]
    pub each: bool,
    /// Table to write, one row for each session (.csv or .json)
    #[arg(long, hide_short_help = true, value_name = "FILE")]
    pub summary: Option<PathBuf>,
    /// Continue an interrupted run: what is done with the same content and options is skipped
    #[arg(long, hide_short_help = true)]
    pub resume: bool,
    /// Part of the sessions for this run, of several with the same arguments: 1/8 to 8/8
    #[arg(long, hide_short_help = true, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// How often a session is tried again after an error of the file system
    #[arg(long, hide_short_help = true, value_name = "N", default_value_t = 0)]
    pub retries: u8,
    /// Number of sessions at a time [default: one for each core]
    #[arg(
        long,
        hide_short_help = true,
        value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..)
    )]
    pub threads: Option<u16>,
}

impl EachArgs {
    /// Refuses options of `--each` without it.
    ///
    /// # Errors
    ///
    /// `each-option` (usage).
    pub fn refuse_alone(&self) -> Result<()> {
        let given = [
            ("--summary", self.summary.is_some()),
            ("--resume", self.resume),
            ("--shard", self.shard.is_some()),
            ("--retries", self.retries > 0),
            ("--threads", self.threads.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(Error::usage(
                "each-option",
                format!("{option}: this belongs to a run over many sessions"),
            )
            .with_hint("add --each: then each path is a session of its own")),
            None => Ok(()),
        }
    }

    /// Refuses options that have no meaning for many sessions.
    ///
    /// # Errors
    ///
    /// `each-option` (usage).
    pub fn refuse_beside(options: &[(&str, bool)]) -> Result<()> {
        match options.iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(Error::usage(
                "each-option",
                format!("{option}: this belongs to one session, not to many"),
            )
            .with_hint("leave it out, or run the command for one session without --each")),
            None => Ok(()),
        }
    }

    /// How many items are worked on at a time.
    pub fn workers(&self) -> usize {
        self.threads.map_or_else(
            || std::thread::available_parallelism().map_or(1, usize::from),
            usize::from,
        )
    }
}
