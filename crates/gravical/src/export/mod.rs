//! A calibration in the form of another program: code, parameters, registers.
//!
//! Canonical is `calibrated = matrix · (raw − bias)`; every target has its own formula, sign and
//! unit, which `docs/exports.md` lists with the version they were read in. A target is a text in
//! `templates/` and a row of [`TARGETS`]. What it cannot hold is in the notes of the result and in
//! a comment of its text, never silently dropped.

mod diagonal;
mod fill;
mod kalibr;
mod sensor;
mod template;

use crate::calibration_file::CalibrationFile;
use crate::numfmt;
use crate::poses::face::AxisMap;
use crate::recording::units::AccelUnit;
use crate::{Error, Result};
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use serde::Deserialize;

pub use kalibr::kalibr;

use fill::Draft;
use sensor::Sensor;
use template::{Values, fill_template, nine_digits};

/// A form that a calibration can be written in.
pub struct Target {
    /// Name in options.
    pub name: &'static str,
    /// In a line: what it is, what it holds, and what is lost.
    pub holds: &'static str,
    /// Options that it takes.
    options: &'static [&'static str],
    template: &'static str,
    /// Adds values that only this target has, and notes on what it cannot hold.
    fill: fn(&mut Draft<'_>) -> Result<()>,
}

const KALIBR: &str = include_str!("templates/kalibr.yaml.in");

/// All targets, one a row.
#[rustfmt::skip]
pub static TARGETS: [Target; 13] = [
    Target { name: "c", options: &["name"], template: include_str!("templates/c.h.in"), fill: fill::full,
        holds: "header for C99 and C++: accelerometer and gyroscope in full, float" },
    Target { name: "arduino", options: &["name", "counts_per_g", "counts_per_deg_s"], template: include_str!("templates/arduino.h.in"), fill: fill::arduino,
        holds: "header for a sketch: accelerometer and gyroscope in full, float" },
    Target { name: "rust", options: &[], template: include_str!("templates/rust.rs.in"), fill: fill::full,
        holds: "module without the standard library: accelerometer and gyroscope in full, f32" },
    Target { name: "python", options: &["name"], template: include_str!("templates/python.py.in"), fill: fill::full,
        holds: "functions on NumPy arrays: accelerometer and gyroscope in full" },
    Target { name: "matlab", options: &[], template: include_str!("templates/matlab.m.in"), fill: fill::full,
        holds: "function for MATLAB and Octave: accelerometer and gyroscope in full" },
    Target { name: "ros", options: &[], template: include_str!("templates/ros.yaml.in"), fill: fill::ros,
        holds: "YAML of imu_calib (ROS 1 and 2): accelerometer in full, no gyroscope" },
    Target { name: "ros2", options: &["name"], template: include_str!("templates/ros2.yaml.in"), fill: fill::ros2,
        holds: "parameters of a ROS 2 node, SI units: accelerometer and gyroscope in full" },
    Target { name: "kalibr", options: &["upper_limit"], template: "$text$", fill: fill::kalibr,
        holds: "imu.yaml: noise density and random walk, of a calibration with noise" },
    Target { name: "px4", options: &["device_id", "rotation"], template: include_str!("templates/px4.params.in"), fill: fill::px4,
        holds: "parameters of PX4: offset and scale of each axis; no cross-axis terms, no gyroscope" },
    Target { name: "ardupilot", options: &["device_id", "rotation"], template: include_str!("templates/ardupilot.param.in"), fill: fill::ardupilot,
        holds: "parameters of ArduPilot: offset and scale of each axis; no cross-axis terms, no gyroscope" },
    Target { name: "mpu6050", options: &["name"], template: include_str!("templates/mpu6050.h.in"), fill: fill::mpu6050,
        holds: "sketch code for the offset registers of an MPU6050: bias to 0.5 mg; no scale, no cross-axis terms, no gyroscope" },
    Target { name: "imucal", options: &[], template: "$text$", fill: fill::imucal,
        holds: "JSON of the Python library imucal, format 2.0: accelerometer and gyroscope in full, no uncertainty" },
    Target { name: "gravical", options: &[], template: "$text$", fill: fill::gravical,
        holds: "calibration file of gravical: everything (converts a file of imucal)" },
];

