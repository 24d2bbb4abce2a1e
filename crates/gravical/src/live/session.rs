//! The state machine: its state, and what the program passes to it. The files of the folder are
//! its parts, in the order of a session.

mod hold;
mod poses;
mod result;
mod start;
mod status;

use std::collections::VecDeque;
use std::ops::Range;

use gravical_core::matrix3::{mul_vec, norm};

use crate::calibration_file::{CalibrationFile, Grade};
use crate::gravity::Gravity;
use crate::poses::MAX_FACE_ANGLE_DEG;
use crate::poses::face::Face;
use crate::recording::Recording;
use crate::{Error, Result};

use super::attitude::Attitude;
use super::event::{Command, Event, Loss, Message, Pose, SourceKind, State, WarningKind};
use super::judge::{Accepted, Units, mean};
use super::rows::SessionRows;
use super::stillness::{Stillness, StillnessDetector};
use super::{LiveOptions, mg, words};
use gravical_recording::Sample;

/// Direction and magnitude are means over this time, s.
const SMOOTH_S: f64 = 0.2;
/// Rows of a capture at least.
const MIN_ROWS: usize = 50;
/// From this many poses on, a fit is tried, and from this many on it is complete.
const FIRST_FIT: usize = 4;
const FULL_FIT: usize = 6;

/// Rest without interruption.
#[derive(Debug, Clone)]
struct Hold {
    /// Its rows.
    rows: Range<usize>,
    stage: HoldStage,
    /// Whatever can be overruled is: the user wants this pose.
    forced: bool,
}

impl Hold {
    fn new(rows: Range<usize>, forced: bool) -> Self {
        Hold {
            rows,
            stage: HoldStage::Settling,
            forced,
        }
    }

    /// Nothing happens until it moves.
    fn is_over(&self) -> bool {
        matches!(self.stage, HoldStage::Refused | HoldStage::Judged)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum HoldStage {
    /// Its capture has not begun.
    Settling,
    /// A capture has begun.
    Capturing,
    /// There was no capture: the pose is not wanted.
    Refused,
    /// The capture was accepted or rejected.
    Judged,
}

/// How far the session is.
enum Phase {
    /// Columns and clock are not known.
    Identify,
    /// Noise at rest and unit are not known.
    Floor(StillnessDetector),
    /// Poses are taken.
    Poses(StillnessDetector, Units),
}

/// Why nothing happens, whatever the phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stop {
    /// No rows arrive.
    Lost,
    /// The user has finished or cancelled it.
    Done,
}

/// A guided calibration. It belongs to one thread.
pub struct Session {
    options: LiveOptions,
    rows: SessionRows,
    phase: Phase,
    stop: Option<Stop>,
    /// What the last block said; none after rows that are missing.
    last: Option<Stillness>,
    rate_hz: f64,
    attitude: Attitude,
    gyro_bias: [f64; 3],
    hold: Option<Hold>,
    poses: Vec<Accepted>,
    /// Numbers of poses that were used.
    numbers: u32,
    /// Faces to record again.
    redo: Vec<Face>,
    /// It was far from the last pose since that was accepted.
    away: bool,
    /// The poses or gravity have changed since the last fit.
    fit_due: bool,
    file: Option<CalibrationFile>,
    grade: Option<Grade>,
    next_hint: Option<String>,
    warned_of_temperature: bool,
    /// Poses of a session that is resumed, while its rows are read.
    restored: Option<VecDeque<Pose>>,
    /// Time of the last row, of the last progress, and of the last status, s.
    now_s: f64,
    progress_s: f64,
    status_s: f64,
    events: Vec<Message>,
}

impl Session {
    /// A session that reads the recording `name`.
    #[must_use]
    pub fn new(name: &str, options: LiveOptions) -> Self {
        Session {
            rows: SessionRows::new(name, &options.read),
            options,
            phase: Phase::Identify,
            stop: None,
            last: None,
            rate_hz: Recording::ASSUMED_RATE_HZ,
            attitude: Attitude::default(),
            gyro_bias: [0.0; 3],
            hold: None,
            poses: Vec::new(),
            numbers: 0,
            redo: Vec::new(),
            away: true,
            fit_due: false,
            file: None,
            grade: None,
            next_hint: None,
            warned_of_temperature: false,
            restored: None,
            now_s: 0.0,
            progress_s: 0.0,
            status_s: f64::NEG_INFINITY,
            events: Vec::new(),
        }
    }

