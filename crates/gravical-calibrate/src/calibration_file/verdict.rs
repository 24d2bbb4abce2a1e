//! The grade of a calibration and its reasons.

use gravical_fit::Grade;
use gravical_judge::numfmt::{COVERAGE, count, mg, words};

use super::types::{Calibration, Method, PoseKind, PoseResult, Reliability, Verdict};
use crate::attitude::in_words;
use crate::recording::Finding;

/// Angles between the axes that are less well known than this are worth a word, degrees.
const OPEN_ANGLE_DEG: f64 = 0.3;

impl Calibration {
    /// The grade and its reasons, by the numbers and findings of the file: the session, the error of the result and what
    /// it could hide, what poses contradict, and what would improve it.
    pub fn verdict(&self) -> Verdict {
        if self.poses.is_empty() && self.reliability == Reliability::default() {
            let why = format!(
                "read from a file of {}, which contains no poses and nothing of its quality",
                self.tool
            );
            return Verdict {
                grade: self.grade(),
                reasons: vec![why],
            };
        }
        let r = &self.reliability;
        let grade = self.grade();
        let mut reasons: Vec<String> = self.gates().map(|f| f.message.clone()).collect();
        reasons.extend(r.worst_direction.map(|worst| {
            let (error, direction) = (mg(worst.error_mps2), in_words(worst.direction));
            // Of six faces it holds less often (docs/accuracy.md).
            let share = if r.left_out_rms_mps2.is_some() {
                95
            } else {
                90
            };
            format!(
                "error of ‖a‖ at most {error} mg ({share} %) in the worst direction ({direction})"
            )
        }));
        reasons.extend(self.detectable());
        reasons.extend(r.predicted_mps2.map(|error| {
            let tilt = r.pose_tilt_deg.map_or_else(String::new, |tilt| {
                let source = words(&tilt.source);
                format!("; tilt of the face poses {:.2}°, {source}", tilt.value)
            });
            let error = mg(COVERAGE * error);
            format!("predicted error of ‖a‖: {error} mg (95 %, mean over all directions{tilt})")
        }));
        let left_out = self.poses.iter().filter_map(|p| p.left_out_error_mps2);
        reasons.push(match r.left_out_rms_mps2.map(mg) {
            None => self.unverified().to_owned(),
            Some(rms) => format!(
                "leave-one-out error of ‖a‖: {rms} mg rms over {} poses",
                left_out.count()
            ),
        });
        if let Some((index, z)) = self.contradiction() {
            let pose = &self.poses[index];
            let (pose, error) = (pose.called(), pose.left_out_error_mps2.unwrap_or(f64::NAN));
            reasons.push(format!(
                "{pose} contradicts the other poses: its leave-one-out error is {} mg, {z:.1} of its standard deviations",
                mg(error)
            ));
        }
        if self.accelerometer.method == Method::Ferraris
            && let Some((error, poses)) = self.free_norm_error()
        {
            let (poses, error) = (count(poses, "free pose"), mg(error));
            reasons.push(format!(
                "error of ‖a‖ at {poses} that the fit did not use: {error} mg rms"
            ));
        }
        reasons.extend(self.open_angles());
        if r.next_poses.is_empty() && grade == Grade::NotVerifiable {
            let verify = "to verify it, calibrate a recording at rest in any free pose: ‖a‖ must equal gravity";
            reasons.push(verify.to_owned());
        }
        Verdict { grade, reasons }
    }

    /// Findings that no good result has.
    fn gates(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|f| f.gate)
    }

    /// The grade of the verdict alone.
    pub fn grade(&self) -> Grade {
        let r = &self.reliability;
        if self.gates().next().is_some() {
            return Grade::Poor;
        }
        if r.fit.is_none() {
            // The closed form tests no single pose: it is never verified.
            let is_large = |error| 2.0 * error > gravical_fit::UNVERIFIED_MPS2;
            let is_poor = r.predicted_mps2.is_some_and(is_large);
            return if is_poor {
                Grade::Poor
            } else {
                Grade::NotVerifiable
            };
        }
        let predicted = r.predicted_mps2.unwrap_or(f64::INFINITY);
        let error = r.worst_direction.map(|worst| worst.error_mps2);
        let hidden = r.undetected.map(|undetected| undetected.effect_mps2);
        let is_open = gravical_fit::is_open(&r.explanations);
        gravical_fit::grade(
            predicted,
            error,
            hidden,
            is_open || self.contradiction().is_some(),
        )
    }

    /// Which error of one pose is not detected with 90 %, and what it does. The poses that would test it are
    /// proposed.
    fn detectable(&self) -> Option<String> {
        self.reliability.fit?;
        self.reliability.left_out_rms_mps2?;
        let Some(hidden) = self.reliability.undetected else {
            let text = "there are too few poses to detect an error of one of them, however large";
            return Some(text.to_owned());
        };
        let [effect, reading] = [hidden.effect_mps2, hidden.reading_mps2].map(mg);
        // A file may be cut.
        let pose = self.poses.get(hidden.pose);
        let pose = pose.map_or("one".to_owned(), PoseResult::called);
        Some(format!(
            "an error of one pose that changes ‖a‖ by less than {effect} mg ({reading} mg in {pose}) may remain undetected"
        ))
    }

    fn unverified(&self) -> &'static str {
        let mut fitted = self.poses.iter().filter(|p| p.fitted);
        let is_six = fitted.clone().count() == 6;
        if is_six && fitted.all(|p| p.kind == PoseKind::Face) {
            "six faces determine six parameters of ‖a‖ exactly: their residuals verify nothing"
        } else if self.accelerometer.method == Method::Ferraris {
            "the six-face method tests no pose that it was not fitted to: its residuals verify nothing"
        } else {
            "too few poses to leave one out: nothing verifies the result"
        }
    }

    /// Angles between the axes that face poses do not separate from their own tilt.
    fn open_angles(&self) -> Option<String> {
        let angles = self.accelerometer.deviations()?.axis_angle_deg;
        let angle_deg = angles.iter().fold(0.0_f64, |m, a| m.max(*a));
        let tilt_deg = self.reliability.pose_tilt_deg?.value;
        (angle_deg > OPEN_ANGLE_DEG).then(|| format!(
        "face poses do not separate their tilt (σ {tilt_deg:.1}°) from misalignment: the angles between the axes are known to ±{:.1}°; free poses determine them",
            COVERAGE * angle_deg
        ))
    }
}