/// Options that some targets take; one that takes none of it refuses it.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct ExportOptions {
    /// Name in the code [default: gravical]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub name: Option<String>,
    /// The autopilot's id of this sensor (px4, ardupilot)
    #[cfg_attr(feature = "clap", arg(long, value_name = "ID"))]
    pub device_id: Option<u32>,
    /// Sensor axes along x, y, z of the autopilot's frame
    #[serde(deserialize_with = "crate::option_text::optional")]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)
    )]
    pub rotation: Option<AxisMap>,
    /// Counts per g of the sketch (arduino)
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub counts_per_g: Option<f64>,
    /// Counts per °/s of the sketch (arduino)
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub counts_per_deg_s: Option<f64>,
    /// Upper limits for what is not determined (kalibr)
    #[cfg_attr(feature = "clap", arg(long))]
    pub upper_limit: bool,
}

/// A written calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// The file.
    pub text: String,
    /// What the target cannot hold, and what to do so that it takes effect.
    pub notes: Vec<String>,
}

impl Target {
    /// The target of this name.
    pub fn find(name: &str) -> Option<&'static Target> {
        TARGETS.iter().find(|t| t.name == name)
    }

    /// Refuses options that mean nothing to this target, and values that it cannot use.
    fn check(&self, options: &ExportOptions) -> Result<()> {
        let given = [
            ("name", options.name.is_some()),
            ("device_id", options.device_id.is_some()),
            ("rotation", options.rotation.is_some()),
            ("counts_per_g", options.counts_per_g.is_some()),
            ("counts_per_deg_s", options.counts_per_deg_s.is_some()),
            ("upper_limit", options.upper_limit),
        ];
        for (option, is_given) in given {
            if is_given && !self.options.contains(&option) {
                let message = format!("means nothing to the target {}", self.name);
                let hint = match self.options {
                    [] => "leave it out; this target takes no options",
                    _ => "leave it out; this target takes others",
                };
                let error = Error::usage("export-option", message)
                    .of_option(option)
                    .with_hint(hint);
                let taken = self.options.iter();
                return Err(taken.fold(error, |error, taken| error.advise(*taken, "")));
            }
        }
        let counts = [options.counts_per_g, options.counts_per_deg_s];
        if let Some(bad) = counts
            .into_iter()
            .flatten()
            .find(|c| !(c.is_finite() && *c > 0.0))
        {
            let message = format!("{bad} counts per unit is no positive number");
            return Err(Error::usage("export-option", message)
                .with_hint("these are of an MPU6050 in the ranges ±2 g and ±250 °/s")
                .advise("counts_per_g", "16384")
                .advise("counts_per_deg_s", "131"));
        }
        options.name.as_deref().map_or(Ok(()), check_name)
    }
}

/// Longer names of functions are cut by some linkers.
const MAX_NAME: usize = 48;

/// Refuses a name that is no identifier. Names of functions only begin with it, so that a reserved
/// word does no harm.
fn check_name(name: &str) -> Result<()> {
    let is_identifier = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.len() <= MAX_NAME;
    let message = if !is_identifier {
        format!("{name} is no identifier")
    } else if name.contains("__") {
        format!("{name}: C++ reserves names with two underscores in a row")
    } else {
        return Ok(());
    };
    let hint = format!(
        "use letters, digits and underscores, a letter first, at most {MAX_NAME}: for example imu_left"
    );
    Err(Error::usage("export-name", message)
        .of_option("name")
        .with_hint(hint))
}

