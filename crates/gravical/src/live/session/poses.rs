//! The poses: one is accepted or rejected, undone, recorded again.

use std::ops::Range;

use gravical_core::matrix3::norm;

use crate::live::event::{Event, Pose, Rejection, Undone, WarningKind, Welcome};
use crate::live::judge::{Accepted, Capture, Fault, Means, mean, warmer_or_colder};
use crate::live::words;
use crate::live::{APART_DEG, face_of};
use crate::poses::MAX_FACE_ANGLE_DEG;
use crate::poses::face::{Face, angle_deg};

use super::{Hold, HoldStage, Session};

/// A change of temperature that is mentioned, °C.
const WARMED_C: f64 = 1.0;

impl Session {
    /// What a hold in this direction would be.
    pub(super) fn welcome(&self, up: [f64; 3]) -> Welcome {
        let face = self.face_up(up);
        let kind = match face {
            Some(_) => Welcome::Face,
            None => Welcome::Free,
        };
        if self.options.any_pose || face.is_some_and(|f| !self.has(f)) {
            return kind;
        }
        let near = |p: &Pose| angle_deg(p.up, up) < APART_DEG;
        // A steep face that is done leaves room for a free pose beside it only if it is far.
        if self.poses().any(near) {
            Welcome::Duplicate
        } else if face.is_some() || self.to_do().is_empty() {
            kind
        } else {
            Welcome::Between
        }
    }

    pub(super) fn unwelcome(&self, welcome: Welcome, up: [f64; 3]) -> Option<Fault> {
        let (face, tilt_deg) = Face::nearest(up);
        let to_do = self.to_do();
        if let Some(wanted) = self.redo.iter().find(|w| w.opposite() == face)
            && welcome == Welcome::Duplicate
        {
            return Some(Fault::new(
                Rejection::Sign,
                format!(
                    "{} is up, and {} is to be recorded again",
                    face.name(),
                    wanted.name()
                ),
                format!("turn it over: {} up", wanted.name()),
            ));
        }
        match welcome {
            Welcome::Face | Welcome::Free => None,
            Welcome::Duplicate => Some(Fault::new(
                Rejection::Duplicate,
                if tilt_deg <= MAX_FACE_ANGLE_DEG {
                    format!("{} is recorded already", face.name())
                } else {
                    format!("a pose within {APART_DEG:.0}° is recorded already")
                },
                if to_do.is_empty() {
                    "turn it to another direction, or redo that face".to_owned()
                } else {
                    format!("turn it to {}, or redo that face", words::any_of(&to_do))
                },
            )),
            Welcome::Between => Some(Fault::new(
                Rejection::BetweenFaces,
                format!(
                    "it lies between two faces: {tilt_deg:.0}° from {}",
                    face.name()
                ),
                format!(
                    "put {} up; or take it all the same, as a free pose",
                    words::any_of(&to_do)
                ),
            )),
        }
    }

    /// Accepts or rejects a capture.
    pub(super) fn judge(&mut self, rows: &Range<usize>, forced: bool) {
        let Some(units) = self.units() else { return };
        let samples = self.rows.within(rows);
        let means = Means::of(&samples);
        let capture = Capture {
            samples: &samples,
            rate_hz: self.rate_hz,
            rows: rows.len(),
            units,
            poses: &self.poses,
            options: &self.options,
        };
        let fault = capture.fault(&means).filter(|f| !(f.soft && forced));
        if let Some(hold) = &mut self.hold {
            hold.stage = HoldStage::Judged;
        }
        self.progress_s = self.now_s;
        if let Some(fault) = fault {
            if matches!(fault.reason, Rejection::Moved | Rejection::Gaps) {
                // The next try begins where this one ended.
                self.hold = Some(Hold::new(rows.end..rows.end, forced));
            }
            self.reject(fault);
            return;
        }
        let up = self.direction_of(means.accel);
        let (face, tilt_deg) = (self.face_up(up), Face::nearest(up).1);
        self.numbers += 1;
        let [Some(first), Some(last)] = [samples.first(), samples.last()] else {
            return;
        };
        let pose = Pose {
            pose: self.numbers,
            face: face.map(Face::name),
            up,
            tilt_deg,
            mean: means.accel,
            norm_mps2: norm(&means.accel) / units.nominal,
            noise_mg: self.mg(means.sigma),
            temperature_c: means.temperature_c,
            seconds: last.time_s - first.time_s + 1.0 / self.rate_hz,
            lines: [first.line, last.line],
        };
        self.accept(pose);
    }

