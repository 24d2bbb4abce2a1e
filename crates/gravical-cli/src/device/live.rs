//! The state of the stream for the person who records: rate, magnitude, rest, poses.

use std::collections::VecDeque;

use gravical::core::matrix3::norm;
use gravical::poses::MAX_FACE_ANGLE_DEG;
use gravical::poses::face::Face;
use gravical::stills::LiveStills;
use serde::Serialize;

use super::item::Row;

/// The rate is that of the last seconds, s.
const RATE_S: f64 = 3.0;
/// The magnitude is a mean over this time, s.
const NORM_S: f64 = 0.5;
/// Rows of these seconds that are kept at most.
const MOST_ROWS: usize = 4096;
/// Rests are looked for once the rate is known from this time, s.
const LEARN_RATE_S: f64 = 1.0;
/// A rest is at least 1 s: before this time it is not known whether there is one, s.
const FIRST_REST_S: f64 = 1.5;
/// No rest continues over a pause of this length between rows, s.
const SPLIT_S: f64 = 0.5;
/// A rest of this length, stored, is a pose, s.
const POSE_S: f64 = 2.0;

/// The stream at one moment. Values are in the board's own units.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Status {
    /// Rows a second over the last three seconds, by the computer's clock.
    pub rate_hz: Option<f64>,
    /// Magnitude of the acceleration, mean of the last half second.
    pub norm: Option<f64>,
    /// Temperature of the last row.
    pub temperature: Option<f64>,
    /// Whether the sensor is at rest.
    pub still: Option<bool>,
    /// The face that is up at rest: `+x`.
    pub up: Option<String>,
    /// Faces that were recorded as a pose.
    pub done: Option<Vec<String>>,
}

/// Poses of a recording: rests of at least 2 s that were stored.
///
/// A guided session ([`gravical::live`]) decides once what is a pose, while the sensor still lies
/// there, and tests a capture of a set length. Here nobody is guided: every rest counts, a repeat
/// adds to the time of its face, and a quieter block that comes later may change what was a rest.
/// Both use the same detector, the same level of noise at rest and the same angle of a face.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Poses {
    /// Seconds for each of [`Face::all`].
    faces_s: [f64; 6],
    /// Rests in which no axis is within 25° of the vertical.
    free: u64,
}

/// A pose in the event `ended`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RecordedPose {
    /// The face that is up: `+x`.
    pub face: String,
    /// Time at rest, s.
    pub duration_s: f64,
}

impl Poses {
    /// The faces that were recorded.
    pub fn faces(&self) -> Vec<RecordedPose> {
        let all = Face::all().into_iter().zip(self.faces_s);
        let recorded = all.filter(|(_, duration_s)| *duration_s > 0.0);
        recorded
            .map(|(face, duration_s)| RecordedPose {
                face: face.name(),
                duration_s,
            })
            .collect()
    }

    /// Free poses.
    pub fn free(&self) -> u64 {
        self.free
    }
}

/// Follows the stream.
#[derive(Debug, Clone, Default)]
pub struct Live {
    /// Arrival, s; row; whether it is stored.
    rows: VecDeque<(f64, Row, bool)>,
    rests: Option<Rests>,
}

impl Live {
    /// A row that arrived at `now_s`; `stored`: it goes into the file.
    pub fn push(&mut self, now_s: f64, row: &Row, stored: bool) {
        self.rows.push_back((now_s, *row, stored));
        let is_old = |(t, ..): &(f64, Row, bool)| now_s - t > RATE_S;
        while self.rows.len() > MOST_ROWS || self.rows.front().is_some_and(is_old) {
            self.rows.pop_front();
        }
        if let Some(rests) = &mut self.rests {
            rests.push(now_s, row, stored);
            return;
        }
        let first = self.rows.iter().find(|(_, row, _)| row.accel.is_some());
        let learned = first.is_some_and(|(t, ..)| now_s - t >= LEARN_RATE_S);
        let Some(rate_hz) = self.rate_hz().filter(|_| learned) else {
            return;
        };
        let mut rests = Rests::new(rate_hz);
        for (t, row, stored) in &self.rows {
            rests.push(*t, row, *stored);
        }
        self.rests = Some(rests);
    }

    /// Seconds between two rows, by the computer's clock.
    pub fn step_s(&self) -> Option<f64> {
        let (first_s, last_s) = (self.rows.front()?.0, self.rows.back()?.0);
        (self.rows.len() > 1).then(|| (last_s - first_s) / (self.rows.len() - 1) as f64)
    }