    /// A session that continues: its `poses` are taken as they are when their rows are read, and
    /// no other, until [`resumed`](Self::resumed). `numbers`: how many numbers of poses were used.
    #[must_use]
    pub fn restore(name: &str, options: LiveOptions, poses: Vec<Pose>, numbers: u32) -> Self {
        Session {
            restored: Some(poses.into()),
            numbers,
            ..Session::new(name, options)
        }
    }

    /// The first event.
    pub fn begin(
        &mut self,
        source: SourceKind,
        name: &str,
        folder: Option<String>,
    ) -> Vec<Message> {
        let into = folder
            .as_ref()
            .map_or(String::new(), |f| format!("; the session is in {f}"));
        let event = Event::Session {
            source,
            name: name.to_owned(),
            folder,
            tool: crate::TOOL.to_owned(),
            gravity_mps2: self.options.gravity.value_mps2,
            gravity_source: self.options.gravity.source,
        };
        self.emit(event, words::sentences([&*format!("{name}{into}")]));
        self.take()
    }

    /// Takes the next bytes of the recording, as they stand on the disk.
    ///
    /// # Errors
    ///
    /// Those of reading: no rows of a sensor. A faulty line is no error.
    pub fn bytes(&mut self, bytes: &[u8]) -> Result<Vec<Message>> {
        let samples = self.rows.read(bytes)?;
        self.samples(samples)
    }

    /// Takes the rows so far as they are, if the format is not known yet: the sensor is slow, or the
    /// recording has ended.
    ///
    /// # Errors
    ///
    /// Those of reading: so far it is no recording.
    pub fn settle_format(&mut self) -> Result<Vec<Message>> {
        let samples = self.rows.settle()?;
        self.samples(samples)
    }

    fn samples(&mut self, samples: Vec<Sample>) -> Result<Vec<Message>> {
        if self.rows.reading.is_calibrated_by_board() {
            return Err(Error::input(
                "already-calibrated",
                "the board sends calibrated values, as the line with its settings says: a calibration needs raw ones",
            )
            .with_hint("gravical live --format si: with it the sketch sends raw values"));
        }
        for sample in samples {
            self.fit_if_due();
            self.sample(sample)?;
        }
        Ok(self.take())
    }

    /// Calculates what waits, so that the events of [`bytes`](Self::bytes) come before the work.
    pub fn settle(&mut self) -> Vec<Message> {
        self.fit_if_due();
        self.take()
    }

    /// No rows arrive.
    pub fn lost(&mut self, why: Loss) -> Vec<Message> {
        if self.stop.is_none() {
            self.stop = Some(Stop::Lost);
            self.interrupt();
            self.status();
            let (what, remedy) = match why {
                Loss::Unplugged => ("Unplugged.", "Plug it back in."),
                Loss::Silent => (
                    "The board sends nothing.",
                    "Check the cable, or press its reset.",
                ),
            };
            let text = words::sentences([what, &words::safe(self.poses.len()), remedy]);
            let poses = self.poses.len() as u32;
            self.emit(Event::Lost { why, poses }, text);
        }
        self.take()
    }

    /// Rows arrive again; or those that were there before a session was resumed have been read.
    pub fn resumed(&mut self) -> Vec<Message> {
        let was_restored = self.restored.take().is_some();
        let was_lost = self.stop == Some(Stop::Lost);
        if !was_restored && !was_lost {
            return Vec::new();
        }
        self.stop = self.stop.filter(|_| !was_lost);
        self.interrupt();
        self.progress_s = self.now_s;
        let text = words::sentences(["here again", &words::safe(self.poses.len())]);
        let poses = self.poses.len() as u32;
        self.emit(Event::Resumed { poses }, text);
        self.ask();
        self.settle()
    }

    /// Something for the record that only the program knows: what was saved, the end.
    pub fn note(&mut self, event: Event, text: impl Into<String>) -> Vec<Message> {
        self.emit(event, text);
        self.take()
    }

    /// Does what the user wants. [`Command::Hand`] is for a simulated sensor, not for the session.
    pub fn command(&mut self, command: &Command) -> Vec<Message> {
        if self.is_done() {
            return Vec::new();
        }
        match command {
            Command::Capture => self.capture_now(),
            Command::Undo => self.undo(),
            Command::Redo { face } => self.record_again(face),
            Command::Finish => self.finish(),
            Command::Gravity {
                value,
                latitude,
                altitude,
            } => self.set_gravity(*value, *latitude, *altitude),
            Command::Port { .. } | Command::Simulate => {
                self.refuse("the sensor was chosen: another one needs a new session");
            }
            Command::Cancel => self.stop = Some(Stop::Done),
            Command::Resume => self.refuse("the session goes on already"),
            Command::Hand { .. } => self.refuse("this sensor is moved by hand, not by commands"),
        }
        self.settle()
    }

