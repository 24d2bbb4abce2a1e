//! Straight moves of several shapes, as a sensor of known truth reads them.

use gravical::recording::{ReadOptions, Recording, SampleColumns};
use gravical::simulate::{Scenario, SimulateOptions, StaticOptions, simulate};

type AnyError = Box<dyn std::error::Error>;

/// How a move speeds up and brakes.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Profile {
    /// The smoothest path from rest to rest (Flash and Hogan 1985).
    MinimumJerk,
    /// A third of the time each: constant acceleration, constant speed, constant braking.
    Trapezoid,
    /// One period of a sine of acceleration.
    Sine,
    /// Constant acceleration for nine tenths of the time, then stopped in the last one.
    Knock,
}

impl Profile {
    pub const ALL: [Profile; 4] = [
        Profile::MinimumJerk,
        Profile::Trapezoid,
        Profile::Sine,
        Profile::Knock,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Profile::MinimumJerk => "minimum jerk",
            Profile::Trapezoid => "trapezoid",
            Profile::Sine => "sine",
            Profile::Knock => "ramp and knock",
        }
    }

    /// Velocity at `s` of 0 to 1 for a way of 1 in unit time.
    fn velocity(self, s: f64) -> f64 {
        let s = s.clamp(0.0, 1.0);
        match self {
            Profile::MinimumJerk => 30.0 * (s * (1.0 - s)).powi(2),
            Profile::Trapezoid => (4.5 * s).min(4.5 * (1.0 - s)).min(1.5),
            Profile::Sine => 1.0 - (std::f64::consts::TAU * s).cos(),
            Profile::Knock => (2.0 / 0.9 * s).min(20.0 * (1.0 - s)),
        }
    }

    /// Mean acceleration from `from` to `to`: what a sensor with a low-pass reads.
    fn acceleration(self, from: f64, to: f64) -> f64 {
        (self.velocity(to) - self.velocity(from)) / (to - from)
    }

    /// The largest acceleration.
    fn greatest(self) -> f64 {
        match self {
            Profile::MinimumJerk => 5.8,
            Profile::Trapezoid => 4.5,
            Profile::Sine => std::f64::consts::TAU,
            Profile::Knock => 20.0,
        }
    }
}

/// One cell of the map.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Cell {
    pub way_m: f64,
    pub move_s: f64,
    pub rest_s: f64,
    pub profile: Profile,
    pub gyro: bool,
}

/// Allan N of the simulated accelerometer, m/s/√s.
pub const ACCEL_NOISE: f64 = 3.3e-3;
const RATE_HZ: f64 = 100.0;

impl Cell {
    /// How far the whole of the acceleration stands out from the noise, in standard
    /// deviations, where the bias is known: √(∫a² dt)/N.
    pub fn sigmas(&self) -> f64 {
        let steps = 1000;
        let at = |k: i32| f64::from(k) / f64::from(steps);
        let mean: f64 = (0..steps)
            .map(|k| self.profile.acceleration(at(k), at(k + 1)).powi(2) / f64::from(steps))
            .sum();
        self.way_m * (mean / self.move_s.powi(3)).sqrt() / ACCEL_NOISE
    }

    /// Whether a sensor of ±2 g can follow it.
    pub fn is_in_range(&self) -> bool {
        self.way_m / self.move_s.powi(2) * self.profile.greatest() < 19.0
    }

    /// Rest, the move along y, rest.
    pub fn recording(&self, seed: u64) -> Result<Recording, AnyError> {
        let (t, accel, gyro) = self.columns(seed)?;
        let columns = SampleColumns {
            time: Some(&t),
            accel: accel.each_ref().map(|c| &c[..]),
            gyro: self.gyro.then(|| gyro.each_ref().map(|c| &c[..])),
            ..SampleColumns::default()
        };
        let options = ReadOptions {
            accel_unit: Some(gravical::recording::AccelUnit::MetrePerSecondSquared),
            gyro_unit: self
                .gyro
                .then_some(gravical::recording::GyroUnit::RadianPerSecond),
            time_unit: Some(gravical::recording::TimeUnit::Second),
            ..ReadOptions::default()
        };
        Ok(Recording::from_samples("simulated", &columns, &options)?)
    }

    /// The same as text.
    pub fn text(&self, seed: u64) -> Result<Vec<u8>, AnyError> {
        use std::io::Write;
        let (t, accel, gyro) = self.columns(seed)?;
        let mut out = Vec::new();
        let names = if self.gyro {
            ",gx_rad_s,gy_rad_s,gz_rad_s"
        } else {
            ""
        };
        writeln!(out, "t_s,ax_mps2,ay_mps2,az_mps2{names}")?;
        for i in 0..t.len() {
            write!(out, "{:.3}", t[i])?;
            for channel in accel.iter().chain(gyro.iter().filter(|_| self.gyro)) {
                write!(out, ",{:.6}", channel[i])?;
            }
            writeln!(out)?;
        }
        Ok(out)
    }

    #[allow(clippy::type_complexity)]
    fn columns(&self, seed: u64) -> Result<(Vec<f64>, [Vec<f64>; 3], [Vec<f64>; 3]), AnyError> {
        let mut options = SimulateOptions::new(Scenario::Static(StaticOptions {
            duration_s: 2.0 * self.rest_s + self.move_s,
            ..StaticOptions::default()
        }));
        let unit = Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        options.seed = seed;
        options.rate_hz = RATE_HZ;
        options.tilt_sd_deg = 0.0;
        options.sensor.accel_matrix = unit;
        options.sensor.gyro_matrix = unit;
        options.sensor.accel_bias_mps2 = Some([0.0; 3]);
        options.sensor.accel_noise_mps_rts = ACCEL_NOISE;
        options.sensor.temperature_rise_c = 0.0;
        options.sensor.g_sensitivity_sd_deg_s_per_g = 0.0;
        let mut file = simulate(&options)?.files.swap_remove(0);
        let size = self.way_m / (self.move_s * self.move_s);
        for (a, t) in file.accel_mps2[1].iter_mut().zip(&file.t_s) {
            let at = |t: f64| (t - self.rest_s) / self.move_s;
            let half = 0.5 / RATE_HZ;
            *a += size * self.profile.acceleration(at(t - half), at(t + half));
        }
        Ok((file.t_s, file.accel_mps2, file.gyro_rad_s))
    }
}
