//! Allan deviations beside those of allantools (`tests/reference/allantools`).

use gravical::noise::{Allan, AllanSums, NoiseOptions, Spacing, Term, noise_of_samples};
use gravical::simulate::{Scenario, SimulateOptions, StaticOptions, simulate};
use serde_json::Value;

const REFERENCE: &str = include_str!("../../../../tests/reference/allantools/oadev.json");

/// The series of `make.py`.
fn series(count: usize) -> Vec<f64> {
    let mut state = 1_u64;
    let mut uniform = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut walk = 0.0;
    let value = |_| {
        walk += 0.002 * uniform();
        9.8 + walk + uniform()
    };
    (0..count).map(value).collect()
}

fn sums(values: &[f64], full: bool) -> Vec<AllanSums> {
    let mut allan = Allan::new(Spacing::Octave, full);
    allan.push(values);
    allan.finish().0
}

#[test]
fn allan_deviations_are_those_of_allantools() {
    let reference: Value = serde_json::from_str(REFERENCE).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let values = series(number(&reference["count"]) as usize);
    assert_eq!(values[0], number(&reference["first"][0]));
    assert_eq!(values[values.len() - 1], number(&reference["last"]));
    for (part, full) in [("full", true), ("decimated", false)] {
        let own = sums(&values, full);
        let theirs = reference[part].as_array().unwrap();
        assert_eq!(own.len(), theirs.len());
        for (own, theirs) in own.iter().zip(theirs) {
            assert_eq!(own.m as f64, number(&theirs["m"]));
            assert_eq!(own.terms as f64, number(&theirs["terms"]), "{part} {own:?}");
            let deviation = number(&theirs["deviation"]);
            let off = own.variance().sqrt() / deviation - 1.0;
            assert!(off.abs() < 1e-10, "{part} {own:?}: {off:e}");
        }
    }
}

#[test]
fn a_stride_costs_less_than_a_fortieth_of_the_standard_deviation() {
    // 0.8 % where the standard deviation is 35 %.
    let values = series(200_000);
    for (full, strided) in sums(&values, true).iter().zip(sums(&values, false)) {
        let off = (strided.variance() / full.variance()).sqrt() - 1.0;
        let deviation = (full.m as f64 / values.len() as f64).sqrt();
        assert!(
            off.abs() < 0.025 * deviation,
            "{}: {off} {deviation}",
            full.m
        );
    }
}

/// N, B and K that a simulated sensor is given are found within their intervals.
#[test]
#[ignore = "slow: twenty million samples"]
fn what_is_simulated_is_found() {
    let mut options = SimulateOptions::new(Scenario::Static(StaticOptions {
        duration_s: 20_000.0,
        ..StaticOptions::default()
    }));
    options.rate_hz = 10.0;
    options.sensor.quantise = false;
    // Nothing is aliased: the sensor itself has 1 kHz.
    options.sensor.low_pass_hz = Some(2.0);
    options.sensor.bias_drift_mg_per_c = 0.0;
    options.sensor.temperature_rise_c = 0.0;
    // Without scale errors, so that a reading is in true units.
    options.sensor.accel_matrix = Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    options.sensor.accel_noise_mps_rts = 2e-3;
    options.sensor.accel_bias_instability_mps2 = 1e-3;
    options.sensor.accel_random_walk_mps2_rts = 1e-4;
    let simulated = simulate(&options).unwrap();
    let mut inside = [0; 3];
    for samples in &simulated.files[0].accel_mps2 {
        let channel = noise_of_samples("ax", samples, 0.1, &NoiseOptions::default());
        for (i, (term, truth)) in [(Term::N, 2e-3), (Term::B, 1e-3), (Term::K, 1e-4)]
            .into_iter()
            .enumerate()
        {
            if let Some(e) = channel.estimate(term) {
                inside[i] += usize::from(e.low < truth && truth < e.high);
            }
        }
    }
    // Of three axes each; one interval of twenty misses the truth.
    assert!(inside.iter().all(|n| *n >= 2), "{inside:?}");
}
