//! What each target needs beside the values that all share.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use super::ExportOptions;
use super::diagonal::fit_diagonal;
use super::sensor::{Sensor, round_counts};
use super::template::Values;
use crate::calibration_file::{CalibrationFile, to_imucal};
use crate::escape::shown_json;
use crate::{Error, Result};

/// The registers of an MPU6050 in steps of two units of 1/2048 g, since the lowest bit of each has
/// another meaning.
const MPU6050_STEPS_PER_G: f64 = 1024.0;

/// The registers hold ±16 g.
const MAX_MPU6050_STEPS: f64 = 16.0 * MPU6050_STEPS_PER_G;

/// An export in the making.
pub(super) struct Draft<'a> {
    pub file: &'a CalibrationFile,
    pub options: &'a ExportOptions,
    pub accelerometer: Sensor,
    pub gyroscope: Option<Sensor>,
    pub values: Values,
    pub notes: Vec<String>,
}

impl Draft<'_> {
    fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// Only this program's own file holds the drift.
    fn note_drift(&mut self) {
        if self.file.temperature_model.is_some() {
            self.note("Without the drift with temperature, which `gravical apply` corrects.");
        }
    }

    fn note_gyroscope(&mut self, instead: &str) {
        self.note_drift();
        if self.gyroscope.is_some() {
            self.note(format!("Without the gyroscope: {instead}."));
        }
    }

    /// Makes the accelerometer take raw values in m/s².
    fn take_nominal(&mut self) -> Result<()> {
        let a = &mut self.accelerometer;
        let per_g = a.per_unit.ok_or_else(|| {
            let message = format!("this target takes m/s², and the calibration is for {} of unknown nominal scale", a.unit);
            Error::input("export-unit", message)
                .with_hint("calibrate with the range, which gives the counts their nominal scale; or export to c, which takes the counts themselves")
                .advise("accel_range", "")
        })?;
        a.subtract_zero_offset();
        a.rescale(per_g / a.unit_size);
        Ok(())
    }

    /// The diagonal model of an autopilot; `without_id`: what to do without the id of the sensor.
    fn fill_autopilot(&mut self, without_id: &str) -> Result<()> {
        self.take_nominal()?;
        let mut d = fit_diagonal(&self.accelerometer, None)?;
        self.note(d.loss.describe("cross-axis terms"));
        if let Some(rotation) = self.options.rotation {
            d.offset = rotation.to_case(d.offset);
            // Scales turn with their axes, but have no sign.
            d.scale = rotation.to_case(d.scale).map(f64::abs);
            self.note(format!(
                "The sensor's {rotation} are the vehicle's x, y, z."
            ));
        } else if d.is_turned {
            self.note("The calibration turns the sensor's axes; these values are for the axes of the sensor. Set the orientation of the sensor in the autopilot, too.");
        }
        self.note_gyroscope("the autopilot measures its bias itself");
        for (key, vector) in [("offset", d.offset), ("scale", d.scale)] {
            for (i, value) in vector.iter().enumerate() {
                self.values
                    .text(&format!("{key}{i}"), format!("{value:.9}"));
            }
        }
        match self.options.device_id {
            // The parameters are signed numbers with the same bits.
            Some(id) => self.values.text("device_id", id.cast_signed().to_string()),
            None => self.note(without_id),
        }
        Ok(())
    }
}

pub(super) fn full(draft: &mut Draft<'_>) -> Result<()> {
    draft.note_drift();
    Ok(())
}

pub(super) fn arduino(draft: &mut Draft<'_>) -> Result<()> {
    draft.note_drift();
    let given = draft.options;
    let mut are_counts = fill_sketch(
        &mut draft.values,
        &mut draft.accelerometer,
        given.counts_per_g,
    )?;
    if let Some(gyroscope) = &mut draft.gyroscope {
        are_counts &= fill_sketch(&mut draft.values, gyroscope, given.counts_per_deg_s)?;
    }
    if !are_counts {
        draft.note("For the raw counts of a sensor give the counts per g (16384 for ±2 g) and per °/s (131 for ±250 °/s).");
    }
    Ok(())
}

/// Raw values of a sketch: signed counts, or those of the recordings. Says whether they are counts.
fn fill_sketch(values: &mut Values, sensor: &mut Sensor, counts: Option<f64>) -> Result<bool> {
    let zero_offset = sensor.zero_offset;
    sensor.subtract_zero_offset();
    match counts {
        Some(counts) => sensor.take_counts(counts)?,
        None => sensor.describe_counts(),
    }
    if zero_offset != 0.0 && counts.is_none() {
        // Unsigned counts do not fit into 16 bits with a sign.
        sensor.unit += &format!(", less {zero_offset}");
    }
    if let Some(counts) = sensor.per_unit.filter(|_| sensor.is_counts) {
        let key = format!("{}_counts_per_unit", sensor.key);
        values.text(&key, format!("{:?}", round_counts(counts)));
    }
    Ok(sensor.is_counts)
}

