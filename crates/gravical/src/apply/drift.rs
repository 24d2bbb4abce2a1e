//! Subtraction of the temperature drift.

use gravical_recording::Piece;
use serde::Serialize;

use crate::calibration_file::{CHANNELS, Calibration, TemperatureModel};
use crate::finding::CalibrationCase;
use crate::recording::{Finding, LineSpans, Recording};
use crate::temperature::{NoTemperature, not_applied};

/// Temperatures outside the range by no more than this are not reported, °C: thermometers are
/// noisy.
const NEAR_C: f64 = 0.5;

/// Result of the temperature correction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TemperatureOutcome {
    /// Channels whose drift was subtracted.
    pub channels: Vec<&'static str>,
    /// Range of the model, °C.
    pub range_c: [f64; 2],
}

/// Temperature correction of a recording.
pub(super) struct Drift {
    pub model: TemperatureModel,
    channels: Vec<&'static str>,
    /// Last known temperature, at first that of the first row that has one.
    now_c: f64,
    /// Drift of each channel at this temperature.
    at: [f64; 6],
    outside: LineSpans,
    outside_range_c: [f64; 2],
}

impl Drift {
    /// `None` if the calibration has no drift, or if the recording has no temperatures; a finding
    /// then reports the possible error.
    pub fn new(
        calibration: &Calibration,
        recording: &Recording,
        findings: &mut Vec<Finding>,
    ) -> Option<Self> {
        let model = calibration.drift.as_ref()?;
        // Without a calibration of the gyroscope its columns stay unchanged.
        let has_gyro = calibration.gyroscope.is_some() && recording.gyro.is_some();
        let is_corrected = |name: &&str| model.channel(name).is_some_and(|c| c.is_corrected());
        let channels = CHANNELS.into_iter().take(if has_gyro { 6 } else { 3 });
        let channels: Vec<&'static str> = channels.filter(is_corrected).collect();
        if channels.is_empty() {
            return None;
        }
        let mut temperatures = recording.temperature_c.iter().flatten();
        let Some(first_c) = temperatures.find(|t| t.is_finite()) else {
            let why = if recording.units.has_unknown_temperature {
                NoTemperature::NotCelsius
            } else {
                NoTemperature::NotRecorded
            };
            findings.push(not_applied(model, why));
            return None;
        };
        Some(Drift {
            channels,
            now_c: *first_c,
            at: model.drift_at(*first_c),
            outside: LineSpans::default(),
            outside_range_c: [f64::INFINITY, f64::NEG_INFINITY],
            model: model.clone(),
        })
    }

    /// Converts the readings of rows to the reference temperature; a row without a temperature has
    /// that of the row before.
    pub fn subtract(&mut self, piece: &mut Piece) {
        let [low_c, high_c] = self.model.range_c;
        let gyro = piece.gyro.iter_mut().flatten();
        let mut channels: Vec<_> = piece.accel.iter_mut().chain(gyro).collect();
        let rows = piece.lines.iter().enumerate();
        for (row, line) in rows.filter(|(row, _)| piece.is_measured[*row]) {
            let t_c = piece.temperature_c.as_ref().map_or(f64::NAN, |t| t[row]);
            if t_c.is_finite() && t_c != self.now_c {
                self.now_c = t_c;
                self.at = self.model.drift_at(t_c);
            }
            if !(low_c - NEAR_C..=high_c + NEAR_C).contains(&self.now_c) {
                self.outside.push(u64::from(*line));
                let [coldest, warmest] = self.outside_range_c;
                self.outside_range_c = [coldest.min(self.now_c), warmest.max(self.now_c)];
            }
            for (channel, drift) in channels.iter_mut().zip(self.at) {
                channel[row] -= drift;
            }
        }
    }

    /// Adds the finding and returns the result; to be called after the last row.
    pub fn finish(self, findings: &mut Vec<Finding>) -> TemperatureOutcome {
        if !self.outside.is_empty() {
            let case = CalibrationCase::RowsOutside {
                rows: self.outside.count(),
                rows_c: self.outside_range_c,
                model_c: self.model.range_c,
            };
            findings.push(case.finding().at_lines(&self.outside));
        }
        TemperatureOutcome {
            channels: self.channels,
            range_c: self.model.range_c,
        }
    }
}
