//! The procedure of the student report: the mean of the first rows off, trapezoid.

use gravical_motion::{SampleState, Samples};
use gravical_signal::detect_rests;

/// Rows that the mean is over.
const ROWS: usize = 500;
/// What a rest may miss of them at its end: half a block of the detector, s.
const MISSED_S: f64 = 0.1;

/// The mean that is subtracted, and whether the sensor moves while it is taken.
#[derive(Debug, Clone)]
pub(super) struct ReportProcedure {
    mean_mps2: [f64; 3],
    /// The first time within the averaged rows at which it moves, s.
    pub moves_at_s: Option<f64>,
}

impl ReportProcedure {
    pub fn new(samples: &Samples) -> Self {
        let rows = 0..ROWS.min(samples.len());
        let force = &samples.force_mps2()[rows.clone()];
        let mean = |c: usize| force.iter().map(|f| f[c]).sum::<f64>() / force.len() as f64;
        let rests = detect_rests(&samples.channels());
        let first = rests.first().cloned().unwrap_or(0..0);
        let t = samples.time_s();
        let moved = if first.start > 0 { 0 } else { first.end };
        let averaged_until_s = t[rows.end - 1];
        ReportProcedure {
            mean_mps2: std::array::from_fn(mean),
            moves_at_s: t
                .get(moved)
                .copied()
                .filter(|t| t + MISSED_S < averaged_until_s),
        }
    }

    /// Velocity and position of each sample; without bands, in the axes of the sensor.
    pub fn states<'a>(&'a self, samples: &'a Samples) -> impl Iterator<Item = SampleState> + 'a {
        let (mut velocity, mut position) = ([0.0; 3], [0.0; 3]);
        let mut last: Option<(f64, [f64; 3])> = None;
        let all = samples.time_s().iter().zip(samples.force_mps2());
        all.map(move |(&t, force)| {
            let acceleration: [f64; 3] = std::array::from_fn(|c| force[c] - self.mean_mps2[c]);
            if let Some((before, a)) = last {
                let h = t - before;
                for c in 0..3 {
                    let faster = 0.5 * (a[c] + acceleration[c]) * h;
                    position[c] += (velocity[c] + 0.5 * faster) * h;
                    velocity[c] += faster;
                }
            }
            last = Some((t, acceleration));
            SampleState {
                at_rest: false,
                attitude: [1.0, 0.0, 0.0, 0.0],
                acceleration_mps2: acceleration,
                velocity_mps: velocity,
                velocity_sd_mps: [f64::NAN; 3],
                position_m: position,
                position_sd_m: [f64::NAN; 3],
            }
        })
    }
}