    fn rate_hz(&self) -> Option<f64> {
        self.step_s()
            .filter(|s| *s > 0.0)
            .map(|step_s| 1.0 / step_s)
    }

    /// The state at `now_s`; empty when no row has arrived for a while.
    pub fn status(&self, now_s: f64) -> Status {
        let recent = || {
            let rows = self.rows.iter();
            rows.filter(|(t, ..)| now_s - t <= NORM_S)
                .map(|(_, row, _)| row)
        };
        let Some(last) = recent().next_back() else {
            return Status::default();
        };
        let norms = recent().filter_map(|row| row.accel);
        let norms: Vec<f64> = norms.map(|accel| norm(&accel)).collect();
        let mean_norm = norms.iter().sum::<f64>() / norms.len() as f64;
        let known = |rests: &&Rests| rests.stills.rows() as f64 >= FIRST_REST_S * rests.rate_hz;
        let rest = self.rests.as_ref().filter(known).map(Rests::state);
        let (still, up, poses) = match rest {
            Some((still, up, poses)) => (Some(still), up, Some(poses)),
            None => (None, None, None),
        };
        let name = |pose: RecordedPose| pose.face;
        Status {
            rate_hz: self.rate_hz(),
            norm: Some(mean_norm).filter(|_| !norms.is_empty()),
            temperature: last.temperature,
            still,
            up: up.map(Face::name),
            done: poses.map(|poses| poses.faces().into_iter().map(name).collect()),
        }
    }

    /// The poses that were stored; none where the accelerometer is not known.
    pub fn poses(&self) -> Option<Poses> {
        self.rests.as_ref().map(|rests| rests.state().2)
    }
}

/// Rests of the whole recording.
#[derive(Debug, Clone)]
struct Rests {
    rate_hz: f64,
    stills: LiveStills,
    /// Rows from which on rows are stored (true) or not.
    switches: Vec<(usize, bool)>,
    last_row_s: f64,
    /// Poses that the stills no longer hold.
    earlier: Poses,
    /// The row up to which a free pose, which still lasts, is among them.
    counted_to: Option<usize>,
}

impl Rests {
    fn new(rate_hz: f64) -> Self {
        Rests {
            rate_hz,
            stills: LiveStills::new(rate_hz),
            switches: Vec::new(),
            last_row_s: f64::NAN,
            earlier: Poses::default(),
            counted_to: None,
        }
    }

    fn push(&mut self, now_s: f64, row: &Row, stored: bool) {
        let Some(accel) = row.accel else {
            return;
        };
        if now_s - self.last_row_s > SPLIT_S.max(5.0 / self.rate_hz) {
            self.stills.split();
        }
        self.last_row_s = now_s;
        if self.switches.last().is_none_or(|(_, was)| *was != stored) {
            self.switches.push((self.stills.rows(), stored));
        }
        self.stills.push(accel);
        if self.stills.is_full() {
            let (rests, face, earlier) = self.state();
            self.counted_to = (rests && face.is_none()).then(|| self.stills.rows());
            self.earlier = earlier;
            self.stills.forget();
            self.switches = vec![(self.stills.rows(), stored)];
        }
    }

    /// Whether the sensor rests, the face that is up then, and the poses so far.
    fn state(&self) -> (bool, Option<Face>, Poses) {
        let mut poses = self.earlier.clone();
        let mut resting = None;
        for still in self.stills.stills() {
            if !still.is_rest() {
                continue;
            }
            let (face, angle_deg) = Face::nearest(still.mean);
            let face = Some(face).filter(|_| angle_deg <= MAX_FACE_ANGLE_DEG);
            let duration_s = self.stored_rows(&still.rows) as f64 / self.rate_hz;
            if duration_s >= POSE_S {
                match face.and_then(|face| poses.faces_s.get_mut(face.index())) {
                    Some(face_s) => *face_s += duration_s,
                    None if self.counted_to == Some(still.rows.start) => {}
                    None => poses.free += 1,
                }
            }
            if still.rows.end == self.stills.judged_rows() {
                resting = Some(face);
            }
        }
        (resting.is_some(), resting.flatten(), poses)
    }

    fn stored_rows(&self, rows: &std::ops::Range<usize>) -> usize {
        let ends = self.switches.iter().skip(1).map(|(row, _)| *row);
        let ends = ends.chain([usize::MAX]);
        let spans = self.switches.iter().zip(ends);
        let stored = spans.filter(|((_, stored), _)| *stored);
        let within =
            stored.map(|((from, _), to)| to.min(rows.end).saturating_sub(rows.start.max(*from)));
        within.sum()
    }
}
