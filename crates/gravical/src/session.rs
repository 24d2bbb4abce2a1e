//! The files of a session, and its calibration.

use std::path::{Path, PathBuf};

use crate::Result;
use crate::calibrate::{CalibrateOptions, Calibrated, calibrate};
use crate::gravity::Gravity;
use crate::live::folder::{calibrate_folder, is_session};
use crate::problem::Problem;
use crate::recording::source::stem;
use crate::recording::{ReadOptions, Recording};

#[doc(hidden)]
pub use gravical_calibrate::session::*;
#[doc(inline)]
pub use gravical_calibrate::session::{SessionFiles, read_session};

/// Reads the files of a session, one folder, or the folder of a guided session, and calibrates; what was
/// left out of a folder is among the findings. `gyro` is the gyroscope of the one recording in a second file;
/// `gravity`, if it is given, stands for that of a guided session. Returns the recordings, too.
///
/// # Errors
///
/// Those of [`read_session`], [`calibrate`] and of a guided session.
pub fn calibrate_files(
    inputs: &[PathBuf],
    gyro: Option<&Path>,
    how: &ReadOptions,
    options: &CalibrateOptions,
    gravity: Option<Gravity>,
) -> Result<(Vec<Recording>, Calibrated)> {
    let name = name_sensor(inputs, options)?;
    if let [folder] = inputs
        // Sections name rows: the whole recording is needed.
        && options.segment.sections.is_none()
        && gyro.is_none()
        && is_session(folder)
    {
        let (recordings, mut done) = calibrate_folder(folder, how, options, gravity)?;
        done.calibration.sensor.id = name.or(done.calibration.sensor.id);
        return Ok((recordings, done));
    }
    let (recordings, left_out) = read_session(inputs, gyro, how)?;
    let mut done = calibrate(&recordings, options)?;
    done.calibration.findings.extend(left_out);
    done.calibration.sensor.id = name.or(done.calibration.sensor.id);
    Ok((recordings, done))
}

/// As a sensor's id: it is the name of the session's folder or file.
#[doc(hidden)]
pub const BY_FOLDER: &str = "folder";

/// Name of a session: that of a recording without its endings (`x.csv.gz` has two), all of a folder's.
#[doc(hidden)]
pub fn session_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or("session".as_ref());
    let name = name.to_string_lossy();
    if path.is_dir() {
        name.into_owned()
    } else {
        stem(&name)
    }
}

/// The name of the session, where it is the sensor's id.
///
/// # Errors
///
/// `sensor-of-several` (usage) where it would be that of several inputs.
fn name_sensor(inputs: &[PathBuf], options: &CalibrateOptions) -> Result<Option<String>> {
    if options.record.sensor_id.as_deref() != Some(BY_FOLDER) {
        return Ok(None);
    }
    let [session] = inputs else {
        return Err(Problem::SensorOfSeveral.error().of_option("sensor_id"));
    };
    // `.` has a name, too.
    let session = session.canonicalize().unwrap_or_else(|_| session.clone());
    Ok(Some(session_name(&session)))
}