/// Writes `file` for `target`.
///
/// # Errors
///
/// `export-option` (usage) for an option that the target does not take, `export-name` (usage) for
/// a name that is no identifier; `export-unit` (input) where the target takes m/s² and the nominal
/// scale of the counts is unknown, or where it is clearly another than the options say;
/// `export-target` (input) where the target cannot represent the calibration at all;
/// `noise-unknown` (input) as `kalibr`; `calibration-values` (input) as
/// [`CalibrationFile::to_json`].
pub fn export(file: &CalibrationFile, target: &Target, options: &ExportOptions) -> Result<Export> {
    target.check(options)?;
    let mut draft = Draft {
        file,
        options,
        accelerometer: Sensor::accelerometer(file),
        gyroscope: Sensor::gyroscope(file),
        values: Values::new(nine_digits),
        notes: Vec::new(),
    };
    let name = options.name.as_deref().unwrap_or("gravical");
    draft.values.text("name", name);
    draft.values.text("NAME", name.to_uppercase());
    (target.fill)(&mut draft)?;
    let Draft {
        accelerometer,
        gyroscope,
        mut values,
        notes,
        ..
    } = draft;
    values.text("created", in_comment(&file.created));
    values.text("about", describe(file, target, &notes).join("\n"));
    sensor::set_values(&mut values, &accelerometer, gyroscope.as_ref());
    let text = fill_template(target.template, &values);
    Ok(Export { text, notes })
}

/// Lines about the calibration, for a comment.
fn describe(file: &CalibrationFile, target: &Target, notes: &[String]) -> Vec<String> {
    let a = &file.accelerometer;
    let sensor: Vec<&str> = [&file.sensor.model, &file.sensor.id]
        .into_iter()
        .flatten()
        .map(String::as_str)
        .collect();
    let of = if sensor.is_empty() { "" } else { " of " };
    let mut lines = vec![
        format!("Calibration{of}{}, {}", sensor.join(" "), file.created),
        format!(
            "by {}, verdict {}, for {}",
            file.tool, file.verdict.grade, target.name
        ),
        match a.nominal_per_mps2() {
            Some(nominal) if a.input_unit == AccelUnit::Counts => format!(
                "made with raw values in counts, nominally {:.0} per g",
                nominal * STANDARD_GRAVITY_MPS2
            ),
            _ => format!("made with raw values in {}", a.input_unit.name()),
        },
    ];
    if let Some(t) = file.temperature_c {
        lines.push(format!(
            "Temperature of the poses: {:.1} to {:.1} degrees Celsius",
            t.min, t.max
        ));
    }
    lines.extend_from_slice(notes);
    lines.iter().map(|l| in_comment(l)).collect()
}

/// Texts from outside cannot end a comment or a string, or continue it: other characters become
/// underscores. Units are in ASCII, since some compilers warn of others.
fn in_comment(text: &str) -> String {
    let ascii = text
        .replace('²', "^2")
        .replace('°', "deg")
        .replace('‖', "|");
    let is_harmless = |c: char| c.is_ascii_alphanumeric() || " `',;:.()+-=/^_|<>%&".contains(c);
    ascii
        .chars()
        .map(|c| if is_harmless(c) { c } else { '_' })
        .collect()
}

/// The calibration as code to paste: its language, the mark of that language in Markdown, and the
/// text.
#[doc(hidden)]
pub fn snippets(file: &CalibrationFile) -> [(&'static str, &'static str, String); 3] {
    let fill = |template: &str, write: fn(f64) -> String| {
        let mut values = Values::new(write);
        let mut accelerometer = Sensor::accelerometer(file);
        accelerometer.unit = numfmt::unit(&accelerometer.unit);
        sensor::set_values(
            &mut values,
            &accelerometer,
            Sensor::gyroscope(file).as_ref(),
        );
        if file.temperature_model.is_some() {
            values.text("drift", "1");
        }
        fill_template(template, &values)
    };
    let six_digits = |value: f64| numfmt::small(value, 6);
    [
        (
            "C",
            "c",
            fill(include_str!("templates/paste.c.in"), nine_digits),
        ),
        (
            "Python",
            "python",
            fill(include_str!("templates/paste.py.in"), nine_digits),
        ),
        (
            "Equation",
            "",
            fill(include_str!("templates/paste.txt.in"), six_digits),
        ),
    ]
}