    /// The calibration from the poses so far.
    #[must_use]
    pub fn calibration(&self) -> Option<&CalibrationFile> {
        self.file.as_ref()
    }

    /// The accepted poses.
    pub fn poses(&self) -> impl Iterator<Item = &Pose> {
        self.poses.iter().map(|p| &p.pose)
    }

    /// Local gravity.
    #[must_use]
    pub fn gravity(&self) -> Gravity {
        self.options.gravity
    }

    /// True once the user has finished or cancelled.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.stop == Some(Stop::Done)
    }

    /// The state for people.
    fn state(&self) -> State {
        let hold = self.hold.as_ref().map(|hold| hold.stage);
        match (self.stop, &self.phase, hold) {
            (Some(Stop::Done), ..) => State::Done,
            (Some(Stop::Lost), ..) => State::Lost,
            (_, Phase::Identify, _) => State::Identify,
            (_, Phase::Floor(_), _) => State::Floor,
            (_, _, Some(HoldStage::Settling)) => State::Settle,
            (_, _, Some(HoldStage::Capturing)) => State::Capture,
            _ => State::Wait,
        }
    }

    fn detector(&mut self) -> Option<&mut StillnessDetector> {
        match &mut self.phase {
            Phase::Identify => None,
            Phase::Floor(detector) | Phase::Poses(detector, _) => Some(detector),
        }
    }

    /// The units, once the noise at rest is known.
    fn units(&self) -> Option<Units> {
        match &self.phase {
            Phase::Poses(_, units) => Some(*units),
            _ => None,
        }
    }

    // Events.

    fn emit(&mut self, event: Event, text: impl Into<String>) {
        self.events.push(Message::new(self.now_s, event, text));
    }

    fn take(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.events)
    }

    fn warn(&mut self, kind: WarningKind, message: &str) {
        self.emit(Event::Warning { kind }, words::sentences([message]));
    }

    fn refuse(&mut self, why: &str) {
        self.warn(WarningKind::Refused, why);
    }

    // What several parts ask for.

    /// The face was recorded.
    fn has(&self, face: Face) -> bool {
        let name = face.name();
        self.poses().any(|p| p.face.as_deref() == Some(&name))
    }

    fn to_do(&self) -> Vec<Face> {
        Face::all().into_iter().filter(|f| !self.has(*f)).collect()
    }

    /// A value of the accelerometer in mg; NaN before the unit is known.
    fn mg(&self, units: f64) -> f64 {
        self.units().map_or(f64::NAN, |u| mg(units / u.nominal))
    }

    /// The face that a direction has up, if one is.
    fn face_up(&self, up: [f64; 3]) -> Option<Face> {
        let (face, tilt_deg) = Face::nearest(up);
        (tilt_deg <= MAX_FACE_ANGLE_DEG).then_some(face)
    }

    /// Specific force of the last rows, unit of the recording.
    fn reading(&self) -> [f64; 3] {
        let recent = self.rows.recent().rev();
        let recent = recent.take_while(|s| self.now_s - s.time_s <= SMOOTH_S);
        let samples: Vec<Sample> = recent.copied().collect();
        mean(&samples, |s| s.accel)
    }

    /// The direction now.
    fn direction(&self) -> [f64; 3] {
        self.direction_of(self.reading())
    }

    /// The direction of a reading, as far as the sensor is known.
    fn direction_of(&self, reading: [f64; 3]) -> [f64; 3] {
        let full = self.file.as_ref().filter(|_| self.poses.len() >= FULL_FIT);
        let force = match full {
            Some(file) => {
                let section = &file.accelerometer;
                let offset = self.units().map_or(0.0, |u| u.zero_offset);
                let raw: [f64; 3] = std::array::from_fn(|i| reading[i] + offset - section.bias[i]);
                mul_vec(&section.matrix, &raw)
            }
            None => reading,
        };
        let size = norm(&force);
        if size > 0.0 {
            force.map(|v| v / size)
        } else {
            [0.0, 0.0, 1.0]
        }
    }

    /// Rows of a hold before its capture begins.
    fn settle_rows(&self) -> usize {
        (self.options.settle_s * self.rate_hz).round() as usize
    }

    fn capture_rows(&self) -> usize {
        ((self.options.capture_s * self.rate_hz).round() as usize).max(MIN_ROWS)
    }
}
