//! The calibration of a recording among those of a folder.

use std::path::{Path, PathBuf};

use gravical_judge::utc::UtcTime;
use gravical_recording::output::ends_in;
use gravical_recording::source::entries;

use crate::Result;
use crate::calibration_file::{Calibration, InputFile, other_range};
use crate::problem::Problem;
use crate::recording::{AccelScale, AccelUnit, Recording, common_serial};

/// A calibration of a folder.
struct Found {
    file: Calibration,
    /// Path and checksum of its file, as results list it.
    input: InputFile,
    /// When the sensor was calibrated: the time of the session, else of the computation.
    time: Option<UtcTime>,
}

impl Found {
    fn sensor(&self) -> Option<&str> {
        let id = self.file.sensor.id.as_deref().map(str::trim);
        id.filter(|id| !id.is_empty())
    }

    /// Unit, and range of counts, of the recording.
    fn takes(&self, scale: AccelScale) -> bool {
        let section = &self.file.accelerometer;
        let is_known = |unit| unit != AccelUnit::Unknown;
        let is_same = section.input_unit == scale.unit && other_range(section, scale).is_none();
        is_same || !is_known(section.input_unit) || !is_known(scale.unit)
    }

    /// For errors.
    fn line(&self) -> String {
        let file = Path::new(&self.input.path).file_name().unwrap_or_default();
        let file = file.to_string_lossy();
        let sensor = self.sensor().unwrap_or("no sensor named");
        let unit = self.file.accelerometer.input_unit;
        let time = self.time.map_or("no date".to_owned(), UtcTime::minute);
        format!("{file}: {sensor}, {unit}, {time}")
    }
}

/// The calibration in `folder` for `recordings` of one sensor, whose first rows are enough: of
/// that sensor (`sensor_id`, else the serial number that they name), for their unit and range, the
/// last one before them; its file as results list it, and why it was taken. Without a date of the
/// recordings it is the last of all, which the reason says. Files that are no calibration are not looked
/// at, nor are folders in it.
///
/// # Errors
///
/// `no-calibration` (input), with what is there; `sensor-id-missing` (usage) where the recordings
/// name no sensor and the folder has several; `sensors-differ` (input) for recordings of several,
/// or of another one than given.
pub fn find_calibration(
    folder: &Path,
    recordings: &[Recording],
    sensor_id: Option<&str>,
) -> Result<(Calibration, InputFile, String)> {
    let named = match common_serial(recordings) {
        // The user says that they are of one sensor.
        Err(_) if sensor_id.is_some() => None,
        named => named?,
    };
    if let (Some(named), Some(given)) = (&named, sensor_id)
        && named != given
    {
        let (named, given) = (named.clone(), given.to_owned());
        let of_another = Problem::NotOfSensor { named, given }.error();
        return Err(of_another.advise("sensor_id", ""));
    }
    let mut all = calibrations(folder)?;
    let sensor = named.or_else(|| sensor_id.map(str::to_owned));
    // Calibrations that name no sensor may be of several.
    let is_one = |c: &Found| c.sensor().is_some() && c.sensor() == all[0].sensor();
    if sensor.is_none() && all.len() > 1 && !all.iter().all(is_one) {
        let there = all.iter().map(Found::line).collect();
        let unnamed = Problem::SensorUnnamed { there }.error().at(folder, None);
        return Err(unnamed.advise("sensor_id", ""));
    }
    let scale = recordings.first().map(|r| r.units.accel);
    let recorded = recordings.iter().filter_map(Recording::recorded_at).min();
    let fits = |(_, c): &(usize, &Found)| {
        (sensor.is_none() || c.sensor() == sensor.as_deref())
            && scale.is_none_or(|scale| c.takes(scale))
            && recorded.is_none_or(|recorded| c.time.is_none_or(|time| time <= recorded))
    };
    let fitting = all.iter().enumerate().filter(fits);
    if let Some((last, _)) = fitting.max_by_key(|(_, c)| c.time) {
        let reason = match recorded {
            Some(time) => format!("the last before the recording of {}", time.minute()),
            None => "the last; the recording has no date".to_owned(),
        };
        let Found { file, input, .. } = all.swap_remove(last);
        return Ok((file, input, reason));
    }
    let none = Problem::NoneFits {
        sensor,
        scale,
        recorded,
        there: all.iter().map(Found::line).collect(),
    };
    Err(none.error().at(folder, None))
}

/// Files of a folder that may be calibrations by their names, in the order of these.
///
/// # Errors
///
/// Those of the file system.
pub fn json_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut paths = entries(folder)?;
    paths.retain(|path| ends_in(path, "json"));
    Ok(paths)
}

/// The calibrations in a folder; other JSON is left out.
///
/// # Errors
///
/// Errors of the file system, and those of a calibration that cannot be read: it might be the one.
fn calibrations(folder: &Path) -> Result<Vec<Found>> {
    let mut found = Vec::new();
    for path in json_files(folder)? {
        match Calibration::read_with_input(&path) {
            Ok((file, input)) => {
                let recorded = file.recorded.map(|recorded| recorded.time);
                let time = recorded.or_else(|| file.created.parse().ok());
                found.push(Found { file, input, time });
            }
            Err(error) if claims_calibration(&path) => return Err(error),
            Err(_) => {}
        }
    }
    Ok(found)
}

fn claims_calibration(path: &Path) -> bool {
    let text = std::fs::read(path).unwrap_or_default();
    String::from_utf8_lossy(&text).contains("\"gravical-calibration/")
}
