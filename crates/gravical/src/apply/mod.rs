//! Application of a calibration to a recording of any size, in one pass.
//!
//! # Overview
//!
//! [`apply`] examines the head of the recording to determine its format and unit (`judge`), plans
//! the columns to write (`plan`) and processes the rows once. The calibrated channels replace the
//! raw ones under SI names; every other column is copied byte for byte. A calibration that does
//! not fit the recording's unit is refused before anything is written. The [`ApplySummary`]
//! accounts for every line and contains the findings about the samples.
//!
//! `calibrated = matrix · (raw − bias)` for the accelerometer and `matrix · (raw − bias −
//! g_sensitivity · a)` for the gyroscope, where raw is the value in the file. The temperature
//! drift is subtracted first if the calibration has a temperature model and the recording has
//! temperatures (`drift`).
//!
//! # Example
//!
//! ```
//! use gravical::apply::{ApplyOptions, apply};
//! use gravical::calibration_file::CalibrationFile;
//! use gravical::recording::open::from_reader;
//!
//! let calibration = CalibrationFile::parse(br#"{
//!     "acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": "g", "cal_type": "Ferraris",
//!     "K_a": [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]], "b_a": [0, 0, 0.02],
//!     "R_a": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
//!     "K_g": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "b_g": [0, 0, 0],
//!     "R_g": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
//!     "K_ga": [[0, 0, 0], [0, 0, 0], [0, 0, 0]]
//! }"#)?;
//! let recording = "t_ms,ax,ay,az,battery\n0,0.01,0.00,1.00,3.30\n10,0.02,0.00,1.01,3.30\n";
//! let input = from_reader(Box::new(recording.as_bytes()), false)?;
//! let mut out = Vec::new();
//! let summary = apply(&calibration, input, "desk.csv", &mut out, &ApplyOptions::default())?;
//! assert_eq!(summary.rows, 2);
//! assert_eq!(
//!     String::from_utf8_lossy(&out),
//!     "t_ms,ax_mps2,ay_mps2,az_mps2,battery\n\
//!      0,0.100000,0.000000,9.800000,3.30\n\
//!      10,0.200000,0.000000,9.900000,3.30\n"
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod drift;
mod joined;
mod judge;
pub(crate) mod memory;
pub(crate) mod plan;
pub(crate) mod sensor;
mod unit;

#[cfg(test)]
mod tests;

use std::io::Write;

use serde::Serialize;

use crate::Result;
use crate::calibration_file::CalibrationFile;
use crate::output::BlockWriter;
use crate::poses::face::AxisMap;
use crate::recording::board::why_calibrated;
use crate::recording::file::open_rows;
use crate::recording::monitor::refuse_unit_change;
use crate::recording::names::Role;
use crate::recording::open::Input;
use crate::recording::{
    AccelScale, AccelUnit, Aside, Finding, FindingKind, GyroUnit, Ledger, ReadOptions, Recording,
};

pub use drift::TemperatureOutcome;
pub use memory::{Applied, apply_recording};
pub use unit::OutputUnit;

use drift::Drift;
use joined::Joined;
use judge::{Case, judge};
use plan::Plan;
use sensor::Sensor;

/// Options of [`apply`].
#[derive(Debug, Clone, Default)]
pub struct ApplyOptions {
    /// Options of the recording. `zero_offset` is used only to determine the unit: a
    /// calibration's bias contains it. With `accel_unit` the calibration is applied even if
    /// gravity contradicts it.
    pub read: ReadOptions,
    /// Keep the raw columns; the calibrated ones are added at the end. Default: they replace the
    /// raw ones.
    pub keep_raw: bool,
    /// Orientation of the board in its case: the calibrated vectors are written in the axes of
    /// the case. Default: those of the board.
    pub axes: AxisMap,
    /// Unit of the calibrated specific force. Default: m/s².
    pub output_unit: OutputUnit,
}

