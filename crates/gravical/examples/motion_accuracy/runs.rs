//! Lines moved by a virtual sensor, and what motion makes of them.

use gravical::calibrate::Method;
use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::{CalibrationFile, Covariance, GyroMethod, GyroscopeSection};
use gravical::motion::{Calibrated, MotionOptions, motion};
use gravical::recording::{GyroUnit, ReadOptions, read, read_bytes};
use gravical::simulate::{LineOptions, Scenario, SimulateOptions, Simulation, simulate, write};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

type AnyError = Box<dyn std::error::Error>;

/// What is known of the gyroscope.
#[derive(Clone, Copy, PartialEq)]
pub enum Gyro {
    /// Its matrix, exactly.
    Exact,
    /// Its matrix with the covariance of [`GYRO_SD`].
    Calibrated,
    /// Nothing; scale errors uniform within ±3 %.
    Uniform,
    /// Nothing; errors as the data sheet's deviations, normal.
    DataSheet,
}

/// One line of a table.
#[derive(Clone)]
pub struct Cell {
    pub name: &'static str,
    pub move_s: f64,
    pub tilt_change_deg: f64,
    /// The accelerometer's parameters are exactly the calibration's; else they are
    /// off by draws from its covariance.
    pub exact: bool,
    pub gyro: Gyro,
    pub dropped: f64,
    pub jitter_ms: f64,
    pub options: MotionOptions,
    /// Read the position at the end of the move instead of the recording.
    pub at_end_of_move: bool,
}

/// Standard deviations of the calibration: bias m/s², scale, cross-axis.
pub const ACCEL_SD: [f64; 3] = [0.01, 0.002, 0.01];
/// Of the gyroscope: scale, cross-axis.
pub const GYRO_SD: [f64; 2] = [0.003, 0.005];
/// What is assumed of a gyroscope that is not calibrated.
const SHEET_SD: [f64; 2] = [0.03, 0.02];

/// What came of many seeds.
#[derive(Default, Clone)]
pub struct Outcome {
    pub runs: u32,
    /// Runs with exactly one move.
    pub found: u32,
    /// Errors of the end position, m: along the track, across, up.
    pub errors: Vec<[f64; 3]>,
    /// … and their predicted standard deviations.
    pub sigmas: Vec<[f64; 3]>,
}

impl Outcome {
    /// Root mean square of one component, mm.
    pub fn rms_mm(&self, axis: usize) -> f64 {
        let n = self.errors.len() as f64;
        1e3 * (self.errors.iter().map(|e| e[axis] * e[axis]).sum::<f64>() / n).sqrt()
    }

    /// Share of all components within `k` standard deviations.
    pub fn covered(&self, k: f64, axes: std::ops::Range<usize>) -> f64 {
        let all = self.errors.iter().zip(&self.sigmas);
        let within: usize = all
            .map(|(e, s)| axes.clone().filter(|i| e[*i].abs() <= k * s[*i]).count())
            .sum();
        within as f64 / (self.errors.len() * axes.len()) as f64
    }
}

/// 0.7 m in 2 s with 5 s of rest before and after, everything else exact.
pub fn line() -> Cell {
    Cell {
        name: "0.7 m in 2 s",
        move_s: 2.0,
        tilt_change_deg: 0.0,
        exact: true,
        gyro: Gyro::Exact,
        dropped: 0.0,
        jitter_ms: 0.0,
        options: MotionOptions::default(),
        at_end_of_move: false,
    }
}

/// Simulates `seeds` and computes motion.
pub fn run(cell: &Cell, seeds: std::ops::Range<u64>) -> Result<Outcome, AnyError> {
    let folder = tempfile::tempdir()?;
    let mut out = Outcome::default();
    for seed in seeds {
        let (simulation, file) = simulated(cell, seed)?;
        write(&simulation, folder.path(), true)?;
        let recording = read(&folder.path().join("line.csv"), &ReadOptions::default())?;
        let calibrated = Calibrated {
            file: &file,
            name: "truth",
        };
        let options = MotionOptions {
            clock_error: 0.0,
            ..cell.options.clone()
        };
        let moved = motion(&recording, Some(calibrated), &options)?;
        out.runs += 1;
        out.found += u32::from(moved.result.moves.len() == 1);
        let mut p = moved.result.r#final.position_m;
        if cell.at_end_of_move {
            let end_s = 5.0 + cell.move_s;
            let at = moved.track.t_s.partition_point(|t| *t < end_s);
            p = moved.track.position_m.get(at).copied();
        }
        let (Some(p), Some(sigma)) = (p, moved.result.r#final.sigma_m) else {
            continue;
        };
        // From the frame of the result into that of the truth: a yaw.
        let report = moved.result.frame.contains("own");
        let yaw = if report { 0.0 } else { yaw(&simulation) };
        let (sine, cosine) = yaw.sin_cos();
        let there = [
            cosine * p[0] - sine * p[1],
            sine * p[0] + cosine * p[1],
            p[2],
        ];
        let truth = simulation.truth.files[0].moves[0].displacement_m;
        // x is across the track, y along it, near enough.
        let e = [
            there[1] - truth[1],
            there[0] - truth[0],
            there[2] - truth[2],
        ];
        out.errors.push(e);
        out.sigmas.push([sigma[1], sigma[0], sigma[2]]);
    }
    Ok(out)
}

