//! 0.7 m in 2 to 16 s between rests of 5 s, at 100 Hz.

// One rest is a range in a list.
#![allow(clippy::single_range_in_vec_init)]

use super::*;
use crate::simulate::StaticOptions;

/// End of the move along its track less the truth, m: trapezoid, gravity by the
/// rest before, velocity zero at both edges.
fn end_error(simulation: &Simulation, samples: &Samples, before: usize, after: usize) -> f64 {
    let truth = simulation.truth.files[0].moves[0].displacement_sensor_m;
    let mean = view::mean_of(samples, 0..before + 1);
    let t = &samples.t_s;
    let whole = t[after] - t[before];
    let mut end = [0.0; 3];
    for c in 0..3 {
        let (mut v, mut p) = (0.0, 0.0);
        for i in before + 1..=after {
            let h = t[i] - t[i - 1];
            let force = &samples.force_mps2[c];
            let next = v + 0.5 * h * (force[i] + force[i - 1] - 2.0 * mean[c]);
            p += 0.5 * h * (v + next);
            v = next;
        }
        end[c] = p - 0.5 * whole * v;
    }
    let length = truth.iter().map(|d| d * d).sum::<f64>().sqrt();
    (0..3)
        .map(|c| (end[c] - truth[c]) * truth[c] / length)
        .sum()
}

#[derive(Debug)]
struct Outcome {
    /// Of all runs: those with a move; those with one and only one.
    found: usize,
    once: usize,
    /// RMS of the end between the found edges and between the true ones, mm.
    rms_mm: f64,
    floor_mm: f64,
    /// Mean and standard deviation of found less true, ms.
    onset_ms: (f64, f64),
    end_ms: (f64, f64),
}

fn run(seeds: u64, move_time_s: f64, change: impl Fn(&mut SimulateOptions)) -> Outcome {
    let (mut any, mut once) = (0, 0);
    let (mut errors, mut floor) = (Vec::new(), Vec::new());
    let (mut onsets, mut ends) = (Vec::new(), Vec::new());
    for seed in 0..seeds {
        let simulation = line(seed, move_time_s, &change);
        let samples = samples_of(&simulation);
        let rests = found(&samples);
        once += usize::from(rests.len() == 2);
        let at = |t: f64| samples.t_s.partition_point(|v| *v < t - 1e-9);
        let (from, to) = (at(5.0), at(5.0 + move_time_s));
        floor.push(1e3 * end_error(&simulation, &samples, from, to));
        if rests.len() >= 2 {
            any += 1;
            let (before, after) = (rests[0].end - 1, rests[rests.len() - 1].start);
            errors.push(1e3 * end_error(&simulation, &samples, before, after));
            onsets.push(1e3 * (samples.t_s[before] - 5.0));
            ends.push(1e3 * (samples.t_s[after] - 5.0 - move_time_s));
        }
    }
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let rms = |v: &[f64]| (v.iter().map(|e| e * e).sum::<f64>() / v.len() as f64).sqrt();
    let both = |v: &[f64]| (mean(v), crate::stats::standard_deviation(v));
    let outcome = Outcome {
        found: any,
        once,
        rms_mm: rms(&errors),
        floor_mm: rms(&floor),
        onset_ms: both(&onsets),
        end_ms: both(&ends),
    };
    println!("{move_time_s} s, {seeds} seeds: {outcome:.2?}");
    outcome
}

#[test]
fn a_move_of_two_seconds() {
    let plain = run(300, 2.0, |_| {});
    assert_eq!((plain.found, plain.once), (300, 300));
    assert!(plain.rms_mm <= 3.3 && plain.floor_mm <= 2.8);
    // Before the onset and after the end, by the margin; the filter's delay of 5 ms
    // is in it.
    assert!((-40.0..-10.0).contains(&plain.onset_ms.0) && plain.onset_ms.1 < 20.0);
    assert!((15.0..50.0).contains(&plain.end_ms.0) && plain.end_ms.1 < 20.0);

    let torn = run(300, 2.0, |o| {
        o.dropped_fraction = 0.02;
        o.stamp_jitter_ms = 1.0;
    });
    assert_eq!((torn.found, torn.once), (300, 300));
    assert!(torn.rms_mm <= 1.1 * plain.rms_mm);
}

