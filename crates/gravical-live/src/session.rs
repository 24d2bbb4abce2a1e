//! The state machine: how far a session is, its holds, poses and calibration.

use std::collections::VecDeque;
use std::ops::Range;

use gravical_core::matrix3::{mul_vec, norm};
use gravical_recording::Sample;

use gravical_calibrate::calibrate::{CalibrateOptions, calibrate};
use gravical_calibrate::calibration_file::{Calibration, Grade, GravitySource};
use gravical_calibrate::gravity::Gravity;
use gravical_calibrate::poses::face::{Face, angle_deg, in_words};
use gravical_calibrate::poses::{MAX_FACE_ANGLE_DEG, SegmentOptions};
use gravical_calibrate::recording::units::{AccelUnit, GyroScale};
use gravical_calibrate::recording::{Follow, Recording};
use gravical_judge::Result;
use gravical_judge::numfmt::{self, count, milli_g};
use gravical_signal::stats::mean_of_finite;

use crate::event::{Command, Event, Loss, Message, Pose, Rejection, State, Status, Tile, Wanted};
use crate::folder::{Journal, section};
use crate::options::LiveOptions;
use crate::problem::Problem;
use crate::rest::{Fault, RELEASE_HINT, Stillness, StillnessDetector, UNSCALED, Units, block};
use crate::words::{any_of, face_of, sentence};

/// Poses closer than this are the same, degrees.
const APART_DEG: f64 = 25.0;
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
/// without low-pass. Where the quietest hold scatters more, the sensor has not rested yet.
const MAX_NOISE_AT_REST: f64 = 0.035;
/// A gyroscope of 16 bits and ±250 °/s.
const FINE_COUNTS_PER_DEG_S: f64 = 131.0;
/// Rows of a capture at least: a variance of fewer says little.
const MIN_ROWS: usize = 5;
/// A capture that is interrupted earlier was none, share of its length.
const MIN_PROGRESS: f64 = 0.15;
/// A pose this much warmer or colder than the first is refused, °C.
const MAX_WARMING_C: f64 = 3.0;
/// A face that is tilted by more than this is noted, degrees.
const FINE_TILT_DEG: f64 = 10.0;
/// Time between two status events, s.
const STATUS_S: f64 = 0.1;
/// After this time without progress the status says which test fails, s.
const HINT_AFTER_S: f64 = 5.0;
/// From this many poses on, a fit is tried, and from this many on it is complete.
const FIRST_FIT: usize = 4;
const FULL_FIT: usize = 6;
/// Beyond this many poses that were not asked for, the next fit waits until there are a tenth more.
const MANY_POSES: usize = 20;

/// Rest without interruption.
#[derive(Debug, Clone)]
struct Hold {
    /// Its rows.
    rows: Range<usize>,
    /// It was refused, accepted or rejected: nothing happens until it moves.
    is_over: bool,
    /// Whatever can be overruled is: the user wants this pose.
    forced: bool,
}

/// A guided calibration. It belongs to one thread.
pub struct Session {
    options: LiveOptions,
    reading: Follow,
    /// The last rows.
    recent: VecDeque<Sample>,
    /// Line of the last row.
    last_line: u32,
    /// None before columns and clock are known.
    detector: Option<StillnessDetector>,
    /// None before the noise at rest is known.
    units: Option<Units>,
    /// Why nothing happens: no rows arrive, or the user has finished or cancelled it.
    stop: Option<State>,
    /// What the last block said; none after rows that are missing.
    last: Option<Stillness>,
    rate_hz: f64,
    hold: Option<Hold>,
    /// The accepted poses.
    poses: Vec<Pose>,
    /// Numbers of poses that were used.
    numbers: u32,
    /// Faces to record again.
    redo: Vec<Face>,
    /// The calibration of the poses so far, and how many it was tried with.
    file: Option<Calibration>,
    fitted: usize,
    /// Time of the last row, of the last progress, and of the last status, s.
    now_s: f64,
    progress_s: f64,
    status_s: f64,
    events: Vec<Message>,
}

