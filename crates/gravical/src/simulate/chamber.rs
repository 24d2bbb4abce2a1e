//! The temperature of the part: on a table it warms up, in a chamber it is
//! cooled and warmed again.

use super::options::SensorOptions;
use super::scenario_options::SoakOptions;
use super::sensor::START_TEMPERATURE_C;

/// °C above the start: what the thermometer says, and what the drift follows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Warmth {
    pub thermometer_c: f64,
    pub felt_c: f64,
}

/// The temperature as a function of time, which only goes forwards.
pub(super) struct Chamber<'a> {
    sensor: &'a SensorOptions,
    soak: Option<(SoakOptions, f64)>,
    warm_s: f64,
    felt_c: Option<f64>,
}

impl<'a> Chamber<'a> {
    /// `warm_s` is how long the part has been on; a soak lasts `duration_s`.
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
            felt_c: None,
        }
    }

    pub fn at(&mut self, t_s: f64) -> Warmth {
        let Some((soak, duration_s)) = &self.soak else {
            let warmer = warming(self.sensor, self.warm_s + t_s);
            return Warmth {
                thermometer_c: warmer,
                felt_c: warmer,
            };
        };
        let turn = std::f64::consts::TAU * t_s / duration_s;
        let thermometer_c = soak.low_c + 0.5 * (soak.high_c - soak.low_c) * (1.0 + turn.cos())
            - START_TEMPERATURE_C;
        // A play as in a gear: what is felt follows when it is pulled.
        let play = 0.5 * soak.hysteresis_c;
        let felt_c = self
            .felt_c
            .unwrap_or(thermometer_c)
            .clamp(thermometer_c - play, thermometer_c + play);
        self.felt_c = Some(felt_c);
        Warmth {
            thermometer_c,
            felt_c,
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
    fn a_soak_goes_down_and_comes_back_with_play() {
        let sensor = SensorOptions::default();
        let soak = SoakOptions {
            high_c: 50.0,
            low_c: -10.0,
            hysteresis_c: 4.0,
            ..SoakOptions::default()
        };
        let mut chamber = Chamber::new(&sensor, Some(soak), 1000.0, 0.0);
        let all: Vec<Warmth> = (0..=1000).map(|t| chamber.at(f64::from(t))).collect();
        let there = |i: usize| all[i].thermometer_c + START_TEMPERATURE_C;
        assert!((there(0) - 50.0).abs() < 1e-9 && (there(500) + 10.0).abs() < 1e-9);
        assert!((there(1000) - 50.0).abs() < 1e-9);
        assert!((all[250].felt_c - all[250].thermometer_c - 2.0).abs() < 1e-9);
        assert!((all[750].felt_c - all[750].thermometer_c + 2.0).abs() < 1e-9);
    }
}
