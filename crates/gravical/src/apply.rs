//! Application of a calibration to a recording of any size, in one pass.
//!
//! # Overview
//!
//! [`apply`] judges the first rows of a recording, and whether the calibration fits them; the others
//! are read alike, calibrated and written, and not judged. The calibrated channels replace the raw ones under SI names; every other column is copied byte for
//! byte. A calibration that does not fit is refused before anything is written. The
//! [`ApplySummary`] accounts for every line.
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
//! use gravical::calibration_file::Calibration;
//! use gravical::recording::bytes::from_reader;
//!
//! let calibration = Calibration::parse(br#"{
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

mod drift;

#[cfg(test)]
mod tests;

use std::io::Write;
use std::path::{Path, PathBuf};

use gravical_core::calibration::{GyroscopeCalibration, LinearCalibration};
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_judge::quiet_norm;
use gravical_recording::bytes::Input;
use gravical_recording::write::Table;
use gravical_recording::{CALIBRATED, Format, Piece, Stream};
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::calibration_file::{Calibration, judge_unit};
use crate::finding::CalibrationCase;
use crate::poses::face::AxisMap;
use crate::poses::gyro_unit;
use crate::poses::rests::find_rests;
use crate::problem::Problem;
use crate::recording::{
    AccelScale, Finding, GyroUnit, Ledger, ReadOptions, Reason, Recording, already_calibrated,
    join_gyroscope,
};
use crate::rewrite::write_rows;

pub use drift::TemperatureOutcome;

use drift::Drift;

/// Names of the calibrated channels of the gyroscope.
const RATES: [&str; 3] = ["gx_rad_s", "gy_rad_s", "gz_rad_s"];
/// Decimals of a calibrated value.
const DECIMALS: u32 = 6;

/// Options of [`apply`].
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct ApplyOptions {
    /// Options of the recording. `zero_offset` is used only to determine the unit: a
    /// calibration's bias contains it. With `accel_unit` the calibration is applied even if
    /// gravity contradicts it.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub read: ReadOptions,
    /// Gyroscope in a second file, joined by time
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub gyro: Option<PathBuf>,
    /// Keep the raw columns, append the calibrated ones
    #[cfg_attr(feature = "clap", arg(long))]
    pub keep_raw: bool,
    /// Axes of the sensor that point along x, y and z of the case.
    #[serde(deserialize_with = "gravical_judge::option_text::one")]
    #[cfg_attr(feature = "clap", command(flatten))]
    pub axes: AxisMap,
    /// m/s^2 or g
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "UNIT",
            default_value = "m/s^2",
            hide_possible_values = true
        )
    )]
    pub output_unit: OutputUnit,
}

/// Unit in which calibrated specific force is written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum OutputUnit {
    /// m/s².
    #[default]
    #[serde(rename = "m/s^2", alias = "m/s2", alias = "mps2")]
    #[cfg_attr(feature = "clap", value(name = "m/s^2", aliases = ["m/s2", "mps2"]))]
    MetrePerSecondSquared,
    /// Standard gravity, 9.80665 m/s².
    #[serde(rename = "g")]
    #[cfg_attr(feature = "clap", value(name = "g"))]
    StandardGravity,
}

