//! A calibration over a recording in memory.

use crate::Result;
use crate::calibration_file::CalibrationFile;
use crate::recording::file::HeadChannels;
use crate::recording::layout::Layout;
use crate::recording::names::Quantity;
use crate::recording::row::{ACCEL, GYRO, SLOTS, TEMPERATURE, TIME};
use crate::recording::{AccelClaim, Finding, Origin, ReadOptions, Recording};

use super::drift::Drift;
use super::judge::{Case, judge};
use super::plan::RATES;
use super::sensor::Sensor;
use super::{ApplyOptions, ApplySummary, about_calibration, gyroscope_outcome, set_aside};

/// Rows by which unit and range are judged; about those of the head of a file.
const HEAD_ROWS: usize = 1 << 13;

/// Calibrated channels of a recording.
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

/// Applies `calibration` to all rows of a recording in memory, with the checks of
/// [`apply`](super::apply), which writes the same values with six decimals. A gyroscope that was
/// joined from a second file is calibrated with it.
///
/// # Errors
///
/// `unit-mismatch` (input) if the calibration is for another unit or range, or if calibrated
/// gravity is off by more than a fifth; `all-zero`; `excerpt` (usage) if rows of the file are left
/// out.
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
/// let file = calibrate(&[means.clone()], &options)?.file;
/// let applied = apply_recording(&file, &means, &ApplyOptions::default())?;
/// assert!((applied.accel[2][5] - 9.80665).abs() < 1e-3);
/// # Ok::<(), gravical::Error>(())
/// ```
pub fn apply_recording(
    calibration: &CalibrationFile,
    recording: &Recording,
    options: &ApplyOptions,
) -> Result<Applied> {
    options.read.validate()?;
    recording.refuse_excerpt("use `apply`, which reads the file")?;
    let mut findings = recording.findings.clone();
    let drift = Drift::of_recording(calibration, recording, &mut findings);
    let read = as_read(recording, &options.read);
    let rows = recording.rows().min(HEAD_ROWS);
    let judged = judge(
        &Case {
            calibration,
            head: &head(recording, rows),
            whole: rows == recording.rows(),
            facts: &recording.known.facts,
            claim: AccelClaim {
                unit: recording.header_unit,
                lsb_per_g: recording.accel_scale.lsb_per_g,
                ..AccelClaim::default()
            },
            options: &read,
            drift: drift.as_ref(),
            name: &recording.name,
        },
        &mut findings,
    )?;
    findings.extend(about_calibration(
        calibration,
        recording.is_calibrated,
        recording.is_calibrated_by_board,
    ));
    let mut sensor =
        Sensor::new(calibration, judged.gyro.is_some(), options.axes).with_drift(drift);
    let mut accel = [(); 3].map(|()| Vec::with_capacity(recording.rows()));
    let mut gyro = judged
        .gyro
        .map(|_| [(); 3].map(|()| Vec::with_capacity(recording.rows())));
    let mut without_acceleration = 0;
    for row in 0..recording.rows() {
        let mut calibrated = sensor.calibrate(&values(recording, row), recording.line(row));
        without_acceleration += u64::from(calibrated[0].is_nan());
        options.output_unit.convert(&mut calibrated[..3]);
        for (channel, value) in accel.iter_mut().zip(calibrated) {
            channel.push(value);
        }
        for (channel, value) in gyro.iter_mut().flatten().zip(&calibrated[3..]) {
            channel.push(*value);
        }
    }
    let temperature = sensor.drift.as_ref().map(|d| d.finish(&mut findings));
    for finding in &mut findings {
        finding.file = Some(recording.name.clone());
    }
    let rates = RATES.into_iter().filter(|_| gyro.is_some());
    let columns = options.output_unit.columns().into_iter().chain(rates);
    Ok(Applied {
        summary: ApplySummary {
            input: recording.name.clone(),
            description: recording.description.clone(),
            lines: recording.ledger.lines,
            rows: recording.ledger.rows,
            rows_without_acceleration: without_acceleration,
            set_aside: set_aside(&recording.ledger),
            accelerometer: judged.accel,
            calibration_unit: calibration.accelerometer.input_unit,
            output_unit: options.output_unit,
            gyroscope: gyroscope_outcome(judged.gyro, recording.gyro.is_some()),
            temperature,
            quiet_norm_mps2: judged.quiet_norm_mps2,
            gravity_mps2: calibration.gravity_mps2,
            columns: columns.map(str::to_owned).collect(),
            findings,
        },
        accel,
        gyro,
    })
}

