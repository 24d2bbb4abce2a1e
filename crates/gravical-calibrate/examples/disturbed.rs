//! Verdicts of recordings that are disturbed row by row: `disturbed [SENSORS]`, one line for each kind of session and disturbance.
//!
//! A verdict is wrong if the error of ‖a‖ in the worst direction, against the mean bias of the session, exceeds 20 mg or
//! twice what is claimed.

use gravical_calibrate::Error;
use gravical_calibrate::calibrate::{CalibrateOptions, calibrate};
use gravical_calibrate::calibration_file::{Calibration, GravitySource};
use gravical_calibrate::gravity::Gravity;
use gravical_calibrate::recording::{ReadOptions, read_bytes};
use gravical_core::matrix3::{mul_vec, norm};
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_fit::Grade;
use gravical_fit::model::sphere;
use gravical_sim::{PoseKind, PosesOptions, Scenario, SimulateOptions, Simulation, simulate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const MG: f64 = 1e-3 * STANDARD_GRAVITY_MPS2;
/// A tremor has this time constant, s.
const TREMOR_S: f64 = 0.03;

#[derive(Debug, Clone, Copy)]
enum Disturbance {
    Nothing,
    /// Share of rows of which one axis is off by 2 to 10 m/s².
    Spikes(f64),
    /// mg that the bias moves by in five minutes, with a thermometer or without.
    Warming {
        mg: f64,
        thermometer: bool,
    },
    /// Free poses held by a hand that trembles by this on each axis, mg.
    Tremor(f64),
}
use Disturbance::*;

const DISTURBANCES: [Disturbance; 10] = [
    Nothing,
    Spikes(0.001),
    Spikes(0.01),
    Spikes(0.05),
    Warming {
        mg: 10.0,
        thermometer: true,
    },
    Warming {
        mg: 10.0,
        thermometer: false,
    },
    Warming {
        mg: 20.0,
        thermometer: true,
    },
    Warming {
        mg: 20.0,
        thermometer: false,
    },
    Tremor(10.0),
    Tremor(20.0),
];

/// Six faces and `free` poses at 100 Hz, as text, and the truth.
fn session(seed: u64, free: u32, disturbance: Disturbance) -> Result<(String, Simulation), Error> {
    let mut options = SimulateOptions::new(Scenario::Poses(PosesOptions { free, hold_s: 4.0 }));
    options.seed = seed;
    let mut thermometer = true;
    if let Warming {
        mg,
        thermometer: is_there,
    } = disturbance
    {
        options.sensor.temperature_rise_c = 10.0;
        options.sensor.temperature_time_s = 300.0 / 3.0;
        options.sensor.bias_drift_mg_per_c = mg / 10.0;
        thermometer = is_there;
    }
    let simulation = simulate(&options)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed + 1_000_000);
    let poses = &simulation.truth.files[0].poses;
    let mut text = String::from("t (ms),ax (m/s^2),ay (m/s^2),az (m/s^2),temp (C)\n");
    let (kept, mut tremor) = ((-0.01 / TREMOR_S).exp(), [0.0; 3]);
    for (i, row) in simulation.files[0].rows.iter().enumerate() {
        let mut a = row.reading.accel_mps2;
        let t_s = i as f64 / options.rate_hz;
        match disturbance {
            Spikes(share) if rng.random_range(0.0..1.0) < share => {
                let size = rng.random_range(2.0..10.0);
                a[rng.random_range(0..3)] += if rng.random_bool(0.5) { size } else { -size };
            }
            Tremor(mg) => {
                let now = poses.iter().find(|p| t_s >= p.start_s && t_s <= p.end_s);
                for (a, x) in a.iter_mut().zip(&mut tremor) {
                    let normal: f64 = rng.sample(rand_distr::StandardNormal);
                    *x = kept * *x + (1.0 - kept * kept).sqrt() * mg * MG * normal;
                    *a += if now.is_some_and(|p| p.kind == PoseKind::Free) {
                        *x
                    } else {
                        0.0
                    };
                }
            }
            _ => (),
        }
        let t_c = if thermometer {
            format!("{:.2}", row.reading.temperature_c)
        } else {
            String::new()
        };
        text += &format!(
            "{},{:.5},{:.5},{:.5},{t_c}\n",
            row.stamp_ms, a[0], a[1], a[2]
        );
    }
    if !thermometer {
        text = text
            .lines()
            .map(|l| l.rsplit_once(',').map_or("", |l| l.0))
            .collect::<Vec<_>>()
            .join("\n");
    }
    Ok((text, simulation))
}

