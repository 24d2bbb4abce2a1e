//! How many samples a second one core takes through attitude, gravity, the
//! trapezoid and the zero-velocity correction:
//!
//!     cargo run --release -p gravical-core --example strapdown_speed

use std::time::Instant;

use gravical_core::motion::Propagator;

const SAMPLES: usize = 10_000_000;
const H_S: f64 = 0.01;

fn main() {
    // A sensor that sways, so that no step is trivial; a minute's worth repeated.
    let period: Vec<([f64; 3], [f64; 3])> = (0..6000)
        .map(|i| {
            let t = H_S * f64::from(i);
            let rate = [0.3 * (1.1 * t).sin(), 0.2 * (0.7 * t).cos(), 0.1];
            ([0.3 * t.sin(), 0.2 * t.cos(), 9.81], rate)
        })
        .collect();
    let mut velocity = vec![[0.0; 3]; SAMPLES];
    for run in 1..=5 {
        let start = Instant::now();
        let mut forward = Propagator::new([1.0, 0.0, 0.0, 0.0], true, [0.0, 0.0, 9.81]);
        for (chunk, _) in velocity.chunks_mut(period.len()).zip(0..) {
            for (v, (force, rate)) in chunk.iter_mut().zip(&period) {
                forward.update(*force, *rate, H_S);
                *v = forward.velocity();
            }
        }
        // Velocity is zero at the end; position follows.
        let total = H_S * (SAMPLES - 1) as f64;
        let slope = forward.velocity().map(|v| v / total);
        let mut position = [0.0; 3];
        let mut before = [0.0; 3];
        for (k, v) in velocity.iter_mut().enumerate() {
            let tau = H_S * k as f64;
            for i in 0..3 {
                v[i] -= slope[i] * tau;
                position[i] += 0.5 * H_S * (before[i] + v[i]);
            }
            before = *v;
        }
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "run {run}: {:.1} million samples a second (ends at {:.3e} m)",
            1e-6 * SAMPLES as f64 / seconds,
            position[0]
        );
    }
}
