//! The calibrations of a store.

use std::path::{Path, PathBuf};

use crate::calibration_file::{CalibrationFile, GyroscopeSection, InputFile, InputRole};
use crate::compare::history;
use crate::{Error, Result};

use super::name::imucal_name;
use super::{
    HistoryCalibration, LeftOutFile, SensorHistory, Store, StoreList, StoredCalibration,
    StoredSensor, StoredTimeSource,
};
use crate::utc::UtcTime;

/// Folders in folders that are searched: imucal has two.
const DEPTH: usize = 4;
/// Ids that a message lists.
const LISTED: usize = 8;

/// The contents of a store.
#[derive(Debug, Clone)]
pub struct Stored {
    pub(super) folder: PathBuf,
    /// The calibrations, by sensor and time.
    pub calibrations: Vec<StoredCalibration>,
    /// JSON files that are no calibration of a sensor.
    pub left_out: Vec<LeftOutFile>,
}

impl Store {
    /// Reads all calibrations. A JSON file that is none, or has no sensor or time, is left out with
    /// the reason; files with other endings are not looked at.
    ///
    /// # Errors
    ///
    /// Errors of the file system about a folder.
    pub fn read(&self) -> Result<Stored> {
        let mut paths = Vec::new();
        files(&self.folder, DEPTH, &mut paths)?;
        paths.sort();
        let (mut calibrations, mut left_out) = (Vec::new(), Vec::new());
        for path in paths {
            match stored(&self.folder, &path) {
                Ok(calibration) => calibrations.push(calibration),
                Err(error) => left_out.push(LeftOutFile {
                    path: path.display().to_string(),
                    reason: error.message().to_owned(),
                }),
            }
        }
        calibrations.sort_by(|a, b| {
            let order = a.sensor_id.cmp(&b.sensor_id).then(a.time.cmp(&b.time));
            let created = || a.file.created.cmp(&b.file.created);
            order.then_with(created).then_with(|| a.path.cmp(&b.path))
        });
        Ok(Stored {
            folder: self.folder.clone(),
            calibrations,
            left_out,
        })
    }
}

/// All JSON files in `folder` and the folders in it; links to folders are not followed.
fn files(folder: &Path, depth: usize, paths: &mut Vec<PathBuf>) -> Result<()> {
    let io = |e| Error::io(folder, e);
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let entry = entry.map_err(io)?;
        let path = entry.path();
        if entry.file_type().map_err(io)?.is_dir() {
            if depth > 1 {
                files(&path, depth - 1, paths)?;
            }
        } else if is_json(&path) && path.is_file() {
            paths.push(path);
        }
    }
    Ok(())
}

