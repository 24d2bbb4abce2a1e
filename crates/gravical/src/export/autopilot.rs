//! Autopilots: PX4, ArduPilot, INAV, Betaflight. Each has an offset for each axis of the sensor,
//! and all but the last a scale.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use super::diagonal::{Diagonal, fit};
use super::header::{about, marked, without_gyroscope};
use super::{Export, ExportOptions, Target, nominal};
use crate::calibration_file::CalibrationFile;
use crate::{Error, Result};

/// Names of the axes in parameters.
const AXES: [&str; 3] = ["X", "Y", "Z"];

/// Gain of INAV that leaves a value as it is.
const INAV_UNIT_GAIN: f64 = 4096.0;

/// The largest gain that INAV's settings take.
const INAV_MOST_GAIN: f64 = 8192.0;

/// Counts per g of most drivers of INAV and Betaflight: 16 bits over ±16 g.
const COUNTS_PER_G: f64 = 2048.0;

/// The range of ArduPilot's offsets, m/s², and of its scales.
const ARDUPILOT_RANGES: (f64, [f64; 2]) = (3.5, [0.8, 1.2]);

/// The diagonal model in the axes that the autopilot calls the sensor's, and notes.
fn model(
    file: &CalibrationFile,
    options: &ExportOptions,
    without: &str,
    scale: Option<[f64; 3]>,
) -> Result<(Diagonal, Vec<String>)> {
    let mut d = fit(&nominal::accelerometer(file)?, scale)?;
    let mut notes = vec![d.loss.says(without)];
    if let Some(rotation) = options.rotation {
        d.offset = rotation.to_case(d.offset);
        // Scales turn with their axes, but have no sign.
        d.scale = rotation.to_case(d.scale).map(f64::abs);
        notes.push(format!(
            "The sensor's {rotation} are the vehicle's x, y, z."
        ));
    } else if d.turned {
        notes.push("The calibration turns the sensor's axes; these values are for the axes of the sensor. Set the orientation of the sensor in the autopilot, too.".to_owned());
    }
    notes.extend(without_gyroscope(
        file,
        "the autopilot measures its bias itself",
    ));
    Ok((d, notes))
}

/// `(raw − OFF) · SCALE`, m/s²: a parameter file of QGroundControl.
///
/// # Errors
///
/// `export-unit`, `export-target` (input).
pub(super) fn px4(file: &CalibrationFile, options: &ExportOptions) -> Result<Export> {
    let (d, mut notes) = model(file, options, "cross-axis terms", None)?;
    if options.device_id.is_none() {
        notes.push("PX4 ignores these values unless CAL_ACC0_ID is the id of this sensor. Give it with --device-id (the vehicle shows it in `sensor_accel`), or calibrate the vehicle once, so that it sets CAL_ACC0_ID, and load this file then.".to_owned());
    }
    // Types of MAVLink: 6 is int32, 9 is a float.
    let line = |name: String, value: String, kind: u8| format!("1\t1\t{name}\t{value}\t{kind}\n");
    let id = options.device_id.map(|id| {
        // The parameter is a signed number with the same bits.
        line("CAL_ACC0_ID".to_owned(), id.cast_signed().to_string(), 6)
    });
    let values = (0..3).flat_map(|i| {
        let axis = AXES[i];
        [
            line(
                format!("CAL_ACC0_{axis}OFF"),
                format!("{:.9}", d.offset[i]),
                9,
            ),
            line(
                format!("CAL_ACC0_{axis}SCALE"),
                format!("{:.9}", d.scale[i]),
                9,
            ),
        ]
    });
    let text = format!(
        "# Onboard parameters for Vehicle 1\n#\n# Stack: PX4 Pro\n#\n{}#\n# Vehicle-Id Component-Id Name Value Type\n{}",
        marked("#", &about(file, Target::Px4, &notes)),
        id.into_iter().chain(values).collect::<String>()
    );
    Ok(Export { text, notes })
}

