//! Drift with temperature, taken off row by row.

#[cfg(test)]
mod tests;

use serde::Serialize;

use crate::calibration_file::{CHANNELS, CalibrationFile, TemperatureModel};
use crate::recording::layout::Layout;
use crate::recording::monitor::is_celsius;
use crate::recording::names::Quantity;
use crate::recording::row::{ACCEL, TEMPERATURE, Values};
use crate::recording::text::HeadChannels;
use crate::recording::{Finding, FindingKind, LineSpans, POSSIBLE_C};
use crate::temperature::{cost_text, evaluate};

/// So far beyond the range nothing is told, °C: thermometers are noisy.
const NEAR_C: f64 = 0.5;

/// What was done about drift with temperature.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TemperatureOutcome {
    /// Channels whose drift was taken off; empty when the recording has no
    /// temperatures.
    pub channels: Vec<String>,
    /// Range of the model, °C.
    pub range_c: [f64; 2],
    /// Rows more than 0.5 °C beyond it: there the drift at its edge is held.
    pub rows_outside: u64,
    /// Rows without a temperature, for which the last one before was taken.
    pub rows_held: u64,
    /// Rows whose drift was not taken off, since no temperature was known.
    pub rows_without: u64,
}

/// Follows the temperature.
pub(crate) struct Drift {
    model: TemperatureModel,
    applied: Vec<usize>,
    /// Known last; NaN before the first.
    now_c: f64,
    /// What the drift and gain are at it.
    at: Correction,
    seen_c: [f64; 2],
    outside: LineSpans,
    held: LineSpans,
    without: LineSpans,
}

/// Of each channel: what is taken off, and what the rest is divided by.
#[derive(Clone, Copy)]
struct Correction {
    drift: [f64; 6],
    divisor: [f64; 6],
}

impl Correction {
    const NONE: Self = Correction {
        drift: [0.0; 6],
        divisor: [1.0; 6],
    };
}

impl Drift {
    /// None when the calibration has nothing to take off, or the recording no
    /// temperature to do it by: then a finding says what that may cost.
    pub fn new(
        calibration: &CalibrationFile,
        head: &HeadChannels,
        layout: &Layout,
        findings: &mut Vec<Finding>,
    ) -> Option<Self> {
        let model = calibration.temperature_model.as_ref()?;
        // Without a gyroscope's calibration its columns stay as they are.
        let channels = if calibration.gyroscope.is_some() && layout.has_gyro() {
            6
        } else {
            3
        };
        let applied: Vec<usize> = (0..channels)
            .filter(|i| model.channel(CHANNELS[*i]).is_some_and(|c| c.is_accepted()))
            .collect();
        if applied.is_empty() {
            return None;
        }
        let why = match layout.field(Quantity::Temperature) {
            None => Some("the recording has no temperatures"),
            Some(_) if !is_celsius(&head.temperature, findings) => {
                Some("the recording's temperatures are no °C")
            }
            Some(_) => None,
        };
        if let Some(why) = why {
            findings.push(Finding::new(
                FindingKind::TemperatureNotApplied,
                format!(
                    "{why}, so the calibration's drift with temperature is not taken off: {}",
                    cost_text(model)
                ),
            ));
            return None;
        }
        let mut drift = Drift {
            model: model.clone(),
            applied,
            now_c: f64::NAN,
            at: Correction::NONE,
            seen_c: [f64::INFINITY, f64::NEG_INFINITY],
            outside: LineSpans::default(),
            held: LineSpans::default(),
            without: LineSpans::default(),
        };
        // Rows before the first temperature are nearer to it than to none.
        if let Some(first) = head.temperature.iter().find(|t| POSSIBLE_C.contains(*t)) {
            drift.go_to(*first);
        }
        Some(drift)
    }

    fn go_to(&mut self, t_c: f64) {
        self.now_c = t_c;
        self.at = self.correction(t_c);
    }

    fn correction(&self, t_c: f64) -> Correction {
        let [low, high] = self.model.range_c;
        let x = t_c.clamp(low, high) - self.model.reference_c;
        let mut out = Correction::NONE;
        for &i in &self.applied {
            if let Some(channel) = self.model.channel(CHANNELS[i]) {
                out.drift[i] = evaluate(&channel.coefficients, x);
                out.divisor[i] = 1.0 + evaluate(&channel.scale_coefficients, x);
            }
        }
        out
    }

    /// The readings of a row as they would be at the reference temperature.
    #[inline]
    pub fn taken_off(&mut self, values: &Values, line: u64) -> Values {
        let t_c = values[TEMPERATURE];
        if POSSIBLE_C.contains(&t_c) {
            if t_c != self.now_c {
                self.go_to(t_c);
            }
        } else if self.now_c.is_nan() {
            self.without.push(line);
        } else {
            self.held.push(line);
        }
        if self.now_c.is_finite() {
            let [low, high] = self.model.range_c;
            if !(low - NEAR_C..=high + NEAR_C).contains(&self.now_c) {
                self.outside.push(line);
                self.seen_c = [
                    self.seen_c[0].min(self.now_c),
                    self.seen_c[1].max(self.now_c),
                ];
            }
        }
        let mut out = *values;
        for ((v, drift), divisor) in out[ACCEL..ACCEL + 6]
            .iter_mut()
            .zip(self.at.drift)
            .zip(self.at.divisor)
        {
            *v = (*v - drift) / divisor;
        }
        out
    }

    /// The accelerometer of a row at `t_c` without its drift; one without a
    /// temperature as it is.
    pub fn accel_at(&self, mut accel: [f64; 3], t_c: f64) -> [f64; 3] {
        if POSSIBLE_C.contains(&t_c) {
            let at = self.correction(t_c);
            for ((v, drift), divisor) in accel.iter_mut().zip(at.drift).zip(at.divisor) {
                *v = (*v - drift) / divisor;
            }
        }
        accel
    }

    /// The findings and what was done, after the last row.
    pub fn finish(&self, findings: &mut Vec<Finding>) -> TemperatureOutcome {
        let [low, high] = self.model.range_c;
        if !self.outside.is_empty() {
            let [coldest, warmest] = self.seen_c;
            let mut beyond = Vec::new();
            if coldest < low {
                beyond.push(format!("down to {coldest:.1} °C"));
            }
            if warmest > high {
                beyond.push(format!("up to {warmest:.1} °C"));
            }
            findings.push(
                Finding::new(
                    FindingKind::TemperatureOutside,
                    format!(
                        "{} rows are outside of the {low:.1} to {high:.1} °C that the drift was measured in ({}): the drift at the edge is taken off there, and may be wrong",
                        self.outside.count(),
                        beyond.join(", ")
                    ),
                )
                .at_lines(&self.outside),
            );
        }
        if !self.held.is_empty() {
            findings.push(
                Finding::new(
                    FindingKind::TemperatureHeld,
                    format!(
                        "{} rows have no temperature: the last one known was taken",
                        self.held.count()
                    ),
                )
                .at_lines(&self.held),
            );
        }
        if !self.without.is_empty() {
            findings.push(
                Finding::new(
                    FindingKind::TemperatureNotApplied,
                    format!(
                        "{} rows come before the first temperature, so the calibration's drift is not taken off there: {}",
                        self.without.count(),
                        cost_text(&self.model)
                    ),
                )
                .at_lines(&self.without),
            );
        }
        TemperatureOutcome {
            channels: self
                .applied
                .iter()
                .map(|i| CHANNELS[*i].to_owned())
                .collect(),
            range_c: self.model.range_c,
            rows_outside: self.outside.count(),
            rows_held: self.held.count(),
            rows_without: self.without.count(),
        }
    }
}
