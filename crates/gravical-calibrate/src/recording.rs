//! Reading of recordings in many formats, and the faults found in them.
//!
//! # Overview
//!
//! [`read`] opens a file (plain, gzip, standard input) and reads it with the crate
//! `gravical_recording`: its format, which column is which channel, and what the columns say of clock,
//! units and defects. The [`Ledger`] accounts for every line: it is a row, or it was set aside for a
//! given reason. Every fault is reported as a [`Finding`] with its lines.
//!
//! Values stay in the unit of the file; [`AccelScale::nominal`] is the size of one m/s² in that
//! unit. The bias and matrix of a calibration therefore apply to the numbers in the file.
//!
//! # Example
//!
//! ```
//! # use gravical_calibrate as gravical;
//! use gravical::recording::{ReadOptions, read_bytes};
//!
//! let csv = "t_ms,ax,ay,az\n0,0.1,0.0,9.8\n10,0.1,0.1,9.8\n20,0.1,0.0,9.7\n";
//! let recording = read_bytes(csv.as_bytes(), "desk.csv", &ReadOptions::default())?;
//! assert_eq!(recording.rows(), 3);
//! assert_eq!(recording.units.accel.unit.name(), "m/s^2");
//! # Ok::<(), gravical::Error>(())
//! ```

use std::path::Path;

use gravical_judge::escape::path_word;

use crate::finding::Case;
use crate::problem::Problem;
use crate::{Error, Result};

pub use crate::finding::{Finding, LineSpans, Severity};
pub use gravical_judge::{ColumnsSpec, Meter, Progress, ReadOptions};
#[doc(hidden)]
pub use gravical_judge::{full_scale, units};
#[doc(hidden)]
pub use gravical_recording::{
    BoardSettings, Follow, Form, LineKind, bytes, holds_gyroscope_alone, is_named_gyroscope,
    max_bytes, source,
};
pub use gravical_recording::{
    Clock, JoinedFile, Labels, Ledger, Reason, Recording, TableColumn, join_gyroscope, read,
    read_bytes, read_head, read_joined, read_named, read_samples,
};
pub use units::{AccelScale, AccelUnit, GyroScale, GyroUnit, Origin, TimeUnit, Units};

/// Size of one m/s² in the numbers of the accelerometer.
///
/// # Errors
///
/// `unit-unknown` for counts of unknown range.
#[doc(hidden)]
pub fn nominal_accel(recording: &Recording) -> Result<f64> {
    recording.units.accel.nominal().ok_or_else(|| {
        let error = Problem::RangeUnknown.error();
        let error = error.at(recording.name.as_ref(), None);
        let error = error.advise("accel_unit", "counts");
        error.advise("accel_range", "2")
    })
}

/// The serial number that the files name, if any does.
///
/// # Errors
///
/// `sensors-differ` where they name several.
#[doc(hidden)]
pub fn common_serial(recordings: &[Recording]) -> Result<Option<String>> {
    let named = recordings.iter().map(|r| (&r.name, r.format.serial()));
    let mut named = named.filter_map(|(name, serial)| Some((name, serial?)));
    let Some((one, serial)) = named.next() else {
        return Ok(None);
    };
    let Some((other, another)) = named.find(|(_, another)| *another != serial) else {
        return Ok(Some(serial));
    };
    let files = [one, other].map(String::clone);
    let serials = [serial, another];
    let differ = Problem::SerialsDiffer { files, serials }.error();
    Err(differ.at(other.as_ref(), None).advise("sensor_id", ""))
}

/// Adds to an error what reading `recordings` lost: too few poses can be too few rows.
pub(crate) fn after_losses(error: Error, recordings: &[Recording]) -> Error {
    let said = |f: &Finding| match f.count {
        0 => f.kind.clone(),
        n => format!("{n} {}", f.kind),
    };
    let losses = |recording: &Recording| -> Vec<String> {
        let lost = recording.findings.iter().filter(|f| f.is_loss());
        lost.map(said).collect()
    };
    let mut damaged = recordings.iter().map(|r| (&r.name, losses(r)));
    let Some((name, losses)) = damaged.find(|(_, losses)| !losses.is_empty()) else {
        return error;
    };
    let file = path_word(Path::new(name));
    let mut hint = format!("`gravical inspect {file}` shows the damaged lines");
    if let Some(first) = error.hint() {
        hint += &format!("; {first}");
    }
    let losses = losses.join(", ");
    error
        .with_detail(&format!("; reading {name} lost samples: {losses}"))
        .with_hint(hint)
}

/// That a recording is calibrated already; `case` of whether by the board.
#[doc(hidden)]
pub fn already_calibrated(
    recording: &Recording,
    case: impl FnOnce(bool) -> Case,
) -> Option<Finding> {
    let format = &recording.format;
    let found = || case(format.is_calibrated_by_board()).finding();
    let is_calibrated = format.is_calibrated();
    is_calibrated.then(|| found().in_file(&recording.name))
}
