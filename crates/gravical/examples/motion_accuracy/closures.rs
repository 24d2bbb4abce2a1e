//! Moves that something disturbs of which the model does not know.

use gravical::motion::{Calibrated, MotionOptions, motion};
use gravical::recording::Recording;
use gravical::simulate::{Scenario, SimulateOptions, StaticOptions, simulate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::recording::recording;
use super::runs::calibration;

type AnyError = Box<dyn std::error::Error>;

const RATE_HZ: f64 = 100.0;
const REST_S: f64 = 5.0;
const WAY_M: f64 = 0.7;
const GRAVITY_MPS2: f64 = 9.80665;

/// What is wrong.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Disturbance {
    None,
    /// The bias goes up by 0.05 m/s² in the course of the move.
    Drift,
    /// 0.25 m/s² at 6 Hz that decay over 4 s after the move: a hand.
    Tremor,
    /// ±25° about the direction of the move, and a gyroscope that ends at 60 °/s.
    Clipped,
    /// 4 s at constant speed in the middle of the move.
    Cruise,
    /// No calibration: scale off by 2 %, bias by 0.3 m/s² (1σ), and lying 5° askew.
    Uncalibrated,
}

impl Disturbance {
    const ALL: [(Disturbance, &'static str); 6] = [
        (Disturbance::None, "nothing wrong"),
        (
            Disturbance::Drift,
            "the bias drifts by 0.05 m/s² in the move",
        ),
        (
            Disturbance::Tremor,
            "tremor of 0.25 m/s² that decays over 4 s after it",
        ),
        (
            Disturbance::Clipped,
            "swing of ±25°, the gyroscope clipped at 60 °/s",
        ),
        (Disturbance::Cruise, "4 s at constant speed in it"),
        (Disturbance::Uncalibrated, "uncalibrated, tilted by 5°"),
    ];

    fn move_s(self) -> f64 {
        if self == Disturbance::Cruise {
            6.0
        } else {
            2.0
        }
    }

    /// Acceleration along the way.
    fn acceleration(self, s: f64) -> f64 {
        match self {
            // A second to speed up, four at WAY/5 per second, one to brake.
            Disturbance::Cruise if (0.0..1.0).contains(&s) => WAY_M / 5.0,
            Disturbance::Cruise if (5.0..6.0).contains(&s) => -WAY_M / 5.0,
            Disturbance::Cruise => 0.0,
            _ if (0.0..2.0).contains(&s) => {
                let u = s / 2.0;
                WAY_M / 4.0 * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)
            }
            _ => 0.0,
        }
    }

    /// What the accelerometer reads of it beside that, along the way.
    fn added(self, s: f64) -> f64 {
        match self {
            Disturbance::Drift => 0.05 * (s / self.move_s()).clamp(0.0, 1.0),
            Disturbance::Tremor if (2.0..6.0).contains(&s) => {
                0.25 * (1.0 - (s - 2.0) / 4.0) * (std::f64::consts::TAU * 6.0 * (s - 2.0)).sin()
            }
            _ => 0.0,
        }
    }

    /// Angle about the way, rad, and its rate.
    fn swing(self, s: f64) -> (f64, f64) {
        let w = std::f64::consts::TAU / 2.0;
        if self == Disturbance::Clipped && (0.0..2.0).contains(&s) {
            let most = 25.0_f64.to_radians();
            (most * (w * s).sin(), most * w * (w * s).cos())
        } else {
            (0.0, 0.0)
        }
    }

