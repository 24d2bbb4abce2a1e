//! The low-pass filter inside the sensor.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Second-order Butterworth low-pass (bilinear transform, cutoff prewarped; direct form II
/// transposed) for one channel.
///
/// The real filter of the part is not published; its data sheet gives a delay of 4.9 ms for the
/// 44 Hz setting, this filter has 5.1 ms.
#[derive(Debug, Clone, Copy)]
pub(super) struct LowPass {
    forward: [f64; 3],
    back: [f64; 2],
    state: [f64; 2],
}

impl LowPass {
    /// `cutoff_hz` is the −3 dB frequency and must be below half of `rate_hz`.
    pub(super) fn new(cutoff_hz: f64, rate_hz: f64) -> Self {
        let k = (PI * cutoff_hz / rate_hz).tan();
        let scale = 1.0 / (1.0 + k / FRAC_1_SQRT_2 + k * k);
        let gain = k * k * scale;
        Self {
            forward: [gain, 2.0 * gain, gain],
            back: [
                2.0 * (k * k - 1.0) * scale,
                (1.0 - k / FRAC_1_SQRT_2 + k * k) * scale,
            ],
            state: [0.0; 2],
        }
    }

    /// Sets the steady state for a constant `input`.
    pub(super) fn settle(&mut self, input: f64) {
        self.state[1] = (self.forward[2] - self.back[1]) * input;
        self.state[0] = (self.forward[1] - self.back[0]) * input + self.state[1];
    }

    pub(super) fn update(&mut self, input: f64) -> f64 {
        let output = self.forward[0] * input + self.state[0];
        self.state[0] = self.forward[1] * input - self.back[0] * output + self.state[1];
        self.state[1] = self.forward[2] * input - self.back[1] * output;
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_settled_filter_passes_a_constant_unchanged() {
        let mut filter = LowPass::new(44.0, 1000.0);
        filter.settle(9.81);
        for _ in 0..100 {
            assert!((filter.update(9.81) - 9.81).abs() < 1e-12);
        }
    }

    #[test]
    fn cutoff_and_delay_are_as_specified() {
        let gain_at = |f: f64| {
            let mut filter = LowPass::new(44.0, 1000.0);
            let mut peak: f64 = 0.0;
            for i in 0..4000 {
                let y = filter.update((2.0 * PI * f * f64::from(i) / 1000.0).sin());
                if i > 2000 {
                    peak = peak.max(y.abs());
                }
            }
            peak
        };
        assert!((gain_at(44.0) - FRAC_1_SQRT_2).abs() < 1e-3);
        assert!(gain_at(220.0) < 0.04);
        let mut filter = LowPass::new(44.0, 1000.0);
        let lag = (0..1000)
            .map(|i| f64::from(i) - filter.update(f64::from(i)))
            .last();
        assert!((lag.unwrap() - 5.1).abs() < 0.1, "{lag:?}");
    }
}
