//! A calibration in the form of another program: code, parameters, registers.
//!
//! Canonical is `calibrated = matrix · (raw − bias)`; every target has its own formula, sign and
//! unit, which `docs/exports.md` lists with the version they were read in. What a target cannot
//! hold is in the notes of the result and in a comment of its text, never silently dropped.

mod arduino;
mod autopilot;
mod code;
mod diagonal;
mod fixed;
#[doc(hidden)]
pub mod formula;
mod fusion;
mod header;
mod kalibr;
mod mpu6050;
mod nominal;
mod ros;

pub use kalibr::kalibr;

use crate::calibration_file::{CalibrationFile, to_imucal};
use crate::escape::shown_json;
use crate::segment::face::AxisMap;
use crate::{Error, Result};

use header::check_name;

/// A form that a calibration can be written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A header for C and C++.
    C,
    /// A header for a sketch: three rows of four numbers, on counts also in fixed point.
    Arduino,
    /// A module for Rust without the standard library.
    Rust,
    /// Functions on NumPy arrays.
    Python,
    /// A function of MATLAB and Octave.
    Matlab,
    /// The YAML of the ROS package imu_calib.
    Ros,
    /// Parameters of a ROS 2 node.
    Ros2,
    /// The noise file of Kalibr.
    Kalibr,
    /// Parameters of PX4.
    Px4,
    /// Parameters of ArduPilot.
    ArduPilot,
    /// Commands of INAV's command line.
    Inav,
    /// Commands of Betaflight's command line.
    Betaflight,
    /// Initialisers for x-io Fusion.
    Fusion,
    /// Offset registers of an MPU6050, as code for a sketch.
    Mpu6050,
    /// JSON of the Python library imucal, format 2.0.
    Imucal,
    /// The calibration file of this program.
    Gravical,
}

/// Options that some targets take; one that takes none of it refuses it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ExportOptions {
    /// Name in the code, an identifier [default: `gravical`; `ros2`: `imu_apply`].
    pub name: Option<String>,
    /// The autopilot's own id of the sensor (`px4`, `ardupilot`).
    pub device_id: Option<u32>,
    /// Sensor axes that point along x, y and z of the autopilot's sensor frame (`px4`,
    /// `ardupilot`, `inav`, `betaflight`).
    pub rotation: Option<AxisMap>,
    /// Counts per g of the firmware's raw values (`inav`, `betaflight`, `arduino`) [default: 2048,
    /// ±16 g; `arduino`: raw values are those of the recordings].
    pub counts_per_g: Option<f64>,
    /// Counts per °/s of the sketch's raw values (`arduino`) [default: raw values are those of the
    /// recordings].
    pub counts_per_deg_s: Option<f64>,
    /// Upper limits for noise parameters that are not determined (`kalibr`).
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

/// What is said of a target.
struct About {
    name: &'static str,
    holds: &'static str,
    options: &'static [&'static str],
}

impl Target {
    /// All targets.
    pub const ALL: [Target; 16] = [
        Target::C,
        Target::Arduino,
        Target::Rust,
        Target::Python,
        Target::Matlab,
        Target::Ros,
        Target::Ros2,
        Target::Kalibr,
        Target::Px4,
        Target::ArduPilot,
        Target::Inav,
        Target::Betaflight,
        Target::Fusion,
        Target::Mpu6050,
        Target::Imucal,
        Target::Gravical,
    ];

    fn about(self) -> About {
        let (name, holds, options): (_, _, &'static [_]) = match self {
            Target::C => (
                "c",
                "header for C99 and C++: accelerometer and gyroscope in full, float",
                &["--name"],
            ),
            Target::Arduino => (
                "arduino",
                "header for a sketch, float, of counts also fixed point: accelerometer and gyroscope in full",
                &["--name", "--counts-per-g", "--counts-per-deg-s"],
            ),
            Target::Rust => (
                "rust",
                "module without the standard library: accelerometer and gyroscope in full, f32",
                &["--name"],
            ),
            Target::Python => (
                "python",
                "functions on NumPy arrays: accelerometer and gyroscope in full",
                &["--name"],
            ),
            Target::Matlab => (
                "matlab",
                "function for MATLAB and Octave: accelerometer and gyroscope in full",
                &["--name"],
            ),
            Target::Ros => (
                "ros",
                "YAML of imu_calib (ROS 1 and 2): accelerometer in full, no gyroscope",
                &[],
            ),
            Target::Ros2 => (
                "ros2",
                "parameters of a ROS 2 node, SI units: accelerometer and gyroscope in full",
                &["--name"],
            ),
            Target::Kalibr => (
                "kalibr",
                "imu.yaml: noise density and random walk, of a calibration with noise (calibrate --noise)",
                &["--upper-limit"],
            ),
            Target::Px4 => (
                "px4",
                "parameters of PX4: offset and scale of each axis; no cross-axis terms, no gyroscope",
                &["--device-id", "--rotation"],
            ),
            Target::ArduPilot => (
                "ardupilot",
                "parameters of ArduPilot: offset and scale of each axis; no cross-axis terms, no gyroscope",
                &["--device-id", "--rotation"],
            ),
            Target::Inav => (
                "inav",
                "INAV command line: offset and gain of each axis as integers; no cross-axis terms, no gyroscope",
                &["--rotation", "--counts-per-g"],
            ),
            Target::Betaflight => (
                "betaflight",
                "Betaflight command line: offset of each axis as an integer; no scale, no cross-axis terms, no gyroscope",
                &["--rotation", "--counts-per-g"],
            ),
            Target::Fusion => (
                "fusion",
                "C initialisers for x-io Fusion, g and °/s: accelerometer and gyroscope, no g-sensitivity",
                &["--name"],
            ),
            Target::Mpu6050 => (
                "mpu6050",
                "sketch code for the offset registers of an MPU6050: bias to 0.5 mg; no scale, no cross-axis terms, no gyroscope",
                &["--name"],
            ),
            Target::Imucal => (
                "imucal",
                "JSON of the Python library imucal, format 2.0: accelerometer and gyroscope in full, no uncertainty",
                &[],
            ),
            Target::Gravical => (
                "gravical",
                "calibration file of gravical: everything (converts a file of imucal)",
                &[],
            ),
        };
        About {
            name,
            holds,
            options,
        }
    }

