//! The state of a session for people, ten times a second: what to do now, and what hinders.

use gravical_core::matrix3::norm;

use super::event::{Event, State, Status, Tile};
use super::sentence;
use super::session::{Session, face_up};
use crate::poses::face::Face;

/// After this time without progress the status says which test fails, s.
const HINT_AFTER_S: f64 = 5.0;

impl Session {
    /// The state for people.
    fn state(&self) -> State {
        let is_capturing = self.hold.as_ref().is_some_and(|h| self.is_capturing(h));
        match self.stop {
            Some(state) => state,
            None if self.detector.is_none() => State::Identify,
            None if self.units.is_none() => State::Floor,
            None if is_capturing => State::Capture,
            None => State::Wait,
        }
    }

    /// Reports the state.
    pub(super) fn status(&mut self) {
        let state = self.state();
        let reading = self.reading();
        let up = self.direction(reading);
        let (face, tilt_deg) = Face::nearest(up);
        let ring = self.ring(state);
        let here = face_up(up);
        let suspect = self.suspect().and_then(|pose| pose.face.clone());
        let tile = |f: Face| match state {
            State::Capture if here == Some(f) => Tile::Capturing,
            _ if self.is_recorded(f) && suspect != Some(f.name()) => Tile::Done,
            _ if self.redo.contains(&f) || self.is_recorded(f) => Tile::Redo,
            _ => Tile::ToDo,
        };
        let gravity_mps2 = self.options.gravity.value_mps2;
        let nominal = self.units.map_or(f64::NAN, |u| u.nominal * gravity_mps2);
        let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
        let last = self.last.as_ref();
        let temperature = self.recent.back().map(|s| s.temperature_c);
        let status = Status {
            state,
            hint: self.hint(state, up).map(|h| sentence(&h)),
            up,
            norm_g: finite(norm(&reading) / nominal),
            noise_mg: finite(last.map_or(0.0, |s| self.mg(s.scatter[0]))),
            limit_mg: self.units.and(last).map(|s| self.mg(s.max_scatter[0])),
            still: last.is_some_and(|s| s.run.is_some()),
            ring,
            face: face.name(),
            tilt_deg,
            rate_hz: self.rate_hz,
            temperature_c: temperature.filter(|t| t.is_finite()),
            tiles: Face::all().map(|f| (f.name(), tile(f))).into(),
        };
        let left = 1.0 - ring;
        let text = match state {
            State::Identify => "Reading the first second.".to_owned(),
            State::Floor => {
                let left_s = left * self.floor_s();
                format!("Put the sensor on the table, hands off: {left_s:.1} s.")
            }
            State::Capture => {
                let called = here.map_or("Free pose".to_owned(), |f| format!("{} up", f.name()));
                let left_s = left * self.options.capture_s;
                format!("{called}: hold still, {left_s:.1} s to go.")
            }
            State::Lost => format!("No data. {}", self.safe()),
            State::Done => "Done.".to_owned(),
            State::Wait => self.next_step().1,
        };
        self.emit(Event::Status(Box::new(status)), &text);
    }

    /// Progress of the state, 0 to 1.
    fn ring(&self, state: State) -> f64 {
        let settle = self.settle_rows() as f64;
        let hold = self.hold.as_ref().filter(|h| !h.is_over);
        let held = hold.map_or(0, |h| h.rows.len()) as f64;
        let share = match state {
            State::Floor => held / (self.floor_s() * self.rate_hz),
            State::Capture => (held - settle) / self.capture_rows() as f64,
            _ => 0.0,
        };
        share.clamp(0.0, 1.0)
    }

    /// Which test fails, after some time without progress.
    fn hint(&self, state: State, up: [f64; 3]) -> Option<String> {
        let waits = matches!(state, State::Wait | State::Floor);
        if !waits || self.now_s - self.progress_s < HINT_AFTER_S {
            return None;
        }
        let last = self.last.as_ref()?;
        if last.run.is_some() {
            self.hold.as_ref().filter(|hold| hold.is_over)?;
            return self.refusal(up).map(|(_, text)| text);
        }
        let excess = |sensor: usize| last.scatter[sensor] / last.max_scatter[sensor];
        let tests = [("moving", excess(0)), ("turning", excess(1))];
        let failing = tests.iter().find(|(_, excess)| *excess > 1.0);
        Some(
            failing.map_or("still turning slowly".to_owned(), |(what, excess)| {
                format!("still {what}: {excess:.1} times the limit")
            }),
        )
    }
}
