//! The state machine: how far a session is, its holds, poses and calibration.

use std::collections::VecDeque;
use std::ops::Range;

use gravical_core::matrix3::{mul_vec, norm, sub};
use gravical_recording::Sample;

use crate::calibrate::{CalibrateOptions, calibrate};
use crate::calibration_file::{CalibrationFile, Grade, GravitySource};
use crate::gravity::Gravity;
use crate::numfmt::{self, count};
use crate::poses::face::{Face, angle_deg, in_words};
use crate::poses::{MAX_FACE_ANGLE_DEG, SegmentOptions};
use crate::recording::units::{AccelUnit, GyroScale};
use crate::recording::{Follow, Recording};
use crate::stats::standard_deviation;
use crate::{Error, Result};

use super::attitude::Attitude;
use super::event::{
    Command, Event, Fit, Loss, Message, Pose, Rejection, SourceKind, Wanted, WarningKind, Welcome,
};
use super::folder::{Journal, section};
use super::rest::{Fault, LET_GO, Means, Units, columns, warming};
use super::stillness::{Stillness, StillnessDetector};
use super::{APART_DEG, LiveOptions, any_of, face_of, mg, sentence};

/// Rows of this time are at hand, s: twice the longest capture.
const RECENT_S: f64 = 120.0;
/// Direction and magnitude are means over this time, s.
const SMOOTH_S: f64 = 0.2;
/// A step of the clock longer than this is a gap, s.
const GAP_S: f64 = 0.5;
/// The columns and the clock are reported after this time, s.
const IDENTIFY_S: f64 = 1.0;
/// A hold is looked back upon for this time before its capture, s.
const RUN_S: f64 = 40.0;
/// Noise at rest over the magnitude at most, three axes together: twice that of a bad MPU6050
/// without low-pass. Where the quietest blocks scatter more, the sensor has not rested yet.
const MAX_NOISE_AT_REST: f64 = 0.035;
/// Rows of a capture at least.
const MIN_ROWS: usize = 50;
/// A capture that is interrupted earlier was none, share of its length.
const MIN_PROGRESS: f64 = 0.15;
/// A change of temperature that is mentioned, °C.
const WARMED_C: f64 = 1.0;
/// A face that is tilted by more than this is noted, degrees.
const FINE_TILT_DEG: f64 = 10.0;
/// Time between two status events, s.
const STATUS_S: f64 = 0.1;
/// What has no face.
const FREE_POSE: &str = "free pose";
/// From this many poses on, a fit is tried, and from this many on it is complete.
const FIRST_FIT: usize = 4;
const FULL_FIT: usize = 6;

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
pub(super) enum Stop {
    /// No rows arrive.
    Lost,
    /// The user has finished or cancelled it.
    Done,
}

/// Rest without interruption.
#[derive(Debug, Clone)]
pub(super) struct Hold {
    /// Its rows.
    pub rows: Range<usize>,
    pub stage: HoldStage,
    /// Whatever can be overruled is: the user wants this pose.
    forced: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum HoldStage {
    /// Its capture has not begun.
    Settling,
    /// A capture has begun.
    Capturing,
    /// It was refused, accepted or rejected: nothing happens until it moves.
    Over,
}

impl Hold {
    fn new(rows: Range<usize>, forced: bool) -> Self {
        Hold {
            rows,
            stage: HoldStage::Settling,
            forced,
        }
    }

    pub fn is_over(&self) -> bool {
        self.stage == HoldStage::Over
    }
}

/// A guided calibration. It belongs to one thread.
pub struct Session {
    pub(super) options: LiveOptions,
    reading: Follow,
    /// The last rows.
    pub(super) recent: VecDeque<Sample>,
    /// Line of the last row.
    last_line: u32,
    phase: Phase,
    pub(super) stop: Option<Stop>,
    /// What the last block said; none after rows that are missing.
    pub(super) last: Option<Stillness>,
    pub(super) rate_hz: f64,
    pub(super) attitude: Attitude,
    gyro_bias: [f64; 3],
    pub(super) hold: Option<Hold>,
    /// The accepted poses, and their mean angular rates.
    pub(super) poses: Vec<(Pose, [f64; 3])>,
    /// Numbers of poses that were used.
    numbers: u32,
    /// Faces to record again.
    pub(super) redo: Vec<Face>,
    /// It was far from the last pose since that was accepted.
    has_departed: bool,
    /// The calibration of the poses so far.
    file: Option<CalibrationFile>,
    warned_of_temperature: bool,
    /// Time of the last row, of the last progress, and of the last status, s.
    pub(super) now_s: f64,
    pub(super) progress_s: f64,
    status_s: f64,
    events: Vec<Message>,
}

impl Session {
    /// A session that reads the recording `name`.
    #[must_use]
    pub fn new(name: &str, options: LiveOptions) -> Self {
        let rate_hz = options.read.rate_hz.unwrap_or(Recording::ASSUMED_RATE_HZ);
        Session {
            reading: Follow::new(name, options.read.clone(), usize::MAX),
            options,
            recent: VecDeque::new(),
            last_line: 0,
            phase: Phase::Identify,
            stop: None,
            last: None,
            rate_hz,
            attitude: Attitude::default(),
            gyro_bias: [0.0; 3],
            hold: None,
            poses: Vec::new(),
            numbers: 0,
            redo: Vec::new(),
            has_departed: true,
            file: None,
            warned_of_temperature: false,
            now_s: 0.0,
            progress_s: 0.0,
            status_s: f64::NEG_INFINITY,
            events: Vec::new(),
        }
    }

