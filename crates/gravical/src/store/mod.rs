//! A folder of calibrations, by sensor and time.
//!
//! # Overview
//!
//! A store is plain folders with plain files: `STORE/SENSOR/TIME-HASH.json`, each an ordinary
//! [calibration file](crate::calibration_file). Nothing else is in it: no index, no lock. A file
//! is written under a name of its own and never changed, so that several programs can add and
//! read at once. [`Store::add`] files a calibration, [`Stored::choose`] finds the one that fits a
//! recording and says why, [`Stored::history`] tests whether a sensor changed.
//!
//! Files of imucal are read, too: sensor and time are in their names,
//! `SENSOR/…/SENSOR_2026-03-09_10-15.json`. A calibration that names no sensor belongs to that of
//! its folder.
//!
//! # Example
//!
//! ```
//! use gravical::calibrate::{CalibrateOptions, Method, calibrate};
//! use gravical::recording::{ReadOptions, read_bytes};
//! use gravical::store::{Query, Store};
//!
//! let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
//!            -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
//! let recordings = [read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default())?];
//! let mut options = CalibrateOptions::default();
//! options.estimate.method = Method::Ferraris;
//! options.sensor.id = Some("left foot".to_owned());
//! options.recorded = Some("2026-03-09".parse()?);
//! let mut calibration = calibrate(&recordings, &options)?.file;
//!
//! let folder = tempfile::tempdir()?;
//! let store = Store::create(&folder.path().join("calibrations"))?;
//! let added = store.add(&calibration)?;
//! assert!(!added.existed && store.add(&calibration)?.existed);
//!
//! let mut query = Query::of(&recordings)?;
//! query.sensor_id = Some("left foot".to_owned());
//! let stored = store.read()?;
//! let (chosen, choice) = stored.choose(&query)?;
//! assert_eq!(chosen.path, added.path);
//! assert_eq!(choice.time.to_string(), "2026-03-09T00:00:00Z");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod choose;
mod name;
mod read;
mod types;

use std::path::{Path, PathBuf};

use crate::calibration_file::CalibrationFile;
use crate::hash::sha256;
use crate::output::make_folder;
use crate::{Error, Result};

use name::{file_ending, file_name, folder_name};
use read::is_json;
pub(crate) use read::time_of;

pub use choose::{Choice, Query, QueryTimeSource, Rejected};
pub use read::Stored;
pub use types::*;

/// A folder of calibrations.
#[derive(Debug, Clone)]
pub struct Store {
    folder: PathBuf,
}

impl Store {
    /// The store in an existing folder.
    ///
    /// # Errors
    ///
    /// `no-store` (input) if there is no such folder.
    pub fn open(folder: &Path) -> Result<Self> {
        if !folder.is_dir() {
            return Err(
                Error::input("no-store", "there is no store: no such folder")
                    .at(folder, None)
                    .with_hint(
                        "`gravical calibrate … --store DIR` makes it with the first calibration",
                    ),
            );
        }
        Ok(Store {
            folder: folder.to_owned(),
        })
    }

    /// The same; the folder is created if necessary.
    ///
    /// # Errors
    ///
    /// `no-folder` (usage) if it cannot be created.
    pub fn create(folder: &Path) -> Result<Self> {
        make_folder(folder)?;
        Self::open(folder)
    }

    /// Files a calibration under the id of its sensor and the time of its session, else that of its
    /// computation. What is there already, with the same parameters from the same recordings, is
    /// not written again.
    ///
    /// Several programs can do this at once: a file is complete when it appears, and replaces none.
    ///
    /// # Errors
    ///
    /// `sensor-id-missing` (usage) if the calibration names no sensor; `date-syntax` if it has no
    /// valid time; `not-saved` (input) if the file reads back differently; errors of the file system.
    pub fn add(&self, file: &CalibrationFile) -> Result<Added> {
        let id = file.sensor.id.as_deref().map(str::trim).unwrap_or("");
        if id.is_empty() {
            return Err(id_missing(
                "the calibration names no sensor, and a store is kept by sensor",
            ));
        }
        let (time, _) = time_of(file)?;
        let fingerprint = fingerprint(file)?;
        let folder = self.folder.join(folder_name(id));
        make_folder(&folder)?;
        if let Some(path) = find(&folder, &fingerprint)? {
            return Ok(Added {
                path,
                existed: true,
            });
        }
        let path = folder.join(file_name(time, &fingerprint));
        match file.write(&path, false) {
            Ok(()) => {}
            // Another program has just filed the same.
            Err(error) if error.code() == "exists" && is_same(&path, &fingerprint) => {
                return Ok(Added {
                    path,
                    existed: true,
                });
            }
            Err(error) => return Err(error),
        }
        if !is_same(&path, &fingerprint) {
            return Err(Error::input(
                "not-saved",
                "the file reads back differently from what was written",
            )
            .at(&path, None));
        }
        Ok(Added {
            path,
            existed: false,
        })
    }
}

/// No sensor is named.
fn id_missing(what: impl Into<String>) -> Error {
    Error::usage("sensor-id-missing", what).with_hint("name it: --sensor-id NAME")
}

/// A calibration with these contents in the folder of its sensor.
fn find(folder: &Path, fingerprint: &str) -> Result<Option<PathBuf>> {
    let ending = file_ending(fingerprint);
    let io = |e| Error::io(folder, e);
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        let named = is_json(&path) && path.to_string_lossy().ends_with(&ending);
        if named && is_same(&path, fingerprint) {
            return Ok(Some(path));
        }
    }
    Ok(None)
}

fn is_same(path: &Path, of: &str) -> bool {
    CalibrationFile::read(path).is_ok_and(|file| fingerprint(&file).is_ok_and(|own| own == of))
}

/// SHA-256 of what a calibration says and of what it was made from, but not of when, where and by
/// which command: the same session calibrated twice is the same calibration.
fn fingerprint(file: &CalibrationFile) -> Result<String> {
    let a = &file.accelerometer;
    let mut inputs: Vec<_> = file.inputs.iter().map(|i| &i.sha256).collect();
    inputs.sort();
    let content = (
        (&file.sensor, &file.recorded, file.gravity_mps2, inputs),
        (a.input_unit, a.matrix, a.bias, &a.covariance),
        (&file.gyroscope, &file.temperature_model, &file.noise),
    );
    let text = serde_json::to_string(&content)
        .map_err(|e| Error::input("calibration-syntax", e.to_string()))?;
    Ok(sha256(text.as_bytes()))
}

#[cfg(test)]
mod tests;
