//! The calibration of the poses so far: the fit, the verdict, and the pose that is wanted next.

use crate::calibrate::{CalibrateOptions, calibrate};
use crate::calibration_file::{CalibrationFile, Grade};
use crate::gravity::Gravity;
use crate::live::event::{Event, Fit, Pose, Wanted, WarningKind};
use crate::live::folder::section;
use crate::live::{mg, words};
use crate::numfmt::count;
use crate::poses::SegmentOptions;
use crate::poses::face::in_words;
use crate::{Error, Result};

use super::{FIRST_FIT, FULL_FIT, Session, Stop};

impl Session {
    /// Calibrates if the poses or gravity have changed.
    pub(super) fn fit_if_due(&mut self) {
        if self.fit_due && self.restored.is_none() {
            self.fit();
        }
    }

    pub(super) fn fit(&mut self) {
        self.fit_due = false;
        self.file = None;
        if self.poses.len() >= FIRST_FIT {
            match self.calibrated() {
                Ok(file) => {
                    let fit = self.fitted(&file);
                    let text = words::fit(&fit);
                    self.emit(Event::Fit(Box::new(fit)), text);
                    self.file = Some(file);
                }
                Err(error) if self.poses.len() >= FULL_FIT => {
                    self.warn(WarningKind::Other, &error.to_string());
                }
                Err(_) => {}
            }
        }
        let full = self.file.as_ref().filter(|_| self.poses.len() >= FULL_FIT);
        let grade = full.map(|file| file.verdict.grade);
        if let Some(file) = full.filter(|_| grade != self.grade) {
            let (event, text) = verdict(file, false);
            self.emit(event, text);
        }
        self.grade = grade;
        self.ask();
    }

    fn calibrated(&self) -> Result<CalibrationFile> {
        let recording = self.rows.recording().transpose()?;
        let recording =
            recording.ok_or_else(|| Error::input("no-rows", "no row was received yet"))?;
        let sections = self.poses().map(|pose| section(pose, &recording));
        let options = CalibrateOptions {
            segment: SegmentOptions {
                sections: Some(sections.collect()),
                ..SegmentOptions::default()
            },
            gravity: self.options.gravity,
            ..CalibrateOptions::default()
        };
        Ok(calibrate(&[recording], &options)?.file)
    }

    /// The figures of a calibration of the poses so far.
    fn fitted(&self, file: &CalibrationFile) -> Fit {
        let section = &file.accelerometer;
        Fit {
            bias_mg: [0, 1, 2].map(|i| mg(section.bias[i] / section.scale[i])),
            worst_mg: section.worst_direction.as_ref().map(|w| mg(w.error_mps2)),
            leave_one_out_mg: section.leave_one_out_rms_mps2.map(mg),
            undetected_mg: section.undetected.as_ref().map(|u| mg(u.effect_mps2)),
            grade: file.verdict.grade,
            poses: self.poses.len() as u32,
            suspect: self.suspect(file).map(|pose| pose.pose),
        }
    }

    /// The pose that contradicts the others.
    pub(super) fn suspect(&self, file: &CalibrationFile) -> Option<&Pose> {
        let (index, _) = file.accelerometer.contradiction()?;
        self.poses().nth(index)
    }

    /// Says which pose is wanted next.
    pub(super) fn ask(&mut self) {
        let to_do = self.to_do();
        let mut up = None;
        self.next_hint = None;
        let kind = if !to_do.is_empty() {
            Wanted::Face
        } else if self.grade == Some(Grade::Good) {
            Wanted::None
        } else {
            let next = self
                .file
                .as_ref()
                .and_then(|f| f.accelerometer.next_poses.first());
            if let Some(next) = next {
                (up, self.next_hint) = (Some(next.direction), Some(in_words(next.direction)));
            }
            Wanted::Free
        };
        let text = match (kind, &self.next_hint) {
            (Wanted::Face, _) => format!("Next: {} up.", words::any_of(&to_do)),
            (Wanted::Free, Some(hint)) => format!("Next, a free pose: {hint}."),
            (Wanted::Free, None) => "Next, a free pose: any new direction.".to_owned(),
            (Wanted::None, _) => "Good: it can be saved; more poses make it better.".to_owned(),
        };
        let event = Event::NextPose {
            kind,
            faces: to_do.iter().map(|f| f.name()).collect(),
            up,
            hint: self.next_hint.clone(),
        };
        self.emit(event, text);
    }

    pub(super) fn set_gravity(
        &mut self,
        value: Option<f64>,
        latitude: Option<f64>,
        altitude: Option<f64>,
    ) {
        let gravity = match (value, latitude) {
            (Some(_), Some(_)) => return self.refuse("gravity is a value or a latitude, not both"),
            (Some(value), None) => Gravity::given(value),
            (None, Some(latitude)) => Gravity::at(latitude, altitude.unwrap_or(0.0)),
            (None, None) => return self.refuse("gravity needs a value or a latitude"),
        };
        match gravity {
            Ok(gravity) => {
                self.options.gravity = gravity;
                self.fit_due = true;
                let event = Event::Gravity {
                    gravity_mps2: gravity.value_mps2,
                    gravity_source: gravity.source,
                };
                let text = format!("Local gravity is {:.5} m/s².", gravity.value_mps2);
                self.emit(event, text);
            }
            Err(error) => self.refuse(error.message()),
        }
    }

    pub(super) fn finish(&mut self) {
        if self.fit_due {
            self.fit();
        }
        let Some(file) = &self.file else {
            let what = count(self.poses.len(), "pose");
            self.refuse(&format!(
                "with {what} nothing is determined yet: at least {FIRST_FIT} are needed, better six faces and three free poses"
            ));
            return;
        };
        let (event, text) = verdict(file, true);
        self.stop = Some(Stop::Done);
        self.emit(event, text);
    }
}

fn verdict(file: &CalibrationFile, r#final: bool) -> (Event, String) {
    let event = Event::Verdict {
        grade: file.verdict.grade,
        r#final,
        reasons: file.verdict.reasons.clone(),
    };
    (event, words::verdict(file))
}