    /// Takes what a session has that goes on: the bytes of its recording, and its poses as they are. The
    /// noise is measured anew, after [`resumed`](Self::resumed).
    ///
    /// # Errors
    ///
    /// As of [`bytes`](Self::bytes).
    pub fn restore(&mut self, bytes: &[u8], journal: &Journal) -> Result<Vec<Message>> {
        self.stop = Some(Stop::Lost);
        self.numbers = journal.numbers;
        for sample in self.reading.push(bytes)? {
            self.remember(sample);
            let mut poses = journal.poses.iter();
            if let Some(pose) = poses.find(|p| p.lines[1] == sample.line) {
                self.accept(pose.clone());
            }
        }
        Ok(self.take_events())
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
            gravity: self.options.gravity,
        };
        self.note(event, &format!("{name}{into}"))
    }

    /// Takes the next bytes of the recording, as they stand on the disk.
    ///
    /// # Errors
    ///
    /// Those of reading: no rows of a sensor. A faulty line is no error.
    pub fn bytes(&mut self, bytes: &[u8]) -> Result<Vec<Message>> {
        let samples = self.reading.push(bytes)?;
        self.samples(samples)
    }

    /// Takes the rows so far as they are, if the format is not known yet: the sensor is slow, or the
    /// recording has ended.
    ///
    /// # Errors
    ///
    /// Those of reading: so far it is no recording.
    pub fn settle_format(&mut self) -> Result<Vec<Message>> {
        let samples = self.reading.settle(1)?;
        self.samples(samples)
    }

    fn samples(&mut self, samples: Vec<Sample>) -> Result<Vec<Message>> {
        if self.reading.is_calibrated_by_board() {
            return Err(Error::input(
                "already-calibrated",
                "the board sends calibrated values, as the line with its settings says: a calibration needs raw ones",
            )
            .with_hint("gravical live --format si: with it the sketch sends raw values"));
        }
        for sample in samples {
            self.sample(sample)?;
        }
        Ok(self.take_events())
    }

    /// No rows arrive.
    pub fn lost(&mut self, why: Loss) -> Vec<Message> {
        if self.stop.is_none() {
            self.stop = Some(Stop::Lost);
            self.interrupt();
            let safe = self.safe();
            let text = match why {
                Loss::Unplugged => format!("Unplugged. {safe}Plug it back in."),
                Loss::Silent => {
                    format!("The board sends nothing. {safe}Check the cable, or press its reset.")
                }
            };
            let poses = self.poses.len() as u32;
            self.emit(Event::Lost { why, poses }, &text);
            self.status();
        }
        self.take_events()
    }

    /// Rows arrive again.
    pub fn resumed(&mut self) -> Vec<Message> {
        if self.stop != Some(Stop::Lost) {
            return Vec::new();
        }
        self.stop = None;
        // No status says that rows are lost once they are here again.
        self.status();
        self.recent.clear();
        self.progress_s = self.now_s;
        let poses = self.poses.len() as u32;
        let text = format!("Here again. {}", self.safe());
        self.emit(Event::Resumed { poses }, &text);
        self.fit();
        self.take_events()
    }

    /// Something for the record that only the program knows: what was saved, the end.
    pub fn note(&mut self, event: Event, text: &str) -> Vec<Message> {
        self.emit(event, text);
        self.take_events()
    }

    /// Does what the user wants. [`Command::Hand`] is for a simulated sensor, not for the session.
    pub fn command(&mut self, command: &Command) -> Vec<Message> {
        if self.is_done() {
            return Vec::new();
        }
        match command {
            Command::Capture => self.capture_now(),
            Command::Undo => match self.poses().last().map(|pose| pose.pose) {
                Some(last) => self.remove("The others are untouched.", |p| p.pose == last),
                None => self.refuse("There is no pose to undo."),
            },
            Command::Redo { face } => self.record_again(face),
            Command::Finish => self.finish(),
            Command::Gravity {
                value,
                latitude,
                altitude,
            } => self.set_gravity(*value, *latitude, *altitude),
            Command::Port { .. } | Command::Simulate => {
                self.refuse("The sensor was chosen: another one needs a new session.");
            }
            Command::Cancel => self.stop = Some(Stop::Done),
            Command::Resume => self.refuse("The session goes on already."),
            Command::Hand { .. } => self.refuse("This sensor is moved by hand, not by commands."),
        }
        self.take_events()
    }

