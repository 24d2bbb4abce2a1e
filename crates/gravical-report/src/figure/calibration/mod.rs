//! Figures of a calibration.

mod captures;
mod parameters;
mod placements;
mod sphere;
mod temperature;
#[cfg(test)]
mod tests;
mod uncertainty;

use gravical::calibration_file::CalibrationFile;
use gravical::poses::Segmentation;
use gravical::recording::{AccelUnit, Recording};

use super::Figure;

/// Names of all figures that a calibration can have, in the order of a report.
#[doc(hidden)]
pub const NAMES: [&str; 9] = [
    "norm",
    "residuals",
    "sphere",
    "tilt",
    "captures",
    "parameters",
    "budget",
    "noise",
    "temperature",
];

/// The recordings behind a calibration, and how they were cut.
#[derive(Debug, Clone, Copy)]
pub struct Session<'a> {
    /// The recordings.
    pub recordings: &'a [Recording],
    /// Placements and turns.
    pub segmentation: &'a Segmentation,
}

/// All figures that a calibration allows, in the order of [`NAMES`]. What the data
/// do not show is left out; without the session that is the raw captures, noise and
/// the temperature over time.
#[must_use]
pub fn figures(file: &CalibrationFile, session: Option<Session<'_>>) -> Vec<Figure> {
    let scale = Scale::of(file, session);
    let all = [
        placements::norm(file, &scale),
        placements::residuals(file),
        sphere::sphere(file),
        placements::tilt(file),
        session.and_then(|s| captures::captures(s, &scale)),
        parameters::parameters(file, &scale),
        uncertainty::budget(file),
        session.and_then(|s| captures::noise(file, s, &scale)),
        temperature::temperature(file, session),
    ];
    all.into_iter().flatten().collect()
}

/// What raw readings are in m/s² before anything is calibrated.
struct Scale {
    /// Unit of the file.
    unit: AccelUnit,
    /// What 1 m/s² is in it; none where nothing tells.
    nominal: Option<f64>,
    /// Reading without acceleration, of unsigned counts; none where nothing tells.
    offset: Option<f64>,
}

impl Scale {
    fn of(file: &CalibrationFile, session: Option<Session<'_>>) -> Self {
        let a = &file.accelerometer;
        let first = session.and_then(|s| s.recordings.first());
        let deviation = a.scale_deviation_percent.map(|d| d[0]);
        let by_file = deviation.map(|d| a.scale[0] / (1.0 + d / 100.0));
        let nominal = first
            .map_or(by_file, |r| r.accel_scale.nominal())
            .filter(|n| n.is_finite() && *n != 0.0);
        // A bias beyond 4 g is an offset of the counts, and its size a guess.
        let far = |n: f64| a.bias.iter().any(|b| (b / n).abs() > 40.0);
        let offset = match first {
            Some(recording) => Some(recording.zero_offset),
            None => (!nominal.is_some_and(far)).then_some(0.0),
        };
        Scale {
            unit: a.input_unit,
            nominal,
            offset,
        }
    }

    /// A raw reading in m/s² as the nominal scale has it.
    fn nominally(&self, raw: [f64; 3]) -> Option<[f64; 3]> {
        let (nominal, offset) = self.nominal.zip(self.offset)?;
        Some(raw.map(|v| (v - offset) / nominal))
    }

    /// Unit of raw values in a figure, and what to multiply differences in the
    /// file's unit with to have them in it: m/s² where that can be.
    fn shown(&self) -> (&'static str, f64) {
        match self.nominal {
            Some(nominal) => ("m/s²", 1.0 / nominal),
            None => (accel_unit(self.unit), 1.0),
        }
    }
}

/// As it stands on an axis.
fn accel_unit(unit: AccelUnit) -> &'static str {
    match unit {
        AccelUnit::MetrePerSecondSquared => "m/s²",
        AccelUnit::Unknown => "unit of the file",
        other => other.name(),
    }
}

fn norm_of(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// 0, 1, 2 …: places on an axis of names.
fn places(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64).collect()
}