/// The largest error of ‖a‖, against the bias in the middle of its drift over the poses, m/s².
fn worst(found: &Calibration, simulation: &Simulation) -> f64 {
    let (truth, options) = (
        &simulation.truth.accelerometer,
        &simulation.truth.options.sensor,
    );
    let poses = &simulation.truth.files[0].poses;
    let warm =
        |t_s: f64| options.temperature_rise_c * (1.0 - (-t_s / options.temperature_time_s).exp());
    let warm_c = poses
        .iter()
        .map(|p| warm(0.5 * (p.start_s + p.end_s)))
        .sum::<f64>()
        / poses.len() as f64;
    let bias: [f64; 3] =
        std::array::from_fn(|i| truth.bias_mps2[i] + warm_c * truth.bias_drift_mps2_per_c[i]);
    let apply = found.accelerometer_calibration();
    let off = |n: nalgebra::Vector3<f64>| {
        let force = mul_vec(&truth.matrix, &(n * simulation.truth.gravity_mps2).into());
        let a = apply.apply(std::array::from_fn(|i| force[i] + bias[i]));
        (norm(&a) - simulation.truth.gravity_mps2).abs()
    };
    sphere(500).map(off).fold(0.0, f64::max)
}

fn main() -> Result<(), Error> {
    let count = std::env::args()
        .nth(1)
        .and_then(|a| a.parse().ok())
        .unwrap_or(100_u64);
    println!(
        "| session | disturbed by | good | fair | not verifiable | poor | refused | wrong good | wrong fair | error, mg | claimed, mg | poses | findings |"
    );
    println!("|{}", " --- |".repeat(13));
    let options = CalibrateOptions {
        gravity: Gravity {
            value_mps2: STANDARD_GRAVITY_MPS2,
            source: GravitySource::Given,
        },
        ..CalibrateOptions::default()
    };
    for free in [6, 12] {
        for disturbance in DISTURBANCES {
            let (mut grades, mut wrong, mut refused) = ([0; 4], [0; 2], 0);
            let (mut errors, mut claims, mut poses) = (vec![], vec![], 0);
            let mut findings = std::collections::BTreeMap::<String, u32>::new();
            for seed in 0..count {
                let (text, simulation) = session(10_000 + seed, free, disturbance)?;
                let found = read_bytes(text.as_bytes(), "session.csv", &ReadOptions::default())
                    .and_then(|recording| calibrate(&[recording], &options));
                let Ok(found) = found.map(|c| c.calibration) else {
                    refused += 1;
                    continue;
                };
                let (grade, worst) = (found.grade(), worst(&found, &simulation));
                let at = [Grade::Good, Grade::Fair, Grade::NotVerifiable, Grade::Poor];
                let column = at.iter().position(|g| *g == grade).unwrap_or(3);
                let claim = found
                    .reliability
                    .worst_direction
                    .map_or(f64::INFINITY, |w| w.error_mps2);
                grades[column] += 1;
                if column < 2 && worst > (20.0 * MG).min(2.0 * claim) {
                    wrong[column] += 1;
                }
                found
                    .findings
                    .iter()
                    .for_each(|f| *findings.entry(f.kind.clone()).or_default() += 1);
                poses += found.poses.iter().filter(|p| p.fitted).count();
                errors.push(worst / MG);
                claims.push(claim / MG);
            }
            let median = |values: &mut Vec<f64>| {
                values.sort_by(f64::total_cmp);
                values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
            };
            let [good, fair, open, poor] = grades;
            let done = (count - refused) as f64;
            println!(
                "| 6 faces + {free} | {disturbance:?} | {good} | {fair} | {open} | {poor} | {refused} | {} | {} | {:.2} | {:.2} | {:.1} | {findings:?} |",
                wrong[0],
                wrong[1],
                median(&mut errors),
                median(&mut claims),
                poses as f64 / done,
            );
        }
    }
    Ok(())
}