    pub(super) fn accept(&mut self, pose: Pose) {
        let gyro = mean(&self.rows.at_lines(pose.lines), |s| s.gyro);
        self.redo.retain(|face| Some(face.name()) != pose.face);
        self.poses.push(Accepted {
            pose: pose.clone(),
            gyro,
        });
        self.away = false;
        let first = self.poses().find_map(|p| p.temperature_c);
        let warmed = first.zip(pose.temperature_c);
        let free = self.poses().filter(|p| p.face.is_none()).count();
        let text = words::accepted(&pose, 6 - self.to_do().len(), free);
        self.emit(Event::PoseAccepted(pose), text);
        if let Some((first, now)) = warmed
            && (now - first).abs() > WARMED_C
            && !std::mem::replace(&mut self.warned_of_temperature, true)
        {
            self.warn(
                WarningKind::Temperature,
                &format!(
                    "the sensor is {:.1} °C {} than in the first pose: let it run for some minutes before the session",
                    (now - first).abs(),
                    warmer_or_colder(now - first)
                ),
            );
        }
        self.fit_due = true;
    }

    pub(super) fn reject(&mut self, fault: Fault) {
        self.progress_s = self.now_s;
        let reason = fault.reason;
        let text = words::sentences([&*fault.message, &*fault.remedy]);
        self.emit(Event::PoseRejected { reason }, text);
    }

    pub(super) fn capture_now(&mut self) {
        let most_rows = self.settle_rows() + self.capture_rows();
        let has_units = self.units().is_some();
        match &mut self.hold {
            Some(hold) if has_units => {
                if hold.stage == HoldStage::Judged {
                    // From now on: what was judged stays judged.
                    hold.rows.start = hold.rows.end;
                }
                // What it has rested already counts.
                let earliest = hold.rows.end.saturating_sub(most_rows);
                hold.rows.start = hold.rows.start.max(earliest);
                (hold.stage, hold.forced) = (HoldStage::Settling, true);
            }
            _ => self.refuse("it moves: hold it still first"),
        }
    }

    pub(super) fn undo(&mut self) {
        let Some(last) = self.poses().last().map(|pose| pose.pose) else {
            self.refuse("there is no pose to undo");
            return;
        };
        self.remove(Undone::Undo, |pose| pose.pose == last);
    }

    pub(super) fn record_again(&mut self, name: &str) {
        let Some(face) = face_of(name) else {
            self.refuse("a face is +x, -x, +y, -y, +z or -z");
            return;
        };
        if self.has(face) && !self.redo.contains(&face) {
            self.redo.push(face);
        }
        let name = face.name();
        self.remove(Undone::Redo, |pose| pose.face.as_ref() == Some(&name));
    }

    fn remove(&mut self, why: Undone, is_gone: impl Fn(&Pose) -> bool) {
        let poses = std::mem::take(&mut self.poses);
        let (gone, left): (Vec<_>, _) = poses.into_iter().partition(|p| is_gone(&p.pose));
        self.poses = left;
        for Accepted { pose, .. } in gone {
            let text = words::undone(&pose, why);
            let Pose { pose, face, .. } = pose;
            self.emit(Event::PoseUndone { pose, face, why }, text);
        }
        self.away = true;
        self.progress_s = self.now_s;
        self.fit_due = true;
        self.file = None;
        if let Some(hold) = &mut self.hold {
            // The pose that lies there now may be wanted again.
            *hold = Hold::new(hold.rows.end..hold.rows.end, hold.forced);
        }
    }
}
