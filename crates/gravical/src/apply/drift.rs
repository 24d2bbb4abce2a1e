//! Subtraction of the temperature drift.

#[cfg(test)]
mod tests;

use std::array::from_fn;

use gravical_recording::Readings;
use serde::Serialize;

use crate::calibration_file::{CHANNELS, CalibrationFile, TemperatureModel};
use crate::recording::{Finding, FindingKind, LineSpans, Recording};
use crate::temperature::cost_text;

/// Temperatures outside the range by no more than this are not reported, °C: thermometers are
/// noisy.
const NEAR_C: f64 = 0.5;

/// Result of the temperature correction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TemperatureOutcome {
    /// Channels whose drift was subtracted; empty if the recording has no temperatures.
    pub channels: Vec<String>,
    /// Range of the model, °C.
    pub range_c: [f64; 2],
    /// Rows more than 0.5 °C outside the range: the drift at its edge was used.
    pub rows_outside: u64,
    /// Rows without a temperature, for which the last one was used.
    pub rows_held: u64,
    /// Rows whose drift was not subtracted because no temperature was known.
    pub rows_without: u64,
}

/// Temperature correction of a recording.
pub(super) struct Drift {
    model: TemperatureModel,
    /// Channels whose drift is subtracted.
    applied: Vec<&'static str>,
    /// Last known temperature; NaN before the first.
    now_c: f64,
    /// Drift of each channel at this temperature.
    at: [f64; 6],
    outside_range_c: [f64; 2],
    outside: LineSpans,
    held: LineSpans,
    without: LineSpans,
}

impl Drift {
    /// `with_gyro`: there is a gyroscope, in the recording or joined to it. `None` if the calibration
    /// has no drift, or if the recording has no temperatures; a finding
    /// then reports the possible error.
    pub fn new(
        calibration: &CalibrationFile,
        recording: &Recording,
        with_gyro: bool,
        findings: &mut Vec<Finding>,
    ) -> Option<Self> {
        let model = calibration.temperature_model.as_ref()?;
        // Without a calibration of the gyroscope its columns stay unchanged.
        let channels = if calibration.gyroscope.is_some() && with_gyro {
            6
        } else {
            3
        };
        let is_corrected = |name: &&str| model.channel(name).is_some_and(|c| c.is_corrected());
        let applied = CHANNELS.into_iter().take(channels).filter(is_corrected);
        let applied: Vec<&'static str> = applied.collect();
        if applied.is_empty() {
            return None;
        }
        let mut temperatures = match &recording.temperature_c {
            Some(temperature_c) => temperature_c.iter(),
            None => {
                let is_no_celsius = |f: &Finding| f.kind == FindingKind::TemperatureUnit;
                let why = if findings.iter().any(is_no_celsius) {
                    "the recording's temperatures are not in °C"
                } else {
                    "the recording has no temperatures"
                };
                findings.push(Finding::new(
                    FindingKind::TemperatureNotApplied,
                    format!(
                        "{why}, so the calibration's temperature drift is not subtracted: {}",
                        cost_text(model)
                    ),
                ));
                return None;
            }
        };
        let mut drift = Drift {
            model: model.clone(),
            applied,
            now_c: f64::NAN,
            at: [0.0; 6],
            outside_range_c: [f64::INFINITY, f64::NEG_INFINITY],
            outside: LineSpans::default(),
            held: LineSpans::default(),
            without: LineSpans::default(),
        };
        // Rows before the first temperature use that temperature.
        if let Some(first) = temperatures.find(|t| t.is_finite()) {
            drift.set_temperature(*first);
        }
        Some(drift)
    }

    fn set_temperature(&mut self, t_c: f64) {
        self.now_c = t_c;
        self.at = CHANNELS.map(|name| self.model.drift_at(name, t_c));
    }

    /// Converts the readings of rows to the reference temperature.
    pub fn subtract(&mut self, readings: &mut Readings, lines: &[u32]) {
        for (row, line) in lines
            .iter()
            .enumerate()
            .filter(|(r, _)| readings.is_measured[*r])
        {
            let t_c = readings.temperature_c.as_ref().map_or(f64::NAN, |t| t[row]);
            self.follow(t_c, u64::from(*line));
            let channels = readings
                .accel
                .iter_mut()
                .chain(readings.gyro.iter_mut().flatten());
            for (channel, drift) in channels.zip(self.at) {
                channel[row] -= drift;
            }
        }
    }

    /// Sets the temperature of the row in `line`; without one the last holds.
    fn follow(&mut self, t_c: f64, line: u64) {
        if t_c.is_finite() {
            if t_c != self.now_c {
                self.set_temperature(t_c);
            }
        } else if self.now_c.is_nan() {
            self.without.push(line);
        } else {
            self.held.push(line);
        }
        let [low, high] = self.model.range_c;
        if self.now_c.is_finite() && !(low - NEAR_C..=high + NEAR_C).contains(&self.now_c) {
            self.outside.push(line);
            self.outside_range_c = [
                self.outside_range_c[0].min(self.now_c),
                self.outside_range_c[1].max(self.now_c),
            ];
        }
    }

    /// The accelerometer at temperature `t_c` without its drift; unchanged without a temperature.
    pub fn accel_at(&self, accel: [f64; 3], t_c: f64) -> [f64; 3] {
        if t_c.is_finite() {
            from_fn(|axis| self.model.at_reference(axis, t_c, accel[axis]))
        } else {
            accel
        }
    }

    /// Adds the findings and returns the result; to be called after the last row.
    pub fn finish(self, findings: &mut Vec<Finding>) -> TemperatureOutcome {
        let [low, high] = self.model.range_c;
        let mut report = |kind, lines: &LineSpans, text: String| {
            if !lines.is_empty() {
                let text = format!("{} rows {text}", lines.count());
                findings.push(Finding::new(kind, text).at_lines(lines));
            }
        };
        let [coldest, warmest] = self.outside_range_c;
        let beyond = [
            (coldest < low).then(|| format!("down to {coldest:.1} °C")),
            (warmest > high).then(|| format!("up to {warmest:.1} °C")),
        ];
        let beyond: Vec<String> = beyond.into_iter().flatten().collect();
        report(
            FindingKind::TemperatureOutside,
            &self.outside,
            format!(
                "are outside the range of {low:.1} to {high:.1} °C in which the drift was measured ({}): the drift at its edge is subtracted, which may be wrong",
                beyond.join(", ")
            ),
        );
        report(
            FindingKind::TemperatureNotApplied,
            &self.without,
            format!(
                "are before the first temperature, so the calibration's drift is not subtracted from them: {}",
                cost_text(&self.model)
            ),
        );
        TemperatureOutcome {
            channels: self.applied.iter().map(|c| (*c).to_owned()).collect(),
            range_c: self.model.range_c,
            rows_outside: self.outside.count(),
            rows_held: self.held.count(),
            rows_without: self.without.count(),
        }
    }
}