    /// The calibration from the poses so far.
    #[must_use]
    pub fn calibration(&self) -> Option<&CalibrationFile> {
        self.file.as_ref()
    }

    /// The accepted poses.
    pub fn poses(&self) -> impl Iterator<Item = &Pose> {
        self.poses.iter().map(|(pose, _)| pose)
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

    // Events.

    pub(super) fn emit(&mut self, event: Event, text: &str) {
        self.events.push(Message::new(self.now_s, event, text));
    }

    fn take_events(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.events)
    }

    fn warn(&mut self, kind: WarningKind, text: &str) {
        self.emit(Event::Warning { kind }, text);
    }

    fn refuse(&mut self, why: &str) {
        self.warn(WarningKind::Refused, why);
    }

    /// A hold was not accepted.
    fn reject(&mut self, (reason, text): Fault) {
        self.progress_s = self.now_s;
        self.emit(Event::PoseRejected { reason }, &text);
    }

    /// That the poses are safe; nothing without any.
    pub(super) fn safe(&self) -> String {
        match self.poses.len() {
            0 => String::new(),
            1 => "1 pose is safe. ".to_owned(),
            n => format!("{n} poses are safe. "),
        }
    }

    // What is known.

    fn detector(&mut self) -> Option<&mut StillnessDetector> {
        match &mut self.phase {
            Phase::Identify => None,
            Phase::Floor(detector) | Phase::Poses(detector, _) => Some(detector),
        }
    }

    pub(super) fn is_identified(&self) -> bool {
        !matches!(self.phase, Phase::Identify)
    }

    /// The units, once the noise at rest is known.
    pub(super) fn units(&self) -> Option<Units> {
        match &self.phase {
            Phase::Poses(_, units) => Some(*units),
            _ => None,
        }
    }

    /// A value of the accelerometer in mg; NaN before the unit is known.
    pub(super) fn mg(&self, units: f64) -> f64 {
        self.units().map_or(f64::NAN, |u| mg(units / u.nominal))
    }

    /// The face was recorded.
    pub(super) fn is_recorded(&self, face: Face) -> bool {
        let name = Some(face.name());
        self.poses().any(|p| p.face == name)
    }

    pub(super) fn missing_faces(&self) -> Vec<Face> {
        Face::all()
            .into_iter()
            .filter(|f| !self.is_recorded(*f))
            .collect()
    }

    /// The temperature of the first pose that has one.
    pub(super) fn first_temperature_c(&self) -> Option<f64> {
        self.poses().find_map(|p| p.temperature_c)
    }

    /// The rows up to the last one, judged as a file: what arrived with it does not matter.
    fn recording(&self) -> Option<Result<Recording>> {
        self.reading.recording(self.last_line)
    }

    /// The rows among the recent ones.
    fn within(&self, rows: &Range<usize>) -> Vec<Sample> {
        let first = self.recent.front().map_or(0, |s| s.row);
        let at = |row: usize| row.saturating_sub(first).min(self.recent.len());
        let samples = self.recent.range(at(rows.start)..at(rows.end));
        samples.copied().collect()
    }

    /// Specific force of the last rows, unit of the recording.
    pub(super) fn reading(&self) -> [f64; 3] {
        let recent = self.recent.iter().rev();
        let recent = recent.take_while(|s| self.now_s - s.time_s <= SMOOTH_S);
        let samples: Vec<Sample> = recent.copied().collect();
        Means::of(&samples).accel
    }

    /// The calibration, where it is complete.
    fn full_fit(&self) -> Option<&CalibrationFile> {
        let file = self.file.as_ref();
        file.filter(|f| f.accelerometer.poses.len() >= FULL_FIT)
    }

    pub(super) fn grade(&self) -> Option<Grade> {
        self.full_fit().map(|file| file.verdict.grade)
    }

    /// The direction of the free pose that is wanted next.
    #[must_use]
    pub fn next_up(&self) -> Option<[f64; 3]> {
        let is_free = self.missing_faces().is_empty() && self.grade() != Some(Grade::Good);
        let next = self.file.as_ref()?.accelerometer.next_poses.first()?;
        is_free.then_some(next.direction)
    }

