//! The state of the recording for the person who records: rate, magnitude, rest, poses; in one
//! line.

use std::collections::HashSet;

use gravical::core::matrix3::{add, norm};
use gravical::poses::MAX_FACE_ANGLE_DEG;
use gravical::poses::face::{AXES, Face};
use gravical::poses::rests::find_rests;
use gravical::recording::{AccelScale, Finding, Recording, Severity};

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
    /// Lines that had arrived.
    judged: usize,
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
        if std::mem::replace(&mut self.judged, writing.judged) == writing.judged {
            // No line has arrived for a second.
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
        let mut norms: Vec<f64> = recent.clone().map(|row| norm(&accel(row))).collect();
        norms.retain(|norm| norm.is_finite());
        let mean = norms.iter().sum::<f64>() / norms.len() as f64;
        status.norm = Some(mean).filter(|mean| mean.is_finite());
        status.accel = Some(recording.accel_scale);
        let temperatures = recording.temperature_c.iter().flatten();
        status.temperature_c = temperatures.copied().rfind(|t| t.is_finite());
        if (rows as f64) < FIRST_REST_S * rate_hz {
            return;
        }
        status.still = Some(false);
        for rest in find_rests(recording) {
            let sum = rest
                .clone()
                .map(accel)
                .fold([0.0; 3], |sum, a| add(&sum, &a));
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
        let mut done = Face::all().to_vec();
        done.retain(|face| self.done[face.index()]);
        status.done = Some(done.into_iter().map(Face::name).collect());
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

/// Columns of the status line.
const MAX_COLUMNS: usize = 79;

/// One line of at most 79 columns: what is needed most comes first, and the rest where there is room.
pub fn status_line(status: &Status) -> String {
    let mut parts = vec![
        format!("{:.1} s", status.elapsed_s),
        format!("{} rows", status.rows),
    ];
    parts.extend(match (status.paused, status.still) {
        (true, _) => Some("PAUSED".to_owned()),
        (_, Some(true)) => Some("at rest".to_owned()),
        (_, Some(false)) => Some("moving".to_owned()),
        (_, None) => None,
    });
    parts.extend(status.up.as_ref().map(|up| format!("up: {up}")));
    parts.extend(status.done.as_ref().map(|done| {
        let mut missing = Face::all().map(Face::name).to_vec();
        missing.retain(|face| !done.contains(face));
        if missing.is_empty() {
            "all 6 done".to_owned()
        } else {
            format!("missing {}", shortened(&missing))
        }
    }));
    parts.extend(status.norm.map(|norm| norm_text(norm, status.accel)));
    parts.extend((status.rejected > 0).then(|| format!("{} rejected", status.rejected)));
    parts.extend(status.rate_hz.map(|rate| format!("{rate:.1} Hz")));
    parts.extend(status.temperature_c.map(|t| format!("{t:.1} °C")));
    while parts.join("  ").chars().count() > MAX_COLUMNS && parts.pop().is_some() {}
    parts.join("  ")
}

/// `+x -x -y` as `±x -y`.
fn shortened(faces: &[String]) -> String {
    let mut text = faces.join(" ");
    for axis in AXES {
        text = text.replace(&format!("+{axis} -{axis}"), &format!("±{axis}"));
    }
    text
}

/// In m/s², or as it stands in a file of unknown unit.
fn norm_text(norm: f64, accel: Option<AccelScale>) -> String {
    match accel.and_then(|accel| accel.nominal()) {
        Some(per_mps2) => format!("‖a‖ {:.2} m/s²", norm / per_mps2),
        None => format!("‖a‖ {norm:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gravical::recording::{AccelUnit, Origin};

    fn status() -> Status {
        Status {
            rows: 123_456,
            elapsed_s: 1234.56,
            rate_hz: Some(100.04),
            norm: Some(9.8134),
            temperature_c: Some(25.53),
            still: Some(true),
            ..Status::default()
        }
    }

    #[test]
    fn a_status_line_has_units() {
        let unit = |unit, lsb_per_g| {
            Some(AccelScale {
                unit,
                lsb_per_g,
                origin: Origin::Header,
            })
        };
        let metric = Status {
            accel: unit(AccelUnit::MetrePerSecondSquared, None),
            ..status()
        };
        assert_eq!(
            status_line(&metric),
            "1234.6 s  123456 rows  at rest  ‖a‖ 9.81 m/s²  100.0 Hz  25.5 °C"
        );
        let counts = Status {
            norm: Some(8201.0),
            accel: unit(AccelUnit::Counts, Some(8192.0)),
            paused: true,
            ..status()
        };
        assert_eq!(
            status_line(&counts),
            "1234.6 s  123456 rows  PAUSED  ‖a‖ 9.82 m/s²  100.0 Hz  25.5 °C"
        );
        let empty = Status {
            rows: 5,
            ..Status::default()
        };
        assert_eq!(status_line(&empty), "0.0 s  5 rows");
    }

    #[test]
    fn a_status_line_has_poses_as_far_as_there_is_room() {
        let poses = |done: &[&str]| {
            let line = status_line(&Status {
                up: Some("-x".to_owned()),
                done: Some(done.iter().map(|face| (*face).to_owned()).collect()),
                ..status()
            });
            assert!(line.chars().count() <= MAX_COLUMNS);
            line
        };
        assert_eq!(
            poses(&["+x", "+y"]),
            "1234.6 s  123456 rows  at rest  up: -x  missing -x -y ±z  ‖a‖ 9.81  100.0 Hz"
        );
        assert!(poses(&["+x", "-x", "+y", "-y", "+z", "-z"]).contains("up: -x  all 6 done  "));
    }
}
