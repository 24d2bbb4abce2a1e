//! `--store`: calibrations filed in a store, and taken from it.

use std::path::{Path, PathBuf};

use gravical::calibration_file::{CalibrationFile, InputFile};
use gravical::escape::{path_text, path_word, shell_word};
use gravical::recording::{ReadOptions, Recording, read_head};
use gravical::session::{files_in, is_something_else};
use gravical::store::{Added, Choice, Query, QueryTimeSource, Store};
use gravical::utc::UtcTime;
use gravical::{Error, Result};
use gravical_report::document::Document;
use gravical_report::report;
use serde::Serialize;

use crate::options::read_calibration;

/// Where `calibrate` files its result.
#[derive(Debug, Default, clap::Args)]
pub struct StoreTarget {
    /// File the calibration in this store, under the sensor's id and the time of the session
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,
    /// When the session was recorded (UTC), stored in the calibration [default: by its time stamps]
    #[arg(long, hide_short_help = true, value_name = "DATE")]
    pub recorded: Option<UtcTime>,
}

impl StoreTarget {
    /// True if a store or the time of the session is given.
    pub fn is_given(&self) -> bool {
        self.store.is_some() || self.recorded.is_some()
    }

    /// Refuses a calibration that names no sensor, before anything is written.
    ///
    /// # Errors
    ///
    /// `sensor-id-missing` (usage).
    pub fn check(&self, file: &CalibrationFile) -> Result<()> {
        let named = file
            .sensor
            .id
            .as_deref()
            .is_some_and(|id| !id.trim().is_empty());
        match self.store {
            Some(_) if !named => Err(Error::usage(
                "sensor-id-missing",
                "--store keeps calibrations by sensor, and the recordings name none",
            )
            .with_hint("name it: --sensor-id NAME")),
            _ => Ok(()),
        }
    }

    /// Files the calibration if a store is given.
    ///
    /// # Errors
    ///
    /// Those of [`Store::create`] and [`Store::add`].
    pub fn add(&self, file: &CalibrationFile) -> Result<Option<Added>> {
        let Some(folder) = &self.store else {
            return Ok(None);
        };
        Store::create(folder)?.add(file).map(Some)
    }

    /// The command that uses what was filed.
    pub fn next(&self, file: &CalibrationFile) -> Option<String> {
        let folder = path_word(self.store.as_deref()?);
        let id = shell_word(file.sensor.id.as_deref()?);
        Some(format!(
            "gravical apply --store {folder} --sensor-id {id} RECORDING.csv -o calibrated.csv"
        ))
    }
}

/// What was filed, for stderr.
pub fn filed(added: &Added) -> String {
    let path = path_text(&added.path);
    match added.existed {
        true => {
            format!("In the store already, with the same parameters of the same recordings: {path}")
        }
        false => format!("Stored: {path}"),
    }
}

/// A calibration from a store in place of a file.
#[derive(Debug, Default, clap::Args)]
#[command(next_help_heading = "Calibration from a store")]
pub struct StoreArgs {
    /// Take the calibration of this store that fits the recording: of the same sensor, the last one
    /// before it, for its unit, range and temperature
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,
    #[command(flatten)]
    criteria: Criteria,
}

/// Which calibration of a store is taken.
#[derive(Debug, Default, clap::Args)]
pub struct Criteria {
    /// Sensor of the recording, with --store [default: the serial number in the recording]
    #[arg(long, hide_short_help = true, value_name = "TEXT", requires = "store")]
    sensor_id: Option<String>,
    /// When the recording was made (UTC), with --store [default: by its time stamps, else now]
    #[arg(long, hide_short_help = true, value_name = "DATE", requires = "store")]
    recorded: Option<UtcTime>,
    #[command(flatten)]
    pub limits: Limits,
}

/// Limits of a choice.
#[derive(Debug, Default, clap::Args)]
pub struct Limits {
    /// Take the nearest calibration, even one made after the recording
    #[arg(long, hide_short_help = true, requires = "store")]
    nearest: bool,
    /// Largest time between calibration and recording, days [default: any]
    #[arg(
        long,
        hide_short_help = true,
        value_name = "DAYS",
        requires = "store",
        allow_negative_numbers = true
    )]
    max_age: Option<f64>,
    /// How far the temperatures of the recording may be outside those of the calibration, °C
    /// [default: 10]
    #[arg(
        long,
        hide_short_help = true,
        value_name = "C",
        requires = "store",
        allow_negative_numbers = true
    )]
    max_temperature_difference: Option<f64>,
}

