//! The state of the recording for the person who records: rate, magnitude, rest, poses; in one
//! line.

use std::collections::BTreeSet;

use gravical::core::matrix3::norm;
use gravical::inspect::inspect;
use gravical::poses::face::{AXES, AxisMap, Face};
use gravical::recording::{AccelScale, Finding, Recording, Severity};
use serde::Serialize;

/// A rest of this length is a pose, s.
const POSE_S: f64 = 2.0;
/// The magnitude is a mean over this time, and a rest ends within it, s.
const RECENT_S: f64 = 0.5;
/// A rest takes at least 1 s: before this time it is not known whether there is one, s.
const FIRST_REST_S: f64 = 1.5;

/// The recording at one moment.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Status {
    /// Rows stored.
    pub rows: u64,
    /// Since the first row, without pauses, s.
    pub elapsed_s: f64,
    /// Rows are not stored.
    pub paused: bool,
    /// Lines rejected so far.
    pub rejected: u64,
    /// Rows a second, by their stamps.
    pub rate_hz: Option<f64>,
    /// Magnitude of the acceleration, mean of the last half second, in the unit of the file.
    pub norm: Option<f64>,
    #[serde(skip)]
    pub accel: Option<AccelScale>,
    /// Temperature of the sensor, °C.
    pub temperature_c: Option<f64>,
    /// Whether the sensor is at rest.
    pub still: Option<bool>,
    /// The face that is up at rest: `+x`.
    pub up: Option<String>,
    /// Faces that were recorded as a pose.
    pub done: Option<Vec<String>>,
}

/// Judges the last rows once a second.
#[derive(Default)]
pub struct Monitor {
    /// Faces that were recorded as a pose.
    done: BTreeSet<String>,
    /// Findings that were returned: their kinds, and their messages without numbers.
    said: BTreeSet<String>,
}

impl Monitor {
    /// Adds to the state what the last rows say; returns what may spoil them and was not returned
    /// before.
    pub fn observe(&mut self, status: &mut Status, recording: &Recording) -> Vec<Finding> {
        let inspection = inspect(recording, &AxisMap::default());
        status.rate_hz = recording.timing.rate_hz();
        let (rows, rate_hz) = (recording.rows(), status.rate_hz.unwrap_or(1.0));
        let recent = rows.saturating_sub((RECENT_S * rate_hz).ceil() as usize);
        let norms =
            (recent..rows).map(|row| norm(&recording.accel.each_ref().map(|axis| axis[row])));
        let norms: Vec<f64> = norms.filter(|norm| norm.is_finite()).collect();
        status.norm = (!norms.is_empty()).then(|| norms.iter().sum::<f64>() / norms.len() as f64);
        status.accel = Some(recording.accel_scale);
        let temperatures = recording.temperature_c.iter().flatten();
        status.temperature_c = temperatures.copied().rfind(|t| t.is_finite());
        if rows as f64 >= FIRST_REST_S * rate_hz {
            status.still = Some(false);
            for rest in inspection.static_intervals {
                if (rest.end_row - rest.start_row) as f64 >= POSE_S * rate_hz {
                    self.done.extend(rest.face.clone());
                }
                if rest.end_row > recent {
                    status.still = Some(true);
                    status.up = rest.face;
                }
            }
            status.done = Some(self.done.iter().cloned().collect());
        }
        let mut findings = inspection.findings;
        findings.retain(|finding| {
            let words = finding.message.replace(|c: char| c.is_ascii_digit(), "");
            finding.severity == Severity::Warning
                && finding.kind.is_of_samples()
                && self.said.insert(format!("{} {words}", finding.kind.name()))
        });
        findings
    }
}

/// Columns of the status line.
const MAX_COLUMNS: usize = 79;

impl Status {
    /// One line of at most 79 columns: what is needed most comes first, and the rest where there is
    /// room.
    pub fn line(&self) -> String {
        let mut parts = vec![
            format!("{:.1} s", self.elapsed_s),
            format!("{} rows", self.rows),
        ];
        parts.extend(match (self.paused, self.still) {
            (true, _) => Some("PAUSED".to_owned()),
            (_, Some(true)) => Some("at rest".to_owned()),
            (_, Some(false)) => Some("moving".to_owned()),
            (_, None) => None,
        });
        parts.extend(self.up.as_ref().map(|up| format!("up: {up}")));
        parts.extend(self.done.as_ref().map(|done| missing(done)));
        parts.extend(self.norm.map(|norm| {
            // In m/s², or as it stands in a file of unknown unit.
            match self.accel.and_then(|accel| accel.nominal()) {
                Some(per_mps2) => format!("‖a‖ {:.2} m/s²", norm / per_mps2),
                None => format!("‖a‖ {norm:.2}"),
            }
        }));
        parts.extend((self.rejected > 0).then(|| format!("{} rejected", self.rejected)));
        parts.extend(self.rate_hz.map(|rate| format!("{rate:.1} Hz")));
        parts.extend(self.temperature_c.map(|t| format!("{t:.1} °C")));
        while parts.join("  ").chars().count() > MAX_COLUMNS && parts.pop().is_some() {}
        parts.join("  ")
    }
}

/// The faces that are no pose yet: `missing ±x -y`.
fn missing(done: &[String]) -> String {
    let mut missing = Face::all().map(Face::name).to_vec();
    missing.retain(|face| !done.contains(face));
    if missing.is_empty() {
        return "all 6 done".to_owned();
    }
    let mut text = format!("missing {}", missing.join(" "));
    for axis in AXES {
        text = text.replace(&format!("+{axis} -{axis}"), &format!("±{axis}"));
    }
    text
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
            metric.line(),
            "1234.6 s  123456 rows  at rest  ‖a‖ 9.81 m/s²  100.0 Hz  25.5 °C"
        );
        let counts = Status {
            norm: Some(8201.0),
            accel: unit(AccelUnit::Counts, Some(8192.0)),
            paused: true,
            ..status()
        };
        assert_eq!(
            counts.line(),
            "1234.6 s  123456 rows  PAUSED  ‖a‖ 9.82 m/s²  100.0 Hz  25.5 °C"
        );
        let empty = Status {
            rows: 5,
            ..Status::default()
        };
        assert_eq!(empty.line(), "0.0 s  5 rows");
    }

    #[test]
    fn a_status_line_has_poses_as_far_as_there_is_room() {
        let poses = |done: &[&str]| {
            let line = Status {
                up: Some("-x".to_owned()),
                done: Some(done.iter().map(|face| (*face).to_owned()).collect()),
                ..status()
            }
            .line();
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