#[test]
fn a_move_of_four_seconds() {
    let outcome = run(300, 4.0, |_| {});
    assert_eq!(outcome.found, 300);
    assert!(outcome.once >= 297 && outcome.rms_mm <= 9.0);
}

#[test]
fn moves_of_six_and_eight_seconds() {
    let six = run(100, 6.0, |_| {});
    let eight = run(100, 8.0, |_| {});
    assert_eq!((six.once, eight.once), (100, 100));
    assert!(six.rms_mm <= 1.4 * six.floor_mm && eight.rms_mm <= 1.4 * eight.floor_mm);
}

#[test]
fn very_slow_moves_are_one() {
    let twelve = run(200, 12.0, |_| {});
    let sixteen = run(200, 16.0, |_| {});
    assert!(twelve.once >= 199 && twelve.found == 200);
    assert!(sixteen.once >= 199 && sixteen.found == 200);
    assert!(twelve.rms_mm <= 1.15 * twelve.floor_mm);
    assert!(sixteen.rms_mm <= 1.15 * sixteen.floor_mm);
}

#[test]
fn a_wobbling_move() {
    let outcome = run(100, 2.0, |o| {
        if let Scenario::Line(line) = &mut o.scenario {
            line.tilt_change_deg = 3.0;
        }
    });
    assert_eq!((outcome.found, outcome.once), (100, 100));
}

#[test]
fn other_rates() {
    for rate_hz in [25.0, 50.0, 400.0, 1000.0] {
        let outcome = run(200, 2.0, |o| o.rate_hz = rate_hz);
        assert_eq!(outcome.found, 200, "{rate_hz} Hz");
        assert!(outcome.once >= 196, "{rate_hz} Hz");
        assert!(outcome.rms_mm <= 1.15 * outcome.floor_mm, "{rate_hz} Hz");
    }
}

#[test]
fn without_a_gyroscope() {
    for seed in 0..60 {
        let mut samples = samples_of(&line(seed, 2.0, |_| {}));
        samples.rate_rad_s = None;
        assert_eq!(found(&samples).len(), 2, "seed {seed}");
        let rests = find_rests(&samples, None);
        assert!(rests.gyro.is_none() && rests.accel.is_some());
    }
}

#[test]
fn an_hour_and_more_of_rest_is_one_rest() {
    for (low_pass_hz, vif) in [(44.0, 1.15), (21.0, 2.3), (10.0, 4.7), (5.0, 9.2)] {
        for seed in 0..2 {
            let mut options = SimulateOptions::new(Scenario::Static(StaticOptions {
                duration_s: 600.0,
                soak: None,
            }));
            options.seed = seed;
            options.sensor.low_pass_hz = Some(low_pass_hz);
            let samples = samples_of(&simulate(&options).unwrap());
            let rests = find_rests(&samples, None);
            assert_eq!(rests.spans, [0..samples.len()], "{low_pass_hz} Hz");
            for noise in [rests.accel.unwrap(), rests.gyro.unwrap()] {
                assert!((noise.vif / vif - 1.0).abs() < 0.08, "{noise:?}");
            }
        }
    }
}

#[test]
fn the_noise_is_that_of_the_sensor() {
    let mut ratios = Vec::new();
    for seed in 0..40 {
        let samples = samples_of(&line(seed, 2.0, |_| {}));
        let noise = find_rests(&samples, None).accel.unwrap();
        // Allan N from σ and VIF.
        let mean = noise.sigma.iter().map(|s| s * s).sum::<f64>() / 3.0;
        ratios.push((mean * noise.vif * 0.01).sqrt() / 3.3e-3);
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    println!(
        "N {mean:.3} ± {:.3} of the truth",
        crate::stats::standard_deviation(&ratios)
    );
    // Behind 44 Hz and read at 100 Hz, noise from around 100 Hz folds down: 4 %.
    assert!((mean - 1.05).abs() < 0.04);
}
