//! A calibration that is named, or found in a folder.

use std::path::{Path, PathBuf};

use gravical::calibration_file::{Calibration, InputFile};
use gravical::calibration_folder::{find_calibration, json_files};
use gravical::escape::one_line;
use gravical::recording::{ReadOptions, Recording, read_head};
use gravical::session::{files_in, is_something_else};
use gravical::{Category, Error, Result};

use crate::text;

/// The sensor, for a folder of calibrations.
#[derive(Debug, Default, clap::Args)]
pub struct OriginArgs {
    /// In a folder: the sensor [default: as recorded]
    #[arg(long, hide_short_help = true, value_name = "TEXT")]
    sensor_id: Option<String>,
}

impl OriginArgs {
    /// Refuses a folder, and the option that chooses in one, where one calibration is for all.
    ///
    /// # Errors
    ///
    /// `origin-unused` (usage).
    pub fn refuse(&self, path: &Path) -> Result<()> {
        let (what, hint) = if path.is_dir() {
            (
                "a folder of calibrations has one for each recording, and many recordings are read here",
                "name the file of one calibration, or run the command for one recording",
            )
        } else if self.sensor_id.is_some() {
            (
                "--sensor-id chooses among the calibrations of a folder, and this is a file",
                "leave it out, or name a folder",
            )
        } else {
            return Ok(());
        };
        let error = Error::usage("origin-unused", what);
        Err(error.at(path, None).with_hint(hint))
    }

    /// The calibration at `path` and its file, as results list it; of a folder, that for `inputs`,
    /// which is said unless `quiet`.
    ///
    /// # Errors
    ///
    /// `origin-unused` and `folder-stdin` (usage); those of [`find_calibration`] and of reading.
    pub fn read(
        &self,
        path: &Path,
        inputs: &[PathBuf],
        options: &ReadOptions,
        quiet: bool,
    ) -> Result<(Calibration, InputFile)> {
        if !path.is_dir() {
            self.refuse(path)?;
            let is_calibration = |path: &PathBuf| path.is_file() && Calibration::read(path).is_ok();
            return Calibration::read_with_input(path).map_err(|error| {
                match error.category() {
                    Category::Input if inputs.first().is_some_and(is_calibration) => {
                        error.with_hint("the recording is a calibration: the calibration comes first, or behind -c in `motion`")
                    }
                    _ => error,
                }
            });
        }
        let heads = heads(inputs, options)?;
        let (file, input, reason) = find_calibration(path, &heads, self.sensor_id.as_deref())?;
        if !quiet {
            text::say(&format!("Calibration: {}, {reason}", one_line(&input.path)));
        }
        Ok((file, input))
    }
}

/// What is read to find the calibration at `path`: the file, or the folder and the JSON files in it.
pub fn files_of(path: &Path) -> Vec<PathBuf> {
    let in_folder = json_files(path).unwrap_or_default();
    std::iter::once(path.to_owned()).chain(in_folder).collect()
}

/// The first rows of the recordings: files, or one folder.
fn heads(inputs: &[PathBuf], options: &ReadOptions) -> Result<Vec<Recording>> {
    let is_folder = inputs.len() == 1 && inputs[0].is_dir();
    let paths = if is_folder {
        files_in(&inputs[0])?
    } else {
        inputs.to_vec()
    };
    if paths.iter().any(|path| path == Path::new("-")) {
        let what = "the beginning of the recording decides which calibration of the folder is taken, and standard input can be read once";
        let hint = "give the recording as a file, or name the file of the calibration";
        return Err(Error::usage("folder-stdin", what).with_hint(hint));
    }
    let heads = paths.iter().map(|path| read_head(path, options));
    let is_other = |error: &Error| is_folder && is_something_else(error);
    heads
        .filter(|head| !head.as_ref().is_err_and(is_other))
        .collect()
}
