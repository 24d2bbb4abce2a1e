//! Epochs of a worn accelerometer: activity, posture and non-wear, one row for each few seconds.
//!
//! # Overview
//!
//! [`summarise`] reads a recording once and writes a table. Per epoch, with ‖a‖ the magnitude of a
//! sample in g:
//!
//! - means and standard deviations (n − 1) of the axes and of ‖a‖;
//! - ENMO, the mean of max(‖a‖ − 1, 0): van Hees et al. 2013, <https://doi.org/10.1371/journal.pone.0061691>;
//! - MAD, the mean of |‖a‖ − its mean over the epoch|: Vähä-Ypyä et al. 2015,
//!   <https://doi.org/10.1111/cpf.12127>;
//! - the angle of the z axis, atan2(z, √(x² + y²)) of the medians of the axes: van Hees et al. 2015,
//!   <https://doi.org/10.1371/journal.pone.0142533>, with the median of the epoch in place of a
//!   rolling one;
//! - non-wear: for each 15 min, the 60 min around them; not worn if two axes have a standard
//!   deviation below 13 mg and a range below 50 mg: van Hees et al. 2013.
//!
//! One g is 9.80665 m/s², or with a calibration the gravity that it is based on: at rest ‖a‖ is 1.
//!
//! Memory does not grow with the recording: a verdict on wear waits for 37 min of samples, the table
//! for the end of the recording in a file without a name.
//!
//! # Example
//!
//! ```
//! use gravical::wearable::{SummariseOptions, summarise};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("wrist.csv");
//! let mut csv = "t,ax,ay,az\n".to_owned();
//! for row in 0..1500 {
//!     csv += &format!("{},0.0,0.6,0.8\n", 1_767_225_600.0 + f64::from(row) / 100.0);
//! }
//! std::fs::write(&path, csv)?;
//! let mut table = Vec::new();
//! let summary = summarise(&path, None, &SummariseOptions::default(), &mut table)?;
//! assert_eq!(summary.worn.epochs, 3);
//! let table = String::from_utf8(table)?;
//! assert!(table.lines().nth(1).unwrap().starts_with("2026-01-01T00:00:00Z,0.00000,0.60000,0.80000"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod epochs;
mod measures;
mod nonwear;
mod table;
#[cfg(test)]
mod tests;
mod totals;
mod zone;

use std::io::Write;
use std::path::Path;

use serde::Serialize;

use crate::apply::about_calibration;
use crate::calibration_file::{Applied, CalibrationFile};
use crate::recording::collect::{Collected, Rereader, collect};
use crate::recording::format::Format;
use crate::recording::monitor::{Facts, refuse_unit_change};
use crate::recording::names::Role;
use crate::recording::open::Reopenable;
use crate::recording::{AccelScale, Finding, FindingKind, ReadOptions};
use crate::segment::face::AxisMap;
use crate::{Error, Result};

pub use totals::{Day, Worn};
pub use zone::Zone;

use epochs::{Epochs, MOST_FILLED_S};
use table::TimeColumn;

/// Options of [`summarise`].
#[derive(Debug, Clone)]
pub struct SummariseOptions {
    /// How the recording is read.
    pub read: ReadOptions,
    /// Length of an epoch, s: a divisor of 60. Default: 5.
    pub epoch_s: u32,
    /// Zone in which dates are written. Default: UTC.
    pub time_zone: Option<Zone>,
    /// Orientation of the board in its case. Default: the axes of the board.
    pub axes: AxisMap,
}

impl Default for SummariseOptions {
    fn default() -> Self {
        SummariseOptions {
            read: ReadOptions::default(),
            epoch_s: 5,
            time_zone: None,
            axes: AxisMap::default(),
        }
    }
}

impl SummariseOptions {
    /// Checks the options.
    ///
    /// # Errors
    ///
    /// `option-range` (usage).
    pub fn validate(&self) -> Result<()> {
        self.read.validate()?;
        if !(1..=60).contains(&self.epoch_s) || 60 % self.epoch_s != 0 {
            let what = format!(
                "{} s is no part of a minute; 1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30 and 60 s are",
                self.epoch_s
            );
            return Err(Error::range("epoch_s", what));
        }
        Ok(())
    }
}

/// Result of [`summarise`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WearableSummary {
    /// Path of the recording as given, `-` for standard input.
    pub input: String,
    /// SHA-256 of the recording, if requested.
    pub sha256: Option<String>,
    /// Its text format in words.
    pub description: String,
    /// Its rows.
    pub rows: u64,
    /// Sampling rate, Hz; null if it is not known.
    pub rate_hz: Option<f64>,
    /// Unit of the accelerometer in the recording, and its source.
    pub accelerometer: AccelScale,
    /// A calibration was applied here.
    pub calibrated: bool,
    /// What one g of the table is, m/s².
    pub g_mps2: f64,
    /// Length of an epoch, s.
    pub epoch_s: u32,
    /// Start of the first epoch: a date, or seconds since the first sample.
    pub start: String,
    /// End of the last epoch.
    pub end: String,
    /// Zone of the dates; null if the time stamps are no dates.
    pub time_zone: Option<String>,
    /// Samples in all epochs.
    pub samples: u64,
    /// Samples that are missing: rows without all three axes, and steps of the time stamps.
    pub missing: u64,
    /// Sums over all epochs.
    #[serde(flatten)]
    pub worn: Worn,
    /// The same for each day.
    pub days: Vec<Day>,
    /// Names of the columns written.
    pub columns: Vec<String>,
    /// Faults found.
    pub findings: Vec<Finding>,
}