/// imu_calib: `SM · raw − bias`, raw in m/s².
pub(super) fn ros(draft: &mut Draft<'_>) -> Result<()> {
    draft.take_nominal()?;
    draft.note_gyroscope(
        "imu_calib measures its bias at rest when it starts (parameter calibrate_gyros)",
    );
    Ok(())
}

pub(super) fn ros2(draft: &mut Draft<'_>) -> Result<()> {
    // The name of a node.
    let name = draft.options.name.as_deref().unwrap_or("imu_apply");
    draft.values.text("name", name);
    draft.take_nominal()?;
    draft.note_drift();
    if let Some(mut gyroscope) = draft.gyroscope.take() {
        // The file does not give the nominal scale of a gyroscope's counts.
        if let Some(per_deg_s) = gyroscope.per_unit {
            gyroscope.rescale(per_deg_s / gyroscope.unit_size);
            draft.gyroscope = Some(gyroscope);
        } else {
            draft.note("Without the gyroscope: the nominal scale of its counts is not known.");
        }
    }
    Ok(())
}

pub(super) fn kalibr(draft: &mut Draft<'_>) -> Result<()> {
    let noise = draft.file.noise.as_ref().ok_or_else(|| {
        Error::input("noise-unknown", "kalibr's imu.yaml holds noise densities and random walks only, and this calibration contains neither")
            .with_hint("export the result of `gravical noise`, or calibrate with it")
            .advise("noise", "noise.json")
    })?;
    let written = super::kalibr(noise, Some(draft.file), draft.options.upper_limit)?;
    draft.values.text("text", written.text);
    draft.notes = written.notes;
    Ok(())
}

/// `(raw − OFF) · SCALE`, m/s²: a parameter file of QGroundControl.
pub(super) fn px4(draft: &mut Draft<'_>) -> Result<()> {
    draft.fill_autopilot("PX4 ignores these values unless CAL_ACC0_ID is the id of this sensor. Give this device id (the vehicle shows it in `sensor_accel`), or calibrate the vehicle once, so that it sets CAL_ACC0_ID, and load this file then.")
}

/// `(raw − OFFS) · SCAL`, m/s²: a parameter file of ArduPilot.
pub(super) fn ardupilot(draft: &mut Draft<'_>) -> Result<()> {
    draft.fill_autopilot("ArduPilot counts the accelerometer as calibrated only while INS_ACC_ID is the id of this sensor, and refuses to arm otherwise. Give this device id (parameter INS_ACC_ID of the running vehicle), or calibrate the vehicle once and load this file then.")
}

/// The hardware adds the registers to every reading. Their unit is 1/2048 g on most parts, but
/// sources disagree and clones differ: the code measures before and after, and takes the registers
/// back where the shift is not what was asked for.
pub(super) fn mpu6050(draft: &mut Draft<'_>) -> Result<()> {
    draft.take_nominal()?;
    let rest = fit_diagonal(&draft.accelerometer, Some([1.0; 3]))?;
    draft.note(rest.loss.describe("scales and cross-axis terms"));
    draft.note("The registers are lost without power: call the function at every start, with the board at rest, before the sensor is set up.");
    draft.note_gyroscope("measure its bias at rest when the sketch starts");
    for (i, offset) in rest.offset.iter().enumerate() {
        let steps = (offset / STANDARD_GRAVITY_MPS2 * MPU6050_STEPS_PER_G).round();
        if steps.abs() > MAX_MPU6050_STEPS {
            let error = Error::input(
                "export-target",
                "the bias is beyond the ±16 g of the offset registers",
            );
            return Err(error.with_hint("look whether the calibration is of an MPU6050"));
        }
        draft
            .values
            .text(&format!("steps{i}"), format!("{steps:.0}"));
    }
    Ok(())
}

pub(super) fn imucal(draft: &mut Draft<'_>) -> Result<()> {
    draft.note_drift();
    draft
        .values
        .text("text", shown_json(&to_imucal(draft.file)?));
    Ok(())
}

pub(super) fn gravical(draft: &mut Draft<'_>) -> Result<()> {
    draft.values.text("text", draft.file.to_json()?);
    Ok(())
}
