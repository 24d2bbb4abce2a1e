//! The state of a session for people, ten times a second: what to do now, and what hinders.

use std::collections::BTreeMap;

use gravical_core::matrix3::norm;

use crate::calibration_file::Grade;
use crate::live::words;
use crate::poses::face::Face;

use super::{Hold, Session};
use crate::live::event::{Event, State, Status, Tile, Welcome};

/// After this time without progress the status says which test fails, s.
const HINT_AFTER_S: f64 = 5.0;

impl Session {
    /// Reports the state.
    pub(super) fn status(&mut self) {
        let up = self.direction();
        let (face, tilt_deg) = Face::nearest(up);
        let welcome = self.welcome(up);
        let still = self.last.as_ref().is_some_and(|s| s.run.is_some());
        let is_face = self.face_up(up).is_some();
        let suspect = self.file.as_ref().and_then(|file| self.suspect(file));
        let suspect = suspect.and_then(|pose| pose.face.clone());
        let tile = |f: Face| {
            let here = is_face && f == face;
            let tile = match self.state() {
                State::Capture if here => Tile::Capturing,
                _ if self.has(f) && suspect != Some(f.name()) => Tile::Done,
                State::Settle if here => Tile::HoldStill,
                _ if self.redo.contains(&f) || self.has(f) => Tile::Redo,
                _ => Tile::ToDo,
            };
            (f.name(), tile)
        };
        let tiles: BTreeMap<String, Tile> = Face::all().into_iter().map(tile).collect();
        let known = self.units().is_some();
        let gravity = self.options.gravity.value_mps2;
        let nominal = self.units().map_or(f64::NAN, |u| u.nominal * gravity);
        let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
        let last = self.last.as_ref();
        let temperature = self.rows.recent().next_back().map(|s| s.temperature_c);
        let status = Status {
            state: self.state(),
            hint: self.hint(up, welcome).map(|h| words::sentences([&*h])),
            up,
            attitude: self.attitude.wxyz(),
            norm_g: finite(norm(&self.reading()) / nominal),
            noise_mg: finite(last.map_or(0.0, |s| self.mg(s.scatter[0]))),
            limit_mg: last.filter(|_| known).map(|s| self.mg(s.max_scatter[0])),
            still,
            ring: self.ring(),
            face: face.name(),
            tilt_deg,
            welcome,
            rate_hz: self.rate_hz,
            temperature_c: temperature.filter(|t| t.is_finite()),
            tiles,
        };
        let text = self.sentence(face, is_face, welcome);
        self.emit(Event::Status(Box::new(status)), text);
    }

    /// Rows of the hold so far.
    fn held(&self) -> usize {
        self.hold
            .as_ref()
            .filter(|h| !h.is_over())
            .map_or(0, |h| h.rows.len())
    }

    fn ring(&self) -> f64 {
        let settle = self.settle_rows() as f64;
        let held = self.held() as f64;
        let share = match self.state() {
            State::Floor => held / ((self.options.settle_s + self.options.floor_s) * self.rate_hz),
            State::Settle => held / settle,
            State::Capture => (held - settle) / self.capture_rows() as f64,
            _ => 0.0,
        };
        share.clamp(0.0, 1.0)
    }

    fn sentence(&self, face: Face, is_face: bool, welcome: Welcome) -> String {
        let called = if is_face {
            format!("{} up", words::signed(&face.name()))
        } else {
            "Free pose".to_owned()
        };
        match self.state() {
            State::Identify => "Reading the first second.".to_owned(),
            State::Floor => format!(
                "Put the sensor on the table, hands off: {:.1} s.",
                (1.0 - self.ring()) * (self.options.settle_s + self.options.floor_s)
            ),
            State::Settle => format!("{called}: hold still."),
            State::Capture => format!(
                "{called}: hold still, {:.1} s to go.",
                (1.0 - self.ring()) * self.options.capture_s
            ),
            State::Lost => words::sentences(["no data", &words::safe(self.poses.len())]),
            State::Done => "Done.".to_owned(),
            State::Wait => {
                let to_do = self.to_do();
                if to_do.len() == 6 {
                    "Put any side up, and hold still.".to_owned()
                } else if !to_do.is_empty() && welcome == Welcome::Duplicate {
                    format!("Turn it: put {} up.", words::any_of(&to_do))
                } else if !to_do.is_empty() {
                    format!("Put {} up, and hold still.", words::any_of(&to_do))
                } else if self.grade == Some(Grade::Good) {
                    "Good. Enter saves it; every further pose makes it better.".to_owned()
                } else {
                    match &self.next_hint {
                        Some(hint) => {
                            format!("Free pose: {hint}. Lean it on something, and let go.")
                        }
                        None => "Free pose: any new direction. Lean it on something, and let go."
                            .to_owned(),
                    }
                }
            }
        }
    }

    /// Which test fails, after some time without progress.
    fn hint(&self, up: [f64; 3], welcome: Welcome) -> Option<String> {
        let waits = matches!(self.state(), State::Wait | State::Floor);
        if !waits || self.now_s - self.progress_s < HINT_AFTER_S {
            return None;
        }
        let last = self.last.as_ref()?;
        if last.run.is_some() {
            let over = self.hold.as_ref().is_some_and(Hold::is_over);
            return match welcome {
                Welcome::Duplicate if over => Some(match self.face_up(up) {
                    Some(face) => format!("{} is up, which is done", face.name()),
                    None => "this pose is done".to_owned(),
                }),
                Welcome::Between if over => Some("it lies between two faces".to_owned()),
                _ => None,
            };
        }
        let unit = |v: f64| match self.units() {
            Some(_) => format!("{:.0} mg", self.mg(v)),
            None => format!("{v:.3}"),
        };
        Some(if last.scatter[0] > last.max_scatter[0] {
            format!(
                "still moving: {}, limit {}",
                unit(last.scatter[0]),
                unit(last.max_scatter[0])
            )
        } else if last.scatter[1] > last.max_scatter[1] {
            let nominal = self.units().and_then(|u| u.gyro_nominal);
            let deg_s = |v: f64| match nominal {
                Some(nominal) => format!("{:.1} °/s", (v / nominal).to_degrees()),
                None => format!("{v:.3}"),
            };
            format!(
                "still turning: {}, limit {}",
                deg_s(last.scatter[1]),
                deg_s(last.max_scatter[1])
            )
        } else {
            "still turning slowly".to_owned()
        })
    }
}
