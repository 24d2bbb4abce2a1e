//! The state machine.

mod status;

use std::collections::VecDeque;
use std::ops::Range;

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::Result;
use crate::calibration_file::{CalibrationFile, Grade, GravitySource};
use crate::gravity::Gravity;
use crate::recording::Recording;
use crate::recording::units::{AccelScale, AccelUnit, GyroScale};
use crate::segment::face::{Face, angle_deg};
use crate::segment::sections::Section;
use crate::still::{LiveState, LiveStills};

use super::attitude::Attitude;
use super::event::{
    Command, EVENTS_VERSION, Event, Fit, Loss, Message, Pose, Rejection, SourceKind, State, Undone,
    Wanted, WarningKind, Welcome,
};
use super::fit::{FIRST_FIT, FULL_FIT, fit, section_label};
use super::judge::{Capture, Fault, Means, difference, length, mean, nearest_pose};
use super::reader::{Reader, Sample};
use super::rows::SessionRows;
use super::{LiveOptions, face_of, words};

/// The columns and the clock are reported after this time, s.
const IDENTIFY_S: f64 = 1.0;
/// Time between two status events, s.
const STATUS_S: f64 = 0.1;
/// Direction and magnitude are means over this time, s.
const SMOOTH_S: f64 = 0.2;
/// A step of the clock longer than this is a gap, s.
const GAP_S: f64 = 0.5;
/// Noise at rest over gravity at most, three axes together: twice that of a bad MPU6050 without
/// low-pass. Above it the sensor has not rested yet.
const MOST_NOISE: f64 = 0.035;
/// A capture that is interrupted earlier was none, share of its length.
const LEAST_PROGRESS: f64 = 0.15;
/// A change of temperature that is mentioned, °C.
const WARMED_C: f64 = 1.0;

/// Rest without interruption.
#[derive(Debug, Clone)]
struct Hold {
    /// Its rows.
    rows: Range<usize>,
    /// A capture has begun.
    capturing: bool,
    /// It was accepted or rejected: nothing happens until it moves.
    over: bool,
    /// Whatever can be overruled is: the user wants this pose.
    forced: bool,
}

/// What is known once the noise is.
#[derive(Debug, Clone, Copy)]
struct Units {
    /// Units of the recording per m/s².
    nominal: f64,
    scale: AccelScale,
    /// Units of the gyroscope per rad/s.
    gyro_nominal: Option<f64>,
}

/// An accepted pose, and where its rows are in those that are kept.
#[derive(Debug, Clone)]
struct Accepted {
    pose: Pose,
    kept: Range<usize>,
    gyro: [f64; 3],
}