    /// The direction of a reading, as far as the sensor is known.
    pub(super) fn direction(&self, reading: [f64; 3]) -> [f64; 3] {
        let force = self.full_fit().map_or(reading, |file| {
            let section = &file.accelerometer;
            let offset = self.units().map_or(0.0, |u| u.zero_offset);
            let raw: [f64; 3] = std::array::from_fn(|i| reading[i] + offset - section.bias[i]);
            mul_vec(&section.matrix, &raw)
        });
        let size = norm(&force);
        if size > 0.0 {
            force.map(|v| v / size)
        } else {
            [0.0, 0.0, 1.0]
        }
    }

    /// Rows of a hold before its capture begins.
    pub(super) fn settle_rows(&self) -> usize {
        (self.options.settle_s * self.rate_hz).round() as usize
    }

    pub(super) fn capture_rows(&self) -> usize {
        ((self.options.capture_s * self.rate_hz).round() as usize).max(MIN_ROWS)
    }

    /// Rest before the noise is known, s.
    pub(super) fn floor_s(&self) -> f64 {
        self.options.settle_s + self.options.floor_s
    }

    // Rows.

    fn sample(&mut self, sample: Sample) -> Result<()> {
        let gap = sample.time_s - self.now_s > GAP_S.max(5.0 / self.rate_hz);
        if sample.row > 0 && (sample.is_break || gap) {
            self.interrupt();
        }
        let sample = self.remember(sample);
        let gyro_nominal = self.units().and_then(|u| u.gyro_nominal);
        let rate =
            gyro_nominal.map(|nominal| sub(&sample.gyro, &self.gyro_bias).map(|v| v / nominal));
        self.attitude.update(sample.time_s, sample.accel, rate);
        if self.is_identified() {
            self.detect(sample);
        } else {
            self.identify(&sample)?;
        }
        if sample.time_s - self.status_s >= STATUS_S - 1e-6 {
            self.status_s = sample.time_s;
            self.status();
        }
        Ok(())
    }

    /// Adds a row to the recent ones.
    fn remember(&mut self, mut sample: Sample) -> Sample {
        sample.time_s = if sample.time_s.is_finite() {
            // The last digits depend on what arrives at once.
            (sample.time_s * 1e9).round() / 1e9
        } else {
            self.now_s + sample.row.min(1) as f64 / self.rate_hz
        };
        self.now_s = sample.time_s;
        self.last_line = sample.line;
        self.recent.push_back(sample);
        let is_old = |s: &Sample| sample.time_s - s.time_s > RECENT_S;
        while self.recent.front().is_some_and(is_old) {
            self.recent.pop_front();
        }
        sample
    }

    /// No hold spans what comes.
    fn interrupt(&mut self) {
        if let Some(detector) = self.detector() {
            detector.split();
        }
        self.last = None;
        let hold = self.hold.take();
        if hold.is_some_and(|h| h.stage == HoldStage::Capturing) {
            let text = "Rows are missing in the middle of the capture. Hold it still once more.";
            self.reject((Rejection::Gaps, text.to_owned()));
        }
    }

    fn identify(&mut self, sample: &Sample) -> Result<()> {
        let untimed = sample.row as f64 >= IDENTIFY_S * Recording::ASSUMED_RATE_HZ;
        if sample.time_s < IDENTIFY_S && !untimed {
            return Ok(());
        }
        let Some(recording) = self.recording().transpose()? else {
            return Ok(());
        };
        let rate_hz = recording.timing.rate_hz();
        self.rate_hz = rate_hz.unwrap_or(self.rate_hz);
        let unit = recording.accel_scale.unit;
        let rate = rate_hz.map_or("rate unknown".to_owned(), |r| format!("{r:.1} Hz"));
        // Those of a recording without a header have no names.
        let columns = self.reading.form().map_or(0, |form| form.roles.len());
        let columns = count(columns, "column");
        let gyro = recording.gyro_scale.map_or("no", |_| "with");
        let first = format!("{rate}, {columns}, {unit}, {gyro} gyroscope");
        // A second is too short to say anything of the samples.
        let findings = recording.findings.iter();
        let notes = findings.filter(|f| !f.kind.is_of_samples());
        let notes = notes.map(|f| sentence(&f.message));
        let text: Vec<String> = std::iter::once(sentence(&first)).chain(notes).collect();
        let event = Event::Identified {
            rate_hz,
            unit,
            gyro_unit: recording.gyro_scale.map(|g| g.unit),
        };
        self.emit(event, &text.join(" "));
        self.phase = Phase::Floor(StillnessDetector::new(
            self.rate_hz,
            recording.resolution,
            RUN_S + self.options.settle_s + self.options.capture_s,
        ));
        self.progress_s = self.now_s;
        for earlier in self.recent.clone() {
            if earlier.is_break {
                self.interrupt();
            }
            self.detect(earlier);
        }
        Ok(())
    }