/// `(raw − OFFS) · SCAL`, m/s²: a parameter file of ArduPilot.
///
/// # Errors
///
/// `export-unit`, `export-target` (input).
pub(super) fn ardupilot(file: &CalibrationFile, options: &ExportOptions) -> Result<Export> {
    let (d, mut notes) = model(file, options, "cross-axis terms", None)?;
    if options.device_id.is_none() {
        notes.push("ArduPilot counts the accelerometer as calibrated only while INS_ACC_ID is the id of this sensor, and refuses to arm otherwise. Give it with --device-id (parameter INS_ACC_ID of the running vehicle), or calibrate the vehicle once and load this file then.".to_owned());
    }
    let (offset, [low, high]) = ARDUPILOT_RANGES;
    let outside = d.offset.iter().any(|o| o.abs() > offset)
        || d.scale.iter().any(|s| !(low..=high).contains(s));
    if outside {
        notes.push(format!("A value is outside of ArduPilot's range: offsets within {offset} m/s², scales from {low} to {high}. Its own calibration would refuse this sensor."));
    }
    let id = options
        .device_id
        .map(|id| format!("INS_ACC_ID,{}\n", id.cast_signed()));
    let values = (0..3).flat_map(|i| {
        let axis = AXES[i];
        [
            format!("INS_ACCOFFS_{axis},{:.9}\n", d.offset[i]),
            format!("INS_ACCSCAL_{axis},{:.9}\n", d.scale[i]),
        ]
    });
    let text = format!(
        "{}{}",
        marked("#", &about(file, Target::ArduPilot, &notes)),
        id.into_iter().chain(values).collect::<String>()
    );
    Ok(Export { text, notes })
}

/// The whole number nearest to `value`, which may not exceed `most`, 16 bits or less.
fn whole(value: f64, what: &str, most: f64) -> Result<i16> {
    let rounded = value.round();
    if rounded.abs() <= most {
        // Within the range by the check above.
        #[allow(clippy::cast_possible_truncation)]
        return Ok(rounded as i16);
    }
    Err(Error::input(
        "export-target",
        format!("{what} would be {value:.0}, and the firmware holds {most} at most"),
    )
    .with_hint("look whether the calibration is of this sensor and --counts-per-g of this board"))
}

/// Offsets in counts of the firmware.
fn offsets(d: &Diagonal, per_g: f64) -> Result<[i16; 3]> {
    let [x, y, z] = d.offset.map(|o| {
        whole(
            o / STANDARD_GRAVITY_MPS2 * per_g,
            "an offset",
            f64::from(i16::MAX),
        )
    });
    Ok([x?, y?, z?])
}

/// `(raw − zero) · gain / 4096`, counts.
///
/// # Errors
///
/// `export-unit`, `export-target` (input).
pub(super) fn inav(file: &CalibrationFile, options: &ExportOptions) -> Result<Export> {
    let per_g = options.counts_per_g.unwrap_or(COUNTS_PER_G);
    let (d, mut notes) = model(file, options, "cross-axis terms", None)?;
    notes.push(counts_note(per_g));
    let zero = offsets(&d, per_g)?;
    let [x, y, z] = d
        .scale
        .map(|s| whole(s * INAV_UNIT_GAIN, "a gain", INAV_MOST_GAIN));
    let gain = [x?, y?, z?];
    let lines = |name: &str, values: [i16; 3]| -> String {
        ["x", "y", "z"]
            .iter()
            .zip(values)
            .map(|(axis, v)| format!("set {name}_{axis} = {v}\n"))
            .collect()
    };
    let text = format!(
        "{}{}{}save\n",
        marked("#", &about(file, Target::Inav, &notes)),
        lines("acczero", zero),
        lines("accgain", gain)
    );
    Ok(Export { text, notes })
}

/// `raw − trim`, counts, after the firmware has turned the sensor's axes to the board's.
///
/// # Errors
///
/// `export-unit`, `export-target` (input).
pub(super) fn betaflight(file: &CalibrationFile, options: &ExportOptions) -> Result<Export> {
    let per_g = options.counts_per_g.unwrap_or(COUNTS_PER_G);
    let without = "scales and cross-axis terms";
    let (d, mut notes) = model(file, options, without, Some([1.0; 3]))?;
    notes.push(counts_note(per_g));
    if options.rotation.is_none() {
        notes.push("Betaflight subtracts after it has turned the sensor's axes to the board's: give --rotation unless align_acc is CW0.".to_owned());
    }
    let [x, y, z] = offsets(&d, per_g)?;
    // The fourth number marks the calibration as done.
    let text = format!(
        "{}set acc_calibration = {x},{y},{z},1\nsave\n",
        marked("#", &about(file, Target::Betaflight, &notes)),
    );
    Ok(Export { text, notes })
}

fn counts_note(per_g: f64) -> String {
    format!("For a board that reads {per_g} counts per g (--counts-per-g).")
}