/// A guided calibration. It belongs to one thread.
pub struct Session {
    options: LiveOptions,
    reader: Reader,
    rows: SessionRows,
    detector: Option<LiveStills>,
    last: Option<LiveState>,
    rate_hz: f64,
    units: Option<Units>,
    attitude: Attitude,
    gyro_bias: [f64; 3],
    state: State,
    /// State before the rows stopped.
    before_loss: Option<State>,
    hold: Option<Hold>,
    poses: Vec<Accepted>,
    numbers: u32,
    redo: Vec<Face>,
    /// It was far from the last pose since that was accepted.
    away: bool,
    fit_due: bool,
    file: Option<CalibrationFile>,
    grade: Option<Grade>,
    next_up: Option<[f64; 3]>,
    next_hint: Option<String>,
    warned_of_temperature: bool,
    /// Poses of a session that is resumed, until their rows were read.
    restored: VecDeque<Pose>,
    restoring: bool,
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
            reader: Reader::new(name, options.read.clone()),
            options,
            rows: SessionRows::default(),
            detector: None,
            last: None,
            rate_hz: Recording::ASSUMED_RATE_HZ,
            units: None,
            attitude: Attitude::default(),
            gyro_bias: [0.0; 3],
            state: State::Identify,
            before_loss: None,
            hold: None,
            poses: Vec::new(),
            numbers: 0,
            redo: Vec::new(),
            away: true,
            fit_due: false,
            file: None,
            grade: None,
            next_up: None,
            next_hint: None,
            warned_of_temperature: false,
            restored: VecDeque::new(),
            restoring: false,
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
            restored: poses.into(),
            restoring: true,
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
        self.emit(Event::Session {
            source,
            name: name.to_owned(),
            folder,
            tool: concat!("gravical ", env!("CARGO_PKG_VERSION")).to_owned(),
            gravity_mps2: self.options.gravity.value_mps2,
            gravity_source: self.options.gravity.source,
            capture_s: self.options.capture_s,
        });
        self.take()
    }

    /// Takes the next bytes of the recording, as they stand on the disk.
    ///
    /// # Errors
    ///
    /// Those of reading: no rows of a sensor. A faulty line is no error.
    pub fn bytes(&mut self, bytes: &[u8]) -> Result<Vec<Message>> {
        self.reader.push(bytes)?;
        while let Some(sample) = self.reader.next()? {
            if self.fit_due && !self.restoring {
                self.fit();
            }
            self.sample(sample)?;
        }
        Ok(self.take())
    }

    /// Calculates what waits, so that the events of [`bytes`](Self::bytes) come before the work.
    pub fn settle(&mut self) -> Vec<Message> {
        if self.fit_due && !self.restoring {
            self.fit();
        }
        self.take()
    }

    /// No rows arrive.
    pub fn lost(&mut self, why: Loss) -> Vec<Message> {
        if self.state != State::Lost && self.state != State::Done {
            self.before_loss = Some(self.state);
            self.state = State::Lost;
            self.interrupt();
            let (what, remedy) = match why {
                Loss::Unplugged => ("Unplugged.", "Plug it back in."),
                Loss::Silent => (
                    "The board sends nothing.",
                    "Check the cable, or press its reset.",
                ),
            };
            let safe = self.safe();
            self.emit(Event::Lost {
                why,
                message: format!("{what} {safe} {remedy}"),
                poses: self.poses.len() as u32,
            });
        }
        self.take()
    }

    /// Rows arrive again; or those that were there before a session was resumed have been read.
    pub fn resumed(&mut self) -> Vec<Message> {
        let restored = std::mem::take(&mut self.restoring);
        if let Some(before) = self.before_loss.take() {
            self.state = match before {
                State::Settle | State::Capture => State::Wait,
                other => other,
            };
        } else if !restored {
            return Vec::new();
        }
        self.interrupt();
        self.progress_s = self.now_s;
        let message = format!("Here again. {}", self.safe());
        self.emit(Event::Resumed {
            message: message.trim_end().to_owned(),
            poses: self.poses.len() as u32,
        });
        self.ask();
        self.settle()
    }

    /// Something for the record that only the program knows: what was saved, the end.
    pub fn note(&mut self, event: Event) -> Vec<Message> {
        self.emit(event);
        self.take()
    }

    /// Does what the user wants. [`Command::Hand`] is for a simulated sensor, not for the session.
    pub fn command(&mut self, command: &Command) -> Vec<Message> {
        if self.state == State::Done {
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

    /// True once the user has finished.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.state == State::Done
    }

    // Events.

    fn emit(&mut self, event: Event) {
        self.events.push(Message {
            v: EVENTS_VERSION,
            t_s: (self.now_s * 1e3).round() / 1e3,
            event,
        });
    }

    fn take(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.events)
    }

    fn warn(&mut self, kind: WarningKind, message: impl Into<String>) {
        self.emit(Event::Warning {
            kind,
            message: message.into(),
        });
    }

    fn refuse(&mut self, why: &str) {
        self.warn(WarningKind::Refused, why);
    }

    fn safe(&self) -> String {
        match self.poses.len() {
            0 => String::new(),
            1 => "1 pose is safe.".to_owned(),
            n => format!("{} are safe.", words::poses(n)),
        }
    }

    // Rows.

    fn sample(&mut self, sample: Sample) -> Result<()> {
        let gap = sample.t_s - self.now_s > GAP_S.max(5.0 / self.rate_hz);
        self.now_s = sample.t_s;
        if sample.row > 0 && (sample.is_break || gap) {
            self.interrupt();
        }
        self.rows.push(sample);
        let gyro_nominal = self.units.and_then(|u| u.gyro_nominal);
        let rate = gyro_nominal
            .map(|nominal| difference(sample.gyro(), self.gyro_bias).map(|v| v / nominal));
        self.attitude.update(sample.t_s, sample.accel(), rate);
        if self.detector.is_none() {
            self.identify(&sample);
        } else {
            self.detect(&sample);
        }
        let ends = |p: &&Pose| p.rows[1] == sample.row as u64 + 1;
        if let Some(pose) = self.restored.front().filter(ends).cloned() {
            self.restored.pop_front();
            self.accept(pose)?;
        }
        if sample.t_s - self.status_s >= STATUS_S - 1e-6 && !self.restoring {
            self.status_s = sample.t_s;
            self.status();
        }
        Ok(())
    }

    /// No hold spans what comes.
    fn interrupt(&mut self) {
        if let Some(detector) = &mut self.detector {
            detector.split();
        }
        self.last = None;
        if let Some(hold) = self.hold.take().filter(|h| h.capturing && !h.over) {
            let fault = Fault::new(
                Rejection::Gaps,
                "rows are missing in the middle of the capture".to_owned(),
                "hold it still once more",
            );
            self.reject(fault, &hold.rows);
        }
    }

    fn identify(&mut self, sample: &Sample) {
        let untimed = sample.row as f64 >= IDENTIFY_S * Recording::ASSUMED_RATE_HZ;
        if sample.t_s < IDENTIFY_S && !untimed {
            return;
        }
        let Some(summary) = self.reader.summary() else {
            return;
        };
        let (facts, timing) = (summary.facts, &summary.timing);
        self.rate_hz = timing.rate_hz().unwrap_or(self.rate_hz);
        let found = summary.found;
        let mut notes = [found.channels, found.clock, found.unit].concat();
        notes.extend(found.cells);
        self.emit(Event::Identified {
            rate_hz: timing.rate_hz(),
            jitter_ms: timing.jitter_s.map(|s| 1e3 * s),
            columns: self.reader.column_names(),
            unit: facts.accel.unit,
            counts_per_g: facts.accel.lsb_per_g,
            gyro_unit: facts.gyro.map(|g| g.unit),
            has_temperature: sample.temperature_c().is_finite(),
            notes: notes.into_iter().map(|f| f.message).collect(),
        });
        self.detector = Some(LiveStills::new(self.rate_hz, self.options.still.clone()));
        self.state = State::Floor;
        self.progress_s = self.now_s;
        let earlier: Vec<Sample> = self.rows.recent().copied().collect();
        earlier.iter().for_each(|s| self.detect(s));
    }

    fn detect(&mut self, sample: &Sample) {
        let Some(detector) = &mut self.detector else {
            return;
        };
        // The detector counts rows as the session does, so that a row without values counts, too.
        let gyro = Some(sample.gyro()).filter(|g| g.iter().all(|v| v.is_finite()));
        if !detector.push_with_gyro(sample.accel(), gyro) {
            return;
        }
        if detector.is_full() {
            detector.forget_older();
        }
        let Some(state) = detector.state() else {
            return;
        };
        self.last = Some(state.clone());
        if state.run.is_some() && gyro.is_some() {
            self.gyro_bias = mean(&self.rows.within(&state.block), Sample::gyro);
        }
        if !self.restoring {
            self.block(&state);
        }
    }

    /// Judges what the last block says.
    fn block(&mut self, state: &LiveState) {
        if matches!(self.state, State::Lost | State::Done | State::Identify) {
            return;
        }
        let Some(run) = state.run.clone() else {
            self.moved(state);
            return;
        };
        self.follow(run.clone(), state);
        if self.state == State::Floor && !self.floor(&run, state) {
            return;
        }
        self.go_away();
        self.hold_on();
    }

    /// It moves: a capture that has begun is interrupted.
    fn moved(&mut self, state: &LiveState) {
        let hold = self.hold.take();
        if hold.as_ref().is_some_and(|h| h.over) {
            // The user begins to turn it.
            self.progress_s = self.now_s;
        }
        if let Some(hold) = hold.filter(|h| h.capturing && !h.over) {
            let progress_s = (hold.rows.len() as f64 / self.rate_hz) - self.options.settle_s;
            if progress_s > LEAST_PROGRESS * self.options.capture_s {
                let mg = |v: f64| self.mg(v);
                let message = match state.scatter > state.most_scatter {
                    true => format!(
                        "it moved after {progress_s:.1} s: {:.0} mg, limit {:.0} mg",
                        mg(state.scatter),
                        mg(state.most_scatter)
                    ),
                    false => format!("it turned after {progress_s:.1} s"),
                };
                let remedy = "lay it down, take the hand off, and wait for the ring";
                self.reject(Fault::new(Rejection::Moved, message, remedy), &hold.rows);
            }
        }
        if self.state != State::Floor {
            self.state = State::Wait;
        }
        self.go_away();
    }

    /// The hold that the run belongs to.
    fn follow(&mut self, run: Range<usize>, state: &LiveState) {
        match &mut self.hold {
            Some(hold) if run.start < hold.rows.end => {
                let from = hold.rows.start + self.options.settle_rows(self.rate_hz);
                if hold.capturing && !hold.over && run.start > from {
                    // It drifts: what was captured does not agree with what is read now.
                    self.moved(state);
                    self.follow(run, state);
                    return;
                }
                hold.rows.end = run.end;
            }
            _ => {
                self.hold = Some(Hold {
                    rows: run,
                    capturing: false,
                    over: false,
                    forced: false,
                });
            }
        }
    }

    /// True once the noise at rest and the unit are known.
    fn floor(&mut self, run: &Range<usize>, state: &LiveState) -> bool {
        let wanted_s = self.options.settle_s + self.options.floor_s;
        if (run.len() as f64) < wanted_s * self.rate_hz {
            return false;
        }
        let samples = self.rows.within(run);
        let means = Means::of(&samples);
        let norm = length(means.accel);
        let Some(summary) = self
            .reader
            .summary()
            .filter(|_| state.noise <= MOST_NOISE * norm)
        else {
            return false;
        };
        let scale = summary.facts.accel;
        let gravity = self.options.gravity.value_mps2;
        // Counts of an unknown range are scaled by gravity itself.
        let counts = scale.unit == AccelUnit::Counts && scale.lsb_per_g.is_none();
        let Some(nominal) = scale.nominal().or(counts.then_some(norm / gravity)) else {
            if let Some(hold) = self.hold.as_mut().filter(|hold| !hold.over) {
                hold.over = true;
                let fault = Fault::new(
                    Rejection::Units,
                    format!("‖a‖ at rest is {norm:.4}: gravity in no unit"),
                    "raw values are needed, with gravity; or give the unit with --accel-unit",
                );
                self.reject(fault, run);
            }
            return false;
        };
        let gyro_scale = summary.facts.gyro;
        self.units = Some(Units {
            nominal,
            scale,
            gyro_nominal: gyro_scale.as_ref().and_then(GyroScale::nominal),
        });
        let steps = self.reader.resolution();
        let deg_s = gyro_scale.as_ref().and_then(GyroScale::nominal);
        let scatter = |of: fn(&Sample) -> [f64; 3], mean: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|i| {
                let squares = samples.iter().map(|s| (of(s)[i] - mean[i]).powi(2));
                let squares = squares.filter(|v| v.is_finite()).sum::<f64>();
                (squares / (samples.len() - 1) as f64).sqrt()
            })
        };
        let accel = scatter(Sample::accel, means.accel);
        let gyro = scatter(Sample::gyro, means.gyro);
        self.emit(Event::Floor {
            noise_mg: accel.map(|v| self.mg(v)),
            gyro_noise_deg_s: deg_s
                .filter(|_| gyro.iter().all(|v| v.is_finite()))
                .map(|nominal| gyro.map(|v| (v / nominal).to_degrees())),
            step_mg: [0, 1, 2].map(|i| self.mg(steps[i])),
            limit_mg: self.mg(state.most_scatter),
        });
        if self.options.gravity.source == GravitySource::Standard {
            self.warn(
                WarningKind::Gravity,
                "local gravity is not known: the latitude (or the value) makes the scale certain; without it 0.15 % (1σ) of doubt remain",
            );
        }
        self.state = State::Wait;
        self.progress_s = self.now_s;
        self.ask();
        true
    }

    /// Notes that it has left the last pose.
    fn go_away(&mut self) {
        if let Some(last) = self.poses.last() {
            let angle = angle_deg(last.pose.up, self.direction());
            self.away |= angle > self.options.apart_deg;
        }
    }

    /// The hold goes on: it settles, is captured, is over.
    fn hold_on(&mut self) {
        let settle = self.options.settle_rows(self.rate_hz);
        let capture = self.options.capture_rows(self.rate_hz);
        let Some(hold) = self.hold.clone().filter(|hold| !hold.over) else {
            self.state = State::Wait;
            return;
        };
        let from = hold.rows.start + settle;
        if hold.rows.end <= from {
            self.state = State::Settle;
            return;
        }
        if !hold.capturing {
            let samples = self.rows.within(&hold.rows);
            let up = self.direction_of(Means::of(&samples).accel);
            let welcome = self.welcome(up);
            let fault = self.unwelcome(welcome, up).filter(|_| !hold.forced);
            if let Some(hold) = &mut self.hold {
                hold.capturing = fault.is_none();
                hold.over = fault.is_some();
            }
            match fault {
                Some(fault) => {
                    self.state = State::Wait;
                    // A bump on the pose that was just accepted is not worth a word.
                    if welcome != Welcome::Duplicate || self.away {
                        self.reject(fault, &hold.rows);
                    }
                    return;
                }
                None => {
                    let (face, tilt_deg) = Face::nearest(up);
                    self.emit(Event::PoseCandidate {
                        face: (tilt_deg <= self.options.most_tilt_deg).then(|| face.name()),
                        up,
                        tilt_deg,
                    });
                }
            }
        }
        self.state = State::Capture;
        if hold.rows.end - from >= capture {
            self.judge(&(from..from + capture), hold.forced);
        }
    }

    /// What a hold in this direction would be.
    fn welcome(&self, up: [f64; 3]) -> Welcome {
        let (face, tilt_deg) = Face::nearest(up);
        let is_face = tilt_deg <= self.options.most_tilt_deg;
        let kind = if is_face {
            Welcome::Face
        } else {
            Welcome::Free
        };
        if self.options.any_pose || is_face && self.to_do().contains(&face) {
            return kind;
        }
        let poses: Vec<Pose> = self.poses().cloned().collect();
        let near = nearest_pose(&poses, up).is_some_and(|(_, deg)| deg < self.options.apart_deg);
        // A steep face that is done leaves room for a free pose beside it only if it is far.
        match near {
            true => Welcome::Duplicate,
            false if is_face || self.to_do().is_empty() => kind,
            false => Welcome::Between,
        }
    }

    fn unwelcome(&self, welcome: Welcome, up: [f64; 3]) -> Option<Fault> {
        let (face, tilt_deg) = Face::nearest(up);
        let to_do = self.to_do();
        if let Some(wanted) = self.redo.iter().find(|w| w.opposite() == face)
            && welcome == Welcome::Duplicate
        {
            return Some(Fault::new(
                Rejection::Sign,
                format!(
                    "{} is up, and {} is to be recorded again",
                    words::attitude(face),
                    wanted.name()
                ),
                format!("turn it over: {}", words::attitude(*wanted)),
            ));
        }
        match welcome {
            Welcome::Face | Welcome::Free => None,
            Welcome::Duplicate => Some(Fault::new(
                Rejection::Duplicate,
                match tilt_deg <= self.options.most_tilt_deg {
                    true => format!("{} is recorded already", face.name()),
                    false => format!(
                        "a pose within {:.0}° is recorded already",
                        self.options.apart_deg
                    ),
                },
                match to_do.is_empty() {
                    true => "turn it to another direction; or record it again: R and the face"
                        .to_owned(),
                    false => format!(
                        "turn it to {}; or record it again: R and the face",
                        words::any_of(&to_do)
                    ),
                },
            )),
            Welcome::Between => Some(Fault::new(
                Rejection::BetweenFaces,
                format!(
                    "it lies between two faces: {tilt_deg:.0}° from {}",
                    face.name()
                ),
                format!(
                    "put {} up; or take it as a free pose (Space)",
                    words::any_of(&to_do)
                ),
            )),
        }
    }

    /// Accepts or rejects a capture.
    fn judge(&mut self, rows: &Range<usize>, forced: bool) {
        let Some(units) = self.units else { return };
        let samples = self.rows.within(rows);
        let means = Means::of(&samples);
        let poses: Vec<Pose> = self.poses().cloned().collect();
        let gyro_means: Vec<[f64; 3]> = self.poses.iter().map(|p| p.gyro).collect();
        let capture = Capture {
            samples: &samples,
            rate_hz: self.rate_hz,
            rows: rows.len(),
            nominal: units.nominal,
            scale: units.scale,
            gyro_nominal: units.gyro_nominal,
            gravity: self.options.gravity.value_mps2,
            poses: &poses,
            gyro_means: &gyro_means,
            options: &self.options,
        };
        let fault = capture.fault(&means).filter(|f| !(f.soft && forced));
        if let Some(hold) = &mut self.hold {
            hold.over = true;
        }
        self.state = State::Wait;
        self.progress_s = self.now_s;
        if let Some(fault) = fault {
            if matches!(fault.reason, Rejection::Moved | Rejection::Gaps) {
                // The next try begins where this one ended.
                self.hold = Some(Hold {
                    rows: rows.end..rows.end,
                    capturing: false,
                    over: false,
                    forced,
                });
            }
            self.reject(fault, rows);
            return;
        }
        let up = self.direction_of(means.accel);
        let (face, tilt_deg) = Face::nearest(up);
        let is_face = tilt_deg <= self.options.most_tilt_deg;
        self.numbers += 1;
        let seconds = samples
            .last()
            .zip(samples.first())
            .map_or(0.0, |(b, a)| b.t_s - a.t_s);
        let pose = Pose {
            pose: self.numbers,
            face: is_face.then(|| face.name()),
            up,
            tilt_deg,
            mean: means.accel,
            norm_mps2: length(means.accel) / units.nominal,
            noise_mg: self.mg(means.sigma),
            temperature_c: means.temperature_c,
            seconds: seconds + 1.0 / self.rate_hz,
            rows: [rows.start as u64, rows.end as u64],
            faces_done: 0,
            free_done: 0,
            note: (is_face && tilt_deg > self.options.fine_tilt_deg).then(|| {
                format!(
                    "{tilt_deg:.0}° from {}: a flatter one would say more of the axes",
                    face.name()
                )
            }),
        };
        if let Err(error) = self.accept(pose) {
            self.warn(WarningKind::Other, error.to_string());
        }
    }

    fn accept(&mut self, mut pose: Pose) -> Result<()> {
        let rows = pose.rows[0] as usize..pose.rows[1] as usize;
        let gyro = mean(&self.rows.within(&rows), Sample::gyro);
        let Some(empty) = self.reader.columns() else {
            return Ok(());
        };
        let kept = self.rows.keep(&rows, || empty)?;
        self.redo.retain(|face| Some(face.name()) != pose.face);
        self.poses.push(Accepted {
            pose: pose.clone(),
            kept,
            gyro,
        });
        self.away = false;
        pose.faces_done = 6 - Face::all().iter().filter(|f| !self.has(**f)).count() as u32;
        pose.free_done = self.free_done();
        if let Some(last) = self.poses.last_mut() {
            last.pose = pose.clone();
        }
        let warmed = self
            .poses
            .iter()
            .find_map(|p| p.pose.temperature_c)
            .zip(pose.temperature_c);
        self.emit(Event::PoseAccepted(pose));
        if let Some((first, now)) = warmed
            && (now - first).abs() > WARMED_C
            && !std::mem::replace(&mut self.warned_of_temperature, true)
        {
            self.warn(
                WarningKind::Temperature,
                format!("the sensor has warmed by {:.1} °C since the first pose: let it run for some minutes before the session", now - first),
            );
        }
        self.fit_due = true;
        Ok(())
    }

    fn reject(&mut self, fault: Fault, rows: &Range<usize>) {
        self.progress_s = self.now_s;
        let samples = self.rows.within(rows);
        let up = self.direction_of(Means::of(&samples).accel);
        let (face, tilt_deg) = Face::nearest(up);
        self.emit(Event::PoseRejected {
            reason: fault.reason,
            message: fault.message,
            remedy: fault.remedy,
            face: Some(face.name()),
            up,
            tilt_deg,
        });
    }

    // Commands.

    fn capture_now(&mut self) {
        match &mut self.hold {
            Some(hold) if self.units.is_some() => {
                if hold.over && hold.capturing {
                    // From now on: what was judged stays judged.
                    hold.rows.start = hold.rows.end;
                }
                // What it has rested already counts.
                let most = self.options.settle_rows(self.rate_hz)
                    + self.options.capture_rows(self.rate_hz);
                let earliest = hold.rows.end.saturating_sub(most);
                hold.rows.start = hold.rows.start.max(earliest);
                (hold.over, hold.capturing, hold.forced) = (false, false, true);
            }
            _ => self.refuse("it moves: hold it still first"),
        }
    }

    fn undo(&mut self) {
        let Some(last) = self.poses.pop() else {
            self.refuse("there is no pose to undo");
            return;
        };
        self.undone(&last.pose, Undone::Undo);
        self.poses_changed();
    }

    fn record_again(&mut self, name: &str) {
        let Some(face) = face_of(name) else {
            self.refuse("a face is +x, -x, +y, -y, +z or -z");
            return;
        };
        let of_face = |p: &Accepted| p.pose.face.as_deref() == Some(&face.name());
        let (gone, left): (Vec<Accepted>, Vec<Accepted>) = std::mem::take(&mut self.poses)
            .into_iter()
            .partition(of_face);
        self.poses = left;
        for accepted in &gone {
            self.undone(&accepted.pose, Undone::Redo);
        }
        if !gone.is_empty() && !self.redo.contains(&face) {
            self.redo.push(face);
        }
        self.poses_changed();
    }

    fn undone(&mut self, pose: &Pose, why: Undone) {
        self.emit(Event::PoseUndone {
            pose: pose.pose,
            face: pose.face.clone(),
            why,
        });
    }

    fn poses_changed(&mut self) {
        self.away = true;
        self.progress_s = self.now_s;
        self.fit_due = true;
        self.file = None;
        if let Some(hold) = &mut self.hold {
            // The pose that lies there now may be wanted again.
            hold.rows.start = hold.rows.end;
            (hold.over, hold.capturing) = (false, false);
        }
    }

    fn set_gravity(&mut self, value: Option<f64>, latitude: Option<f64>, altitude: Option<f64>) {
        let gravity = match (value, latitude) {
            (Some(value), _) => Gravity::given(value),
            (None, Some(latitude)) => Gravity::at(latitude, altitude.unwrap_or(0.0)),
            (None, None) => return self.refuse("gravity needs a value or a latitude"),
        };
        match gravity {
            Ok(gravity) => {
                self.options.gravity = gravity;
                self.fit_due = true;
                self.emit(Event::Gravity {
                    gravity_mps2: gravity.value_mps2,
                    gravity_source: gravity.source,
                });
            }
            Err(error) => self.refuse(error.message()),
        }
    }

    fn finish(&mut self) {
        if self.fit_due {
            self.fit();
        }
        let Some(file) = &self.file else {
            let what = words::poses(self.poses.len());
            self.refuse(&format!(
                "with {what} nothing is determined yet: at least {FIRST_FIT} are needed, better six faces and three free poses"
            ));
            return;
        };
        let verdict = file.verdict.clone();
        let sentence = words::verdict(file);
        self.state = State::Done;
        self.emit(Event::Verdict {
            grade: verdict.grade,
            r#final: true,
            sentence,
            reasons: verdict.reasons,
        });
    }

    // The result.

    fn fit(&mut self) {
        self.fit_due = false;
        self.file = None;
        if self.poses.len() >= FIRST_FIT {
            match self.calibrated() {
                Ok(file) => {
                    let poses: Vec<Pose> = self.poses().cloned().collect();
                    self.emit(Event::Fit(Box::new(Fit::of(&file, &poses))));
                    self.file = Some(file);
                }
                Err(error) if self.poses.len() >= FULL_FIT => {
                    self.warn(WarningKind::Other, error.to_string());
                }
                Err(_) => {}
            }
        }
        let full = self.file.as_ref().filter(|_| self.poses.len() >= FULL_FIT);
        let grade = full.map(|file| file.verdict.grade);
        if let Some(file) = full.filter(|_| grade != self.grade) {
            let event = Event::Verdict {
                grade: file.verdict.grade,
                r#final: false,
                sentence: words::verdict(file),
                reasons: file.verdict.reasons.clone(),
            };
            self.emit(event);
        }
        self.grade = grade;
        self.ask();
    }

    fn calibrated(&self) -> Result<CalibrationFile> {
        let columns = self.rows.kept().cloned().unwrap_or_default();
        let recording = self.reader.recording(columns)?;
        let section = |p: &Accepted| Section {
            label: section_label(p.pose.pose),
            rows: p.kept.clone(),
        };
        fit(
            recording,
            self.poses.iter().map(section).collect(),
            &self.options,
        )
    }

    /// Says which pose is wanted next.
    fn ask(&mut self) {
        let to_do = self.to_do();
        (self.next_up, self.next_hint) = (None, None);
        let mut predicted_mg = None;
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
                let mps2 = next.predicted_norm_error_mps2;
                predicted_mg = Some(2000.0 * mps2 / STANDARD_GRAVITY_MPS2);
                (self.next_up, self.next_hint) = (Some(next.direction), Some(next.hint.clone()));
            }
            Wanted::Free
        };
        self.emit(Event::NextPose {
            kind,
            faces: to_do.iter().map(|f| f.name()).collect(),
            up: self.next_up,
            hint: self.next_hint.clone(),
            predicted_mg,
        });
    }

    // The state, for people.

    fn has(&self, face: Face) -> bool {
        let name = face.name();
        self.poses
            .iter()
            .any(|p| p.pose.face.as_deref() == Some(&name))
    }

    fn to_do(&self) -> Vec<Face> {
        Face::all().into_iter().filter(|f| !self.has(*f)).collect()
    }

    fn free_done(&self) -> u32 {
        self.poses.iter().filter(|p| p.pose.face.is_none()).count() as u32
    }

    fn mg(&self, units: f64) -> f64 {
        let nominal = self.units.map_or(f64::NAN, |u| u.nominal);
        1000.0 * units / nominal / STANDARD_GRAVITY_MPS2
    }

    /// Specific force of the last rows, unit of the recording.
    fn reading(&self) -> [f64; 3] {
        let recent = self.rows.recent().rev();
        let recent = recent.take_while(|s| self.now_s - s.t_s <= SMOOTH_S);
        let samples: Vec<Sample> = recent.copied().collect();
        mean(&samples, Sample::accel)
    }

    fn direction(&self) -> [f64; 3] {
        self.direction_of(self.reading())
    }

    /// The direction of a reading, as far as the sensor is known.
    fn direction_of(&self, reading: [f64; 3]) -> [f64; 3] {
        let full = self.file.as_ref().filter(|_| self.poses.len() >= FULL_FIT);
        let force = match full {
            Some(file) => {
                let section = &file.accelerometer;
                let offset = self.reader.zero_offset();
                let raw: [f64; 3] = std::array::from_fn(|i| reading[i] + offset - section.bias[i]);
                gravical_core::matrix3::mul_vec(&section.matrix, &raw)
            }
            None => reading,
        };
        let size = length(force);
        match size > 0.0 {
            true => force.map(|v| v / size),
            false => [0.0, 0.0, 1.0],
        }
    }
}

impl LiveOptions {
    fn settle_rows(&self, rate_hz: f64) -> usize {
        (self.settle_s * rate_hz).round() as usize
    }

    fn capture_rows(&self, rate_hz: f64) -> usize {
        ((self.capture_s * rate_hz).round() as usize).max(self.least_rows)
    }
}
