//! Temperature of the part: it warms up on a table, or is cooled and warmed in a chamber.

use super::options::SensorOptions;
use super::scenario_options::SoakOptions;
use super::sensor::START_TEMPERATURE_C;

/// °C above the start: the reading of the thermometer, and the temperature that determines the
/// drift.
#[derive(Debug, Clone, Copy)]
pub(super) struct Warmth {
    pub thermometer_c: f64,
    pub drift_c: f64,
}

/// Temperature as a function of time, which must not decrease.
pub(super) struct Chamber<'a> {
    sensor: &'a SensorOptions,
    soak: Option<(SoakOptions, f64)>,
    warm_s: f64,
    drift_c: Option<f64>,
}

impl<'a> Chamber<'a> {
    /// `warm_s`: how long the part has been switched on; a soak lasts `duration_s`.
    pub fn new(
        sensor: &'a SensorOptions,
        soak: Option<SoakOptions>,
        duration_s: f64,
        warm_s: f64,
    ) -> Self {
        Self {
            sensor,
            soak: soak.map(|s| (s, duration_s)),
            warm_s,
            drift_c: None,
        }
    }

    pub fn at(&mut self, t_s: f64) -> Warmth {
        let Some((soak, duration_s)) = &self.soak else {
            let warmer = warming(self.sensor, self.warm_s + t_s);
            return Warmth {
                thermometer_c: warmer,
                drift_c: warmer,
            };
        };
        let turn = std::f64::consts::TAU * t_s / duration_s;
        let thermometer_c = soak.low_c + 0.5 * (soak.high_c - soak.low_c) * (1.0 + turn.cos())
            - START_TEMPERATURE_C;
        // Mechanical play as a model of hysteresis.
        let play = 0.5 * soak.hysteresis_c;
        let drift_c = self
            .drift_c
            .unwrap_or(thermometer_c)
            .clamp(thermometer_c - play, thermometer_c + play);
        self.drift_c = Some(drift_c);
        Warmth {
            thermometer_c,
            drift_c,
        }
    }
}

/// °C above the start after `on_s` seconds.
pub(super) fn warming(o: &SensorOptions, on_s: f64) -> f64 {
    o.temperature_rise_c * -(-on_s / o.temperature_time_s).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_soak_cools_and_warms_with_hysteresis() {
        let sensor = SensorOptions::default();
        let soak = SoakOptions {
            high_c: 50.0,
            low_c: -10.0,
            hysteresis_c: 4.0,
        };
        let mut chamber = Chamber::new(&sensor, Some(soak), 1000.0, 0.0);
        let all: Vec<Warmth> = (0..=1000).map(|t| chamber.at(f64::from(t))).collect();
        let there = |i: usize| all[i].thermometer_c + START_TEMPERATURE_C;
        assert!((there(0) - 50.0).abs() < 1e-9 && (there(500) + 10.0).abs() < 1e-9);
        assert!((there(1000) - 50.0).abs() < 1e-9);
        assert!((all[250].drift_c - all[250].thermometer_c - 2.0).abs() < 1e-9);
        assert!((all[750].drift_c - all[750].thermometer_c + 2.0).abs() < 1e-9);
    }
}