pub(super) fn is_json(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

/// Reads one calibration.
fn stored(store: &Path, path: &Path) -> Result<StoredCalibration> {
    let (file, input) = InputFile::read(path, InputRole::Calibration, CalibrationFile::parse)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    // Folders from the store to the file.
    let within = path.parent().and_then(|p| p.strip_prefix(store).ok());
    let folders: Vec<_> = within
        .iter()
        .flat_map(|p| p.iter())
        .map(|f| f.to_string_lossy().into_owned())
        .collect();
    // One that was filed here knows its sensor and time.
    if file.tool == "imucal" && file.recorded.is_none() {
        let (id, time) = imucal_name(&name).ok_or_else(|| {
            Error::input(
                "calibration-format",
                "a file of imucal, whose name does not give sensor and time: SENSOR_2026-03-09_10-15.json",
            )
        })?;
        // imucal writes ids in lower case in the name of the file, and as they are in that of the
        // folder.
        let folder = folders.iter().find(|f| f.eq_ignore_ascii_case(id));
        return Ok(StoredCalibration {
            path: path.to_owned(),
            sensor_id: folder.map_or(id, String::as_str).to_owned(),
            time,
            time_source: StoredTimeSource::FileName,
            file,
            input,
        });
    }
    let own = file.sensor.id.as_deref().map(str::trim);
    let own = own.filter(|id| !id.is_empty()).map(str::to_owned);
    let sensor_id = own.or_else(|| folders.first().cloned()).ok_or_else(|| {
        Error::input(
            "calibration-format",
            "it names no sensor and is in no folder of one",
        )
    })?;
    let (time, time_source) = time_of(&file)?;
    Ok(StoredCalibration {
        path: path.to_owned(),
        sensor_id,
        time,
        time_source,
        file,
        input,
    })
}

/// When a sensor was calibrated.
///
/// # Errors
///
/// `date-syntax` if the file gives no valid time.
pub(crate) fn time_of(file: &CalibrationFile) -> Result<(UtcTime, StoredTimeSource)> {
    match file.recorded {
        Some(recorded) => Ok((recorded.time, StoredTimeSource::Recording)),
        None => Ok((file.created.parse()?, StoredTimeSource::Calibration)),
    }
}

impl Stored {
    /// The sensors.
    #[must_use]
    pub fn list(&self) -> StoreList {
        let sensors = self
            .calibrations
            .chunk_by(|a, b| a.sensor_id == b.sensor_id);
        let sensor = |own: &[StoredCalibration]| {
            let (first, last) = own.first().zip(own.last())?;
            Some(StoredSensor {
                sensor_id: first.sensor_id.clone(),
                calibrations: own.len(),
                first: first.time,
                last: last.time,
                last_grade: last.file.verdict.grade,
                last_predicted_norm_error_mps2: last.file.accelerometer.predicted_norm_error_mps2,
            })
        };
        StoreList {
            store: self.folder.display().to_string(),
            sensors: sensors.filter_map(sensor).collect(),
            left_out: self.left_out.clone(),
        }
    }

    /// The calibrations of a sensor, in order of time.
    ///
    /// # Errors
    ///
    /// `no-such-sensor` (input), with the ids that there are.
    pub fn of(&self, sensor_id: &str) -> Result<&[StoredCalibration]> {
        let all = self
            .calibrations
            .chunk_by(|a, b| a.sensor_id == b.sensor_id);
        let mut all = all.filter(|own| own.first().is_some_and(|c| c.sensor_id == sensor_id));
        all.next().ok_or_else(|| {
            Error::input(
                "no-such-sensor",
                format!(
                    "the store has no calibration of sensor \"{sensor_id}\"; {}",
                    self.ids(sensor_id)
                ),
            )
            .at(&self.folder, None)
            .with_hint("give one of its ids: --sensor-id ID; `gravical calibrate … --sensor-id ID --store DIR` files a calibration")
        })
    }

    /// The ids in words, those first that differ from `like` by the case alone.
    pub(super) fn ids(&self, like: &str) -> String {
        let mut ids: Vec<&str> = self.calibrations.iter().map(|c| &*c.sensor_id).collect();
        ids.dedup();
        ids.sort_by_key(|id| !id.eq_ignore_ascii_case(like));
        let left_out = match self.left_out.len() {
            0 => String::new(),
            n => format!(" ({n} JSON files in it are no calibration of a sensor)"),
        };
        if ids.is_empty() {
            return format!("it has no calibration at all{left_out}");
        }
        let more = match ids.len().saturating_sub(LISTED) {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        ids.truncate(LISTED);
        let named: Vec<String> = ids.iter().map(|id| format!("\"{id}\"")).collect();
        format!("it has {}{more}{left_out}", named.join(", "))
    }

    /// The calibrations of a sensor, and whether it changed.
    ///
    /// # Errors
    ///
    /// As [`of`](Self::of).
    pub fn history(&self, sensor_id: &str) -> Result<SensorHistory> {
        let own = self.of(sensor_id)?;
        // Dates are enough unless two are alike.
        let one_a_day = own.windows(2).all(|w| w[0].time.date() != w[1].time.date());
        let name = |c: &StoredCalibration| match one_a_day {
            true => c.time.date(),
            false => c.time.to_string(),
        };
        let names: Vec<String> = own.iter().map(name).collect();
        let files: Vec<_> = own
            .iter()
            .map(|c| &c.file)
            .zip(names.iter().map(|n| &**n))
            .collect();
        let calibration = |c: &StoredCalibration| HistoryCalibration {
            path: c.path.display().to_string(),
            time: c.time,
            time_source: c.time_source,
            method: c.file.accelerometer.method.clone(),
            grade: c.file.verdict.grade,
            gravity_mps2: c.file.gravity_mps2,
            temperature_c: c.file.temperature_c,
            gyroscope_bias_deg_s: c.file.gyroscope.as_ref().map(GyroscopeSection::bias_deg_s),
        };
        Ok(SensorHistory {
            store: self.folder.display().to_string(),
            sensor_id: sensor_id.to_owned(),
            calibrations: own.iter().map(calibration).collect(),
            history: history(&files),
            left_out: self.left_out.clone(),
        })
    }
}
