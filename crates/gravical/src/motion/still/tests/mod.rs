//! Targets on simulated moves, real recordings, faults.

mod faults;
mod lines;
mod recordings;
mod slow;
mod stream;

use nalgebra::{Matrix3, Vector3};

use super::*;
use crate::simulate::{LineOptions, Scenario, SimulateOptions, Simulation, simulate};

/// Row by row, with the true parameters taken out.
fn samples_of(simulation: &Simulation) -> Samples {
    let file = &simulation.files[0];
    let truth = &simulation.truth;
    let inverse = |rows: [[f64; 3]; 3]| Matrix3::from(rows).transpose().try_inverse().unwrap();
    let accel = inverse(truth.accelerometer.matrix);
    let gyro = inverse(truth.gyroscope.matrix);
    let bias = Vector3::from(truth.accelerometer.bias_mps2);
    let first = file.stamp_ms[0];
    let mut out = Samples {
        t_s: file
            .stamp_ms
            .iter()
            .map(|t| (*t - first) as f64 / 1e3)
            .collect(),
        ..Samples::default()
    };
    let mut rate: [Vec<f64>; 3] = Default::default();
    for i in 0..file.t_s.len() {
        let read = |of: &[Vec<f64>; 3]| Vector3::from(std::array::from_fn(|c| of[c][i]));
        let force = accel * (read(&file.accel_mps2) - bias);
        let turn = gyro * read(&file.gyro_rad_s);
        for c in 0..3 {
            out.force_mps2[c].push(force[c]);
            rate[c].push(turn[c]);
        }
    }
    out.rate_rad_s = Some(rate);
    out
}

/// 5 s of rest, a move of 0.7 m, 5 s of rest.
fn line(seed: u64, move_time_s: f64, change: impl Fn(&mut SimulateOptions)) -> Simulation {
    let mut options = SimulateOptions::new(Scenario::Line(LineOptions {
        move_time_s,
        ..LineOptions::default()
    }));
    options.seed = seed;
    change(&mut options);
    simulate(&options).unwrap()
}

fn found(samples: &Samples) -> Vec<Range<usize>> {
    let rests = find_rests(samples, None).spans;
    for pair in rests.windows(2) {
        assert!(pair[0].end <= pair[1].start, "{rests:?}");
    }
    assert!(
        rests
            .iter()
            .all(|r| r.start < r.end && r.end <= samples.len())
    );
    rests
}