impl Session {
    /// A session that reads the recording `name`.
    pub fn new(name: &str, options: LiveOptions) -> Self {
        let rate_hz = options.read.rate_hz.unwrap_or(Recording::ASSUMED_RATE_HZ);
        Session {
            reading: Follow::new(name, options.read.clone(), usize::MAX),
            options,
            recent: VecDeque::new(),
            last_line: 0,
            detector: None,
            units: None,
            stop: None,
            last: None,
            rate_hz,
            hold: None,
            poses: Vec::new(),
            numbers: 0,
            redo: Vec::new(),
            file: None,
            fitted: 0,
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
        self.stop = Some(State::Lost);
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
        let samples = self.reading.settle()?;
        self.samples(samples)
    }

    fn samples(&mut self, samples: Vec<Sample>) -> Result<Vec<Message>> {
        if self.reading.is_calibrated_by_board() {
            return Err(Problem::AlreadyCalibrated.error().advise("format", "si"));
        }
        for sample in samples {
            self.sample(sample)?;
        }
        Ok(self.take_events())
    }

    /// No rows arrive.
    pub fn lost(&mut self, why: Loss) -> Vec<Message> {
        if self.stop.is_none() {
            self.stop = Some(State::Lost);
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
        if self.stop != Some(State::Lost) {
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

    /// Does what the user wants. [`Command::Hand`] is for a simulated sensor, not for the session.
    pub fn command(&mut self, command: &Command) -> Vec<Message> {
        if self.is_done() {
            return Vec::new();
        }
        match command {
            Command::Capture => self.capture_now(),
            Command::Undo => match self.poses.last().map(|pose| pose.pose) {
                Some(last) => self.remove("The others are untouched.", |p| p.pose == last),
                None => self.warn("There is no pose to undo."),
            },
            Command::Redo { face } => self.record_again(face),
            Command::Finish => self.finish(),
            Command::Gravity { value, latitude } => self.set_gravity(*value, *latitude),
            Command::Cancel => self.stop = Some(State::Done),
            Command::Hand { .. } => self.warn("This sensor is moved by hand, not by commands."),
            Command::Resume | Command::Port { .. } | Command::Simulate => {
                self.warn("The session has begun; another sensor needs another session.");
            }
        }
        self.take_events()
    }

    /// The calibration from the poses so far.
    pub fn calibration(&self) -> Option<&Calibration> {
        self.file.as_ref()
    }

    /// The accepted poses.
    pub fn poses(&self) -> impl Iterator<Item = &Pose> {
        self.poses.iter()
    }

    /// Local gravity.
    pub fn gravity(&self) -> Gravity {
        self.options.gravity
    }

    /// True once the user has finished or cancelled.
    pub fn is_done(&self) -> bool {
        self.stop == Some(State::Done)
    }

    // Events.

    fn emit(&mut self, event: Event, text: &str) {
        self.events.push(Message::new(self.now_s, event, text));
    }

    fn take_events(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.events)
    }

    fn warn(&mut self, text: &str) {
        self.emit(Event::Warning, text);
    }

    /// A hold was not accepted.
    fn reject(&mut self, (reason, text): Fault) {
        self.progress_s = self.now_s;
        self.emit(Event::PoseRejected { reason }, &text);
    }

    /// That the poses are safe; nothing without any.
    fn safe(&self) -> String {
        match self.poses.len() {
            0 => String::new(),
            1 => "1 pose is safe. ".to_owned(),
            n => format!("{n} poses are safe. "),
        }
    }

    // What is known.

    /// The face was recorded.
    fn is_recorded(&self, face: Face) -> bool {
        let name = Some(face.name());
        self.poses.iter().any(|p| p.face == name)
    }

    fn missing_faces(&self) -> Vec<Face> {
        let all = Face::all().into_iter();
        all.filter(|face| !self.is_recorded(*face)).collect()
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
    fn reading(&self) -> [f64; 3] {
        let recent = self.recent.iter().rev();
        let recent = recent.take_while(|s| self.now_s - s.time_s <= SMOOTH_S);
        let samples: Vec<Sample> = recent.copied().collect();
        block(&samples, UNSCALED).sensor_mean(0)
    }

    /// The calibration, where it is complete.
    fn full_fit(&self) -> Option<&Calibration> {
        let file = self.file.as_ref();
        file.filter(|f| f.poses.len() >= FULL_FIT)
    }

    fn grade(&self) -> Option<Grade> {
        self.full_fit().map(|file| file.grade())
    }

    /// The direction of the free pose that is wanted next.
    pub fn next_up(&self) -> Option<[f64; 3]> {
        let is_free = self.missing_faces().is_empty() && self.grade() != Some(Grade::Good);
        let next = self.file.as_ref()?.reliability.next_poses.first()?;
        is_free.then_some(next.direction)
    }

    /// The direction of a reading, as far as the sensor is known.
    fn direction(&self, reading: [f64; 3]) -> [f64; 3] {
        let force = self.full_fit().map_or(reading, |file| {
            let section = &file.accelerometer;
            let offset = self.units.map_or(0.0, |u| u.zero_offset);
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
    fn settle_rows(&self) -> usize {
        (self.options.settle_s * self.rate_hz).round() as usize
    }

    fn capture_rows(&self) -> usize {
        ((self.options.capture_s * self.rate_hz).round() as usize).max(MIN_ROWS)
    }

    /// A capture has begun.
    fn is_capturing(&self, hold: &Hold) -> bool {
        self.units.is_some() && !hold.is_over && hold.rows.len() > self.settle_rows()
    }

    /// Rest before the noise is known, s.
    fn floor_s(&self) -> f64 {
        self.options.settle_s + self.options.floor_s
    }

    // Rows.

    fn sample(&mut self, sample: Sample) -> Result<()> {
        let gap = sample.time_s - self.now_s > GAP_S.max(5.0 / self.rate_hz);
        if sample.row > 0 && (sample.is_break || gap) {
            self.interrupt();
        }
        let sample = self.remember(sample);
        if self.detector.is_some() {
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
        if let Some(detector) = &mut self.detector {
            detector.split();
        }
        self.last = None;
        let hold = self.hold.take();
        if hold.is_some_and(|hold| self.is_capturing(&hold)) {
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
        let rate_hz = recording.clock.rate_hz();
        self.rate_hz = rate_hz.unwrap_or(self.rate_hz);
        let unit = recording.units.accel.unit;
        let rate = rate_hz.map_or("rate unknown".to_owned(), |r| format!("{r:.1} Hz"));
        let columns = self.reading.form().map_or(0, |form| form.roles.len());
        let columns = count(columns, "column");
        let gyro = recording.units.gyro.map_or("no", |_| "with");
        let mut text = sentence(&format!("{rate}, {columns}, {unit}, {gyro} gyroscope"));
        // A second is too short to say anything of the samples.
        for finding in &recording.findings {
            if !finding.is_of_samples() {
                text += &format!(" {}", sentence(&finding.message));
            }
        }
        let event = Event::Identified {
            rate_hz,
            unit,
            gyro_unit: recording.units.gyro.map(|g| g.unit),
        };
        self.emit(event, &text);
        // What no unit is known of: gravity is gravity, and counts of a gyroscope are fine ones.
        let magnitude = norm(&self.reading());
        let by_gravity = || {
            if magnitude > 0.0 {
                magnitude / self.options.gravity.value_mps2
            } else {
                1.0
            }
        };
        let per_rad_s = recording.units.gyro.and_then(|g| g.nominal());
        let scale = [
            recording.units.accel.nominal().unwrap_or_else(by_gravity),
            per_rad_s.unwrap_or(FINE_COUNTS_PER_DEG_S * 1.0_f64.to_degrees()),
        ];
        self.detector = Some(StillnessDetector::new(
            self.rate_hz,
            scale,
            recording.units.resolution,
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
        let rest = block(&samples, UNSCALED);
        let norm = norm(&rest.sensor_mean(0));
        let noise = rest.total_variance(0).sqrt();
        if noise > MAX_NOISE_AT_REST * norm || self.hold.as_ref().is_some_and(|h| h.is_over) {
            return false;
        }
        let Some(Ok(recording)) = self.recording() else {
            return false;
        };
        let scale = recording.units.accel;
        let gravity = self.options.gravity;
        // Counts of an unknown range are scaled by gravity itself.
        let counts = scale.unit == AccelUnit::Counts && scale.lsb_per_g.is_none();
        let by_gravity = counts.then_some(norm / gravity.value_mps2);
        let Some(nominal) = scale.nominal().or(by_gravity) else {
            self.end_try();
            let text = format!(
                "‖a‖ at rest is {norm:.4}: gravity in no unit. Raw values are needed, with gravity."
            );
            self.reject((Rejection::Units, text));
            return false;
        };
        self.units = Some(Units {
            zero_offset: recording.units.zero_offset,
            nominal,
            scale,
            gyro_nominal: recording.units.gyro.as_ref().and_then(GyroScale::nominal),
            gyro_bias: rest.sensor_mean(1),
        });
        let noise_mg = milli_g(noise / nominal);
        let limit_mg = milli_g(state.limit[0].sqrt());
        let text =
            format!("Noise at rest {noise_mg:.1} mg; above {limit_mg:.0} mg it counts as moving.");
        self.emit(Event::Floor, &text);
        for finding in recording.frozen_axes() {
            self.warn(&finding.message);
        }
        if gravity.source == GravitySource::Standard {
            let text = "Local gravity is not known, so the scale is uncertain by 0.3 %: give the latitude, or the value.";
            self.emit(Event::Gravity(gravity), text);
        }
        self.progress_s = self.now_s;
        let (event, text) = self.next_step();
        self.emit(event, &text);
        true
    }

    // Holds.

    fn detect(&mut self, sample: Sample) {
        let Some(state) = self.detector.as_mut().and_then(|d| d.push(sample)) else {
            return;
        };
        self.last = Some(state.clone());
        if self.stop.is_some() {
            return;
        }
        let Some(run) = &state.run else {
            self.end_hold();
            return;
        };
        self.extend_hold(run.clone());
        if self.units.is_some() || self.floor(run, &state) {
            self.advance_hold();
        }
    }

    /// It moves: a capture that has begun is interrupted.
    fn end_hold(&mut self) {
        let Some(hold) = self.hold.take() else { return };
        if hold.is_over {
            // The user begins to turn it.
            self.progress_s = self.now_s;
            return;
        }
        let progress_s = hold.rows.len() as f64 / self.rate_hz - self.options.settle_s;
        if self.units.is_some() && progress_s > MIN_PROGRESS * self.options.capture_s {
            let text = format!("It moved after {progress_s:.1} s. {RELEASE_HINT}");
            self.reject((Rejection::Moved, text));
        }
    }

    /// The hold that the run belongs to.
    fn extend_hold(&mut self, run: Range<usize>) {
        let settle = self.settle_rows();
        // Where a capture drifts, what was captured does not agree with what is read now.
        let drifts = |h: &Hold| self.is_capturing(h) && run.start > h.rows.start + settle;
        if self.hold.as_ref().is_some_and(drifts) {
            self.end_hold();
        }
        match &mut self.hold {
            Some(hold) if run.start < hold.rows.end => hold.rows.end = run.end,
            _ => {
                self.hold = Some(Hold {
                    rows: run,
                    is_over: false,
                    forced: false,
                });
            }
        }
    }

    fn end_try(&mut self) {
        if let Some(hold) = &mut self.hold {
            hold.is_over = true;
        }
    }

    /// The hold goes on: it settles, is captured, is over.
    fn advance_hold(&mut self) {
        let (Some(hold), Some(units)) = (self.hold.clone(), self.units) else {
            return;
        };
        if !self.is_capturing(&hold) {
            return;
        }
        let mean = block(&self.within(&hold.rows), UNSCALED).sensor_mean(0);
        let up = self.direction(mean);
        // Where the magnitude is not that of gravity the direction says nothing; the capture finds
        // what is wrong.
        let gravity_mps2 = self.options.gravity.value_mps2;
        let is_judged = !hold.forced && units.magnitude_fault(mean, gravity_mps2).is_none();
        if let Some(fault) = self.refusal(up).filter(|_| is_judged) {
            self.end_try();
            // That the last pose still lies there is not worth a word.
            let is_last = |last: &Pose| angle_deg(last.up, up) < APART_DEG;
            if !self.poses.last().is_some_and(is_last) {
                self.reject(fault);
            }
            return;
        }
        let from = hold.rows.start + self.settle_rows();
        let end = from + self.capture_rows();
        if hold.rows.end >= end {
            self.judge(&(from..end), hold.forced, &units);
        }
    }

    /// Why a hold in this direction is not wanted.
    fn refusal(&self, up: [f64; 3]) -> Option<Fault> {
        let face = face_up(up);
        if self.options.any_pose || face.is_some_and(|f| !self.is_recorded(f)) {
            return None;
        }
        let (nearest, tilt_deg) = Face::nearest(up);
        let nearest = nearest.name();
        let missing_faces = self.missing_faces();
        let missing = any_of(&missing_faces);
        // A steep face that is done leaves room for a free pose beside it only if it is far.
        if self.poses.iter().any(|p| angle_deg(p.up, up) < APART_DEG) {
            let what = match face {
                Some(_) => nearest,
                None => format!("A pose within {APART_DEG:.0}°"),
            };
            let text =
                format!("{what} is recorded already. Turn it to {missing}, or redo that face.");
            return Some((Rejection::Duplicate, text));
        }
        (face.is_none() && !missing_faces.is_empty()).then(|| {
            let text = format!(
                "It lies between two faces: {tilt_deg:.0}° from {nearest}. Put {missing} up; or take it all the same, as a free pose."
            );
            (Rejection::BetweenFaces, text)
        })
    }

    /// Accepts or rejects a capture.
    fn judge(&mut self, rows: &Range<usize>, forced: bool, units: &Units) {
        let samples = self.within(rows);
        let capture = block(&samples, UNSCALED);
        let temperature_c = mean_of_finite(samples.iter().map(|s| &s.temperature_c));
        let temperature_c = Some(temperature_c).filter(|t| t.is_finite());
        let gravity_mps2 = self.options.gravity.value_mps2;
        let fault = units
            .fault(&samples, &capture, gravity_mps2)
            .or_else(|| self.warming(temperature_c?).filter(|_| !forced));
        // What was judged stays judged: the next try begins where this one ended.
        if let Some(hold) = &mut self.hold {
            hold.rows.start = rows.end;
            hold.is_over = !fault.as_ref().is_some_and(|f| f.0 == Rejection::Moved);
        }
        self.progress_s = self.now_s;
        if let Some(fault) = fault {
            self.reject(fault);
            return;
        }
        let [Some(first), Some(last)] = [samples.first(), samples.last()] else {
            return;
        };
        let mean = capture.sensor_mean(0);
        let up = self.direction(mean);
        self.numbers += 1;
        self.accept(Pose {
            pose: self.numbers,
            face: face_up(up).map(Face::name),
            up,
            tilt_deg: Face::nearest(up).1,
            mean,
            norm_mps2: norm(&mean) / units.nominal,
            noise_mg: milli_g(capture.total_variance(0).sqrt() / units.nominal),
            temperature_c,
            seconds: last.time_s - first.time_s + 1.0 / self.rate_hz,
            lines: [first.line, last.line],
        });
        let poses = self.poses.len();
        let waits = self.options.any_pose && poses > MANY_POSES && 10 * poses < 11 * self.fitted;
        if !waits {
            self.fit();
        }
    }

    fn warming(&self, temperature_c: f64) -> Option<Fault> {
        let first_c = self.poses.iter().find_map(|p| p.temperature_c)?;
        let change_c = temperature_c - first_c;
        let how = if change_c > 0.0 { "warmer" } else { "colder" };
        (change_c.abs() > MAX_WARMING_C && !self.options.any_pose).then(|| {
            let text = format!(
                "The sensor is {:.1} °C {how} than in the first pose: its bias has drifted. Wait until it is as before; or take it all the same, or undo the old poses one by one.",
                change_c.abs()
            );
            (Rejection::Temperature, text)
        })
    }

    // Poses.

    fn accept(&mut self, pose: Pose) {
        self.redo.retain(|face| Some(face.name()) != pose.face);
        self.poses.push(pose.clone());
        let name = called(&pose);
        let faces = 6 - self.missing_faces().len();
        let free = self.poses.iter().filter(|p| p.face.is_none()).count();
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
        self.emit(Event::PoseAccepted(pose), &text);
    }

    fn capture_now(&mut self) {
        let most_rows = self.settle_rows() + self.capture_rows();
        let has_units = self.units.is_some();
        match &mut self.hold {
            Some(hold) if has_units => {
                // What it has rested already counts.
                let earliest = hold.rows.end.saturating_sub(most_rows);
                hold.rows.start = hold.rows.start.max(earliest);
                (hold.is_over, hold.forced) = (false, true);
            }
            _ => self.warn("It moves: hold it still first."),
        }
    }

    fn record_again(&mut self, name: &str) {
        let Some(face) = face_of(name) else {
            self.warn("A face is +x, -x, +y, -y, +z or -z.");
            return;
        };
        if self.is_recorded(face) {
            self.redo.push(face);
        }
        let name = face.name();
        let next = format!("Put {name} up again.");
        self.remove(&next, |pose| pose.face.as_ref() == Some(&name));
    }

    fn remove(&mut self, next: &str, is_gone: impl Fn(&Pose) -> bool) {
        let poses = std::mem::take(&mut self.poses);
        let (gone, left) = poses.into_iter().partition::<Vec<_>, _>(is_gone);
        self.poses = left;
        for pose in gone {
            let text = format!(
                "Pose {} ({}) no longer counts. {next}",
                pose.pose,
                called(&pose)
            );
            let Pose { pose, face, .. } = pose;
            self.emit(Event::PoseUndone { pose, face }, &text);
        }
        self.progress_s = self.now_s;
        if let Some(hold) = &mut self.hold {
            // The pose that lies there now may be wanted again.
            hold.rows.start = hold.rows.end;
            hold.is_over = false;
        }
        self.fit();
    }

    // The calibration of the poses so far.

    /// Calibrates, and says which pose is wanted next: the poses or gravity have changed.
    fn fit(&mut self) {
        let before = self.grade();
        self.fitted = self.poses.len();
        let fitted = (self.poses.len() >= FIRST_FIT).then(|| self.calibrated());
        self.file = fitted.transpose().unwrap_or_else(|error| {
            if self.poses.len() >= FULL_FIT {
                self.warn(&error.to_string());
            }
            None
        });
        let shown = self.file.as_ref().map(shown_fit);
        let full = self.full_fit().filter(|_| self.grade() != before);
        let verdict = full.map(|file| verdict(file, false));
        let said = [shown, verdict, Some(self.next_step())];
        for (event, text) in said.into_iter().flatten() {
            self.emit(event, &text);
        }
    }

    fn calibrated(&self) -> Result<Calibration> {
        let no_rows = || Problem::NoRows.error();
        let recording = self.recording().ok_or_else(no_rows)??;
        let sections = self.poses.iter().map(|pose| section(pose, &recording));
        let options = CalibrateOptions {
            segment: SegmentOptions {
                sections: Some(sections.collect()),
                ..SegmentOptions::default()
            },
            gravity: self.options.gravity,
            ..CalibrateOptions::default()
        };
        Ok(calibrate(&[recording], &options)?.calibration)
    }

    /// What is wanted next.
    fn next_step(&self) -> (Event, String) {
        let missing = self.missing_faces();
        let up = self.next_up();
        let hint = up.map(in_words);
        let (kind, text) = if !missing.is_empty() {
            let text = format!("Put {} up, and hold still.", any_of(&missing));
            (Wanted::Face, text)
        } else if self.grade() == Some(Grade::Good) {
            let text = "Good: it can be saved; every further pose makes it better.";
            (Wanted::None, text.to_owned())
        } else {
            let hint = hint.as_deref().unwrap_or("any new direction");
            let text = format!("Free pose: {hint}. Lean it on something, and let go.");
            (Wanted::Free, text)
        };
        let faces = missing.iter().map(|f| f.name()).collect();
        let event = Event::NextPose {
            kind,
            faces,
            up,
            hint,
        };
        (event, text)
    }

    fn set_gravity(&mut self, value: Option<f64>, latitude: Option<f64>) {
        let gravity = match (value, latitude) {
            (Some(value), None) => Gravity::given(value),
            (None, Some(latitude)) => Gravity::at(latitude, 0.0),
            _ => return self.warn("Gravity is given by a value, or by the latitude."),
        };
        match gravity {
            Ok(gravity) => {
                self.options.gravity = gravity;
                let text = format!("Local gravity is {:.5} m/s².", gravity.value_mps2);
                self.emit(Event::Gravity(gravity), &text);
                self.fit();
            }
            Err(error) => self.warn(error.message()),
        }
    }

    fn finish(&mut self) {
        if self.fitted != self.poses.len() {
            self.fit();
        }
        if let Some((event, text)) = self.file.as_ref().map(|file| verdict(file, true)) {
            self.stop = Some(State::Done);
            self.emit(event, &text);
        } else {
            let poses = count(self.poses.len(), "pose");
            self.warn(&format!(
                "With {poses} nothing is determined yet: at least {FIRST_FIT} are needed, better six faces and three free poses."
            ));
        }
    }

    // The state for people: what to do now, and what hinders.

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
    fn status(&mut self) {
        let state = self.state();
        let reading = self.reading();
        let up = self.direction(reading);
        let (face, tilt_deg) = Face::nearest(up);
        let ring = self.ring(state);
        let here = face_up(up);
        let file = self.file.as_ref();
        let suspect = file.and_then(|file| file.contradiction());
        let suspect = suspect.and_then(|(pose, _)| self.poses.get(pose)?.face.clone());
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
            noise_mg: last.map_or(0.0, |s| milli_g(s.variance[0].sqrt())),
            limit_mg: self.units.and(last).map(|s| milli_g(s.limit[0].sqrt())),
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
        let excess = |sensor: usize| (last.variance[sensor] / last.limit[sensor]).sqrt();
        let tests = [("moving", excess(0)), ("turning", excess(1))];
        let failing = tests.iter().find(|(_, excess)| *excess > 1.0);
        Some(
            failing.map_or("still turning slowly".to_owned(), |(what, excess)| {
                format!("still {what}: {excess:.1} times the limit")
            }),
        )
    }
}

/// The face that a direction has up, if one is.
fn face_up(up: [f64; 3]) -> Option<Face> {
    let (face, tilt_deg) = Face::nearest(up);
    (tilt_deg <= MAX_FACE_ANGLE_DEG).then_some(face)
}

fn called(pose: &Pose) -> &str {
    pose.face.as_deref().unwrap_or("free pose")
}

/// The figures of a calibration of the poses so far.
fn shown_fit(file: &Calibration) -> (Event, String) {
    let section = &file.accelerometer;
    let r = &file.reliability;
    let worst = r.worst_direction.as_ref().map(|w| w.error_mps2);
    let scale = section.scale();
    let bias_mg = [0, 1, 2].map(|i| milli_g(section.bias[i] / scale[i]));
    let [x, y, z] = bias_mg;
    // Of six faces it holds less often.
    let share = if r.left_out_rms_mps2.is_some() {
        95
    } else {
        90
    };
    let most = worst.map(|w| format!("at most {} mg ({share} %)", numfmt::mg(w)));
    let most = most.as_deref().unwrap_or("unknown");
    let grade = file.grade();
    let grade = numfmt::words(&grade);
    let text = format!("Bias {x:.1}, {y:.1}, {z:.1} mg; error of ‖a‖ {most}; {grade}.");
    let event = Event::Fit {
        bias_mg,
        worst_mg: worst.map(milli_g),
        leave_one_out_mg: r.left_out_rms_mps2.map(milli_g),
        undetected_mg: r.undetected.as_ref().map(|u| milli_g(u.effect_mps2)),
        poses: file.poses.len() as u32,
    };
    (event, text)
}

/// The verdict with what decides it: the error, and what one pose could hide.
fn verdict(file: &Calibration, r#final: bool) -> (Event, String) {
    let verdict = file.verdict();
    let (grade, reasons) = (verdict.grade, verdict.reasons);
    let why = reasons[..reasons.len().min(2)].join("; ");
    let more = match grade {
        Grade::Good | Grade::Poor => "",
        Grade::Fair | Grade::NotVerifiable => "; more free poses test it, and reduce the error",
    };
    let text = format!("{}: {why}{more}.", numfmt::words(&grade));
    let event = Event::Verdict {
        grade,
        r#final,
        reasons,
    };
    (event, text)
}
