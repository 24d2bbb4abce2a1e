//! Filters compared with scipy, and general properties.

use super::*;
use serde_json::Value;

/// The largest difference, relative to the largest value.
fn off(got: &[f64], want: &[f64]) -> f64 {
    assert_eq!(got.len(), want.len());
    let largest = want.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let differences = got.iter().zip(want).map(|(a, b)| (a - b).abs());
    // NaN counts as an infinite difference.
    let worst = differences.map(|d| if d.is_nan() { f64::INFINITY } else { d });
    worst.fold(0.0, f64::max) / largest
}

fn designed(spec: &str, rate_hz: f64) -> Filter {
    Filter::design(&spec.parse().unwrap(), Some(rate_hz)).unwrap()
}

fn filtered(spec: &str, rate_hz: f64, x: &[f64]) -> Vec<f64> {
    let mut y = x.to_vec();
    designed(spec, rate_hz).apply(&mut y);
    y
}

/// Cases of a part of the reference, and the samples that they filter.
fn reference(part: &str) -> (Vec<Value>, Vec<f64>) {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/reference/scipy/filters.json"
    );
    let file: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    (file[part].as_array().unwrap().clone(), numbers(&file["x"]))
}

fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().unwrap().iter();
    values.map(|v| v.as_f64().unwrap()).collect()
}

#[test]
fn savitzky_golay_equals_scipy() {
    let (cases, x) = reference("savgol");
    for case in &cases {
        let value = |key: &str| case[key].as_u64().unwrap() as usize;
        let spec = format!("savgol:{},{}", value("window"), value("order"));
        let ours = filtered(&spec, 100.0, &x[..value("n")]);
        let off = off(&ours, &numbers(&case["y"]));
        assert!(off < 1e-12, "{spec}: {off:e}");
    }
}

#[test]
fn butterworth_equals_scipy() {
    let (cases, x) = reference("butter");
    for case in cases {
        let spec = case["spec"].as_str().unwrap();
        let gain = designed(spec, 100.0).noise_gain().unwrap();
        let theirs = case["noise_gain"].as_f64().unwrap();
        let share = gain / theirs - 1.0;
        assert!(share.abs() < 1e-9, "{spec}: {gain} {theirs}");
        if !case["y"].is_null() {
            let off = off(&filtered(spec, 100.0, &x), &numbers(&case["y"]));
            assert!(off < 1e-10, "{spec}: {off:e}");
        }
    }
}

/// The filter that a microcontroller runs, sample by sample.
#[test]
fn streaming_butterworth_equals_scipy() {
    use gravical_core::filter::biquad::{Biquad, settle, update};
    use gravical_core::filter::butterworth::{Pass, design, sections_of};
    let (cases, x) = reference("sosfilt");
    for case in cases {
        let order = case["order"].as_u64().unwrap() as usize;
        let is_high = case["kind"] == "highpass";
        let pass = if is_high { Pass::High } else { Pass::Low };
        let mut stream = vec![Biquad::default(); sections_of(order)];
        let cutoff_hz = case["cutoff_hz"].as_f64().unwrap();
        design(pass, order, cutoff_hz, 100.0, &mut stream).unwrap();
        settle(&mut stream, x[0]);
        let ours: Vec<f64> = x.iter().map(|x| update(&mut stream, *x)).collect();
        let off = off(&ours, &numbers(&case["y"]));
        assert!(off < 1e-10, "{order} {cutoff_hz} Hz: {off:e}");
    }
}