/// Writes one row for each epoch of the recording at `path` (`-` is standard input) to `out`, after
/// applying `calibration` if there is one.
///
/// # Errors
///
/// `option-range`, `time-zone-unused` (usage); `unit-unknown`, `rate-unknown`, `unit-mismatch` (input)
/// if values, times or the calibration have no known size; `unit-changed`; as
/// [`crate::recording::read`]; errors of writing. Nothing is written before the recording was read.
pub fn summarise(
    path: &Path,
    calibration: Option<&CalibrationFile>,
    options: &SummariseOptions,
    out: &mut dyn Write,
) -> Result<WearableSummary> {
    options.validate()?;
    let name = path.display().to_string();
    let mut source = Reopenable::of(path);
    let role = Role::Recording;
    let sink = |format: &Format, facts: &Facts| Epochs::new(options, calibration, format, facts);
    let read = collect(&mut source, &name, role, &options.read, sink)?;
    let (mut epochs, mut rest) = read.with(());
    // Evenly spaced rows have the mean rate of all of them, which is known only now.
    if rest.even_hz().is_some() {
        let mut again = Rereader::new(&mut source, &name, &options.read, rest.known());
        epochs = again.collect(sink)?;
    }
    epochs.check(&name)?;
    refuse_unit_change(&rest.finished.summary.found, &options.read, &name)?;
    let mut findings = std::mem::take(&mut rest.about.findings);
    findings.extend(rest.facts.contradicted_by(&rest.finished.summary.facts));
    findings.append(&mut rest.finished.findings());
    findings.append(&mut epochs.drift_findings());
    let scale = rest.finished.summary.facts.accel;
    match calibration {
        Some(file) => {
            let applied = Applied {
                calibration: file,
                name: &name,
                scale,
                given: options.read.accel_unit.is_some(),
                norm_mps2: epochs.quiet.finish().map(|quiet| quiet.norm),
                gravity_mps2: file.gravity_mps2,
                at_rest: "its quietest parts",
                moves: false,
            };
            applied.judge(&mut findings)?;
            let (already, by_board) = (rest.about.is_calibrated, rest.about.is_calibrated_by_board);
            findings.extend(about_calibration(file, already, by_board));
        }
        None if rest.about.is_calibrated => {}
        None => findings.push(Finding::new(
            FindingKind::EpochsUncalibrated,
            "no calibration was applied: an error of ‖a‖ at rest of 10 mg is up to 10 mg of ENMO; give one with --calibration",
        )),
    }
    findings.extend(of_epochs(&epochs));
    for finding in &mut findings {
        finding.file = Some(name.clone());
    }
    epochs.copy_table(out)?;
    Ok(summary(&name, epochs, rest, calibration, options, findings))
}

/// What is odd about the times of the rows.
fn of_epochs(epochs: &Epochs) -> impl Iterator<Item = Finding> {
    let untimed = (!epochs.untimed.is_empty()).then(|| {
        Finding::new(
            FindingKind::EpochRowsUntimed,
            format!(
                "{} rows are before the first time stamp and in no epoch",
                epochs.untimed.count()
            ),
        )
        .at_lines(&epochs.untimed)
    });
    let jumps = (!epochs.jumps.is_empty()).then(|| {
        Finding::new(
            FindingKind::EpochsJump,
            format!(
                "the clock steps back, or ahead by more than {} days, in {} places: the table goes on with the new time",
                MOST_FILLED_S / 86_400,
                epochs.jumps.count()
            ),
        )
        .at_lines(&epochs.jumps)
    });
    let empty = epochs.totals.all.epochs_empty;
    let empty = (empty > 0).then(|| {
        Finding::new(
            FindingKind::EpochsEmpty,
            format!("{empty} epochs have no samples: their cells are empty"),
        )
        .counting(empty)
    });
    untimed.into_iter().chain(jumps).chain(empty)
}

fn summary(
    name: &str,
    epochs: Epochs,
    rest: Collected<()>,
    calibration: Option<&CalibrationFile>,
    options: &SummariseOptions,
    findings: Vec<Finding>,
) -> WearableSummary {
    let time = epochs.time.as_ref();
    let [start_s, end_s] = epochs.totals.span_s.unwrap_or_default();
    let text = |s: i64| time.map_or_else(String::new, |time| time.text(s));
    let facts = &rest.finished.summary;
    WearableSummary {
        input: name.to_owned(),
        sha256: rest.about.sha256,
        description: rest.about.description,
        rows: rest.finished.ledger.rows,
        rate_hz: facts.timing.rate_hz(),
        accelerometer: facts.facts.accel,
        calibrated: calibration.is_some(),
        g_mps2: epochs.g_mps2(),
        epoch_s: options.epoch_s,
        start: text(start_s),
        end: text(end_s),
        time_zone: match time {
            Some(TimeColumn::Dates { zone, .. }) => Some(zone.to_string()),
            Some(TimeColumn::Relative) | None => None,
        },
        samples: epochs.totals.samples,
        missing: epochs.totals.missing,
        days: epochs.totals.days(),
        worn: epochs.totals.all.clone(),
        columns: time.map_or_else(Vec::new, |t| t.columns().map(str::to_owned).collect()),
        findings,
    }
}
