//! The calibration of the poses so far: the fit, the verdict, and the pose that is wanted next.

use crate::calibration_file::{CalibrationFile, Grade};
use crate::gravity::Gravity;
use crate::live::event::{Event, Fit, Pose, Wanted, WarningKind};
use crate::live::fit::{FIRST_FIT, FULL_FIT, fit, section_label};
use crate::live::judge::Accepted;
use crate::live::{mg, words};
use crate::numfmt::count;
use crate::poses::face::in_words;
use crate::poses::sections::Section;
use crate::{Error, Result};

use super::{Session, Stop};

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
                    let poses: Vec<Pose> = self.poses().cloned().collect();
                    let fit = Fit::of(&file, &poses);
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
        let section = |p: &Accepted| Section {
            label: section_label(p.pose.pose),
            rows: recording.rows_at(p.pose.lines),
        };
        let sections = self.poses.iter().map(section).collect();
        fit(&recording, sections, &self.options)
    }

    /// Says which pose is wanted next.
    pub(super) fn ask(&mut self) {
        let to_do = self.to_do();
        let (mut up, mut predicted_mg) = (None, None);
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
                predicted_mg = Some(2.0 * mg(next.predicted_norm_error_mps2));
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
            predicted_mg,
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