    fn recording(self, seed: u64) -> Result<Recording, AnyError> {
        let unit = Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let mut options = SimulateOptions::new(Scenario::Static(StaticOptions {
            duration_s: 2.0 * REST_S + self.move_s(),
            ..StaticOptions::default()
        }));
        options.seed = seed;
        options.rate_hz = RATE_HZ;
        options.tilt_sd_deg = 0.0;
        options.sensor.accel_matrix = unit;
        options.sensor.gyro_matrix = unit;
        options.sensor.accel_bias_mps2 = Some([0.0; 3]);
        options.sensor.temperature_rise_c = 0.0;
        options.sensor.g_sensitivity_sd_deg_s_per_g = 0.0;
        let mut file = simulate(&options)?.files.swap_remove(0);
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xc105_u64);
        let mut normal = || rng.sample::<f64, _>(StandardNormal);
        let off: [(f64, f64); 3] = std::array::from_fn(|_| match self {
            Disturbance::Uncalibrated => (1.0 + 0.02 * normal(), 0.3 * normal()),
            _ => (1.0, 0.0),
        });
        let tilt = match self {
            Disturbance::Uncalibrated => 5.0_f64.to_radians(),
            _ => 0.0,
        };
        for (i, t) in file.t_s.iter().enumerate() {
            let s = t - REST_S;
            let (angle, rate) = self.swing(s);
            let (sine, cosine) = (angle + tilt).sin_cos();
            // Along y; turned about y, x and z read the gravity of it.
            let force = [
                -GRAVITY_MPS2 * sine,
                self.acceleration(s) + self.added(s),
                GRAVITY_MPS2 * (cosine - 1.0),
            ];
            for c in 0..3 {
                let noisy = file.accel_mps2[c][i] + force[c];
                file.accel_mps2[c][i] = off[c].0 * noisy + off[c].1;
            }
            if self == Disturbance::Clipped {
                let most = 60.0_f64.to_radians();
                let gyro = &mut file.gyro_rad_s[1][i];
                *gyro = (*gyro + rate).clamp(-most, most);
            }
        }
        recording("disturbed", &file.t_s, &file.accel_mps2, &file.gyro_rad_s)
    }
}

/// Prints how often the band of the end holds the truth.
pub fn print(seeds: u64) -> Result<(), AnyError> {
    let file = calibration([1e-6; 3], Some([1e-6; 2]))?;
    println!(
        "| what is wrong | within 1.96σ, % | beyond 4σ, % | not usable, % | median band (1σ), mm | contradicted, % |"
    );
    println!("|---|---|---|---|---|---|");
    for (what, name) in Disturbance::ALL {
        let options = MotionOptions {
            clock_error: 0.0,
            ..MotionOptions::default()
        };
        let known = (what != Disturbance::Uncalibrated).then_some(Calibrated {
            file: &file,
            name: "truth",
        });
        let (mut held, mut wrong, mut all) = (0_u32, 0_u32, 0_u32);
        let (mut unusable, mut contradicted) = (0_u32, 0_u32);
        let mut bands = Vec::new();
        for seed in 1..=seeds {
            let result = motion(&what.recording(seed)?, known, &options)?.result;
            let end = &result.r#final;
            let (Some(p), Some(sigma)) = (end.position_m, end.sigma_m) else {
                unusable += 1;
                continue;
            };
            contradicted += u32::from(
                result
                    .moves
                    .iter()
                    .any(|m| m.closure_sigmas.is_some_and(|s| s > 4.0)),
            );
            for i in 0..3 {
                let off = (p[i] - [0.0, WAY_M, 0.0][i]).abs() / sigma[i];
                held += u32::from(off <= 1.96);
                wrong += u32::from(off > 4.0);
                all += 1;
            }
            bands.push(1e3 * sigma[1]);
        }
        bands.sort_by(f64::total_cmp);
        let share = |n: u32, of: u32| 100.0 * f64::from(n) / f64::from(of.max(1));
        let runs = seeds as u32;
        let Some(median) = bands.get(bands.len() / 2) else {
            println!("| {name} | – | – | {:.1} | – | – |", share(unusable, runs));
            continue;
        };
        println!(
            "| {name} | {:.1} | {:.1} | {:.1} | {median:.1} | {:.0} |",
            share(held, all),
            share(wrong, all),
            share(unusable, runs),
            share(contradicted, runs),
        );
    }
    Ok(())
}