    /// True once the noise at rest and the unit are known.
    fn floor(&mut self, run: &Range<usize>, state: &Stillness) -> bool {
        if (run.len() as f64) < self.floor_s() * self.rate_hz {
            return false;
        }
        let samples = self.within(run);
        let norm = norm(&Means::of(&samples).accel);
        if state.noise > MAX_NOISE_AT_REST * norm || self.hold.as_ref().is_some_and(Hold::is_over) {
            return false;
        }
        let Some(Ok(recording)) = self.recording() else {
            return false;
        };
        let scale = recording.accel_scale;
        let gravity = self.options.gravity;
        // Counts of an unknown range are scaled by gravity itself.
        let counts = scale.unit == AccelUnit::Counts && scale.lsb_per_g.is_none();
        let by_gravity = counts.then_some(norm / gravity.value_mps2);
        let Some(nominal) = scale.nominal().or(by_gravity) else {
            self.set_stage(HoldStage::Over);
            let text = format!(
                "‖a‖ at rest is {norm:.4}: gravity in no unit. Raw values are needed, with gravity; or give the unit with --accel-unit."
            );
            self.reject((Rejection::Units, text));
            return false;
        };
        let units = Units {
            zero_offset: recording.zero_offset,
            nominal,
            scale,
            gyro_nominal: recording.gyro_scale.as_ref().and_then(GyroScale::nominal),
        };
        self.phase = match std::mem::replace(&mut self.phase, Phase::Identify) {
            Phase::Floor(detector) => Phase::Poses(detector, units),
            other => other,
        };
        let noise_mg = columns(&samples, |s| s.accel).map(|mut axis| {
            axis.retain(|v| v.is_finite());
            self.mg(standard_deviation(&axis))
        });
        let limit_mg = self.mg(state.max_scatter[0]);
        let [x, y, z] = noise_mg;
        let text = format!(
            "Noise at rest {x:.1}, {y:.1}, {z:.1} mg; above {limit_mg:.0} mg it counts as moving."
        );
        self.emit(Event::Floor { noise_mg, limit_mg }, &text);
        if gravity.source == GravitySource::Standard {
            let text = "Local gravity is not known, so the scale is uncertain by 0.15 % (1σ): give the latitude, or the value.";
            self.warn(WarningKind::Gravity, text);
        }
        self.progress_s = self.now_s;
        self.request_pose();
        true
    }

    // Holds.

    fn detect(&mut self, sample: Sample) {
        let Some(state) = self.detector().and_then(|d| d.push(sample)) else {
            return;
        };
        self.last = Some(state.clone());
        if state.run.is_some() && state.scatter[1].is_finite() {
            self.gyro_bias = state.gyro;
        }
        if self.stop.is_some() {
            return;
        }
        if let Some(run) = &state.run {
            self.extend_hold(run.clone(), &state);
            if self.units().is_some() || self.floor(run, &state) {
                self.note_departure();
                self.advance_hold();
            }
        } else {
            self.end_hold(&state);
        }
    }

    /// It moves: a capture that has begun is interrupted.
    fn end_hold(&mut self, state: &Stillness) {
        let hold = self.hold.take();
        if hold.as_ref().is_some_and(Hold::is_over) {
            // The user begins to turn it.
            self.progress_s = self.now_s;
        }
        if let Some(hold) = hold.filter(|h| h.stage == HoldStage::Capturing) {
            let progress_s = (hold.rows.len() as f64 / self.rate_hz) - self.options.settle_s;
            if progress_s > MIN_PROGRESS * self.options.capture_s {
                let [scatter, limit] = [state.scatter, state.max_scatter].map(|scatter| scatter[0]);
                let text = if scatter > limit {
                    format!(
                        "It moved after {progress_s:.1} s: {:.0} mg, limit {:.0} mg. {LET_GO}",
                        self.mg(scatter),
                        self.mg(limit)
                    )
                } else {
                    format!("It turned after {progress_s:.1} s. {LET_GO}")
                };
                self.reject((Rejection::Moved, text));
            }
        }
        self.note_departure();
    }

    /// The hold that the run belongs to.
    fn extend_hold(&mut self, run: Range<usize>, state: &Stillness) {
        let settle = self.settle_rows();
        // Where a capture drifts, what was captured does not agree with what is read now.
        let drifts =
            |h: &Hold| h.stage == HoldStage::Capturing && run.start > h.rows.start + settle;
        if self.hold.as_ref().is_some_and(drifts) {
            self.end_hold(state);
        }
        match &mut self.hold {
            Some(hold) if run.start < hold.rows.end => hold.rows.end = run.end,
            _ => self.hold = Some(Hold::new(run, false)),
        }
    }

    /// Notes that it has left the last pose.
    fn note_departure(&mut self) {
        if let Some((last, _)) = self.poses.last() {
            let angle = angle_deg(last.up, self.direction(self.reading()));
            self.has_departed |= angle > APART_DEG;
        }
    }

