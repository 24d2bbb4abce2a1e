//! The state of a session for people, ten times a second: what to do now, and what hinders.

use std::collections::BTreeMap;

use gravical_core::matrix3::norm;

use crate::calibration_file::Grade;
use crate::live::{mg, words};
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
            State::Wait => self.next_step(welcome),
        }
    }

    /// What to do while nothing is held.
    fn next_step(&self, welcome: Welcome) -> String {
        let to_do = self.to_do();
        let faces = words::any_of(&to_do);
        match (to_do.len(), &self.next_hint) {
            (6, _) => "Put any side up, and hold still.".to_owned(),
            (1.., _) if welcome == Welcome::Duplicate => format!("Turn it: put {faces} up."),
            (1.., _) => format!("Put {faces} up, and hold still."),
            _ if self.grade == Some(Grade::Good) => {
                "Good. Enter saves it; every further pose makes it better.".to_owned()
            }
            (_, hint) => {
                let hint = hint.as_deref().unwrap_or("any new direction");
                format!("Free pose: {hint}. Lean it on something, and let go.")
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
        let units = self.units();
        let turning = units.and_then(|u| u.gyro_nominal);
        // In the unit of the recording while that is not known.
        let tests = [
            ("moving", units.map(|u| mg(u.nominal.recip())), "mg", 0),
            ("turning", turning.map(|n| n.recip().to_degrees()), "°/s", 1),
        ];
        let mut tests = tests.into_iter().zip(last.scatter).zip(last.max_scatter);
        let failing = tests.find(|((_, scatter), max)| scatter > max);
        let Some((((what, scale, unit, decimals), scatter), max)) = failing else {
            return Some("still turning slowly".to_owned());
        };
        Some(match scale {
            Some(k) => {
                let (scatter, max) = (k * scatter, k * max);
                format!("still {what}: {scatter:.decimals$} {unit}, limit {max:.decimals$} {unit}")
            }
            None => format!("still {what}: {scatter:.3}, limit {max:.3}"),
        })
    }
}