impl OutputUnit {
    /// Name in files and options.
    pub fn name(self) -> &'static str {
        ["m/s^2", "g"][self as usize]
    }

    /// Names of the columns, by which they are recognised as calibrated.
    pub fn columns(self) -> [&'static str; 3] {
        CALIBRATED[self as usize]
    }

    /// One m/s² in this unit.
    fn per_mps2(self) -> f64 {
        [1.0, 1.0 / STANDARD_GRAVITY_MPS2][self as usize]
    }
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
    /// Reason
    pub reason: Reason,
    /// Number of lines.
    pub lines: u64,
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
/// The first 262,144 rows are held and judged as [`read`](crate::recording::read) judges a
/// recording; nothing is written before that. The others are read alike and not judged, so that memory
/// stays flat and a pipe flows. A row of another sensor or of zeros, and in the first rows one of a
/// sensor that hung, stays a row without calibrated values.
///
/// Values have six decimals, in the unit of the options. The delimiter is that of the input; white
/// space becomes a tab. Decimal commas are kept.
///
/// With `gyro` the recording is held as a whole ([`join_gyroscope`]). The calibrated angular rate is
/// appended as columns; rows without a reading of the gyroscope nearby have none.
///
/// # Errors
///
/// `unit-mismatch` (input) if the calibration is for another unit or range, or if calibrated
/// gravity is off by more than a fifth; what [`read`](crate::recording::read) refuses;
/// `header-differs` (input) for another header in the middle, with its line. With `gyro` those of [`join_gyroscope`], and `gyro-not-calibrated` (usage)
/// if the calibration has no gyroscope. Errors of reading and writing.
pub fn apply(
    calibration: &Calibration,
    input: Input,
    name: &str,
    out: &mut dyn Write,
    options: &ApplyOptions,
) -> Result<ApplySummary> {
    let gyro = options.gyro.as_deref();
    if gyro.is_some() && calibration.gyroscope.is_none() {
        return Err(Problem::GyroNotCalibrated.error().of_option("gyro"));
    }
    let table = |format: &Format| table(calibration, format, options);
    let copied = |format: &Format| table(format).copied().to_vec();
    let (read, head_rows) = match gyro {
        Some(_) => (options.read.beside_gyroscope_file(), Stream::WHOLE),
        None => (options.read.clone(), Stream::HEAD_ROWS),
    };
    let mut stream = Stream::open(input, name, &read, head_rows, copied)?;
    if let Some(gyro) = gyro {
        join_gyroscope(&mut stream.recording, gyro, &options.read)?;
    }
    let table = table(&stream.format);
    let mut applied = Application::begin(calibration, &mut stream.recording, options)?;
    applied.summary.columns.clone_from(&table.names);
    let (mut recording, written) = write_rows(stream, out, table, |piece| {
        applied.calibrate(piece);
        let gyro = piece.gyro.take();
        let accel = std::mem::take(&mut piece.accel).into_iter();
        accel.chain(gyro.into_iter().flatten()).collect()
    })?;
    applied.summary.findings.append(&mut recording.findings);
    Ok(applied.finish(&recording, written))
}

/// Columns of the output.
fn table(calibration: &Calibration, format: &Format, options: &ApplyOptions) -> Table {
    let accel = options.output_unit.columns().into_iter();
    let accel = accel.zip(format.accel.map(Some));
    let gyro = match format.gyro.filter(|_| calibration.gyroscope.is_some()) {
        _ if options.gyro.is_some() => Some([None; 3]),
        gyro => gyro.map(|columns| columns.map(Some)),
    };
    let rates = RATES.into_iter().zip(gyro.into_iter().flatten());
    let columns = accel.chain(rates);
    let columns = columns.map(|(name, replaces)| (name.to_owned(), replaces));
    let columns: Vec<_> = columns.collect();
    Table::with_new(format, &columns, DECIMALS, options.keep_raw)
}

/// Calibrated channels of a recording in memory.
#[derive(Debug, Clone)]
pub struct Applied {
    /// Specific force along x, y, z, in the unit of the options; NaN where a value is missing.
    pub accel: [Vec<f64>; 3],
    /// Angular rate about x, y, z, rad/s; none if the recording or the calibration has no
    /// gyroscope.
    pub gyro: Option<[Vec<f64>; 3]>,
    /// What was done, and what is odd. Its columns are those of the calibrated channels.
    pub summary: ApplySummary,
}