    /// Name in options.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.about().name
    }

    /// In a line: what it is, what it holds, and what is lost.
    #[must_use]
    pub fn holds(self) -> &'static str {
        self.about().holds
    }

    /// Refuses options that mean nothing to this target.
    fn check(self, options: &ExportOptions) -> Result<()> {
        let about = self.about();
        let given = [
            ("--name", options.name.is_some()),
            ("--device-id", options.device_id.is_some()),
            ("--rotation", options.rotation.is_some()),
            ("--counts-per-g", options.counts_per_g.is_some()),
            ("--counts-per-deg-s", options.counts_per_deg_s.is_some()),
            ("--upper-limit", options.upper_limit),
        ];
        for (option, is_given) in given {
            if is_given && !about.options.contains(&option) {
                let message = format!("{option} means nothing to the target {}", about.name);
                let hint = match about.options {
                    [] => "leave it out; this target takes no options".to_owned(),
                    some => format!("leave it out; this target takes {}", some.join(", ")),
                };
                return Err(Error::usage("export-option", message).with_hint(hint));
            }
        }
        for (option, counts, hint) in [
            (
                "--counts-per-g",
                options.counts_per_g,
                "2048 for a range of ±16 g, 4096 for ±8 g, with 16 bits",
            ),
            (
                "--counts-per-deg-s",
                options.counts_per_deg_s,
                "131 for a range of ±250 °/s, 65.5 for ±500 °/s, with an MPU6050",
            ),
        ] {
            if let Some(counts) = counts.filter(|c| !(c.is_finite() && *c > 0.0)) {
                let message = format!("{option} {counts} is no positive number");
                return Err(Error::usage("export-option", message).with_hint(hint));
            }
        }
        match &options.name {
            Some(name) => check_name(self, name),
            None => Ok(()),
        }
    }
}

/// Writes `file` for `target`.
///
/// # Errors
///
/// `export-option` (usage) for an option that the target does not take, `export-name` (usage) for
/// a name that its language refuses; `export-unit` (input) where the target takes m/s² and the
/// nominal scale of the counts is unknown, or where it is clearly another than the options say; `export-target` (input) where the target cannot
/// represent the calibration at all; `calibration-values` (input) as
/// [`CalibrationFile::to_json`].
pub fn export(file: &CalibrationFile, target: Target, options: &ExportOptions) -> Result<Export> {
    target.check(options)?;
    let name = options.name.as_deref();
    let plain = |text: String| Export {
        text,
        notes: Vec::new(),
    };
    match target {
        Target::C => Ok(code::c(file, name.unwrap_or("gravical"))),
        Target::Arduino => arduino::arduino(file, name.unwrap_or("gravical"), options),
        Target::Rust => Ok(code::rust(file, name)),
        Target::Python => Ok(code::python(file, name.unwrap_or("gravical"))),
        Target::Matlab => Ok(code::matlab(file, name.unwrap_or("gravical"))),
        Target::Ros => ros::ros(file),
        Target::Ros2 => ros::ros2(file, name.unwrap_or("imu_apply")),
        Target::Kalibr => match &file.noise {
            Some(noise) => kalibr(noise, Some(file), options.upper_limit),
            None => Err(Error::input(
                "noise-unknown",
                "kalibr's imu.yaml holds noise densities and random walks only, and this calibration contains neither",
            )
            .with_hint(
                "take them from an Allan deviation: `gravical noise REST.csv --to kalibr -o imu.yaml`; or keep them in the calibration: `gravical calibrate … --noise noise.json`",
            )),
        },
        Target::Px4 => autopilot::px4(file, options),
        Target::ArduPilot => autopilot::ardupilot(file, options),
        Target::Inav => autopilot::inav(file, options),
        Target::Betaflight => autopilot::betaflight(file, options),
        Target::Fusion => Ok(fusion::fusion(file, name.unwrap_or("gravical"))),
        Target::Mpu6050 => mpu6050::mpu6050(file, name.unwrap_or("gravical")),
        Target::Imucal => Ok(Export {
            text: shown_json(&to_imucal(file)?).into_owned(),
            notes: header::without_drift(file),
        }),
        Target::Gravical => file.to_json().map(plain),
    }
}
