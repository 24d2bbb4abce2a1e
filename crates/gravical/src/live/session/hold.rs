//! A hold: it begins, settles, is captured, or is interrupted.

use std::ops::Range;

use gravical_core::matrix3::sub;

use crate::Result;
use crate::live::APART_DEG;
use crate::live::event::{Event, Pose, Rejection, State, Welcome};
use crate::live::judge::{Fault, LET_GO, Means, mean};
use crate::live::stillness::Stillness;
use crate::poses::face::angle_deg;
use gravical_recording::Sample;

use super::{Hold, HoldStage, Phase, Session};

/// Time between two status events, s.
const STATUS_S: f64 = 0.1;
/// A step of the clock longer than this is a gap, s.
const GAP_S: f64 = 0.5;
/// A capture that is interrupted earlier was none, share of its length.
const MIN_PROGRESS: f64 = 0.15;

impl Session {
    pub(super) fn sample(&mut self, sample: Sample) -> Result<()> {
        let gap = sample.time_s - self.now_s > GAP_S.max(5.0 / self.rate_hz);
        self.now_s = sample.time_s;
        if sample.row > 0 && (sample.is_break || gap) {
            self.interrupt();
        }
        self.rows.push(sample);
        let gyro_nominal = self.units().and_then(|u| u.gyro_nominal);
        let rate =
            gyro_nominal.map(|nominal| sub(&sample.gyro, &self.gyro_bias).map(|v| v / nominal));
        self.attitude.update(sample.time_s, sample.accel, rate);
        if matches!(self.phase, Phase::Identify) {
            self.identify(&sample)?;
        } else {
            self.detect(&sample);
        }
        let ends = |p: &&Pose| p.lines[1] == sample.line;
        if let Some(restored) = &mut self.restored
            && restored.front().is_some_and(|p| ends(&p))
            && let Some(pose) = restored.pop_front()
        {
            self.accept(pose);
        }
        if sample.time_s - self.status_s >= STATUS_S - 1e-6 && self.restored.is_none() {
            self.status_s = sample.time_s;
            self.status();
        }
        Ok(())
    }

    /// No hold spans what comes.
    pub(super) fn interrupt(&mut self) {
        if let Some(detector) = self.detector() {
            detector.split();
        }
        self.last = None;
        let hold = self.hold.take();
        if hold.is_some_and(|h| h.stage == HoldStage::Capturing) {
            let fault = Fault::new(
                Rejection::Gaps,
                "rows are missing in the middle of the capture".to_owned(),
                "hold it still once more",
            );
            self.reject(fault);
        }
    }

    pub(super) fn detect(&mut self, sample: &Sample) {
        let Some(detector) = self.detector() else {
            return;
        };
        let Some(state) = detector.push(*sample) else {
            return;
        };
        self.last = Some(state.clone());
        if state.run.is_some() && state.scatter[1].is_finite() {
            self.gyro_bias = mean(&self.rows.within(&state.block), |s| s.gyro);
        }
        if self.restored.is_none() {
            self.block(&state);
        }
    }

    /// Judges what the last block says.
    pub(super) fn block(&mut self, state: &Stillness) {
        if self.stop.is_some() {
            return;
        }
        let Some(run) = state.run.clone() else {
            self.moved(state);
            return;
        };
        self.follow(run.clone(), state);
        if self.state() == State::Floor && !self.floor(&run, state) {
            return;
        }
        self.go_away();
        self.hold_on();
    }

    /// It moves: a capture that has begun is interrupted.
    fn moved(&mut self, state: &Stillness) {
        let hold = self.hold.take();
        if hold.as_ref().is_some_and(Hold::is_over) {
            // The user begins to turn it.
            self.progress_s = self.now_s;
        }
        if let Some(hold) = hold.filter(|h| h.stage == HoldStage::Capturing) {
            let progress_s = (hold.rows.len() as f64 / self.rate_hz) - self.options.settle_s;
            if progress_s > MIN_PROGRESS * self.options.capture_s {
                let message = if state.scatter[0] > state.max_scatter[0] {
                    format!(
                        "it moved after {progress_s:.1} s: {:.0} mg, limit {:.0} mg",
                        self.mg(state.scatter[0]),
                        self.mg(state.max_scatter[0])
                    )
                } else {
                    format!("it turned after {progress_s:.1} s")
                };
                let fault = Fault::new(Rejection::Moved, message, LET_GO);
                self.reject(fault);
            }
        }
        self.go_away();
    }

    /// The hold that the run belongs to.
    fn follow(&mut self, run: Range<usize>, state: &Stillness) {
        let settle = self.settle_rows();
        match &mut self.hold {
            Some(hold) if run.start < hold.rows.end => {
                let from = hold.rows.start + settle;
                if hold.stage == HoldStage::Capturing && run.start > from {
                    // It drifts: what was captured does not agree with what is read now.
                    self.moved(state);
                    self.follow(run, state);
                    return;
                }
                hold.rows.end = run.end;
            }
            _ => self.hold = Some(Hold::new(run, false)),
        }
    }

    /// Notes that it has left the last pose.
    fn go_away(&mut self) {
        if let Some(last) = self.poses.last() {
            let angle = angle_deg(last.pose.up, self.direction());
            self.away |= angle > APART_DEG;
        }
    }

    /// The hold goes on: it settles, is captured, is over.
    pub(super) fn hold_on(&mut self) {
        let settle = self.settle_rows();
        let capture = self.capture_rows();
        let Some(hold) = self.hold.clone().filter(|hold| !hold.is_over()) else {
            return;
        };
        let from = hold.rows.start + settle;
        if hold.rows.end <= from {
            return;
        }
        if hold.stage == HoldStage::Settling {
            let samples = self.rows.within(&hold.rows);
            let accel = Means::of(&samples).accel;
            let up = self.direction_of(accel);
            let welcome = self.welcome(up);
            // Where the magnitude is not that of gravity the direction says nothing; the capture
            // finds what is wrong.
            let gravity = self.options.gravity.value_mps2;
            let is_gravity = self
                .units()
                .is_some_and(|u| u.fault(accel, gravity).is_none());
            let fault = self.unwelcome(welcome, up);
            let fault = fault.filter(|_| is_gravity && !hold.forced);
            if let Some(hold) = &mut self.hold {
                hold.stage = match fault {
                    Some(_) => HoldStage::Refused,
                    None => HoldStage::Capturing,
                };
            }
            match fault {
                Some(fault) => {
                    // A bump on the pose that was just accepted is not worth a word.
                    if welcome != Welcome::Duplicate || self.away {
                        self.reject(fault);
                    }
                    return;
                }
                None => self.emit(Event::PoseCandidate, "The capture begins."),
            }
        }
        if hold.rows.end - from >= capture {
            self.judge(&(from..from + capture), hold.forced);
        }
    }
}