/// Result of [`apply`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ApplySummary {
    /// Path of the recording as given, `-` for standard input.
    pub input: String,
    /// Its text format in words: `comma separated, header in line 1`.
    pub description: String,
    /// Its lines: `lines = rows + Σ set_aside`.
    pub lines: u64,
    /// Rows that were written.
    pub rows: u64,
    /// Rows written without calibrated acceleration because a value was missing.
    pub rows_without_acceleration: u64,
    /// Lines that are not rows, by reason. Breaks are written as blank lines.
    pub set_aside: Vec<SetAside>,
    /// Unit of the accelerometer in the recording, and its source.
    pub accelerometer: AccelScale,
    /// Input unit of the accelerometer's calibration.
    pub calibration_unit: AccelUnit,
    /// Unit of the calibrated specific force.
    pub output_unit: OutputUnit,
    /// Treatment of the gyroscope.
    pub gyroscope: GyroscopeOutcome,
    /// Result of the temperature correction; null if the calibration has no drift or the
    /// recording no temperatures.
    pub temperature: Option<TemperatureOutcome>,
    /// Calibrated magnitude in the quietest parts of the head, m/s²; null if no row of it is
    /// complete.
    pub quiet_norm_mps2: Option<f64>,
    /// Gravity that the calibration is based on, m/s².
    pub gravity_mps2: f64,
    /// Names of the columns written.
    pub columns: Vec<String>,
    /// Faults found.
    pub findings: Vec<Finding>,
}

/// Lines that are not rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SetAside {
    /// Reason; in JSON its name, as in the counts of `inspect`.
    #[serde(serialize_with = "by_name")]
    pub reason: Aside,
    /// Number of lines.
    pub lines: u64,
}

fn by_name<S: serde::Serializer>(reason: &Aside, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(reason.name())
}

/// Treatment of the gyroscope's columns.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "outcome", content = "unit")]
pub enum GyroscopeOutcome {
    /// Calibrated from this unit to rad/s.
    Calibrated(GyroUnit),
    /// Copied byte for byte: the calibration has no gyroscope.
    Kept,
    /// The recording has none.
    Absent,
}

/// Applies `calibration` to the recording `input` and writes a table with a header to `out`;
/// `name` is used in messages.
///
/// Memory use is a few MiB, whatever the size of the recording. The unit is determined from the
/// first 256 KiB, so nothing is written before they have been read.
///
/// Values have six decimals, in the unit of the options. The delimiter is that of the input; white space becomes a tab.
/// Decimal commas are kept.
///
/// # Errors
///
/// `unit-mismatch` (input) if the calibration is for another unit or range, or if calibrated
/// gravity is off by more than a fifth; `all-zero`, `no-rows`, `no-values`, `empty-file`,
/// `no-accelerometer`, `columns-unknown` as [`crate::recording::read`]; `unit-changed` if the
/// unit changes among the rows and `accel_unit` is not given, `header-differs` if a header among
/// them cannot be converted to the first one; errors of reading and writing. With `all-zero`,
/// `no-values`, `unit-changed` and `header-differs` some rows may have been written already.
pub fn apply(
    calibration: &CalibrationFile,
    input: Input,
    name: &str,
    out: &mut dyn Write,
    options: &ApplyOptions,
) -> Result<ApplySummary> {
    run(calibration, input, name, out, options, None)
}

/// The same with the gyroscope of a second file: `joined` is the recording `input`, read as a
/// whole, with the gyroscope joined to it
/// ([`join_gyroscope`](crate::recording::join_gyroscope)). The calibrated angular rate is
/// appended as columns; rows without a reading of the gyroscope nearby have none.
///
/// # Errors
///
/// As [`apply`], and `gyro-not-calibrated` (usage) if the calibration has no gyroscope.
pub fn apply_with_gyroscope(
    calibration: &CalibrationFile,
    input: Input,
    name: &str,
    out: &mut dyn Write,
    options: &ApplyOptions,
    joined: &Recording,
) -> Result<ApplySummary> {
    run(calibration, input, name, out, options, Some(joined))
}

