use super::*;
use crate::simulate::{LineOptions, Scenario, SimulateOptions, Simulation, simulate};

/// Row by row, with the truth of the calibration taken out.
fn samples_of(simulation: &Simulation) -> Samples {
    let file = &simulation.files[0];
    let m = nalgebra::Matrix3::from(simulation.truth.accelerometer.matrix).transpose();
    let inverse = m.try_inverse().unwrap();
    let bias = nalgebra::Vector3::from(simulation.truth.accelerometer.bias_mps2);
    let mg = nalgebra::Matrix3::from(simulation.truth.gyroscope.matrix).transpose();
    let inverse_g = mg.try_inverse().unwrap();
    let mut out = Samples {
        t_s: file
            .stamp_ms
            .iter()
            .map(|t| (*t - file.stamp_ms[0]) as f64 / 1e3)
            .collect(),
        row: (0..file.t_s.len()).collect(),
        ..Samples::default()
    };
    let mut rate: [Vec<f64>; 3] = Default::default();
    for i in 0..file.t_s.len() {
        let a = nalgebra::Vector3::from(std::array::from_fn(|c| file.accel_mps2[c][i]));
        let w = nalgebra::Vector3::from(std::array::from_fn(|c| file.gyro_rad_s[c][i]));
        let (a, w) = (inverse * (a - bias), inverse_g * w);
        for c in 0..3 {
            out.force_mps2[c].push(a[c]);
            rate[c].push(w[c]);
        }
    }
    out.rate_rad_s = Some(rate);
    out
}

fn line(
    seed: u64,
    move_time_s: f64,
    rest_s: f64,
    change: impl Fn(&mut SimulateOptions),
) -> Simulation {
    let mut options = SimulateOptions::new(Scenario::Line(LineOptions {
        move_time_s,
        rest_s,
        offset_m: 0.0,
        ..LineOptions::default()
    }));
    options.seed = seed;
    change(&mut options);
    simulate(&options).unwrap()
}

/// End position along the sensor's axes by trapezoid and detrend, less the truth.
fn end_error(
    samples: &Samples,
    before: usize,
    after: usize,
    truth: [f64; 3],
    gravity_over: Range<usize>,
) -> f64 {
    let mean = view::mean_of(samples, gravity_over);
    let n = after - before + 1;
    let t = &samples.t_s[before..=after];
    let mut p = [0.0; 3];
    for c in 0..3 {
        let a: Vec<f64> = samples.force_mps2[c][before..=after]
            .iter()
            .map(|v| v - mean[c])
            .collect();
        let mut v = vec![0.0; n];
        for i in 1..n {
            v[i] = v[i - 1] + 0.5 * (t[i] - t[i - 1]) * (a[i] + a[i - 1]);
        }
        let last = v[n - 1];
        for i in 0..n {
            v[i] -= last * (t[i] - t[0]) / (t[n - 1] - t[0]);
        }
        for i in 1..n {
            p[c] += 0.5 * (t[i] - t[i - 1]) * (v[i] + v[i - 1]);
        }
    }
    let length = truth.iter().map(|v| v * v).sum::<f64>().sqrt();
    (0..3).map(|c| (p[c] - truth[c]) * truth[c] / length).sum()
}

#[test]
fn the_move_is_found_and_its_edges_cost_little() {
    let mut squares = Vec::new();
    for seed in 0..100 {
        let simulation = line(seed, 2.0, 5.0, |_| {});
        let samples = samples_of(&simulation);
        let rests = find_rests(&samples, &RestOptions::default()).spans;
        assert_eq!(rests.len(), 2, "seed {seed}");
        let truth = simulation.truth.files[0].moves[0].displacement_sensor_m;
        let (before, after) = (rests[0].end - 1, rests[1].start);
        let error = end_error(&samples, before, after, truth, rests[0].clone());
        squares.push(error * error);
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!(rms < 3.3e-3, "{rms}");
}