/// Applies `calibration` to all rows of a recording in memory, with the checks of [`apply`], which
/// writes the same values with six decimals. A gyroscope that was joined from a second file is
/// calibrated with it.
///
/// # Errors
///
/// `unit-mismatch` (input) if the calibration is for another unit or range, or if calibrated
/// gravity is off by more than a fifth; `averaged` (usage) if its rows are means of samples.
///
/// # Example
///
/// ```
/// use gravical::apply::{ApplyOptions, apply_recording};
/// use gravical::calibrate::{CalibrateOptions, Method, calibrate};
/// use gravical::recording::{ReadOptions, read_bytes};
///
/// let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
///            -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
/// let means = read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default())?;
/// let mut options = CalibrateOptions::default();
/// options.estimate.method = Method::Ferraris;
/// let file = calibrate(&[means.clone()], &options)?.calibration;
/// let applied = apply_recording(&file, &means, &ApplyOptions::default())?;
/// assert!((applied.accel[2][5] - 9.80665).abs() < 1e-3);
/// # Ok::<(), gravical::Error>(())
/// ```
pub fn apply_recording(
    calibration: &Calibration,
    recording: &Recording,
    options: &ApplyOptions,
) -> Result<Applied> {
    options.read.validate()?;
    recording.refuse_averaged("use `apply`, which reads the file")?;
    let mut recording = recording.clone();
    let mut applied = Application::begin(calibration, &mut recording, options)?;
    let rows = recording.rows();
    let mut piece = Piece {
        is_measured: vec![true; rows],
        accel: std::mem::take(&mut recording.accel),
        gyro: recording.gyro.take(),
        temperature_c: recording.temperature_c.take(),
        lines: recording.lines.clone(),
        ..Piece::default()
    };
    applied.calibrate(&mut piece);
    let rates = RATES.into_iter().filter(|_| piece.gyro.is_some());
    let columns = options.output_unit.columns().into_iter().chain(rates);
    applied.summary.columns = columns.map(str::to_owned).collect();
    Ok(Applied {
        summary: applied.finish(&recording, rows),
        accel: piece.accel,
        gyro: piece.gyro,
    })
}

/// A calibration on its way over the rows of a recording.
struct Application {
    /// What is known before the first row, and counted since.
    summary: ApplySummary,
    accel: LinearCalibration<f64>,
    /// `None` if the gyroscope is not calibrated.
    gyro: Option<GyroscopeCalibration<f64>>,
    /// What was subtracted from the values of the file, in whose unit the calibration is.
    zero_offset: f64,
    axes: AxisMap,
    /// Temperature drift, subtracted before calibrating.
    drift: Option<Drift>,
}

impl Application {
    /// Judges whether the calibration fits the recording, whose findings are taken.
    fn begin(
        calibration: &Calibration,
        recording: &mut Recording,
        options: &ApplyOptions,
    ) -> Result<Self> {
        let mut findings = std::mem::take(&mut recording.findings);
        let drift = Drift::new(calibration, recording, &mut findings);
        let quiet_norm_mps2 =
            judge_accelerometer(calibration, recording, drift.as_ref(), &mut findings)?;
        let gyro_unit = judge_gyroscope(calibration, recording, &mut findings)?;
        findings.extend(calibration.poor_finding());
        let case = |by_board| CalibrationCase::CalibratedForApply { by_board };
        findings.extend(already_calibrated(recording, case));
        let summary = ApplySummary {
            input: recording.name.clone(),
            description: String::new(),
            lines: 0,
            rows: 0,
            rows_without_acceleration: 0,
            set_aside: Vec::new(),
            accelerometer: recording.units.accel,
            output_unit: options.output_unit,
            gyroscope: match gyro_unit {
                Some(unit) => GyroscopeOutcome::Calibrated(unit),
                None if recording.gyro.is_some() => GyroscopeOutcome::Kept,
                None => GyroscopeOutcome::Absent,
            },
            temperature: None,
            quiet_norm_mps2,
            gravity_mps2: calibration.gravity_mps2,
            columns: Vec::new(),
            findings,
        };
        Ok(Application {
            summary,
            accel: calibration.accelerometer_calibration(),
            gyro: gyro_unit.and(calibration.gyroscope_calibration()),
            zero_offset: recording.units.zero_offset,
            axes: options.axes,
            drift,
        })
    }

    /// Calibrates rows in place: specific force in the unit of the output, angular rate in rad/s.
    /// All axes of a sensor are NaN if one is missing. Without a calibration of the gyroscope its
    /// channels are dropped.
    fn calibrate(&mut self, piece: &mut Piece) {
        if let Some(drift) = &mut self.drift {
            drift.subtract(piece);
        }
        let gyro = self.gyro.as_ref();
        let is_sensitive =
            gyro.is_some_and(|g| g.g_sensitivity.iter().flatten().any(|v| *v != 0.0));
        piece.gyro = piece.gyro.take().filter(|_| gyro.is_some());
        let [ax, ay, az] = &mut piece.accel;
        let mut rates = piece.gyro.as_mut();
        let (rate_axes, per_mps2) = (self.axes.of_rates(), self.summary.output_unit.per_mps2());
        for row in 0..ax.len() {
            let raw = [ax[row], ay[row], az[row]].map(|v| v + self.zero_offset);
            let accel = self.accel.apply(raw);
            if let (Some(gyro), Some([gx, gy, gz])) = (gyro, &mut rates) {
                let raw = [gx[row], gy[row], gz[row]];
                let rate = gyro.apply(raw, if is_sensitive { accel } else { [0.0; 3] });
                [gx[row], gy[row], gz[row]] = complete(rate_axes.to_case(rate));
            }
            let accel = complete(self.axes.to_case(accel));
            self.summary.rows_without_acceleration += u64::from(accel[0].is_nan());
            [ax[row], ay[row], az[row]] = accel.map(|v| v * per_mps2);
        }
    }

