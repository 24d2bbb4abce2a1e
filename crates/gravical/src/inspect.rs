//! Contents of a recording.

use std::ops::Range;

use gravical_calibrate::poses::face::{AxisMap, CaseAxes, Face};
use gravical_core::matrix3;
use gravical_signal::stats::moments;
use serde::Serialize;

use crate::calibration_file::TemperatureModel;
use crate::finding::{Case, Finding};
use crate::poses::gyro_unit;
use crate::poses::rests::{find_rests, why_never_static};
use crate::poses::{MAX_FACE_ANGLE_DEG, is_too_short};
use crate::recording::{AccelScale, Clock, GyroScale, Recording};
use crate::temperature::study;

/// Result of [`inspect`].
#[derive(Debug, Clone, Serialize)]
pub struct Inspection {
    /// Path of the file as given.
    pub file: String,
    /// Text format of the file in words.
    pub description: String,
    /// Serial number of the sensor, where the file names it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Counts of lines.
    pub row_counts: LineCounts,
    /// Rates, duration, jitter.
    pub timing: Clock,
    /// Unit of the accelerometer.
    pub accelerometer: AccelScale,
    /// Unit of the gyroscope.
    pub gyroscope: Option<GyroScale>,
    /// Lowest and highest temperature, °C.
    pub temperature_c: Option<[f64; 2]>,
    /// Temperature drift at rest; null unless the temperature spans more than 5 °C.
    pub temperature_drift: Option<TemperatureModel>,
    /// Labels of the label column and their numbers of rows.
    pub labels: Vec<(String, u64)>,
    /// The static intervals, in order.
    pub static_intervals: Vec<StillSpan>,
    /// Which axes of the sensor are those of its case; null where the rests show fewer than two axes.
    pub case_axes: Option<CaseAxes>,
    /// Share of the rows in static intervals, 0 to 1.
    pub static_share: f64,
    /// Faults found.
    pub findings: Vec<Finding>,
}

/// Counts of all lines of a file.
#[derive(Debug, Clone, Serialize)]
pub struct LineCounts {
    /// Lines of the file.
    pub lines: u64,
    /// Lines that are rows.
    pub rows: u64,
    /// Lines set aside, by reason.
    pub aside: Vec<(String, u64)>,
    /// The sum as text.
    pub sum: String,
}

/// A static interval of a recording.
#[derive(Debug, Clone, Serialize)]
pub struct StillSpan {
    /// First row, from 0.
    pub start_row: usize,
    /// Row after the last.
    pub end_row: usize,
    /// First and last line of the file.
    pub lines: [u64; 2],
    /// Seconds since the start of the recording; null without a rate.
    pub start_s: Option<f64>,
    /// The same for the end.
    pub end_s: Option<f64>,
    /// Mean of the accelerometer, unit of the file.
    pub mean: [f64; 3],
    /// `+x` …; null for a free pose.
    pub face: Option<String>,
    /// Angle of the mean reading to the nearest face, degrees: tilt, bias and misalignment
    /// together.
    pub face_angle_deg: f64,
}

/// Inspects a recording; `axes` are those of its case.
pub fn inspect(recording: &Recording, axes: &AxisMap) -> Inspection {
    let mut findings = recording.findings.clone();
    let spans = find_rests(recording);
    if spans.is_empty() && !is_too_short(recording.rows(), 0.0) {
        let why = why_never_static(recording);
        findings.push(Case::NeverStatic { why }.finding().in_file(&recording.name));
    }
    let gyroscope = gyro_unit::judge(recording, None, &spans, &mut findings);
    let held: usize = spans.iter().map(Range::len).sum();
    let means = spans
        .iter()
        .map(|span| moments(&recording.accel, span.clone()).0);
    let means: Vec<[f64; 3]> = means.collect();
    let centre = gravical_fit::centre(&means);
    let forces = means.iter().map(|mean| matrix3::sub(mean, &centre));
    let case_axes = CaseAxes::of(forces);
    let stills = spans
        .iter()
        .zip(means)
        .map(|(span, mean)| {
            let up = axes.to_case(matrix3::sub(&mean, &centre));
            let (face, face_angle_deg) = Face::nearest(up);
            StillSpan {
                start_row: span.start,
                end_row: span.end,
                lines: recording.lines_of(span),
                start_s: recording.time_at(span.start),
                end_s: recording.time_at(span.end - 1),
                mean,
                face: (face_angle_deg <= MAX_FACE_ANGLE_DEG).then(|| face.name()),
                face_angle_deg,
            }
        })
        .collect();
    Inspection {
        file: recording.name.clone(),
        description: recording.format.describe(),
        serial: recording.format.serial(),
        columns: recording.format.names.clone(),
        row_counts: LineCounts {
            lines: recording.ledger.lines as u64,
            rows: recording.ledger.rows() as u64,
            aside: recording
                .ledger
                .counts()
                .map(|(reason, n)| (reason.name().to_owned(), n))
                .collect(),
            sum: recording.ledger.sum(),
        },
        timing: recording.clock.clone(),
        accelerometer: recording.units.accel,
        gyroscope,
        temperature_c: recording.temperature_range_c(),
        temperature_drift: study(std::slice::from_ref(recording)).ok(),
        labels: label_counts(recording),
        static_intervals: stills,
        case_axes,
        static_share: held as f64 / recording.rows().max(1) as f64,
        findings,
    }
}

fn label_counts(recording: &Recording) -> Vec<(String, u64)> {
    let Some(labels) = &recording.labels else {
        return Vec::new();
    };
    let mut counts = vec![0_u64; labels.names.len()];
    for &label in &labels.of_row {
        counts[label as usize] += 1;
    }
    labels.names.iter().cloned().zip(counts).collect()
}