    fn set_stage(&mut self, stage: HoldStage) {
        if let Some(hold) = &mut self.hold {
            hold.stage = stage;
        }
    }

    /// The hold goes on: it settles, is captured, is over.
    fn advance_hold(&mut self) {
        let Some(hold) = self.hold.clone().filter(|hold| !hold.is_over()) else {
            return;
        };
        let Some(units) = self.units() else { return };
        let from = hold.rows.start + self.settle_rows();
        let end = from + self.capture_rows();
        if hold.rows.end <= from {
            return;
        }
        if hold.stage == HoldStage::Settling {
            let accel = Means::of(&self.within(&hold.rows)).accel;
            let up = self.direction(accel);
            let welcome = self.welcome(up);
            // Where the magnitude is not that of gravity the direction says nothing; the capture
            // finds what is wrong.
            let is_gravity = units
                .fault(accel, self.options.gravity.value_mps2)
                .is_none();
            let fault = self.refusal(welcome, up);
            if let Some(fault) = fault.filter(|_| is_gravity && !hold.forced) {
                self.set_stage(HoldStage::Over);
                // A bump on the pose that was just accepted is not worth a word.
                if welcome != Welcome::Duplicate || self.has_departed {
                    self.reject(fault);
                }
                return;
            }
            self.set_stage(HoldStage::Capturing);
            self.emit(Event::PoseCandidate, "The capture begins.");
        }
        if hold.rows.end >= end {
            self.judge(&(from..end), hold.forced, &units);
        }
    }

    /// What a hold in this direction would be.
    pub(super) fn welcome(&self, up: [f64; 3]) -> Welcome {
        let face = face_up(up);
        let kind = face.map_or(Welcome::Free, |_| Welcome::Face);
        if self.options.any_pose || face.is_some_and(|f| !self.is_recorded(f)) {
            return kind;
        }
        // A steep face that is done leaves room for a free pose beside it only if it is far.
        if self.poses().any(|p| angle_deg(p.up, up) < APART_DEG) {
            Welcome::Duplicate
        } else if face.is_some() || self.missing_faces().is_empty() {
            kind
        } else {
            Welcome::Between
        }
    }

    fn refusal(&self, welcome: Welcome, up: [f64; 3]) -> Option<Fault> {
        let (face, tilt_deg) = Face::nearest(up);
        let name = face.name();
        let missing = self.missing_faces();
        let faces = any_of(&missing);
        Some(match welcome {
            Welcome::Face | Welcome::Free => return None,
            Welcome::Duplicate if self.redo.contains(&face.opposite()) => {
                let wanted = face.opposite().name();
                let text = format!(
                    "{name} is up, and {wanted} is to be recorded again. Turn it over: {wanted} up."
                );
                (Rejection::Sign, text)
            }
            Welcome::Duplicate => {
                let what = match face_up(up) {
                    Some(_) => name,
                    None => format!("A pose within {APART_DEG:.0}°"),
                };
                let next = if missing.is_empty() {
                    "another direction"
                } else {
                    &faces
                };
                let text =
                    format!("{what} is recorded already. Turn it to {next}, or redo that face.");
                (Rejection::Duplicate, text)
            }
            Welcome::Between => {
                let text = format!(
                    "It lies between two faces: {tilt_deg:.0}° from {name}. Put {faces} up; or take it all the same, as a free pose."
                );
                (Rejection::BetweenFaces, text)
            }
        })
    }

    /// Accepts or rejects a capture.
    fn judge(&mut self, rows: &Range<usize>, forced: bool, units: &Units) {
        let samples = self.within(rows);
        let fault = self.fault(&samples, rows.len(), units, forced);
        // What was judged stays judged: the next try begins where this one ended.
        if let Some(hold) = &mut self.hold {
            *hold = Hold::new(rows.end..hold.rows.end, forced);
            let again = |fault: &Fault| matches!(fault.0, Rejection::Moved | Rejection::Gaps);
            if !fault.as_ref().is_some_and(again) {
                hold.stage = HoldStage::Over;
            }
        }
        self.progress_s = self.now_s;
        if let Some(fault) = fault {
            self.reject(fault);
            return;
        }
        let [Some(first), Some(last)] = [samples.first(), samples.last()] else {
            return;
        };
        let means = Means::of(&samples);
        let up = self.direction(means.accel);
        self.numbers += 1;
        self.accept(Pose {
            pose: self.numbers,
            face: face_up(up).map(Face::name),
            up,
            tilt_deg: Face::nearest(up).1,
            mean: means.accel,
            norm_mps2: norm(&means.accel) / units.nominal,
            noise_mg: self.mg(means.scatter[0]),
            temperature_c: means.temperature_c,
            seconds: last.time_s - first.time_s + 1.0 / self.rate_hz,
            lines: [first.line, last.line],
        });
        self.fit();
    }

