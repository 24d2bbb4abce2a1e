//! N, B and K of a simulated sensor.

use gravical::noise::{NoiseOptions, Term, noise_of_samples};
use gravical::simulate::{Scenario, SimulateOptions, StaticOptions, simulate};

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
