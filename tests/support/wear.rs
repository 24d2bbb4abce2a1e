//! A device that is worn: rests in many attitudes, movement between them, a temperature that
//! follows the day; with the errors of its sensor known.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::cwa::{Counts, Device};

/// The errors of the sensor, axis by axis.
pub const OFFSET_G: [f64; 3] = [0.021, -0.034, 0.048];
pub const GAIN: [f64; 3] = [1.012, 0.991, 1.007];
/// Change of the offset, g/°C, from 25 °C on.
pub const DRIFT_G_PER_C: [f64; 3] = [0.0006, -0.0004, 0.0011];

/// Standard deviation of the noise, g.
const NOISE_G: f64 = 0.003;

/// Wear, sample by sample.
pub struct Wear {
    random: ChaCha8Rng,
    rate_hz: f64,
    /// Direction of gravity in the axes of the device, and its change per sample.
    up: [f64; 3],
    turn: [f64; 3],
    /// Samples left of the rest or of the movement.
    left: u64,
    moving: bool,
    rests_s: std::ops::Range<f64>,
    sample: u64,
}

impl Wear {
    /// Rests last some time out of `rests_s`.
    pub fn new(device: &Device, rests_s: std::ops::Range<f64>, seed: u64) -> Self {
        Wear {
            random: ChaCha8Rng::seed_from_u64(seed),
            rate_hz: device.true_rate_hz,
            up: [0.0, 0.0, 1.0],
            turn: [0.0; 3],
            left: 0,
            moving: true,
            rests_s,
            sample: 0,
        }
    }

    /// Temperature, °C: a day's course around that of the skin.
    pub fn temperature_c(&self) -> f64 {
        let day = self.sample as f64 / self.rate_hz / 86_400.0 * std::f64::consts::TAU;
        27.0 + 5.0 * day.sin() + 1.5 * (9.0 * day).sin()
    }

    /// The temperature as the converter of the device reads it.
    pub fn temperature(&self) -> u16 {
        // 500 mV at 0 °C, 10 mV for each °C, 1024 steps over 3 V.
        ((500.0 + 10.0 * self.temperature_c()) / 3000.0 * 1024.0).round() as u16
    }

    /// The next sample in counts of `device`.
    pub fn next(&mut self, device: &Device, temperature_c: f64) -> Counts {
        if self.left == 0 {
            self.moving = !self.moving;
            let seconds = match self.moving {
                true => self.random.random_range(3.0..20.0),
                false => self.random.random_range(self.rests_s.clone()),
            };
            self.left = (seconds * self.rate_hz) as u64 + 1;
            self.turn = [0; 3].map(|_| self.random.random_range(-3.0..3.0) / self.rate_hz);
        }
        self.left -= 1;
        self.sample += 1;
        let mut force = self.up;
        let mut rate_deg_s = [0.0; 3];
        if self.moving {
            let [x, y, z] = self.turn;
            let [a, b, c] = self.up;
            let moved = [a + y * c - z * b, b + z * a - x * c, c + x * b - y * a];
            let length = moved.iter().map(|v| v * v).sum::<f64>().sqrt();
            self.up = moved.map(|v| v / length);
            force = self.up;
            for (axis, value) in force.iter_mut().enumerate() {
                let phase = self.left as f64 / self.rate_hz * (7.0 + axis as f64);
                *value += 0.2 * phase.sin();
            }
            rate_deg_s = self.turn.map(|t| (-t * self.rate_hz).to_degrees());
        }
        let mut counts = [0; 6];
        for axis in 0..3 {
            // A sum of four uniform numbers is nearly normal.
            let sum: f64 = (0..4).map(|_| self.random.random::<f64>()).sum();
            let noise_g = NOISE_G * (sum - 2.0) * 3.0_f64.sqrt();
            let offset = OFFSET_G[axis] + DRIFT_G_PER_C[axis] * (temperature_c - 25.0);
            let read_g = GAIN[axis] * force[axis] + offset + noise_g;
            let step = device.accel_step();
            counts[axis] = ((read_g / device.accel_g() / step).round() * step) as i16;
            let rate = rate_deg_s[axis] + 0.3 + 10.0 * noise_g;
            counts[axis + 3] = (rate / device.gyro_deg_s()).round() as i16;
        }
        counts
    }

    /// The next block of `device`.
    pub fn block(&mut self, device: &mut Device) -> [u8; 512] {
        let (raw, celsius) = (self.temperature(), self.temperature_c());
        let samples: Vec<Counts> = (0..device.coding.samples())
            .map(|_| self.next(device, celsius))
            .collect();
        device.block(&samples, raw)
    }
}