/// The options that the recording was read with, as far as its units tell.
fn as_read(recording: &Recording, read: &ReadOptions) -> ReadOptions {
    let scale = recording.accel_scale;
    let given = Some(scale.unit).filter(|_| scale.origin == Origin::Given);
    ReadOptions {
        accel_unit: read.accel_unit.or(given),
        ..read.clone()
    }
}

/// Values of a row as those of the file.
pub(crate) fn values(recording: &Recording, row: usize) -> [f64; SLOTS] {
    let mut values = [f64::NAN; SLOTS];
    if let Some(time) = &recording.time_s {
        values[TIME] = time[row];
    }
    for i in 0..3 {
        values[ACCEL + i] = recording.accel[i][row] + recording.zero_offset;
        if let Some(gyro) = &recording.gyro {
            values[GYRO + i] = gyro[i][row];
        }
    }
    if let Some(temperature) = &recording.temperature_c {
        values[TEMPERATURE] = temperature[row];
    }
    values
}

fn head(recording: &Recording, rows: usize) -> HeadChannels {
    let some = |channel: &Vec<f64>| channel[..rows].to_vec();
    let offset = recording.zero_offset;
    HeadChannels {
        accel: recording
            .accel
            .each_ref()
            .map(|c| c[..rows].iter().map(|v| v + offset).collect()),
        gyro: recording
            .gyro
            .as_ref()
            .map(|gyro| gyro.each_ref().map(some)),
        temperature: match &recording.temperature_c {
            Some(temperature) => some(temperature),
            None => vec![f64::NAN; rows],
        },
    }
}

impl Drift {
    /// For a recording in memory; `None` as for a file.
    pub(crate) fn of_recording(
        calibration: &CalibrationFile,
        recording: &Recording,
        findings: &mut Vec<Finding>,
    ) -> Option<Self> {
        let mut layout = Layout::default();
        if recording.temperature_c.is_some() {
            layout.fields.push((Quantity::Temperature, 0));
        }
        let rows = recording.rows().min(HEAD_ROWS);
        Drift::new(
            calibration,
            &head(recording, rows),
            &layout,
            recording.known.facts.celsius,
            recording.gyro.is_some(),
            findings,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::apply::apply;
    use crate::calibrate::{CalibrateOptions, calibrate};
    use crate::recording::open::from_reader;
    use crate::recording::read_bytes;
    use crate::simulate::{FileFormat, PosesOptions, Scenario, SimulateOptions, simulate, write};

    #[test]
    fn a_recording_in_memory_is_calibrated_as_its_file() {
        for format in [FileFormat::TrueHeader, FileFormat::Raw] {
            let folder = tempfile::tempdir().unwrap();
            let mut options = SimulateOptions::new(Scenario::Poses(PosesOptions {
                hold_s: 4.0,
                free: 8,
            }));
            options.file.format = format;
            let files = write(&simulate(&options).unwrap(), folder.path(), false).unwrap();
            let bytes = std::fs::read(&files[0]).unwrap();
            let recording = read_bytes(&bytes, "poses.csv", &ReadOptions::default()).unwrap();
            let file = calibrate(
                std::slice::from_ref(&recording),
                &CalibrateOptions::default(),
            )
            .unwrap()
            .file;
            let mut table = Vec::new();
            let options = ApplyOptions::default();
            let input = from_reader(Box::new(std::io::Cursor::new(bytes)), false).unwrap();
            let summary = apply(&file, input, "poses.csv", &mut table, &options).unwrap();
            let own = apply_recording(&file, &recording, &options).unwrap();
            assert_eq!(own.summary.rows, summary.rows);
            assert_eq!(own.summary.gyroscope, summary.gyroscope);
            assert_eq!(own.summary.accelerometer, summary.accelerometer);
            let text = String::from_utf8(table).unwrap();
            let mut lines = text.lines();
            let header: Vec<&str> = lines.next().unwrap().split(',').collect();
            let at = |name: &str| header.iter().position(|h| *h == name).unwrap();
            let fields = ["ax_mps2", "az_mps2", "gy_rad_s"].map(at);
            let gyro = own.gyro.as_ref().unwrap();
            for (row, line) in lines.enumerate() {
                let cells: Vec<&str> = line.split(',').collect();
                let values = [own.accel[0][row], own.accel[2][row], gyro[1][row]];
                for (field, value) in fields.iter().zip(values) {
                    let written: f64 = cells[*field].parse().unwrap();
                    assert!((written - value).abs() <= 0.5e-6 + 1e-12, "{line}");
                }
            }
        }
    }
}
