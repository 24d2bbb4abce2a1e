use rand::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};

use super::*;
use crate::recording::read_bytes;

/// Rows of a sensor at rest with white noise of 0.03 m/s² and 0.002 rad/s, of which `change` makes
/// others.
fn csv(rows: usize, mut change: impl FnMut(usize, &mut Vec<f64>) -> bool) -> String {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(11);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut text = "t_ms,ax,ay,az,gx (rad/s),gy (rad/s),gz (rad/s)\n".to_owned();
    for k in 0..rows {
        let mut row = vec![10.0 * k as f64];
        row.extend([0.1, -0.2, 9.8].map(|g| g + 0.03 * normal()));
        row.extend([0.01, 0.0, -0.01].map(|g| g + 0.002 * normal()));
        if change(k, &mut row) {
            let cells: Vec<String> = row.iter().map(|v| format!("{v:.6}")).collect();
            text += &(cells.join(",") + "\n");
        }
    }
    text
}

fn of(text: &str) -> NoiseResult {
    let recording = read_bytes(text.as_bytes(), "desk.csv", &ReadOptions::default()).unwrap();
    noise_of(recording).unwrap()
}

fn kinds(result: &NoiseResult) -> Vec<&str> {
    result.findings.iter().map(|f| &*f.kind).collect()
}

#[test]
fn lost_rows_and_gaps_leave_the_noise_as_it_is() {
    let whole = of(&csv(30_000, |_, _| true));
    // 2 % lost, one or three at a time, and a pause of 4 s.
    let is_lost =
        |k: usize| k % 97 == 5 || (7..10).contains(&(k % 301)) || (9000..9400).contains(&k);
    let lossy = of(&csv(30_000, |k, _| !is_lost(k)));
    assert_eq!(lossy.segments, 2);
    assert!((lossy.rate_hz / 100.0 - 1.0).abs() < 1e-6);
    for (a, b) in whole.channels.iter().zip(&lossy.channels) {
        let ratio = b.n.unwrap().value / a.n.unwrap().value;
        assert!((ratio - 1.0).abs() < 0.01, "{} {ratio}", a.channel);
    }
}

#[test]
fn only_rest_is_analysed() {
    let turning = |k: usize, row: &mut Vec<f64>| {
        if k < 6000 {
            let angle = (k as f64 / 150.0).sin();
            row[1] += 9.8 * angle.sin();
            row[3] = 9.8 * angle.cos();
            row[4] += 0.6 * (k as f64 / 150.0).cos();
        }
        true
    };
    let result = of(&csv(20_000, turning));
    assert!(kinds(&result).contains(&"noise-from-rests"));
    assert!((result.used_s - 140.0).abs() < 2.0, "{}", result.used_s);
    assert!((result.channels[0].n.unwrap().value / 0.003 - 1.0).abs() < 0.02);
}

#[test]
fn noise_below_the_resolution_has_only_a_limit() {
    let result = of(&csv(20_000, |_, row| {
        // Two decimals of a gyroscope with a noise of 0.002 rad/s.
        let rates = row[4..7].iter_mut();
        rates.for_each(|v| *v = (*v * 100.0).round() / 100.0);
        true
    }));
    assert!(kinds(&result).contains(&"noise-below-resolution"));
    for channel in result.channels.iter().filter(|c| c.is_gyroscope()) {
        let most = channel.missing(Term::N).unwrap().limit.at_most.unwrap();
        assert!(channel.n.is_none() && (0.0002..0.001).contains(&most));
    }
    assert!(result.channels[0].n.is_some());
}

/// White noise of 0.003 m/s²/√Hz behind a low-pass of one pole, and a random walk beside it, at 100 Hz.
fn behind_a_low_pass(count: usize, cutoff_hz: f64, walk_sd: f64) -> ChannelNoise {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let (mut state, mut walk) = (0.0, 0.0);
    let passed = 1.0 - (-2.0 * PI * cutoff_hz * 0.01).exp();
    let sample = |_| {
        state += passed * (0.03 * normal() - state);
        walk += walk_sd * normal();
        state + walk
    };
    let samples: Vec<f64> = (0..count).map(sample).collect();
    noise_of_samples("ax", &samples, 0.01, 0.0)
}

