//! What is computed of the samples of one epoch.

use crate::stats::median;

/// Largest number of samples kept for the measures that need all of them at once: a minute at
/// 17 kHz. More rows in one epoch have a clock that stands still.
const MOST_SAMPLES: usize = 1 << 20;

/// The samples of one epoch.
#[derive(Debug, Clone, Default)]
pub(super) struct EpochSamples {
    /// Specific force along x, y, z, g.
    accel: [Vec<f64>; 3],
    norm: Vec<f64>,
    /// Samples, with those that were not kept.
    count: u64,
    temperature: (f64, u64),
}

/// Measures of an epoch; NaN without samples. Sources of the formulas: [`super`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measures {
    /// Means of ax, ay, az and ‖a‖, g.
    pub mean_g: [f64; 4],
    /// Their standard deviations (n − 1), g.
    pub sd_g: [f64; 4],
    /// Mean of max(‖a‖ − 1, 0), g.
    pub enmo_g: f64,
    /// Mean of |‖a‖ − mean ‖a‖|, g.
    pub mad_g: f64,
    /// Angle of the z axis above the horizontal plane, by the medians of the axes, °.
    pub angle_z_deg: f64,
    /// Mean temperature, °C.
    pub temperature_c: f64,
    /// Number of samples.
    pub samples: u64,
}

/// An epoch whose samples are complete.
#[derive(Debug, Clone, Copy)]
pub(super) struct Epoch {
    /// Its start, in epochs since 1970 or since the first sample.
    pub number: i64,
    pub measures: Measures,
    /// Number of samples that are missing.
    pub missing: u64,
}

impl EpochSamples {
    /// Adds a sample, in g.
    #[inline]
    pub fn push(&mut self, accel_g: [f64; 3]) {
        self.count += 1;
        if self.norm.len() == MOST_SAMPLES {
            return;
        }
        for (channel, value) in self.accel.iter_mut().zip(accel_g) {
            channel.push(value);
        }
        let [x, y, z] = accel_g;
        self.norm.push((x * x + y * y + z * z).sqrt());
    }

    /// Adds a temperature, °C; NaN is none.
    #[inline]
    pub fn push_temperature(&mut self, t_c: f64) {
        if t_c.is_finite() {
            self.temperature.0 += t_c;
            self.temperature.1 += 1;
        }
    }

    /// The measures; nothing is left.
    pub fn take(&mut self) -> Measures {
        let mut measures = Measures::none();
        let (sum_c, readings) = std::mem::take(&mut self.temperature);
        measures.temperature_c = sum_c / readings as f64;
        measures.samples = std::mem::take(&mut self.count);
        let n = self.norm.len() as f64;
        let channels = self.accel.iter().chain([&self.norm]);
        for ((channel, mean), sd) in channels.zip(&mut measures.mean_g).zip(&mut measures.sd_g) {
            // 0/0 without samples, and of one sample for its deviation: not known.
            *mean = channel.iter().sum::<f64>() / n;
            let squares: f64 = channel.iter().map(|v| (v - *mean).powi(2)).sum();
            *sd = (squares / (n - 1.0)).sqrt();
        }
        let norm_mean = measures.mean_g[3];
        measures.enmo_g = self.norm.iter().map(|a| (a - 1.0).max(0.0)).sum::<f64>() / n;
        measures.mad_g = self.norm.iter().map(|a| (a - norm_mean).abs()).sum::<f64>() / n;
        let [x, y, z] = self
            .accel
            .each_mut()
            .map(|channel| median(channel).unwrap_or(f64::NAN));
        measures.angle_z_deg = z.atan2(x.hypot(y)).to_degrees();
        self.accel.iter_mut().for_each(Vec::clear);
        self.norm.clear();
        measures
    }
}

impl Measures {
    /// Those of an epoch without samples.
    pub fn none() -> Self {
        Measures {
            mean_g: [f64::NAN; 4],
            sd_g: [f64::NAN; 4],
            enmo_g: f64::NAN,
            mad_g: f64::NAN,
            angle_z_deg: f64::NAN,
            temperature_c: f64::NAN,
            samples: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(samples: &[[f64; 3]]) -> Measures {
        let mut epoch = EpochSamples::default();
        samples.iter().for_each(|a| epoch.push(*a));
        epoch.take()
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-12, "{a} is not {b}");
    }

    #[test]
    fn three_samples_by_hand() {
        // ‖a‖ = 5, 13, 1: its mean is 19/3, ENMO (4 + 12 + 0)/3, MAD (4/3 + 20/3 + 16/3)/3.
        let m = of(&[[3.0, 0.0, 4.0], [5.0, 12.0, 0.0], [0.0, 0.0, 1.0]]);
        close(m.mean_g[3], 19.0 / 3.0);
        close(m.enmo_g, 16.0 / 3.0);
        close(m.mad_g, 40.0 / 9.0);
        close(m.mean_g[0], 8.0 / 3.0);
        // Of 3, 5, 0 about 8/3: (1 + 49 + 64)/9 over 2.
        close(m.sd_g[0], (114.0_f64 / 18.0).sqrt());
        // Medians 3, 0, 1.
        close(m.angle_z_deg, (1.0_f64 / 3.0).atan().to_degrees());
        assert_eq!(m.samples, 3);
    }

    #[test]
    fn the_angle_follows_a_rotation_about_y() {
        for tilt in [-90.0_f64, -60.0, -30.0, 0.0, 10.0, 45.0, 90.0] {
            let (s, c) = tilt.to_radians().sin_cos();
            close(of(&[[c, 0.0, s]; 7]).angle_z_deg, tilt);
            // The sense of the horizontal part does not matter.
            close(of(&[[0.0, -c, s]; 4]).angle_z_deg, tilt);
        }
    }

    #[test]
    fn a_constant_has_its_mean_and_no_spread_and_nothing_is_carried_over() {
        let mut epoch = EpochSamples::default();
        (0..50).for_each(|_| epoch.push([0.6, 0.0, 0.8]));
        (0..2).for_each(|i| epoch.push_temperature(20.0 + f64::from(i)));
        epoch.push_temperature(f64::NAN);
        let m = epoch.take();
        for (mean, expected) in m.mean_g.into_iter().zip([0.6, 0.0, 0.8, 1.0]) {
            close(mean, expected);
        }
        assert!(m.sd_g.iter().all(|sd| *sd < 1e-12) && m.enmo_g < 1e-12 && m.mad_g < 1e-12);
        close(m.temperature_c, 20.5);
        let none = epoch.take();
        assert_eq!(none.samples, 0);
        assert!(none.enmo_g.is_nan() && none.mean_g[0].is_nan() && none.temperature_c.is_nan());
        assert!(none.angle_z_deg.is_nan());
    }
}
