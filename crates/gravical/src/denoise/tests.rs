//! Filters compared with scipy, and general properties.

mod recordings;
mod scipy;

use super::*;
use proptest::prelude::*;
use serde_json::Value;
use std::f64::consts::PI;

/// The largest difference, relative to the largest value.
fn off(got: &[f64], want: &[f64]) -> f64 {
    assert_eq!(got.len(), want.len());
    let largest = want.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let worst = got
        .iter()
        .zip(want)
        .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    // NaN counts as an infinite difference.
    if worst.is_nan() || got.iter().any(|v| v.is_nan()) {
        return f64::INFINITY;
    }
    worst / largest
}

fn designed(spec: &str, rate_hz: f64) -> Filter {
    Filter::design(&spec.parse().unwrap(), Some(rate_hz)).unwrap()
}

fn filtered(spec: &str, rate_hz: f64, x: &[f64]) -> Vec<f64> {
    let mut y = x.to_vec();
    designed(spec, rate_hz).apply(&mut y);
    y
}

#[test]
fn poles_that_nearly_reach_the_unit_circle_are_refused() {
    for text in [
        "butter:4,0.0001Hz",
        "butter:1,49.99999999Hz",
        "highpass:4,49.99999999Hz",
    ] {
        let error = Filter::design(&text.parse().unwrap(), Some(100.0)).err();
        assert_eq!(error.unwrap().code(), "filter-range", "{text}");
    }
}

/// Every kind of linear filter.
const LINEAR: [&str; 7] = [
    "savgol:5,2",
    "savgol:21,4",
    "butter:4,5Hz",
    "butter1:3,5Hz",
    "highpass:4,0.5Hz",
    "highpass1:2,12Hz",
    "mean:7",
];

fn noise(count: usize, seed: u64) -> Vec<f64> {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    (0..count)
        .map(|_| StandardNormal.sample(&mut random))
        .collect()
}

fn deviation(x: &[f64]) -> f64 {
    (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt()
}

#[test]
fn gain_equals_that_measured_on_noise() {
    let white = noise(400_000, 3);
    for spec in LINEAR.iter().chain(&["butter:8,1Hz"]) {
        let y = filtered(spec, 100.0, &white);
        let gain = designed(spec, 100.0).noise_gain().unwrap();
        let seen = deviation(&y) / deviation(&white);
        // The output of a narrow filter has few independent values.
        assert!((seen / gain - 1.0).abs() < 0.03, "{spec}: {seen} {gain}");
    }
}

/// Amplitude of a sine of amplitude 1 after the filter, in the middle.
fn passed(spec: &str, share: f64) -> f64 {
    let n = 8000;
    let part = |phase: f64| {
        let x: Vec<f64> = (0..n)
            .map(|i| (2.0 * PI * share * f64::from(i) + phase).sin())
            .collect();
        filtered(spec, 100.0, &x)
    };
    let (sine, cosine) = (part(0.0), part(PI / 2.0));
    f64::hypot(sine[n as usize / 2], cosine[n as usize / 2])
}

#[test]
fn gain_is_minus_3_db_at_the_cutoff() {
    for (spec, share) in [
        ("butter:4,5Hz", 0.05),
        ("butter1:3,5Hz", 0.05),
        ("highpass:4,0.5Hz", 0.005),
        ("highpass1:2,12Hz", 0.12),
    ] {
        let got = passed(spec, share);
        assert!((got - 0.5_f64.sqrt()).abs() < 1e-6, "{spec}: {got}");
    }
}

#[test]
fn streaming_filter_gives_identical_results() {
    use gravical_core::filter::biquad::{Biquad, settle, update};
    let x: Vec<f64> = noise(500, 8).iter().map(|v| 9.81 + v).collect();
    let batch = filtered("butter1:4,5Hz", 100.0, &x);
    let mut stream = [Biquad::default(); 2];
    gravical_core::filter::butterworth::low_pass(4, 5.0, 100.0, &mut stream).unwrap();
    settle(&mut stream, x[0]);
    for (x, want) in x.iter().zip(&batch) {
        assert_eq!(update(&mut stream, *x).to_bits(), want.to_bits());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn constants_are_kept_or_removed(value in -20.0..20.0, which in 0..LINEAR.len(), n in 1_usize..200) {
        let spec = LINEAR[which];
        let filter = designed(spec, 100.0);
        let mut y = vec![value; n];
        filter.apply(&mut y);
        let want = if n < filter.shortest() || filter.spec.keeps_constants() { value } else { 0.0 };
        for y in y {
            prop_assert!((y - want).abs() < 2e-10, "{} {}: {} {}", spec, n, y, want);
        }
    }
}
