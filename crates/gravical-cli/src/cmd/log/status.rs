//! The state of the recording for the person who records: rate, magnitude, rest, poses.

use std::collections::HashSet;

use gravical::core::matrix3::norm;
use gravical::poses::MAX_FACE_ANGLE_DEG;
use gravical::poses::face::Face;
use gravical::poses::rests::find_rests;
use gravical::recording::{Finding, Recording, Severity};

use super::POSE_S;
use super::event::Status;
use super::writing::Writing;

/// The magnitude is a mean over this time, and a rest ends within it, s.
const RECENT_S: f64 = 0.5;
/// A rest takes at least 1 s: before this time it is not known whether there is one, s.
const FIRST_REST_S: f64 = 1.5;

/// Judges the last rows once a second.
#[derive(Default)]
pub struct Monitor {
    /// Rows that had arrived.
    arrived: u64,
    /// Of each of [`Face::all`], whether it was recorded as a pose.
    done: [bool; 6],
    /// Findings that were returned: their kinds, and their messages without numbers.
    said: HashSet<String>,
}

impl Monitor {
    /// The state at `now_s`, and what may spoil the samples and was not returned before.
    pub fn observe(&mut self, writing: &Writing, now_s: f64) -> (Status, Vec<Finding>) {
        let counts = writing.counts;
        let mut status = Status {
            rows: counts.rows,
            elapsed_s: writing.elapsed_s(now_s),
            paused: writing.is_paused(),
            rejected: counts.rejected,
            ..Status::default()
        };
        if std::mem::replace(&mut self.arrived, writing.arrived) == writing.arrived {
            // No row has arrived for a second.
            return (status, Vec::new());
        }
        let Some(Ok(recording)) = writing.reader.recording(u32::MAX) else {
            return (status, Vec::new());
        };
        self.observe_rows(&mut status, &recording, writing);
        (status, self.new_findings(recording.findings))
    }

    fn observe_rows(&mut self, status: &mut Status, recording: &Recording, writing: &Writing) {
        status.rate_hz = recording.timing.rate_hz();
        let (rows, rate_hz) = (recording.rows(), status.rate_hz.unwrap_or(1.0));
        let recent = rows.saturating_sub((RECENT_S * rate_hz).ceil() as usize)..rows;
        let accel = |row: usize| recording.accel.each_ref().map(|axis| axis[row]);
        let norms: Vec<f64> = recent.clone().map(|row| norm(&accel(row))).collect();
        let norms: Vec<f64> = norms.into_iter().filter(|norm| norm.is_finite()).collect();
        status.norm = Some(norms.iter().sum::<f64>() / norms.len() as f64);
        status.norm = status.norm.filter(|norm| norm.is_finite());
        status.accel = Some(recording.accel_scale);
        let temperatures = recording.temperature_c.iter().flatten();
        status.temperature_c = temperatures.copied().rfind(|t| t.is_finite());
        if (rows as f64) < FIRST_REST_S * rate_hz {
            return;
        }
        status.still = Some(false);
        for rest in find_rests(recording).spans {
            let sum = rest.clone().map(accel).fold([0.0; 3], |sum, a| {
                [sum[0] + a[0], sum[1] + a[1], sum[2] + a[2]]
            });
            let (face, angle_deg) = Face::nearest(sum);
            let face = Some(face).filter(|_| angle_deg <= MAX_FACE_ANGLE_DEG);
            let is_stored = |row: &usize| writing.is_stored(recording.line(*row) as usize);
            let stored = rest.clone().filter(is_stored).count();
            if let Some(face) = face.filter(|_| stored as f64 >= POSE_S * rate_hz) {
                self.done[face.index()] = true;
            }
            if rest.end > recent.start {
                status.still = Some(true);
                status.up = face.map(Face::name);
            }
        }
        let done = Face::all()
            .into_iter()
            .filter(|face| self.done[face.index()]);
        status.done = Some(done.map(Face::name).collect());
    }

    fn new_findings(&mut self, mut findings: Vec<Finding>) -> Vec<Finding> {
        findings.retain(|finding| {
            if finding.severity != Severity::Warning || !finding.kind.is_of_samples() {
                return false;
            }
            let words = finding.message.replace(|c: char| c.is_ascii_digit(), "");
            self.said.insert(format!("{} {words}", finding.kind.name()))
        });
        findings
    }
}