impl Limits {
    /// Sets the limits of a query.
    pub fn set(&self, query: &mut Query) {
        query.nearest = self.nearest;
        query.max_age_days = self.max_age;
        if let Some(most) = self.max_temperature_difference {
            query.max_temperature_difference_c = most;
        }
    }
}

/// A calibration, named or chosen.
pub struct Taken {
    pub file: CalibrationFile,
    pub input: InputFile,
    pub path: PathBuf,
    /// Why it was chosen; none if it was named.
    pub choice: Option<Choice>,
}

impl StoreArgs {
    /// True if the calibration comes from a store.
    pub fn is_given(&self) -> bool {
        self.store.is_some()
    }

    /// The calibration that was named, or the one of the store that fits `inputs`; none if neither
    /// is given. `swap`: the hint if calibration and recording are in each other's place.
    ///
    /// # Errors
    ///
    /// `store-and-file` and `store-stdin` (usage); those of [`read_calibration`], of reading the
    /// recordings, and of `Stored::choose`.
    pub fn take(
        &self,
        named: Option<&Path>,
        inputs: &[PathBuf],
        options: &ReadOptions,
        swap: &str,
    ) -> Result<Option<Taken>> {
        let folder = match (&self.store, named) {
            (None, None) => return Ok(None),
            (None, Some(path)) => {
                let recording = inputs.first().map(PathBuf::as_path);
                let (file, input) = read_calibration(path, recording, swap)?;
                let path = path.to_owned();
                return Ok(Some(Taken {
                    file,
                    input,
                    path,
                    choice: None,
                }));
            }
            (Some(_), Some(path)) => return Err(store_and_file(path)),
            (Some(folder), None) => folder,
        };
        let stored = Store::open(folder)?.read()?;
        let mut query = Query::of(&heads(inputs, options)?)?;
        if self.criteria.sensor_id.is_some() {
            query.sensor_id.clone_from(&self.criteria.sensor_id);
        }
        if let Some(time) = self.criteria.recorded {
            (query.time, query.time_source) = (time, QueryTimeSource::Given);
        }
        self.criteria.limits.set(&mut query);
        let (chosen, choice) = stored.choose(&query)?;
        Ok(Some(Taken {
            file: chosen.file.clone(),
            input: chosen.input.clone(),
            path: chosen.path.clone(),
            choice: Some(choice),
        }))
    }
}

fn store_and_file(path: &Path) -> Error {
    Error::usage(
        "store-and-file",
        "--store chooses the calibration: with one recording, this is a file too many",
    )
    .at(path, None)
    .with_hint("leave out --store, or this file; --store takes one session at a time")
}

/// The first rows of the recordings: files, or one folder.
fn heads(inputs: &[PathBuf], options: &ReadOptions) -> Result<Vec<Recording>> {
    let folder = inputs.len() == 1 && inputs[0].is_dir();
    let paths = match folder {
        true => files_in(&inputs[0])?,
        false => inputs.to_vec(),
    };
    let mut heads = Vec::new();
    for path in paths {
        if path == Path::new("-") {
            return Err(Error::usage(
                "store-stdin",
                "--store: the beginning of the recording decides which calibration is taken, and standard input can be read once",
            )
            .with_hint("give the recording as a file; `gravical store show ID --store DIR` names the file of the calibration"));
        }
        match read_head(&path, options) {
            // A calibration is first where a command takes one.
            Err(error) if error.code() == "is-a-calibration" && !folder => {
                return Err(store_and_file(&path));
            }
            Err(error) if folder && is_something_else(&error) => {}
            head => heads.push(head?),
        }
    }
    Ok(heads)
}

/// A result with the choice of its calibration, as JSON.
#[derive(Serialize)]
pub struct WithChoice<'a, T> {
    #[serde(flatten)]
    pub result: &'a T,
    /// Absent without --store.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub store: Option<&'a Choice>,
}

impl Taken {
    /// The result with the choice, for JSON.
    pub fn with<'a, T>(&'a self, result: &'a T) -> WithChoice<'a, T> {
        WithChoice {
            result,
            store: self.choice.as_ref(),
        }
    }

    /// The document with the choice behind its first section.
    pub fn add_to(&self, document: &mut Document<'_>) {
        if let Some(choice) = &self.choice {
            let at = document.sections.len().min(1);
            document.sections.insert(at, report::choice(choice));
        }
    }
}