    // Poses.

    fn accept(&mut self, pose: Pose) {
        let [first, last] = pose.lines;
        let samples = self.recent.iter();
        let samples = samples.filter(|s| (first..=last).contains(&s.line));
        let gyro = Means::of(&samples.copied().collect::<Vec<_>>()).gyro;
        self.redo.retain(|face| Some(face.name()) != pose.face);
        self.poses.push((pose.clone(), gyro));
        self.has_departed = false;
        let name = pose.face.as_deref().unwrap_or(FREE_POSE);
        let faces = 6 - self.missing_faces().len();
        let free = self.poses().filter(|p| p.face.is_none()).count();
        let mut text = format!(
            "{name} is done. ‖a‖ {:.3} m/s², noise {:.1} mg ({faces} of 6 faces, {free} free).",
            pose.norm_mps2, pose.noise_mg
        );
        if pose.face.is_some() && pose.tilt_deg > FINE_TILT_DEG {
            text += &format!(
                " {:.0}° from {name}: a pose nearer to the face determines the axes better.",
                pose.tilt_deg
            );
        }
        let now_c = pose.temperature_c;
        self.emit(Event::PoseAccepted(pose), &text);
        let change_c = now_c
            .zip(self.first_temperature_c())
            .map_or(0.0, |(now, first)| now - first);
        if change_c.abs() > WARMED_C && !self.warned_of_temperature {
            self.warned_of_temperature = true;
            let text = format!(
                "{}: let it run for some minutes before the session.",
                warming(change_c)
            );
            self.warn(WarningKind::Temperature, &text);
        }
    }

    fn capture_now(&mut self) {
        let most_rows = self.settle_rows() + self.capture_rows();
        let has_units = self.units().is_some();
        match &mut self.hold {
            Some(hold) if has_units => {
                // What it has rested already counts.
                let earliest = hold.rows.end.saturating_sub(most_rows);
                let start = hold.rows.start.max(earliest);
                *hold = Hold::new(start..hold.rows.end, true);
            }
            _ => self.refuse("It moves: hold it still first."),
        }
    }

    fn record_again(&mut self, name: &str) {
        let Some(face) = face_of(name) else {
            self.refuse("A face is +x, -x, +y, -y, +z or -z.");
            return;
        };
        if self.is_recorded(face) && !self.redo.contains(&face) {
            self.redo.push(face);
        }
        let name = face.name();
        let next = format!("Put {name} up again.");
        self.remove(&next, |pose| pose.face.as_ref() == Some(&name));
    }

    fn remove(&mut self, next: &str, is_gone: impl Fn(&Pose) -> bool) {
        let poses = std::mem::take(&mut self.poses);
        let (gone, left): (Vec<_>, _) = poses.into_iter().partition(|(p, _)| is_gone(p));
        self.poses = left;
        for (Pose { pose, face, .. }, _) in gone {
            let name = face.as_deref().unwrap_or(FREE_POSE);
            let text = format!("Pose {pose} ({name}) no longer counts. {next}");
            self.emit(Event::PoseUndone { pose, face }, &text);
        }
        self.has_departed = true;
        self.progress_s = self.now_s;
        if let Some(hold) = &mut self.hold {
            // The pose that lies there now may be wanted again.
            *hold = Hold::new(hold.rows.end..hold.rows.end, hold.forced);
        }
        self.fit();
    }

    // The calibration of the poses so far.

    /// Calibrates, and says which pose is wanted next: the poses or gravity have changed.
    fn fit(&mut self) {
        let before = self.grade();
        let fitted = (self.poses.len() >= FIRST_FIT).then(|| self.calibrated());
        let fitted = fitted.transpose().unwrap_or_else(|error| {
            if self.poses.len() >= FULL_FIT {
                self.warn(WarningKind::Other, &error.to_string());
            }
            None
        });
        if let Some(file) = &fitted {
            self.show_fit(file);
        }
        self.file = fitted;
        let full = self.full_fit().filter(|_| self.grade() != before);
        if let Some((event, text)) = full.map(|file| verdict(file, false)) {
            self.emit(event, &text);
        }
        self.request_pose();
    }

