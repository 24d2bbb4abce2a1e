//! What [`check`](crate::check) and [`compare`](crate::compare) share: a calibration as numbers, a
//! test in words, a verdict with its reasons.

use gravical_fit::model::{BIAS, Covariance};
use gravical_fit::{SIGNIFICANCE, Sensor, Test};
use gravical_judge::numfmt::{count, name};
use serde::Serialize;

use crate::Result;
use crate::calibration_file::{Calibration, SensorInfo};
use crate::finding::{Case, Finding};
use crate::problem::Problem;
use crate::recording::{Recording, common_serial};
use gravical_judge::utc::UtcTime;

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

fn probability(p: f64) -> String {
    match p {
        p if p < 1e-4 => "p < 0.0001".to_owned(),
        p => format!("p = {p:.*}", if p < 0.095 { 4 } else { 2 }),
    }
}

/// What a test says of two sets of parameters, or of one and new readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judgement {
    /// The difference is within the uncertainty.
    Agrees,
    /// It is larger: the calibration does not fit the readings.
    DoesNotFit,
    /// It is larger: the calibrations differ.
    Differs,
    /// Nothing tells.
    Undecided,
}

impl Judgement {
    /// Something is beyond the uncertainty.
    pub fn is_change(self) -> bool {
        matches!(self, Judgement::DoesNotFit | Judgement::Differs)
    }

    /// As in JSON: `does-not-fit`.
    pub fn name(self) -> String {
        name(&self)
    }
}

/// The judgement and its reasons.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict<J = Judgement> {
    /// The judgement.
    pub judgement: J,
    /// Why: what was found, what was not tested.
    pub reasons: Vec<String>,
}

/// Judges the test of `what` at a level, with the reason in words: a change beyond it, else agreement, unless that
/// would prove nothing because of `no_proof`.
pub(crate) fn judge(
    what: &str,
    test: Option<&Test>,
    (level, change): (f64, Judgement),
    no_proof: Option<&str>,
) -> (Judgement, String) {
    let Some(test) = test.filter(|test| test.degrees_of_freedom > 0) else {
        let why = no_proof.unwrap_or("their uncertainty determines nothing");
        return (Judgement::Undecided, format!("{what}: not tested, {why}"));
    };
    let freedom = count(test.degrees_of_freedom, "degree");
    let (p, chi2) = (probability(test.p_value), test.chi2);
    let tested = format!("{p}, the limit is {level} (χ² = {chi2:.1} with {freedom} of freedom)");
    let (judgement, verb) = match no_proof {
        _ if test.p_value < level => (change, "differ by more than"),
        None => (Judgement::Agrees, "agree within"),
        Some(why) => {
            let reason = format!("{what}: agreement would prove nothing, {why}");
            return (Judgement::Undecided, reason);
        }
    };
    let reason = format!("{what} {verb} the uncertainty: {tested}");
    (judgement, reason)
}

/// One of the two sides that are held against each other.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Side {
    /// Its sensor, as far as it is named.
    pub sensor: SensorInfo,
    /// When the session was recorded.
    pub recorded: Option<UtcTime>,
    /// When the calibration was computed, as its file says.
    pub created: Option<String>,
}

impl Side {
    pub(crate) fn of_calibration(file: &Calibration) -> Side {
        Side {
            sensor: file.sensor.clone(),
            recorded: file.recorded.map(|recorded| recorded.time),
            created: Some(file.created.clone()),
        }
    }

    pub(crate) fn of_recordings(recordings: &[Recording]) -> Side {
        let id = common_serial(recordings).ok().flatten();
        Side {
            sensor: SensorInfo { id, model: None },
            recorded: recordings.iter().filter_map(Recording::recorded_at).min(),
            created: None,
        }
    }

    /// Days from this one to a later one; none without the dates.
    pub fn days_to(&self, later: &Side) -> Option<f64> {
        let date = |side: &Side| {
            let created = side.created.as_ref();
            side.recorded.or_else(|| created?.parse().ok())
        };
        Some(date(later)?.days_since(date(self)?))
    }
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