fn run(
    calibration: &CalibrationFile,
    input: Input,
    name: &str,
    out: &mut dyn Write,
    options: &ApplyOptions,
    joined: Option<&Recording>,
) -> Result<ApplySummary> {
    options.read.validate()?;
    let mut file = open_rows(input, name, Role::Recording, &options.read, None)?.with_spans();
    let mut findings = std::mem::take(&mut file.findings);
    let (format, head) = (file.format.clone(), file.head());
    let with_gyro = joined.is_some() || format.layout.has_gyro();
    let drift = Drift::new(
        calibration,
        &head,
        &format.layout,
        file.rows.facts().celsius,
        with_gyro,
        &mut findings,
    );
    let case = Case {
        calibration,
        head: &head,
        whole: file.whole,
        facts: file.rows.facts(),
        claim: format.layout.accel_claim,
        options: &options.read,
        drift: drift.as_ref(),
        name,
    };
    let judged = judge(&case, &mut findings)?;
    let joined = joined.map(|r| Joined::new(calibration, r, &mut findings));
    let mut joined = joined.transpose()?;
    let gyro_unit = joined.as_ref().map(|j| j.unit).or(judged.gyro);
    let has_drift = calibration.drift_model().is_some();
    let assumed = *file.rows.facts();
    let names = format.dialect.header.as_ref().map_or(&[][..], |h| &h.names);
    findings.extend(about_calibration(
        calibration,
        format.layout.reads_calibrated(names),
        format.layout.calibrated_by_board,
    ));
    let mut plan = Plan::new(
        &format.dialect,
        &format.layout,
        options.output_unit,
        gyro_unit.is_some(),
        options.keep_raw,
    );
    findings.append(&mut plan.findings);

    let mut sensor = Sensor::new(calibration, gyro_unit.is_some(), options.axes).with_drift(drift);
    let mut out = BlockWriter::new(out);
    out.bytes.extend_from_slice(&plan.header());
    let mut without_acceleration = 0;
    while let Some(row) = file.rows.next_row()? {
        let mut calibrated = match &mut joined {
            Some(joined) => sensor.calibrate(&joined.fill(row.values, row.line), row.line),
            None => sensor.calibrate(row.values, row.line),
        };
        without_acceleration += u64::from(calibrated[0].is_nan());
        options.output_unit.convert(&mut calibrated[..3]);
        write_breaks(row.before, &mut out.bytes);
        plan.write_row(row.text.bytes, row.text.spans, &calibrated, &mut out.bytes);
        out.write_if_full()?;
    }
    let mut read = file.finish()?;
    refuse_unit_change(&read.finished.summary.found, &options.read, name)?;
    write_breaks(&read.finished.trailing, &mut out.bytes);
    out.finish()?;
    findings.append(&mut read.findings);
    let found = read.finished.summary.found;
    findings.extend(assumed.contradicted_by(&read.finished.summary.facts));
    findings.extend(read.finished.zeros);
    // Counts are the calibration's own unit; temperatures matter to its drift.
    let temperature = |f: &Finding| f.kind == FindingKind::TemperatureUnit && has_drift;
    findings.extend(found.channels.into_iter().filter(temperature));
    findings.extend(found.clock);
    findings.extend(found.cells);
    // The unit itself was checked above.
    let changed = |f: &Finding| f.kind == FindingKind::UnitChanged;
    findings.extend(found.unit.into_iter().filter(changed));
    findings.extend(found.values);
    let temperature = sensor.drift.as_ref().map(|d| d.finish(&mut findings));
    for finding in &mut findings {
        finding.file = Some(name.to_owned());
    }
    let ledger = read.finished.ledger;
    Ok(ApplySummary {
        input: name.to_owned(),
        description: read.description,
        lines: ledger.lines,
        rows: ledger.rows,
        rows_without_acceleration: without_acceleration,
        set_aside: set_aside(&ledger),
        accelerometer: judged.accel,
        calibration_unit: calibration.accelerometer.input_unit,
        output_unit: options.output_unit,
        gyroscope: gyroscope_outcome(gyro_unit, format.layout.has_gyro()),
        temperature,
        quiet_norm_mps2: judged.quiet_norm_mps2,
        gravity_mps2: calibration.gravity_mps2,
        columns: plan.names,
        findings,
    })
}

/// What is odd about applying this calibration to this recording.
pub(crate) fn about_calibration(
    calibration: &CalibrationFile,
    already: bool,
    by_board: bool,
) -> impl Iterator<Item = Finding> {
    let twice = already.then(|| {
        Finding::new(
            FindingKind::AlreadyCalibrated,
            format!(
                "{}: calibrating again would apply the correction twice",
                why_calibrated(by_board)
            ),
        )
    });
    calibration.poor_finding().into_iter().chain(twice)
}

pub(crate) fn set_aside(ledger: &Ledger) -> Vec<SetAside> {
    let reasons = ledger.reasons();
    reasons
        .map(|(reason, lines)| SetAside { reason, lines })
        .collect()
}

fn gyroscope_outcome(calibrated: Option<GyroUnit>, recorded: bool) -> GyroscopeOutcome {
    match calibrated {
        Some(unit) => GyroscopeOutcome::Calibrated(unit),
        None if recorded => GyroscopeOutcome::Kept,
        None => GyroscopeOutcome::Absent,
    }
}

/// Writes each line that is a break as a blank line; many programs cannot read comments.
fn write_breaks(before: &[Aside], out: &mut Vec<u8>) {
    out.extend(before.iter().map(|_| b'\n'));
}