/// Angle of the sensor's x, made horizontal, in the frame of the truth.
fn yaw(simulation: &Simulation) -> f64 {
    let [w, x, y, z] = simulation.files[0].path.state_at(0.0).attitude;
    (2.0 * (x * y + w * z)).atan2(1.0 - 2.0 * (y * y + z * z))
}

/// A sensor whose parameters are off the calibration's by draws from its
/// covariance.
fn simulated(cell: &Cell, seed: u64) -> Result<(Simulation, CalibrationFile), AnyError> {
    let mut options = SimulateOptions::new(Scenario::Line(LineOptions {
        tilt_change_deg: cell.tilt_change_deg,
        move_time_s: cell.move_s,
        ..LineOptions::default()
    }));
    options.seed = seed;
    options.dropped_fraction = cell.dropped;
    options.stamp_jitter_ms = cell.jitter_ms;
    options.file.decimals = 6;
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed_0000);
    let mut normal = || rng.sample::<f64, _>(StandardNormal);
    let mut matrix = |scale: f64, cross: f64| -> [[f64; 3]; 3] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                if i == j {
                    1.0 + scale * normal()
                } else {
                    cross * normal()
                }
            })
        })
    };
    let accel_sd = if cell.exact { [0.0; 3] } else { ACCEL_SD };
    options.sensor.accel_matrix = Some(matrix(accel_sd[1], accel_sd[2]));
    match cell.gyro {
        Gyro::Exact => options.sensor.gyro_matrix = Some(matrix(0.0, 0.0)),
        Gyro::Calibrated => options.sensor.gyro_matrix = Some(matrix(GYRO_SD[0], GYRO_SD[1])),
        Gyro::DataSheet => options.sensor.gyro_matrix = Some(matrix(SHEET_SD[0], SHEET_SD[1])),
        Gyro::Uniform => {}
    }
    options.sensor.accel_bias_mps2 = Some([0.0; 3].map(|_: f64| accel_sd[0] * normal()));
    let gyro_sd = match cell.gyro {
        Gyro::Exact => Some([1e-6; 2]),
        Gyro::Calibrated => Some(GYRO_SD),
        Gyro::DataSheet | Gyro::Uniform => None,
    };
    let accel_sd = if cell.exact { [1e-6; 3] } else { ACCEL_SD };
    Ok((simulate(&options)?, calibration(accel_sd, gyro_sd)?))
}

/// The identity, with its covariance.
pub fn calibration(
    accel_sd: [f64; 3],
    gyro_sd: Option<[f64; 2]>,
) -> Result<CalibrationFile, AnyError> {
    let csv = "label,ax,ay,az\n-x,-9.80665,0,0\n+x,9.80665,0,0\n-y,0,-9.80665,0\n\
               +y,0,9.80665,0\n-z,0,0,-9.80665\n+z,0,0,9.80665\n";
    let session = [read_bytes(
        csv.as_bytes(),
        "means.csv",
        &ReadOptions::default(),
    )?];
    let mut options = CalibrateOptions::default();
    options.estimate.method = Method::Ferraris;
    let mut file = calibrate(&session, &options)?.file;
    let diagonal = |variances: &[f64]| {
        let n = variances.len();
        (0..n)
            .map(|i| {
                (0..n)
                    .map(|j| if i == j { variances[i] } else { 0.0 })
                    .collect()
            })
            .collect::<Vec<Vec<f64>>>()
    };
    let elements = |scale: f64, cross: f64| {
        (0..9).map(move |k| {
            if k % 4 == 0 {
                scale * scale
            } else {
                cross * cross
            }
        })
    };
    let mut accel: Vec<f64> = elements(accel_sd[1], accel_sd[2]).collect();
    accel.extend([accel_sd[0] * accel_sd[0]; 3]);
    file.accelerometer.covariance = Some(Covariance {
        parameters: Covariance::parameter_names(),
        values: diagonal(&accel),
    });
    if let Some([scale, cross]) = gyro_sd {
        let mut gyro: Vec<f64> = elements(scale, cross).collect();
        gyro.extend([1e-6; 3]);
        file.gyroscope = Some(GyroscopeSection {
            method: GyroMethod::Motion,
            input_unit: GyroUnit::RadianPerSecond,
            covariance: Some(Covariance {
                parameters: Covariance::parameter_names(),
                values: diagonal(&gyro),
            }),
            ..GyroscopeSection::default()
        });
    }
    Ok(file)
}
