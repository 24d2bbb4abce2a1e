//! White noise of the rests, and what a move has beyond it.

use std::ops::Range;

use gravical_signal::{BLOCK_S, Block, MIN_VARIANCE, block_len, blocks};
use nalgebra::Vector3;

use crate::options::RestNoise;
use crate::rough::Roughness;
use crate::samples::Samples;

/// Samples that a variance takes.
const MIN_BLOCK_LEN: usize = 5;
/// Without a rest of so many, the noise is that of this fraction of the recording, where it is quietest.
const QUIETEST: f64 = 0.1;
/// Steps of the gyroscope's resolution hide a rate for about so long, s: a turn of a hand goes through
/// several steps within it.
const HIDDEN_RATE_S: f64 = 0.2;

/// Power densities of white noise: (m/s²)² s and (rad/s)² s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Density {
    pub force: Vector3<f64>,
    pub rate: Vector3<f64>,
}

impl Density {
    pub const ZERO: Density = Density {
        force: Vector3::new(0.0, 0.0, 0.0),
        rate: Vector3::new(0.0, 0.0, 0.0),
    };
}

/// Noise of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Noise {
    /// In the rests, sensor axes.
    pub rest: Density,
    /// What the filter takes it for: the same unless it is given.
    pub white: Density,
    /// Variance of the mean rate of a rest that no averaging takes away, (rad/s)².
    pub rounding: Vector3<f64>,
    /// Of the moves.
    pub rough: Roughness,
}

impl Noise {
    /// Densities by the blocks of `rests`: the variance within blocks, and where there are enough of them
    /// that between neighbours, which counts noise that is slower than a block. Rests that are all shorter
    /// than a block are blocks themselves.
    pub fn new(samples: &Samples, rests: &[Range<usize>], rough: Roughness) -> Noise {
        let channels = samples.channels();
        let (mut within, mut between, mut range) = ([0.0; 6], [0.0; 6], [0.0; 6]);
        let (mut count, mut pairs) = (0.0, 0.0);
        for blocks in quiet_blocks(samples, rests) {
            for block in &blocks {
                count += 1.0;
                for c in 0..6 {
                    within[c] += block.variance[c];
                    range[c] += block.range[c];
                }
            }
            for pair in blocks.windows(2) {
                pairs += 1.0;
                let size = pair[0].span.len();
                for c in 0..6 {
                    between[c] += (pair[1].mean[c] - pair[0].mean[c]).powi(2) / 2.0 * size as f64;
                }
            }
        }
        let density: [f64; 6] = std::array::from_fn(|c| {
            let (white, slow) = (
                within[c] / f64::max(count, 1.0),
                between[c] / f64::max(pairs, 1.0),
            );
            let variance = if pairs > 3.0 {
                white.max(0.5 * (white + slow))
            } else {
                white
            };
            variance.max(MIN_VARIANCE[c / 3]) * samples.period_s
        });
        let rate = Vector3::from_column_slice(&density[3..]);
        let rest = Density {
            force: Vector3::from_column_slice(&density[..3]),
            rate: if samples.has_gyro() {
                rate
            } else {
                Vector3::zeros()
            },
        };
        Noise {
            rest,
            white: rest,
            rounding: Vector3::from_fn(|c, _| {
                rounding(
                    channels.resolution[3 + c],
                    range[3 + c] / f64::max(count, 1.0),
                )
            }),
            rough,
        }
    }

    /// The same with densities that are given for the filter, at least those that no data sheet undercuts.
    pub fn with_white(mut self, given: Option<&RestNoise>, samples: &Samples) -> Noise {
        let density = |n: [f64; 3], sensor: usize| {
            Vector3::from(n).map(|n| (n * n).max(MIN_VARIANCE[sensor] * samples.period_s))
        };
        if let Some(given) = given {
            self.white.force = density(given.force_mps2_sqrt_s, 0);
            if samples.has_gyro() {
                self.white.rate = density(given.rate_rad_sqrt_s, 1);
            }
        }
        self
    }

    /// As a caller reads it.
    pub fn of_rests(&self) -> RestNoise {
        RestNoise {
            force_mps2_sqrt_s: self.rest.force.map(f64::sqrt).into(),
            rate_rad_sqrt_s: self.rest.rate.map(f64::sqrt).into(),
        }
    }

    /// What a move has beyond the noise of the rests, the same along all axes.
    pub fn excess(&self, from: usize, to: usize) -> Density {
        let level = [self.white.force.mean(), self.white.rate.mean()];
        let [force, rate] = self.rough.excess(from..to, level);
        Density {
            force: Vector3::repeat(force),
            rate: Vector3::repeat(rate) + self.rounding * HIDDEN_RATE_S,
        }
    }
}

/// Blocks of each rest; of the quietest parts of the recording if no rest is long enough for a variance.
fn quiet_blocks(samples: &Samples, rests: &[Range<usize>]) -> Vec<Vec<Block>> {
    let channels = samples.channels();
    let size = block_len(samples.period_s, BLOCK_S);
    let longest = rests.iter().map(Range::len).max().unwrap_or(0);
    if longest >= MIN_BLOCK_LEN {
        let size = size.min(longest);
        return rests.iter().map(|r| blocks(&channels, r, size)).collect();
    }
    let mut all = blocks(&channels, &(0..samples.len()), size);
    all.sort_by(|a, b| a.total_variance(0).total_cmp(&b.total_variance(0)));
    all.truncate((all.len() as f64 * QUIETEST).ceil() as usize);
    all.into_iter().map(|block| vec![block]).collect()
}

/// Variance of a mean that no averaging takes away: noise that stays within a step dithers nothing.
fn rounding(resolution: f64, range: f64) -> f64 {
    if range < 1.5 * resolution {
        resolution.powi(2) / 12.0
    } else {
        0.0
    }
}

/// Density of the force in one rest, the axes together, (m/s²)² s; none where it has too few samples to tell.
pub(crate) fn tremor(samples: &Samples, rest: &Range<usize>) -> Option<f64> {
    if rest.len() < MIN_BLOCK_LEN {
        return None;
    }
    let noise = Noise::new(samples, std::slice::from_ref(rest), Roughness::default());
    Some(noise.rest.force.sum())
}
