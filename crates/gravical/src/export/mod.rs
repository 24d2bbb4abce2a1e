//! A calibration in the form of another program: code or parameters.
//!
//! Canonical is `calibrated = matrix · (raw − bias)`; every target has its own formula, sign and
//! unit, which `docs/exports.md` lists with the version they were read in. A target is a text in
//! `templates/` and a row of [`TARGETS`]. What it cannot hold is in the notes of the result and in
//! a comment of its text, never silently dropped.

mod diagonal;
mod noise;
mod sensor;
mod template;

use crate::Result;
use crate::calibration_file::{Calibration, to_imucal};
use crate::problem::Problem;
use crate::recording::units::AccelUnit;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_judge::escape::shown_json;
use gravical_judge::numfmt;
use serde::Deserialize;

pub use noise::export_noise;

use diagonal::fit_diagonal;
use sensor::Sensor;
use template::{Values, fill_template, nine_digits};

/// A form that a calibration can be written in.
pub struct Target {
    /// Name in options.
    pub name: &'static str,
    /// Usual name of the file.
    pub file: &'static str,
    /// In a line: what it is, what it holds, and what is lost.
    pub holds: &'static str,
    /// Options that it takes.
    options: &'static [&'static str],
    form: Form,
}

/// What is written for a target.
enum Form {
    /// A template for raw values as they were recorded.
    Recorded(&'static str),
    /// A template for the counts of a sketch.
    Sketch(&'static str),
    /// A template for raw values in SI units by their nominal scale; without the gyroscope where
    /// something says what is done instead.
    Nominal(&'static str, Option<&'static str>),
    /// A text of its own.
    Text(fn(&Calibration) -> Result<String>),
    /// A template for an offset and a scale of each axis, SI units; and what to do without the id of the sensor.
    Axes(&'static str, &'static str),
    /// A template for noise, which no calibration holds.
    Noise(&'static str),
}

use Form::{Axes, Noise, Nominal, Recorded, Sketch, Text};

/// All targets, one a row.
#[rustfmt::skip]
pub static TARGETS: [Target; 13] = [
    Target { name: "c", file: "gravical.h", options: &["name"], form: Recorded(include_str!("templates/c.h.in")),
        holds: "header for C99 and C++: accelerometer and gyroscope in full, float" },
    Target { name: "arduino", file: "gravical_calibration.h", options: &["name", "counts_per_g", "counts_per_deg_s"], form: Sketch(include_str!("templates/arduino.h.in")),
        holds: "header for a sketch: accelerometer and gyroscope in full, float" },
    Target { name: "rust", file: "gravical.rs", options: &[], form: Recorded(include_str!("templates/rust.rs.in")),
        holds: "module without the standard library: accelerometer and gyroscope in full, f32" },
    Target { name: "python", file: "gravical_calibration.py", options: &["name"], form: Recorded(include_str!("templates/python.py.in")),
        holds: "functions on NumPy arrays: accelerometer and gyroscope in full" },
    Target { name: "ros", file: "imu_calib.yaml", options: &[], form: Nominal(include_str!("templates/ros.yaml.in"), Some("imu_calib measures its bias at rest when it starts (parameter calibrate_gyros)")),
        holds: "YAML of imu_calib (ROS 1 and 2): accelerometer in full, no gyroscope" },
    Target { name: "ros2", file: "gravical.yaml", options: &["name"], form: Nominal(include_str!("templates/ros2.yaml.in"), None),
        holds: "parameters of a ROS 2 node, SI units: accelerometer and gyroscope in full" },
    Target { name: "fusion", file: "gravical_fusion.h", options: &["name"], form: Recorded(include_str!("templates/fusion.h.in")),
        holds: "header for Fusion of x-io: accelerometer in full, gyroscope without its g-sensitivity, float" },
    Target { name: "px4", file: "gravical.params", options: &["device_id"], form: Axes(include_str!("templates/px4.params.in"), "PX4 ignores these values unless CAL_ACC0_ID is the id of this sensor. Give this device id (the vehicle shows it in `sensor_accel`), or calibrate the vehicle once, so that it sets CAL_ACC0_ID, and load this file then."),
        holds: "parameters of PX4: offset and scale of each axis; no cross-axis terms, no gyroscope" },
    Target { name: "ardupilot", file: "gravical.param", options: &["device_id"], form: Axes(include_str!("templates/ardupilot.param.in"), "ArduPilot counts the accelerometer as calibrated only while INS_ACC_ID is the id of this sensor, and refuses to arm otherwise. Give this device id (parameter INS_ACC_ID of the running vehicle), or calibrate the vehicle once and load this file then."),
        holds: "parameters of ArduPilot: offset and scale of each axis; no cross-axis terms, no gyroscope" },
    Target { name: "ros-noise", file: "imu_noise.yaml", options: &["upper_limit"], form: Noise(include_str!("templates/ros-noise.yaml.in")),
        holds: "covariances of sensor_msgs/Imu: white noise of both sensors, of the result of noise" },
    Target { name: "kalibr", file: "imu.yaml", options: &["upper_limit"], form: Noise(include_str!("templates/kalibr.yaml.in")),
        holds: "imu.yaml: noise density and random walk, of the result of noise" },
    Target { name: "imucal", file: "imucal.json", options: &[], form: Text(to_imucal),
        holds: "JSON of the Python library imucal, format 2.0: accelerometer and gyroscope in full, no uncertainty" },
    Target { name: "gravical", file: "calibration.json", options: &[], form: Text(Calibration::to_json),
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
    /// Counts per g of the sketch (arduino)
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub counts_per_g: Option<f64>,
    /// Counts per °/s of the sketch (arduino)
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub counts_per_deg_s: Option<f64>,
    /// Upper limits for what is not determined (kalibr, ros-noise)
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

    /// It is written of the result of `noise`, not of a calibration.
    pub fn is_noise(&self) -> bool {
        matches!(self.form, Noise(_))
    }

    /// Refuses options that mean nothing to this target, and values that it cannot use.
    ///
    /// # Errors
    ///
    /// `export-option` and `export-name` (usage).
    pub fn check(&self, options: &ExportOptions) -> Result<()> {
        let given = [
            ("name", options.name.is_some()),
            ("device_id", options.device_id.is_some()),
            ("counts_per_g", options.counts_per_g.is_some()),
            ("counts_per_deg_s", options.counts_per_deg_s.is_some()),
            ("upper_limit", options.upper_limit),
        ];
        for (option, is_given) in given {
            if is_given && !self.options.contains(&option) {
                let error = Problem::NoOption { target: self.name }.error();
                let (error, taken) = (error.of_option(option), self.options.iter());
                return Err(taken.fold(error, |error, taken| error.advise(*taken, "")));
            }
        }
        let counts = [options.counts_per_g, options.counts_per_deg_s];
        let mut counts = counts.into_iter().flatten();
        if let Some(counts) = counts.find(|c| !(c.is_finite() && *c > 0.0)) {
            let error = Problem::NoCounts { counts }.error();
            let error = error.advise("counts_per_g", "16384");
            return Err(error.advise("counts_per_deg_s", "131"));
        }
        options.name.as_deref().map_or(Ok(()), check_name)
    }
}

/// Longer names of functions are cut by some linkers.
const MAX_NAME: usize = 48;

/// Refuses a name that is no identifier. Names of functions only begin with it, so that a reserved
/// word does no harm.
fn check_name(name: &str) -> Result<()> {
    // C++ reserves names with two underscores in a row.
    let is_identifier = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.len() <= MAX_NAME
        && !name.contains("__");
    if is_identifier {
        return Ok(());
    }
    let problem = Problem::NoIdentifier {
        name: name.to_owned(),
        longest: MAX_NAME,
    };
    Err(problem.error().of_option("name"))
}

/// Writes `file` for `target`.
///
/// # Errors
///
/// `export-option` (usage) for an option that the target does not take, `export-name` (usage) for
/// a name that is no identifier; `export-unit` (input) where the target takes m/s² and the nominal
/// scale of the counts is unknown, or where it is clearly another than the options say;
/// `export-target` (input) where the axes of the sensor are not those of the target; `noise-unknown` (input) for a
/// target of noise; `calibration-values` (input) as
/// [`Calibration::to_json`].
pub fn export(file: &Calibration, target: &Target, options: &ExportOptions) -> Result<Export> {
    target.check(options)?;
    let mut accelerometer = Sensor::accelerometer(file);
    let mut gyroscope = Sensor::gyroscope(file);
    let mut notes = Vec::new();
    // Only this program's own file holds the drift.
    if file.drift.is_some() && target.name != "gravical" {
        notes.push(
            "Without the drift with temperature, which `gravical apply` corrects.".to_owned(),
        );
    }
    let template = match target.form {
        Text(write) => {
            let text = shown_json(&write(file)?).into_owned();
            return Ok(Export { text, notes });
        }
        Noise(_) => {
            let target = target.name;
            return Err(Problem::NoiseOfCalibration { target }.error());
        }
        Axes(template, _) => {
            accelerometer.take_nominal()?;
            if gyroscope.take().is_some() {
                notes.push(
                    "Without the gyroscope: the autopilot measures its bias itself.".to_owned(),
                );
            }
            template
        }
        Recorded(template) => {
            if target.name == "fusion" && gyroscope.as_ref().is_some_and(Sensor::is_coupled) {
                notes.push("Without the g-sensitivity of the gyroscope.".to_owned());
            }
            template
        }
        Sketch(template) => {
            let mut are_counts = accelerometer.take_sketch(options.counts_per_g)?;
            if let Some(gyroscope) = &mut gyroscope {
                are_counts &= gyroscope.take_sketch(options.counts_per_deg_s)?;
            }
            if !are_counts {
                notes.push("For the raw counts of a sensor give the counts per g (16384 for ±2 g) and per °/s (131 for ±250 °/s).".to_owned());
            }
            template
        }
        Nominal(template, instead) => {
            accelerometer.take_nominal()?;
            // The file does not give the nominal scale of a gyroscope's counts.
            let instead = instead.or_else(|| {
                let taken = gyroscope.as_mut().map(Sensor::take_nominal);
                let is_unknown = taken.is_some_and(|taken| taken.is_err());
                is_unknown.then_some("the nominal scale of its counts is not known")
            });
            if let Some(instead) = instead.filter(|_| gyroscope.take().is_some()) {
                notes.push(format!("Without the gyroscope: {instead}."));
            }
            template
        }
    };
    let mut values = Values::new(nine_digits);
    if let Axes(_, without_id) = target.form {
        let fitted = fit_diagonal(&accelerometer)?;
        values.vector("scale", &fitted.scale);
        notes.push(fitted.loss);
        if fitted.is_turned {
            notes.push("The calibration turns the sensor's axes; these values are for the axes of the sensor. Set the orientation of the sensor in the autopilot, too.".to_owned());
        }
        match options.device_id {
            // The parameters are signed numbers with the same bits.
            Some(id) => values.text("device_id", id.cast_signed().to_string()),
            None => notes.push(without_id.to_owned()),
        }
    }
    let is_node = target.name == "ros2";
    let name = if is_node { "imu_apply" } else { "gravical" };
    let name = options.name.as_deref().unwrap_or(name);
    values.text("name", name);
    values.text("NAME", name.to_uppercase());
    values.text("created", in_comment(&file.created));
    values.text("about", describe(file, target, &notes).join("\n"));
    sensor::set_values(&mut values, &accelerometer, gyroscope.as_ref());
    let text = fill_template(template, &values);
    Ok(Export { text, notes })
}

/// Lines about the calibration, for a comment.
fn describe(file: &Calibration, target: &Target, notes: &[String]) -> Vec<String> {
    let a = &file.accelerometer;
    let sensor = [&file.sensor.model, &file.sensor.id].into_iter().flatten();
    let sensor: String = sensor.map(|name| format!(" {name}")).collect();
    let of = if sensor.is_empty() { "" } else { " of" };
    let mut lines = vec![
        format!("Calibration{of}{sensor}, {}", file.created),
        format!(
            "by {}, verdict {}, for {}",
            file.tool,
            file.grade(),
            target.name
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
    let is_harmful = |c: char| !c.is_ascii_alphanumeric() && !" `',;:.()+-=/^_|<>%&".contains(c);
    ascii.replace(is_harmful, "_")
}

/// The calibration as code to paste: its language and the
/// text.
#[doc(hidden)]
pub fn snippets(file: &Calibration) -> [(&'static str, String); 3] {
    let fill = |template: &str, write: fn(f64) -> String| {
        let mut values = Values::new(write);
        let mut accelerometer = Sensor::accelerometer(file);
        accelerometer.unit = numfmt::unit(&accelerometer.unit);
        let gyroscope = Sensor::gyroscope(file);
        sensor::set_values(&mut values, &accelerometer, gyroscope.as_ref());
        if file.drift.is_some() {
            values.text("drift", "1");
        }
        fill_template(template, &values)
    };
    let six_digits = |value: f64| numfmt::small(value, 6);
    let c = fill(include_str!("templates/paste.c.in"), nine_digits);
    let python = fill(include_str!("templates/paste.py.in"), nine_digits);
    let equation = fill(include_str!("templates/paste.txt.in"), six_digits);
    [("C", c), ("Python", python), ("Equation", equation)]
}
