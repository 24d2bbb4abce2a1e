//! What [`check`](crate::check) and [`compare`](crate::compare) share: a calibration as numbers, a
//! test in words, a verdict with its reasons.

use gravical_fit::model::{BIAS, Covariance};
use gravical_fit::{SIGNIFICANCE, Sensor, Test};
use serde::Serialize;

use crate::Result;
use crate::calibration_file::Calibration;
use crate::finding::{Case, Finding};
use crate::numfmt::count;
use crate::problem::Problem;

/// Gravity that differs by less than this fraction is the same.
const SAME_GRAVITY: f64 = 1e-5;

/// A calibration without a covariance is taken to be off by this, in any direction, m/s² (10 mg):
/// six faces placed within 1° leave 8 mg, a sensor without any calibration shows 35 mg.
pub(crate) const ASSUMED_ERROR_MPS2: f64 = 0.1;

/// Level of each of the two tests of `compare`, so that both together keep 1 % (Bonferroni).
pub(crate) const PART_SIGNIFICANCE: f64 = SIGNIFICANCE / 2.0;

/// Says that two values of gravity, m/s², are not the same; `of`: whose they are.
pub(crate) fn gravity_differs(gravity_mps2: [f64; 2], of: [&str; 2]) -> Option<Finding> {
    let off = (gravity_mps2[1] / gravity_mps2[0] - 1.0).abs();
    let case = Case::GravityDiffers {
        gravity_mps2,
        of: of.map(str::to_owned),
        percent: 100.0 * off,
    };
    (off > SAME_GRAVITY).then(|| case.finding())
}

/// χ² of a difference by its covariance.
pub(crate) fn chi_square(test: &Test) -> String {
    let freedom = count(test.degrees_of_freedom, "degree");
    format!("χ² = {:.1} with {freedom} of freedom", test.chi2)
}

pub(crate) fn probability(p: f64) -> String {
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
    /// The calibration does not fit, or the two differ.
    pub fn is_change(self) -> bool {
        matches!(self, Judgement::DoesNotFit | Judgement::Differ)
    }
}

/// The judgement and its reasons.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// In a word.
    pub judgement: Judgement,
    /// Why: what was found, what was not tested.
    pub reasons: Vec<String>,
}

/// A calibration as numbers, with readings divided by `unit` once `offset` is taken off: about the input
/// units per m/s². Without a covariance an error of [`ASSUMED_ERROR_MPS2`] stands for it.
///
/// # Errors
///
/// `calibration-values` for a singular matrix; `name` is the file.
pub(crate) fn sensor(file: &Calibration, name: &str, unit: f64, offset: f64) -> Result<Sensor> {
    let assumed = || file.sensor_with(Covariance::zeros(), ASSUMED_ERROR_MPS2);
    let mut sensor = file
        .sensor()
        .or_else(assumed)
        .ok_or_else(|| Problem::Singular.error().at(name.as_ref(), None))?;
    for axis in 0..3 {
        sensor.parameters[BIAS + axis] -= offset;
    }
    Ok(sensor.rescaled(unit))
}