#[test]
fn noise_behind_a_low_pass_is_that_of_long_averaging_times() {
    let channel = behind_a_low_pass(400_000, 2.0, 0.0);
    let n = channel.n.unwrap();
    assert!((n.value / 0.003 - 1.0).abs() < 0.05, "{n:?}");
    let fit = channel.fit.unwrap();
    let low_pass_hz = fit.low_pass_hz.unwrap();
    assert!(
        fit.from_s > 0.1 && (low_pass_hz / 2.0 - 1.0).abs() < 0.2,
        "{fit:?}"
    );
}

/// Behind a low-pass at 0.1 Hz the wander of the bias hides N.
#[test]
fn noise_behind_a_narrow_low_pass_is_not_visible() {
    let channel = behind_a_low_pass(60_000, 0.1, 2e-4);
    let missing = channel.missing(Term::N).unwrap();
    assert!(missing.reason.contains("wider low-pass"), "{missing:?}");
    assert!(missing.limit.record_s.is_none() && channel.n.is_none());
}

#[test]
fn a_channel_without_values_is_left_out() {
    let text = csv(3000, |_, row| {
        row[4] = f64::NAN;
        true
    });
    let result = of(&text.replace("NaN", ""));
    assert!(kinds(&result).contains(&"empty-cells"));
    assert_eq!(result.channels.len(), 5);
    let nothing = noise_of_samples("ax", &[], 0.01, 0.0);
    assert!(nothing.adev.is_empty() && nothing.n.is_none());
    // A channel that never changes is not empty.
    let constant = noise_of_samples("ax", &[9.8; 100], 0.01, 0.0);
    assert!(!constant.adev.is_empty() && constant.not_observable.len() == 3);
}

/// A line or an exponential through the bias looks like a random walk at long averaging times.
#[test]
fn a_drift_is_told_from_a_random_walk() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let (mut along_a_line, mut warming, mut wandering, mut walk) = (vec![], vec![], vec![], 0.0);
    for k in 0..400_000 {
        let t_s = 0.01 * f64::from(k);
        along_a_line.push(0.03 * normal() + 1e-5 * t_s);
        warming.push(0.03 * normal() - 0.05 * (-t_s / 600.0).exp());
        walk += 1e-4 * 0.1 * normal();
        wandering.push(0.03 * normal() + walk);
    }
    let of = |samples: &[f64]| noise_of_samples("ax", samples, 0.01, 0.0);
    let drift = |channel: &ChannelNoise| channel.fit.unwrap().drift;
    let (along_a_line, warming, wandering) = (of(&along_a_line), of(&warming), of(&wandering));
    let line = drift(&along_a_line).unwrap();
    assert!((line.change / 0.04 - 1.0).abs() < 0.05, "{line:?}");
    assert!(line.time_constant_s.is_none() && along_a_line.k.is_none());
    let exponential = drift(&warming).unwrap();
    assert!(
        (exponential.change / 0.05 - 1.0).abs() < 0.1,
        "{exponential:?}"
    );
    let constant_s = exponential.time_constant_s.unwrap();
    assert!((400.0..900.0).contains(&constant_s) && warming.k.is_none());
    assert!(
        drift(&wandering).is_none(),
        "{:?} {:?}",
        drift(&wandering),
        wandering.k
    );
    let k = wandering.k.unwrap();
    assert!(k.low < 1e-4 && 1e-4 < k.high, "{k:?}");
}

#[test]
fn noise_of_rounding_is_no_noise_of_the_sensor() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    for (step, off) in [(0.015, 0.005), (0.048, 0.005), (0.066, 0.1)] {
        let mut rounded = |_| {
            let white: f64 = StandardNormal.sample(&mut rng);
            ((0.01 + 0.03 * white) / step).round() * step
        };
        let samples: Vec<f64> = (0..400_000).map(&mut rounded).collect();
        let n = noise_of_samples("ax", &samples, 0.01, step).n.unwrap();
        assert!((n.value / 0.003 - 1.0).abs() < off, "{step} {n:?}");
        assert!(n.low < 0.003 && 0.003 < n.high, "{step} {n:?}");
    }
}
