//! Slow noise: bias instability and random walk.
//!
//! Flicker noise of one-sided density B²/(πf) is a sum of processes that each forget exponentially
//! (Ornstein–Uhlenbeck), two in a decade of time constants: the sum deviates from 1/f by less than
//! 0.1 %. The constants reach from one row to thirty times the recording, and each process starts in
//! its stationary state.

use rand_chacha::ChaCha8Rng;

use super::options::SimulateOptions;
use super::random::{Purpose, normal, stream};

/// Ratio of neighbouring time constants.
const RATIO: f64 = 3.162_277_660_168_379_5;
/// The longest time constant over the length of the recording.
const LONGEST: f64 = 30.0;

/// Slow noise of ax … gz, row by row.
pub(super) struct SlowNoise {
    rng: ChaCha8Rng,
    /// Increment of the random walk, and deviation of each process.
    channels: [(f64, f64); 6],
    /// What a process keeps from row to row, and what is added for a unit of deviation.
    keeps: Vec<(f64, f64)>,
    walks: [f64; 6],
    states: Vec<[f64; 6]>,
    is_silent: bool,
}

impl SlowNoise {
    pub(super) fn new(options: &SimulateOptions, duration_s: f64, file: usize) -> Self {
        let o = &options.sensor;
        let period_s = 1.0 / options.rate_hz;
        let step = |k: f64| k * period_s.sqrt();
        let each = |b: f64| b * (RATIO.ln() / std::f64::consts::PI).sqrt();
        let accel = (
            step(o.accel_random_walk_mps2_rts),
            each(o.accel_bias_instability_mps2),
        );
        let gyro = (
            step(o.gyro_random_walk_deg_s_rts.to_radians()),
            each(o.gyro_bias_instability_deg_h.to_radians() / 3600.0),
        );
        let channels = [accel, accel, accel, gyro, gyro, gyro];
        let mut rng = stream(options.seed, Purpose::SlowNoise, file);
        let mut keeps = Vec::new();
        let mut constant_s = period_s;
        while constant_s < LONGEST * duration_s {
            let keep = (-period_s / constant_s).exp();
            keeps.push((keep, (1.0 - keep * keep).sqrt()));
            constant_s *= RATIO;
        }
        let states = keeps
            .iter()
            .map(|_| channels.map(|(_, deviation)| deviation * normal(&mut rng)))
            .collect();
        SlowNoise {
            rng,
            channels,
            keeps,
            walks: [0.0; 6],
            states,
            is_silent: channels.iter().all(|c| *c == (0.0, 0.0)),
        }
    }

    /// Noise of the next row: m/s², rad/s.
    pub(super) fn next(&mut self) -> [f64; 6] {
        if self.is_silent {
            return [0.0; 6];
        }
        let mut out = self.walks;
        for (walk, (step, _)) in self.walks.iter_mut().zip(self.channels) {
            *walk += step * normal(&mut self.rng);
        }
        for (state, (keep, add)) in self.states.iter_mut().zip(&self.keeps) {
            for ((value, out), (_, deviation)) in state.iter_mut().zip(&mut out).zip(self.channels)
            {
                *out += *value;
                *value = keep * *value + add * deviation * normal(&mut self.rng);
            }
        }
        out
    }
}
