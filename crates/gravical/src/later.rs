//! What [`check`](crate::check) and [`compare`](crate::compare) share: a calibration as numbers, a
//! test, a verdict with its reasons.

use std::fmt;

use gravical_fit::model::{BIAS, Covariance};
use gravical_fit::{Gravity, SIGNIFICANCE, Sensor, Test};
use serde::{Serialize, Serializer};

pub use gravical_fit::later::{Cause, Explanation};

use crate::calibration_file::{CalibrationFile, TemperatureRange};
use crate::numfmt::{decimals_for, fixed, mg, signed, unit};
use crate::{Error, Result};

/// Gravity that differs by less than this fraction is the same.
pub(crate) const SAME_GRAVITY: f64 = 1e-5;

/// A calibration without a covariance is taken to be off by this, in any direction, m/s² (10 mg):
/// six faces placed within 1° leave 8 mg, a sensor without any calibration shows 35 mg.
pub(crate) const ASSUMED_ERROR_MPS2: f64 = 0.1;

/// χ² of a difference by its covariance.
fn chi_square(test: &Test) -> String {
    let (chi2, n) = (test.chi2, test.degrees_of_freedom);
    let s = if n == 1 { "" } else { "s" };
    format!("χ² = {chi2:.1} with {n} degree{s} of freedom")
}

fn probability(p: f64) -> String {
    match p {
        p if p < 1e-4 => "p < 0.0001".to_owned(),
        p => format!("p = {p:.*}", if p < 0.095 { 4 } else { 2 }),
    }
}

/// In a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judgement {
    /// `check`: the errors are within what its uncertainty allows.
    Fits,
    /// `check`: they are larger.
    DoesNotFit,
    /// `compare`: the difference is within the uncertainty.
    Agree,
    /// `compare`: it is larger.
    Differ,
    /// Nothing tells.
    Undecided,
}

impl Judgement {
    /// As it is written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Judgement::Fits => "fits",
            Judgement::DoesNotFit => "does not fit",
            Judgement::Agree => "agree",
            Judgement::Differ => "differ",
            Judgement::Undecided => "undecided",
        }
    }

    /// The calibration does not fit, or the two differ.
    #[must_use]
    pub fn is_change(self) -> bool {
        matches!(self, Judgement::DoesNotFit | Judgement::Differ)
    }
}

/// The judgement and its reasons.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// In a word.
    pub judgement: Judgement,
    /// Why: what was found, what explains it, what was not tested. Texts in JSON.
    pub reasons: Vec<Reason>,
}

/// One sentence of a verdict.
#[derive(Debug, Clone, PartialEq)]
pub enum Reason {
    /// The size of the errors of `check`, and what was expected.
    Errors {
        /// Root mean square.
        rms_mps2: f64,
        /// By the uncertainty of the calibration.
        predicted_rms_mps2: f64,
        /// The file has no covariance.
        is_assumed: bool,
    },
    /// How often chance makes such errors.
    Chance {
        /// By all together or a single fault.
        p_value: f64,
        /// By all together.
        all: Test,
    },
    /// One change explains the errors; the gravity that would do so, m/s², if it is a scale.
    Explained(Explanation, Option<f64>),
    /// No single change explains them.
    Unexplained,
    /// The calibration was fitted to these readings.
    Fitted,
    /// Axes of the case that the readings leave open.
    Untested {
        /// Not tested.
        untested: Vec<&'static str>,
        /// Up or down only.
        one_way: Vec<&'static str>,
    },
    /// Gravity is assumed, which hides errors of scale of this size, m/s².
    GravityAssumed(f64),
    /// The gyroscope: its judgement, its largest rate at rest, the limit, °/s.
    Gyroscope(Judgement, f64, f64),
    /// `compare`: a part that was tested, and what came of it.
    Part(Part, Judgement, Test),
    /// `compare`: a part that could not be tested, and why.
    NotTested(Part, &'static str),
    /// `compare`: the parameter that differs most.
    Most(ParameterDifference),
    /// `compare`: one frame is the mirror image of the other.
    Mirrored,
    /// `compare`: names or types of two sensors.
    TwoSensors([String; 2]),
    /// `compare`: the temperatures of the sessions.
    Temperatures([TemperatureRange; 2]),
}

/// What `compare` tests by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// What changes ‖a‖.
    Magnitude,
    /// How the frames are turned.
    Orientation,
}

/// One parameter of two calibrations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterDifference {
    /// `bias_x` … `scale_z`, `angle_xy` …, `rotation_x` ….
    pub name: &'static str,
    /// `m/s^2` for the bias, `%` of nominal for the scale, `deg` for angles.
    pub unit: &'static str,
    /// Value in A; null for the rotation, which is between the two.
    pub a: Option<f64>,
    /// Value in B.
    pub b: Option<f64>,
    /// B − A.
    pub difference: f64,
    /// Its standard deviation by both covariances; null without them.
    pub sigma: Option<f64>,
    /// difference / sigma.
    pub z: Option<f64>,
}

