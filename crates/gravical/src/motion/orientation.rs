//! How the sensor points: the attitude of a motion, without its position.

use gravical_calibrate::check::Verdict;
use gravical_calibrate::recording::Finding;
use gravical_calibrate::{Error, Result};
use serde::Serialize;

use super::Motion;
use super::result::Computation;
use super::track::MotionSample;

/// Orientation over one recording: how it points at its end, and the largest uncertainties on the way.
///
/// The attitude is the rotation from the axes of the sensor, or of the case with `axes`, to a world with z up and x
/// along the sensor's x at the start, made horizontal: heading is relative to the start.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OrientationResult {
    /// How it was computed, and from what.
    #[serde(flatten)]
    pub computation: Computation,
    /// What is known, and why not more.
    pub verdict: Verdict<OrientationJudgement>,
    /// At the start and at the end.
    pub ends: Option<[Attitude; 2]>,
    /// Largest standard deviation of the tilt, degrees.
    pub largest_sigma_tilt_deg: Option<f64>,
    /// Largest standard deviation of the heading, degrees; null where it is not known at every row.
    pub largest_sigma_heading_deg: Option<f64>,
    /// What is odd.
    pub findings: Vec<Finding>,
}

/// The verdict in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum OrientationJudgement {
    /// Tilt and heading, everywhere.
    Known,
    /// Not everywhere, or no heading.
    PartlyKnown,
    /// Nowhere.
    NotKnown,
}

/// An attitude, sensor → world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Attitude {
    /// Time, s.
    pub t_s: f64,
    /// Unit quaternion w, x, y, z (Hamilton).
    pub quaternion: [f64; 4],
    /// Roll, pitch and yaw, degrees: R = R_z(yaw) R_y(pitch) R_x(roll).
    pub roll_pitch_yaw_deg: [f64; 3],
    /// Standard deviation of the tilt, the angle between true and estimated vertical, degrees.
    pub sigma_tilt_deg: Option<f64>,
    /// Standard deviation of the heading against the start, degrees.
    pub sigma_heading_deg: Option<f64>,
}

impl Motion {
    /// How the sensor points.
    ///
    /// # Errors
    ///
    /// `option-range` (usage) for the procedure of the student report, which knows no attitude.
    pub fn orientation(&self) -> Result<OrientationResult> {
        if !self.bands {
            let error = Error::range("procedure", "that of the student report knows no attitude");
            return Err(error.advise("procedure", "strapdown"));
        }
        let r = &self.result;
        let known = |value: f64| Some(value).filter(|v| v.is_finite());
        let attitude = |sample: MotionSample| {
            let [tilt, heading] = sample.attitude_sd_deg();
            Attitude {
                t_s: sample.t_s,
                quaternion: sample.state.attitude,
                roll_pitch_yaw_deg: sample.roll_pitch_yaw_deg(),
                sigma_tilt_deg: known(tilt),
                sigma_heading_deg: known(heading),
            }
        };
        let (mut ends, mut largest) = (None::<[MotionSample; 2]>, [0.0_f64; 2]);
        let (mut unknown, mut without_heading) = (0_u64, 0_u64);
        for sample in self.samples() {
            let sd = sample.attitude_sd_deg();
            unknown += u64::from(!sd[0].is_finite());
            without_heading += u64::from(!sd[1].is_finite());
            if sd[0].is_finite() {
                ends = Some([ends.map_or(sample, |e| e[0]), sample]);
            }
            // NaN is passed over.
            largest = [0, 1].map(|i| largest[i].max(sd[i]));
        }
        let rows = self.rows() as u64;
        let mut reasons = Vec::new();
        if unknown == rows {
            reasons.extend(r.verdict.reasons.first().cloned());
        } else {
            if unknown > 0 {
                let moves = (1..).zip(&r.moves).filter(|(_, m)| m.unusable.is_some());
                let moves: Vec<String> = moves
                    .map(|(number, _): (usize, _)| number.to_string())
                    .collect();
                let (moves, after) = (
                    moves.join(", "),
                    if without_heading > unknown {
                        ", nor the heading after it"
                    } else {
                        ""
                    },
                );
                reasons.push(format!(
                    "The attitude of {unknown} rows is not known (move {moves}){after}."
                ));
            }
            if !self.own.samples.has_gyro() {
                reasons.push("Without a gyroscope the heading is not known, and the tilt only about as at the rests.".to_owned());
            }
        }
        let judgement = match (unknown == rows, without_heading) {
            (true, _) => OrientationJudgement::NotKnown,
            (_, 0) => OrientationJudgement::Known,
            _ => OrientationJudgement::PartlyKnown,
        };
        let [tilt, heading] = largest.map(|v| Some(v).filter(|_| unknown < rows));
        Ok(OrientationResult {
            computation: r.computation.clone(),
            verdict: Verdict { judgement, reasons },
            ends: ends.map(|ends| ends.map(attitude)),
            largest_sigma_tilt_deg: tilt,
            largest_sigma_heading_deg: heading.filter(|_| without_heading == 0),
            findings: r.findings.clone(),
        })
    }
}