    fn calibrated(&self) -> Result<CalibrationFile> {
        let recording = self.recording().transpose()?;
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

    /// Shows the figures of a calibration of the poses so far.
    fn show_fit(&mut self, file: &CalibrationFile) {
        let section = &file.accelerometer;
        let fit = Fit {
            bias_mg: [0, 1, 2].map(|i| mg(section.bias[i] / section.scale[i])),
            worst_mg: section.worst_direction.as_ref().map(|w| mg(w.error_mps2)),
            leave_one_out_mg: section.leave_one_out_rms_mps2.map(mg),
            undetected_mg: section.undetected.as_ref().map(|u| mg(u.effect_mps2)),
            poses: self.poses.len() as u32,
            suspect: self.suspect(file).map(|pose| pose.pose),
        };
        let [x, y, z] = fit.bias_mg;
        let mg = |value: Option<f64>| {
            value.map_or("unknown".to_owned(), |v| {
                format!("{} mg", numfmt::digits(v, 2))
            })
        };
        let text = format!(
            "Bias {x:.1}, {y:.1}, {z:.1} mg; error of ‖a‖ at most {} (95 %); leave-one-out {}; {}.",
            mg(fit.worst_mg),
            mg(fit.leave_one_out_mg),
            file.verdict.grade
        );
        self.emit(Event::Fit(Box::new(fit)), &text);
    }

    /// The pose that contradicts the others.
    pub(super) fn suspect(&self, file: &CalibrationFile) -> Option<&Pose> {
        let (index, _) = file.accelerometer.contradiction()?;
        self.poses().nth(index)
    }

    /// Says which pose is wanted next.
    fn request_pose(&mut self) {
        let missing = self.missing_faces();
        let up = self.next_up();
        let hint = up.map(in_words);
        let (kind, text) = if !missing.is_empty() {
            (Wanted::Face, format!("Next: {} up.", any_of(&missing)))
        } else if self.grade() == Some(Grade::Good) {
            let text = "Good: it can be saved; more poses make it better.";
            (Wanted::None, text.to_owned())
        } else {
            let hint = hint.as_deref().unwrap_or("any new direction");
            (Wanted::Free, format!("Next, a free pose: {hint}."))
        };
        let event = Event::NextPose {
            kind,
            faces: missing.iter().map(|f| f.name()).collect(),
            up,
            hint,
        };
        self.emit(event, &text);
    }

    fn set_gravity(&mut self, value: Option<f64>, latitude: Option<f64>, altitude: Option<f64>) {
        let gravity = match (value, latitude) {
            (Some(value), None) => Gravity::given(value),
            (None, Some(latitude)) => Gravity::at(latitude, altitude.unwrap_or(0.0)),
            _ => return self.refuse("Gravity is given by a value, or by the latitude."),
        };
        match gravity {
            Ok(gravity) => {
                self.options.gravity = gravity;
                let text = format!("Local gravity is {:.5} m/s².", gravity.value_mps2);
                self.emit(Event::Gravity(gravity), &text);
                self.fit();
            }
            Err(error) => self.refuse(error.message()),
        }
    }

    fn finish(&mut self) {
        if let Some((event, text)) = self.file.as_ref().map(|file| verdict(file, true)) {
            self.stop = Some(Stop::Done);
            self.emit(event, &text);
        } else {
            let poses = count(self.poses.len(), "pose");
            self.refuse(&format!(
                "With {poses} nothing is determined yet: at least {FIRST_FIT} are needed, better six faces and three free poses."
            ));
        }
    }
}

/// The face that a direction has up, if one is.
pub(super) fn face_up(up: [f64; 3]) -> Option<Face> {
    let (face, tilt_deg) = Face::nearest(up);
    (tilt_deg <= MAX_FACE_ANGLE_DEG).then_some(face)
}

/// The verdict, and what it says of the accuracy in a sentence.
fn verdict(file: &CalibrationFile, r#final: bool) -> (Event, String) {
    let grade = file.verdict.grade;
    let reasons = file.verdict.reasons.clone();
    let section = &file.accelerometer;
    let error = section.worst_direction.as_ref().map_or(String::new(), |w| {
        let most_mg = numfmt::mg(w.error_mps2);
        format!("error of ‖a‖ at most {most_mg} mg (95 %)")
    });
    // Where this is the larger error, it decides the grade.
    let most = section.worst_direction.as_ref().map(|w| w.error_mps2);
    let hidden = section.undetected.as_ref().map(|u| u.effect_mps2);
    let is_tested = hidden
        .zip(most)
        .is_some_and(|(hidden, most)| hidden <= most);
    let undetected =
        section
            .undetected
            .as_ref()
            .map_or("no pose is left to test the others".to_owned(), |u| {
                let most_mg = numfmt::mg(u.effect_mps2);
                format!("an error of one pose could change ‖a‖ by {most_mg} mg undetected")
            });
    let text = match grade {
        Grade::Good => format!("Good: {error}, verified."),
        Grade::Fair if is_tested => format!("Fair: {error}; more free poses reduce it."),
        Grade::Fair => format!("Fair: {error}, but {undetected}; more free poses test it."),
        Grade::NotVerifiable => {
            format!("Not verifiable yet: {undetected}; more free poses test it.")
        }
        Grade::Poor => format!("Poor: {}", reasons.first().map_or("", String::as_str)),
    };
    let event = Event::Verdict {
        grade,
        r#final,
        reasons,
    };
    (event, text)
}