impl Serialize for Reason {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::Errors {
                rms_mps2,
                predicted_rms_mps2,
                is_assumed,
            } => {
                write!(f, "‖a‖ is off by {} mg rms; ", mg(*rms_mps2))?;
                if *is_assumed {
                    let assumed = mg(ASSUMED_ERROR_MPS2);
                    return write!(f, "the file has no covariance, so {assumed} mg are assumed");
                }
                write!(f, "its uncertainty predicts {} mg rms", mg(*predicted_rms_mps2))
            }
            Reason::Chance { p_value, all } => write!(
                f,
                "probability of such errors if the calibration fits: {}, the limit is {SIGNIFICANCE} (all errors together: {})",
                probability(*p_value),
                chi_square(all)
            ),
            Reason::Explained(e, gravity) => {
                let (what, factor, unit) = match e.cause {
                    Cause::Share => ("common scale error", 100.0, "%"),
                    Cause::BiasX => ("changed bias of x", 1.0, "m/s²"),
                    Cause::BiasY => ("changed bias of y", 1.0, "m/s²"),
                    Cause::BiasZ => ("changed bias of z", 1.0, "m/s²"),
                };
                let n = decimals_for(factor * e.sd);
                let (change, sd) = (signed(factor * e.change, n), fixed(factor * e.sd, n));
                write!(f, "a {what} explains it: {change} ± {sd} {unit}")?;
                gravity.map_or(Ok(()), |g| {
                    write!(f, "; so would a local gravity of {g:.4} m/s²")
                })
            }
            Reason::Unexplained => f.write_str(
                "neither a changed scale nor a changed bias of one axis explains it",
            ),
            Reason::Fitted => f.write_str(
                "the calibration was fitted to these static intervals, which therefore cannot test it",
            ),
            Reason::Untested { untested, one_way } => write_untested(f, untested, one_way),
            Reason::GravityAssumed(hidden) => write!(
                f,
                "gravity is assumed, which hides an error of scale of up to {:.0} mg; the latitude is enough to know it",
                crate::numfmt::milli_g(*hidden)
            ),
            Reason::Gyroscope(judgement, largest, limit) => match judgement {
                Judgement::Undecided => write!(
                    f,
                    "gyroscope: too short or unsteady to test its bias against {limit} °/s"
                ),
                Judgement::DoesNotFit => write!(
                    f,
                    "gyroscope: its bias has changed, the rate at rest is up to {largest:.2} °/s (limit {limit} °/s); it changes with every power-up"
                ),
                _ => write!(
                    f,
                    "gyroscope: its bias fits, the rate at rest is {largest:.2} °/s at most (limit {limit} °/s)"
                ),
            },
            Reason::Part(part, judgement, test) => {
                let verb = match (judgement.is_change(), part) {
                    (true, Part::Magnitude) => "differ by more than",
                    (true, Part::Orientation) => "differs by more than",
                    (false, Part::Magnitude) => "agree within",
                    (false, Part::Orientation) => "agrees within",
                };
                let p = probability(test.p_value);
                write!(f, "{part} {verb} the uncertainty: {p}, the limit is {PART_SIGNIFICANCE} ({})", chi_square(test))
            }
            Reason::NotTested(part, why) => write!(f, "{part}: not tested, {why}"),
            Reason::Most(p) => {
                let (name, sigma) = (p.name.replace('_', " "), p.sigma.unwrap_or(0.0));
                let n = decimals_for(sigma);
                let (change, sigma) = (signed(p.difference, n), fixed(sigma, n));
                write!(f, "most of all {name}, by {change} ± {sigma} {}", unit(p.unit))
            }
            Reason::Mirrored => f.write_str(
                "the orientation of the axes differs: one is the mirror image of the other",
            ),
            Reason::TwoSensors([a, b]) => write!(f, "these are two sensors, \"{a}\" and \"{b}\""),
            Reason::Temperatures([a, b]) => write!(
                f,
                "the sessions were at {:.1} °C and {:.1} °C; the bias of an MPU6050 moves by 0.5 mg (x, y) to 0.9 mg (z) per °C, which the uncertainties do not include",
                a.mean, b.mean
            ),
        }
    }
}

fn write_untested(f: &mut fmt::Formatter<'_>, none: &[&str], one_way: &[&str]) -> fmt::Result {
    if none.is_empty() && one_way.is_empty() {
        return f.write_str("every axis was tested in both directions");
    }
    if !none.is_empty() {
        let axes = if none.len() == 1 { "axis" } else { "axes" };
        write!(f, "does not test the {} {axes}", none.join(" and "))?;
    }
    if !one_way.is_empty() {
        let and = if none.is_empty() { "" } else { "; " };
        let one_way = one_way.join(" and ");
        write!(
            f,
            "{and}{one_way} pointed one way only, where bias and scale are not distinguished"
        )?;
    }
    Ok(())
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Part::Magnitude => "bias, scale and misalignment",
            Part::Orientation => "the orientation of the axes in the case",
        })
    }
}

/// Level of each of the two tests of `compare`, so that both together keep 1 % (Bonferroni).
pub(crate) const PART_SIGNIFICANCE: f64 = SIGNIFICANCE / 2.0;

/// A calibration as numbers, with readings divided by `unit` once `offset` is taken off: about the input
/// units per m/s². Without a covariance an error of [`ASSUMED_ERROR_MPS2`] stands for it.
///
/// # Errors
///
/// `calibration-values` for a singular matrix; `name` is the file.
pub(crate) fn sensor(file: &CalibrationFile, name: &str, unit: f64, offset: f64) -> Result<Sensor> {
    let section = &file.accelerometer;
    let parameters = section.parameters().ok_or_else(|| singular(name))?;
    let mut sensor = file.sensor().unwrap_or(Sensor {
        parameters,
        covariance: Covariance::zeros(),
        gravity: Gravity {
            value_mps2: file.gravity_mps2,
            sd_mps2: section.gravity_sd_mps2,
        },
        model_error_mps2: ASSUMED_ERROR_MPS2,
        tilt_freedom: f64::INFINITY,
    });
    for axis in 0..3 {
        sensor.parameters[BIAS + axis] -= offset;
    }
    Ok(sensor.rescaled(unit))
}

/// The error of a file whose numbers make no calibration.
pub(crate) fn singular(name: &str) -> Error {
    let what = "the accelerometer's matrix is singular";
    Error::input("calibration-values", what).at(name.as_ref(), None)
}
