//! The judgement of a check and its reasons.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use super::LIMIT_WITHOUT_COVARIANCE_MG;
use super::types::{CheckVerdict, ChiSquare, Coverage, GyroscopeCheck, Judgement};
use crate::calibration_file::GravitySource;
use crate::compare::SIGNIFICANCE;
use crate::gravity::Gravity;

/// What the judgement rests on.
pub(super) struct Evidence<'a> {
    pub judgement: Judgement,
    pub test: Option<ChiSquare>,
    pub single_fault_p_value: Option<f64>,
    pub p_value: Option<f64>,
    pub rms_mps2: f64,
    pub predicted_mps2: Option<f64>,
    /// The calibration was fitted to every interval that counts.
    pub own: bool,
    pub gravity: &'a Gravity,
    pub coverage: &'a Coverage,
    pub gyroscope: Option<&'a GyroscopeCheck>,
}

fn mg(mps2: f64) -> f64 {
    1000.0 * mps2 / STANDARD_GRAVITY_MPS2
}

pub(super) fn judge(p_value: Option<f64>, rms_mps2: f64) -> Judgement {
    match p_value {
        Some(p) if p < SIGNIFICANCE => Judgement::DoesNotFit,
        Some(_) => Judgement::Fits,
        None if mg(rms_mps2) > LIMIT_WITHOUT_COVARIANCE_MG => Judgement::DoesNotFit,
        None => Judgement::Undecided,
    }
}

/// The reasons: errors, test, what it rests on, what was not tested, the gyroscope.
pub(super) fn verdict(e: &Evidence<'_>) -> CheckVerdict {
    let rms = mg(e.rms_mps2);
    let mut reasons = Vec::new();
    if e.own {
        reasons.push(
            "the calibration was fitted to these static intervals, which therefore cannot test it: record the sensor at rest again"
                .to_owned(),
        );
    }
    match (e.test, e.predicted_mps2) {
        (Some(test), Some(predicted)) => {
            reasons.push(format!(
                "‖a‖ is off by {rms:.2} mg rms; its uncertainty predicts {:.2} mg rms",
                mg(predicted)
            ));
            reasons.push(by_chance(e, test));
        }
        _ => reasons.push(format!(
            "‖a‖ is off by {rms:.2} mg rms; the file has no covariance, so only errors above {LIMIT_WITHOUT_COVARIANCE_MG} mg count as a misfit"
        )),
    }
    reasons.push(e.coverage.text.clone());
    if e.gravity.source == GravitySource::Standard {
        reasons.push(format!(
            "gravity is assumed: an error of scale that all axes share is not detected up to about {:.0} mg; --latitude or --gravity tests it, too",
            mg(2.0 * e.gravity.uncertainty_mps2())
        ));
    }
    reasons.extend(e.gyroscope.map(gyroscope));
    CheckVerdict {
        judgement: e.judgement,
        reasons,
    }
}

/// How probable such errors are, in words.
fn by_chance(e: &Evidence<'_>, test: ChiSquare) -> String {
    let p = e.p_value.unwrap_or(test.p_value);
    let all = test.statistic();
    match e.single_fault_p_value {
        Some(single) if 2.0 * single < SIGNIFICANCE && 2.0 * test.p_value >= SIGNIFICANCE => {
            format!(
                "one fault (a changed scale, or a changed bias of one axis) explains the errors better than chance: {}, below {SIGNIFICANCE}; all intervals together would pass ({all})",
                ChiSquare::probability(p)
            )
        }
        _ => {
            let limit = match e.judgement {
                Judgement::DoesNotFit => format!("below {SIGNIFICANCE}"),
                Judgement::Fits | Judgement::Undecided => {
                    format!("the limit is {SIGNIFICANCE}")
                }
            };
            format!(
                "probability of such errors if the calibration fits: {}, {limit} ({all})",
                ChiSquare::probability(p)
            )
        }
    }
}

/// The gyroscope, which is judged by itself.
fn gyroscope(g: &GyroscopeCheck) -> String {
    let largest = g.rate_deg_s.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
    let limit = g.limit_deg_s;
    match g.judgement {
        Judgement::Fits => format!(
            "gyroscope: its bias fits, the rate at rest is {largest:.2} °/s at most (limit {limit} °/s)"
        ),
        Judgement::DoesNotFit => format!(
            "gyroscope: its bias has changed, the rate at rest is up to {largest:.2} °/s (limit {limit} °/s); it changes with every power-up and with temperature, and is not part of the verdict on the accelerometer"
        ),
        Judgement::Undecided => {
            format!("gyroscope: too short or unsteady to test its bias against {limit} °/s")
        }
    }
}
