//! Where the sensor rested, found from the recording's own noise, to the sample.

use std::ops::Range;

use super::samples::Samples;

/// Noise of the samples at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation of a sample, each axis: m/s² or rad/s.
    pub sigma: [f64; 3],
    /// Variance inflation factor: Var(mean of n) = σ²·VIF/n.
    pub vif: f64,
}

/// Rests of a recording and the noise they were found with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rests {
    /// Samples of each rest, in order; none spans a break.
    pub spans: Vec<Range<usize>>,
    /// Noise of the accelerometer, m/s²; none without any rest.
    pub accel: Option<Noise>,
    /// Noise of the gyroscope, rad/s.
    pub gyro: Option<Noise>,
}

/// How rests are found.
#[derive(Debug, Clone, Default)]
pub struct RestOptions {
    /// Rests given by hand, s; then nothing is searched. Default none.
    pub given_s: Option<Vec<(f64, f64)>>,
}

/// Finds the rests.
#[must_use]
pub fn find_rests(samples: &Samples, options: &RestOptions) -> Rests {
    let spans: Vec<Range<usize>> = options
        .given_s
        .iter()
        .flatten()
        .map(|(from, to)| {
            samples.t_s.partition_point(|t| t < from)..samples.t_s.partition_point(|t| t <= to)
        })
        .collect();
    let noise = |channels: &[Vec<f64>; 3]| {
        let holds: Vec<[&[f64]; 3]> = spans
            .iter()
            .map(|r| std::array::from_fn(|i| &channels[i][r.clone()]))
            .collect();
        let pooled = crate::segment::hold::pooled_noise(&holds);
        Noise {
            sigma: pooled.sigma,
            vif: pooled.vif,
        }
    };
    let found = !spans.is_empty();
    Rests {
        accel: found.then(|| noise(&samples.force_mps2)),
        gyro: samples.rate_rad_s.as_ref().filter(|_| found).map(noise),
        spans,
    }
}