    /// The summary, after the last row.
    fn finish(self, recording: &Recording, rows: usize) -> ApplySummary {
        let mut summary = self.summary;
        let drift = self.drift;
        summary.temperature = drift.map(|d| d.finish(&mut summary.findings));
        for finding in &mut summary.findings {
            finding.file = Some(recording.name.clone());
        }
        summary.description = recording.format.describe();
        summary.lines = recording.ledger.lines as u64;
        summary.rows = rows as u64;
        summary.set_aside = set_aside(&recording.ledger);
        summary
    }
}

/// Judges the accelerometer by the rows of `recording`: the first of a file, or all. Returns the
/// calibrated magnitude in the quietest of them, m/s²; none if no row is complete.
///
/// # Errors
///
/// `unit-mismatch` as in [`apply`].
fn judge_accelerometer(
    calibration: &Calibration,
    recording: &Recording,
    drift: Option<&Drift>,
    findings: &mut Vec<Finding>,
) -> Result<Option<f64>> {
    let accelerometer = calibration.accelerometer_calibration();
    let mut axes: [Vec<f64>; 3] = Default::default();
    for row in 0..recording.rows() {
        let mut raw = recording
            .accel_at(row)
            .map(|v| v + recording.units.zero_offset);
        let t_c = recording.temperature_c.as_ref().map(|t| t[row]);
        if let (Some(drift), Some(t_c)) = (drift, t_c.filter(|t| t.is_finite())) {
            let at = drift.model.drift_at(t_c);
            raw = std::array::from_fn(|axis| raw[axis] - at[axis]);
        }
        let calibrated = accelerometer.apply(raw);
        for (axis, value) in axes.iter_mut().zip(calibrated) {
            axis.push(value);
        }
    }
    let norm_mps2 = quiet_norm(axes.each_ref().map(Vec::as_slice));
    let quietest = format!("the quietest parts of its first {} rows", recording.rows());
    let (at_rest, gravity_mps2) = ((&*quietest, norm_mps2), calibration.gravity_mps2);
    judge_unit(calibration, recording, at_rest, gravity_mps2, findings)?;
    Ok(norm_mps2)
}

/// The unit of the gyroscope, if it is to be calibrated: by the rule of `gyro_unit`, without
/// turns where only the head is known.
fn judge_gyroscope(
    calibration: &Calibration,
    recording: &Recording,
    findings: &mut Vec<Finding>,
) -> Result<Option<GyroUnit>> {
    let Some(section) = &calibration.gyroscope else {
        return Ok(None);
    };
    let rests = if recording.gyro_file.is_some() {
        find_rests(recording)
    } else {
        std::iter::once(0..recording.rows()).collect()
    };
    let Some(scale) = gyro_unit::judge(recording, Some(section), &rests, findings) else {
        return Ok(None);
    };
    let Some(why) = gyro_unit::mismatch(section, &scale) else {
        return Ok(Some(section.input_unit));
    };
    let error = Problem::GyroMismatch { why }.error();
    let error = error.at(Path::new(&recording.name), None);
    Err(error.advise("gyro_unit", section.input_unit.name()))
}

/// NaN on all axes if one is missing.
fn complete(axes: [f64; 3]) -> [f64; 3] {
    let is_complete = (axes[0] + axes[1] + axes[2]).is_finite();
    if is_complete { axes } else { [f64::NAN; 3] }
}

pub(crate) fn set_aside(ledger: &Ledger) -> Vec<SetAside> {
    let reasons = ledger.counts();
    reasons
        .map(|(reason, lines)| SetAside { reason, lines })
        .collect()
}
